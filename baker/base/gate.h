/* A gate that the threads of a run pass between pieces of its work. While it is shut they stand still before it; and who passes it learns that
 * the run is given up.
 *
 *     gate_enter(&g);              // this thread works behind the gate: waits until it is open
 *     for (...) { gate_pass(); ... }
 *     gate_leave(&g);
 *
 * Loops on threads (parallel.h) pass it between their chunks, and their threads stand before the gate of whoever started them. What takes
 * milliseconds on one thread passes it by itself, never while it holds a lock. A thread that has no gate passes everywhere.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GATE_H
#define GATE_H

#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

typedef struct gate {
    atomic_int      is_shut, is_cancelled;
    pthread_mutex_t lock;
    pthread_cond_t  opened, still;
    uint32_t        at_work; /* threads behind the gate */
} gate;

/* An open gate. */
void gate_init(gate *g);
void gate_free(gate *g);

/* The gate of the calling thread; NULL: it has none. */
gate *gate_here(void);

/* The calling thread begins to work, or goes on; NULL does nothing. */
void gate_enter(gate *g);

/* It ends, or waits for threads that work behind the same gate; NULL does nothing. */
void gate_leave(gate *g);

/* Wait while the gate of the calling thread is shut. A few nanoseconds when it is open. */
void gate_pass(void);

/* The same once in so many items of a loop, a power of two. */
static inline void gate_pass_each(size_t items, size_t n)
{
    if (!(n & (items - 1))) gate_pass();
}

/* 1 when the run of the calling thread is given up. */
int gate_is_cancelled(void);

void gate_open(gate *g);

/* Returns when no thread is at work any more. */
void gate_shut(gate *g);

/* Give the run up. The gate need not be open, and the run ends only behind it. */
void gate_cancel(gate *g);

#endif
