/* A loop over [0, count) shared by threads.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PARALLEL_H
#define PARALLEL_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* More threads than this are never started by one loop. */
#define PARALLEL_THREADS_MAX 256

/* Call body(user, begin, end, worker) until its ranges have covered [0, count) once, each at most `grain` long.
 * threads  at most this many ranges are in work at once; 0 and 1 mean the caller alone, PARALLEL_THREADS_MAX is the most
 * grain    items handed out at a time; 0 means 1
 * worker   in [0, threads), never two at once with the same number: an index into scratch memory of each worker
 * Which worker gets which range is left to chance, where ranges begin is not: every begin is a multiple of grain. For the
 * same result at any thread count, body writes only to slots named by item, never by worker or by order of arrival. Runs in
 * the caller alone when count <= grain. A thread that cannot be started leaves its work to the others, so this never fails.
 * Returns when all work is done and seen by the caller. Loops may be nested, and run from several threads at once.
 * Between ranges the threads call run_control_wait for the caller's run (run_control.h): the caller holds no lock that body takes. */
void parallel_for(uint32_t threads, size_t count, size_t grain, void (*body)(void *user, size_t begin, size_t end, uint32_t worker),
                  void *user);

/* The same for formats/ and runtime/, which start no threads: a loop that is theirs to call. */
vxs_parallel parallel_lent(uint32_t threads);

/* The processors that this process may run on, at least 1 and at most PARALLEL_THREADS_MAX. */
uint32_t parallel_default_threads(void);

#ifdef __cplusplus
}
#endif
#endif
