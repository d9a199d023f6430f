/* Measuring bakes and lookups: what was measured, of each scene with each combination of options.
 *
 * Every bake and every comparison is a process of its own, so that its time and memory are those of `vxs bake` and `vxs compare`.
 * Runs go round by round over all cells: a slow minute of the machine lies on all of them, not on one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_H
#define BENCH_H

#include "baker/lab/bench/bench_jobs.h"

/* Measure.
 * result           [out] as docs/bench.schema.json has it; NULL on failure; released with json_decref
 * outputs_differ   [out] 1: it failed because two runs of a cell made different bytes
 * Returns VXS_OK; VXS_E_ARGUMENT when options are wrong or two cells the same, before anything is measured; what a bake or a
 * comparison failed with; VXS_E_WRITE, VXS_E_MEMORY. A signal that ends runs ends this one when
 * its children and its folder are gone.
 * Threads: only in a process of one thread. */
vxs_result bench_run(const bench_options *o, json_t **result, int *outputs_differ, message *m);

#endif
