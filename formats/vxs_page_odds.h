/* Odds of a page: numbers coded with them as nibbles and plain bits; then the contexts of each value, and start values.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_ODDS_H
#define VXS_PAGE_ODDS_H

#include "vxs_page.h"
#include "vxs_page_coder.h"

/* numbers: of any size, steps to a number that is probably round, signed -------------------------------------------------------- */

enum { NUMBER_LONG = 15, SIGNED_MOST = (1 << 28) - 1 /* greatest signed number */ };

typedef struct number_odds {
    nibble_odds size, rest[5];
} number_odds;

typedef struct signed_odds {
    nibble_odds sign;
    number_odds size;
} signed_odds;

PAGE_CALL uint32_t code_flag(coder *c, nibble_odds *odds, uint32_t value)
{
    return code_nibble(c, odds, value) != 0;
}

/* Number of bits of value + 1 after the leading one; NUMBER_LONG: all 32 bits are coded. */
PAGE_CALL uint32_t code_size(coder *c, nibble_odds *odds, uint32_t value)
{
    uint32_t size = 0;
    if (PAGE_ENCODING) size = page_last_bit(value + 1);
    return code_nibble(c, odds, size < NUMBER_LONG ? size : NUMBER_LONG);
}

PAGE_CALL uint32_t code_long(coder *c, uint32_t value)
{
    uint32_t high = code_plain(c, 8, value >> 24), middle = code_plain(c, 12, value >> 12 & 0xfff);
    return high << 24 | middle << 12 | code_plain(c, 12, value & 0xfff);
}

/* Any number below 2^32 - 1: its size, then the bits after the leading one. Up to four such bits are coded with adaptive
 * odds, more as plain bits. */
PAGE_CALL uint32_t code_number(coder *c, number_odds *odds, uint32_t value)
{
    uint32_t size = code_size(c, &odds->size, value), first = (1u << size) - 1, rest = value - first;
    if (!size) return 0;
    if (size == NUMBER_LONG) return code_long(c, value);
    if (size <= 4) return first + code_nibble(c, &odds->rest[size], rest & 15);
    if (size <= 12) return first + code_plain(c, size, rest);
    uint32_t high = code_plain(c, size - 12, rest >> 12);
    return first + (high << 12 | code_plain(c, 12, rest & 0xfff));
}

/* The step from last + 1 to a number that is probably round. If the step has more than four bits after the leading one, the
 * low bits of the sum last + value + 1 are coded instead, with the number of their low zero bits. */
PAGE_CALL uint32_t code_step(coder *c, number_odds *odds, nibble_odds *round, uint32_t last, uint32_t value)
{
    uint32_t size = code_size(c, &odds->size, value), first = (1u << size) - 1, rest = value - first;
    if (!size) return 0;
    if (size == NUMBER_LONG) return code_long(c, value);
    if (size <= 4) return first + code_nibble(c, &odds->rest[size], rest & 15);
    uint32_t low = size < 12 ? size : 12, mask = (1u << low) - 1;
    if (size > 12) first += code_plain(c, size - 12, rest >> 12) << 12;
    uint32_t bits  = (last + value + 1) & mask;
    uint32_t zeros = code_nibble(c, &round[low], bits ? page_first_bit(bits) : low), more = zeros < low ? low - zeros - 1 : 0;
    bits = zeros < low ? (code_plain(c, more, bits >> (zeros + 1)) << 1 | 1) << zeros : 0;
    return first + ((bits - last - first - 1) & mask);
}

/* A number from -SIGNED_MOST to SIGNED_MOST. */
PAGE_CALL int32_t code_signed(coder *c, signed_odds *odds, int32_t value)
{
    uint32_t size = code_number(c, &odds->size, (uint32_t)(value < 0 ? -value : value)) & SIGNED_MOST;
    if (!size) return 0;
    return code_flag(c, &odds->sign, value < 0) ? -(int32_t)size : (int32_t)size;
}

/* contexts ---------------------------------------------------------------------------------------------------------------------- */

