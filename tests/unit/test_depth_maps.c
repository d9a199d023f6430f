/* The min-max pyramid and the columns of stored depth maps, against brute force (baker/maps/depth_maps.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/maps/depth_maps.h" /* before cmocka, whose fail() is a macro */

#include <cmocka.h>

#include "tests/unit/random_maps.h"

static void init(depth_maps *d, uint32_t side, uint32_t depth, int with_exit)
{
    message m = {0};
    assert_int_equal(depth_maps_init(d, side, depth, 0, with_exit, &m), VXS_OK);
}

static uint32_t down(const depth_maps *d, float depth)
{
    return (uint32_t)floor((double)depth * d->depth_vx);
}

static uint32_t up(const depth_maps *d, float depth)
{
    return (uint32_t)ceil((double)depth * d->depth_vx);
}

static column_bounds brute_bounds(const depth_maps *d, uint32_t side, uint32_t i, uint32_t j)
{
    column_bounds b = {UINT32_MAX, 0, UINT32_MAX, 0};
    for (uint32_t v = j * side; v < (j + 1) * side; v++)
        for (uint32_t u = i * side; u < (i + 1) * side; u++) {
            uint32_t e = down(d, d->enter[v * d->side_px + u]), x = up(d, d->exit[v * d->side_px + u]);
            b.emin = e < b.emin ? e : b.emin;
            b.emax = e > b.emax ? e : b.emax;
            b.xmin = x < b.xmin ? x : b.xmin;
            b.xmax = x > b.xmax ? x : b.xmax;
        }
    return b;
}

static void assert_pyramid(const depth_maps *d)
{
    column_source s = depth_maps_columns(d);
    assert_int_equal(s.side_px, d->side_px);
    assert_int_equal(s.depth_vx, d->depth_vx);
    for (uint32_t level = 0; 8u << level <= d->side_px; level++)
        for (uint32_t j = 0; j < d->side_px >> (3 + level); j++)
            for (uint32_t i = 0; i < d->side_px >> (3 + level); i++) {
                column_bounds found = s.bounds(s.data, level, i, j), brute = brute_bounds(d, 8u << level, i, j);
                assert_memory_equal(&found, &brute, sizeof found);
            }
}

static void assert_tiles(const depth_maps *d)
{
    column_source s = depth_maps_columns(d);
    for (uint32_t j = 0; j < d->side_px / 8; j++)
        for (uint32_t i = 0; i < d->side_px / 8; i++) {
            column_tile t;
            s.tile(s.data, i, j, &t);
            for (uint32_t n = 0; n < 64; n++) {
                size_t at = (size_t)(j * 8 + n / 8) * d->side_px + i * 8 + n % 8;
                assert_int_equal(t.e[n], down(d, d->enter[at]));
                assert_int_equal(t.x[n], up(d, d->exit[at]));
            }
        }
}

static void pyramid_is_brute_force(void **state)
{
    static const uint32_t sides[] = {8, 16, 64, 128};
    (void)state;
    for (int n = 0; n < 4; n++)
        for (map_kind kind = 0; kind < MAP_KINDS; kind++)
            for (uint32_t threads = 1; threads <= 8; threads += 7) {
                depth_maps d;
                rng        r = rng_split((uint64_t)n, kind);
                init(&d, sides[n], sides[n] * (n % 2 ? 1 : 4), 1);
                fill_maps(&d, kind, &r);
                depth_maps_reduce(&d, threads);
                assert_pyramid(&d);
                assert_tiles(&d);
                depth_maps_free(&d);
            }
}

/* One float off a voxel boundary decides, whatever the size of the map. */
static void rounding_is_exact_at_boundaries(void **state)
{
    (void)state;
    for (uint32_t depth = 8; depth <= 262144; depth *= 2) {
        depth_maps d;
        rng        r = rng_split(depth, 0);
        init(&d, 8, depth, 1);
        for (int n = 0; n < 64; n++) {
            float edge = (float)rng_below(&r, depth) / (float)depth;
            float near = n % 3 == 0 ? edge : n % 3 == 1 ? nextafterf(edge, 2) : nextafterf(edge, -1);
            d.enter[n] = near < 0 ? 0 : near;
            d.exit[n]  = n % 2 ? d.enter[n] : nextafterf(d.enter[n], 2);
        }
        depth_maps_reduce(&d, 1);
        assert_pyramid(&d);
        assert_tiles(&d);
        depth_maps_free(&d);
    }
}

static void one_array_serves_both_when_all_are_sheets(void **state)
{
    depth_maps d;
    rng        r = {1};
    (void)state;
    init(&d, 32, 32, 0);
    assert_ptr_equal(d.enter, d.exit);
    for (int n = 0; n < 32 * 32; n++) d.enter[n] = random_unit(&r);
    depth_maps_reduce(&d, 2);
    assert_pyramid(&d);
    assert_tiles(&d);
    depth_maps_free(&d);
}

static void reducing_again_follows_the_maps(void **state)
{
    depth_maps d;
    rng        r = {2};
    (void)state;
    init(&d, 64, 64, 1);
    for (map_kind kind = 0; kind < MAP_KINDS; kind++) {
        fill_maps(&d, kind, &r);
        depth_maps_reduce(&d, 1);
        assert_pyramid(&d);
    }
    depth_maps_free(&d);
    depth_maps_free(&d); /* a zeroed object is accepted */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pyramid_is_brute_force),
        cmocka_unit_test(rounding_is_exact_at_boundaries),
        cmocka_unit_test(one_array_serves_both_when_all_are_sheets),
        cmocka_unit_test(reducing_again_follows_the_maps),
    };
    return cmocka_run_group_tests_name("depth_maps", tests, NULL, NULL);
}
