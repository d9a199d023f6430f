/* Patterns of tiles whose texels lie on one plane or on two, as where a slanted sheet ends before another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OWN_PLANES_H
#define OWN_PLANES_H

#include "baker/blocks/plane.h"
#include "baker/blocks/tile_ranges.h"

enum { OWN_PLANE_HALVES = 3, OWN_PAIR_HALVES = 6, OWN_PLANES_HALVES_MAX = 10 };

/* The ranges of a tile in parts of a voxel, from depth `from` on. */
void plane_ranges_of(plane_ranges *to, const tile_ranges *t, int32_t from);

/* Halves of one plane that passes through all ranges.
 * halves  [out] [OWN_PLANE_HALVES], formats/vxs.md 13.3;   depth  [out] [64] from the base on;   base  [out]
 * Returns their number; 0: there is none. */
uint32_t own_plane(const tile_ranges *t, uint16_t *halves, int32_t depth[64], int32_t *base);

/* The same of two planes, in at most `most` halves.   halves  [out] [OWN_PLANES_HALVES_MAX] */
uint32_t own_plane_pair(const tile_ranges *t, uint32_t most, uint16_t *halves, int32_t depth[64], int32_t *base);

#endif
