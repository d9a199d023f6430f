/* Lookups in palette blocks, by vectors and word by word, against the depths that the words were written from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* first: it needs nothing before it */

#include "blocks_sample.h"
#include "blocks_scalar.h"
#include "formats/vxs_format.h"
#include "smooth_box.h"
#include "tests/unit/repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* Filters that would have had taps of both kinds. */
static uint32_t mixed_filters;

static void check_voxel(const blocks_sample *s, uint32_t map, uint32_t i, uint32_t j, uint32_t k)
{
    uint32_t wanted = blocks_sample_shadow(s, map, i, j, k), found = vxs_blocks_shadow(s->words, map, s->levels, i, j, k);
    uint32_t scalar = scalar_shadow(s->words, map, s->levels, i, j, k);
    if (found != wanted || scalar != wanted)
        fail_msg("levels %u, map %u, voxel %u %u %u: %u, scalar %u, expected %u", s->levels, map, i, j, k, found, scalar, wanted);
}

/* One tap at a time; what is outside the map is lit. Where a tap is not known, all are coarse. */
static void check_filter(const blocks_sample *s, uint32_t map, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    int32_t  side = 1 << s->levels, half_px = width_px / 2;
    uint32_t wanted = 0, coarse = 0, full = 1;
    for (int32_t y = j - half_px; y <= j + half_px; y++)
        for (int32_t x = i - half_px; x <= i + half_px; x++) {
            if (x < 0 || y < 0 || x >= side || y >= side) continue;
            wanted += blocks_sample_shadow(s, map, (uint32_t)x, (uint32_t)y, k);
            coarse += blocks_sample_coarse(s, map, (uint32_t)x, (uint32_t)y, k);
            full &= (uint32_t)blocks_sample_is_full(s, map, (uint32_t)x, (uint32_t)y, k);
        }
    if (!full && coarse != wanted) mixed_filters++;
    if (!full) wanted = coarse;
    uint32_t found  = vxs_blocks_shadow_count(s->words, map, s->levels, i, j, k, width_px);
    uint32_t scalar = scalar_shadow_count(s->words, map, s->levels, i, j, k, width_px);
    if (found != wanted || scalar != wanted)
        fail_msg("levels %u, map %u, texel %d %d, depth %u, filter %d: %u, scalar %u, expected %u", s->levels, map, i, j, k,
                 width_px, found, scalar, wanted);
    assert_int_equal(vxs_blocks_is_full(s->words, map, s->levels, i, j, k, width_px), full);
    assert_int_equal(scalar_is_full(s->words, map, s->levels, i, j, k, width_px), full);
}

static void check_smooth(const blocks_sample *s, uint32_t map, int32_t i, int32_t j, uint32_t across, uint32_t down, uint32_t k,
                         int width)
{
    int32_t  side = 1 << s->levels, reach = width / 2 + 1;
    uint32_t wanted = 0, coarse = 0, full = 1;
    for (int32_t y = j - reach; y <= j + reach; y++)
        for (int32_t x = i - reach; x <= i + reach; x++) {
            uint32_t part = smooth_overlap(x, i, across, width) * smooth_overlap(y, j, down, width);
            if (x < 0 || y < 0 || x >= side || y >= side || !part) continue;
            wanted += part * blocks_sample_shadow(s, map, (uint32_t)x, (uint32_t)y, k);
            coarse += part * blocks_sample_coarse(s, map, (uint32_t)x, (uint32_t)y, k);
            full &= (uint32_t)blocks_sample_is_full(s, map, (uint32_t)x, (uint32_t)y, k);
        }
    if (!full) wanted = coarse;
    assert_int_equal(vxs_blocks_weight_is_full(s->words, map, s->levels, i, j, across, down, k, width), full);
    uint32_t found  = vxs_blocks_shadow_weight(s->words, map, s->levels, i, j, across, down, k, width);
    uint32_t scalar = scalar_shadow_weight(s->words, map, s->levels, i, j, across, down, k, width);
    if (found != wanted || scalar != wanted)
        fail_msg("levels %u, map %u, texel %d + %u/256, %d + %u/256, depth %u, width %d: %u, scalar %u, expected %u", s->levels,
                 map, i, across, j, down, k, width, found, scalar, wanted);
}

/* A depth at which a texel's shadow begins, or near it, or anywhere; within the map. */
static uint32_t tricky_depth(const blocks_sample *s, rng *r, uint32_t map, int32_t i, int32_t j)
{
    int32_t last = (1 << s->levels) - 1, x = i < 0 ? 0 : i < last ? i : last, y = j < 0 ? 0 : j < last ? j : last;
    int32_t k = blocks_sample_depth(s, map, (uint32_t)x, (uint32_t)y) + rng_between(r, -2, 1);
    if (!rng_below(r, 4)) k = (int32_t)rng_below(r, 1u << s->levels);
    return (uint32_t)(k < 0 ? 0 : k < last ? k : last);
}

