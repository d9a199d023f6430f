/* Parallel loop over pieces of work that may warn or fail, as if they ran one after another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PARALLEL_RUNS_H
#define PARALLEL_RUNS_H

#include "baker/base/run_context.h"

/* Piece n of the work.   own  run context for its messages */
typedef vxs_result run_piece(void *user, size_t n, uint32_t worker, run_context *own);

/* Call run(user, n, worker, own) for all n in [0, count), as parallel_for does with a grain of 1. The order of messages in m is that
 * of the pieces, and nothing is added of pieces behind the first that fails. With one thread `own` is m.
 * Returns VXS_OK, or the result of the first piece that fails; VXS_E_MEMORY. */
vxs_result parallel_runs(uint32_t threads, size_t count, run_piece *run, void *user, run_context *m);

#endif
