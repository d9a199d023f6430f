/* A cell of a measurement: a scene with one combination of options, in the form of docs/bench.schema.json.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_CELL_H
#define BENCH_CELL_H

#include "baker/lab/bench/bench_json.h"

/* A cell of one run, with a number where a spread will be. NULL without memory.
 * cell          has its "scene" and "options"
 * bake          what `vxs bake --json` wrote (docs/bake-report.schema.json)
 * compare       what `vxs compare --json` wrote (docs/compare.schema.json); NULL: nothing was compared
 * wall_seconds  of the whole process of the bake */
json_t *bench_cell_of_run(const json_t *cell, const json_t *bake, const json_t *compare, double wall_seconds);

/* What runs of one cell come to: times spread, of peaks the greatest counts, all else is the same in all. NULL without memory.
 * runs  an array of at most BENCH_RUNS_MAX; released */
json_t *bench_cell_of_runs(json_t *runs);

#endif
