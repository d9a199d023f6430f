/* Parallel loop over [0, count); see parallel.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/parallel.h"

#include <stdatomic.h>
#include <stdlib.h>

#include "baker/base/clock.h"
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
    atomic_uint  called;      /* threads that are called to the loop and have not ended their work */
} loop;

/* The pool of the calling thread; NULL: none. */
static _Thread_local thread_pool *current;

static void work(loop *l, uint32_t worker)
{
    for (;;) {
        run_control_wait();
        size_t chunk = atomic_fetch_add_explicit(&l->next, 1, memory_order_relaxed);
        if (chunk >= l->chunk_count) return;
        size_t begin = chunk * l->grain;
        size_t end   = l->count - begin > l->grain ? begin + l->grain : l->count;
        l->body(l->user, begin, end, worker);
    }
}

/* pools ----------------------------------------------------------------------------------------------------------------------- */

/* A thread of a pool. */
typedef struct pool_thread {
    thread_pool        *pool;
    os_thread           thread;
    os_signal           wake;
    loop *_Atomic       loop;   /* the loop to which it is called, and in which it has not begun to work; NULL: none */
    uint32_t            worker; /* its number in that loop */
    struct pool_thread *next;   /* idle thread after it; under the pool's lock */
} pool_thread;

struct thread_pool {
    os_mutex     lock;
    os_signal    done; /* a loop has no called threads any more */
    pool_thread  threads[PARALLEL_THREADS_MAX - 1];
    uint32_t     count; /* started threads */
    pool_thread *idle;
    atomic_uint  waiting;      /* threads that wait for done */
    atomic_int   ends;         /* 1: threads without a loop end */
    double       spin_seconds; /* that threads look again and again before they sleep */
};

/* Waking a thread that sleeps takes longer than many loops: the time between them, or until the last thread of a loop ends, is often
 * shorter. */
static const double SPIN_SECONDS = 5e-5;

static void become_idle(pool_thread *t)
{
    t->next       = t->pool->idle;
    t->pool->idle = t;
}

/* Wait for a loop. Returns NULL when the pool ends. */
static loop *next_loop(pool_thread *t)
{
    thread_pool *pool = t->pool;
    double       end  = clock_seconds() + pool->spin_seconds;
    while (!atomic_load(&t->loop) && !atomic_load(&pool->ends) && clock_seconds() < end) {}
    loop *l = atomic_exchange(&t->loop, NULL);
    if (l) return l;
    os_lock(&pool->lock);
    while (!(l = atomic_exchange(&t->loop, NULL)) && !atomic_load(&pool->ends)) os_wait(&t->wake, &pool->lock);
    os_unlock(&pool->lock);
    return l;
}

/* The loop is gone when no thread is called to it any more. */
static void leave_loop(loop *l, thread_pool *pool)
{
    if (atomic_fetch_sub(&l->called, 1) != 1 || !atomic_load(&pool->waiting)) return;
    os_lock(&pool->lock);
    os_wake_all(&pool->done);
    os_unlock(&pool->lock);
}

static void *run_pool_thread(void *argument)
{
    pool_thread *t    = argument;
    thread_pool *pool = t->pool;
    current           = pool;
    for (loop *l; (l = next_loop(t));) {
        run_control_enter(l->run_control);
        work(l, t->worker);
        run_control_leave(l->run_control);
        os_lock(&pool->lock);
        become_idle(t);
        os_unlock(&pool->lock);
        leave_loop(l, pool);
    }
    return NULL;
}

/* Start a thread that is called to a loop. Returns 0 when there is none. */
static int start_thread(thread_pool *pool, loop *l, uint32_t worker)
{
    if (pool->count == sizeof pool->threads / sizeof *pool->threads) return 0;
    pool_thread *t = &pool->threads[pool->count];
    *t             = (pool_thread){.pool = pool, .loop = l, .worker = worker};
    os_signal_init(&t->wake);
    if (!os_thread_start(&t->thread, run_pool_thread, t)) {
        os_signal_free(&t->wake);
        return 0;
    }
    pool->count++;
    return 1;
}

