/* A cell of a measurement: a scene with one combination of options, in the form of docs/bench.schema.json.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_CELL_H
#define BENCH_CELL_H

#include "baker/lab/bench/bench_json.h"

/* The cell of one run; single numbers where bench_cell_of_runs puts spreads. NULL when out of memory.
 * cell          has its "scene" and "options"
 * bake          the JSON of `vxs bake --json` (docs/bake-report.schema.json)
 * compare       the JSON of `vxs compare --json` (docs/compare.schema.json); NULL: no comparison
 * wall_seconds  of the whole process of the bake */
json_t *bench_cell_of_run(const json_t *cell, const json_t *bake, const json_t *compare, double wall_seconds);

/* Combine the runs of one cell: times become spreads, peaks their maximum; all other values are the same in all runs. NULL when
 * out of memory.
 * runs  an array of at most BENCH_RUNS_MAX; released */
json_t *bench_cell_of_runs(json_t *runs);

#endif
