/* Depths read from palette blocks, of squares and of tiles, against the depths that the words were written from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "runtime/tile_depths.h" /* first: it needs nothing before it */

#include "blocks_sample.h"
#include "tests/unit/repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static int32_t depth_at(const blocks_sample *s, uint32_t map, int32_t i, int32_t j)
{
    int32_t side = 1 << s->levels, depth = blocks_sample_depth(s, map, (uint32_t)i, (uint32_t)j);
    return depth < side ? depth : side;
}

/* All texels of what was found are as it says; of large squares, some. */
static void check_square(const blocks_sample *s, rng *r, uint32_t map, int32_t i, int32_t j, int32_t k, int32_t least_px)
{
    vxs_depth_square q = vxs_depth_square_at((vxs_blocks_map){s->words, map, s->levels}, i, j, k, least_px);
    assert_true(q.i <= i && i < q.i + q.side_px && q.j <= j && j < q.j + q.side_px);
    assert_int_equal(q.coarse, 0);
    assert_in_range(q.greatest, q.least, 1 << s->levels);
    if (q.side_px > least_px) assert_true(q.least == q.greatest || (k >= 0 && (k < q.least || k >= q.greatest)));
    int32_t area = q.side_px * q.side_px, step = area > 1024 ? 1 + rng_between(r, 0, 2 * area / 256) : 1;
    for (int32_t n = 0; n < area; n += step) {
        int32_t x = q.i + n % q.side_px, y = q.j + n / q.side_px, depth = depth_at(s, map, x, y);
        if (depth < q.least || depth > q.greatest)
            fail_msg("levels %u, map %u, texel %d %d: depth %d, square of %d from %d %d has %d to %d", s->levels, map, x, y, depth,
                     q.side_px, q.i, q.j, q.least, q.greatest);
    }
}

static void check_tile(const blocks_sample *s, vxs_block_cursor *cursor, uint32_t map, int32_t tile_x, int32_t tile_y)
{
    int32_t depth[64];
    int     found = vxs_tile_depths((vxs_blocks_map){s->words, map, s->levels}, cursor, tile_x, tile_y, depth);
    assert_int_not_equal(found, VXS_TILE_MISSING);
    for (int n = 0; n < 64; n++) {
        if (found == VXS_TILE_WHOLE) depth[n] = depth[0];
        int32_t i = 8 * tile_x + n % 8, j = 8 * tile_y + n / 8;
        if (depth[n] != depth_at(s, map, i, j))
            fail_msg("levels %u, map %u, texel %d %d: depth %d, expected %d", s->levels, map, i, j, depth[n],
                     depth_at(s, map, i, j));
    }
}

/* Every tile of every square with more than one depth; and squares about texels of it, at all depths that decide something. */
static void check_map(const blocks_sample *s, rng *r, uint32_t map)
{
    uint32_t         wide = s->squares_wide, side = 1u << s->levels, tiles = side < 256 ? side / 8 : 32;
    vxs_block_cursor cursor = {0};
    for (uint32_t n = 0; n < wide * wide; n++) {
        if (s->map[map][n] >= 0 && rng_below(r, wide < 64 ? 64 : repeats(2048, 64))) continue;
        for (uint32_t t = 0; t < tiles * tiles; t++)
            check_tile(s, &cursor, map, (int32_t)(n % wide * 32 + t % tiles), (int32_t)(n / wide * 32 + t / tiles));
        for (uint32_t count = 0; count < repeats(60, 3000); count++) {
            static const int32_t leasts[5] = {1, 1, VXS_TILE_PX, VXS_BLOCK_PX, VXS_SQUARE_PX};
            int32_t              i         = (int32_t)(n % wide * 256 + rng_below(r, 8 * tiles)),
                    j                      = (int32_t)(n / wide * 256 + rng_below(r, 8 * tiles));
            int32_t k                      = depth_at(s, map, i, j) + rng_between(r, -1, 0);
            check_square(s, r, map, i, j, rng_below(r, 4) ? k : -1, leasts[rng_below(r, 5)]);
        }
    }
}

static void test_depths(void **state)
{
    (void)state;
    static const struct {
        uint32_t levels, maps, squares;
    } cases[]         = {{3, 2, 2}, {4, 1, 1}, {5, 6, 6},   {6, 1, 1},   {7, 1, 1},
                         {8, 2, 2}, {9, 2, 6}, {11, 1, 20}, {15, 1, 12}, {18, 1, 12}};
    blocks_sample all = {0};
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++)
        for (uint64_t seed = 0; seed < (cases[n].levels < 9 ? repeats(2, 4) : 1); seed++) {
            blocks_sample s;
            rng           r = {100 * n + seed};
            blocks_sample_init(&s, &r, cases[n].levels, cases[n].maps, cases[n].squares);
            for (uint32_t map = 0; map < s.map_count; map++) check_map(&s, &r, map);
            for (int kind = 0; kind < BLOCKS_KINDS; kind++) all.kinds[kind] += s.kinds[kind];
            for (int width = 0; width < 3; width++) all.widths[width] += s.widths[width];
            all.images += s.images;
            all.planes += s.planes;
            blocks_sample_free(&s);
        }
    for (int kind = 0; kind < BLOCKS_KINDS; kind++) assert_in_range(all.kinds[kind], 100, UINT32_MAX);
    for (int width = 0; width < 3; width++) assert_in_range(all.widths[width], 100, UINT32_MAX);
    assert_in_range(all.images, 100, UINT32_MAX);
    assert_in_range(all.planes, 100, UINT32_MAX);
}

/* Without its page a square has one depth: that of the coarse answer, with bounds that hold of the file. */
static void test_missing_pages(void **state)
{
    (void)state;
    blocks_sample s;
    rng           r      = {6};
    int           coarse = 0;
    blocks_sample_init(&s, &r, 10, 1, 14);
    for (uint32_t page = 0; page < s.page_count; page++) s.words[8 + page] = 0;
    for (int n = 0; n < 2000; n++) {
        int32_t          i = rng_between(&r, 0, 1023), j = rng_between(&r, 0, 1023);
        vxs_blocks_map   map = {s.words, 0, s.levels};
        vxs_depth_square q   = vxs_depth_square_at(map, i, j, -1, 1);
        vxs_block_cursor c   = {0};
        int32_t          depth[64];
        assert_int_equal(q.side_px, 256);
        assert_int_equal(q.least, q.greatest);
        assert_int_equal(vxs_tile_depths(map, &c, i / 8, j / 8, depth) == VXS_TILE_MISSING, q.coarse);
        if (q.least > 0) assert_int_equal(vxs_blocks_shadow(s.words, 0, 10, (uint32_t)i, (uint32_t)j, (uint32_t)q.least - 1), 0);
        if (q.least < 1024) assert_int_equal(vxs_blocks_shadow(s.words, 0, 10, (uint32_t)i, (uint32_t)j, (uint32_t)q.least), 1);
        if (q.coarse) assert_true(q.low <= depth_at(&s, 0, i, j) && depth_at(&s, 0, i, j) <= q.high);
        coarse += q.coarse;
    }
    assert_in_range(coarse, 100, 2000);
    blocks_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_depths),
        cmocka_unit_test(test_missing_pages),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
