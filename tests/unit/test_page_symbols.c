/* What the decoder of pages makes of any symbols (formats/vxs_page_model.h): the coder is taken out, and symbols are drawn by chance, so
 * that nothing but the walk's own checks stands between them and the words. What it takes must keep the rules of the layout.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "page_sample.h"

#include <cmocka.h>

size_t     drawn_scratch_bytes(void);
void       drawn_scratch_init(vxs_page_scratch *scratch);
uint32_t   drawn_word_count(const uint8_t *bytes, size_t size_bytes);
vxs_result drawn_decode(uint32_t *words, const uint8_t *bytes, size_t size_bytes, const vxs_page_node *nodes, uint32_t node_count,
                        const vxs_common *common, vxs_page_scratch *scratch);
vxs_result drawn_sizes_of(vxs_resident_sizes *sizes, const uint8_t *bytes, size_t size_bytes);
vxs_result drawn_resident_decode(vxs_resident *out, uint32_t levels, uint32_t map_count, const uint8_t *bytes, size_t size_bytes,
                                 vxs_page_scratch *scratch);

#define PAGE_ENCODING 0
#define code_nibble   real_code_nibble
#define code_plain    real_code_plain
#include "formats/vxs_page_coder.h"
#undef code_nibble
#undef code_plain
#undef PAGE_ENCODING

static rng      draw;
static uint32_t wild; /* one symbol of so many may be any; the others are small */

static uint32_t code_nibble(coder *c, nibble_odds *odds, uint32_t value)
{
    (void)c, (void)odds, (void)value;
    uint32_t any = rng_below(&draw, 16);
    return rng_below(&draw, wild) ? any & rng_below(&draw, 16) & 7 : any;
}

static uint32_t code_plain(coder *c, uint32_t bits, uint32_t value)
{
    (void)c, (void)value;
    return rng_u32(&draw) & ((1u << bits) - 1);
}

#define vxs_page_scratch_bytes drawn_scratch_bytes
#define vxs_page_scratch_init  drawn_scratch_init
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
                          .half       = 2 * node_words,
                          .common     = &common.common};
    memset(words, 0, sizeof words);
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
    for (uint64_t seed = 0; seed < 30000; seed++) {
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
    uint32_t taken[VXS_PATTERN_KINDS] = {0};
    for (uint64_t seed = 0; seed < 300000; seed++) {
        draw               = rng_split(seed, 2);
        wild               = 2 + (uint32_t)(seed % 9) * 20;
        uint32_t      kind = rng_below(&draw, VXS_PATTERN_KINDS);
        uint32_t      room = 1 + rng_below(&draw, seed % 4 ? 200 : 20);
        resident_walk r    = {.w = {.odds = &scratch.odds, .s = &scratch, .words = words, .word_count = room}};
        vxs_pattern   made = {.kind = kind == 1 ? 0 : kind};
        checked_words pool = {words, 0};
        int           good = 1;
        memset(words, 0, (room + 1) * sizeof *words);
        int done = code_common_pattern(&r, &made);
        assert_int_equal(words[room], 0);
        if (!done) continue;
        assert_true(r.w.half <= 2 * room);
        pool.halves = r.w.half;
        if (made.kind)
            check_masks(pool, 0, made.kind, &good);
        else
            check_own(pool, 0, &good);
        assert_true(good);
        taken[made.kind]++;
    }
    for (uint32_t k = 0; k < VXS_PATTERN_KINDS; k++) assert_true(k == 1 || taken[k] > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_symbols_make_blocks),
        cmocka_unit_test(any_symbols_make_patterns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
