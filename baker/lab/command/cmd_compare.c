/* vxs compare: error, size and time of .vxs files against ray tracing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/command/asset_open.h"
#include "baker/command/options/options.h"
#include "baker/command/provenance_differences.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"
#include "baker/lab/command/camera_choice.h"
#include "baker/lab/command/compare_report.h"
#include "baker/lab/command/lab_commands.h"

typedef struct compare_command {
    const char   *json_path;
    scene_choice  choice; /* may borrow texts from the first asset's metadata */
    text_list     asset_paths, light_names;
    number_list   filters_px, smooth_px;
    camera_choice camera;
    int           camera_given, fov_given;
    text_list     bake_reports;
    int           closed, closed_given;
    int           other_scene;

    scene          scene;
    compare_report report;
} compare_command;

/* assets ----------------------------------------------------------------------------------------------------------------------- */

/* Read the report that vxs bake --json wrote for an asset. */
static vxs_result read_bake_report(compared_asset *a, const char *path, run_context *m)
{
    static const char *const keys[] = {"total_seconds", "peak_bytes", "file_bytes"};
    double                   values[3];
    const char              *absent  = NULL;
    run_context              of_file = {0};
    json_t                  *root;
    vxs_result               r = json_read(&root, path, &of_file);
    if (r != VXS_OK) return fail(m, r, "--bake-report %s", of_file.error);
    int unchanged = json_is_true(json_object_get(root, "unchanged")); /* nothing was baked, so there are no measurements */
    for (int n = unchanged ? 2 : 0; n < 3; n++) {
        const json_t *value = json_object_get(root, keys[n]);
        values[n]           = json_number_value(value);
        if (!absent && !(json_is_number(value) && values[n] >= 0 && values[n] <= 1e18)) absent = keys[n];
    }
    json_decref(root);
    if (absent)
        return fail(m, VXS_E_READ, "--bake-report %s: expected what vxs bake --json writes, with a number from 0 as %s", path,
                    absent);
    if (values[2] != (double)a->file_bytes)
        return fail(m, VXS_E_ARGUMENT,
                    "--bake-report %s is of a file of %.0f bytes, and '%s' has %llu: expected the report of its bake", path,
                    values[2], a->path, (unsigned long long)a->file_bytes);
    if (unchanged) return VXS_OK;
    a->bake_given      = 1;
    a->bake_seconds    = values[0];
    a->bake_peak_bytes = (uint64_t)values[1];
    return VXS_OK;
}

static vxs_result open_asset(compare_command *c, size_t n, run_context *m)
{
    compared_asset *a = &c->report.assets[n];
    a->path           = c->asset_paths.items[n];
    vxs_result r      = asset_open(&a->asset, a->path, 0, 1, c->report.options.threads, m);
    if (r == VXS_OK) r = provenance_read(&a->made, vxs_asset_contents(a->asset), m);
    if (r != VXS_OK) return r;

    /* the mode that decided in the bake which components were solids; auto if the metadata does not have it */
    const char *closed = json_string_value(json_object_get(json_object_get(a->made, "options"), "closed"));
    int         index  = c->closed_given ? c->closed : closed ? choice_index(CLOSED_CHOICES, closed) : -1;
    a->closed          = index < 0 ? CLOSED_AUTO : (closed_mode)index;

    if ((a->lights = calloc(VXS_LIGHTS_MAX, sizeof *a->lights)) == NULL)
        return fail(m, VXS_E_MEMORY, "out of memory for the lights of '%s'", a->path);
    if ((r = asset_choose_lights(vxs_asset_contents(a->asset), a->path, &c->light_names, a->lights, &a->light_count, m)) != VXS_OK)
        return r;

    const vxs_contents *contents = vxs_asset_contents(a->asset);
    a->file_bytes                = asset_file_bytes(a->asset);
    for (uint32_t l = 0; l < contents->light_count; l++) a->memory_bytes += (uint64_t)contents->lights[l].word_count * 4;
    return n < c->bake_reports.count ? read_bake_report(a, c->bake_reports.items[n], m) : VXS_OK;
}

/* the comparison --------------------------------------------------------------------------------------------------------------- */

/* A comparison that checked no point is an error. */
static vxs_result require_checked(const compare_command *c, const vxs_light *l, const compare_result *result, run_context *m)
{
    uint64_t checked = 0, inside = 0;
    for (int kind = 0; kind < COMPARE_KINDS; kind++) {
        checked += result->counts[kind].checked;
        inside += result->counts[kind].inside_solid;
    }
    if (checked) return VXS_OK;
    if (!inside)
        return fail(m, VXS_E_ARGUMENT, "no point of %s lies in the volume of light '%s'", input_name(c->report.scene_path),
                    l->name);
    return fail(m, VXS_E_ARGUMENT, "all points of %s in the volume of light '%s' lie inside solids: expected more --points",
                input_name(c->report.scene_path), l->name);
}

