/* Depth ranges in which the columns of a tile allow the shadow to begin.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TILE_RANGES_H
#define TILE_RANGES_H

#include <stdint.h>

/* [low, high] of 64 texels, in the order of patterns.h, in voxels. */
typedef struct tile_ranges {
    int32_t low[64], high[64];
} tile_ranges;

static inline int32_t least_high(const tile_ranges *t)
{
    int32_t least = t->high[0];
    for (int n = 1; n < 64; n++) least = t->high[n] < least ? t->high[n] : least;
    return least;
}

#endif
