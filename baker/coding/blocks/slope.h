/* The slope of a node: what is added to the depths of its tiles, so that flat ground that the light meets at an angle has one depth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SLOPE_H
#define SLOPE_H

#include <stdint.h>

enum { NODE_TILES = 32, NODE_PX = 256, SLOPE_MAX = 20000 };

/* In 1/256 voxel a tile, to the right and down; each within +-SLOPE_MAX. */
typedef struct node_slope {
    int32_t x, y;
} node_slope;

/* What is added to the depths of tile (x, y), [0, 32): never negative. As formats/vxs_lookup_blocks.h does it. */
static inline int32_t slope_shift(node_slope s, int32_t x, int32_t y)
{
    return ((s.x < 0 ? s.x * (x - 31) : s.x * x) + (s.y < 0 ? s.y * (y - 31) : s.y * y)) >> 8;
}

/* The most that is added to any tile. */
static inline int32_t slope_shift_max(node_slope s)
{
    return ((s.x < 0 ? -s.x : s.x) * 31 + (s.y < 0 ? -s.y : s.y) * 31) >> 8;
}

/* A slope under which few blocks of 4 x 4 tiles are left without a depth for all of their columns.
 * emax, xmin  [32 * 32] rows of tiles: the last enter and the first exit of each, [0, 2^19] voxels
 * first       tried first: that of the node before
 * Returns {0, 0} where no slope helps. */
node_slope slope_find(const int32_t *emax, const int32_t *xmin, node_slope first);

#endif
