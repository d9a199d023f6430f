/* Where light first ends, and depth maps of that: against samples, voxel by voxel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before blocks.h, whose blocks it calls so, too */

#include "query_lights.h"
#include "tests/unit/repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* What tests know of a light's voxels: one of the samples. */
typedef struct truth_of {
    const blocks_sample *blocks;
    dag_sample          *dag; /* that shows the map */
} truth_of;

static uint32_t is_dark(const truth_of *t, uint32_t map, int32_t i, int32_t j, int32_t k)
{
    if (t->blocks) return blocks_sample_shadow(t->blocks, map, (uint32_t)i, (uint32_t)j, (uint32_t)k);
    return dag_sample_shadow(t->dag, (uint32_t)i, (uint32_t)j, (uint32_t)k);
}

static int32_t first_dark(const truth_of *t, uint32_t map, int32_t i, int32_t j, int32_t side)
{
    int32_t k = 0;
    if (t->blocks) k = blocks_sample_depth(t->blocks, map, (uint32_t)i, (uint32_t)j);
    while (k < side && !is_dark(t, map, i, j, k)) k++;
    return k < side ? k : side;
}

/* A depth map of any part of a map, and beside it, at any resolution, a texel at a time. */
static void check_depth_map(rng *r, const vxs_baked_light *l, const truth_of *t, uint32_t map)
{
    enum { WIDE = 40, PITCH = 43 };
    static uint32_t    voxels[WIDE * PITCH];
    static float       depths[WIDE * PITCH];
    int32_t            side = 1 << l->light.levels;
    vxs_depth_map_desc d    = {.struct_size = sizeof d, .map = (int32_t)map, .voxels = voxels, .depths = depths};
    d.shift                 = rng_below(r, 4) ? rng_below(r, l->light.levels < 5 ? l->light.levels : 5) : 0;
    d.which                 = rng_below(r, 3);
    d.i                     = rng_between(r, -20, side - 1);
    d.j                     = rng_between(r, -20, side - 1);
    d.wide_px               = 1 + rng_below(r, WIDE);
    d.high_px               = 1 + rng_below(r, WIDE >> d.shift);
    d.row_stride_bytes      = rng_below(r, 2) ? PITCH * sizeof *voxels : 0;
    size_t pitch            = d.row_stride_bytes ? PITCH : d.wide_px;
    for (int n = 0; n < WIDE * PITCH; n++) depths[n] = (float)(voxels[n] = 77777);
    int coarse = 7;
    assert_int_equal(vxs_depth_map(l, &d, &coarse), VXS_OK);
    assert_int_equal(coarse, 0);
    for (uint32_t y = 0; y < d.high_px; y++)
        for (uint32_t x = 0; x < d.wide_px; x++) {
            int32_t size = 1 << d.shift, wanted = d.which == VXS_DEPTH_GREATEST ? 0 : side;
            for (int32_t n = 0; n < size * size; n++) {
                int32_t u = n % size, v = n / size, i = d.i + (int32_t)x * size + u, j = d.j + (int32_t)y * size + v;
                int32_t depth = i < 0 || j < 0 || i >= side || j >= side ? side : first_dark(t, map, i, j, side);
                if (d.which == VXS_DEPTH_CENTRE && u == size / 2 && v == size / 2) wanted = depth;
                if (d.which == VXS_DEPTH_LEAST && depth < wanted) wanted = depth;
                if (d.which == VXS_DEPTH_GREATEST && depth > wanted) wanted = depth;
            }
            if (voxels[y * pitch + x] != (uint32_t)wanted)
                fail_msg("levels %u, pixel %u %u of %u x %u from %d %d, shift %u, which %u: %u, expected %d", l->light.levels, x, y,
                         d.wide_px, d.high_px, d.i, d.j, d.shift, d.which, voxels[y * pitch + x], wanted);
            assert_true(depths[y * pitch + x] == (float)wanted / (float)side);
            voxels[y * pitch + x] = 77777;
        }
    for (int n = 0; n < WIDE * PITCH; n++) assert_int_equal(voxels[n], 77777);
}

static void check_light(rng *r, const vxs_baked_light *l, const truth_of *t, uint32_t map)
{
    int32_t side = 1 << l->light.levels;
    int     coarse;
    for (uint32_t n = 0; n < repeats(300, 3000); n++) {
        int32_t i = rng_between(r, 0, side - 1), j = rng_between(r, 0, side - 1);
        assert_int_equal(vxs_first_shadow(l, (int)map, i, j, n % 2 ? NULL : &coarse), first_dark(t, map, i, j, side));
        if (n % 2 == 0) assert_int_equal(coarse, 0);
    }
    for (uint32_t n = 0; n < repeats(12, 200); n++) check_depth_map(r, l, t, map);
}

