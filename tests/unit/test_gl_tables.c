/* Tables of libvxs_gl, read by the book of gl_tables.h: the same answer as the words have, for every texel of every tile at the
 * depths where something changes; what has no tables, and memory.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "runtime/gl/gl_tables.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "alloc_fail.h"
#include "blocks_sample.h"
#include "formats/vxs_space.h"
#include "repeats.h"

enum { FIRST = 1000 };

static alloc_fail memory;

static vxs_baked_light light_of(const blocks_sample *s)
{
    return (vxs_baked_light){.light      = {.kind   = s->map_count > 1 ? VXS_LIGHT_KIND_POINT : VXS_LIGHT_KIND_DIRECTIONAL,
                                            .flags  = s->map_count > 1 ? VXS_LIGHT_CUBE : 0,
                                            .levels = s->levels,
                                            .coding = VXS_CODING_BLOCKS},
                             .words      = s->words,
                             .word_count = (uint32_t)s->word_count};
}

/* a second reader ---------------------------------------------------------------------------------------------------------------- */

static uint32_t word_at(const gl_tables *t, uint32_t index)
{
    assert_in_range(index, t->first, t->first + t->count - 1);
    return t->words[index - t->first];
}

static int32_t slope_of(uint32_t slope, int32_t tile_x, int32_t tile_y)
{
    int32_t across = (int16_t)(slope & 0xffff), down = (int16_t)(slope >> 16);
    return (across * (across < 0 ? tile_x - 31 : tile_x) + down * (down < 0 ? tile_y - 31 : tile_y)) >> 8;
}

/* Depths of a tile, in order; rank: of each texel among them.   Returns their number. */
static uint32_t read_tile(const gl_tables *t, uint32_t start, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y,
                          int64_t depth[64], uint32_t rank[64])
{
    uint32_t up   = light->levels > 8 ? light->levels - 8 : 0;
    uint32_t word = word_at(t, start + (map << 2 * up) + ((y >> 5) << up) + (x >> 5)), in_block = 2 + 2 * ((x & 3) + 4 * (y & 3));
    int32_t  slope = 0;
    memset(rank, 0, 64 * sizeof *rank);
    if (!(word >> 31)) {
        slope = slope_of(word_at(t, word), (int32_t)(x & 31), (int32_t)(y & 31));
        word  = word_at(t, word + 4 + (x >> 2 & 7) + 8 * (y >> 2 & 7));
    }
    depth[0] = (int64_t)(word & 0x7fffffff) - slope;
    if (word >> 31) return 1;
    depth[0]      = (int64_t)word_at(t, word + in_block) - slope;
    uint32_t last = word_at(t, word + in_block + 1), bits = last >> 28, at = last & 0xfffffff, count = 1;
    assert_in_range(bits, 0, 6);
    for (uint32_t n = 1; n < 1u << bits; n++) { /* the n-th delta: down the tree, as the bits of n say */
        uint32_t node = 1, bit = bits;
        while (n & ((1u << bit) - 1)) node = 2 * node + (n >> --bit & 1);
        node /= 2; /* the last step was to the right of it */
        depth[count++] = depth[0] + word_at(t, at + node - 1);
        assert_true(depth[n] >= depth[n - 1]);
    }
    for (uint32_t p = 0; p < bits; p++)
        for (uint32_t n = 0; n < 64; n++) rank[n] |= (word_at(t, at + count - 1 + 2 * p + n / 32) >> n % 32 & 1) << (bits - 1 - p);
    return count;
}

/* Hold a tile against the words, for all texels at the depths where one changes, and before. Returns how many voxels. */
static uint64_t check_tile(const gl_tables *t, uint32_t start, const vxs_baked_light *l, uint32_t map, uint32_t x, uint32_t y)
{
    int64_t  depth[64];
    uint32_t rank[64], levels = l->light.levels, count = read_tile(t, start, &l->light, map, x, y, depth, rank);
    uint64_t voxels = 0;
    for (uint32_t n = 0; n < 2 * count + 2; n++) {
        int64_t k = n < 2 * count ? depth[n / 2] - n % 2 : n == 2 * count ? 0 : (1 << levels) - 1;
        if (k < 0 || k >> levels) continue;
        for (uint32_t z = 0; z < 64; z++, voxels++) {
            uint32_t wanted = vxs_blocks_shadow(l->words, map, levels, 8 * x + z % 8, 8 * y + z / 8, (uint32_t)k);
            if ((k >= depth[rank[z]]) != (int)wanted)
                fail_msg("map %u, texel %u %u, depth %d: %u is expected", map, 8 * x + z % 8, 8 * y + z / 8, (int)k, wanted);
        }
    }
    return voxels;
}