/* A texel near what may go wrong: borders of tiles, blocks, nodes and cells, corners of the map, just outside and far outside. */
static int32_t tricky_texel(rng *r, int32_t side)
{
    switch (rng_below(r, 8)) {
    case 0: return rng_between(r, -12, 12);
    case 1: return side + rng_between(r, -12, 12);
    case 2: return 8 * rng_between(r, 0, side / 8) + rng_between(r, -1, 1);
    case 3: return 32 * rng_between(r, 0, side / 32) + rng_between(r, -9, 9);
    case 4: return 256 * rng_between(r, 0, side / 256) + rng_between(r, -9, 9);
    case 5: return rng_below(r, 16) ? rng_between(r, -side, 2 * side) : rng_below(r, 2) ? -(1 << 30) : 1 << 30;
    default: return rng_between(r, 0, side - 1);
    }
}

/* A texel of a square that has more than one depth, or near its border. */
static void texel_of_square(const blocks_sample *s, rng *r, uint32_t map, int32_t *i, int32_t *j)
{
    uint32_t wide = s->squares_wide;
    size_t   area = (size_t)wide * wide, from = rng_below(r, (uint32_t)area), n;
    for (n = 0; n < area && s->map[map][(from + n) % area] >= 0; n++) {}
    *i = (int32_t)((from + n) % area % wide) * BLOCKS_SQUARE_PX + rng_between(r, -9, BLOCKS_SQUARE_PX + 8);
    *j = (int32_t)((from + n) % area / wide) * BLOCKS_SQUARE_PX + rng_between(r, -9, BLOCKS_SQUARE_PX + 8);
}

static void check_random(const blocks_sample *s, rng *r, int count)
{
    int32_t side = 1 << s->levels;
    for (int n = 0; n < count; n++) {
        uint32_t map = rng_below(r, s->map_count);
        int32_t  i = tricky_texel(r, side), j = tricky_texel(r, side);
        if (s->levels > 8 && rng_below(r, 4)) texel_of_square(s, r, map, &i, &j);
        uint32_t k = tricky_depth(s, r, map, i, j);
        check_filter(s, map, i, j, k, 1 + 2 * rng_between(r, 0, VXS_FILTER_MAX / 2));
        check_smooth(s, map, i, j, rng_below(r, 4) ? rng_below(r, 256) : 128, rng_below(r, 4) ? rng_below(r, 256) : 128, k,
                     rng_between(r, 1, VXS_FILTER_MAX));
        if (i >= 0 && j >= 0 && i < side && j < side) check_voxel(s, map, (uint32_t)i, (uint32_t)j, k);
    }
}

/* Every texel of every square with more than one depth: the last lit voxel, the first shadowed one, and any. */
static void check_squares(const blocks_sample *s, rng *r)
{
    uint32_t wide = s->squares_wide, side = 1u << s->levels, width = side < 256 ? side : 256;
    for (uint32_t map = 0; map < s->map_count; map++)
        for (size_t n = 0; n < (size_t)wide * wide; n++) {
            if (s->map[map][n] >= 0) continue;
            for (uint32_t y = 0; y < width; y++)
                for (uint32_t x = 0; x < width; x++) {
                    uint32_t i = (uint32_t)(n % wide) * 256 + x, j = (uint32_t)(n / wide) * 256 + y;
                    uint32_t d = (uint32_t)blocks_sample_depth(s, map, i, j);
                    if (d > 0) check_voxel(s, map, i, j, d - 1);
                    if (d < side) check_voxel(s, map, i, j, d);
                    check_voxel(s, map, i, j, rng_below(r, side));
                }
        }
}

