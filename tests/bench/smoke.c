/* smoke: error of shadows of smoke, hair and leaves against bytes and run time, of curves of few nodes and of their rivals, in one
 * process and context.
 *
 *     smoke [--scene columns|hair|leaves] [--side PX] [--capsules N] [--width PX] [--height PX] [--json FILE.json] ...
 *
 * Of a procedural scene (tests/volumes/smoke_scene.h) a map is made by every technique with every setting of its knob, from the
 * same capsules, and queried at random places in the smoke, of which there is one in each pixel. A frame captures segments in
 * lists, makes the map of them, and looks it up; all three are reported. The reference is the product over all capsules in double,
 * four texels' rays weighed as lookups do. Errors are of shadow, which is what the smoke takes: so places that nothing shades do
 * not count as good.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/command/options/options.h"
#include "baker/files/json_value.h"
#include "baker/lab/opengl/gl.h"
#include "baker/vxs_bake.h"
#include "runtime/volumes/smoke/transmittance_map.h"
#include "tests/bench/volumes_bench.h"
#include "tests/volumes/rival_curves.h"
#include "tests/volumes/smoke_view.h"

enum { SEGMENTS_EACH = 512 };

typedef struct smoke {
    smoke_kind   kind;
    uint32_t     side, capsule_count;
    vxs_capsule *capsules;
    smoke_sun    sun;
    GLuint       texture; /* what reaches each place */
} smoke;

/* techniques ---------------------------------------------------------------------------------------------------------------------- */

/* A map, and the curves that a rival makes of its lists. */
typedef struct curves {
    vxs_transmittance_map *map;
    rival_curves          *rival;
} curves;

static vxs_result open_map(bench *b, void **state, vxs_transmittance_desc desc)
{
    curves *c = calloc(1, sizeof *c);
    *state    = c;
    if (!c) return VXS_E_MEMORY;
    desc.constants = &b->smoke->sun.constants;
    desc.side_px   = b->smoke->side;
    desc.capsules  = b->smoke->capsule_count;
    return vxs_transmittance_map_create(&c->map, b->volumes, &desc);
}

static uint32_t room_of(const bench *b)
{
    return SEGMENTS_EACH * b->smoke->capsule_count;
}

static vxs_result open_sorted(bench *b, void **state, uint32_t nodes)
{
    return open_map(b, state, (vxs_transmittance_desc){.nodes = nodes, .segments = room_of(b)});
}

static vxs_result open_unsorted(bench *b, void **state, uint32_t nodes)
{
    return open_map(b, state, (vxs_transmittance_desc){.nodes = nodes, .segments = room_of(b), .unsorted = 1});
}

static vxs_result open_tiles(bench *b, void **state, uint32_t nodes)
{
    return open_map(b, state, (vxs_transmittance_desc){.nodes = nodes});
}

static vxs_result open_rival(bench *b, void **state, rival_curve which, uint32_t knob)
{
    vxs_result r = open_sorted(b, state, 4);
    curves    *c = *state;
    return r == VXS_OK ? rival_curves_create(&c->rival, b->volumes, c->map, which, knob) : r;
}

static vxs_result open_slices(bench *b, void **state, uint32_t slices)
{
    return open_rival(b, state, RIVAL_OPACITY, slices);
}

static vxs_result open_terms(bench *b, void **state, uint32_t terms)
{
    return open_rival(b, state, RIVAL_FOURIER, terms);
}

static vxs_result open_moments(bench *b, void **state, uint32_t moments)
{
    return open_rival(b, state, RIVAL_MOMENTS, moments);
}

/* Lines that leave the curve by so many ten thousandths. */
static vxs_result open_deep(bench *b, void **state, uint32_t tolerance)
{
    return open_rival(b, state, RIVAL_DEEP, tolerance);
}

static vxs_result open_uncompressed(bench *b, void **state, uint32_t knob)
{
    return open_rival(b, state, RIVAL_UNCOMPRESSED, knob);
}

static void close_curves(void *state)
{
    curves *c = state;
    if (!c) return;
    rival_curves_destroy(c->rival);
    vxs_transmittance_map_destroy(c->map);
    free(c);
}

static vxs_capsules capsules_of(const bench *b)
{
    return (vxs_capsules){.list = b->smoke->capsules, .count = b->smoke->capsule_count};
}

static vxs_result capture(bench *b, void *state, uint32_t knob)
{
    const curves      *c        = state;
    const vxs_capsules capsules = capsules_of(b);
    (void)knob;
    rival_curves_capture(c->map, &capsules);
    return VXS_OK;
}

