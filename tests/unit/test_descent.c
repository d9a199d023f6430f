/* A descent adds its squares in order, whatever threads build first, and never builds into a slot that is in use.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/descent.h"

#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

#include "baker/base/z_order.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { SIDE_PX = 1024, SQUARE_PX = 8, ACROSS = SIDE_PX / SQUARE_PX, SQUARES = ACROSS * ACROSS, EMPTY = -1 };

typedef struct descended {
    atomic_int slots[DESCENT_SLOTS]; /* number of the build; EMPTY */
    atomic_int faults, built, in_slots, most_in_slots;
    int        added, failing; /* the build that fails */
} descended;

static vxs_result map_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    (void)data, (void)level, (void)i, (void)j;
    *out = bounds_unknown(SIDE_PX);
    return VXS_OK;
}

static vxs_result map_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    (void)ctx, (void)level, (void)i, (void)j;
    *out = (column_square){.data = data, .bounds = map_bounds};
    return VXS_OK;
}

static void map_release(void *data, column_square *square)
{
    (void)data;
    *square = (column_square){0};
}

static descent_step classify(const void *user, const column_bounds *bounds, uint32_t level, int fetched)
{
    (void)user, (void)bounds, (void)fetched;
    return level == square_level(SQUARE_PX) ? DESCENT_BUILD : DESCENT_SPLIT;
}

static vxs_result build(void *user, uint32_t slot, const column_square *columns, uint32_t level, uint32_t i, uint32_t j)
{
    descended *o = user;
    (void)columns, (void)level, (void)i, (void)j;
    int number = atomic_fetch_add(&o->built, 1), in_slots = atomic_fetch_add(&o->in_slots, 1) + 1;
    if (atomic_exchange(&o->slots[slot], number) != EMPTY) atomic_fetch_add(&o->faults, 1);
    for (int most = o->most_in_slots; in_slots > most && !atomic_compare_exchange_weak(&o->most_in_slots, &most, in_slots);)
        continue;
    if (number % 997 == 0) usleep(3000); /* the others come far ahead */
    return number == o->failing ? VXS_E_WRITE : VXS_OK;
}

static vxs_result settle(void *user, const column_bounds *bounds, uint32_t level, uint32_t i, uint32_t j)
{
    (void)bounds, (void)level, (void)i, (void)j;
    atomic_fetch_add(&((descended *)user)->faults, 1);
    return VXS_OK;
}

static vxs_result add(void *user, uint32_t slot, uint32_t level, uint32_t i, uint32_t j)
{
    descended *o = user;
    (void)level;
    if (z_number((z_place){i, j}) != (uint32_t)o->added++) atomic_fetch_add(&o->faults, 1);
    if (atomic_exchange(&o->slots[slot], EMPTY) == EMPTY) atomic_fetch_add(&o->faults, 1);
    atomic_fetch_sub(&o->in_slots, 1);
    return VXS_OK;
}

static vxs_result run(descended *o, uint32_t threads, int failing)
{
    uint64_t     fetched = 0;
    run_context  m       = {0};
    bake_context ctx     = {.run = &m, .threads = threads};
    column_map   map     = {.data        = o,
                            .side_px     = SIDE_PX,
                            .depth_vx    = SIDE_PX,
                            .fetch_px    = SIDE_PX,
                            .parallel_px = SQUARE_PX,
                            .bounds      = map_bounds,
                            .fetch       = map_fetch,
                            .release     = map_release};
    descent      d       = {.user            = o,
                            .square_px       = SQUARE_PX,
                            .squares_fetched = &fetched,
                            .classify        = classify,
                            .settle          = settle,
                            .build           = build,
                            .add             = add,
                            .add_early       = 1};
    memset(o, 0, sizeof *o);
    o->failing = failing;
    for (int n = 0; n < DESCENT_SLOTS; n++) atomic_init(&o->slots[n], EMPTY);
    vxs_result r = descend(&d, &map, &ctx);
    assert_int_equal(o->faults, 0);
    assert_true((uint32_t)o->most_in_slots <= descent_slots(threads));
    return r;
}

static void test_all_squares_in_order(void **state)
{
    static descended o;
    (void)state;
    for (uint32_t threads = 1; threads <= 8; threads *= 2) {
        assert_int_equal(run(&o, threads, EMPTY), VXS_OK);
        assert_int_equal(o.added, SQUARES);
        assert_int_equal(o.in_slots, 0);
    }
}

static void test_nothing_is_added_after_a_failure(void **state)
{
    static descended o;
    (void)state;
    for (uint32_t threads = 1; threads <= 8; threads *= 2) {
        assert_int_equal(run(&o, threads, 5000), VXS_E_WRITE);
        assert_true(o.added <= 5000 + (int)descent_slots(threads) && o.built < SQUARES);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_squares_in_order),
        cmocka_unit_test(test_nothing_is_added_after_a_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
