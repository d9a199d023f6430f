/* What the decoder of pages makes of any symbols (formats/vxs_page_model.h): the coder is taken out, and symbols are drawn by
 * chance, or come from a list, so that nothing but the walk's own checks stands between them and the words. What it takes must keep
 * the rules of the layout.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "page_sample.h"
#include "repeats.h"

#include <cmocka.h>

size_t     drawn_scratch_bytes(void);
uint32_t   drawn_word_count(const uint8_t *bytes, size_t size_bytes);
vxs_result drawn_decode(uint32_t *words, const uint8_t *bytes, size_t size_bytes, const vxs_page_node *nodes, uint32_t node_count,
                        const vxs_common *common, vxs_page_scratch *scratch);
vxs_result drawn_sizes_of(vxs_resident_sizes *sizes, const uint8_t *bytes, size_t size_bytes);
vxs_result drawn_resident_decode(vxs_resident *out, uint32_t levels, uint32_t map_count, uint32_t packing, const uint8_t *bytes,
                                 size_t size_bytes, vxs_page_scratch *scratch);

#define PAGE_ENCODING    0
#define code_nibble      real_code_nibble
#define code_nibble_here real_code_nibble_here
#define code_two_nibbles real_code_two_nibbles
#define code_plain       real_code_plain
#include "formats/vxs_page_coder.h"
#undef code_nibble
#undef code_nibble_here
#define code_nibble_here code_nibble
#undef code_two_nibbles
#undef code_plain
#undef PAGE_ENCODING

static rng      draw;
static uint32_t wild; /* one symbol of so many may be any; the others are small */

/* Symbols of a list, and how many of them were taken; NULL: they are drawn. */
static const uint16_t *given;
static uint32_t        taken_count;

static uint32_t code_nibble(coder *c, nibble_odds *odds, uint32_t value)
{
    (void)c, (void)odds, (void)value;
    if (given) return given[taken_count++];
    uint32_t any = rng_below(&draw, 16);
    return rng_below(&draw, wild) ? any & rng_below(&draw, 16) & 7 : any;
}

static uint32_t code_two_nibbles(coder *c, nibble_odds *first, nibble_odds *second, uint32_t apart, uint32_t value)
{
    uint32_t low = code_nibble(c, first, value & 15);
    return low | code_nibble(c, second + apart * (low >> 3), value >> 4) << 4;
}

static uint32_t code_plain(coder *c, uint32_t bits, uint32_t value)
{
    (void)c, (void)value;
    if (given) return given[taken_count++];
    return rng_u32(&draw) & ((1u << bits) - 1);
}

#define vxs_page_scratch_bytes drawn_scratch_bytes
#define vxs_page_word_count    drawn_word_count
#define vxs_page_decode        drawn_decode
#define vxs_resident_sizes_of  drawn_sizes_of
#define vxs_resident_decode    drawn_resident_decode
#include "formats/vxs_page_decode.c"

static uint32_t         words[VXS_PAGE_WORDS_MAX];
static vxs_page_scratch scratch;
static sample_common    common;

/* Mixed blocks of a node until one is refused; those before it are checked. Returns how many. */
static uint32_t walk_blocks(uint32_t word_count, uint32_t node_words)
{
    checked_words page = {words, 2 * word_count}, pool = {common.words, common.common.half_count};
    uint32_t      starts[64], count                    = 0;
    int           good = 1;
    walk          w    = {.odds       = &scratch.odds,
                          .s          = &scratch,
                          .words      = words,
                          .word_count = word_count,
                          .node_words = node_words,
                          .common     = &common.common};
    memset(words, 0, sizeof words);
    start_page(&w);
    for (; count < 64; count++) {
        uint32_t base = 0;
        starts[count] = 0;
        if (!code_block_of(&w, (int)rng_below(&draw, 2), count % 8 * 32, count / 8 * 32, &starts[count], &base)) break;
        assert_true(w.word <= node_words && w.half <= 2 * word_count && base < 1 << 24);
    }
    for (uint32_t n = word_count; n < VXS_PAGE_WORDS_MAX; n++) assert_int_equal(words[n], 0);
    for (uint32_t n = 0; n < count; n++) check_block(page, pool, starts[n], &good);
    assert_true(good);
    return count;
}

