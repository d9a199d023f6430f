/* Numbers as nibbles and plain bits: of any size, steps to a number that is probably round, and signed numbers.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_NUMBERS_H
#define VXS_PAGE_NUMBERS_H

#include "vxs_page_coder.h"

enum { NUMBER_LONG = 15, SIGNED_MOST = (1 << 28) - 1 /* greatest signed number */ };

typedef struct number_odds {
    nibble_odds size, rest[5];
} number_odds;

typedef struct signed_odds {
    nibble_odds sign;
    number_odds size;
} signed_odds;

PAGE_INLINE uint32_t code_flag(coder *c, nibble_odds *odds, uint32_t value)
{
    return code_nibble(c, odds, value) != 0;
}

/* Number of bits of value + 1 after the leading one; NUMBER_LONG: all 32 bits are coded. */
PAGE_INLINE uint32_t code_size(coder *c, nibble_odds *odds, uint32_t value)
{
    uint32_t size = 0;
    if (PAGE_ENCODING) size = page_last_bit(value + 1);
    return code_nibble(c, odds, size < NUMBER_LONG ? size : NUMBER_LONG);
}

PAGE_INLINE uint32_t code_long(coder *c, uint32_t value)
{
    uint32_t high = code_plain(c, 8, value >> 24), middle = code_plain(c, 12, value >> 12 & 0xfff);
    return high << 24 | middle << 12 | code_plain(c, 12, value & 0xfff);
}

/* Any number below 2^32 - 1: its size, then the bits after the leading one. Up to four such bits are coded with adaptive
 * odds, more as plain bits. */
PAGE_INLINE uint32_t code_number(coder *c, number_odds *odds, uint32_t value)
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
PAGE_INLINE uint32_t code_step(coder *c, number_odds *odds, nibble_odds *round, uint32_t last, uint32_t value)
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
PAGE_INLINE int32_t code_signed(coder *c, signed_odds *odds, int32_t value)
{
    uint32_t size = code_number(c, &odds->size, (uint32_t)(value < 0 ? -value : value)) & SIGNED_MOST;
    if (!size) return 0;
    return code_flag(c, &odds->sign, value < 0) ? -(int32_t)size : (int32_t)size;
}

#endif
