/* smoke: error of transmittance against bytes and time, of curves of few nodes and of their rivals, in one process and context.
 *
 *     smoke [--side PX] [--capsules N] [--width PX] [--height PX] [--rounds N] [--gl osmesa|egl] [--json FILE.json]
 *
 * Of each procedural scene (tests/volumes/smoke_scene.h) a map is made by every technique with every setting of its knob, from the same capsules, and asked at random
 * places in the smoke. In each round every technique builds and looks up once, one after the other. The reference is the product over all capsules in double,
 * four texels' rays weighed as lookups do. Times are those of the processor with OSMesa, in all threads, which other programs hardly disturb; wall time with EGL.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/opengl/gl.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "baker/base/version.h"
#include "baker/files/json_file.h"
#include "baker/files/json_value.h"
#include "baker/measure/clock.h"
#include "baker/measure/spread.h"
#include "baker/options/options.h"
#include "baker/vxs_bake.h"
#include "runtime/volumes/transmittance_map.h"
#include "runtime/vxs.h"
#include "tests/volumes/rival_curves.h"
#include "tests/volumes/smoke_view.h"

enum { ROUNDS_MAX = 99, CELLS_MAX = 32, SEGMENTS_EACH = 512, DENSE_PERCENT = 99 };

typedef struct bench {
    uint32_t     side, capsule_count, width, height, rounds;
    gl_backend   backend;
    const char  *json_path;
    vxs_asset   *asset;
    gl_context  *gl;
    vxs_gl      *shadows;
    vxs_volumes *volumes;
    GLuint       depths, texture;
    vxs_capsule *capsules;
    float       *read;
    double (*places)[3], *wanted;
    smoke_sun sun;
} bench;

/* techniques ---------------------------------------------------------------------------------------------------------------------- */

typedef enum made_by { BY_LISTS, BY_UNSORTED_LISTS, BY_TILES, BY_RIVAL } made_by;

/* values end with 0 */
typedef struct technique {
    const char      *name, *knob;
    made_by          by;
    rival_curve      which;
    vxs_curve_lookup how;
    uint32_t         values[5];
} technique;

static const technique techniques[] = {
    {"adaptive", "nodes", BY_LISTS, 0, VXS_CURVE_LINES, {4, 8, 12, 16}},
    {"adaptive, exponentials", "nodes", BY_LISTS, 0, VXS_CURVE_EXPONENTIALS, {4, 8, 12, 16}},
    {"adaptive, unsorted", "nodes", BY_UNSORTED_LISTS, 0, VXS_CURVE_LINES, {4, 8, 12, 16}},
    {"adaptive, tiles", "nodes", BY_TILES, 0, VXS_CURVE_LINES, {4, 8, 12, 16}},
    {"opacity slices", "slices", BY_RIVAL, RIVAL_OPACITY, 0, {16, 32}},
    {"Fourier", "terms", BY_RIVAL, RIVAL_FOURIER, 0, {8, 16}},
    {"moments", "moments", BY_RIVAL, RIVAL_MOMENTS, 0, {4}},
    {"deep", "1/10000", BY_RIVAL, RIVAL_DEEP, 0, {20, 100}},
    {"uncompressed", "-", BY_RIVAL, RIVAL_UNCOMPRESSED, 0, {1}},
};
enum { TECHNIQUES = sizeof techniques / sizeof *techniques };

typedef struct cell {
    const technique       *technique;
    uint32_t               value;
    vxs_transmittance_map *map;
    rival_curves          *rival;
    double                 build[ROUNDS_MAX], look_up[ROUNDS_MAX], bytes_per_texel, rms, most, mean;
} cell;

static vxs_result cell_open(const bench *b, cell *c)
{
    vxs_transmittance_desc desc = {.constants = &b->sun.constants,
                                   .side_px   = b->side,
                                   .nodes     = c->technique->by == BY_RIVAL ? 4 : c->value,
                                   .capsules  = b->capsule_count,
                                   .segments  = c->technique->by == BY_TILES ? 0 : SEGMENTS_EACH * b->capsule_count,
                                   .unsorted  = c->technique->by == BY_UNSORTED_LISTS};
    vxs_result             r    = vxs_transmittance_map_create(&c->map, b->volumes, &desc);
    if (r != VXS_OK || c->technique->by != BY_RIVAL) return r;
    return rival_curves_create(&c->rival, b->volumes, c->map, c->technique->which, c->value);
}