/* Maps of all sizes, up to what is sparse: two maps of some, six of one, seeds that differ. */
static void test_lookups(void **state)
{
    (void)state;
    static const struct {
        uint32_t levels, maps, squares;
    } cases[]         = {{3, 2, 2}, {4, 1, 1},   {5, 6, 6},   {6, 1, 1},   {7, 1, 1},  {8, 2, 2},
                         {9, 2, 6}, {10, 1, 12}, {11, 1, 20}, {15, 1, 12}, {18, 2, 20}};
    blocks_sample all = {0};
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++)
        for (uint64_t seed = 0; seed < (cases[n].levels < 9 ? 4 : 1); seed++) {
            blocks_sample s;
            rng           r = {100 * n + seed};
            blocks_sample_init(&s, &r, cases[n].levels, cases[n].maps, cases[n].squares);
            check_squares(&s, &r);
            check_random(&s, &r, (int)repeats(800, 10000));
            for (int kind = 0; kind < BLOCKS_KINDS; kind++) all.kinds[kind] += s.kinds[kind];
            for (int kind = 0; kind < 4; kind++) all.states[kind] += s.states[kind];
            for (int width = 0; width < 3; width++) all.widths[width] += s.widths[width];
            all.images += s.images;
            all.planes += s.planes;
            all.far += s.far;
            all.wide += s.wide;
            blocks_sample_free(&s);
        }
    for (int kind = 0; kind < BLOCKS_KINDS; kind++) assert_in_range(all.kinds[kind], 100, UINT32_MAX);
    for (int kind = 0; kind < 4; kind++) assert_in_range(all.states[kind], 100, UINT32_MAX);
    for (int width = 0; width < 3; width++) assert_in_range(all.widths[width], 100, UINT32_MAX);
    assert_in_range(all.images, 100, UINT32_MAX);
    assert_in_range(all.planes, 100, UINT32_MAX);
    assert_in_range(all.far, 100, UINT32_MAX);
    assert_in_range(all.wide, 2, UINT32_MAX);
}

/* Every page, one after the other, and all of them, are not there: what they hold is answered by their entries, and so are filters
 * that need it, all else as before. */
static void test_absent_pages(void **state)
{
    (void)state;
    blocks_sample s;
    rng           r = {6};
    blocks_sample_init(&s, &r, 10, 1, 14);
    assert_true(s.page_count > 2);
    mixed_filters = 0;
    for (uint32_t page = 0; page <= s.page_count; page++) {
        uint32_t start                   = s.words[8 + page % s.page_count];
        s.words[8 + page % s.page_count] = 0;
        check_random(&s, &r, (int)repeats(2000, 10000));
        if (page + 1 < s.page_count) s.words[8 + page % s.page_count] = start;
    }
    assert_in_range(mixed_filters, 50, UINT32_MAX);
    blocks_sample_free(&s);
}

/* far bases ------------------------------------------------------------------------------------------------------------------------ */

enum { FAR_PAGE = 11, FAR_BLOCK = 8, FAR_PATTERN = 15, FAR_WORDS = 24 }; /* block and pattern: words of the page */

/* A map of 256 x 256 texels. One block of it has something: a tile on its plane, one with planes of its own, and others at its
 * base. */
typedef struct far_block {
    node_slope  slope;
    uint32_t    plane_tile, private_tile;
    block_plane plane; /* of depths relative to the block */
    tile_planes own;   /* its base is relative to the block */
    int64_t     base;
    uint32_t    words[FAR_PAGE + FAR_WORDS + BLOCKS_SPARE_WORDS];
} far_block;

/* Where shadow begins, formats/vxs.md section 13.2. */
static int64_t far_depth(const far_block *b, int32_t i, int32_t j)
{
    if (i > 31 || j > 31) return INT64_MAX;
    uint32_t t     = (uint32_t)(i / 8 + j / 8 * 4);
    int64_t  depth = b->base - slope_at(b->slope, i / 8, j / 8);
    if (t == b->plane_tile) return b->base + block_plane_at(&b->plane, i, j);
    return t == b->private_tile ? depth + b->own.base + tile_planes_at(&b->own, i % 8, j % 8) : depth;
}

/* A number of any length, up to 29 bits. */
static int32_t far_number(rng *r)
{
    int32_t limit = 1 << rng_below(r, 30);
    return rng_between(r, -limit, limit - 1);
}

/* Of any texel of tile t. */
static int64_t far_depth_in(const far_block *b, rng *r, uint32_t t)
{
    return far_depth(b, (int32_t)(t % 4 * 8 + rng_below(r, 8)), (int32_t)(t / 4 * 8 + rng_below(r, 8)));
}

/* Bases are any numbers, or those by which a texel of one of the two tiles has its depth in the map. */
static void far_plan(far_block *b, rng *r)
{
    b->slope        = random_slope(r);
    b->plane_tile   = rng_below(r, 16);
    b->private_tile = (b->plane_tile + 1 + rng_below(r, 15)) % 16;
    b->plane        = random_block_plane(r, 0, 0);
    b->plane.depth  = far_number(r) / 4;
    b->own          = random_tile_planes(r, far_number(r));
    b->base         = far_number(r);
    if (rng_below(r, 2)) b->base += rng_below(r, 256) - far_depth_in(b, r, b->plane_tile);
    if (rng_below(r, 2)) b->own.base += (int32_t)(rng_below(r, 256) - far_depth_in(b, r, b->private_tile));
}

