/* vxs bench: time, memory, size and error of bakes and lookups. The JSON is described by docs/bench.schema.json.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>

#include "baker/bake/bake.h"
#include "baker/command/options/options.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"
#include "baker/lab/bench/bench.h"
#include "baker/lab/bench/bench_text.h"
#include "baker/lab/command/lab_commands.h"
#include "baker/scene/scene.h"
#include "formats/vxs_format.h"

typedef struct bench_command {
    bench_options o;
    number_list   filters, smooth;
    const char   *output_path, *against_path;
    double        max_slower;
    int           max_slower_given;

    json_t *now, *before;
    int     outputs_differ;
    size_t  too_slow;
} bench_command;

static vxs_result run(void *command, run_context *m)
{
    bench_command *c = command;
    char           word[COLORED_BYTES];
    FILE          *to = report_stream(m, is_standard_output(c->output_path)); /* keep the report out of standard output when JSON
                                                                                 goes there */

    vxs_result r = filters_take(&c->filters, &c->smooth, c->o.filters, &c->o.filter_count, m);
    if (r == VXS_OK && c->max_slower_given && !c->against_path) r = fail(m, VXS_E_ARGUMENT, "--max-slower goes with --against");
    for (size_t n = 0; n < c->o.scenes.count && r == VXS_OK; n++)
        if (!is_read_once(c->o.scenes.items[n])) r = scene_check_files_gltf(c->o.scenes.items[n], m);
    if (r == VXS_OK && c->against_path) r = bench_json_read(&c->before, c->against_path, m);

    c->o.progress = progress_wanted(m);
    if (r == VXS_OK) r = bench_run(&c->o, &c->now, &c->outputs_differ, m);
    if (r == VXS_OK) r = json_write(c->output_path, json_incref(c->now), m);
    if (r == VXS_OK && to) r = bench_print(to, c->now, m);
    if (r == VXS_OK && c->against_path) r = bench_against(to, c->now, c->before, c->against_path, c->max_slower, &c->too_slow, m);
    if (r == VXS_OK && c->too_slow && to)
        fprintf(to, "%zu of these times are more than %g times what they were; %s\n", c->too_slow, c->max_slower,
                colored(word, m->color, to, COLOR_RED, "FAILED"));
    m->wrong = c->outputs_differ || c->too_slow;
    json_decref(c->now);
    json_decref(c->before);
    return r;
}

/* Values of swept options are texts here; bake's own parser reads them later. */
static option swept(bench_command *c, int n, const char *name, const char *value, const char *help)
{
    c->o.sweep_name[n] = name;
    return (option){name, OPTION_TEXTS, &c->o.sweep_value[n], 0, 0, NULL, value, help, NULL};
}

