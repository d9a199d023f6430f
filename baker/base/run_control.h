/* Pause, resume and cancel the threads of a run.
 *
 *     run_control_enter(&g);              // the thread works for this run; waits while the run is paused
 *     for (...) { run_control_wait(); ... }
 *     run_control_leave(&g);
 *
 * Parallel loops (parallel.h) call run_control_wait between chunks; their threads belong to the run of the thread that started
 * them. Single-threaded work of milliseconds calls it itself, but never while it holds a lock. In a thread without a run all calls
 * do nothing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RUN_CONTROL_H
#define RUN_CONTROL_H

#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include "baker/base/threads.h"

typedef struct run_control {
    atomic_int is_paused, is_cancelled;
    os_mutex   lock;
    os_signal  resumed, still;
    uint32_t   at_work; /* threads between enter and leave that are not waiting */
} run_control;

/* Initialize a run: not paused, not cancelled. */
void run_control_init(run_control *g);
void run_control_free(run_control *g);

/* Run of the calling thread; NULL: none. */
run_control *run_control_current(void);

/* The calling thread starts or resumes work for a run. Waits while the run is paused. NULL: does nothing. */
void run_control_enter(run_control *g);

/* The calling thread ends its work, or is about to wait for other threads of the same run. NULL: does nothing. */
void run_control_leave(run_control *g);

/* Wait while the run of the calling thread is paused. Costs a few nanoseconds otherwise. */
void run_control_wait(void);

/* The same, at every items-th step n of a loop. `items` is a power of two. */
static inline void run_control_wait_each(size_t items, size_t n)
{
    if (!(n & (items - 1))) run_control_wait();
}

/* 1 when the run of the calling thread is cancelled. */
int run_control_is_cancelled(void);

void run_control_resume(run_control *g);

/* Pause. Returns when no thread is working any more. */
void run_control_pause(run_control *g);

/* Cancel. A paused run stays paused, and ends after run_control_resume. */
void run_control_cancel(run_control *g);

#endif
