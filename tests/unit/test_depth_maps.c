/* The min-max pyramid and the columns of stored depth maps, against brute force (baker/lab/opengl/depth_maps.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/lab/opengl/depth_maps.h" /* before cmocka, whose fail() is a macro */

#include <cmocka.h>

#include "tests/columns/stored_maps.h"
#include "tests/unit/random_maps.h"

static void init(depth_maps *d, uint32_t side, uint32_t depth, int with_exit)
{
    run_context m = {0};
    assert_int_equal(depth_maps_init(d, side, depth, 0, with_exit, &m), VXS_OK);
}

/* Perspective depths are -near / distance; their logarithm in voxels, where long double is what rounding is held against. */
static long double voxels(const depth_maps *d, float depth)
{
    if (d->voxel_log == 0) return (long double)depth * d->depth_vx;
    if (!(depth < 0)) return d->depth_vx;
    return fminl(-logl(-(long double)depth) / d->voxel_log, d->depth_vx);
}

static uint32_t down(const depth_maps *d, float depth)
{
    return (uint32_t)floorl(voxels(d, depth));
}

static uint32_t up(const depth_maps *d, float depth)
{
    return (uint32_t)ceill(voxels(d, depth));
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
    column_square s = depth_maps_square(d);
    assert_int_equal(s.side_px, d->side_px);
    assert_int_equal(s.depth_vx, d->depth_vx);
    for (uint32_t level = 0; 8u << level <= d->side_px; level++)
        for (uint32_t j = 0; j < d->side_px >> (3 + level); j++)
            for (uint32_t i = 0; i < d->side_px >> (3 + level); i++) {
                column_bounds found, brute = brute_bounds(d, 8u << level, i, j);
                assert_int_equal(s.bounds(s.data, level, i, j, &found), VXS_OK);
                assert_memory_equal(&found, &brute, sizeof found);
            }
}

static void assert_tiles(const depth_maps *d)
{
    column_square s = depth_maps_square(d);
    for (uint32_t j = 0; j < d->side_px / 8; j++)
        for (uint32_t i = 0; i < d->side_px / 8; i++) {
            column_tile t;
            assert_int_equal(s.tile(s.data, i, j, &t), VXS_OK);
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

/* Logarithmic depths of every kind of field: nearest, far, beyond the far side, no caster (both zeros), and many between. */
static void logarithmic_depths(void **state)
{
    static const double ratios[] = {1.001, 2, 100, 1e4, 1e7};
    (void)state;
    for (uint32_t depth = 8; depth <= 16384; depth *= 8)
        for (size_t ratio = 0; ratio < sizeof ratios / sizeof *ratios; ratio++)
            for (int with_exit = 0; with_exit < 2; with_exit++) {
                depth_maps  d;
                rng         r = rng_split(depth, ratio);
                run_context m = {0};
                assert_int_equal(depth_maps_init(&d, 64, depth, log(ratios[ratio]) / depth, with_exit, &m), VXS_OK);
                for (int n = 0; n < 64 * 64; n++) {
                    int      ends  = n / 8 % 2; /* every other tile has casters everywhere, before the far side */
                    double   share = pow(ratios[ratio], -(double)random_unit(&r) * (ends ? 1.2 : 0.8));
                    double   more  = pow(ratios[ratio], -(double)random_unit(&r) * 0.1);
                    uint32_t kind  = ends ? rng_below(&r, 16) : 16;
                    d.enter[n]     = kind == 0 ? -1 : kind == 1 ? 0 : kind == 2 ? -0.0f : kind == 3 ? -1e-30f : (float)-share;
                    if (with_exit) d.exit[n] = rng_below(&r, 4) ? fmaxf(d.enter[n], (float)(-share * more)) : d.enter[n];
                }
                depth_maps_reduce(&d, 2);
                assert_pyramid(&d);
                assert_tiles(&d);
                for (int n = 0; n < 64 * 64; n++) {
                    double found = stored_voxels(&d, d.enter[n]);
                    assert_true(found >= 0 && found <= depth && fabs(found - (double)voxels(&d, d.enter[n])) <= 1e-11 * depth);
                }
                depth_maps_free(&d);
            }
}

/* Farther is never nearer, float by float. */
static void logarithms_keep_order(void **state)
{
    (void)state;
    depth_maps  d;
    run_context m = {0};
    rng         r = {5};
    assert_int_equal(depth_maps_init(&d, 8, 512, log(1e7) / 512, 0, &m), VXS_OK);
    assert_true(stored_voxels(&d, -1) == 0);
    assert_true(stored_voxels(&d, 0) == 512 && stored_voxels(&d, -0.0f) == 512 && stored_voxels(&d, -1e-45f) == 512);
    for (int n = 0; n < 20000; n++) {
        float depth = -powf(1e-7f, random_unit(&r));
        for (int k = 0; k < 20; k++) {
            float next = nextafterf(depth, 1);
            assert_true(stored_voxels(&d, next) >= stored_voxels(&d, depth));
            depth = next;
        }
    }
    depth_maps_free(&d);
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
        cmocka_unit_test(logarithmic_depths),
        cmocka_unit_test(logarithms_keep_order),
        cmocka_unit_test(one_array_serves_both_when_all_are_sheets),
        cmocka_unit_test(reducing_again_follows_the_maps),
    };
    return cmocka_run_group_tests_name("depth_maps", tests, NULL, NULL);
}
