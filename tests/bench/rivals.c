/* rivals: vxs beside other ways to keep a light's shadow, on the same depth maps, in one run.
 *
 *     rivals SCENE [--sun X,Y,Z] [--resolution N] [--threads N] [--runs R] [--points P] [--width PX]
 *         [--eye X,Y,Z --target X,Y,Z] [--fov DEGREES] [--voxels all|COUNT] [--rival NAME]... [--json FILE] [--fault depth|filter]
 *
 * The maps are made once; then each rival (rival.h) makes a file of them, reads it, answers at the same points, and is checked:
 * single taps against the contract of an asset, voxel by voxel, filtered lookups against its own single taps. Tables go to standard
 * output. Points are anywhere, at edges of shadows, and where the pixels of a picture see surfaces: from where vxs render looks, or
 * from --eye. With --threads, DAGs and palette blocks are made and opened on so many. --fault plants one that the check must see: a
 * texel whose caster the rivals do not get, or filters that are queried a texel aside. Exit status 0: no voxel is wrong (rays are
 * not judged: they graze triangles); 1: some are; else as vxs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/command/options/options.h"
#include "baker/command/process/process.h"
#include "baker/files/json_file.h"
#include "baker/files/run_files.h"
#include "tests/bench/rival_report.h"

typedef enum fault { FAULT_NONE, FAULT_DEPTH, FAULT_FILTER } fault;

typedef struct rivals_command {
    bake_options    bake;
    measure_options measure;
    const char     *json_path;
    int             fault;
    uint32_t        threads;
    text_list       names; /* none: all */
} rivals_command;

static const rival *const families[] = {block_rivals, dag_rivals, interval_rivals, depth_rivals, shader_rivals, ray_rivals};

enum { FAMILY_COUNT = sizeof families / sizeof *families };

static int is_listed(const text_list *names, const char *name)
{
    for (size_t n = 0; n < names->count; n++)
        if (!strcmp(names->items[n], name)) return 1;
    return 0;
}

/* vxs, which others are held against, and those that are named, or all.
 * out  [out] their results; NULL: they are counted alone */
static size_t choose(const text_list *names, rival_result *out)
{
    size_t count = 0;
    for (int f = 0; f < FAMILY_COUNT; f++)
        for (const rival *r = families[f]; r->name; r++) {
            if (names->count && count && !is_listed(names, r->name)) continue;
            if (out) out[count].rival = r;
            count++;
        }
    return count;
}

static vxs_result check_names(const text_list *names, run_context *m)
{
    for (size_t n = 0; n < names->count; n++) {
        int known = 0;
        for (int f = 0; f < FAMILY_COUNT; f++)
            for (const rival *r = families[f]; r->name; r++) known |= !strcmp(r->name, names->items[n]);
        if (!known) return fail(m, VXS_E_ARGUMENT, "--rival %s: there is none of that name", names->items[n]);
    }
    return VXS_OK;
}

static int all_right(const rival_report *report)
{
    uint64_t wrong = 0;
    for (const rival_result *r = report->results; r < report->results + report->count; r++)
        wrong += r->wrong_filters[LOOKUP_BOX] + r->wrong_filters[LOOKUP_SMOOTH] +
                 (r->rival->traits & RIVAL_RAYS ? 0 : r->wrong_lit + r->wrong_dark);
    return !wrong;
}

static void place_camera(measure_options *o, const rival_maps *maps)
{
    const vxs_baked_light sun = {.light = maps->light}, *suns = &sun;
    box around = box_of_corners(maps->casters.positions_ws, maps->casters.indices, 3 * maps->casters.triangle_count);
    if (!o->camera.eye_given) camera_frame_lit(&o->camera.camera, &around, &suns, 1, (double)o->width_px / o->height_px);
}

static vxs_result run(rivals_command *c, int *right, run_context *m)
{
    rival_maps    maps    = {.levels = 0};
    size_t        count   = choose(&c->names, NULL);
    rival_result *results = calloc(count, sizeof *results);
    rival_report  report  = {c->bake.scene_path, &maps, &c->measure, results, count};
    vxs_result    r       = results ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) r = rival_maps_render(&maps, &c->bake, m);
    if (results) choose(&c->names, results);
    maps.threads = c->threads;
    place_camera(&c->measure, &maps);
    if (r == VXS_OK && c->fault == FAULT_DEPTH) r = rival_maps_spoil(&maps, m);
    if (r == VXS_OK) r = rivals_measure(results, count, &maps, &c->measure, m);
    if (r != VXS_OK) goto done;

    /* JSON that goes to standard output stays alone there */
    FILE *to = c->json_path && !strcmp(c->json_path, "-") ? stderr : stdout;
    if (!rival_report_print(to, &report)) r = fail(m, VXS_E_MEMORY, "out of memory for a table");
    if (r == VXS_OK && c->json_path) r = json_write(c->json_path, rival_report_json(&report), m);
    *right = all_right(&report);
