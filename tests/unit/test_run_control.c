/* A run control pauses the threads of a loop between its chunks, and resumes them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/run_control.h"

#include <unistd.h>

#include "baker/base/parallel.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { CHUNKS = 1 << 15 };

typedef struct held_loop {
    run_control run_control;
    uint32_t    threads;
    atomic_uint begun, ended, cancelled;
} held_loop;

static void do_chunk(void *user, size_t begin, size_t end, uint32_t worker)
{
    held_loop *l = user;
    (void)begin;
    (void)end;
    (void)worker;
    atomic_fetch_add(&l->begun, 1);
    if (run_control_is_cancelled())
        atomic_fetch_add(&l->cancelled, 1);
    else
        usleep(20);
    atomic_fetch_add(&l->ended, 1);
}

static void *run_loop(void *user)
{
    held_loop *l = user;
    run_control_enter(&l->run_control);
    parallel_for(l->threads, CHUNKS, 1, do_chunk, l);
    run_control_leave(&l->run_control);
    return NULL;
}

static void test_loops_are_held(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads += 3) {
        held_loop l = {.threads = threads};
        pthread_t runner;
        run_control_init(&l.run_control);
        assert_int_equal(pthread_create(&runner, NULL, run_loop, &l), 0);
        uint32_t before = 0;
        for (int n = 0; n < 5; n++) {
            while (atomic_load(&l.begun) == before) usleep(500);
            run_control_pause(&l.run_control);
            uint32_t held = atomic_load(&l.begun);
            assert_int_equal(held, atomic_load(&l.ended)); /* no thread is in the middle of a chunk */
            assert_true(held > before && held < CHUNKS);
            usleep(2000);
            assert_int_equal(held, atomic_load(&l.begun));
            before = held;
            run_control_resume(&l.run_control);
        }
        assert_int_equal(atomic_load(&l.cancelled), 0);
        run_control_cancel(&l.run_control);
        pthread_join(runner, NULL);
        assert_int_equal(atomic_load(&l.ended), CHUNKS);
        assert_true(atomic_load(&l.cancelled) > 0);
        run_control_pause(&l.run_control); /* no thread is at work: returns at once */
        run_control_free(&l.run_control);
    }
}

static void test_threads_without_a_run_do_not_wait(void **state)
{
    (void)state;
    assert_null(run_control_current());
    assert_int_equal(run_control_is_cancelled(), 0);
    run_control_wait();
    run_control_enter(NULL);
    run_control_leave(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_loops_are_held),
                                       cmocka_unit_test(test_threads_without_a_run_do_not_wait)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
