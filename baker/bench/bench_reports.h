/* What a child reports, as samples and figures of a cell.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_REPORTS_H
#define BENCH_REPORTS_H

#include "baker/bench/bench_jobs.h"

/* Take what `vxs bake --json` wrote (docs/bake-report.schema.json): samples of run `run` of `runs`, and what is the same in all.
 * machine  gets its renderer
 * Returns VXS_OK, VXS_E_READ, VXS_E_MEMORY. */
vxs_result bench_take_bake(bench_job *job, uint32_t run, uint32_t runs, const char *path, bench_machine *machine, message *m);

/* The same of `vxs compare --json` (docs/compare.schema.json). */
vxs_result bench_take_compare(bench_job *job, uint32_t run, uint32_t runs, const char *path, message *m);

#endif
