/* Numbers of the coder, made of nibbles and plain bits: of any size, steps to what is likely to be round, and signed ones.
 * Internal to vxs_page_*.c, which say PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_NUMBERS_H
#define VXS_PAGE_NUMBERS_H

#include "vxs_page_coder.h"

enum { SIGNED_MOST = (1 << 28) - 1 }; /* of numbers with a sign */

typedef struct number_odds {
    nibble_odds size, top[15];
} number_odds;

typedef struct signed_odds {
    nibble_odds sign;
    number_odds size;
} signed_odds;

PAGE_INLINE uint32_t code_flag(coder *c, nibble_odds *odds, uint32_t value)
{
    return code_nibble(c, odds, value) != 0;
}

/* Any number below 2^32 - 1: how many bits v + 1 has, up to four bits behind its first, and the rest as it is. */
PAGE_INLINE uint32_t code_number(coder *c, number_odds *odds, uint32_t value)
{
    uint32_t size = 0;
    if (PAGE_ENCODING) size = page_last_bit(value + 1) < 15 ? page_last_bit(value + 1) : 15;
    size = code_nibble(c, &odds->size, size);
    if (!size) return 0;
    if (size == 15) {
        uint32_t high = code_plain(c, 8, value >> 24), middle = code_plain(c, 12, value >> 12 & 0xfff);
        return high << 24 | middle << 12 | code_plain(c, 12, value & 0xfff);
    }
    uint32_t low = size > 4 ? size - 4 : 0, rest = value + 1 - (1u << size);
    uint32_t top = code_nibble(c, &odds->top[size], rest >> low & 15);
    rest         = low ? code_plain(c, low, rest & ((1u << low) - 1)) : 0;
    return (1u << size) + (top << low | rest) - 1;
}

/* A number that is the step from `last` + 1 to one that is likely to be round: low bits of the sum are coded, not of the step. */
PAGE_INLINE uint32_t code_step(coder *c, number_odds *odds, nibble_odds *round, uint32_t last, uint32_t value)
{
    uint32_t size = 0;
    if (PAGE_ENCODING) size = page_last_bit(value + 1) < 15 ? page_last_bit(value + 1) : 15;
    size = code_nibble(c, &odds->size, size);
    if (!size) return 0;
    if (size == 15) {
        uint32_t high = code_plain(c, 8, value >> 24), middle = code_plain(c, 12, value >> 12 & 0xfff);
        return high << 24 | middle << 12 | code_plain(c, 12, value & 0xfff);
    }
    uint32_t low = size > 4 ? size - 4 : 0, rest = value + 1 - (1u << size), mask = (1u << low) - 1;
    uint32_t step = (1u << size) + (code_nibble(c, &odds->top[size], rest >> low & 15) << low); /* at least */
    if (!low) return step - 1;
    uint32_t bits  = (last + value + 1) & mask;
    uint32_t zeros = code_nibble(c, &round[low], bits ? page_first_bit(bits) : low), more = zeros < low ? low - zeros - 1 : 0;
    bits = zeros < low ? (code_plain(c, more, bits >> (zeros + 1)) << 1 | 1) << zeros : 0;
    return step + ((bits - last - step) & mask) - 1;
}

/* A number from -SIGNED_MOST to SIGNED_MOST. */
PAGE_INLINE int32_t code_signed(coder *c, signed_odds *odds, int32_t value)
{
    uint32_t size = code_number(c, &odds->size, (uint32_t)(value < 0 ? -value : value)) & SIGNED_MOST;
    if (!size) return 0;
    return code_flag(c, &odds->sign, value < 0) ? -(int32_t)size : (int32_t)size;
}

#endif