done:
    rival_maps_free(&maps);
    free(results);
    return r;
}

static vxs_result parse(rivals_command *c, int argc, char **argv, int *help_shown, run_context *m)
{
    const char  *voxels    = "2000000";
    const option options[] = {
        {"SCENE", OPTION_INPUT, &c->bake.scene_path, FILE_SCENE, 0, NULL, NULL, NULL, NULL},
        {"--sun", OPTION_NAMED_VECTOR, &c->bake.suns, 0, 3, SUN_NAME, "[NAME=]X,Y,Z", "as bake", NULL},
        {"--light", OPTION_TEXTS, &c->bake.light_names, 0, 0, NULL, "NAME", "as bake", NULL},
        {"--resolution", OPTION_U32, &c->bake.resolution, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX, NULL, "N", "as bake (default 4096)",
         NULL},
        {"--runs", OPTION_U32, &c->measure.runs, 1, 1000, NULL, "R", "of everything that is timed (default 5)", NULL},
        {"--threads", OPTION_U32, &c->threads, 1, PARALLEL_THREADS_MAX, NULL, "N",
         "for making and opening files, where a rival can use them (default 1)", NULL},
        {"--points", OPTION_U32, &c->measure.points, 1, 1e8, NULL, "P", "lookups of each kind in a run (default 1000000)", NULL},
        {"--width", OPTION_U32, &c->measure.width_px, 16, 8192, NULL, "PX", "of the picture, 16:9, whose pixels ask (default 1920)",
         NULL},
        {"--eye", OPTION_VECTOR, c->measure.camera.camera.eye_ws, 0, 3, NULL, "X,Y,Z", "as render", &c->measure.camera.eye_given},
        {"--target", OPTION_VECTOR, c->measure.camera.camera.target_ws, 0, 3, NULL, "X,Y,Z", "as render",
         &c->measure.camera.target_given},
        {"--fov", OPTION_F64, &c->measure.camera.camera.fov_degrees, 1, 170, NULL, "DEGREES", "as render (default 35)", NULL},
        {"--voxels", OPTION_TEXT, &voxels, 0, 0, NULL, "COUNT", "random voxels to check, or all (default 2000000)", NULL},
        {"--rival", OPTION_TEXTS, &c->names, 0, 0, NULL, "NAME", "this one beside vxs; repeat for more (default all)", NULL},
        {"--seed", OPTION_U32, &c->measure.seed, 0, UINT32_MAX, NULL, "S", "other points (default 1)", NULL},
        {"--json", OPTION_OUTPUT, &c->json_path, 0, 0, ".json", "FILE", "the same as JSON; - is standard output", NULL},
        {"--fault", OPTION_CHOICE, &c->fault, 0, 0, "none|depth|filter", NULL, "plant a fault", NULL},
    };
    const command_line line = COMMAND_LINE(
        "rivals", "SCENE [options]", "Measure vxs beside other ways to keep a light's shadow, on the same depth maps.", options);
    vxs_result r = options_parse(&line, argc, argv, help_shown, m);
    if (r == VXS_OK && !*help_shown) r = options_check_files(&line, m);
    if (r == VXS_OK && !*help_shown) r = camera_check(&c->measure.camera, m);
    if (r == VXS_OK) r = check_names(&c->names, m);
    if (r != VXS_OK) return r;
    c->measure.height_px = c->measure.width_px * 9 / 16;
    if (c->bake.resolution & (c->bake.resolution - 1))
        return fail(m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two", c->bake.resolution);
    if (strcmp(voxels, "all")) {
        char *end;
        c->measure.voxels = strtoull(voxels, &end, 10);
        if (*end || !c->measure.voxels) return fail(m, VXS_E_ARGUMENT, "--voxels %s: expected all or a number from 1", voxels);
    }
    c->measure.filter_aside = c->fault == FAULT_FILTER;
    return VXS_OK;
}

int main(int argc, char **argv)
{
    rivals_command c = {
        .bake    = {.resolution = 4096, .reuse = 1, .stop = STOP_FINAL, .threads = parallel_default_threads()},
        .measure = {.runs = 5, .points = 1000000, .seed = 1, .width_px = 1920, .camera = {.camera = {.fov_degrees = 35}}},
        .threads = 1,
    };
    run_files   files = {0};
    run_context m     = {.files = &files};
    int         help_shown, right = 1;
    process_begin();
    vxs_result r = parse(&c, argc, argv, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = run(&c, &right, &m);
    free(c.bake.light_names.items);
    free(c.names.items);
    named_list_free(&c.bake.suns);
    run_files_free(&files);
    int status = command_end(&m, r);
    return status ? status : !right;
}
