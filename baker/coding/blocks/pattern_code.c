/* Encodes patterns as halves; see pattern_code.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/pattern_code.h"

#include <string.h>

#include "baker/base/simd.h"

enum { STATE_LIT, STATE_DARK, STATE_OWN, STATE_SAME, IMAGE = 0xff };
enum { OWN_BYTES, OWN_HALVES, OWN_WORDS, RAW_NIBBLES, RAW_BYTES };

/* Bytes are stored low byte first in halves. */
static void put_byte(uint16_t *halves, uint32_t at, uint32_t byte)
{
    if (at & 1)
        halves[at / 2] |= (uint16_t)(byte << 8);
    else
        halves[at / 2] = (uint16_t)byte;
}

/* Texels below 32 are in the low nibbles of 32 bytes, the others in the high nibbles. */
static void put_nibbles(uint16_t *halves, const uint8_t nibble[64])
{
    for (uint32_t n = 0; n < 32; n++) put_byte(halves, n, nibble[n] | (uint32_t)nibble[n + 32] << 4);
}

uint32_t pattern_encode(const uint8_t index[64], int depths, uint16_t *halves)
{
    int      masks = depths - 1;
    uint64_t mask_bits[OWN_DEPTHS_MAX];
    uint16_t own[4 * (OWN_DEPTHS_MAX - 1)];
    uint8_t  states[OWN_DEPTHS_MAX] = {0};
    uint32_t count                  = 0;
    for (int mask = 0; mask < masks; mask++) mask_bits[mask] = bytes_at_most(index, (uint8_t)mask);
    for (int q = 0; q < 4; q++)
        for (int mask = 0, owned = 0; mask < masks; mask++) {
            uint16_t bits = (uint16_t)(mask_bits[mask] >> 16 * q);
            int state = !bits ? STATE_LIT : bits == 0xffff ? STATE_DARK : owned && own[count - 1] == bits ? STATE_SAME : STATE_OWN;
            states[mask] |= (uint8_t)(state << 2 * q);
            if (state != STATE_OWN) continue;
            own[count++] = bits;
            owned        = 1;
        }
    uint32_t head = (uint32_t)(masks + 1) / 2;
    if (head + count > PATTERN_HALVES_MAX) {
        halves[0] = IMAGE;
        put_nibbles(halves + 1, index);
        return PATTERN_HALVES_MAX;
    }
    for (int n = 0; n < masks; n++) put_byte(halves, (uint32_t)n, states[n]);
    memcpy(halves + head, own, count * sizeof *own);
    return head + count;
}

/* private-palette patterns ---------------------------------------------------------------------------------------------------- */

/* The distinct depths, ascending. Each search starts at the previous texel's depth, because neighbours are similar.
 * Returns their number, or OWN_DEPTHS_MAX + 1. */
static int depths_of(const int32_t depth[64], int32_t *list)
{
    int count = 0, at = 0;
    for (int n = 0; n < 64; n++) {
        while (at && list[at - 1] >= depth[n]) at--;
        while (at < count && list[at] < depth[n]) at++;
        if (at < count && list[at] == depth[n]) continue;
        if (count == OWN_DEPTHS_MAX) return OWN_DEPTHS_MAX + 1;
        for (int m = count++; m > at; m--) list[m] = list[m - 1];
        list[at] = depth[n];
    }
    return count;
}

/* Encode as a palette and a pattern. Returns 0 if there are too many depths. */
static uint32_t encode_palette(const int32_t depth[64], int shift, int32_t greatest, uint16_t *halves)
{
    int32_t  list[OWN_DEPTHS_MAX + 1];
    uint8_t  index[64];
    int      count = depths_of(depth, list), bytes = greatest >> shift <= 0xff, at_halves = greatest >> shift <= 0xffff;
    uint32_t at = 1;
    if (count < 2 || count > OWN_DEPTHS_MAX) return 0;
    if (!bytes && !at_halves) shift = 0;
    halves[0] = (uint16_t)((bytes ? OWN_BYTES : at_halves ? OWN_HALVES : OWN_WORDS) << 12 | shift << 8 | count);
    for (int n = 1; n < count; n++) {
        uint32_t delta = (uint32_t)(list[n] - list[0]) >> shift;
        if (bytes) {
            put_byte(halves + 1, (uint32_t)n - 1, delta);
            continue;
        }
        halves[at++] = (uint16_t)delta;
        if (!at_halves) halves[at++] = (uint16_t)(delta >> 16);
    }
    if (bytes) at += (uint32_t)count / 2;
    for (int n = 0; n < 64; n++) {
        index[n] = n && depth[n] >= depth[n - 1] ? index[n - 1] : 0;
        while (list[index[n]] != depth[n]) index[n]++;
    }
    return at + pattern_encode(index, count, halves + at);
}

/* Encode as nibbles over a base for each quadrant. Returns 0 if the depths of a quadrant span too much. */
static uint32_t encode_nibbles(const int32_t depth[64], int shift, uint16_t *halves)
{
    uint8_t nibble[64];
    halves[0] = (uint16_t)(RAW_NIBBLES << 12 | shift << 8);
    for (uint32_t q = 0; q < 4; q++) {
        int32_t least = depth[16 * q], most = least;
        for (uint32_t n = 16 * q; n < 16 * q + 16; n++) {
            least = depth[n] < least ? depth[n] : least;
            most  = depth[n] > most ? depth[n] : most;
        }
        if (least >> shift > 0xff || (most - least) >> shift > 15) return 0;
        for (uint32_t n = 16 * q; n < 16 * q + 16; n++) nibble[n] = (uint8_t)((depth[n] - least) >> shift);
        put_byte(halves + 1, q, (uint32_t)least >> shift);
    }
    put_nibbles(halves + 3, nibble);
    return 19;
}

/* bytes  per depth */
static void encode_raw(const int32_t depth[64], int shift, uint32_t bytes, uint16_t *halves)
{
    halves[0] = (uint16_t)((RAW_BYTES + bytes - 1) << 12 | (uint32_t)shift << 8);
    for (uint32_t n = 0; n < 64; n++)
        for (uint32_t b = 0; b < bytes; b++) put_byte(halves + 1, bytes * n + b, (uint32_t)depth[n] >> shift >> 8 * b & 0xff);
}

uint32_t own_encode(const int32_t depth[64], uint16_t *halves)
{
    uint16_t other[OWN_HALVES_MAX];
    int32_t  bits = 0, greatest = 0;
    for (int n = 0; n < 64; n++) {
        bits |= depth[n];
        greatest = depth[n] > greatest ? depth[n] : greatest;
    }
    int      shift = (int)common_shift((uint32_t)bits);
    uint32_t bytes = greatest >> shift <= 0xff ? 1 : greatest >> shift <= 0xffff ? 2 : 3, raw = 1 + 32 * bytes;
    uint32_t palette = encode_palette(depth, shift, greatest, halves), nibbles = encode_nibbles(depth, shift, other);
    uint32_t least = nibbles ? nibbles : raw;
    if (palette && palette < least) return palette;
    if (nibbles)
        memcpy(halves, other, nibbles * sizeof *other);
    else
        encode_raw(depth, shift, bytes, halves);
    return least;
}
