/* area: what an area light takes, beside its lamps one after the other, in one context.
 *
 *     area FILE.vxs [--points N] [--width PX] [--height PX] [--rounds N] [--gl osmesa|egl] [--json FILE.json]
 *
 * A screen of 2 x 1 metres with 1 to 256 lamps stands where the file's first lamp does, points of casters lie about it at random, and the view is of air. Each way draws the same lamps:
 *
 *     together      imperfect shadow maps, grids and a scan of all lamps, then what pixels gather: all of them, a ninth, or of a quarter of the pixels
 *     alone         the same passes of one lamp after the other, each with all the points that fall to it
 *     grids         vxs_volumes_grid of one lamp after the other, by a light map that is there
 *     marches       vxs_volumes_march of one lamp after the other, 64 steps of that map
 *
 * Maps are imperfect shadow maps alone; creation is what a view of one pixel takes, its maps among it. All ways take turns, --rounds times; OpenGL is waited for
 * before and behind each; medians, in milliseconds: of OSMesa's threads together, so that what else the machine does counts less, else of a clock.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/files/json_file.h"
#include "baker/measure/clock.h"
#include "baker/measure/spread.h"
#include "baker/opengl/gl.h"
#include "baker/options/options.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/vxs_area_light.h"

enum { ROUNDS_MAX = 31, COUNTS = 5 };
static const uint32_t counts[COUNTS] = {1, 4, 16, 64, 256};

typedef enum way { TOGETHER, NINTHS, QUARTER, ALONE, GRIDS, MARCHES, WAYS } way;
static const char *const way_names[WAYS] = {"together", "together, ninths", "together, quarter", "alone", "grids", "marches"};

typedef enum part { FRAME, CREATION, MAPS, PARTS } part;

typedef struct area_bench {
    const char         *asset_path, *json_path;
    uint32_t            points, width, height, rounds, threads;
    int                 backend;
    vxs_asset          *asset;
    gl_context         *gl;
    vxs_gl             *shadows;
    vxs_volumes        *volumes;
    vxs_light_map      *map;
    vxs_shadow_grid    *grid;
    vxs_area_light     *all, *one;
    vxs_light_constants light;
    float              *depths; /* zeros */
    GLuint              casters;
    vxs_volumes_frame   frames[2]; /* a view; one pixel of it */
    vxs_area_lamp       lamps[VXS_AREA_LAMPS];
    double              ms[PARTS][COUNTS][WAYS][ROUNDS_MAX];
} area_bench;

static vxs_gl_function lookup(const char *name, void *user)
{
    return (vxs_gl_function)((const gl_context *)user)->lookup(name);
}

static void say(const char *text, void *user)
{
    (void)user;
    fprintf(stderr, "%s\n", text);
}

static vxs_result open_gl(area_bench *b, message *m)
{
    vxs_result r = vxs_asset_open_file(&b->asset, b->asset_path, NULL);
    if (r != VXS_OK) return fail(m, r, "%s: %s", b->asset_path, vxs_result_text(r));
    if ((r = gl_context_create(&b->gl, (gl_backend)b->backend, b->threads, m)) != VXS_OK) return r;
    vxs_gl_desc words = {.struct_size = sizeof words, .get_proc_address = lookup, .user = b->gl, .asset = b->asset};
    if ((r = vxs_gl_create(&b->shadows, &words)) != VXS_OK) return fail(m, r, "no words: %s", vxs_result_text(r));
    vxs_gl_upload(b->shadows, SIZE_MAX);
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = lookup,
                             .user             = b->gl,
                             .shadows          = b->shadows,
                             .width_px         = b->width,
                             .height_px        = b->height,
                             .log              = say};
    if ((r = vxs_volumes_create(&b->volumes, &desc)) != VXS_OK) return fail(m, r, "no fog: %s", vxs_result_text(r));
    vxs_light_map_desc   map  = {.side_px = 128};
    vxs_shadow_grid_desc grid = {.columns = 128, .rows = 128, .bits = 128};
    vxs_area_light_desc  all = {0}, one = {.lamps = 1};
    if ((r = vxs_light_map_create(&b->map, b->volumes, &map)) != VXS_OK ||
        (r = vxs_shadow_grid_create(&b->grid, b->volumes, &grid)) != VXS_OK ||
        (r = vxs_area_light_create(&b->all, b->volumes, &all)) != VXS_OK ||
        (r = vxs_area_light_create(&b->one, b->volumes, &one)) != VXS_OK)
        return fail(m, r, "no area light: %s", vxs_result_text(r));
    while (vxs_light_map_fill(b->map, 1 << 20)) continue;
    return VXS_OK;
}