static void any_symbols_make_blocks(void **state)
{
    (void)state;
    uint32_t taken = 0;
    for (uint64_t seed = 0; seed < repeats(9000, 30000); seed++) {
        draw                = rng_split(seed, 1);
        wild                = 20 + (uint32_t)(seed % 9) * 60;
        uint32_t node_words = 1 + rng_below(&draw, seed % 3 ? 4000 : 60000);
        if (seed % 100 == 0) assert_int_equal(sample_common_make(&draw, &common, rng_below(&draw, SAMPLE_COMMON_MAX)), VXS_OK);
        taken += walk_blocks(node_words + rng_below(&draw, VXS_PAGE_WORDS_MAX - node_words), node_words);
    }
    assert_true(taken > 200);
}

/* Patterns one by one, of the common pool: many more come to their end. */
static void any_symbols_make_patterns(void **state)
{
    (void)state;
    uint32_t taken[VXS_PATTERN_KINDS] = {0}, private_taken[PRIVATE_KINDS] = {0};
    for (uint64_t seed = 0; seed < repeats(90000, 300000); seed++) {
        draw          = rng_split(seed, 2);
        wild          = 2 + (uint32_t)(seed % 9) * 20;
        uint32_t kind = rng_below(&draw, VXS_PATTERN_KINDS);
        if (kind == 1) kind = 0;
        uint32_t      room = 1 + rng_below(&draw, seed % 4 ? 200 : 20);
        walk          w    = {.odds = &scratch.odds, .s = &scratch, .words = words, .word_count = room};
        checked_words pool = {words, 0};
        int           good = 1;
        memset(words, 0, (room + 1) * sizeof *words);
        int done = code_common_pattern(&w, kind);
        assert_int_equal(words[room], 0);
        if (!done) continue;
        assert_true(w.half <= 2 * room);
        pool.halves = w.half;
        if (kind)
            check_masks(pool, 0, kind, &good);
        else
            check_private(pool, 0, &good);
        assert_true(good);
        taken[kind]++;
        if (!kind) private_taken[words[0] >> 12 & 15]++;
    }
    for (uint32_t k = 0; k < VXS_PATTERN_KINDS; k++) assert_true(k == 1 || taken[k] > 100);
    for (uint32_t k = 0; k < PRIVATE_KINDS; k++) assert_true(private_taken[k] > repeats(6, 20));
}

enum { TOP_SIDE = 2, TOP_ENTRIES = TOP_SIDE * TOP_SIDE };

/* The top of a map of so many squares a side. Each entry is a depth, or names a node of the list. Returns whether it was taken. */
static int walk_top(void)
{
    vxs_page_node nodes[TOP_ENTRIES];
    uint32_t      page_first[TOP_ENTRIES + 1];
    top_odds      odds;
    resident_walk r = {.w          = {.words = words, .word_count = 2 * TOP_ENTRIES},
                       .odds       = &odds,
                       .levels     = 9,
                       .page_count = TOP_ENTRIES,
                       .node_count = TOP_ENTRIES,
                       .nodes      = nodes,
                       .page_first = page_first};
    memset(words, 0, 2 * TOP_ENTRIES * sizeof *words);
    if (!code_top(&r, 0)) return 0;
    page_first[r.pages] = r.met;
    for (uint32_t n = 0; n < TOP_ENTRIES; n++) {
        uint32_t entry = words[2 * n], page = entry >> 16, met = 0;
        if (entry >> 31) {
            assert_true((entry & 0x7fffffff) <= 1 << 18 && !words[2 * n + 1]);
            continue;
        }
        assert_true(page < r.pages);
        for (uint32_t k = page_first[page]; k < page_first[page + 1]; k++) {
            assert_true(k == page_first[page] ? nodes[k].offset == 0 : nodes[k].offset > nodes[k - 1].offset);
            met += nodes[k].offset == (entry & 0xffff);
        }
        assert_int_equal(met, 1);
    }
    return 1;
}

