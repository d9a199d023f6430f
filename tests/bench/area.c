/* area: error against run time of the airlight of a rectangle that shines, by VPLs on it whose shadow volumes are made together,
 * and by rivals, in one process and context.
 *
 *     area SCENE --corner X,Y,Z --across X,Y,Z --up X,Y,Z --eye X,Y,Z --target X,Y,Z [--picture] [--points N] [--fog PER_METRE]
 *     [--json FILE.json] ...
 *
 * A knob is how many VPLs are set, but of froxels, which have one light and slices. Imperfect shadow maps are made in each frame,
 * as when all moves. Exact ones are shadow depth maps of an asset that is baked here, with a VPL at each of Halton's places and one
 * in the middle. The reference is a mean over places of the rectangle and of the ray, with traced shadows
 * (tests/volumes/area_reference.h). Creation is what a view of one pixel takes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/command/options/options.h"
#include "baker/files/json_value.h"
#include "baker/lab/opengl/gl.h"
#include "baker/vxs_bake.h"
#include "runtime/volumes/vxs_area_light.h"
#include "tests/bench/volumes_bench.h"
#include "tests/volumes/area_reference.h"
#include "tests/volumes/rival_faces.h"
#include "tests/volumes/rival_froxels.h"

enum { VPLS = VXS_VPLS_MAX, LIGHTS = VPLS + 1, WIDE = 16, HIGH = 9, STEPS = 64 };

typedef struct area {
    double                corner_ws[3], across[3], up[3];
    uint32_t              points, side_px, samples, apart;
    int                   has_picture;
    vxs_area_rectangle    screen; /* places count from the eye */
    float                 picture[HIGH][WIDE][3];
    area_source           source;
    vxs_vpl               vpls[VPLS]; /* of the frame */
    vxs_area_light       *all, *one;  /* of all techniques */
    uint32_t              vpls_most;  /* of those that have exact maps; behind them is one in the middle */
    vxs_shadow_depth_map *maps[LIGHTS];
    rival_faces          *faces;
    GLuint                casters;
    double               *off; /* [pixels] of the reference, about, at most */
} area;

/* techniques ------------------------------------------------------------------------------------------------------------------- */

static vxs_result sample(bench *b, vxs_area_places which, uint32_t count)
{
    return vxs_area_sample(&b->area->screen, which, which == VXS_AREA_JITTERED, b->area->vpls, count);
}

static vxs_result halton(bench *b, void *state, uint32_t count)
{
    (void)state;
    return sample(b, VXS_AREA_HALTON, count);
}

static vxs_result importance(bench *b, void *state, uint32_t count)
{
    (void)state;
    return sample(b, VXS_AREA_IMPORTANCE, count);
}

static vxs_result jittered(bench *b, void *state, uint32_t count)
{
    (void)state;
    return sample(b, VXS_AREA_JITTERED, count);
}

/* VPLs of `light`, and what casts shadows of them. */
static vxs_result cast_vpls(vxs_area_light *light, const vxs_vpl *vpls, uint32_t count, GLuint points, uint32_t point_count)
{
    vxs_result r = vxs_area_light_set(light, vpls, count);
    return r == VXS_OK ? vxs_area_light_cast(light, &(vxs_area_casters){points, point_count, 0}) : r;
}

static vxs_result cast(bench *b, void *state, uint32_t count)
{
    (void)state;
    return cast_vpls(b->area->all, b->area->vpls, count, b->area->casters, b->area->points);
}

static vxs_result gather(const bench *b, vxs_area_gather which)
{
    return vxs_volumes_area(b->volumes, b->area->all, &(vxs_area_look){.gather = which});
}

static vxs_result each(bench *b, void *state, uint32_t count)
{
    (void)state;
    (void)count;
    return gather(b, VXS_AREA_EACH);
}

static vxs_result ninths(bench *b, void *state, uint32_t count)
{
    (void)state;
    (void)count;
    return gather(b, VXS_AREA_NINTHS);
}

static vxs_result quarter(bench *b, void *state, uint32_t count)
{
    (void)state;
    (void)count;
    return gather(b, VXS_AREA_QUARTER);
}

static vxs_result exact(bench *b, void *state, uint32_t count)
{
    area      *a = b->area;
    vxs_result r = vxs_area_light_set(a->all, a->vpls, count);
    (void)state;
    return r == VXS_OK
               ? vxs_volumes_area(b->volumes, a->all, &(vxs_area_look){.maps = (const vxs_shadow_depth_map *const *)a->maps})
               : r;
}

