/* The command line of bake and plan; see bake_arguments.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/bake_arguments.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "baker/bake/cache/cache_folder.h"
#include "baker/bake/cache/part_file.h"
#include "baker/base/parallel.h"
#include "baker/command/options/laboratory.h"
#include "baker/command/options/options.h"
#include "baker/files/input_file.h"

static vxs_result check_map_sizes(bake_options *o, run_context *m)
{
    for (const named_value *v = o->resolutions.items; v < o->resolutions.items + o->resolutions.count; v++) {
        uint32_t side = (uint32_t)v->numbers[0];
        if (side & (side - 1))
            return fail(m, VXS_E_ARGUMENT, "--resolution %s%s%u: expected a power of two from %d to %d", v->name ? v->name : "",
                        v->name ? "=" : "", side, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX);
        if (!named_find(&o->texels, v->name)) continue;
        if (!v->name)
            return fail(
                m, VXS_E_ARGUMENT,
                "--resolution and --texel exclude each other: expected one of them, or a name before one: --texel NAME=METRES");
        return fail(m, VXS_E_ARGUMENT, "--resolution %s=%u and --texel %s=%g exclude each other: expected one of them", v->name,
                    side, v->name, named_find(&o->texels, v->name)->numbers[0]);
    }
    const named_value *resolution = named_find(&o->resolutions, NULL), *texel = named_find(&o->texels, NULL);
    if (resolution) o->resolution = (uint32_t)resolution->numbers[0];
    if (texel) {
        o->resolution   = 0;
        o->texel_metres = texel->numbers[0];
    }
    return VXS_OK;
}

/* Render depth maps when --maps or --gl requires it. */
static vxs_result choose_maps(bake_arguments *a, run_context *m)
{
    int wanted = a->o.gl != GL_BACKEND_OSMESA;
    if (a->o.maps == MAPS_AUTO) a->o.maps = wanted ? MAPS_GL : MAPS_SPARSE;
    if (a->o.maps == MAPS_GL && leaves_more_free(&a->o))
        return fail(m, VXS_E_ARGUMENT, "%s needs what lies behind surfaces, which depth maps do not show: expected --maps sparse%s",
                    a->o.behind == BEHIND_FREE ? "--behind free" : "--thickness", wanted ? ", and no --gl" : "");
    return VXS_OK;
}

/* "3/8" */
static vxs_result read_part(bake_arguments *a, run_context *m)
{
    unsigned number, parts;
    char     rest;
    if (!a->part) return VXS_OK;
    if (strspn(a->part, "0123456789/") != strlen(a->part) || sscanf(a->part, "%6u/%6u%c", &number, &parts, &rest) != 2 || !number ||
        number > parts || parts > PARTS_MAX)
        return fail(m, VXS_E_ARGUMENT,
                    "--part %s: expected I/N, the number of a part and how many there are, 1/N to N/N, N at most %d", a->part,
                    PARTS_MAX);
    a->o.part  = number;
    a->o.parts = parts;
    return VXS_OK;
}

/* The extension of the output must match: .part with --part, else .vxs. */
static vxs_result check_part_name(const bake_options *o, run_context *m)
{
    const char *dot = o->output_path ? strrchr(o->output_path, '.') : NULL;
    if (o->parts && dot && !strcasecmp(dot, ".vxs"))
        return fail(m, VXS_E_ARGUMENT, "-o %s: with --part, what is written is a part, .part, of which vxs merge makes a .vxs file",
                    o->output_path);
    if (!o->parts && dot && !strcasecmp(dot, ".part"))
        return fail(m, VXS_E_ARGUMENT, "-o %s: '.part' is the extension of other files: what is written is .vxs", o->output_path);
    return VXS_OK;
}