/* Nodes of captured lists. */
static vxs_result build(bench *b, void *state, uint32_t nodes)
{
    const curves *c     = state;
    saved_storage saved = vxs_volumes_save_storage(b->volumes);
    (void)nodes;
    vxs_transmittance_set(c->map, NULL, b->smoke->capsule_count);
    vxs_volumes_use_storage(b->volumes, c->map->buffer, 0);
    vxs_transmittance_run(c->map, vxs_transmittance_builder(c->map), NULL);
    vxs_volumes_restore_storage(b->volumes, &saved);
    return VXS_OK;
}

/* Tiles begin with capsules, and have no lists. */
static vxs_result build_tiles(bench *b, void *state, uint32_t nodes)
{
    const curves      *c        = state;
    const vxs_capsules capsules = capsules_of(b);
    (void)nodes;
    return vxs_transmittance_map_build(c->map, &capsules, NULL);
}

static vxs_result build_rival(bench *b, void *state, uint32_t knob)
{
    const curves *c = state;
    (void)knob;
    rival_curves_build(c->rival, b->smoke->sun.nearest, b->smoke->sun.farthest);
    return VXS_OK;
}

static vxs_result look_up_lines(bench *b, void *state, uint32_t nodes)
{
    const curves *c = state;
    (void)nodes;
    return vxs_volumes_transmittance(b->volumes, c->map, b->smoke->texture, VXS_CURVE_LINES);
}

static vxs_result look_up_exponentials(bench *b, void *state, uint32_t nodes)
{
    const curves *c = state;
    (void)nodes;
    return vxs_volumes_transmittance(b->volumes, c->map, b->smoke->texture, VXS_CURVE_EXPONENTIALS);
}

static vxs_result look_up_rival(bench *b, void *state, uint32_t knob)
{
    const curves *c = state;
    (void)knob;
    rival_curves_look_up(c->rival, b->smoke->texture);
    return VXS_OK;
}

static double bytes_of_nodes(const bench *b, const void *state, uint32_t nodes)
{
    (void)b;
    (void)state;
    return 8.0 * nodes;
}

static double bytes_of_rival(const bench *b, const void *state, uint32_t knob)
{
    const curves *c = state;
    (void)knob;
    return (double)rival_curves_bytes(c->rival) / ((double)b->smoke->side * b->smoke->side);
}

#define SEGMENTS "all segments, exactly"
#define LINES    "all segments, but for lines between nodes"
#define PLACED   "all segments, but for nodes that were set on lines between others"

/* clang-format off */
#define NODES {4, 8, 12, 16}
#define LISTS close_curves, {capture, build}, bytes_of_nodes
#define RIVAL look_up_rival, close_curves, {capture, build_rival}, bytes_of_rival
static const technique techniques[] = {
    {"adaptive", "nodes", LINES, 0, NODES, open_sorted, look_up_lines, LISTS},
    {"adaptive, exponentials", "nodes", PLACED, 0, NODES, open_sorted, look_up_exponentials, LISTS},
    {"adaptive, unsorted", "nodes", LINES, 0, NODES, open_unsorted, look_up_lines, LISTS},
    {"adaptive, tiles", "nodes", LINES, 0, NODES, open_tiles, look_up_lines, close_curves, {NULL, build_tiles}, bytes_of_nodes},
    {"opacity slices", "slices", SEGMENTS, 1, {8, 16, 32, 64}, open_slices, RIVAL},
    {"Fourier", "terms", SEGMENTS, 1, {4, 8, 16, 32}, open_terms, RIVAL},
    {"power moments", "moments", "the middle of the bounds that four moments leave", 1, {4}, open_moments, RIVAL},
    {"deep", "/ 10000 off", LINES, 1, {400, 100, 20, 5}, open_deep, RIVAL},
    {"uncompressed", "-", SEGMENTS, 1, {1}, open_uncompressed, RIVAL},
};
/* clang-format on */

/* the scene ----------------------------------------------------------------------------------------------------------------------- */