/* The same passes of one VPL after the other, with the same points. */
static vxs_result one_by_one(bench *b, void *state, uint32_t count)
{
    const area *a = b->area;
    vxs_result  r = VXS_OK;
    (void)state;
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        r = cast_vpls(a->one, &a->vpls[n], 1, a->casters, a->points);
        if (r == VXS_OK) r = vxs_volumes_area(b->volumes, a->one, &(vxs_area_look){0});
    }
    return r;
}

static vxs_result marches(bench *b, void *state, uint32_t count)
{
    vxs_result r = VXS_OK;
    (void)state;
    for (uint32_t n = 0; n < count && r == VXS_OK; n++)
        r = rival_faces_march(b->area->faces, &b->area->vpls[n], n, b->area->maps[n], STEPS);
    return r;
}

/* Columns of 8 x 8 pixels, and so many slices. */
static vxs_result open_froxels(bench *b, void **state, uint32_t deep)
{
    return rival_froxels_create_rectangle((rival_froxels **)state, b->volumes, (b->width + 7) / 8, (b->height + 7) / 8, deep);
}

static vxs_result froxels(bench *b, void *state, uint32_t deep)
{
    (void)deep;
    return rival_froxels_add_rectangle(state, &b->area->screen, &b->light, b->area->maps[b->area->vpls_most]);
}

static void close_froxels(void *state)
{
    rival_froxels_destroy(state);
}

#define POINTS "the points' shadows"
#define MAPS   "shadow maps of VPLs, and grids of 128"

/* clang-format off */
#define COUNTS {1, 4, 16, 64, VPLS}
#define OF(places, draw) NULL, draw, NULL, {places, cast}, NULL
static const technique techniques[] = {
    {"imperfect", "vpls", POINTS, 0, COUNTS, OF(halton, each)},
    {"imperfect, importance", "vpls", POINTS, 0, COUNTS, OF(importance, each)},
    {"imperfect, jittered", "vpls", POINTS, 0, COUNTS, OF(jittered, each)},
    {"imperfect, ninths", "vpls", POINTS ", a ninth of the VPLs a pixel", 0, COUNTS, OF(halton, ninths)},
    {"imperfect, quarter", "vpls", POINTS ", in a quarter of the pixels", 0, COUNTS, OF(halton, quarter)},
    {"exact maps", "vpls", MAPS, 0, COUNTS, NULL, exact, NULL, {halton}, NULL},
    {"imperfect, one by one", "vpls", POINTS, 1, COUNTS, NULL, one_by_one, NULL, {halton}, NULL},
    {"marches", "vpls", "shadow maps of VPLs, and 64 steps", 1, COUNTS, NULL, marches, NULL, {halton}, NULL},
    {"froxels", "slices", "all light with the shadow of its middle, columns of 8 x 8 pixels", 1, {16, 64, 256}, open_froxels, froxels, close_froxels, {NULL}, NULL},
};
/* clang-format on */

/* the scene -------------------------------------------------------------------------------------------------------------------- */

/* A picture as a television shows: dim, with a bright window and a warm corner. */
static void paint(area *a)
{
    for (uint32_t y = 0; y < HIGH; y++)
        for (uint32_t x = 0; x < WIDE; x++) {
            int    is_window = x >= 10 && x < 13 && y >= 5 && y < 8, is_warm = x < 4 && y < 3;
            float *texel = a->picture[y][x];
            for (int n = 0; n < 3; n++) texel[n] = is_window ? 4 : is_warm ? (n == 0 ? 1.5F : 0.5F) : 0.2F + 0.02F * (float)x;
        }
}

static int is_free(const void *traced, const double from_ws[3], const double to_ws[3])
{
    const light_shape vpl = {.kind = LIGHT_POINT, .position_ws = {from_ws[0], from_ws[1], from_ws[2]}, .range_metres = INFINITY};
    return truth_lit(traced, to_ws, &vpl);
}

static void set_screen(bench *b)
{
    area *a = b->area;
    for (int n = 0; n < 3; n++) {
        a->screen.corner[n]    = (float)(a->corner_ws[n] - b->pose.eye_ws[n]);
        a->screen.across[n]    = (float)a->across[n];
        a->screen.up[n]        = (float)a->up[n];
        a->screen.radiance[n]  = 1;
        a->source.origin_ws[n] = b->pose.eye_ws[n];
    }
    if (a->has_picture) {
        paint(a);
        a->screen.texture = a->picture[0][0];
        a->screen.wide_px = WIDE;
        a->screen.high_px = HIGH;
    }
    a->source.rectangle = &a->screen;
    a->source.is_free   = is_free;
    a->source.user      = b->truth;
}

