/* Parallel loop over pieces of work that may warn or fail, as if they ran one after another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PARALLEL_RUNS_H
#define PARALLEL_RUNS_H

#include "baker/base/run_context.h"

/* Call body(user, n, worker, own) for all n in [0, count), as parallel_for does with a grain of 1.
 * own  run context for the messages of piece n. Their order in m is that of the pieces, and nothing is added of pieces behind the
 *      first that fails. With one thread it is m
 * Returns VXS_OK, or the result of the first piece that fails; VXS_E_MEMORY. */
vxs_result parallel_runs(uint32_t threads, size_t                                                           count,
                         vxs_result (*body)(void *user, size_t n, uint32_t worker, run_context *own), void *user, run_context *m);

#endif
