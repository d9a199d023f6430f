/* A gate before the threads of a run; see gate.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/gate.h"

/* What a thread stands before is the thread's own: loops hand it to the threads that they start. */
static _Thread_local gate *here;

void gate_init(gate *g)
{
    atomic_init(&g->is_shut, 0);
    atomic_init(&g->is_cancelled, 0);
    pthread_mutex_init(&g->lock, NULL);
    pthread_cond_init(&g->opened, NULL);
    pthread_cond_init(&g->still, NULL);
    g->at_work = 0;
}

void gate_free(gate *g)
{
    pthread_cond_destroy(&g->still);
    pthread_cond_destroy(&g->opened);
    pthread_mutex_destroy(&g->lock);
}

gate *gate_here(void)
{
    return here;
}

static void begin(gate *g)
{
    while (atomic_load(&g->is_shut)) pthread_cond_wait(&g->opened, &g->lock);
    g->at_work++;
}

static void end(gate *g)
{
    if (!--g->at_work) pthread_cond_broadcast(&g->still);
}

void gate_enter(gate *g)
{
    if (!g) return;
    here = g;
    pthread_mutex_lock(&g->lock);
    begin(g);
    pthread_mutex_unlock(&g->lock);
}

void gate_leave(gate *g)
{
    if (!g) return;
    pthread_mutex_lock(&g->lock);
    end(g);
    pthread_mutex_unlock(&g->lock);
    here = NULL;
}

void gate_pass(void)
{
    gate *g = here;
    if (!g || !atomic_load_explicit(&g->is_shut, memory_order_relaxed)) return;
    pthread_mutex_lock(&g->lock);
    end(g);
    begin(g);
    pthread_mutex_unlock(&g->lock);
}

int gate_is_cancelled(void)
{
    return here && atomic_load(&here->is_cancelled);
}

void gate_open(gate *g)
{
    pthread_mutex_lock(&g->lock);
    atomic_store(&g->is_shut, 0);
    pthread_cond_broadcast(&g->opened);
    pthread_mutex_unlock(&g->lock);
}

void gate_shut(gate *g)
{
    pthread_mutex_lock(&g->lock);
    atomic_store(&g->is_shut, 1);
    while (g->at_work) pthread_cond_wait(&g->still, &g->lock);
    pthread_mutex_unlock(&g->lock);
}

void gate_cancel(gate *g)
{
    atomic_store(&g->is_cancelled, 1);
}