/* How many VPLs of Halton's places a technique has, as far as knobs go. */
static uint32_t most_vpls(const bench *b)
{
    const uint32_t *counts = techniques[0].values;
    uint32_t        n      = 0;
    while (n + 1 < b->values && counts[n + 1]) n++;
    return counts[n];
}

/* An asset of a VPL at each place, and in the middle. */
static vxs_result bake(bench *b, const float *positions, run_context *m)
{
    area            *a    = b->area;
    vxs_bake_mesh    mesh = {.positions      = positions,
                             .indices        = b->casting.indices,
                             .vertex_count   = (uint32_t)b->casting.vertex_count,
                             .triangle_count = (uint32_t)b->casting.triangle_count};
    vxs_bake_light   lights[LIGHTS];
    char             names[LIGHTS][16];
    vxs_bake_options options = vxs_bake_defaults();
    vxs_bake_arrays  arrays  = {.meshes = &mesh, .mesh_count = 1, .lights = lights, .light_count = a->vpls_most + 1};
    vxs_bake_bytes   file;
    for (uint32_t n = 0; n <= a->vpls_most; n++) {
        snprintf(names[n], sizeof names[n], "lamp %u", n);
        lights[n] = (vxs_bake_light){.name = names[n], .kind = VXS_BAKE_POINT};
        for (int i = 0; i < 3; i++) {
            double middle            = (double)a->screen.corner[i] + 0.5 * (a->across[i] + a->up[i]);
            lights[n].position_ws[i] = b->pose.eye_ws[i] + (n == a->vpls_most ? middle : (double)a->vpls[n].place[i]);
            mesh.origin_ws[i]        = b->pose.eye_ws[i];
        }
    }
    options.arrays     = &arrays;
    options.closed     = VXS_BAKE_CLOSED_OFF;
    options.resolution = a->side_px;
    options.threads    = b->threads;
    vxs_result r       = vxs_bake(&options, &file);
    if (r == VXS_OK) r = vxs_asset_open(&b->asset, file.data, file.size_bytes, NULL);
    vxs_bake_bytes_free(&file);
    return r == VXS_OK ? r : fail(m, r, "no asset of lamps: %s", vxs_result_text(r));
}

static vxs_result upload_points(bench *b, const float *positions, run_context *m)
{
    area           *a      = b->area;
    size_t          bytes  = a->points * sizeof(vxs_area_point);
    vxs_area_point *points = malloc(bytes);
    if (!points) return fail(m, VXS_E_MEMORY, "out of memory for points");
    double area_there = vxs_area_scatter(positions, b->casting.indices, (uint32_t)b->casting.triangle_count, points, a->points);
    b->gl->GenBuffers(1, &a->casters);
    b->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, a->casters);
    b->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, points, GL_STATIC_DRAW);
    free(points);
    return area_there > 0 ? VXS_OK : fail(m, VXS_E_SCENE, "%s: nothing has an area", b->scene_path);
}

static vxs_result open_lights(bench *b, run_context *m)
{
    area               *a   = b->area;
    vxs_area_light_desc all = {.takes_maps = 1}, one = {.vpls = 1};
    vxs_result          r = vxs_area_light_create(&a->all, b->volumes, &all);
    if (r == VXS_OK) r = vxs_area_light_create(&a->one, b->volumes, &one);
    if (r == VXS_OK) r = rival_faces_create(&a->faces, b->volumes);
    for (uint32_t n = 0; n <= a->vpls_most && r == VXS_OK; n++) r = volumes_open_map(b, n, 0, &a->maps[n]);
    b->light = (vxs_volumes_light){.baked_number  = vxs_baked_number(a->vpls_most),
                                   .colour        = {1, 1, 1},
                                   .cos_inner     = 1,
                                   .radius_metres = (float)b->radius_metres};
    return r == VXS_OK ? r : fail(m, r, "no area light: %s", vxs_result_text(r));
}

static void close_lights(area *a)
{
    for (uint32_t n = 0; n < LIGHTS; n++) vxs_shadow_depth_map_destroy(a->maps[n]);
    rival_faces_destroy(a->faces);
    vxs_area_light_destroy(a->one);
    vxs_area_light_destroy(a->all);
}

static void wanted(const bench *b, const double eye_ws[3], const double direction[3], double metres, size_t ray, double to[3])
{
    const area *a = b->area;
    if (ray % b->width % a->apart || ray / b->width % a->apart)
        to[0] = to[1] = to[2] = NAN;
    else
        a->off[ray] = area_reference_add(&a->source, &b->medium, eye_ws, direction, metres, a->samples, ray, to);
}

