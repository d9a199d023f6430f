/* Parallel loops with threads that are kept between them, and without.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/parallel.h"

#include <pthread.h>
#include <stdatomic.h>

/* last: the four headers above are those that cmocka needs */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "baker/base/threads.h"

enum { ITEMS = 1000, GRAIN = 7, INNER = 10, THREADS = 4, LOOPS = 200 };

static _Atomic int      visits[ITEMS][INNER];
static _Atomic int      at_work[THREADS]; /* ranges that a worker number does at once */
static _Atomic int      shared_numbers;
static _Atomic uint32_t threads_seen;

static void inner_items(void *user, size_t begin, size_t end, uint32_t worker)
{
    _Atomic int *of = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) of[n]++;
}

static void outer_items(void *user, size_t begin, size_t end, uint32_t worker)
{
    static _Thread_local int is_known;
    (void)user;
    if (!is_known) threads_seen++;
    is_known = 1;
    if (at_work[worker]++) shared_numbers++;
    for (size_t n = begin; n < end; n++) parallel_for(2, INNER, 1, inner_items, visits[n]);
    at_work[worker]--;
}

static void run_loops(int loops)
{
    threads_seen = 0;
    for (int n = 0; n < loops; n++) parallel_for(THREADS, ITEMS, GRAIN, outer_items, NULL);
    for (int n = 0; n < ITEMS; n++)
        for (int k = 0; k < INNER; k++) {
            assert_int_equal(visits[n][k], loops);
            visits[n][k] = 0;
        }
    assert_int_equal(shared_numbers, 0);
}

static void test_each_item_once(void **state)
{
    (void)state;
    run_loops(3);
}

static void test_kept_threads(void **state)
{
    (void)state;
    thread_pool *pool = parallel_keep_threads();
    assert_non_null(pool);
    assert_null(parallel_keep_threads()); /* the thread has one */
    run_loops(LOOPS);
    assert_true(threads_seen <= 2 * THREADS); /* each of the outer ones may have called an inner one */
    parallel_end_threads(pool);
    parallel_end_threads(NULL);
    run_loops(3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_item_once),
        cmocka_unit_test(test_kept_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