static void any_symbols_make_tops(void **state)
{
    (void)state;
    uint32_t taken = 0;
    for (uint64_t seed = 0; seed < repeats(60000, 200000); seed++) {
        draw = rng_split(seed, 3);
        wild = 2 + (uint32_t)(seed % 9) * 20;
        taken += (uint32_t)walk_top();
    }
    assert_true(taken > repeats(300, 1000));
}

/* rules one by one ------------------------------------------------------------------------------------------------------------- */

enum { BLOCK_SYMBOLS_MAX = 96, NODE_WORDS = 7 };

/* A page of one node with one block: the symbols of that block, how many words it takes, and halves of the pool. */
typedef struct symbol_list {
    const char *what;
    vxs_result  result;
    uint32_t    block_words, pool_halves;
    uint16_t    block[BLOCK_SYMBOLS_MAX];
    uint32_t    count;
    uint32_t    twice; /* the node has one more block, which is there already */
} symbol_list;

/* 40000 as a number; it takes plain bits. */
#define LARGE 15, 0, 40000 >> 12, 40000 & 0xfff

#define NEW_BLOCK  0
#define ALL_ON     NEW_BLOCK, 2
#define SOME_ON    NEW_BLOCK, 1
#define NONE_ON    NEW_BLOCK, 0
#define STEPS      0, 0, 0
#define NO_LIKE    3
#define FLAT       NO_LIKE, 0, STEPS
#define LEAST      0, 0
#define BASE       0
#define NO_PALETTE 0, 0
/* a block whose first tile has depths of its own; a new pattern; its kind, and what all of planes begin with */
#define TILE       NONE_ON, BASE, NO_PALETTE, 1
#define OWN        TILE, 0
#define ONE        OWN, 7, 0, 0
#define TWO(kind)  OWN, kind, 0, 0, STEPS, STEPS
#define OTHER_ROWS 0, 0, 0
#define ZEROS_16   0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0
#define ZEROS_62   ZEROS_16, ZEROS_16, ZEROS_16, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0
#define LIST(...)  {__VA_ARGS__}, sizeof((uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t), 0
#define TWICE(...) {__VA_ARGS__}, sizeof((uint16_t[]){__VA_ARGS__}) / sizeof(uint16_t), 1

