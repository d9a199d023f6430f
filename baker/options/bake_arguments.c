/* The command line of bake and plan; see bake_arguments.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/options/bake_arguments.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"

static vxs_result check(bake_arguments *a, int output_needed, message *m)
{
    bake_options *o = &a->o;
    vxs_result    r;
    if (output_needed && !o->output_path) return fail(m, VXS_E_ARGUMENT, "bake needs -o OUT.vxs");
    if ((r = outputs_check_apart("-o", o->output_path, "--json", a->json_path, m)) != VXS_OK) return r;
    if ((r = outputs_check_apart("-o", o->output_path, "--report", a->page_path, m)) != VXS_OK) return r;
    if ((r = outputs_check_apart("--json", a->json_path, "--report", a->page_path, m)) != VXS_OK) return r;
    if (a->resolution_given && a->texel_given) return fail(m, VXS_E_ARGUMENT, "--resolution and --texel exclude each other");
    if (a->texel_given) o->resolution = 0;
    if (o->resolution & (o->resolution - 1))
        return fail(m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two from %d to %d", o->resolution, RESOLUTION_MIN_PX,
                    RESOLUTION_MAX_PX);
    for (int axis = 0; axis < 3 && o->region_given; axis++)
        if (!(o->region_ws[axis] < o->region_ws[axis + 3]))
            return fail(m, VXS_E_ARGUMENT, "--region: the minimum must be less than the maximum, but is %g and %g on axis %c",
                        o->region_ws[axis], o->region_ws[axis + 3], "xyz"[axis]);
    return VXS_OK;
}

vxs_result bake_arguments_parse(bake_arguments *a, const char *name, const char *synopsis, const char *summary, int output_needed,
                                int argc, char **argv, message *m)
{
    memset(a, 0, sizeof *a);
    a->o =
        (bake_options){.resolution = 4096, .reuse = 1, .stop = STOP_FINAL, .zstd_level = 12, .threads = parallel_default_threads()};
    const option options[] = {
        {"-o", OPTION_TEXT, &a->o.output_path, 0, 0, NULL, "OUT.vxs", "where the asset goes; - is standard output", NULL},
        {"--light", OPTION_TEXTS, &a->o.light_names, 0, 0, NULL, "NAME", "bake this light; repeat for more (default: all)", NULL},
        {"--sun", OPTION_VECTOR, a->o.sun, 0, 3, NULL, "X,Y,Z", "add a light named sun that travels this way", &a->o.sun_given},
        {"--resolution", OPTION_U32, &a->o.resolution, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX, NULL, "N",
         "texels a side of the map, a power of two, 8 to 16384 (default 4096)", &a->resolution_given},
        {"--texel", OPTION_F64, &a->o.texel_metres, 1e-9, 1e9, NULL, "METRES", "side of a texel; the resolution follows from it",
         &a->texel_given},
        {"--region", OPTION_VECTOR, a->o.region_ws, 0, 6, NULL, "MIN,MAX",
         "x,y,z,x,y,z of the box that will be looked up, metres (default: all casters)", &a->o.region_given},
        {"--scene", OPTION_TEXT, &a->o.scene_name, 0, 0, NULL, "NAME", "name or index of the glTF scene (default: the file's)",
         NULL},
        {"--maps", OPTION_CHOICE, &a->maps, 0, 0, "auto|gl", NULL, "where depths come from (default auto, which is gl)", NULL},
        {"--gl", OPTION_CHOICE, &a->o.gl, 0, 0, GL_CHOICES, NULL, "OpenGL by OSMesa, or by EGL for a GPU (default osmesa)", NULL},
        {"--exit", OPTION_CHOICE, &a->o.exit, 0, 0, EXIT_CHOICES, NULL,
         "exit depth of solids: peeled, or the nearest back face (default auto: peeled where solids meet)", NULL},
        {"--closed", OPTION_CHOICE, &a->o.closed, 0, 0, CLOSED_CHOICES, NULL,
         "solids: by the rules, all that is closed, none (default auto)", NULL},
        {"--level", OPTION_U32, &a->o.zstd_level, 1, 19, NULL, "L", "zstd level of the file, 1 to 19 (default 12)", NULL},
        {"--threads", OPTION_U32, &a->o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N",
         "threads (default: all processors); never changes the bytes", NULL},
        {"--memory", OPTION_BYTES, &a->o.memory_bytes, 0, 0, NULL, "BYTES",
         "hold no more memory than this: 800M, 2G, or plain bytes (default: as much as it needs)", NULL},
        {"--report", OPTION_TEXT, &a->page_path, 0, 0, NULL, "FILE.html",
         "a page with sizes, times, the plan and pictures of the maps; - is standard output", NULL},
        {"--json", OPTION_TEXT, &a->json_path, 0, 0, NULL, "FILE", "the report as JSON; - is standard output", NULL},
        {NULL, OPTION_GROUP, NULL, 0, 0, NULL, NULL, "for comparison with older work", NULL},
        {"--rule", OPTION_CHOICE, &a->o.rule, 0, 0, RULE_CHOICES, NULL,
         "undefined voxels: fewest masks, or shadow as in older work (default greedy)", NULL},
        {"--reuse", OPTION_CHOICE, &a->o.reuse, 0, 0, REUSE_CHOICES, NULL,
         "insertion refers to an equal neighbour nearer the light (default on)", NULL},
        {"--compress", OPTION_CHOICE, &a->o.compress, 0, 0, COMPRESS_CHOICES, NULL,
         "order of sub-DAG compression (default auto: top-down where it pays)", NULL},
        {"--stop", OPTION_CHOICE, &a->o.stop, 0, 0, STOP_CHOICES, NULL,
         "after insertion, sub-DAG compression, or the merge (default final)", NULL},
        {"--baseline", OPTION_CHOICE, &a->o.baseline, 0, 0, BASELINE_CHOICES, NULL,
         "measure the depth map under zstd -19 on a sample, whole (slow), or not (default sample)", NULL},
    };
    const command_line line = {name, synopsis, summary, options, sizeof options / sizeof *options, 1};
    vxs_result         r    = options_parse(&line, argc, argv, &a->o.scene_path, &a->help_shown, m);
    if (r != VXS_OK || a->help_shown) return r;
    a->o.pictures = a->page_path != NULL;
    return check(a, output_needed, m);
}

void bake_arguments_free(bake_arguments *a)
{
    free(a->o.light_names.items);
    memset(a, 0, sizeof *a);
}
