/* What a tile needs of a palette: which of its entries, and which texels have to be lit and dark between them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TILE_NEEDS_H
#define TILE_NEEDS_H

#include "baker/coding/blocks/patterns.h"

/* The fewest entries that a tile can do with, and what each mask between two of them needs.
 * low, high  [64] of texels, as codes
 * points     [count] codes of the palette's depths, ascending; each texel may have one of them at least
 * needs      [out] [entries - 1]
 * cpu        what may be used, of cpu.h: it decides on time alone
 * Returns the bits of the entries. */
uint32_t tile_needs(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, mask_need *needs, int cpu);

#endif