int cmd_bench(int argc, char **argv)
{
    bench_command c         = {.o = {.runs = 5, .points = 100000}, .max_slower = INFINITY};
    const option  options[] = {
         {"SCENE", OPTION_INPUTS, &c.o.scenes, FILE_SCENE, 0, NULL, NULL, "glTF 2.0 scenes, .gltf or .glb", NULL},
         {"-o", OPTION_OUTPUT, &c.output_path, 1, 0, ".json", "FILE.json", "where the measurements go; - is standard output", NULL},
         swept(&c, 0, "--resolution", "[NAME=]N", "texels a side of the map, of light NAME or of all others (default 4096)"),
         swept(&c, 1, "--coding", CODING_CHOICES, "how maps are kept (default blocks)"),
         swept(&c, 2, "--pack", PACK_CHOICES, "how pages of palette blocks are stored (default small)"),
         swept(&c, 3, "--exit", EXIT_CHOICES, "exit depth of solids (default auto)"),
         swept(&c, 4, "--closed", CLOSED_CHOICES, "which components are solids (default auto)"),
         swept(&c, 5, "--threads", "N", "threads of the bake (default all processors)"),
         swept(&c, 6, "--level", "L", "zstd level of the file (default 12)"),
         swept(&c, 7, "--skinned", SKINNED_CHOICES, "skinned meshes (default exclude)"),
         swept(&c, 8, "--maps", MAPS_CHOICES, "where depths come from (default auto)"),
         swept(&c, 9, "--blend", BLEND_CHOICES, "materials of alphaMode BLEND (default mask)"),
         {"--filter", OPTION_U32S, &c.filters, 1, VXS_FILTER_MAX, NULL, "K",
          "K x K box filters to look up, besides single taps; K odd, 1 to 17 texels (default single taps only)", NULL},
         {"--smooth", OPTION_U32S, &c.smooth, 1, VXS_FILTER_MAX, NULL, "K",
          "smooth K x K filters to look up, too; K even or odd, 1 to 17 texels", NULL},
         {"--light", OPTION_TEXTS, &c.o.light_names, 0, 0, NULL, "NAME",
          "bake this light, or all that a pattern names, in all scenes (default all lights)", NULL},
         {"--sun", OPTION_TEXTS, &c.o.suns, 0, 0, NULL, "[NAME=]X,Y,Z",
          "add a light that travels this way, named sun or NAME, to all scenes; repeat for more", NULL},
         {"--region", OPTION_TEXT, &c.o.region, 0, 0, NULL, "MIN,MAX",
          "x,y,z,x,y,z of the box that will be looked up, metres (default all casters)", NULL},
         {"--scene", OPTION_TEXT, &c.o.scene_name, 0, 0, NULL, "NAME", "name or index of the glTF scene (default the file's)", NULL},
         {"--exclude", OPTION_TEXTS, &c.o.exclude, 0, 0, NULL, "PATTERN",
          "nodes, meshes or materials that cast no shadow, of all scenes; repeat for more", NULL},
         {"--include", OPTION_TEXTS, &c.o.include, 0, 0, NULL, "PATTERN",
          "only these cast, less what --exclude names; repeat for more (default all)", NULL},
         {"--allow-outside", OPTION_SWITCH, &c.o.allow_outside, 0, 0, NULL, NULL,
          "read buffers and images that lie outside of their scene's folder", NULL},
         {"--runs", OPTION_U32, &c.o.runs, 1, BENCH_RUNS_MAX, NULL, "N", "how often everything is measured, 1 to 1000 (default 5)",
          NULL},
         {"--points", OPTION_U32, &c.o.points, 0, 1e9, NULL, "N",
          "points of each kind that errors are measured at; 0: neither errors nor lookups (default 100000)", NULL},
         {"--against", OPTION_INPUT, &c.against_path, FILE_JSON, 0, NULL, "OLD.json", "say what moved since these measurements",
          NULL},
         {"--max-slower", OPTION_F64, &c.max_slower, 1, 1e6, NULL, "F",
          "with --against: exit status 1 when a time is more than F times what it was", &c.max_slower_given},
         {NULL, OPTION_GROUP, NULL, 0, 0, NULL, NULL, "steps of a DAG, with --coding dag alone", NULL},
         swept(&c, 10, "--rule", RULE_CHOICES, "undefined voxels (default greedy)"),
         swept(&c, 11, "--reuse", REUSE_CHOICES, "insertion refers to an equal neighbour (default on)"),
         swept(&c, 12, "--compress", COMPRESS_CHOICES, "order of sub-DAG compression (default auto)"),
         swept(&c, 13, "--stop", STOP_CHOICES, "after insertion, sub-DAG compression, or the merge (default final)"),
    };
    const command_line line =
        COMMAND_LINE("bench", "SCENE... -o FILE.json [options]",
                     "Measure bakes and lookups of scenes: time, memory, size, error. Options of bake may be repeated: what is "
                     "measured is every combination of their values.",
                     options);
    return command_run(&line, argc, argv, run, &c);
}