static void describe(const bench *b, json_t **scene_json)
{
    double off = 0, size = 0;
    for (size_t n = 0; n < 3 * b->pixels; n++) {
        if (isnan(b->wanted[n])) continue;
        off += b->area->off[n / 3] * b->area->off[n / 3];
        size += b->wanted[n] * b->wanted[n];
    }
    volumes_describe_view(b, scene_json);
    json_set(scene_json, "points", json_integer(b->area->points));
    json_set(scene_json, "reference_rms", json_real(rounded(size > 0 ? sqrt(off / size) : 0, 4)));
}

static vxs_result run(void *command, run_context *m)
{
    bench     *b         = command;
    area      *a         = b->area;
    float     *positions = NULL;
    vxs_result r         = volumes_load_scene(b, m);
    free(b->classes); /* there is no pixel that passes the VPL */
    b->classes = NULL;
    if (r == VXS_OK) {
        set_screen(b);
        positions = volumes_casters_from_eye(b);
        a->off    = calloc(b->pixels, sizeof *a->off);
        if (!positions || !a->off) r = fail(m, VXS_E_MEMORY, "out of memory for casters");
    }
    b->has_creation = !b->cell_texts.count;
    a->vpls_most    = most_vpls(b);
    if (r == VXS_OK && (r = sample(b, VXS_AREA_HALTON, a->vpls_most)) != VXS_OK) r = fail(m, r, "the rectangle has no area");
    if (r == VXS_OK) r = bake(b, positions, m);
    if (r == VXS_OK) r = volumes_open_gl(b, m);
    if (r == VXS_OK) r = upload_points(b, positions, m);
    if (r == VXS_OK) r = open_lights(b, m);
    if (r == VXS_OK) r = volumes_see(b, 0, wanted, m);
    if (r == VXS_OK) r = volumes_measure(b, m);
    close_lights(a);
    volumes_close_gl(b);
    volumes_free_scene(b);
    free(positions);
    free(a->off);
    return r;
}

int main(int argc, char **argv)
{
    static area  a         = {.points = 1000000, .side_px = 128, .samples = 32768, .apart = 1};
    bench        b         = {BENCH_DEFAULTS,
                              .area             = &a,
                              .pose.fov_degrees = 60,
                              .fog              = FOG_DEFAULTS,
                              .techniques       = techniques,
                              .technique_count  = sizeof techniques / sizeof *techniques,
                              .light_name       = "area",
                              .reference        = "the whole surface, with traced shadows",
                              .parts            = {"vpls", "maps", "volumes"},
                              .describe         = describe};
    const option options[] = {
        {"SCENE", OPTION_INPUT, &b.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene", NULL},
        {"--corner", OPTION_VECTOR, a.corner_ws, 0, 3, NULL, "X,Y,Z", "of the rectangle that shines, metres", NULL},
        {"--across", OPTION_VECTOR, a.across, 0, 3, NULL, "X,Y,Z", "one of its sides", NULL},
        {"--up", OPTION_VECTOR, a.up, 0, 3, NULL, "X,Y,Z", "the other; it shines to where their cross product points", NULL},
        {"--picture", OPTION_SWITCH, &a.has_picture, 0, 0, NULL, NULL, "a picture is on it", NULL},
        {"--points", OPTION_U32, &a.points, 1, 1 << 24, NULL, "N", "of casters, for imperfect maps (default 1000000)", NULL},
        {"--side", OPTION_U32, &a.side_px, 8, 1024, NULL, "PX", "of exact maps (default 128)", NULL},
        {"--samples", OPTION_U32, &a.samples, 2, 1 << 24, NULL, "N", "of each ray of the reference (default 32768)", NULL},
        {"--apart", OPTION_U32, &a.apart, 1, 64, NULL, "PX", "pixels of the reference, across and down (default 1: all)", NULL},
        {"--eye", OPTION_VECTOR, b.pose.eye_ws, 0, 3, NULL, "X,Y,Z", "where to stand, metres", NULL},
        {"--target", OPTION_VECTOR, b.pose.target_ws, 0, 3, NULL, "X,Y,Z", "where to look", NULL},
        {"--fov", OPTION_F64, &b.pose.fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom (default 60)", NULL},
        FOG_ROWS(b.fog),
        BENCH_ROWS(b),
    };
    const command_line line =
        COMMAND_LINE("area", "SCENE --corner X,Y,Z --across X,Y,Z --up X,Y,Z --eye X,Y,Z --target X,Y,Z [options]",
                     "Measure error against run time of airlight of an area.", options);
    b.fog.per_metre = 0.1;
    b.cameras       = 1;
    return command_run(&line, argc, argv, run, &b);
}
