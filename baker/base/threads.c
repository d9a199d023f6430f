/* Threads of the baker; see threads.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/threads.h"

#include <math.h>

#if !defined(VXS_ONE_THREAD) && !defined(__wasm__)

int threads_wait_until(os_signal *s, os_mutex *m, double until)
{
    struct timespec at = {.tv_sec = (time_t)until, .tv_nsec = (long)(1e9 * (until - floor(until)))};
    return pthread_cond_clockwait(s, m, CLOCK_MONOTONIC, &at) != ETIMEDOUT;
}

void threads_block_signals(sigset_t *before)
{
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, before);
}

void threads_unblock_signals(const sigset_t *before)
{
    pthread_sigmask(SIG_SETMASK, before, NULL);
}

void threads_set_stacks(size_t least, size_t bytes)
{
#ifdef __GLIBC__
    pthread_attr_t attributes;
    size_t         size;
    if (pthread_getattr_default_np(&attributes)) return;
    if (!pthread_attr_getstacksize(&attributes, &size) && size < least && !pthread_attr_setstacksize(&attributes, bytes))
        pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
#else
    (void)least;
    (void)bytes;
#endif
}

int threads_run_on_stack(size_t bytes, void *(*run)(void *work), void *work)
{
    pthread_attr_t attributes;
    pthread_t      thread;
    sigset_t       before;
    if (pthread_attr_init(&attributes)) return 0;
    int failed = pthread_attr_setstacksize(&attributes, bytes) || pthread_create(&thread, &attributes, run, work);
    pthread_attr_destroy(&attributes);
    if (failed) return 0;
    threads_block_signals(&before);
    pthread_join(thread, NULL);
    threads_unblock_signals(&before);
    return 1;
}

#else

int threads_wait_until(os_signal *s, os_mutex *m, double until)
{
    (void)s;
    (void)m;
    (void)until;
    return 0;
}

void threads_block_signals(sigset_t *before)
{
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_BLOCK, &all, before);
}

void threads_unblock_signals(const sigset_t *before)
{
    sigprocmask(SIG_SETMASK, before, NULL);
}

void threads_set_stacks(size_t least, size_t bytes)
{
    (void)least;
    (void)bytes;
}

int threads_run_on_stack(size_t bytes, void *(*run)(void *work), void *work)
{
    (void)bytes;
    (void)run;
    (void)work;
    return 0;
}

#endif
