/* Queries with any numbers: at the ends of their types, beside maps, of lights that do not have such maps; and answers at any
 * address. Each has an answer or an error.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>

#include "query_lights.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const int32_t any_int[] = {INT32_MIN, INT32_MIN + 1, -(1 << 30),    -257,     -8, -2, -1, 0, 1, 5, 7, 8, 31,
                                  32,        1 << 30,       INT32_MAX - 1, INT32_MAX};

static int32_t an_int(rng *r)
{
    return rng_below(r, 4) ? any_int[rng_below(r, sizeof any_int / sizeof *any_int)] : rng_between(r, -40, 40);
}

static void check_depth_map(rng *r, const vxs_baked_light *l)
{
    enum { SIDE = 3 };
    uint32_t           voxels[SIDE * SIDE + 1], side = 1u << l->light.levels;
    float              depths[SIDE * SIDE + 1];
    vxs_depth_map_desc d     = {.map     = rng_below(r, 2) ? 0 : an_int(r),
                                .i       = an_int(r),
                                .j       = an_int(r),
                                .wide_px = rng_below(r, SIDE + 1),
                                .high_px = rng_below(r, SIDE + 1),
                                .shift   = rng_below(r, 2) ? rng_below(r, 20) : (uint32_t)an_int(r),
                                .which   = rng_below(r, 4),
                                .voxels  = rng_below(r, 4) ? voxels : NULL,
                                .depths  = rng_below(r, 4) ? depths : NULL};
    uint32_t           count = d.wide_px * d.high_px;
    int                coarse;
    voxels[count] = 12345;
    depths[count] = 12345;
    if (vxs_depth_map(l, &d, &coarse) == VXS_OK)
        for (uint32_t n = 0; n < count; n++) {
            if (d.voxels) assert_in_range(voxels[n], 0, side);
            if (d.depths) assert_true(depths[n] >= 0 && depths[n] <= 1);
        }
    assert_true(voxels[count] == 12345 && depths[count] == 12345);
}

static void check_numbers(rng *r, const vxs_baked_light *l)
{
    static const double wild[] = {NAN, INFINITY, -INFINITY, 1e30, -1e300, 0, 3.5};
    int32_t             side = 1 << l->light.levels, map, maps = (int32_t)vxs_map_count(&l->light);
    for (int n = 0; n < 4000; n++) {
        int32_t i = an_int(r), j = an_int(r);
        double  at[3], point[3];
        int     coarse;
        map            = rng_below(r, 2) ? rng_between(r, 0, 5) : an_int(r);
        int32_t first  = vxs_first_shadow(l, map, i, j, &coarse);
        int     inside = map >= 0 && map < maps && i >= 0 && i < side && j >= 0 && j < side;
        assert_true(inside ? first >= 0 && first <= side : first == -1);
        for (int k = 0; k < 3; k++) at[k] = rng_below(r, 3) ? rng_between(r, 0, side) : wild[rng_below(r, 7)];
        vxs_point(&l->light, map, at, point);
        double as_held[3];
        vxs_point(&l->light, map < 0 ? 0 : map < maps ? map : maps - 1, at, as_held);
        for (int k = 0; k < 3; k++) assert_true(point[k] == as_held[k] || isnan(point[k]));
        check_depth_map(r, l);
    }
}

/* Any numbers of maps, texels, voxels and sizes, for all kinds of lights in both codings. */
static void test_numbers(void **state)
{
    (void)state;
    rng           r = {7};
    blocks_sample blocks;
    dag_sample    dag;
    blocks_sample_init(&blocks, &r, 5, 6, 6);
    dag_sample_init(&dag, &r, 5, 100);
    vxs_asset *asset = dag_asset(&dag);
    for (int kind = 0; kind < LIGHTS; kind++) {
        vxs_baked_light l = blocks_light(blocks.words, 5, kind);
        check_numbers(&r, &l);
        check_numbers(&r, vxs_asset_light(asset, (uint32_t)kind));
    }
    vxs_asset_close(asset);
    dag_sample_free(&dag);
    blocks_sample_free(&blocks);
}

/* The widest rectangles there are, beside the largest map there is. */
static void test_widest_depth_map(void **state)
{
    (void)state;
    enum { LEVELS = 18, WIDE = 1 << (30 - LEVELS), FAR = 1 << 30 };
    rng           r = {8};
    blocks_sample s;
    blocks_sample_init(&s, &r, LEVELS, 1, 2);
    vxs_baked_light l      = blocks_light(s.words, LEVELS, 0);
    uint32_t       *voxels = calloc(2 * WIDE, sizeof *voxels);
    for (uint32_t which = 0; which <= VXS_DEPTH_GREATEST; which++)
        for (int n = 0; n < 4; n++) {
            vxs_depth_map_desc d = {
                .i = -FAR, .j = -FAR, .wide_px = WIDE, .high_px = 1, .shift = LEVELS, .which = which, .voxels = voxels};
            if (n == 1) d.i = 0, d.j = 1 << LEVELS;
            if (n >= 2) d.wide_px *= 2; /* as many texels as the numbers from -2^30 to 2^30, which no int32_t counts */
            if (n == 3) {
                d.high_px = d.wide_px;
                d.wide_px = 1;
            }
            voxels[WIDE - 1] = 0;
            assert_int_equal(vxs_depth_map(&l, &d, NULL), n < 2 ? VXS_OK : VXS_E_ARGUMENT);
            assert_int_equal(voxels[WIDE - 1], n < 2 ? 1 << LEVELS : 0);
        }
    free(voxels);
    blocks_sample_free(&s);
}

/* Answers at any address, at any distance from one another. */
static void test_answers_anywhere(void **state)
{
    (void)state;
    enum { COUNT = 150 };
    rng           r = {9};
    blocks_sample s;
    blocks_sample_init(&s, &r, 5, 1, 1);
    vxs_baked_light l = blocks_light(s.words, 5, 0);
    double          points[3 * COUNT];
    unsigned char   answers[COUNT * 23 + 8];
    for (int n = 0; n < COUNT; n++) {
        double at[3];
        for (int k = 0; k < 3; k++) at[k] = rng_between(&r, -100, 3300) / 100.0;
        vxs_point(&l.light, 0, at, points + 3 * n);
    }
    static const vxs_filter filters[] = {{5, 0}, {5, 1}, {261, 0}, {517, 1}};
    for (size_t stride = 4; stride < 23; stride++)
        for (int f = 0; f < 4; f++) {
            vxs_batch b = {.points_ws        = {.data = points},
                           .count            = COUNT,
                           .filter           = filters[f],
                           .lit              = (float *)(void *)(answers + stride % 5),
                           .lit_stride_bytes = stride};
            assert_int_equal(vxs_lookup_batch(&l, 1, &b), VXS_OK);
            for (size_t n = 0; n < COUNT; n++) {
                float lit;
                memcpy(&lit, answers + stride % 5 + n * stride, sizeof lit);
                assert_true(lit == vxs_lookup(&l, points + 3 * n, NULL, filters[f]));
            }
        }
    blocks_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_widest_depth_map),
        cmocka_unit_test(test_answers_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
