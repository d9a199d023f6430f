/* Patterns of tiles: which texels of 8 x 8 are in shadow behind each of a few depths, without the depths, shared by a whole map.
 *
 * A tile that needs p depths has p - 1 masks, each within the next: behind depth n, the texels of mask n are in shadow. Most texels of
 * most masks may be either, because a column's contract is an interval. So what is kept of a pattern, until all tiles have theirs, is
 * what each mask needs: texels that must be dark, and texels that must be lit. A tile takes a known pattern whose needs do not contradict
 * its own; the pattern then needs both. Depths of texels are chosen at the end.
 *
 * Texel (x, y) is bit 16 q + 4 (y & 3) + (x & 3) of a mask, in quadrant q = (x >> 2) + 2 (y >> 2).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PATTERNS_H
#define PATTERNS_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

enum {
    PALETTE_MAX    = 14,  /* depths of a pattern, and of a block */
    PATTERN_WINDOW = 2048 /* patterns with as many depths that a tile is compared with */
};

/* Where texel (x, y) of a tile is among its 64. */
static inline int pattern_texel(int x, int y)
{
    return ((x >> 2) + 2 * (y >> 2)) * 16 + (y & 3) * 4 + (x & 3);
}

/* What one mask of a pattern needs. */
typedef struct mask_need {
    uint64_t dark, lit;
} mask_need;

/* The patterns with p depths, in the order in which they are searched, the last first. */
typedef struct pattern_class {
    uint32_t *ids;
    uint64_t *needs; /* rows of `capacity`: of each mask two, dark and lit */
    size_t    count, capacity;
} pattern_class;

/* Zero it. */
typedef struct pattern_set {
    pattern_class by_depths[PALETTE_MAX + 1];
    uint32_t      count; /* ids are [0, count) */
    int           cpu;   /* [in] what searches may use, of cpu.h: it decides on time alone */
} pattern_set;

/* A pattern that fits, or a new one.
 * depths  p, [2, PALETTE_MAX];   needs  [p - 1]
 * id      [out]
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result pattern_find(pattern_set *s, int depths, const mask_need *needs, uint32_t *id);

/* The next pattern of its class, as it was in a set that was saved. Ids are in no order; the caller sees to it that each is given once.
 * Returns the same. */
vxs_result pattern_put(pattern_set *s, int depths, const mask_need *needs, uint32_t id);

/* What a pattern needs in the end; place n of its class. */
void pattern_needs(const pattern_set *s, int depths, size_t n, mask_need *needs);

/* Which depth each texel has, [0, depths): as few different ones in a quadrant as its needs allow, and of those what is beside.
 * index  [out] [64] */
void pattern_choose(const mask_need *needs, int depths, uint8_t index[64]);

/* The same from ranges: texel n has one of low[n]..high[n]. */
void pattern_choose_within(const uint8_t low[64], const uint8_t high[64], uint8_t index[64]);

void pattern_set_free(pattern_set *s);

#endif
