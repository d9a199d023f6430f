/* Threads of platform.h in a build that has none.
 * SPDX-License-Identifier: MIT */
#ifndef PLATFORM_ONE_THREAD_H
#define PLATFORM_ONE_THREAD_H

#include <assert.h>

/* members, because empty structs are not C */
typedef struct os_mutex {
    int unused;
} os_mutex;
typedef os_mutex os_signal, os_thread;

static inline int os_mutex_init(os_mutex *m)
{
    m->unused = 0;
    return 1;
}

static inline int os_signal_init(os_signal *s)
{
    s->unused = 0;
    return 1;
}

static inline int os_thread_start(os_thread *t, void *(*run)(void *), void *work)
{
    (void)t;
    (void)run;
    (void)work;
    return 0;
}

static inline void os_mutex_free(os_mutex *m)
{
    (void)m;
}

static inline void os_signal_free(os_signal *s)
{
    (void)s;
}

static inline void os_lock(os_mutex *m)
{
    (void)m;
}

static inline void os_unlock(os_mutex *m)
{
    (void)m;
}

static inline void os_wait(os_signal *s, os_mutex *m)
{
    (void)s;
    (void)m;
    assert(!"no other thread can end the wait");
}

static inline void os_wake_all(os_signal *s)
{
    (void)s;
}

static inline void os_thread_join(os_thread t)
{
    (void)t;
}

#endif
