/* A cell of a measurement: a scene with one combination of options, in the form of docs/bench.schema.json.
 *
 * While it is measured, a list of samples, one of each run, stands where a spread will be.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_CELL_H
#define BENCH_CELL_H

#include "baker/bench/bench_json.h"

/* A cell that nothing is known of yet. NULL without memory.
 * scene    a path, of which the last part is taken
 * options  released */
json_t *bench_cell_new(const char *scene_path, json_t *options);

/* Take in a run: what `vxs bake --json` wrote (docs/bake-report.schema.json), and how long the whole process took.
 * machine  gets its renderer
 * Returns VXS_OK, VXS_E_READ, VXS_E_MEMORY. */
vxs_result bench_cell_add_bake(json_t *cell, json_t *machine, const char *path, double wall_seconds, message *m);

/* The same of `vxs compare --json` (docs/compare.schema.json). */
vxs_result bench_cell_add_compare(json_t *cell, const char *path, message *m);

/* Samples become what they spread over. */
void bench_cell_finish(json_t *cell);

#endif
