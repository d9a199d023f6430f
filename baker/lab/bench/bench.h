/* Measure bakes and lookups: each scene with each combination of options (a cell).
 *
 * Every bake and every comparison is a process of its own, so that its time and memory are those of `vxs bake` and `vxs
 * compare`. Each round runs all cells once, so that a slow minute of the machine affects all cells alike.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_H
#define BENCH_H

#include "baker/lab/bench/bench_jobs.h"

/* Measure.
 * result           [out] JSON as in docs/bench.schema.json; NULL on failure; released with json_decref
 * outputs_differ   [out] 1: it failed because two runs of a cell made different bytes
 * Returns VXS_OK; VXS_E_ARGUMENT when options are wrong or two cells the same, before anything is measured; the result of a bake
 * or comparison that failed; VXS_E_WRITE, VXS_E_MEMORY. After a signal that ends runs, it first ends its children and removes
 * its folder; then the signal ends the process.
 * Threads: only in a process of one thread. */
vxs_result bench_run(const bench_options *o, json_t **result, int *outputs_differ, message *m);

#endif