/* Points on spheres of 2 to 10 metres about the lamp, as many in each square metre as in any other. */
static vxs_result scatter(area_bench *b, const float place[3], message *m)
{
    vxs_area_point *points = malloc(b->points * sizeof *points);
    rng             r      = {1};
    if (!points) return fail(m, VXS_E_MEMORY, "out of memory for points");
    for (uint32_t n = 0; n < b->points; n++) {
        double from[3], square, metres = 2 * pow(5, rng_unit(&r));
        do {
            square = 0;
            for (int i = 0; i < 3; i++) {
                from[i] = 2 * rng_unit(&r) - 1;
                square += from[i] * from[i];
            }
        } while (square > 1 || square < 1e-4);
        points[n].square_metres = (float)(12.6 * metres * metres / b->points);
        for (int i = 0; i < 3; i++) points[n].place[i] = (float)((double)place[i] + metres * from[i] / sqrt(square));
    }
    b->gl->GenBuffers(1, &b->casters);
    b->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->casters);
    b->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(b->points * sizeof *points), points, GL_STATIC_DRAW);
    free(points);
    return VXS_OK;
}

/* The view from 8 metres before the screen, a quarter turn wide, of nothing but air. */
static void set_frames(area_bench *b, const float place[3])
{
    GLuint texture;
    b->gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    b->gl->TextureStorage2D(texture, 1, GL_R32F, (GLsizei)b->width, (GLsizei)b->height);
    b->gl->TextureSubImage2D(texture, 0, 0, 0, (GLsizei)b->width, (GLsizei)b->height, GL_RED, GL_FLOAT, b->depths);
    for (uint32_t n = 0; n < 2; n++) {
        vxs_volumes_frame *f = &b->frames[n];
        float             *p = f->view.point_from_depth, high = (float)b->height / (float)b->width;
        *f      = (vxs_volumes_frame){.top_metres = 1e30F, .far_metres = 20, .depth_texture = texture};
        f->view = (vxs_view){.width_px = n ? 1 : b->width, .height_px = n ? 1 : b->height};
        for (int i = 0; i < 3; i++) {
            f->scattering[i] = f->extinction[i] = 0.02F;
            f->eye[i] = p[8 + i] = place[i] + (i == 2 ? 8 : i == 1 ? 0.7F : 0);
        }
        p[0]  = 2;
        p[5]  = 2 * high;
        p[11] = 1;
        p[12] = -1;
        p[13] = -high;
        p[14] = -1;
    }
}

static vxs_result set_up(area_bench *b, message *m)
{
    float place[3] = {0};
    b->depths      = calloc((size_t)b->width * b->height, sizeof *b->depths);
    if (!b->depths) return fail(m, VXS_E_MEMORY, "out of memory for a picture");
    b->light = vxs_gl_constants(b->shadows)[0];
    if (b->light.kind == VXS_LIGHT_KIND_DIRECTIONAL)
        return fail(m, VXS_E_ARGUMENT, "%s: its first light is no lamp", b->asset_path);
    for (int n = 0; n < 3; n++)
        for (int row = 0; row < 3; row++) place[n] -= b->light.ls_from_ws[4 * row + n] * b->light.ls_from_ws[4 * row + 3];
    const vxs_area_rectangle screen = {{place[0] - 1, place[1] - 0.5F, place[2]}, {2, 0, 0}, {0, 1, 0}, {10, 10, 10}, NULL, 0, 0};
    set_frames(b, place);
    vxs_area_sample(&screen, VXS_AREA_HALTON, 0, b->lamps, VXS_AREA_LAMPS);
    return scatter(b, place, m);
}

/* The light of the map, moved to a lamp. */
static vxs_volumes_light light_at(const area_bench *b, const vxs_area_lamp *lamp, vxs_light_constants *constants)
{
    *constants = b->light;
    for (int row = 0; row < 3; row++) {
        float *r = constants->ls_from_ws + 4 * row;
        r[3]     = -(r[0] * lamp->place[0] + r[1] * lamp->place[1] + r[2] * lamp->place[2]);
    }
    return (vxs_volumes_light){.constants = constants, .colour = {1, 1, 1}, .radius_metres = lamp->radius_metres};
}

static vxs_result draw_area(const area_bench *b, vxs_area_light *light, const vxs_area_lamp *lamps, uint32_t count, uint32_t points,
                            vxs_area_gather gather, part of)
{
    vxs_result r = vxs_area_light_set(light, lamps, count);
    if (r == VXS_OK) r = vxs_area_light_cast(light, &(vxs_area_casters){b->casters, points, 0});
    return r == VXS_OK && of != MAPS ? vxs_volumes_area(b->volumes, light, &(vxs_area_look){.gather = gather}) : r;
}