/* Hold the bounds of a node and of its blocks against all of its texels. */
static void check_bounds(const gl_tables *t, uint32_t start, const vxs_baked_light *l, uint32_t map, uint32_t square_x,
                         uint32_t square_y)
{
    uint32_t up = l->light.levels > 8 ? l->light.levels - 8 : 0, tiles = 1u << (l->light.levels - 3);
    uint32_t node = word_at(t, start + (map << 2 * up) + (square_y << up) + square_x), side = 1u << l->light.levels;
    int64_t  all[2] = {INT32_MAX, -1};
    if (node >> 31) return;
    for (uint32_t n = 0; n < 64; n++) {
        int64_t  own[2] = {INT32_MAX, -1}, depth[64];
        uint32_t x = 32 * square_x + 4 * (n & 7), y = 32 * square_y + 4 * (n >> 3), rank[64], block = word_at(t, node + 4 + n);
        for (uint32_t tile = 0; tile < 16; tile++) {
            if (x + (tile & 3) >= tiles || y + (tile >> 2) >= tiles) continue;
            uint32_t count = read_tile(t, start, &l->light, map, x + (tile & 3), y + (tile >> 2), depth, rank);
            for (uint32_t z = 0; z < (count > 1 ? 64 : 1); z++) {
                int64_t d = depth[rank[z]] < 0 ? 0 : depth[rank[z]] < side ? depth[rank[z]] : side;
                own[0]    = d < own[0] ? d : own[0];
                own[1]    = d > own[1] ? d : own[1];
            }
        }
        if (own[1] < 0) continue;
        if (!(block >> 31)) {
            assert_int_equal(word_at(t, block), own[0]);
            assert_int_equal(word_at(t, block + 1), own[1]);
        }
        all[0] = own[0] < all[0] ? own[0] : all[0];
        all[1] = own[1] > all[1] ? own[1] : all[1];
    }
    assert_int_equal(word_at(t, node + 1), all[0]);
    assert_int_equal(word_at(t, node + 2), all[1]);
}

/* Narrow the bounds in all entries, so that they decide what blocks hold otherwise. */
static void narrow(blocks_sample *s, rng *r)
{
    for (uint32_t map = 0; map < s->map_count; map++)
        for (uint32_t c = 0; c < s->squares_wide * s->squares_wide; c++) {
            uint32_t at = vxs_blocks_entry(s->words, map, s->levels, c % s->squares_wide, c / s->squares_wide);
            if (s->words[at] >> 31) continue;
            uint32_t bounds = s->words[at + 1], min = bounds >> 16 & 0xff, max = bounds >> 24;
            min += rng_below(r, (max - min) / 2 + 1);
            max -= rng_below(r, (max - min) / 2 + 1);
            s->words[at + 1] = (bounds & 0xffff) | min << 16 | max << 24;
        }
}

