/* Lookups in a light's words, against a dense array of every voxel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup.h" /* first: it needs nothing before it */

#include "dag_sample.h"
#include "runtime/vxs.h"
#include "smooth_box.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* A sample, and the words of its light. */
typedef struct subject {
    dag_sample sample;
    vxs_asset *asset;
} subject;

static subject subject_make(uint64_t seed, uint32_t levels, uint32_t count_max)
{
    subject s = {0};
    rng     r = {seed};
    dag_sample_init(&s.sample, &r, levels, count_max);
    vxs_bytes file = dag_sample_file(&s.sample);
    assert_int_equal(vxs_asset_open(&s.asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    return s;
}

static void subject_free(subject *s)
{
    vxs_asset_close(s->asset);
    dag_sample_free(&s->sample);
}

/* Shadowed taps of a box, one at a time; what is outside the map is lit. */
static uint32_t count_taps(const dag_sample *s, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    int32_t  side = 1 << s->levels, half_px = width_px / 2;
    uint32_t count = 0;
    for (int32_t y = j - half_px; y <= j + half_px; y++)
        for (int32_t x = i - half_px; x <= i + half_px; x++)
            if (x >= 0 && y >= 0 && x < side && y < side) count += dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, k);
    return count;
}

/* The shadowed part of a smooth box, one tap at a time, of 65536 for each texel. */
static uint32_t weigh_taps(const dag_sample *s, int32_t i, int32_t j, uint32_t across, uint32_t down, uint32_t k, int width)
{
    int32_t  side = 1 << s->levels, reach = width / 2 + 1;
    uint32_t sum = 0;
    for (int32_t y = j - reach; y <= j + reach; y++)
        for (int32_t x = i - reach; x <= i + reach; x++)
            if (x >= 0 && y >= 0 && x < side && y < side && dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, k))
                sum += smooth_overlap(x, i, across, width) * smooth_overlap(y, j, down, width);
    return sum;
}

static void test_popcount(void **state)
{
    (void)state;
    rng r = {1};
    for (int n = 0; n < 100000; n++) {
        uint32_t x = rng_u32(&r) & rng_u32(&r), bits = 0;
        for (int bit = 0; bit < 32; bit++) bits += x >> bit & 1;
        assert_int_equal(vxs_popcount(x), bits);
    }
    assert_int_equal(vxs_popcount(0u), 0);
    assert_int_equal(vxs_popcount(0xffffffffu), 32);
}

/* Every range that starts or ends inside a mask, or beyond it. */
static void test_cover(void **state)
{
    const vxs_mask mask = {0x9d03c5a7, 0x71e4f08b};
    (void)state;
    for (int32_t x0 = -17; x0 <= 9; x0++)
        for (int32_t x1 = x0; x1 <= 25; x1++)
            for (int32_t y0 = -17; y0 <= 9; y0++)
                for (int32_t y1 = y0; y1 <= 25; y1++) {
                    uint32_t wanted = 0;
                    for (int32_t bit = 0; bit < 64; bit++)
                        if (bit % 8 >= x0 && bit % 8 < x1 && bit / 8 >= y0 && bit / 8 < y1)
                            wanted += (bit < 32 ? mask.low : mask.high) >> bit % 32 & 1;
                    assert_int_equal(vxs_count_covered(mask, x0, x1, y0, y1), wanted);
                }
}

/* Every voxel, every filter, every centre near enough to touch a map of 32 x 32 texels: by a table of sums over the map. */
static void test_count_exhaustive(void **state)
{
    (void)state;
    enum { SIDE = 32, PAD = 20, TABLE = SIDE + 2 * PAD + 1 };
    subject                s     = subject_make(11, 5, 40);
    const vxs_baked_light *light = vxs_asset_light(s.asset, 0);
    for (uint32_t k = 0; k < SIDE; k++) {
        static uint32_t sum[TABLE][TABLE]; /* shadowed texels in front of (x, y), both counted from -PAD */
        for (int y = 1; y < TABLE; y++)
            for (int x = 1; x < TABLE; x++) {
                int      i = x - 1 - PAD, j = y - 1 - PAD;
                uint32_t shadow =
                    i >= 0 && j >= 0 && i < SIDE && j < SIDE && dag_sample_shadow(&s.sample, (uint32_t)i, (uint32_t)j, k);
                sum[y][x] = shadow + sum[y - 1][x] + sum[y][x - 1] - sum[y - 1][x - 1];
            }
        for (int width_px = 1; width_px <= VXS_FILTER_MAX; width_px += 2)
            for (int j = -10; j < SIDE + 10; j++)
                for (int i = -10; i < SIDE + 10; i++) {
                    int      x0 = i - width_px / 2 + PAD, x1 = x0 + width_px, y0 = j - width_px / 2 + PAD, y1 = y0 + width_px;
                    uint32_t wanted = sum[y1][x1] - sum[y0][x1] - sum[y1][x0] + sum[y0][x0];
                    if (vxs_shadow_count(light->words, 0, light->light.levels, i, j, k, width_px) != wanted)
                        fail_msg("texel %d %d, depth %u, filter %d", i, j, k, width_px);
                }
    }
    subject_free(&s);
}

