/* Parallel loop over [0, count).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PARALLEL_H
#define PARALLEL_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Upper limit of the threads of one loop. */
#define PARALLEL_THREADS_MAX 256

/* Threads that wait for the next loop between loops, so that a loop need not start its own: starting one takes longer than many
 * loops. They are started by the loops that need them. */
typedef struct thread_pool thread_pool;

/* Let the loops of the calling thread, and loops inside them, share a pool until parallel_end_threads, which the same thread calls.
 * Returns NULL, and changes nothing, if the thread has a pool or there is no memory. A child of a fork must not use its parent's. */
thread_pool *parallel_keep_threads(void);

/* Accepts NULL. */
void parallel_end_threads(thread_pool *pool);

/* Call body(user, begin, end, worker) for ranges that cover [0, count) exactly once.
 * threads  at most this many ranges run at once; 0 and 1: only the calling thread; at most PARALLEL_THREADS_MAX
 * grain    maximum length of a range; 0 means 1
 * worker   in [0, threads); no two threads share a number at once: an index into scratch memory of each worker
 * The assignment of ranges to workers is random. Each `begin` is a multiple of grain. To be independent of the number of threads,
 * body must write only to slots indexed by item, never by worker or by order of execution. With count <= grain the loop runs in the
 * caller. If a thread cannot be started, the others do its work: the loop never fails.
 * Returns when all work is done and visible to the caller. Loops may be nested, and run from several threads at once.
 * Between ranges the threads call run_control_wait for the caller's run (run_control.h). So the caller must hold no lock that body
 * takes. */
void parallel_for(uint32_t threads, size_t count, size_t grain, void (*body)(void *user, size_t begin, size_t end, uint32_t worker),
                  void *user);

/* The same loop as a callback for formats/ and runtime/, which start no threads themselves. */
vxs_parallel parallel_lent(uint32_t threads);

/* Number of processors available to this process, [1, PARALLEL_THREADS_MAX]. */
uint32_t parallel_default_threads(void);

#ifdef __cplusplus
}
#endif
#endif