static void test_same_answer(void **state)
{
    static const uint32_t levels[] = {3, 5, 7, 8, 9, 11, 15, 17};
    rng                   r        = {5};
    uint64_t              voxels   = 0;
    (void)state;
    for (uint32_t round = 0; round < repeats(2, 40); round++)
        for (size_t n = 0; n < sizeof levels / sizeof *levels; n++) {
            blocks_sample s;
            gl_tables     t = {.memory = alloc_fail_allocator(&memory), .first = FIRST, .most = 1 << 26};
            uint32_t      start, maps = n % 2 ? 1 : 6, side = 1u << (levels[n] - 3);
            blocks_sample_init(&s, &r, levels[n], maps, maps + 3);
            vxs_baked_light l = light_of(&s);
            if (round % 2) narrow(&s, &r);
            assert_int_equal(vxs_gl_tables_add(&t, &l, &start), VXS_OK);
            for (uint32_t map = 0; map < maps; map++)
                for (uint32_t c = 0; c < s.squares_wide * s.squares_wide; c++)
                    check_bounds(&t, start, &l, map, c % s.squares_wide, c / s.squares_wide);
            for (uint32_t map = 0; map < maps; map++)
                for (uint32_t tile = 0; tile < 1024; tile++) {
                    uint32_t x = rng_below(&r, side), y = rng_below(&r, side);
                    voxels += check_tile(&t, start, &l, map, x, y);
                }
            for (uint32_t square = 0; square < s.square_count; square++)
                for (uint32_t map = 0; map < maps; map++)
                    for (uint32_t c = 0; c < s.squares_wide * s.squares_wide; c++)
                        for (uint32_t tile = 0; s.map[map][c] == ~(int32_t)square && tile < 1024; tile++) {
                            uint32_t x = 32 * (c % s.squares_wide) + tile % 32, y = 32 * (c / s.squares_wide) + tile / 32;
                            if (x < side && y < side) voxels += check_tile(&t, start, &l, map, x, y);
                        }
            vxs_gl_tables_free(&t);
            blocks_sample_free(&s);
        }
    assert_true(voxels > 10000000);
    print_message("%.1f million voxels\n", (double)voxels / 1e6);
}

/* Equal records are stored once, and two lights follow each other. */
static void test_shared(void **state)
{
    rng           r = {6};
    blocks_sample s;
    gl_tables     t = {.memory = alloc_fail_allocator(&memory), .first = FIRST, .most = 1 << 26};
    uint32_t      starts[2], after;
    (void)state;
    blocks_sample_init(&s, &r, 10, 1, 4);
    vxs_baked_light l = light_of(&s);
    assert_int_equal(vxs_gl_tables_add(&t, &l, &starts[0]), VXS_OK);
    assert_int_equal(starts[0], FIRST);
    after = t.first + t.count;
    assert_int_equal(vxs_gl_tables_add(&t, &l, &starts[1]), VXS_OK);
    assert_int_equal(starts[1], after);
    assert_int_equal(t.first + t.count - after, after - FIRST);
    vxs_gl_tables_free(&t);
    blocks_sample_free(&s);
}

/* A missing page, and tables larger than allowed; memory that ends at any allocation comes back. */
static void test_refused(void **state)
{
    rng           r = {7};
    blocks_sample s;
    uint32_t      start, count = 0;
    (void)state;
    blocks_sample_init(&s, &r, 11, 1, 5);
    vxs_baked_light l = light_of(&s);
    for (uint64_t fail_at = 1;; fail_at++) {
        alloc_fail a      = {.fail_at = fail_at};
        gl_tables  t      = {.memory = alloc_fail_allocator(&a), .first = FIRST, .most = 1 << 26};
        vxs_result result = vxs_gl_tables_add(&t, &l, &start);
        count             = t.count;
        vxs_gl_tables_free(&t);
        assert_int_equal(a.live_bytes, 0);
        assert_int_equal(a.wrong_sizes, 0);
        if (a.calls < fail_at) {
            assert_int_equal(result, VXS_OK);
            assert_true(fail_at > 5);
            break;
        }
        assert_int_equal(result, VXS_E_MEMORY);
    }
    for (uint32_t less = 0; less < 2; less++) {
        gl_tables t = {.memory = alloc_fail_allocator(&memory), .first = FIRST, .most = count - less};
        assert_int_equal(vxs_gl_tables_add(&t, &l, &start), less ? VXS_E_ARGUMENT : VXS_OK);
        assert_true(t.capacity <= count);
        vxs_gl_tables_free(&t);
    }
    gl_tables t = {.memory = alloc_fail_allocator(&memory), .first = FIRST, .most = 1 << 26};
    s.words[8]  = 0; /* the name of a page */
    assert_int_equal(vxs_gl_tables_add(&t, &l, &start), VXS_E_ARGUMENT);
    vxs_gl_tables_free(&t);
    blocks_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_answer), cmocka_unit_test(test_shared),
                                       cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