static void cell_close(cell *c)
{
    rival_curves_destroy(c->rival);
    vxs_transmittance_map_destroy(c->map);
}

static double now(const bench *b)
{
    struct timespec t;
    b->gl->Finish();
    if (b->backend == GL_BACKEND_EGL) return clock_seconds();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Lists to curves. Tiles begin with capsules, and have no lists. */
static void build(const bench *b, cell *c)
{
    vxs_capsules capsules = {.list = b->capsules, .count = b->capsule_count};
    if (c->rival) {
        rival_curves_build(c->rival, b->sun.nearest, b->sun.farthest);
    } else if (c->technique->by == BY_TILES) {
        vxs_transmittance_map_build(c->map, &capsules, NULL);
    } else {
        storage_kept kept = vxs_volumes_keep_storage(b->volumes);
        vxs_transmittance_set(c->map, NULL, b->capsule_count);
        vxs_volumes_use_storage(b->volumes, c->map->buffer, 0);
        vxs_transmittance_run(c->map, c->map->build, NULL);
        vxs_volumes_put_back_storage(b->volumes, &kept);
    }
}

static void look_up(const bench *b, const cell *c)
{
    if (c->rival)
        rival_curves_look_up(c->rival, b->texture);
    else
        vxs_volumes_transmittance(b->volumes, c->map, b->texture, c->technique->how);
}

/* Returns seconds that capturing took. */
static double measure(const bench *b, cell *c, uint32_t round)
{
    vxs_capsules capsules = {.list = b->capsules, .count = b->capsule_count};
    double       begin    = now(b), captured, built;
    if (c->technique->by != BY_TILES) rival_curves_capture(c->map, &capsules);
    captured = now(b);
    build(b, c);
    built = now(b);
    look_up(b, c);
    c->look_up[round] = now(b) - built;
    c->build[round]   = built - captured;
    return captured - begin;
}

/* Of places in shadow. */
static void judge(const bench *b, cell *c)
{
    size_t count = 0, texels = (size_t)b->side * b->side;
    c->rms = c->mean = c->most = 0;
    look_up(b, c);
    b->gl->GetTextureImage(b->texture, 0, GL_RED, GL_FLOAT, (GLsizei)((size_t)b->width * b->height * sizeof *b->read), b->read);
    for (size_t n = 0; n < (size_t)b->width * b->height; n++) {
        double off = (double)b->read[n] - b->wanted[n];
        if (b->wanted[n] > DENSE_PERCENT / 100.0) continue;
        c->rms += off * off;
        c->mean += off;
        c->most = fmax(c->most, fabs(off));
        count++;
    }
    c->rms             = sqrt(c->rms / (double)(count ? count : 1));
    c->mean            = c->mean / (double)(count ? count : 1);
    c->bytes_per_texel = c->rival ? (double)rival_curves_bytes(c->rival) / (double)texels : 8.0 * c->value;
}

/* reports ------------------------------------------------------------------------------------------------------------------------- */

static json_t *ms_json(spread s)
{
    json_t *o = json_object();
    json_set(&o, "median", json_real(rounded(1000 * s.median, 4)));
    json_set(&o, "least", json_real(rounded(1000 * s.min, 4)));
    json_set(&o, "greatest", json_real(rounded(1000 * s.max, 4)));
    return o;
}

static json_t *cell_json(const bench *b, cell *c)
{
    json_t *o     = json_object();
    spread  built = spread_of(c->build, b->rounds), asked = spread_of(c->look_up, b->rounds);
    json_set(&o, "technique", json_text(c->technique->name));
    json_set(&o, "knob", json_text(c->technique->knob));
    json_set(&o, "value", json_integer(c->value));
    json_set(&o, "bytes_per_texel", json_real(rounded(c->bytes_per_texel, 4)));
    json_set(&o, "rms", json_real(rounded(c->rms, 4)));
    json_set(&o, "most", json_real(rounded(c->most, 4)));
    json_set(&o, "signed_mean", json_real(rounded(c->mean, 4)));
    json_set(&o, "build_ms", ms_json(built));
    json_set(&o, "look_up_ms", ms_json(asked));
    printf("%-24s %5u %-8s %8.1f %9.5f %8.4f %+9.5f %9.3g %9.3g\n", c->technique->name, c->value, c->technique->knob,
           c->bytes_per_texel, c->rms, c->most, c->mean, 1000 * built.median, 1000 * asked.median);
    return o;
}

static json_t *scene_json(const bench *b, smoke_kind kind, cell *cells, size_t count, double *capture)
{
    json_t                  *o = json_object(), *list = json_array();
    vxs_transmittance_counts lists    = vxs_transmittance_map_counts(cells[0].map);
    spread                   captured = spread_of(capture, b->rounds);
    printf("\n%s: %u capsules, %u segments, %u merged, capture %.3g ms\n%-24s %-14s %8s %9s %8s %9s %9s %9s\n", smoke_names[kind],
           b->capsule_count, lists.segments, lists.merged, 1000 * captured.median, "technique", "knob", "bytes", "RMS", "most",
           "mean", "build ms", "lookup ms");
    json_set(&o, "name", json_text(smoke_names[kind]));
    json_set(&o, "segments", json_integer(lists.segments));
    json_set(&o, "merged", json_integer(lists.merged));
    json_set(&o, "capture_ms", ms_json(captured));
    for (size_t n = 0; n < count; n++) json_append(&list, cell_json(b, &cells[n]));
    json_set(&o, "cells", list);
    return o;
}

/* scenes -------------------------------------------------------------------------------------------------------------------------- */

static vxs_result see(bench *b, smoke_kind kind)
{
    size_t count = (size_t)b->width * b->height;
    smoke_make(kind, b->capsules, b->capsule_count, 1);
    b->sun                  = smoke_sun_over(b->capsules, b->capsule_count);
    vxs_volumes_frame frame = smoke_frame(b->width, b->height, b->read, b->places);
    smoke_truth(&b->sun, b->side, b->capsules, b->capsule_count, (const double(*)[3])b->places, count, b->wanted);
    b->gl->TextureSubImage2D(b->depths, 0, 0, 0, (GLsizei)b->width, (GLsizei)b->height, GL_RED, GL_FLOAT, b->read);
    frame.depth_texture = b->depths;
    return vxs_volumes_begin(b->volumes, &frame);
}

/* All that the techniques have, once for all scenes. */
static vxs_result open_cells(const bench *b, cell *cells, size_t *count)
{
    vxs_result r = VXS_OK;
    for (int t = 0; t < TECHNIQUES; t++)
        for (int n = 0; n < 5 && techniques[t].values[n] && r == VXS_OK; n++) {
            cells[*count] = (cell){.technique = &techniques[t], .value = techniques[t].values[n]};
            r             = cell_open(b, &cells[(*count)++]);
        }
    return r;
}

static vxs_result measure_scene(bench *b, smoke_kind kind, cell *cells, size_t count, json_t **scenes)
{
    double     capture[ROUNDS_MAX];
    vxs_result r = see(b, kind);
    if (r != VXS_OK) return r;
    for (size_t n = 0; n < count; n++) measure(b, &cells[n], 0); /* programs are compiled when they first run */
    for (uint32_t round = 0; round < b->rounds; round++)
        for (size_t n = 0; n < count; n++) {
            double seconds = measure(b, &cells[n], round);
            if (n == 0) capture[round] = seconds;
        }
    for (size_t n = 0; n < count; n++) judge(b, &cells[n]);
    json_append(scenes, scene_json(b, kind, cells, count, capture));
    return VXS_OK;
}

static vxs_result measure_all(bench *b, json_t **scenes, message *m)
{
    cell       cells[CELLS_MAX];
    size_t     count = 0;
    vxs_result r;
    b->sun = smoke_sun_over(NULL, 0);
    r      = open_cells(b, cells, &count);
    for (int kind = 0; kind < SMOKE_KINDS && r == VXS_OK; kind++) r = measure_scene(b, (smoke_kind)kind, cells, count, scenes);
    if (r != VXS_OK) r = fail(m, r, "a map cannot be made: %s", vxs_result_text(r));
    for (size_t n = 0; n < count; n++) cell_close(&cells[n]);
    return r;
}

/* ---------------------------------------------------------------------------------------------------------------------------------- */

static vxs_gl_function lookup(const char *name, void *user)
{
    return (vxs_gl_function)((const gl_context *)user)->lookup(name);
}

static void say(const char *text, void *user)
{
    (void)user;
    fprintf(stderr, "%s\n", text);
}

/* A triangle in the sun: libvxs_volumes stands on an asset. */
static vxs_result bake(bench *b)
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
    vxs_result r       = vxs_bake(&options, &file, NULL);
    if (r != VXS_OK) return r;
    r = vxs_asset_open(&b->asset, file.data, file.size_bytes, NULL);
    vxs_bake_bytes_free(&file);
    return r;
}