typedef struct plane_odds {
    nibble_odds shift, zeros;
    signed_odds a[3], b[3];
} plane_odds;

/* Room of a set of vxs_page_tiles.h; a set of patterns leaves one place empty. */
enum { PATTERN_LANES = 16, USED_LANES = 4 };

/* Consists only of nibble_odds, so that it can be used as one array. */
typedef struct page_odds {
    /* nodes */
    nibble_odds node_mixed[64], depth_like[4][16][12];
    nibble_odds wide, same_slope, no_slope;
    signed_odds slope, depth;
    number_odds high, fresh_count;
    /* blocks */
    nibble_odds block_found[5];
    number_odds block;
    signed_odds base[3][4];
    nibble_odds entries[5][8], delta_form[6][4], delta_shift, delta_width, last_depth[4];
    number_odds delta[224], delta_wide;
    nibble_odds round[13];
    nibble_odds block_mixed[5][64], index[5][3][12];
    nibble_odds on_plane[9], plane_like[9], row_on_plane[64], row_mixed[5][16], least_zeros[2];
    plane_odds  block_plane;
    signed_odds plane_least[2][3];
    /* tiles */
    nibble_odds used[4][256]; /* [entries left if fewer than four, else 0] */
    nibble_odds used_again[2][USED_LANES], pattern_again[4][PATTERN_LANES];
    number_odds pattern[VXS_PATTERN_KINDS], common[VXS_PATTERN_KINDS];
    signed_odds private_base[3];
    number_odds private_lately;
    nibble_odds private_found[5];
    /* patterns; the resident part has these alone */
    nibble_odds differs[2][2][128], other[4][5][3], far;
    nibble_odds private_round[13], private_kind[3], private_shift, private_count, residual[3][6];
    number_odds private_delta, raw_far, raw_base;
    plane_odds  private_plane[3];
    nibble_odds far_shift, quarters[2];
    number_odds far_plane;
} page_odds;

/* Weights of two bits, which are 1 with odds of so many in 256.   high  of the second bit, if the first one is 0 or 1 */
PAGE_INLINE void start_two(uint32_t weight[4], uint32_t low, const uint32_t high[2])
{
    for (uint32_t n = 0; n < 4; n++) weight[n] = (n & 1 ? low : 256 - low) * (n & 2 ? high[n & 1] : 256 - high[n & 1]);
}

/* Start odds of a nibble from weights of its low two bits, and of its high two bits after a second bit of 0 or 1. */
PAGE_INLINE void start_four(nibble_odds *odds, const uint32_t low[4], uint32_t high[2][4])
{
    uint32_t weight[16];
    for (uint32_t n = 0; n < 16; n++) weight[n] = low[n & 3] * high[n >> 1 & 1][n >> 2];
    nibble_start(odds, weight, 5);
}

/* Start odds of a nibble with independent bits: bit n is 1 with odds chance[(states >> n & 1) + 2 * (states >> (n + 4) & 1)]
 * of 256. */
static void start_mask(nibble_odds *odds, uint32_t states, const uint8_t chance[4], uint32_t bits)
{
    uint32_t one[4], low[4], high[2][4];
    for (uint32_t n = 0; n < 4; n++) one[n] = n < bits ? chance[(states >> n & 1) + 2 * (states >> (n + 4) & 1)] : 0;
    start_two(low, one[0], (uint32_t[]){one[1], one[1]});
    start_two(high[0], one[2], (uint32_t[]){one[3], one[3]});
    memcpy(high[1], high[0], sizeof high[0]);
    start_four(odds, low, high);
}

/* Start odds of which of four texels differ from those above. Bits 0..4 of k: texels above differ from those on their left.
 * Bit 5: the texel on the left of the four differs from the one above it. */
static void start_differs(nibble_odds *odds, uint32_t k)
{
    uint32_t one[4][2], low[4], high[2][4]; /* one: of each bit, after a bit of 0 or 1 */
    for (uint32_t n = 0; n < 4; n++) one[n][0] = k >> n & 3 ? 77 : 10, one[n][1] = 128;
    start_two(low, one[0][k >> 5 & 1], one[1]);
    for (uint32_t n = 0; n < 2; n++) start_two(high[n], one[2][n], one[3]);
    start_four(odds, low, high);
}

