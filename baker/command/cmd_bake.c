/* vxs bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "baker/bake.h"
#include "baker/base/output_file.h"
#include "baker/base/parallel.h"
#include "baker/command/options.h"
#include "baker/report.h"

static vxs_result check_options(bake_options *o, int resolution_given, int texel_given, const char *json_path, message *m)
{
    if (!o->output_path) return fail(m, VXS_E_ARGUMENT, "bake needs -o OUT.vxs");
    if (json_path && !strcmp(json_path, o->output_path) && strcmp(json_path, "-"))
        return fail(m, VXS_E_ARGUMENT, "-o and --json are both %s: expected two names", json_path);
    if (json_path && !strcmp(json_path, "-") && !strcmp(o->output_path, "-"))
        return fail(m, VXS_E_ARGUMENT, "-o - and --json - exclude each other: both would go to standard output");
    if (resolution_given && texel_given) return fail(m, VXS_E_ARGUMENT, "--resolution and --texel exclude each other");
    if (texel_given) o->resolution = 0;
    if (o->resolution & (o->resolution - 1))
        return fail(m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two from %d to %d", o->resolution, RESOLUTION_MIN_PX,
                    RESOLUTION_MAX_PX);
    for (int axis = 0; axis < 3 && o->region_given; axis++)
        if (!(o->region_ws[axis] < o->region_ws[axis + 3]))
            return fail(m, VXS_E_ARGUMENT, "--region: the minimum must be less than the maximum, but is %g and %g on axis %c",
                        o->region_ws[axis], o->region_ws[axis + 3], "xyz"[axis]);
    return VXS_OK;
}

int cmd_bake(int argc, char **argv)
{
    bake_options o = {.resolution = 4096, .reuse = 1, .stop = STOP_FINAL, .zstd_level = 12, .threads = parallel_default_threads()};
    int          resolution_given = 0, texel_given = 0, help_shown = 0;
    int          closed = CLOSED_AUTO, exit_choice = EXIT_AUTO, rule = MASK_RULE_GREEDY, stop = STOP_FINAL, gl = GL_BACKEND_OSMESA;
    int          compress = COMPRESS_TOP_DOWN, baseline = BASELINE_SAMPLE, maps = 0;
    const char  *json_path = NULL, *scene_path = NULL;

    const option options[] = {
        {"-o", OPTION_TEXT, &o.output_path, 0, 0, NULL, "OUT.vxs", "where the asset goes; - is standard output", NULL},
        {"--light", OPTION_TEXTS, &o.light_names, 0, 0, NULL, "NAME", "bake this light; repeat for more (default: all)",
         NULL},
        {"--sun", OPTION_VECTOR, o.sun, 0, 3, NULL, "X,Y,Z", "add a light named sun that travels this way", &o.sun_given},
        {"--resolution", OPTION_U32, &o.resolution, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX, NULL, "N",
         "texels a side of the map, a power of two, 8 to 16384 (default 4096)", &resolution_given},
        {"--texel", OPTION_F64, &o.texel_metres, 1e-9, 1e9, NULL, "METRES", "side of a texel; the resolution follows from it",
         &texel_given},
        {"--region", OPTION_VECTOR, o.region_ws, 0, 6, NULL, "MIN,MAX",
         "x,y,z,x,y,z of the box that will be looked up, metres (default: all casters)", &o.region_given},
        {"--scene", OPTION_TEXT, &o.scene_name, 0, 0, NULL, "NAME", "name or index of the glTF scene (default: the file's)", NULL},
        {"--maps", OPTION_CHOICE, &maps, 0, 0, "auto|gl", NULL, "where depths come from (default auto, which is gl)", NULL},
        {"--gl", OPTION_CHOICE, &gl, 0, 0, GL_CHOICES, NULL, "OpenGL by OSMesa, or by EGL for a GPU (default osmesa)", NULL},
        {"--exit", OPTION_CHOICE, &exit_choice, 0, 0, EXIT_CHOICES, NULL,
         "exit depth of solids: peeled, or the nearest back face (default auto: peeled where solids meet)", NULL},
        {"--closed", OPTION_CHOICE, &closed, 0, 0, CLOSED_CHOICES, NULL,
         "solids: by the rules, all that is closed, none (default auto)", NULL},
        {"--rule", OPTION_CHOICE, &rule, 0, 0, RULE_CHOICES, NULL,
         "undefined voxels: fewest masks, or shadow as in older work (default greedy)", NULL},
        {"--reuse", OPTION_CHOICE, &o.reuse, 0, 0, REUSE_CHOICES, NULL,
         "insertion refers to an equal neighbour nearer the light (default on)", NULL},
        {"--compress", OPTION_CHOICE, &compress, 0, 0, COMPRESS_CHOICES, NULL, "order of sub-DAG compression (default top-down)",
         NULL},
        {"--stop", OPTION_CHOICE, &stop, 0, 0, STOP_CHOICES, NULL,
         "after insertion, sub-DAG compression, or the merge (default final)", NULL},
        {"--level", OPTION_U32, &o.zstd_level, 1, 19, NULL, "L", "zstd level of the file, 1 to 19 (default 12)", NULL},
        {"--threads", OPTION_U32, &o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N",
         "threads (default: all processors); never changes the bytes", NULL},
        {"--baseline", OPTION_CHOICE, &baseline, 0, 0, BASELINE_CHOICES, NULL,
         "measure the depth map under zstd -19 on a sample, whole (slow), or not (default sample)", NULL},
        {"--json", OPTION_TEXT, &json_path, 0, 0, NULL, "FILE", "the report as JSON; - is standard output", NULL},
    };
    const command_line line = {"bake",  "SCENE -o OUT.vxs [options]",     "Bake the shadows of a glTF scene into a .vxs file.",
                               options, sizeof options / sizeof *options, 1};

    message     m      = {0};
    bake_report report = {0};
    vxs_result  r      = options_parse(&line, argc, argv, &scene_path, &help_shown, &m);
    if (r == VXS_OK && !help_shown) {
        o.scene_path = scene_path;
        o.closed     = (closed_mode)closed;
        o.exit       = (exit_mode)exit_choice;
        o.rule       = (mask_rule)rule;
        o.compress   = (compress_order)compress;
        o.stop       = (stop_stage)stop;
        o.gl         = (gl_backend)gl;
        o.baseline   = (baseline_mode)baseline;
        o.progress   = isatty(STDERR_FILENO);
        r            = check_options(&o, resolution_given, texel_given, json_path, &m);
        if (r == VXS_OK && json_path) r = output_file_check(json_path, scene_path, &m);
        if (r == VXS_OK) r = bake(&o, &report, &m);
        /* what goes to standard output stays alone there */
        int to_stdout = !strcmp(o.output_path ? o.output_path : "", "-") || (json_path && !strcmp(json_path, "-"));
        if (r == VXS_OK) report_print(to_stdout ? stderr : stdout, &o, &report);
        if (r == VXS_OK && json_path) r = report_write_json(json_path, &o, &report, &m);
    }
    bake_report_free(&report);
    free(o.light_names.items);
    return command_end(&m, r);
}