/* Conflicts of options that store or share squares. Such a run does not make every square, so options that need all are refused. */
static vxs_result check_stored(const bake_arguments *a, run_context *m)
{
    const char *given = a->o.resume_path ? "--resume" : a->o.parts ? "--part" : "several processes";
    const char *why   = a->o.page_path                                         ? "--report draws depth maps"
                        : a->o.coding == CODING_DAG && a->o.stop != STOP_FINAL ? "--stop leaves nodes where they were made"
                                                                               : NULL;
    if (stores_squares(&a->o) && why)
        return fail(m, VXS_E_ARGUMENT, "%s, and with %s not every square is made: expected one of them", why, given);
    if (a->o.others && a->o.parts)
        return fail(m, VXS_E_ARGUMENT,
                    "--part makes a part of a bake, and several processes share all of it: expected one of them");
    if (a->o.others && is_standard_input(a->o.scene_path))
        return fail(m, VXS_E_ARGUMENT, "several processes read the scene, and standard input is read once: expected a file");
    if (a->o.parts && a->o.if_changed)
        return fail(m, VXS_E_ARGUMENT, "--if-changed looks into an asset, and --part writes none: expected one of them");
    return VXS_OK;
}

vxs_result bake_arguments_check(bake_arguments *a, run_context *m)
{
    bake_options *o = &a->o;
    vxs_result    r = check_map_sizes(o, m);
    if (r == VXS_OK) r = choose_maps(a, m);
    if (r == VXS_OK) r = read_part(a, m);
    if (r == VXS_OK) r = check_stored(a, m);
    if (r == VXS_OK) r = check_part_name(o, m);
    if (r != VXS_OK) return r;

    uint32_t side = a->o.smoke.side_px;
    if (a->smoke_given && !bakes_smoke(&a->o))
        return fail(m, VXS_E_ARGUMENT,
                    "--smoke-extinction, --smoke-side, --smoke-nodes and --smoke-error say how smoke is baked: they need --smoke "
                    "or --scene-smoke on");
    if (side & (side - 1)) return fail(m, VXS_E_ARGUMENT, "--smoke-side %u: expected a power of two from 8 to 8192", side);
    if (bakes_smoke(&a->o) && a->o.parts)
        return fail(
            m, VXS_E_ARGUMENT,
            "smoke is baked into a whole asset, and --part makes a part of it: expected --part, or --smoke and --scene-smoke");

    if (o->page_path && !linked_laboratory.pages)
        return fail(m, VXS_E_ARGUMENT, "--report %s: this program was built without pages (make core=1): expected --json",
                    o->page_path);
    if (o->coding != CODING_DAG && a->dag_step_given)
        return fail(m, VXS_E_ARGUMENT, "--rule, --reuse, --compress and --stop are steps of a DAG: they need --coding dag");
    if (o->points && o->parts)
        return fail(m, VXS_E_ARGUMENT, "--points is of a whole asset, and --part makes a part of one: expected one of them");
    if (o->coding == CODING_DAG && a->pack_given)
        return fail(m, VXS_E_ARGUMENT, "--pack is of the pages of palette blocks: it needs --coding blocks");
    for (int axis = 0; axis < 3 && o->region_given; axis++)
        if (!(o->region_ws[axis] < o->region_ws[axis + 3]))
            return fail(m, VXS_E_ARGUMENT, "--region: the minimum must be less than the maximum, but is %g and %g on axis %c",
                        o->region_ws[axis], o->region_ws[axis + 3], "xyz"[axis]);
    if (o->if_changed && (!o->output_path || is_standard_output(o->output_path)))
        return fail(m, VXS_E_ARGUMENT, "--if-changed needs -o OUT.vxs: there is no older asset on standard output");
    if (o->if_changed && is_standard_output(o->page_path))
        return fail(m, VXS_E_ARGUMENT, "--if-changed and --report - exclude each other: a page is made of a bake");
    if (o->page_path && access(o->page_path, F_OK))
        o->if_changed = 0; /* without a page, bake even if unchanged: the page is
                              made from a bake */
    return o->if_changed ? VXS_OK : bake_check_outputs(o, m);
}