/* Copies of the first of so many elements. */
static void repeat(void *first, size_t size, size_t count)
{
    for (size_t done = 1, more; done < count; done += more) {
        more = done < count - done ? done : count - done;
        memcpy((char *)first + done * size, first, more * size);
    }
}

/* Odds of so many numbers: bits behind the leading one start with even odds of those that there are. */
static void start_numbers(number_odds *odds, size_t count)
{
    for (uint32_t size = 1; size <= 4; size++) {
        uint32_t weight[16];
        for (uint32_t n = 0; n < 16; n++) weight[n] = n >> size ? 0 : 1u << (32 - size);
        nibble_start(&odds->rest[size], weight, 0);
    }
    repeat(odds, sizeof *odds, count);
}

static void start_signed(signed_odds *odds, size_t count)
{
    uint32_t weight[16] = {1u << 31, 1u << 31};
    nibble_start(&odds->sign, weight, 0);
    start_numbers(&odds->size, 1);
    repeat(odds, sizeof *odds, count);
}

#define ODDS_OF(type, array) (type *)(void *)(array), sizeof(array) / sizeof(type)

/* Pages of VXS_PACKING_FINE have many contexts of few symbols each. */
static void start_fine(page_odds *odds)
{
    start_numbers(ODDS_OF(number_odds, odds->delta));
    start_numbers(ODDS_OF(number_odds, odds->pattern));
    start_numbers(ODDS_OF(number_odds, odds->common));
    start_signed(ODDS_OF(signed_odds, odds->base));
    start_signed(ODDS_OF(signed_odds, odds->private_base));
    nibble_odds *like = &odds->depth_like[0][0][0];
    uint32_t     weight[16];
    for (uint32_t n = 0; n < 16; n++) weight[n] = 1u << (n < 15 ? 31 - n : 17); /* each half as likely as the one before */
    nibble_start(like, weight, 0);
    repeat(like, sizeof *like, sizeof odds->depth_like / sizeof *like);
}

/* So many rows, with even odds. */
static void start_even(nibble_odds *odds, size_t count)
{
    uint32_t even[16];
    for (uint32_t n = 0; n < 16; n++) even[n] = 1 << 28;
    nibble_start(odds, even, 0);
    repeat(odds, sizeof *odds, count);
}

/* The odds of patterns; others stay as they are. */
static void start_patterns(page_odds *odds)
{
    const size_t before = offsetof(page_odds, differs);
    start_even((nibble_odds *)(void *)((char *)odds + before), (sizeof *odds - before) / sizeof(nibble_odds));
    for (uint32_t k = 0; k < 64; k++) start_differs(&odds->differs[0][0][k], k);
    repeat(odds->differs, 64 * sizeof(nibble_odds), sizeof odds->differs / (64 * sizeof(nibble_odds)));
}

static void start_odds(page_odds *odds, int fine)
{
    static const uint8_t used[4] = {38, 64, 128, 218}, mixed[4] = {51, 179};
    start_even((nibble_odds *)odds, offsetof(page_odds, differs) / sizeof(nibble_odds));
    start_patterns(odds);
    for (uint32_t k = 0; k < 16; k++) start_mask(&odds->node_mixed[k], k, mixed, 4);
    repeat(odds->node_mixed, 16 * sizeof(nibble_odds), 4);
    for (uint32_t q = 0; q < 5; q++) memcpy(odds->block_mixed[q], odds->node_mixed, sizeof odds->node_mixed);
    if (fine) start_fine(odds);
    for (uint32_t left = 0; left < 4; left++) {
        uint32_t bits = left ? left : 4, known = ((1u << bits) - 1) * 0x11; /* bits of k that are used */
        for (uint32_t k = 0; k < 256; k++)
            if (k & ~known)
                odds->used[left][k] = odds->used[left][k & known];
            else
                start_mask(&odds->used[left][k], k, used, bits);
    }
}

#endif