static const symbol_list lists[] = {
    /* planes of blocks */
    {"a plane of all tiles", VXS_OK, 4, 0, LIST(ALL_ON, FLAT, LEAST, BASE)},
    {"no such number of tiles", VXS_E_CORRUPT, 5, 0, LIST(NEW_BLOCK, 3, FLAT, LEAST, BASE, NO_PALETTE, 7, 0, 15, 15, 15)},
    {"a record without room for its plane", VXS_E_CORRUPT, 3, 0, LIST(ALL_ON, FLAT, LEAST, BASE)},
    {"no such plane beside it", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, 4, 0, STEPS, LEAST, BASE)},
    {"the greatest shift", VXS_OK, 4, 0, LIST(ALL_ON, NO_LIKE, 8, STEPS, LEAST, BASE)},
    {"a shift beyond it", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, NO_LIKE, 9, STEPS, LEAST, BASE)},
    {"the most zeros", VXS_OK, 4, 0, LIST(ALL_ON, NO_LIKE, 0, 8, 0, 0, LEAST, BASE)},
    {"more of them", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, NO_LIKE, 0, 9, 0, 0, LEAST, BASE)},
    {"a that is no half", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, NO_LIKE, 0, 0, LARGE, 0, 0, LEAST, BASE)},
    {"b that is no half", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, NO_LIKE, 0, 0, 0, LARGE, 0, LEAST, BASE)},
    {"a that is no half with its zeros", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, NO_LIKE, 0, 8, 8, 0, 0, 0, LEAST, BASE)},
    {"a that leaves 32 bits with its zeros", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, NO_LIKE, 0, 8, 15, 15, 0, 0, 0, 0, LEAST, BASE)},
    {"the most zeros of its least depth", VXS_OK, 4, 0, LIST(ALL_ON, FLAT, 8, 0, BASE)},
    {"more of those", VXS_E_CORRUPT, 4, 0, LIST(ALL_ON, FLAT, 9, BASE)},
    {"a plane of some tiles", VXS_OK, 5, 0, LIST(SOME_ON, FLAT, LEAST, BASE, NO_PALETTE, 7, 0, 15, 15, 15)},
    {"a plane of no tile", VXS_E_CORRUPT, 5, 0, LIST(SOME_ON, FLAT, LEAST, BASE, NO_PALETTE, 0, 0, 0, 0, 0, 0, 0, 0)},
    {"a tile on the plane that is mixed", VXS_E_CORRUPT, 5, 0, LIST(SOME_ON, FLAT, LEAST, BASE, NO_PALETTE, 7, 1, 15, 15, 15)},
    /* patterns of planes */
    {"a pattern of a plane", VXS_OK, 4, 3, LIST(ONE, STEPS, BASE, OTHER_ROWS)},
    {"its greatest shift", VXS_OK, 4, 3, LIST(OWN, 7, 8, 0, STEPS, BASE, OTHER_ROWS)},
    {"a shift beyond that", VXS_E_CORRUPT, 4, 3, LIST(OWN, 7, 9, 0, STEPS, BASE, OTHER_ROWS)},
    {"its greatest start", VXS_OK, 4, 3, LIST(OWN, 7, 0, 3, STEPS, BASE, OTHER_ROWS)},
    {"a start beyond that", VXS_E_CORRUPT, 4, 3, LIST(OWN, 7, 0, 4, STEPS, BASE, OTHER_ROWS)},
    {"a of it that is no half", VXS_E_CORRUPT, 4, 3, LIST(ONE, 0, LARGE, 0, 0, BASE, OTHER_ROWS)},
    {"a pool without room for a plane", VXS_E_CORRUPT, 4, 2, LIST(ONE, STEPS, BASE, OTHER_ROWS)},
    {"the nearer of two planes", VXS_OK, 4, 6, LIST(TWO(8), 0, 0, BASE, OTHER_ROWS)},
    {"the farther", VXS_OK, 4, 6, LIST(TWO(9), 0, 0, BASE, OTHER_ROWS)},
    {"the greatest shift of c", VXS_OK, 4, 6, LIST(TWO(8), 5, 0, BASE, OTHER_ROWS)},
    {"one beyond", VXS_E_CORRUPT, 4, 6, LIST(TWO(8), 6, 0, BASE, OTHER_ROWS)},
    {"the greatest c", VXS_OK, 4, 6, LIST(TWO(8), 0, 15, 0, 15, 0xfff, BASE, OTHER_ROWS)},
    {"one beyond", VXS_E_CORRUPT, 4, 6, LIST(TWO(8), 0, 15, 0, 16, 0, BASE, OTHER_ROWS)},
    {"the second plane's b no half", VXS_E_CORRUPT, 4, 6, LIST(OWN, 8, 0, 0, STEPS, 0, 0, LARGE, 0, 0, 0, BASE, OTHER_ROWS)},
    {"a pool without room for two planes", VXS_E_CORRUPT, 4, 4, LIST(TWO(9), 0, 0, BASE, OTHER_ROWS)},
    {"two planes by a mask", VXS_OK, 4, 10,
     LIST(TWO(10), 0, 0, BASE, 9, 0, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, OTHER_ROWS)},
    {"a pool without room for a mask", VXS_E_CORRUPT, 4, 8, LIST(TWO(10), 0, 0, BASE, ZEROS_16, OTHER_ROWS)},
    /* private-palette patterns */
    {"nibbles of 12", VXS_OK, 4, 19, LIST(OWN, 3, BASE, 0, 0, 15, 3, 2, ZEROS_62, OTHER_ROWS)},
    {"nibbles of 30", VXS_E_CORRUPT, 4, 19, LIST(OWN, 3, BASE, 0, 0, 15, 5, 7, 0, ZEROS_62, OTHER_ROWS)},
    {"no such pattern", VXS_E_CORRUPT, 4, 3, LIST(OWN, 12, 0, 0, 0, BASE, OTHER_ROWS)},
    /* what was met before */
    {"a plane on the left", VXS_OK, 5, 3, LIST(NONE_ON, BASE, NO_PALETTE, 3, 0, 7, 0, 0, STEPS, BASE, 3, BASE, OTHER_ROWS)},
    {"none on the left", VXS_E_CORRUPT, 4, 0, LIST(TILE, 3, BASE, OTHER_ROWS)},
    {"none above", VXS_E_CORRUPT, 4, 0, LIST(TILE, 4, BASE, OTHER_ROWS)},
    {"none lately", VXS_E_CORRUPT, 4, 0, LIST(TILE, 5, 0, BASE, OTHER_ROWS)},
    {"none in the list", VXS_E_CORRUPT, 4, 0, LIST(TILE, 2, 0, BASE, OTHER_ROWS)},
    {"a plane above", VXS_OK, 5, 3, LIST(ONE, STEPS, BASE, 1, 4, BASE, 0, 0)},
    {"no such place", VXS_E_CORRUPT, 5, 3, LIST(ONE, STEPS, BASE, 1, 6, BASE, 0, 0)},
    {"no block on the left", VXS_E_CORRUPT, 4, 0, LIST(2, BASE)},
    {"no block above", VXS_E_CORRUPT, 4, 0, LIST(3, BASE)},
    {"no block in the list", VXS_E_CORRUPT, 4, 0, LIST(1, 0, BASE)},
    {"a block once more", VXS_OK, 4, 0, TWICE(ALL_ON, FLAT, LEAST, BASE, 2, BASE)},
    {"one of the list", VXS_OK, 4, 0, TWICE(ALL_ON, FLAT, LEAST, BASE, 1, 0, BASE)},
    {"no such place of a block", VXS_E_CORRUPT, 4, 0, TWICE(ALL_ON, FLAT, LEAST, BASE, 4, 0, BASE)},
};

