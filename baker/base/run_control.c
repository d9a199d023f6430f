/* Pause, resume and cancel the threads of a run; see run_control.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/run_control.h"

/* Each thread has its own current run. Parallel loops pass it to the threads that they start. */
static _Thread_local run_control *current;

void run_control_init(run_control *g)
{
    atomic_init(&g->is_paused, 0);
    atomic_init(&g->is_cancelled, 0);
    os_mutex_init(&g->lock);
    os_signal_init(&g->resumed);
    os_signal_init(&g->still);
    g->at_work = 0;
}

void run_control_free(run_control *g)
{
    os_signal_free(&g->still);
    os_signal_free(&g->resumed);
    os_mutex_free(&g->lock);
}

run_control *run_control_current(void)
{
    return current;
}

static void begin(run_control *g)
{
    while (atomic_load(&g->is_paused)) os_wait(&g->resumed, &g->lock);
    g->at_work++;
}

static void end(run_control *g)
{
    if (!--g->at_work) os_wake_all(&g->still);
}

void run_control_enter(run_control *g)
{
    if (!g) return;
    current = g;
    os_lock(&g->lock);
    begin(g);
    os_unlock(&g->lock);
}

void run_control_leave(run_control *g)
{
    if (!g) return;
    os_lock(&g->lock);
    end(g);
    os_unlock(&g->lock);
    current = NULL;
}

void run_control_wait(void)
{
    run_control *g = current;
    if (!g || !atomic_load_explicit(&g->is_paused, memory_order_relaxed)) return;
    os_lock(&g->lock);
    end(g);
    begin(g);
    os_unlock(&g->lock);
}

int run_control_is_cancelled(void)
{
    return current && atomic_load(&current->is_cancelled);
}

void run_control_resume(run_control *g)
{
    os_lock(&g->lock);
    atomic_store(&g->is_paused, 0);
    os_wake_all(&g->resumed);
    os_unlock(&g->lock);
}

void run_control_pause(run_control *g)
{
    os_lock(&g->lock);
    atomic_store(&g->is_paused, 1);
    while (g->at_work) os_wait(&g->still, &g->lock);
    os_unlock(&g->lock);
}

void run_control_cancel(run_control *g)
{
    atomic_store(&g->is_cancelled, 1);
}
