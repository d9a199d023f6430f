/* Patterns of tiles: which of 8 x 8 texels are in shadow behind each of a few depths. Patterns do not contain the depths, and a
 * whole map shares them.
 *
 * A tile that needs p depths has p - 1 masks, each a subset of the next: behind depth n, the texels of mask n are in shadow. Most
 * texels of most masks may have either value, because the contract of a column is an interval. So until all tiles have patterns, a
 * pattern stores only the needs of each mask: texels that must be dark, and texels that must be lit. A tile takes a known pattern
 * whose needs do not contradict its own; the pattern then has the needs of both. The depths of texels are chosen at the end.
 *
 * Texel (x, y) is bit 16 q + 4 (y & 3) + (x & 3) of a mask, in quadrant q = (x >> 2) + 2 (y >> 2).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PATTERNS_H
#define PATTERNS_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

enum {
    PALETTE_MAX    = 14,  /* most depths of a pattern, and of a block */
    PATTERN_WINDOW = 2048 /* number of patterns with as many depths that a tile is compared with */
};

/* Index of texel (x, y) of a tile, [0, 64). */
static inline int pattern_texel(int x, int y)
{
    return ((x >> 2) + 2 * (y >> 2)) * 16 + (y & 3) * 4 + (x & 3);
}

/* What one mask of a pattern needs. */
typedef struct mask_need {
    uint64_t dark, lit;
} mask_need;

/* The patterns with p depths. Search order is last to first. */
typedef struct pattern_class {
    uint32_t *ids;
    uint64_t *needs; /* rows of `capacity`: two for each mask, dark and lit */
    size_t    count, capacity;
} pattern_class;

/* Zero it. */
typedef struct pattern_set {
    pattern_class by_depths[PALETTE_MAX + 1];
    uint32_t      count; /* ids are [0, count) */
    int           cpu;   /* [in] level of cpu.h for searches; affects only time */
} pattern_set;

/* Find a pattern that fits, or add one.
 * depths  p, [2, PALETTE_MAX];   needs  [p - 1]
 * id      [out]
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result pattern_find(pattern_set *s, int depths, const mask_need *needs, uint32_t *id);

/* Append a pattern to its class, when a saved set is loaded. Ids come in any order; the caller makes sure that each is given once.
 * Returns the same. */
vxs_result pattern_put(pattern_set *s, int depths, const mask_need *needs, uint32_t id);

/* Final needs of a pattern: number n of its class. */
void pattern_needs(const pattern_set *s, int depths, size_t n, mask_need *needs);

/* Choose the depth index of each texel, [0, depths): as few distinct ones in a quadrant as the needs allow, preferring
 * neighbours' indices.
 * index  [out] [64] */
void pattern_choose(const mask_need *needs, int depths, uint8_t index[64]);

/* The same from ranges: texel n takes one of low[n]..high[n]. */
void pattern_choose_within(const uint8_t low[64], const uint8_t high[64], uint8_t index[64]);

void pattern_set_free(pattern_set *s);

/* Encodes patterns as halves for lookups (formats/vxs.md, "Patterns"). */

enum { PATTERN_HALVES_MAX = 17, PRIVATE_HALVES_MAX = 97, PRIVATE_DEPTHS_MAX = 16 };

/* Number of trailing zero bits that depths have in common, at most 15.   bits  the depths, or-ed together */
static inline uint32_t common_shift(uint32_t bits)
{
    uint32_t shift = 0;
    while (bits && shift < 15 && !(bits >> shift & 1)) shift++;
    return shift;
}

/* index  [64] depth of each texel, [0, depths);   depths  [2, PRIVATE_DEPTHS_MAX];   halves  [out] [PATTERN_HALVES_MAX]
 * Returns the number of halves. */
uint32_t pattern_encode(const uint8_t index[64], int depths, uint16_t *halves);

/* depth  [64] each [0, 2^24);   halves  [out] [PRIVATE_HALVES_MAX]. Returns the number of halves, in the smallest form. */
uint32_t private_encode(const int32_t depth[64], uint16_t *halves);

#endif