static vxs_result open_gl(bench *b, message *m)
{
    vxs_result r = gl_context_create(&b->gl, b->backend, 1, m);
    if (r != VXS_OK) return r;
    vxs_gl_desc      words = {.get_proc_address = lookup, .user = b->gl, .asset = b->asset};
    vxs_volumes_desc desc  = {.get_proc_address = lookup, .user = b->gl, .width_px = b->width, .height_px = b->height, .log = say};
    if ((r = vxs_gl_create(&b->shadows, &words)) != VXS_OK)
        return fail(m, r, "the words cannot be uploaded: %s", vxs_result_text(r));
    vxs_gl_upload(b->shadows, SIZE_MAX);
    desc.shadows = b->shadows;
    if ((r = vxs_volumes_create(&b->volumes, &desc)) != VXS_OK) return fail(m, r, "no volumes: %s", vxs_result_text(r));
    GLuint *const textures[] = {&b->depths, &b->texture};
    for (int n = 0; n < 2; n++) {
        b->gl->CreateTextures(GL_TEXTURE_2D, 1, textures[n]);
        b->gl->TextureStorage2D(*textures[n], 1, GL_R32F, (GLsizei)b->width, (GLsizei)b->height);
    }
    return VXS_OK;
}

static vxs_result report(const bench *b, json_t *scenes, message *m)
{
    json_t *o = json_object();
    json_set(&o, "generator", json_text("vxs " VXS_VERSION));
    json_set(&o, "renderer", json_text(b->gl->renderer));
    json_set(&o, "clock", json_text(b->backend == GL_BACKEND_EGL ? "wall" : "processor"));
    json_set(&o, "side_px", json_integer(b->side));
    json_set(&o, "capsules", json_integer(b->capsule_count));
    json_set(&o, "places", json_integer((json_int_t)b->width * b->height));
    json_set(&o, "rounds", json_integer(b->rounds));
    json_set(&o, "scenes", scenes);
    return json_write(b->json_path, o, m);
}