void bake_arguments_init(bake_arguments *a, const char *name, const char *synopsis, const char *summary, int output_needed)
{
    memset(a, 0, sizeof *a);
    a->o                   = (bake_options){.resolution   = 4096,
                                            .coding       = CODING_BLOCKS,
                                            .reuse        = 1,
                                            .stop         = STOP_FINAL,
                                            .renderer     = linked_laboratory.renderer,
                                            .zstd_level   = 12,
                                            .threads      = parallel_default_threads(),
                                            .smoke        = {.nodes = 8, .error = 0.005},
                                            .smoke_factor = 1};
    const option options[] = {
        {"SCENE", OPTION_INPUT, &a->o.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
        {"-o", OPTION_OUTPUT, &a->o.output_path, output_needed, OUTPUT_CHECKED_BY_COMMAND, ".vxs|.part", "OUT.vxs",
         "where the asset goes; - is standard output", NULL},
        {"--if-changed", OPTION_SWITCH, &a->o.if_changed, 0, 0, NULL, NULL,
         "do nothing when OUT.vxs is sound, and was baked from the same scene, lights and options by this version", NULL},
        {"--resume", OPTION_FOLDER, &a->o.resume_path, 0, 0, CACHE_FOLDER_NAMES, "DIR",
         "keep finished squares of the maps in this folder, and take from there what is finished: after a kill, or a change of the "
         "scene",
         NULL},
        {"--watch", OPTION_SWITCH, &a->watch, 0, 0, NULL, NULL,
         "bake, and again whenever SCENE or a file that it names has changed, until interrupted; best with --resume", NULL},
        {"--part", OPTION_TEXT, &a->part, 0, 0, NULL, "I/N",
         "make every N-th square of the maps, from the I-th on, and write a part, of which vxs merge makes the asset", NULL},
        {"--light", OPTION_TEXTS, &a->o.light_names, 0, 0, NULL, "NAME",
         "bake this light, or all that a pattern names, as lamp*; repeat for more (default all lights)", NULL},
        {"--sun", OPTION_NAMED_VECTOR, &a->o.suns, 0, 3, SUN_NAME, "[NAME=]X,Y,Z",
         "add a light that travels this way, named sun or NAME; repeat for more", NULL},
        {"--resolution", OPTION_NAMED_U32, &a->o.resolutions, RESOLUTION_MIN_PX, RESOLUTION_MAX_PX, NULL, "[NAME=]N",
         "texels a side of the map, of light NAME or of all others, a power of two, 8 to 262144, or 4K for 4096 (default 4096)",
         NULL},
        {"--texel", OPTION_NAMED_F64, &a->o.texels, 1e-9, 1e9, NULL, "[NAME=]METRES",
         "side of a texel, of light NAME or of all others; the resolution follows from it (default from --resolution)", NULL},
        {"--region", OPTION_VECTOR, a->o.region_ws, 0, 6, NULL, "MIN,MAX",
         "x,y,z,x,y,z of the box that will be looked up, metres (default all casters)", &a->o.region_given},
        SCENE_ROWS(a->o.scene),
        {"--smoke", OPTION_INPUT, &a->o.smoke_path, FILE_UNKNOWN, 0, NULL, "SMOKE.nrrd",
         "a grid of extinction, in world space: what it leaves of each light is baked, too", NULL},
        {"--scene-smoke", OPTION_CHOICE, &a->o.scene_smoke, 0, 0, "off|on", NULL,
         "what the scene's own smoke leaves, points and lines with a radius and extinction, is baked, too (default off)", NULL},
        {"--smoke-extinction", OPTION_F64, &a->o.smoke_factor, 1e-9, 1e9, NULL, "N",
         "extinction per metre of what is 1 in the grid (default 1)", &a->smoke_given},
        {"--smoke-side", OPTION_U32, &a->o.smoke.side_px, 8, 8192, NULL, "N",
         "curves along a side of a light's map, a power of two, no more than the map has texels (default as close as samples of "
         "the grid, 64 to 1024)",
         &a->smoke_given},
        {"--smoke-nodes", OPTION_U32, &a->o.smoke.nodes, 4, VXS_SMOKE_NODES_MAX, NULL, "N",
         "nodes of a curve at most, 4 to 16 (default 8)", &a->smoke_given},
        {"--smoke-error", OPTION_F64, &a->o.smoke.error, 0, 1, NULL, "T",
         "nodes are added to a curve until its error, a share of the light, is at most this (default 0.005)", &a->smoke_given},
        {"--maps", OPTION_CHOICE, &a->o.maps, 0, 0, MAPS_CHOICES, NULL,
         "where depths come from: rendered with OpenGL, or straight from the triangles; auto: sparse, unless --gl "
         "is given (default auto)",
         NULL},
        {"--gl", OPTION_CHOICE, &a->o.gl, 0, 0, GL_CHOICES, NULL, "OpenGL by OSMesa, or by EGL for a GPU (default osmesa)", NULL},
        {"--exit", OPTION_CHOICE, &a->o.exit, 0, 0, EXIT_CHOICES, NULL,
         "exit depth of solids: peeled, or the nearest back face; auto: peeled where solids meet (default auto)", NULL},
        {"--behind", OPTION_CHOICE, &a->o.behind, 0, 0, BEHIND_CHOICES, NULL,
         "behind the last surface on a light's ray: shadow, or don't-care voxels, which make files smaller (default shadow)", NULL},
        {"--thickness", OPTION_F64, &a->o.thickness_metres, 1e-9, 1e9, NULL, "METRES",
         "thickness of single-sided sheets that face the light; it ends at the next surface (default none)", NULL},
        {"--closed", OPTION_CHOICE, &a->o.closed, 0, 0, CLOSED_CHOICES, NULL,
         "solids: by the rules, all that is closed, none (default auto)", NULL},
        {"--coding", OPTION_CHOICE, &a->o.coding, 0, 0, CODING_CHOICES, NULL,
         "how maps are kept: palette blocks, or a DAG as in older work, larger and slower to look up (default blocks)", NULL},
        {"--pack", OPTION_CHOICE, &a->o.pack, 0, 0, PACK_CHOICES, NULL,
         "pages of palette blocks: in the fewest bytes, or in more that open many times faster (default small)", &a->pack_given},
        {"--points", OPTION_U32, &a->o.points, 0, VXS_POINTS_MAX, NULL, "N",
         "points of what casts, for shadows of area lights, 0 to 4194304, 0: none (default 0)", NULL},
        {"--level", OPTION_U32, &a->o.zstd_level, 1, 19, NULL, "L", "zstd level of the file, 1 to 19 (default 12)", NULL},
        {"--threads", OPTION_U32, &a->o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N",
         "threads; never changes the bytes (default all processors)", NULL},
        {"--memory", OPTION_BYTES, &a->o.memory_bytes, 0, 0, NULL, "BYTES",
         "hold no more memory than this: 800M, 2G, or plain bytes (default as much as needed)", NULL},
        {"--report", OPTION_OUTPUT, &a->o.page_path, 0, OUTPUT_CHECKED_BY_COMMAND, ".html|.htm", "FILE.html",
         "a page with sizes, times, the plan and pictures of the maps; - is standard output", NULL},
        {"--json", OPTION_OUTPUT, &a->json_path, 0, 0, ".json", "FILE.json", "the report as JSON; - is standard output", NULL},
        {NULL, OPTION_GROUP, NULL, 0, 0, NULL, NULL, "steps of a DAG, with --coding dag alone", NULL},
        {"--rule", OPTION_CHOICE, &a->o.rule, 0, 0, RULE_CHOICES, NULL,
         "undefined voxels: fewest masks, or shadow as in older work (default greedy)", &a->dag_step_given},
        {"--reuse", OPTION_CHOICE, &a->o.reuse, 0, 0, REUSE_CHOICES, NULL,
         "insertion refers to an equal neighbour nearer the light (default on)", &a->dag_step_given},
        {"--compress", OPTION_CHOICE, &a->o.compress, 0, 0, COMPRESS_CHOICES, NULL,
         "order of sub-DAG compression; auto: top-down where it pays (default auto)", &a->dag_step_given},
        {"--stop", OPTION_CHOICE, &a->o.stop, 0, 0, STOP_CHOICES, NULL,
         "after insertion, sub-DAG compression, or the merge (default final)", &a->dag_step_given},
    };
    static_assert(sizeof options <= sizeof a->options, "the table has room for all");
    memcpy(a->options, options, sizeof options);
    a->line = (command_line){name, synopsis, summary, a->options, sizeof options / sizeof *options};
}
