/* Threads, locks and signals of the baker. Together with parallel.h this is the only place that depends on a thread library.
 *
 * runtime/platform.h has os_mutex, os_signal and os_thread. Built with `make threads=1` there are no threads: os_thread_start
 * fails, locks do nothing, and no thread library is linked. Atomics of C11 need none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THREADS_H
#define THREADS_H

#include <signal.h>
#include <stddef.h>

#include "runtime/platform.h"

#ifdef __cplusplus
extern "C" {
#endif

/* 0: no thread can be started that outlives a loop. Built with threads=1, or WebAssembly (baker/web/threads_web.c). */
#if defined(VXS_ONE_THREAD) || defined(__wasm__)
enum { HAS_THREADS = 0 };
#else
enum { HAS_THREADS = 1 };
#endif

/* Wait like os_wait, at most until clock_seconds() is `until`. Returns 0 when it is later. */
int threads_wait_until(os_signal *s, os_mutex *m, double until);

/* Block all signals in the calling thread, and in threads that it starts from now on. threads_unblock_signals(&before) restores the
 * old set. */
void threads_block_signals(sigset_t *before);
void threads_unblock_signals(const sigset_t *before);

/* Set the default stack size of threads, including those of libraries, to `bytes` if it is smaller than `least`. */
void threads_set_stacks(size_t least, size_t bytes);

/* Run run(work) on a thread with a stack of so many bytes, and wait for its end; the new thread handles the signals. Returns 0, and
 * runs nothing, when there is no such thread. */
int threads_run_on_stack(size_t bytes, void *(*run)(void *work), void *work);

#ifdef __cplusplus
}
#endif
#endif
