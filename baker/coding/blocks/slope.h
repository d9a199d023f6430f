/* Slope of a node: it is added to the depths of the node's tiles, so that flat ground under slanted light has a single depth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SLOPE_H
#define SLOPE_H

#include <stdint.h>

enum { NODE_TILES = 32, NODE_PX = 256, SLOPE_MAX = 20000 };

/* In 1/256 voxel per tile, to the right and down; each within +-SLOPE_MAX. */
typedef struct node_slope {
    int32_t x, y;
} node_slope;

/* Depth added to tile (x, y), [0, 32): never negative. Must equal formats/vxs_lookup_blocks.h. */
static inline int32_t slope_shift(node_slope s, int32_t x, int32_t y)
{
    return ((s.x < 0 ? s.x * (x - 31) : s.x * x) + (s.y < 0 ? s.y * (y - 31) : s.y * y)) >> 8;
}

/* Greatest depth added to any tile. */
static inline int32_t slope_shift_max(node_slope s)
{
    return ((s.x < 0 ? -s.x : s.x) * 31 + (s.y < 0 ? -s.y : s.y) * 31) >> 8;
}

/* Find a slope with which few blocks of 4 x 4 tiles have no common depth for all of their columns.
 * emax, xmin  [32 * 32] rows of tiles: the last enter and the first exit depth of each, [0, 2^19] voxels
 * first       tried first: the slope of the previous node
 * Returns {0, 0} if no slope helps. */
node_slope slope_find(const int32_t *emax, const int32_t *xmin, node_slope first);

#endif