static void test_blocks(void **state)
{
    (void)state;
    static const uint32_t levels[] = {3, 5, 8, 10, 15};
    for (size_t n = 0; n < sizeof levels / sizeof *levels; n++) {
        blocks_sample s;
        rng           r = {40 + n};
        blocks_sample_init(&s, &r, levels[n], levels[n] < 10 ? 6 : 1, 6);
        for (int kind = 0; kind < (s.map_count == 6 ? LIGHTS : 3); kind++) {
            vxs_baked_light l = blocks_light(s.words, levels[n], kind);
            for (uint32_t map = 0; map < vxs_map_count(&l.light); map++) check_light(&r, &l, &(truth_of){.blocks = &s}, map);
        }
        blocks_sample_free(&s);
    }
}

static void test_dags(void **state)
{
    (void)state;
    for (uint32_t levels = 3; levels <= 8; levels++) {
        dag_sample s;
        rng        r = {50 + levels};
        dag_sample_init(&s, &r, levels, levels < 5 ? 20 : 200);
        vxs_asset *asset = dag_asset(&s);
        for (uint32_t kind = 0; kind < LIGHTS; kind++) {
            const vxs_baked_light *l = vxs_asset_light(asset, kind);
            for (uint32_t map = 0; map < vxs_map_count(&l->light); map++) {
                dag_sample_show(&s, map);
                check_light(&r, l, &(truth_of){.dag = &s}, map);
            }
        }
        vxs_asset_close(asset);
        dag_sample_free(&s);
    }
}

/* Without pages, depths are those of lookups and are reported as coarse; depths that are not reported as coarse are those of the
 * whole file. */
static void test_missing_pages(void **state)
{
    (void)state;
    blocks_sample s;
    rng           r     = {7};
    int           count = 0, coarse, map_is_coarse;
    blocks_sample_init(&s, &r, 10, 1, 14);
    for (uint32_t page = 0; page < s.page_count; page += 2) s.words[8 + page] = 0;
    vxs_baked_light l = blocks_light(s.words, 10, 0);
    for (int n = 0; n < 20000; n++) {
        int32_t  i = rng_between(&r, 0, 1023), j = rng_between(&r, 0, 1023), first = vxs_first_shadow(&l, 0, i, j, &coarse);
        uint32_t depth;
        if (!coarse) assert_int_equal(blocks_sample_depth(&s, 0, (uint32_t)i, (uint32_t)j), first);
        if (first < 1024) assert_int_equal(vxs_blocks_shadow(s.words, 0, 10, (uint32_t)i, (uint32_t)j, (uint32_t)first), 1);
        if (first > 0) assert_int_equal(vxs_blocks_shadow(s.words, 0, 10, (uint32_t)i, (uint32_t)j, (uint32_t)first - 1), 0);
        vxs_depth_map_desc d = {.i = i, .j = j, .wide_px = 1, .high_px = 1, .voxels = &depth};
        assert_int_equal(vxs_depth_map(&l, &d, &map_is_coarse), VXS_OK);
        assert_int_equal(depth, first);
        assert_int_equal(map_is_coarse, coarse);
        count += coarse;
    }
    assert_in_range(count, 100, 20000);
    blocks_sample_free(&s);
}

static void test_arguments(void **state)
{
    (void)state;
    blocks_sample s;
    rng           r = {1};
    uint32_t      out[4];
    blocks_sample_init(&s, &r, 5, 1, 1);
    vxs_baked_light l = blocks_light(s.words, 5, 0);
    assert_int_equal(vxs_first_shadow(&l, 0, -1, 3, NULL), -1);
    assert_int_equal(vxs_first_shadow(&l, 0, 3, 32, NULL), -1);
    assert_int_equal(vxs_first_shadow(&l, 1, 3, 3, NULL), -1);
    assert_int_equal(vxs_first_shadow(&l, -1, 3, 3, NULL), -1);

    const vxs_depth_map_desc good = {.wide_px = 2, .high_px = 2, .voxels = out};
    vxs_depth_map_desc       bad[8];
    for (int n = 0; n < 8; n++) bad[n] = good;
    assert_int_equal(vxs_depth_map(&l, &good, NULL), VXS_OK);
    bad[0].map         = 1;
    bad[1].map         = -1;
    bad[2].shift       = 6;
    bad[3].which       = 3;
    bad[4].i           = INT32_MIN;
    bad[5].j           = 1 << 30;
    bad[6].wide_px     = UINT32_MAX;
    bad[7].struct_size = 4;
    for (int n = 0; n < 8; n++) assert_int_equal(vxs_depth_map(&l, &bad[n], NULL), VXS_E_ARGUMENT);
    blocks_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks),
        cmocka_unit_test(test_dags),
        cmocka_unit_test(test_missing_pages),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
