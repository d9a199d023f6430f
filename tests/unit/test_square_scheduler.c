/* How squares are distributed to ranks, in simulated time: ranks and the merge take given times for a square.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/base/random.h"
#include "baker/command/mpi/square_scheduler.h"

#include <cmocka.h>

enum { RANKS_MAX = 8, SQUARES = 512 };

typedef struct farm {
    square_scheduler square_scheduler;
    uint32_t         ranks;
    double   making[RANKS_MAX], adding, varies; /* time for a square; how much more one may take than another, in its ratio */
    double   cost[SQUARES], done[SQUARES];      /* when it is made */
    double   free_at[RANKS_MAX];                /* when it is done with what it has */
    uint32_t made[RANKS_MAX];
} farm;

/* All other ranks, up to a moment: whoever is free first is first. */
static void others_until(farm *f, double now)
{
    for (;;) {
        uint32_t first = 1;
        uint64_t number;
        for (uint32_t rank = 2; rank < f->ranks; rank++)
            if (f->free_at[rank] < f->free_at[first]) first = rank;
        if (f->free_at[first] > now || f->square_scheduler.count >= SQUARES) return;
        if (square_scheduler_next(&f->square_scheduler, first, &number) !=
            SCHEDULER_GIVEN) { /* the rank calls again when rank 0 has gone on */
            f->free_at[first] = now + 1e-9;
            continue;
        }
        if (number >= SQUARES) return;
        f->free_at[first] += f->making[first] * f->cost[number];
        f->done[number] = f->free_at[first];
        f->made[first]++;
    }
}

/* Returns how long it takes, and everything is made once. */
static double run(farm *f)
{
    double now                = 0;
    rng    r                  = rng_split(1, 1);
    f->square_scheduler.ranks = f->ranks;
    for (int n = 0; n < SQUARES; n++) f->cost[n] = 1 + f->varies * rng_unit(&r);
    for (uint64_t n = 0; n < SQUARES; n++) {
        if (f->ranks > 1) others_until(f, now);
        const scheduled_square *s = square_scheduler_take(&f->square_scheduler, n);
        assert_non_null(s);
        if (!s->rank) {
            now += f->making[0] * f->cost[n];
            f->made[0]++;
        } else if (f->done[n] > now) {
            now = f->done[n];
        }
        now += f->adding;
    }
    uint32_t all = 0;
    for (uint32_t rank = 0; rank < f->ranks; rank++) all += f->made[rank];
    assert_int_equal(all, SQUARES);
    square_scheduler_free(&f->square_scheduler);
    return now;
}

/* The time that no order of squares could beat: rank 0 adds them all, and everybody is at work to the end. */
static double ideal(const farm *f)
{
    double work = 0, rate = 0, adding = SQUARES * f->adding;
    for (int n = 0; n < SQUARES; n++) work += f->cost[n];
    for (uint32_t rank = 0; rank < f->ranks; rank++) rate += 1 / f->making[rank];
    double time = (work + adding / f->making[0]) / rate;
    return time > adding ? time : adding;
}

static void takes_little_longer_than_it_has_to(farm f, double ratio)
{
    double took = run(&f), best = ideal(&f);
    if (took > ratio * best) {
        for (uint32_t rank = 0; rank < f.ranks; rank++) print_message("rank %u made %u\n", rank, f.made[rank]);
        fail_msg("%u ranks took %.1f, and could have taken %.1f", f.ranks, took, best);
    }
}

static void alike(void **state)
{
    (void)state;
    for (uint32_t ranks = 1; ranks <= RANKS_MAX; ranks++) {
        takes_little_longer_than_it_has_to((farm){.ranks = ranks, .making = {1, 1, 1, 1, 1, 1, 1, 1}, .adding = 0.05}, 1.1);
        takes_little_longer_than_it_has_to((farm){.ranks = ranks, .making = {1, 1, 1, 1, 1, 1, 1, 1}, .adding = 0.05, .varies = 4},
                                           1.15);
    }
}

static void merging_takes_long(void **state)
{
    (void)state;
    for (uint32_t ranks = 2; ranks <= RANKS_MAX; ranks++)
        takes_little_longer_than_it_has_to((farm){.ranks = ranks, .making = {1, 1, 1, 1, 1, 1, 1, 1}, .adding = 0.5, .varies = 2},
                                           1.1);
}

static void some_are_slow(void **state)
{
    (void)state;
    takes_little_longer_than_it_has_to((farm){.ranks = 4, .making = {1, 1, 3, 1}, .adding = 0.05, .varies = 1}, 1.25);
    takes_little_longer_than_it_has_to((farm){.ranks = 4, .making = {4, 1, 1, 1}, .adding = 0.05, .varies = 1}, 1.25);
    takes_little_longer_than_it_has_to((farm){.ranks = 4, .making = {1, 2, 2, 2}, .adding = 0.05, .varies = 1}, 1.25);
}

/* Squares are taken from those alone that have them, and once. */
static void what_nobody_was_given(void **state)
{
    (void)state;
    square_scheduler d = {.ranks = 3};
    uint64_t         number;
    assert_int_equal(square_scheduler_next(&d, 1, &number), SCHEDULER_GIVEN);
    assert_int_equal(number, 1); /* the first is left for rank 0 */
    assert_null(square_scheduler_deliver(&d, 1, 2));
    assert_null(square_scheduler_deliver(&d, 0, 1));
    assert_null(square_scheduler_deliver(&d, 2, 1));
    assert_null(square_scheduler_deliver(&d, UINT64_MAX, 1));
    scheduled_square *s = square_scheduler_deliver(&d, 1, 1);
    assert_non_null(s);
    s->is_here = 1;
    assert_null(square_scheduler_deliver(&d, 1, 1));
    square_scheduler_free(&d);
}

/* What is held is bounded, where rank 0 does not go on. */
static void others_wait_in_the_end(void **state)
{
    (void)state;
    square_scheduler d     = {.ranks = 4};
    uint32_t         given = 0;
    uint64_t         number;
    while (square_scheduler_next(&d, 1 + given % 3, &number) == SCHEDULER_GIVEN && given < 100000) given++;
    assert_in_range(given, 64, 256);
    assert_non_null(square_scheduler_take(&d, 1));
    assert_int_equal(square_scheduler_next(&d, 1, &number), SCHEDULER_GIVEN);
    square_scheduler_free(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(alike),
        cmocka_unit_test(merging_takes_long),
        cmocka_unit_test(some_are_slow),
        cmocka_unit_test(what_nobody_was_given),
        cmocka_unit_test(others_wait_in_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
