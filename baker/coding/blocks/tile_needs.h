/* Needs of a tile for a given palette: entries that it uses, and texels that must be lit or dark between them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TILE_NEEDS_H
#define TILE_NEEDS_H

#include "baker/coding/blocks/patterns.h"

/* Find the fewest entries that are enough for a tile, and the needs of each mask between two of them.
 * low, high  [64] ranges of texels, as codes
 * points     [count] codes of the palette's depths, ascending; the range of each texel contains at least one
 * needs      [out] [entries - 1]
 * cpu        level of cpu.h; affects only time
 * Returns the bits of the entries. */
uint32_t tile_needs(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, mask_need *needs, int cpu);

#endif
