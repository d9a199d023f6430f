/* Threads of WebAssembly: pthread_create and pthread_join over workers of the host, which emscripten's C library has only with its own
 * JavaScript. Locks, signals and memory of single threads are those of that library.
 *
 * A worker has a place in `workers`, and for its life one thread of the C library. The host starts workers while the command runs, and
 * ends them after it; a worker that has arrived waits for work. So pthread_create hands work to a worker that has none, or fails.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "baker/base/threads.h"

enum {
    WORKERS_MAX = 63,
    STACK_BYTES = 1 << 20,
    STACK_ALIGN = 16,
    SPARE_BYTES = 1 << 13, /* more than the C library takes for a thread, without a look at what it got */
};

enum {
    ABSENT,
    ARRIVED, /* the host has set it: the worker has neither stack nor thread */
    IDLE,
    CLAIMED, /* by a pthread_create that is not done */
    BUSY,
    DONE,
};

/* host.mjs knows the first two fields. */
typedef struct worker {
    _Atomic(int) state;
    char        *stack_top; /* of STACK_BYTES; behind it the worker's thread-local variables */
    pthread_t    thread;
    void *(*run)(void *work);
    void *work;
} worker;

static worker workers[WORKERS_MAX];

/* what emscripten's C library calls, in the place of its JavaScript, and calls of the linker */
int  __pthread_create_js(pthread_t thread, const pthread_attr_t *attributes, void *(*run)(void *), void *work);
void __emscripten_thread_cleanup(pthread_t thread);
int  _emscripten_default_pthread_stack_size(void);
void __emscripten_init_main_thread_js(void *thread);
void emscripten_check_blocking_allowed(void);
int  emscripten_builtin_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *), void *work);
void __set_thread_state(void *thread, int is_main, int is_runtime, int can_wait);
void __wasm_init_tls(void *memory);

#define EXPORT(name) __attribute__((export_name(#name), used))

/* The place of worker n; NULL: there is none. */
EXPORT(worker_place) worker *worker_place(uint32_t n);
/* What a worker calls once it has a stack. Never returns. */
EXPORT(run_worker) void run_worker(worker *w);

static void wait_while(worker *w, int state)
{
    __builtin_wasm_memory_atomic_wait32((int *)&w->state, state, -1);
}

static void set_state(worker *w, int state)
{
    atomic_store(&w->state, state);
    __builtin_wasm_memory_atomic_notify((int *)&w->state, UINT32_MAX);
}

worker *worker_place(uint32_t n)
{
    return n < WORKERS_MAX ? &workers[n] : NULL;
}

void run_worker(worker *w)
{
    __set_thread_state(w->thread, 0, 0, 1);
    __wasm_init_tls(w->stack_top);
    for (;;) {
        int state = atomic_load(&w->state);
        if (state != BUSY) {
            wait_while(w, state);
            continue;
        }
        w->run(w->work);
        set_state(w, DONE);
    }
}

/* Give an arrived worker its stack and its thread of the C library. Returns 0 when there is no memory. */
static int equip(worker *w)
{
    static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
    pthread_attr_t         attributes;
    size_t                 own   = (__builtin_wasm_tls_size() + STACK_ALIGN - 1) / STACK_ALIGN * STACK_ALIGN;
    char                  *stack = aligned_alloc(STACK_ALIGN, STACK_BYTES + own);
    void                  *spare = malloc(SPARE_BYTES);
    free(spare);
    if (!stack || !spare) {
        free(stack);
        return 0;
    }
    w->stack_top = stack + STACK_BYTES;
    pthread_attr_init(&attributes);
    pthread_attr_setstack(&attributes, stack, STACK_BYTES);
    pthread_mutex_lock(&one_at_a_time);
    emscripten_builtin_pthread_create(&w->thread, &attributes, NULL, NULL);
    pthread_mutex_unlock(&one_at_a_time);
    pthread_attr_destroy(&attributes);
    return 1;
}

static int claim(worker *w)
{
    int idle = IDLE, arrived = ARRIVED;
    if (atomic_compare_exchange_strong(&w->state, &idle, CLAIMED)) return 1;
    if (!atomic_compare_exchange_strong(&w->state, &arrived, CLAIMED)) return 0;
    if (equip(w)) return 1;
    atomic_store(&w->state, ARRIVED);
    return 0;
}

int pthread_create(pthread_t *restrict thread, const pthread_attr_t *restrict attributes, void *(*run)(void *), void *restrict work)
{
    (void)attributes;
    for (worker *w = workers; w < workers + WORKERS_MAX; w++) {
        if (!claim(w)) continue;
        w->run  = run;
        w->work = work;
        *thread = (pthread_t)w;
        set_state(w, BUSY);
        return 0;
    }
    return EAGAIN;
}

int pthread_join(pthread_t thread, void **result)
{
    worker *w = (worker *)thread;
    while (atomic_load(&w->state) != DONE) wait_while(w, BUSY);
    if (result) *result = NULL; /* results of threads are not kept: no caller uses them */
    atomic_store(&w->state, IDLE);
    return 0;
}

/* The first thread waits like any other. */
void __emscripten_init_main_thread_js(void *thread)
{
    __set_thread_state(thread, 0, 0, 1);
}

int __pthread_create_js(pthread_t thread, const pthread_attr_t *attributes, void *(*run)(void *), void *work)
{
    (void)thread, (void)attributes, (void)run, (void)work;
    return 0;
}

int _emscripten_default_pthread_stack_size(void)
{
    return STACK_BYTES;
}

void __emscripten_thread_cleanup(pthread_t thread)
{
    (void)thread;
}

void emscripten_check_blocking_allowed(void) {}