static vxs_result compare_asset(compare_command *c, compared_asset *a, const casters *casting, const truth *t, run_context *m)
{
    /* the don't-care rules of the asset besides the insides of solids, from its metadata */
    const json_t           *options   = json_object_get(a->made, "options");
    const char             *behind    = json_string_value(json_object_get(options, "behind"));
    double                  thickness = json_number_value(json_object_get(options, "thickness_m"));
    const compare_dont_care dont_care = {behind && choice_index(BEHIND_CHOICES, behind) == BEHIND_FREE,
                                         thickness > 0 ? thickness : 0};

    uint32_t   count        = a->light_count;
    vxs_result r            = VXS_OK;
    a->triangle_count       = casting->triangle_count;
    a->solid_triangle_count = casting->solid_triangle_count;
    a->results              = calloc(count, sizeof *a->results);
    if (!a->results) return fail(m, VXS_E_MEMORY, "out of memory for the results of %u lights", count);
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        const vxs_baked_light *l = a->lights[n];
        if ((r = compare_light(&a->results[n], t, casting, l, &dont_care, &c->report.options, m)) == VXS_OK)
            r = require_checked(c, &l->light, &a->results[n], m);
    }
    return r;
}

/* Errors against a scene that was not baked are meaningless: check all assets before the work begins. */
static vxs_result check_scene(compare_command *c, const scene *s, run_context *m)
{
    vxs_result r = VXS_OK;
    for (size_t n = 0; n < c->report.asset_count && r == VXS_OK; n++) {
        compared_asset *a = &c->report.assets[n];
        char            differ[PROVENANCE_TEXT_BYTES];
        if (a->scene_differences) continue;
        r = provenance_differences(&a->scene_differences, a->made, vxs_asset_contents(a->asset), s, m);
        if (r == VXS_OK && json_array_size(a->scene_differences) && !c->other_scene)
            r = fail(
                m, VXS_E_ARGUMENT,
                "'%s' was baked from another scene than %s (differs: %s): bake it anew, or --other-scene compares all the same",
                a->path, c->report.scene_path, provenance_differences_text(differ, a->scene_differences));
    }
    return r;
}

static vxs_result compare_all(compare_command *c, run_context *m)
{
    vxs_result r;

    r = filters_take(&c->filters_px, &c->smooth_px, c->report.options.filters, &c->report.options.filter_count, m);
    if (r == VXS_OK) r = camera_check(&c->camera, m);
    if (r != VXS_OK) return r;
    c->camera_given |= c->camera.eye_given;
    if (c->fov_given && !c->camera_given) return fail(m, VXS_E_ARGUMENT, "--fov goes with --camera, or with --eye and --target");
    c->report.asset_count = c->asset_paths.count;
    if (c->bake_reports.count > c->report.asset_count)
        return fail(m, VXS_E_ARGUMENT, "--bake-report is given %zu times for %zu .vxs files: expected one for each at most",
                    c->bake_reports.count, c->report.asset_count);

    c->report.assets = calloc(c->report.asset_count, sizeof *c->report.assets);
    if (!c->report.assets) return fail(m, VXS_E_MEMORY, "out of memory for %zu assets", c->report.asset_count);
    for (size_t n = 0; n < c->report.asset_count && r == VXS_OK; n++) r = open_asset(c, n, m);
    if (r != VXS_OK) return r;

    if ((r = asset_scene_choice(c->report.assets[0].made, &c->choice, m)) != VXS_OK) return r;
    if ((r = scene_load_gltf(&c->scene, c->report.scene_path, &c->choice, m)) != VXS_OK) return r;
    if ((r = check_scene(c, &c->scene, m)) != VXS_OK) return r;
    for (size_t n = 0; n < c->report.asset_count && r == VXS_OK; n++)
        if (!c->report.assets[n].results) {
            /* Compare an asset, and all others that were baked with the same solids: they share the casters. */
            compared_asset *assets  = c->report.assets;
            casters         casting = {0};
            truth          *t       = NULL;
            r                       = casters_from_scene(&casting, &c->scene, assets[n].closed, c->report.options.threads, m);
            if (r == VXS_OK) r = truth_create(&t, &casting, c->report.options.threads, m);
            if (r == VXS_OK && n == 0 && c->camera_given) {
                /* one camera serves all assets; if it is not given, it is placed for the lights of the first */
                box around = box_of_corners(casting.positions_ws, casting.indices, 3 * casting.triangle_count);
                if (!c->camera.eye_given)
                    camera_frame_lit(&c->camera.camera, &around, assets->lights, assets->light_count, COMPARE_CAMERA_ASPECT);
                c->report.options.camera = &c->camera.camera;
            }
            for (size_t k = n; k < c->report.asset_count && r == VXS_OK; k++)
                if (assets[k].closed == assets[n].closed) r = compare_asset(c, &assets[k], &casting, t, m);
            truth_destroy(t);
            casters_free(&casting);
        }
    if (r != VXS_OK) return r;

    /* keep the report out of standard output when JSON goes there */
    FILE *to = report_stream(m, is_standard_output(c->json_path));
    if (to) compare_print(to, &c->report, m);
    m->wrong = !compare_passes(&c->report);
    return c->json_path ? json_write(c->json_path, compare_json(&c->report), m) : VXS_OK;
}

