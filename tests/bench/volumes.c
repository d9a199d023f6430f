/* volumes: error against run time of shadows in fog, of every technique and rival, each with its own knob, in one process and context.
 *
 *     volumes SCENE FILE.vxs --eye X,Y,Z --target X,Y,Z [--light NAME] [--fog PER_METRE] [--json FILE.json] ...
 *
 * What is seen from a camera, and from two more a third of a texel of the light's map aside. In each round every technique draws every setting of its knob
 * once, one after the other, so that what else the machine does falls on all of them; OpenGL is waited for before and behind each. The reference
 * is airlight between exact lit intervals of the asset, in double; of spheres, between those of formulas, so that what is off by its map counts, too.
 * A cell is on the front when no other that is as near to it is faster.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/opengl/gl.h"
#include "baker/options/options.h"
#include "tests/bench/volumes_bench.h"

static vxs_result load(bench *b, message *m)
{
    scene_choice choice = {0};
    vxs_result   r      = vxs_asset_open_file(&b->asset, b->asset_path, NULL);
    if (r != VXS_OK) return fail(m, r, "%s: %s", b->asset_path, vxs_result_text(r));
    for (uint32_t n = 0; b->light_name && n < vxs_asset_light_count(b->asset); n++)
        if (!strcmp(vxs_asset_light(b->asset, n)->light.name, b->light_name)) b->number = n;
    if ((r = scene_load_gltf(&b->scene, b->scene_path, &choice, m)) != VXS_OK) return r;
    if ((r = casters_from_scene(&b->casting, &b->scene, CLOSED_OFF, b->threads, m)) != VXS_OK) return r;
    if ((r = truth_create(&b->truth, &b->casting, b->threads, m)) != VXS_OK) return r;
    box    bounds    = box_of_corners(b->casting.positions_ws, b->casting.indices, 3 * b->casting.triangle_count);
    double size      = box_diagonal(&bounds);
    b->far_metres    = 2 * size;
    b->radius_metres = 5e-4 * size;
    b->medium        = fog_of(&b->fog);
    if (b->is_of_spheres && (r = volumes_find_spheres(b, m)) != VXS_OK) return r;
    b->pixels  = (size_t)b->width * b->height;
    b->wanted  = malloc(3 * CAMERAS * b->pixels * sizeof *b->wanted);
    b->classes = malloc(b->pixels);
    return b->wanted && b->classes ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
}

static vxs_gl_function lookup(const char *name, void *user)
{
    return (vxs_gl_function)((const gl_context *)user)->lookup(name);
}

static void say(const char *text, void *user)
{
    (void)user;
    fprintf(stderr, "%s\n", text);
}

static vxs_result open_gl(bench *b, message *m)
{
    vxs_result r = gl_context_create(&b->gl, b->backend, b->threads, m);
    if (r != VXS_OK) return r;
    vxs_gl_desc words = {.struct_size = sizeof words, .get_proc_address = lookup, .user = b->gl, .asset = b->asset};
    if ((r = vxs_gl_create(&b->shadows, &words)) != VXS_OK)
        return fail(m, r, "the words cannot be uploaded: %s", vxs_result_text(r));
    vxs_gl_upload(b->shadows, SIZE_MAX);
    vxs_gl_origin(b->shadows, b->pose.eye_ws);
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = lookup,
                             .user             = b->gl,
                             .shadows          = b->shadows,
                             .width_px         = b->width,
                             .height_px        = b->height,
                             .log              = say};
    if ((r = vxs_volumes_create(&b->volumes, &desc)) != VXS_OK) return fail(m, r, "no fog: %s", vxs_result_text(r));
    vxs_light_map_desc map = {.baked = b->number};
    if ((r = vxs_light_map_create(&b->map, b->volumes, &map)) != VXS_OK) return fail(m, r, "no light map: %s", vxs_result_text(r));
    while (vxs_light_map_fill(b->map, 1 << 20)) continue;
    return VXS_OK;
}

static vxs_result run(void *command, message *m)
{
    bench     *b     = command;
    size_t     count = 0;
    cell      *cells = calloc(CELLS_MAX, sizeof *cells);
    vxs_result r     = cells ? load(b, m) : fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) r = open_gl(b, m);
    for (int camera = 0; camera < CAMERAS && r == VXS_OK; camera++) r = volumes_see(b, camera, m);
    if (r == VXS_OK) volumes_open_cells(b, cells, &count);
    if (r == VXS_OK) r = volumes_time_cells(b, cells, count, m);
    for (size_t n = 0; n < count && r == VXS_OK; n++)
        if (!cells[n].is_refused) r = volumes_judge(b, &cells[n], m);
    if (r == VXS_OK) {
        volumes_find_front(cells, count);
        r = volumes_report(b, cells, count, m);
    }
    for (size_t n = 0; n < count; n++) cells[n].technique->close(cells[n].state);
    vxs_light_map_destroy(b->map);
    vxs_volumes_destroy(b->volumes);
    vxs_gl_destroy(b->shadows);
    gl_context_destroy(b->gl);
    truth_destroy(b->truth);
    free((void *)b->spheres.at);
    casters_free(&b->casting);
    scene_free(&b->scene);
    vxs_asset_close(b->asset);
    free(b->wanted);
    free(b->classes);
    free(cells);
    return r;
}

int main(int argc, char **argv)
{
    bench b                = {.pose.fov_degrees = 60,
                              .width            = 160,
                              .height           = 90,
                              .rounds           = 7,
                              .values           = VALUES_MAX,
                              .threads          = parallel_default_threads(),
                              .fog              = FOG_DEFAULTS};
    b.fog.per_metre        = 0.01;
    const option options[] = {
        {"SCENE", OPTION_INPUT, &b.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene", NULL},
        {"FILE.vxs", OPTION_INPUT, &b.asset_path, FILE_ASSET, 0, NULL, NULL, "its shadows", NULL},
        {"--light", OPTION_TEXT, &b.light_name, 0, 0, NULL, "NAME", "the light (default the first)", NULL},
        {"--eye", OPTION_VECTOR, b.pose.eye_ws, 0, 3, NULL, "X,Y,Z", "where to stand, metres", NULL},
        {"--target", OPTION_VECTOR, b.pose.target_ws, 0, 3, NULL, "X,Y,Z", "where to look", NULL},
        {"--spheres", OPTION_SWITCH, &b.is_of_spheres, 0, 0, NULL, NULL, "all is spheres: formulas tell what is lit, not the asset",
         NULL},
        {"--fov", OPTION_F64, &b.pose.fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom (default 60)", NULL},
        {"--width", OPTION_U32, &b.width, 16, 4096, NULL, "PX", "default 160", NULL},
        {"--height", OPTION_U32, &b.height, 16, 4096, NULL, "PX", "default 90", NULL},
        FOG_ROWS(b.fog),
        {"--rounds", OPTION_U32, &b.rounds, 1, ROUNDS_MAX, NULL, "N", "default 7", NULL},
        {"--values", OPTION_U32, &b.values, 1, VALUES_MAX, NULL, "N", "of each knob, the first N (default all)", NULL},
        {"--gl", OPTION_CHOICE, &b.backend, 0, 0, "osmesa|egl", NULL, "whose OpenGL draws (default osmesa)", NULL},
        {"--threads", OPTION_U32, &b.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads", NULL},
        {"--json", OPTION_OUTPUT, &b.json_path, 0, 0, ".json", "FILE.json", "figures as JSON", NULL},
    };
    const command_line line = COMMAND_LINE("volumes", "SCENE FILE.vxs --eye X,Y,Z --target X,Y,Z [options]",
                                           "Measure error against run time of shadows in fog.", options);
    return command_run(&line, argc, argv, run, &b);
}