static void far_write(far_block *b)
{
    half_list     page     = {0};
    blocks_sample count    = {0};
    uint32_t      others   = 0xffff & ~(1u << b->plane_tile | 1u << b->private_tile);
    uint32_t      halves[] = {1, 0, 0, 0, 2, 0, 0, 0, (uint32_t)b->slope.x, (uint32_t)b->slope.y, 1, FAR_BLOCK};
    for (size_t n = 0; n < sizeof halves / sizeof *halves; n++) put_half(&page, halves[n]);
    put_word(&page, (uint32_t)b->base);
    put_word(&page, 0xffffffff);
    put_word(&page, 1u << b->private_tile | (others & -others) << 16);
    put_word(&page, 1u << b->private_tile | 1u << b->plane_tile | 1u << 26);
    put_plane(&count, &page, &b->plane, 0);
    put_word(&page, 2 * FAR_PATTERN << 14);
    put_word(&page, 0);
    put_word(&page, (uint32_t)b->own.base);
    put_planes(&count, &page, &b->own);
    pad_to_word(&page);
    memset(b->words, 0, sizeof b->words);
    memcpy(b->words, (uint32_t[FAR_PAGE]){1, FAR_PAGE, 9, 0, 0, 0, 0, 0, FAR_PAGE, 0, 255u << 24}, FAR_PAGE * sizeof *b->words);
    for (size_t n = 0; n < page.count / 2; n++) b->words[FAR_PAGE + n] = page.data[2 * n] | (uint32_t)page.data[2 * n + 1] << 16;
    free(page.data);
}

static uint32_t far_count(const far_block *b, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    uint32_t dark = 0;
    for (int32_t y = j - width_px / 2; y <= j + width_px / 2; y++)
        for (int32_t x = i - width_px / 2; x <= i + width_px / 2; x++) dark += x >= 0 && y >= 0 && (int64_t)k >= far_depth(b, x, y);
    return dark;
}

/* Depths far from those of the map, where a difference of both times 256 is no number. */
static void test_far_bases(void **state)
{
    rng      r      = {7};
    uint32_t partly = 0;
    (void)state;
    for (uint32_t round = 0; round < repeats(1200, 4000); round++) {
        far_block b;
        far_plan(&b, &r);
        far_write(&b);
        for (int n = 0; n < 200; n++) {
            int32_t i = rng_between(&r, 0, 35), j = rng_between(&r, 0, 35),
                    width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
            uint32_t k = rng_below(&r, 256), tap = far_count(&b, i, j, k, 1), dark = far_count(&b, i, j, k, width_px);
            assert_int_equal(vxs_blocks_shadow(b.words, 0, 8, (uint32_t)i, (uint32_t)j, k), tap);
            assert_int_equal(scalar_shadow(b.words, 0, 8, (uint32_t)i, (uint32_t)j, k), tap);
            assert_int_equal(vxs_blocks_shadow_count(b.words, 0, 8, i, j, k, width_px), dark);
            assert_int_equal(scalar_shadow_count(b.words, 0, 8, i, j, k, width_px), dark);
            partly += dark > 0 && dark < (uint32_t)(width_px * width_px);
        }
    }
    assert_in_range(partly, repeats(30000, 100000), UINT32_MAX);
}

/* Planes that no file has, steeper and deeper than 32 bits hold: vectors and words agree, and nothing that is signed overflows. */
static void test_bad_planes(void **state)
{
    rng r = {8};
    (void)state;
    for (uint32_t round = 0; round < repeats(1200, 4000); round++) {
        far_block b;
        far_plan(&b, &r);
        far_write(&b);
        for (uint32_t n = 0; n < 8; n++) { /* the block's plane, and the pattern */
            uint32_t *word = b.words + FAR_PAGE + (n < 2 ? FAR_BLOCK + 2 + n : FAR_PATTERN + n - 2);
            if (rng_below(&r, 2)) *word = rng_u32(&r);
            if (n == 2) *word |= 0x8000; /* kinds 8 to 15 */
        }
        for (int n = 0; n < 200; n++) {
            int32_t i = rng_between(&r, 0, 35), j = rng_between(&r, 0, 35),
                    width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
            uint32_t k       = rng_below(&r, 256);
            assert_int_equal(vxs_blocks_shadow(b.words, 0, 8, (uint32_t)i, (uint32_t)j, k),
                             scalar_shadow(b.words, 0, 8, (uint32_t)i, (uint32_t)j, k));
            assert_int_equal(vxs_blocks_shadow_count(b.words, 0, 8, i, j, k, width_px),
                             scalar_shadow_count(b.words, 0, 8, i, j, k, width_px));
            assert_int_equal(vxs_blocks_shadow_weight(b.words, 0, 8, i, j, k, 77, k, width_px),
                             scalar_shadow_weight(b.words, 0, 8, i, j, k, 77, k, width_px));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lookups),
        cmocka_unit_test(test_absent_pages),
        cmocka_unit_test(test_far_bases),
        cmocka_unit_test(test_bad_planes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
