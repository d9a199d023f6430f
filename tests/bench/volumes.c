/* volumes: error against run time of shadows in fog, of every technique and rival, each with its own knob, in one process and
 * context.
 *
 *     volumes SCENE FILE.vxs --eye X,Y,Z --target X,Y,Z [--light NAME] [--fog PER_METRE] [--json FILE.json] ...
 *
 * What is seen from a camera, and from two more a third of a texel of the light's map aside. In each round every technique draws
 * every setting of its knob once, one after the other, so that what else the machine does falls on all of them; OpenGL is waited
 * for before and behind each. The reference is airlight between exact lit intervals of the asset, in double; of spheres, between
 * those of formulas, so that what is off by its map counts, too. A cell is on the front when no other that is as near to it is
 * faster.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/command/options/options.h"
#include "tests/bench/volumes_bench.h"

static vxs_result load(bench *b, run_context *m)
{
    vxs_result r = vxs_asset_open_file(&b->asset, b->asset_path, NULL);
    if (r != VXS_OK) return fail(m, r, "%s: %s", b->asset_path, vxs_result_text(r));
    for (uint32_t n = 0; b->light_name && n < vxs_asset_light_count(b->asset); n++)
        if (!strcmp(vxs_asset_light(b->asset, n)->light.name, b->light_name)) b->number = n;
    b->light_name = vxs_asset_light(b->asset, b->number)->light.name;
    if ((r = volumes_load_scene(b, m)) != VXS_OK) return r;
    b->light = (vxs_volumes_light){
        .baked_number = vxs_baked_number(b->number), .colour = {1, 1, 1}, .cos_inner = 1, .radius_metres = (float)b->radius_metres};
    return b->is_of_spheres ? volumes_find_spheres(b, m) : VXS_OK;
}

static vxs_result run(void *command, run_context *m)
{
    bench     *b = command;
    vxs_result r = load(b, m);
    b->reference = b->is_of_spheres ? "formulas of spheres" : "exact lit intervals of the asset";
    if (r == VXS_OK) r = volumes_open_gl(b, m);
    if (r == VXS_OK && (r = volumes_open_map(b, b->number, 0, &b->map)) != VXS_OK)
        r = fail(m, r, "no shadow depth map: %s", vxs_result_text(r));
    for (uint32_t camera = 0; camera < CAMERAS && r == VXS_OK; camera++) r = volumes_see(b, camera, volumes_airlight_wanted, m);
    if (r == VXS_OK) r = volumes_measure(b, m);
    vxs_shadow_depth_map_destroy(b->map);
    volumes_close_gl(b);
    free((void *)b->spheres.at);
    volumes_free_scene(b);
    return r;
}

int main(int argc, char **argv)
{
    bench b         = {BENCH_DEFAULTS, .describe = volumes_describe_view, .pose.fov_degrees = 60, .fog = FOG_DEFAULTS};
    b.fog.per_metre = 0.01;
    volumes_use_techniques(&b);
    const option options[] = {
        {"SCENE", OPTION_INPUT, &b.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene", NULL},
        {"FILE.vxs", OPTION_INPUT, &b.asset_path, FILE_ASSET, 0, NULL, NULL, "its shadows", NULL},
        {"--light", OPTION_TEXT, &b.light_name, 0, 0, NULL, "NAME", "the light (default the first)", NULL},
        {"--eye", OPTION_VECTOR, b.pose.eye_ws, 0, 3, NULL, "X,Y,Z", "where to stand, metres", NULL},
        {"--target", OPTION_VECTOR, b.pose.target_ws, 0, 3, NULL, "X,Y,Z", "where to look", NULL},
        {"--spheres", OPTION_SWITCH, &b.is_of_spheres, 0, 0, NULL, NULL, "all is spheres: formulas tell what is lit, not the asset",
         NULL},
        {"--fov", OPTION_F64, &b.pose.fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom (default 60)", NULL},
        FOG_ROWS(b.fog),
        BENCH_ROWS(b),
    };
    const command_line line = COMMAND_LINE("volumes", "SCENE FILE.vxs --eye X,Y,Z --target X,Y,Z [options]",
                                           "Measure error against run time of shadows in fog.", options);
    return command_run(&line, argc, argv, run, &b);
}
