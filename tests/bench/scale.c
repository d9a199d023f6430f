/* scale: how the time and memory of a map's DAG grow with the map, from formulas and without OpenGL.
 *
 *     scale [--runs N] [--threads N] [--largest N] [--json FILE]
 *
 * A box and a sphere (tests/columns/analytic.h) in maps from 16384 texels a side, doubling up to --largest. Each cell is built
 * --runs times, the cells in turn; medians are printed, and go to FILE as JSON (docs/scale.schema.json).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/spread.h"
#include "baker/base/version.h"
#include "baker/coding/dag/build.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "tests/columns/analytic.h"

enum { SMALLEST_PX = 16384, LARGEST_PX = 262144, SIZES_MAX = 5, RUNS_MAX = 99 };

static const char *const shape_names[] = {"box", "sphere"};
enum { SHAPES = sizeof shape_names / sizeof *shape_names };

/* A shape in a map of one size. */
typedef struct cell {
    double   seconds[RUNS_MAX];
    uint64_t peak_bytes; /* of the process above what it held before; the most of all runs */
    uint64_t calls, tiles, nodes, masks;
} cell;

static vxs_result build_once(cell *c, int shape, uint32_t side_px, uint32_t threads, uint32_t run, run_context *m)
{
    analytic      a      = analytic_shape((analytic_kind)shape, side_px);
    bake_context  ctx    = {.run = m, .threads = threads};
    build_options o      = {.rule = MASK_RULE_GREEDY, .reuse = 1, .share = 1};
    build_stats   stats  = {0};
    column_source source = analytic_source(&a);
    column_map    map;
    dag_merger    g;
    dag           d = {0};
    vxs_result    r;
    memory_peak_reset();
    uint64_t held = memory_peak_bytes();
    double   from = clock_seconds();
    if ((r = dag_merger_init(&g, side_px, 1, 1)) != VXS_OK) return fail(m, r, "out of memory");
    if ((r = source.open(source.data, 0, &map, &ctx)) == VXS_OK) {
        r = dag_build_map(&g, 0, &map, &o, &stats, &ctx);
        map.close(map.data);
    }
    if (r == VXS_OK) r = dag_merger_finish(&g, &d);
    c->seconds[run] = clock_seconds() - from;
    uint64_t peak   = ctx.peak_bytes > memory_peak_bytes() ? ctx.peak_bytes : memory_peak_bytes();
    if (peak > held && peak - held > c->peak_bytes) c->peak_bytes = peak - held;
    c->calls = atomic_load(&a.calls);
    c->tiles = atomic_load(&a.tile_calls);
    c->nodes = dag_node_count(&d);
    c->masks = d.mask_count;
    dag_merger_free(&g);
    dag_free(&d);
    return r == VXS_OK ? r : fail(m, r, "the DAG of %u x %u texels cannot be built", side_px, side_px);
}

/* Print a cell, and add it to an array. */
static void print_cell(json_t *cells, cell *c, int shape, uint32_t side_px, uint32_t runs)
{
    spread s = spread_of(c->seconds, runs);
    printf("%-6s %7u %9.1f ms (%.1f to %.1f) %9.2f MiB %9llu calls %8llu tiles %8llu nodes %8llu masks\n", shape_names[shape],
           side_px, 1e3 * s.median, 1e3 * s.min, 1e3 * s.max, (double)c->peak_bytes / (1 << 20), (unsigned long long)c->calls,
           (unsigned long long)c->tiles, (unsigned long long)c->nodes, (unsigned long long)c->masks);
    json_array_append_new(cells, json_pack("{s:s, s:I, s:{s:f, s:f, s:f}, s:I, s:I, s:I, s:I, s:I}", "shape", shape_names[shape],
                                           "resolution_px", (json_int_t)side_px, "seconds", "median", s.median, "min", s.min, "max",
                                           s.max, "peak_bytes", (json_int_t)c->peak_bytes, "calls", (json_int_t)c->calls, "tiles",
                                           (json_int_t)c->tiles, "nodes", (json_int_t)c->nodes, "masks", (json_int_t)c->masks));
}

int main(int argc, char **argv)
{
    uint32_t     runs = 5, threads = parallel_default_threads(), largest_px = LARGEST_PX;
    const char  *json_path = NULL;
    const option options[] = {
        {"--runs", OPTION_U32, &runs, 1, RUNS_MAX, NULL, "N", "of each cell (default 5)", NULL},
        {"--threads", OPTION_U32, &threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default: all)", NULL},
        {"--largest", OPTION_U32, &largest_px, SMALLEST_PX, LARGEST_PX, NULL, "N",
         "texels a side of the largest map (default 262144)", NULL},
        {"--json", OPTION_OUTPUT, &json_path, 0, 0, ".json", "FILE", "the figures as JSON", NULL}};
    const command_line line = COMMAND_LINE("scale", "[options]", "Time and memory of maps from formulas.", options);
    run_context        m    = {0};
    int                help_shown;
    vxs_result         r     = options_parse(&line, argc, argv, &help_shown, &m);
    cell              *cells = calloc(SHAPES * SIZES_MAX, sizeof *cells);
    if (r != VXS_OK || help_shown || !cells) goto done;

    for (uint32_t run = 0; run < runs && r == VXS_OK; run++)
        for (int n = 0; n < SHAPES * SIZES_MAX && r == VXS_OK; n++) {
            uint32_t side_px = (uint32_t)SMALLEST_PX << n % SIZES_MAX;
            if (side_px <= largest_px) r = build_once(&cells[n], n / SIZES_MAX, side_px, threads, run, &m);
        }
    json_t *printed = json_array();
    for (int n = 0; n < SHAPES * SIZES_MAX && r == VXS_OK; n++)
        if ((uint32_t)SMALLEST_PX << n % SIZES_MAX <= largest_px)
            print_cell(printed, &cells[n], n / SIZES_MAX, (uint32_t)SMALLEST_PX << n % SIZES_MAX, runs);
    json_t *root = json_pack("{s:s, s:I, s:I, s:o}", "vxs", VXS_VERSION, "threads", (json_int_t)threads, "runs", (json_int_t)runs,
                             "cells", printed);
    if (r == VXS_OK && json_path)
        r = json_write(json_path, root, &m);
    else
        json_decref(root);
done:
    free(cells);
    return command_end(&m, r);
}