static vxs_result run(void *command, message *m)
{
    bench     *b      = command;
    size_t     count  = (size_t)b->width * b->height;
    json_t    *scenes = json_array();
    vxs_result r      = bake(b);
    if (r != VXS_OK) r = fail(m, r, "no asset: %s", vxs_result_text(r));
    b->capsules = malloc(b->capsule_count * sizeof *b->capsules);
    b->read     = malloc(count * sizeof *b->read);
    b->places   = malloc(count * sizeof *b->places);
    b->wanted   = malloc(count * sizeof *b->wanted);
    if (!b->capsules || !b->read || !b->places || !b->wanted) r = fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) r = open_gl(b, m);
    if (r == VXS_OK) r = measure_all(b, &scenes, m);
    if (r == VXS_OK && b->json_path)
        r = report(b, scenes, m);
    else
        json_decref(scenes);
    vxs_volumes_destroy(b->volumes);
    vxs_gl_destroy(b->shadows);
    gl_context_destroy(b->gl);
    vxs_asset_close(b->asset);
    free(b->capsules);
    free(b->read);
    free(b->places);
    free(b->wanted);
    return r;
}

int main(int argc, char **argv)
{
    bench        b         = {.side = 256, .capsule_count = 4000, .width = 160, .height = 90, .rounds = 7};
    const option options[] = {
        {"--side", OPTION_U32, &b.side, 8, 1024, NULL, "PX", "texels a side of the map (default 256)", NULL},
        {"--capsules", OPTION_U32, &b.capsule_count, 8, 100000, NULL, "N", "default 4000", NULL},
        {"--width", OPTION_U32, &b.width, 16, 4096, NULL, "PX", "places across (default 160)", NULL},
        {"--height", OPTION_U32, &b.height, 16, 4096, NULL, "PX", "default 90", NULL},
        {"--rounds", OPTION_U32, &b.rounds, 1, ROUNDS_MAX, NULL, "N", "default 7", NULL},
        {"--gl", OPTION_CHOICE, &b.backend, 0, 0, "osmesa|egl", NULL, "whose OpenGL draws (default osmesa)", NULL},
        {"--json", OPTION_OUTPUT, &b.json_path, 0, 0, ".json", "FILE.json", "figures as JSON", NULL},
    };
    const command_line line = COMMAND_LINE("smoke", "[options]", "Measure error of transmittance against bytes and time.", options);
    return command_run(&line, argc, argv, run, &b);
}