static vxs_result run(void *command, run_context *m)
{
    compare_command *c = command;
    vxs_result       r = compare_all(c, m);
    for (size_t n = 0; c->report.assets && n < c->report.asset_count; n++) {
        vxs_asset_close(c->report.assets[n].asset);
        free(c->report.assets[n].results);
        free(c->report.assets[n].lights);
        json_decref(c->report.assets[n].scene_differences);
        json_decref(c->report.assets[n].made);
    }
    free(c->report.assets);
    scene_free(&c->scene);
    return r;
}

int cmd_compare(int argc, char **argv)
{
    compare_command  c          = {.report.options = {.points = 100000, .seed = 1, .threads = parallel_default_threads()}};
    compare_options *o          = &c.report.options;
    c.camera.camera.fov_degrees = 35;
    const option options[]      = {
             {"SCENE", OPTION_INPUT, &c.report.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
             {"FILE.vxs", OPTION_INPUTS, &c.asset_paths, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote, of this scene", NULL},
             {"--light", OPTION_TEXTS, &c.light_names, 0, 0, NULL, "NAME",
              "compare this light of each file, or all that a pattern names; repeat for more (default all of each file)", NULL},
             {"--points", OPTION_U32, &o->points, 1, 1e9, NULL, "N", "points of each kind (default 100000)", NULL},
             {"--seed", OPTION_U32, &o->seed, 0, UINT32_MAX, NULL, "S", "another seed, other points (default 1)", NULL},
             {"--filter", OPTION_U32S, &c.filters_px, 1, VXS_FILTER_MAX, NULL, "K",
              "also compare K x K box filters, K odd, 1 to 17 texels; repeat for more (default single taps only)", NULL},
             {"--smooth", OPTION_U32S, &c.smooth_px, 1, VXS_FILTER_MAX, NULL, "K",
              "also compare smooth K x K filters, K even or odd, 1 to 17 texels; repeat for more", NULL},
             {"--camera", OPTION_SWITCH, &c.camera_given, 0, 0, NULL, NULL, "also compare what a camera sees, all of the scene in view",
              NULL},
             CAMERA_ROWS(c.camera, c.fov_given, "the same, from here, metres (default all of the scene in view)"),
             SCENE_ROWS(c.choice),
             {"--closed", OPTION_CHOICE, &c.closed, 0, 0, CLOSED_CHOICES, NULL,
              "which casters are solids (default as each asset was baked)", &c.closed_given},
             {"--other-scene", OPTION_SWITCH, &c.other_scene, 0, 0, NULL, NULL,
              "go on when SCENE is not what a file was baked from: an edited one, say", NULL},
             {"--threads", OPTION_U32, &o->threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default all processors)", NULL},
             {"--max-error", OPTION_F64, &c.report.max_error, 0, 1, NULL, "F",
              "share of an asset's points that may be wrong, 0 to 1 (default any)", &c.report.max_error_given},
             {"--bake-report", OPTION_INPUTS, &c.bake_reports, FILE_JSON, 0, NULL, "FILE.json",
              "what bake --json wrote of an asset, to tell its time; repeat for more, in their order", NULL},
             {"--json", OPTION_OUTPUT, &c.json_path, 0, 0, ".json", "FILE.json", "the report as JSON; - is standard output", NULL},
    };
    const command_line line = COMMAND_LINE(
        "compare", "SCENE FILE.vxs [FILE.vxs ...] [options]",
        "Compare .vxs files with ray tracing: error, size and time. Lights are looked up at random points, on surfaces, and "
        "where a camera looks. The exit status is 1 when an answer is wrong that the ray through its texel's centre does not "
        "explain, or when more than --max-error of a file's are.",
        options);
    return command_run(&line, argc, argv, run, &c);
}