/* What lies behind the heads of a page and of a resident part: words of the coder, of which symbols of a list take none, and its
 * states. */
typedef struct coded_end {
    uint32_t words, states[2];
} coded_end;

static const coded_end good_end   = {0, {STATE_LEAST, STATE_LEAST}};
static const coded_end bad_ends[] = {
    {1, {STATE_LEAST, STATE_LEAST}}, {0, {STATE_LEAST + 1, STATE_LEAST}}, {0, {STATE_LEAST, STATE_LEAST + 1}}};

/* Returns the size of the bytes. */
static size_t put_end(uint8_t *bytes, size_t size, const coded_end *end)
{
    memset(bytes + size, 0, 2 * end->words);
    size += 2 * end->words;
    vxs_store32(bytes + size, end->states[0]);
    vxs_store32(bytes + size + 4, end->states[1]);
    return size + 8;
}

static vxs_result decode_list(const symbol_list *l, const coded_end *end)
{
    /* which blocks are mixed; one fresh depth */
    const uint16_t      node[] = {0, 1, l->twice ? 3 : 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
    const vxs_page_node first  = {0};
    uint16_t            all[20 + BLOCK_SYMBOLS_MAX + 63];
    uint8_t             bytes[16];
    uint32_t            count = sizeof node / sizeof *node + l->count, node_words = NODE_WORDS + l->twice + l->block_words;
    uint32_t            word_count = node_words + (l->pool_halves + 1) / 2;
    memcpy(all, node, sizeof node);
    memcpy(all + sizeof node / sizeof *node, l->block, l->count * sizeof *l->block);
    /* uniform blocks, like the last one: of VXS_PACKING_FINE only the fresh one has a symbol */
    uint32_t end_block = common.common.packing == VXS_PACKING_FINE ? 2 + l->twice : 64;
    for (uint32_t n = 1 + l->twice; n < end_block; n++) all[count++] = 2;
    vxs_store16(bytes, (uint16_t)(word_count - 1));
    vxs_store16(bytes + 2, (uint16_t)(node_words - 1));
    given             = all;
    taken_count       = 0;
    vxs_result result = drawn_decode(words, bytes, put_end(bytes, 4, end), &first, 1, &common.common, &scratch);
    given             = NULL;
    if (result != VXS_OK) return result;
    assert_int_equal(taken_count, count);
    assert_true(check_page(words, word_count, &first, 1, &common.common));
    return result;
}

static void rules_are_checked_one_by_one(void **state)
{
    (void)state;
    for (uint32_t packing = VXS_PACKING_SMALL; packing <= VXS_PACKING_FINE; packing += VXS_PACKING_FINE - VXS_PACKING_SMALL) {
        common.common.packing = packing;
        for (size_t n = 0; n < sizeof lists / sizeof *lists; n++)
            if (decode_list(&lists[n], &good_end) != lists[n].result) fail_msg("%s, packing %u", lists[n].what, (unsigned)packing);
    }
}

/* A light of one square, which is a depth, and no patterns. */
static vxs_result decode_resident_list(const coded_end *end)
{
    static const uint16_t all[2 + VXS_PATTERN_KINDS] = {TOP_DEPTH};
    vxs_page_node         node;
    uint32_t              pattern;
    uint32_t              page_first[1], light[10];
    vxs_resident          out       = {light, &node, page_first, &pattern, {0}};
    uint8_t               bytes[32] = {sizeof light / sizeof *light};
    given                           = all;
    taken_count                     = 0;
    vxs_result result = drawn_resident_decode(&out, 8, 1, VXS_PACKING_SMALL, bytes, put_end(bytes, 16, end), &scratch);
    given             = NULL;
    return result;
}

static void the_coder_ends_where_it_began(void **state)
{
    (void)state;
    assert_int_equal(decode_list(&lists[0], &good_end), VXS_OK);
    assert_int_equal(decode_resident_list(&good_end), VXS_OK);
    for (size_t n = 0; n < sizeof bad_ends / sizeof *bad_ends; n++) {
        assert_int_equal(decode_list(&lists[0], &bad_ends[n]), VXS_E_CORRUPT);
        assert_int_equal(decode_resident_list(&bad_ends[n]), VXS_E_CORRUPT);
    }
}

/* A node of a page is behind the one before it, in the page. */
static void nodes_of_a_top_lie_in_their_page(void **state)
{
    (void)state;
    static const struct {
        uint16_t high, middle, low;
        int      taken;
    } steps[] = {{0, 15, 0xffe, 1}, {0, 15, 0xfff, 0}, {0xff, 0xfff, 0xfff, 0}};
    for (size_t n = 0; n < sizeof steps / sizeof *steps; n++) {
        /* the first node of a page, the next one, and two depths */
        const uint16_t all[] = {4, 0, 0, 0, 3, 15, steps[n].high, steps[n].middle, steps[n].low, 0, 0, 0, 2, 0, 2, 0};
        given                = all;
        taken_count          = 0;
        assert_int_equal(walk_top(), steps[n].taken);
        given = NULL;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_symbols_make_blocks),       cmocka_unit_test(any_symbols_make_patterns),
        cmocka_unit_test(any_symbols_make_tops),         cmocka_unit_test(rules_are_checked_one_by_one),
        cmocka_unit_test(the_coder_ends_where_it_began), cmocka_unit_test(nodes_of_a_top_lie_in_their_page),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