/* Call threads to a loop: idle ones, then new ones. */
static void call_threads(thread_pool *pool, loop *l, uint32_t threads)
{
    os_lock(&pool->lock);
    for (uint32_t worker = 1; worker < threads; worker++) {
        pool_thread *t = pool->idle;
        atomic_fetch_add(&l->called, 1);
        if (t) {
            pool->idle = t->next;
            t->worker  = worker;
            atomic_store(&t->loop, l);
            os_wake_all(&t->wake);
        } else if (!start_thread(pool, l, worker)) {
            atomic_fetch_sub(&l->called, 1);
            break;
        }
    }
    os_unlock(&pool->lock);
}

static int is_left(const loop *l, double until)
{
    while (atomic_load(&l->called))
        if (clock_seconds() >= until) return 0;
    return 1;
}

/* Wait for the threads that work in a loop, and call off those that have not begun. */
static void end_calls(thread_pool *pool, loop *l)
{
    os_lock(&pool->lock);
    for (pool_thread *t = pool->threads; t < pool->threads + pool->count; t++) {
        loop *called = l;
        if (!atomic_compare_exchange_strong(&t->loop, &called, NULL)) continue;
        atomic_fetch_sub(&l->called, 1);
        become_idle(t);
    }
    os_unlock(&pool->lock);
    if (is_left(l, clock_seconds() + pool->spin_seconds)) return;
    run_control_leave(l->run_control); /* waiting for the other threads does not count as work */
    os_lock(&pool->lock);
    atomic_fetch_add(&pool->waiting, 1);
    while (atomic_load(&l->called)) os_wait(&pool->done, &pool->lock);
    atomic_fetch_sub(&pool->waiting, 1);
    os_unlock(&pool->lock);
    run_control_enter(l->run_control);
}

/* ends  1: threads end after one loop */
static void pool_init(thread_pool *pool, int ends)
{
    os_mutex_init(&pool->lock);
    os_signal_init(&pool->done);
    pool->count        = 0;
    pool->idle         = NULL;
    pool->spin_seconds = system_processors() > 1 ? SPIN_SECONDS : 0;
    atomic_init(&pool->waiting, 0);
    atomic_init(&pool->ends, ends);
}

static void pool_free(thread_pool *pool)
{
    os_lock(&pool->lock);
    atomic_store(&pool->ends, 1);
    for (uint32_t n = 0; n < pool->count; n++) os_wake_all(&pool->threads[n].wake);
    os_unlock(&pool->lock);
    for (uint32_t n = 0; n < pool->count; n++) {
        os_thread_join(pool->threads[n].thread);
        os_signal_free(&pool->threads[n].wake);
    }
    os_signal_free(&pool->done);
    os_mutex_free(&pool->lock);
}

thread_pool *parallel_keep_threads(void)
{
    thread_pool *pool = current ? NULL : malloc(sizeof *pool);
    if (!pool) return NULL;
    pool_init(pool, 0);
    return current = pool;
}

void parallel_end_threads(thread_pool *pool)
{
    if (!pool) return;
    current = NULL;
    pool_free(pool);
    free(pool);
}

/* loops ----------------------------------------------------------------------------------------------------------------------- */

void parallel_for(uint32_t threads, size_t count, size_t grain, void (*body)(void *user, size_t begin, size_t end, uint32_t worker),
                  void *user)
{
    if (!count) return;
    if (!grain) grain = 1;
    if (threads > PARALLEL_THREADS_MAX) threads = PARALLEL_THREADS_MAX;

    loop l = {.chunk_count = (count - 1) / grain + 1,
              .count       = count,
              .grain       = grain,
              .body        = body,
              .user        = user,
              .run_control = run_control_current()};
    atomic_init(&l.next, 0);
    atomic_init(&l.called, 0);
    if (threads > l.chunk_count) threads = (uint32_t)l.chunk_count;
    if (threads < 2) {
        work(&l, 0);
        return;
    }

    thread_pool own, *pool = current;
    if (!pool) pool_init(pool = &own, 1);
    call_threads(pool, &l, threads);
    work(&l, 0);
    end_calls(pool, &l);
    if (pool == &own) pool_free(&own);
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