/* A texel near what may go wrong: borders of tiles, corners of the map, just outside and far outside. */
static int32_t tricky_texel(rng *r, int32_t side)
{
    switch (rng_below(r, 8)) {
    case 0: return rng_between(r, -12, 12);
    case 1: return side + rng_between(r, -12, 12);
    case 2: return 8 * rng_between(r, 0, side / 8) + rng_between(r, -1, 1);
    case 3: return side / 2 + rng_between(r, -9, 9);
    case 4: return rng_below(r, 16) ? rng_between(r, -side, 2 * side) : rng_below(r, 2) ? -(1 << 30) : 1 << 30;
    default: return rng_between(r, 0, side - 1);
    }
}

static void test_lookups_random(void **state)
{
    (void)state;
    rng r = {3};
    for (uint32_t levels = 3; levels <= 8; levels++) {
        subject                s     = subject_make(20 + levels, levels, levels < 5 ? 12 : 200);
        const vxs_baked_light *light = vxs_asset_light(s.asset, 0);
        uint32_t               side  = 1u << levels;
        for (int n = 0; n < 10000; n++) {
            int32_t  i = tricky_texel(&r, (int32_t)side), j = tricky_texel(&r, (int32_t)side);
            uint32_t k        = rng_below(&r, side);
            int32_t  width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
            assert_int_equal(vxs_shadow_count(light->words, 0, levels, i, j, k, width_px),
                             count_taps(&s.sample, i, j, k, width_px));
            if (i < 0 || j < 0 || i >= (int32_t)side || j >= (int32_t)side) continue;
            assert_int_equal(vxs_shadow(light->words, 0, levels, (uint32_t)i, (uint32_t)j, k),
                             dag_sample_shadow(&s.sample, (uint32_t)i, (uint32_t)j, k));
        }
        subject_free(&s);
    }
}

/* Parts of a texel where something may change: none, all but none, the middle, and any. */
static uint32_t tricky_part(rng *r)
{
    static const uint32_t parts[] = {0, 1, 127, 128, 129, 255};
    return rng_below(r, 2) ? parts[rng_below(r, 6)] : rng_below(r, 256);
}

static void test_smooth_random(void **state)
{
    (void)state;
    rng      r      = {4};
    uint32_t partly = 0;
    for (uint32_t levels = 3; levels <= 8; levels++) {
        subject                s     = subject_make(30 + levels, levels, levels < 5 ? 12 : 200);
        const vxs_baked_light *light = vxs_asset_light(s.asset, 0);
        uint32_t               side  = 1u << levels;
        for (int n = 0; n < 10000; n++) {
            int32_t  i = tricky_texel(&r, (int32_t)side), j = tricky_texel(&r, (int32_t)side);
            uint32_t k = rng_below(&r, side), across = tricky_part(&r), down = tricky_part(&r);
            int32_t  width  = rng_between(&r, 1, VXS_FILTER_MAX);
            uint32_t wanted = weigh_taps(&s.sample, i, j, across, down, k, width);
            assert_int_equal(vxs_shadow_weight(light->words, 0, levels, i, j, across, down, k, width), wanted);
            partly += wanted > 0 && wanted < 65536u * (uint32_t)(width * width);
        }
        subject_free(&s);
    }
    assert_in_range(partly, 10000, 60000);
}

/* Of odd width about a texel's middle, and of even width about its corner, it is a box of whole texels; all of the widest fits 32
 * bits. */
static void test_smooth_of_whole_texels(void **state)
{
    (void)state;
    subject                s     = subject_make(12, 6, 100);
    const vxs_baked_light *light = vxs_asset_light(s.asset, 0);
    rng                    r     = {5};
    for (int n = 0; n < 20000; n++) {
        int32_t  i = rng_between(&r, -9, 72), j = rng_between(&r, -9, 72), width = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
        uint32_t k = rng_below(&r, 64), count = vxs_shadow_count(light->words, 0, 6, i, j, k, width);
        assert_int_equal(vxs_shadow_weight(light->words, 0, 6, i, j, 128, 128, k, width), 65536 * count);
        assert_int_equal(vxs_shadow_weight(light->words, 0, 6, i, j, 0, 0, k, 2),
                         65536 * (count_taps(&s.sample, i, j, k, 1) + count_taps(&s.sample, i - 1, j, k, 1) +
                                  count_taps(&s.sample, i, j - 1, k, 1) + count_taps(&s.sample, i - 1, j - 1, k, 1)));
    }
    subject_free(&s);

    const uint32_t all_shadow[] = {0x5555};
    for (uint32_t part = 0; part < 256; part++)
        assert_int_equal(vxs_shadow_weight(all_shadow, 0, 8, 100, 100, part, 255 - part, 9, VXS_FILTER_MAX),
                         65536 * VXS_FILTER_MAX * VXS_FILTER_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_popcount),       cmocka_unit_test(test_cover),         cmocka_unit_test(test_count_exhaustive),
        cmocka_unit_test(test_lookups_random), cmocka_unit_test(test_smooth_random), cmocka_unit_test(test_smooth_of_whole_texels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
