/* A gate holds the threads of a loop between its chunks, and lets them go on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/gate.h"

#include <unistd.h>

#include "baker/base/parallel.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { CHUNKS = 1 << 15 };

typedef struct held_loop {
    gate        gate;
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
    if (gate_is_cancelled())
        atomic_fetch_add(&l->cancelled, 1);
    else
        usleep(20);
    atomic_fetch_add(&l->ended, 1);
}

static void *run_loop(void *user)
{
    held_loop *l = user;
    gate_enter(&l->gate);
    parallel_for(l->threads, CHUNKS, 1, do_chunk, l);
    gate_leave(&l->gate);
    return NULL;
}

static void test_loops_are_held(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 4; threads += 3) {
        held_loop l = {.threads = threads};
        pthread_t runner;
        gate_init(&l.gate);
        assert_int_equal(pthread_create(&runner, NULL, run_loop, &l), 0);
        uint32_t before = 0;
        for (int n = 0; n < 5; n++) {
            while (atomic_load(&l.begun) == before) usleep(500);
            gate_shut(&l.gate);
            uint32_t held = atomic_load(&l.begun);
            assert_int_equal(held, atomic_load(&l.ended)); /* nobody is in the middle of a chunk */
            assert_true(held > before && held < CHUNKS);
            usleep(2000);
            assert_int_equal(held, atomic_load(&l.begun));
            before = held;
            gate_open(&l.gate);
        }
        assert_int_equal(atomic_load(&l.cancelled), 0);
        gate_cancel(&l.gate);
        pthread_join(runner, NULL);
        assert_int_equal(atomic_load(&l.ended), CHUNKS);
        assert_true(atomic_load(&l.cancelled) > 0);
        gate_shut(&l.gate); /* nobody is there: it does not wait */
        gate_free(&l.gate);
    }
}

static void test_threads_without_a_gate_pass(void **state)
{
    (void)state;
    assert_null(gate_here());
    assert_int_equal(gate_is_cancelled(), 0);
    gate_pass();
    gate_enter(NULL);
    gate_leave(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_loops_are_held), cmocka_unit_test(test_threads_without_a_gate_pass)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