static vxs_result draw(const area_bench *b, way which, uint32_t count, part of)
{
    vxs_result r = VXS_OK;
    if (which <= QUARTER) return draw_area(b, b->all, b->lamps, count, b->points, (vxs_area_gather)which, of);
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        vxs_light_constants constants;
        vxs_volumes_light   light = light_at(b, &b->lamps[n], &constants);
        if (which == ALONE) r = draw_area(b, b->one, &b->lamps[n], 1, b->points / count, VXS_AREA_EACH, of);
        if (which == GRIDS && of != MAPS) r = vxs_volumes_grid(b->volumes, &light, b->map, b->grid, 8);
        if (which == MARCHES && of != MAPS) r = vxs_volumes_march(b->volumes, &light, b->map, 64, VXS_STEPS_ANGLE);
    }
    return r;
}

static double seconds(const area_bench *b)
{
    return b->backend == GL_BACKEND_OSMESA ? (double)clock() / CLOCKS_PER_SEC : clock_seconds();
}

static vxs_result measure(area_bench *b, message *m)
{
    for (uint32_t round = 0; round <= b->rounds; round++) /* the first warms up */
        for (uint32_t n = 0; n < PARTS * COUNTS * WAYS; n++) {
            uint32_t count = n / PARTS / WAYS;
            part     of    = (part)(n % PARTS);
            way      which = (way)(n / PARTS % WAYS);
            if (!round && counts[count] > 4) continue;
            vxs_result r = vxs_volumes_begin(b->volumes, &b->frames[of != FRAME]);
            b->gl->Finish();
            double begun = seconds(b);
            if (r == VXS_OK) r = draw(b, which, counts[count], of);
            if (r != VXS_OK) return fail(m, r, "%s: %s", way_names[which], vxs_result_text(r));
            b->gl->Finish();
            if (round) b->ms[of][count][which][round - 1] = 1e3 * (seconds(b) - begun);
        }
    return VXS_OK;
}

static vxs_result report(area_bench *b, message *m)
{
    json_t *rows = json_array();
    printf("%5s  %-18s %12s %12s %12s\n", "lamps", "way", "maps, ms", "creation, ms", "frame, ms");
    for (int count = 0; count < COUNTS; count++)
        for (int which = 0; which < WAYS; which++) {
            double median[PARTS];
            for (int of = 0; of < PARTS; of++) median[of] = spread_of(b->ms[of][count][which], b->rounds).median;
            printf("%5u  %-18s %12.2f %12.2f %12.2f\n", counts[count], way_names[which], median[MAPS], median[CREATION],
                   median[FRAME]);
            json_array_append_new(rows,
                                  json_pack("{s:i,s:s,s:f,s:f,s:f}", "lamps", (int)counts[count], "way", way_names[which],
                                            "maps_ms", median[MAPS], "creation_ms", median[CREATION], "frame_ms", median[FRAME]));
        }
    if (b->json_path) return json_write(b->json_path, rows, m);
    json_decref(rows);
    return VXS_OK;
}

static vxs_result run(void *command, message *m)
{
    area_bench *b = command;
    vxs_result  r = open_gl(b, m);
    if (r == VXS_OK) r = set_up(b, m);
    if (r == VXS_OK) r = measure(b, m);
    if (r == VXS_OK) r = report(b, m);
    vxs_area_light_destroy(b->one);
    vxs_area_light_destroy(b->all);
    vxs_shadow_grid_destroy(b->grid);
    vxs_light_map_destroy(b->map);
    vxs_volumes_destroy(b->volumes);
    vxs_gl_destroy(b->shadows);
    gl_context_destroy(b->gl);
    vxs_asset_close(b->asset);
    free(b->depths);
    return r;
}

int main(int argc, char **argv)
{
    static area_bench b         = {.points = 200000, .width = 64, .height = 36, .rounds = 3};
    const option      options[] = {
             {"FILE.vxs", OPTION_INPUT, &b.asset_path, FILE_ASSET, 0, NULL, NULL, "shadows whose first light is a lamp", NULL},
             {"--points", OPTION_U32, &b.points, 1, 1 << 24, NULL, "N", "of casters (default 200000)", NULL},
             {"--width", OPTION_U32, &b.width, 16, 4096, NULL, "PX", "default 64", NULL},
             {"--height", OPTION_U32, &b.height, 16, 4096, NULL, "PX", "default 36", NULL},
             {"--rounds", OPTION_U32, &b.rounds, 1, ROUNDS_MAX, NULL, "N", "default 3", NULL},
             {"--gl", OPTION_CHOICE, &b.backend, 0, 0, "osmesa|egl", NULL, "whose OpenGL draws (default osmesa)", NULL},
             {"--threads", OPTION_U32, &b.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads of OSMesa", NULL},
             {"--json", OPTION_OUTPUT, &b.json_path, 0, 0, ".json", "FILE.json", "figures as JSON", NULL},
    };
    const command_line line =
        COMMAND_LINE("area", "FILE.vxs [options]", "Measure area lights beside their lamps one after the other.", options);
    b.threads = parallel_default_threads();
    return command_run(&line, argc, argv, run, &b);
}