/* A triangle in the sun: libvxs_volumes stands on an asset. */
static vxs_result bake(bench *b, run_context *m)
{
    static const float    corners[9] = {-1, 0, 0, 1, 0, 0, 0, 0, 1};
    static const uint32_t indices[3] = {0, 1, 2};
    vxs_bake_mesh         mesh       = {corners, indices, 3, 1, {0, 0, 0}, 0};
    vxs_bake_light        light      = {"sun", VXS_BAKE_DIRECTIONAL, {0, 0, 0}, {0, -1, 0}, 0, 0};
    vxs_bake_arrays       arrays     = {.meshes = &mesh, .mesh_count = 1, .lights = &light, .light_count = 1};
    vxs_bake_options      options    = vxs_bake_defaults();
    vxs_bake_bytes        file;
    options.arrays     = &arrays;
    options.resolution = 8;
    vxs_result r       = vxs_bake(&options, &file);
    if (r == VXS_OK) r = vxs_asset_open(&b->asset, file.data, file.size_bytes, NULL);
    vxs_bake_bytes_free(&file);
    return r == VXS_OK ? r : fail(m, r, "no asset: %s", vxs_result_text(r));
}

static double shadow_of(const float pixel[4], int channel)
{
    (void)channel;
    return 1 - (double)pixel[0];
}

static GLuint new_texture(const bench *b)
{
    GLuint texture;
    b->gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    b->gl->TextureStorage2D(texture, 1, GL_R32F, (GLsizei)b->width, (GLsizei)b->height);
    return texture;
}

/* A place in each pixel, and what is wanted there. */
static vxs_result see(bench *b, run_context *m)
{
    smoke *s       = b->smoke;
    float *depths  = malloc(b->pixels * sizeof *depths);
    double(*at)[3] = malloc(b->pixels * sizeof *at), *left = malloc(b->pixels * sizeof *left);
    b->wanted    = malloc(3 * b->pixels * sizeof *b->wanted);
    int has_room = depths && at && left && b->wanted;
    if (has_room) {
        vxs_volumes_frame frame = smoke_frame(b->width, b->height, depths, at);
        smoke_truth(&s->sun, s->side, s->capsules, s->capsule_count, (const double(*)[3])at, b->pixels, left);
        for (size_t n = 0; n < 3 * b->pixels; n++) b->wanted[n] = 1 - left[n / 3];
        frame.depth_texture = new_texture(b);
        b->gl->TextureSubImage2D(frame.depth_texture, 0, 0, 0, (GLsizei)b->width, (GLsizei)b->height, GL_RED, GL_FLOAT, depths);
        b->frames[0] = frame;
        b->picture = s->texture = new_texture(b);
    }
    free(depths);
    free(at);
    free(left);
    return has_room ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for places");
}

static void describe(const bench *b, json_t **to)
{
    json_set(to, "side_px", json_integer(b->smoke->side));
    json_set(to, "capsules", json_integer(b->smoke->capsule_count));
}

static vxs_result run(void *command, run_context *m)
{
    bench     *b = command;
    smoke     *s = b->smoke;
    vxs_result r = bake(b, m);
    b->pixels    = (size_t)b->width * b->height;
    s->capsules  = malloc(s->capsule_count * sizeof *s->capsules);
    if (r == VXS_OK && !s->capsules) r = fail(m, VXS_E_MEMORY, "out of memory for capsules");
    if (r == VXS_OK) {
        smoke_make(s->kind, s->capsules, s->capsule_count, 1);
        s->sun = smoke_sun_over(s->capsules, s->capsule_count);
        r      = volumes_open_gl(b, m);
    }
    if (r == VXS_OK) r = see(b, m);
    if (r == VXS_OK) r = volumes_measure(b, m);
    volumes_close_gl(b);
    free(s->capsules);
    free(b->wanted);
    return r;
}

int main(int argc, char **argv)
{
    smoke s                = {.side = 256, .capsule_count = 4000};
    bench b                = {BENCH_DEFAULTS,
                              .smoke           = &s,
                              .techniques      = techniques,
                              .technique_count = sizeof techniques / sizeof *techniques,
                              .light_name      = "sun",
                              .reference       = "the product over all capsules",
                              .parts           = {"capture", "build", "look up"},
                              .describe        = describe};
    b.cameras              = 1;
    b.value_of             = shadow_of;
    const option options[] = {
        {"--scene", OPTION_CHOICE, &s.kind, 0, 0, "columns|hair|leaves", NULL, "what casts (default columns)", NULL},
        {"--side", OPTION_U32, &s.side, 8, 1024, NULL, "PX", "texels a side of the map (default 256)", NULL},
        {"--capsules", OPTION_U32, &s.capsule_count, 8, 100000, NULL, "N", "default 4000", NULL},
        BENCH_ROWS(b),
    };
    const command_line line =
        COMMAND_LINE("smoke", "[options]", "Measure error of shadows of smoke against bytes and run time.", options);
    return command_run(&line, argc, argv, run, &b);
}
