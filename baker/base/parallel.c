/* Parallel loop over [0, count); see parallel.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/parallel.h"

#include <stdatomic.h>

#include "baker/base/integer.h"
#include "baker/base/run_control.h"
#include "baker/base/system.h"
#include "baker/base/threads.h"

typedef struct loop {
    atomic_size_t next; /* the next chunk to hand out; counts chunks, not items, so that it cannot wrap */
    size_t        chunk_count;
    size_t        count;
    size_t        grain;
    void (*body)(void *user, size_t begin, size_t end, uint32_t worker);
    void        *user;
    run_control *run_control; /* the caller's run */
} loop;

typedef struct worker {
    loop     *shared;
    uint32_t  index;
    os_thread thread;
} worker;

static void work(const worker *w)
{
    loop *l = w->shared;
    for (;;) {
        run_control_wait();
        size_t chunk = atomic_fetch_add_explicit(&l->next, 1, memory_order_relaxed);
        if (chunk >= l->chunk_count) return;
        size_t begin = chunk * l->grain;
        size_t end   = l->count - begin > l->grain ? begin + l->grain : l->count;
        l->body(l->user, begin, end, w->index);
    }
}

static void *work_on_thread(void *argument)
{
    const worker *w = argument;
    run_control_enter(w->shared->run_control);
    work(w);
    run_control_leave(w->shared->run_control);
    return NULL;
}

void parallel_for(uint32_t threads, size_t count, size_t grain, void (*body)(void *user, size_t begin, size_t end, uint32_t worker),
                  void *user)
{
    if (!count) return;
    if (!grain) grain = 1;
    if (threads < 1) threads = 1;
    if (threads > PARALLEL_THREADS_MAX) threads = PARALLEL_THREADS_MAX;

    loop l = {.chunk_count = (count - 1) / grain + 1,
              .count       = count,
              .grain       = grain,
              .body        = body,
              .user        = user,
              .run_control = run_control_current()};
    atomic_init(&l.next, 0);
    if (threads > l.chunk_count) threads = (uint32_t)l.chunk_count;

    /* the caller is worker 0; after the first failure no more threads are started */
    worker   workers[PARALLEL_THREADS_MAX];
    uint32_t started = 1;
    workers[0]       = (worker){.shared = &l, .index = 0};
    while (started < threads) {
        worker *w = &workers[started];
        *w        = (worker){.shared = &l, .index = started};
        if (!os_thread_start(&w->thread, work_on_thread, w)) break;
        started++;
    }
    work(&workers[0]);
    if (started == 1) return;
    run_control_leave(l.run_control); /* waiting for the other threads does not count as work */
    for (uint32_t i = 1; i < started; i++) os_thread_join(workers[i].thread);
    run_control_enter(l.run_control);
}

typedef struct lent_loop {
    void (*task)(void *work, uint32_t n);
    void *work;
} lent_loop;

static void run_tasks(void *user, size_t begin, size_t end, uint32_t index)
{
    const lent_loop *l = user;
    (void)index;
    for (size_t n = begin; n < end; n++) l->task(l->work, (uint32_t)n);
}

static void run_lent(void *user, uint32_t count, void (*task)(void *work, uint32_t n), void *work)
{
    lent_loop l = {task, work};
    (void)user;
    parallel_for(count, count, 1, run_tasks, &l);
}

static void pause_lent(void *user)
{
    (void)user;
    run_control_wait();
}

vxs_parallel parallel_lent(uint32_t threads)
{
    return (vxs_parallel){.run = run_lent, .threads = threads, .pause = pause_lent};
}

uint32_t parallel_default_threads(void)
{
    return !HAS_THREADS ? 1 : min_u32(system_processors(), PARALLEL_THREADS_MAX);
}
