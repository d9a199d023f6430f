/* Depths in palette blocks: between which depths shadow begins, of squares of texels as great as the structure tells at once; and of each
 * texel of a tile. A lookup asks whether a voxel is in shadow, from the top down, by its depth; here the same records (vxs_lookup_blocks.h)
 * are asked for the depth itself. Every texel has one (formats/vxs.md 13). Internal to the runtime; not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_BLOCK_DEPTHS_H
#define VXS_BLOCK_DEPTHS_H

#include "vxs_depths.h"

enum { VXS_CELL_PX = 2048, VXS_SQUARE_PX = 256, VXS_BLOCK_PX = 32, VXS_TILE_PX = 8 };

/* Where a map's words are. */
typedef struct vxs_blocks_map {
    const uint32_t *words;
    uint32_t        map, levels;
} vxs_blocks_map;

typedef vxs_depths_square vxs_depth_square; /* of side VXS_CELL_PX to VXS_TILE_PX, or 1 */

/* A block of 32 x 32 texels, kept from one tile to the next, so that those of one block find it once; zero it first. */
typedef struct vxs_block_cursor {
    uint32_t         block; /* 1 + its number in the map */
    int32_t          found; /* 0: of its square nothing is kept */
    vxs_blocks_node  node;  /* its k is that of depth 0 */
    vxs_blocks_block record;
    int32_t          low, high; /* of all depths of the square */
    int32_t          whole;     /* -1, or the depth of all of the square */
} vxs_block_cursor;

/* The greatest square about texel (i, j) of which all voxels at depth k are alike. k below 0: the greatest of which all texels have one
 * depth. It is one texel where nothing greater is.
 * least_px  1; or VXS_TILE_PX, VXS_BLOCK_PX, VXS_SQUARE_PX: smaller squares are not looked for, and depths may be mixed in what is found
 * i, j      of the map */
vxs_depth_square vxs_depth_square_at(vxs_blocks_map map, int32_t i, int32_t j, int32_t k, int32_t least_px);

enum { VXS_TILE_MISSING, VXS_TILE_WHOLE, VXS_TILE_MIXED };

/* The depths of tile (tile_x, tile_y) of a map, texel (x, y) at [x + 8 y]; of a map that has it.
 * cursor  zero, or as the last call with this map left it
 * Returns VXS_TILE_MIXED; VXS_TILE_WHOLE when depth[0] is that of all, and the others are not written; or VXS_TILE_MISSING when its page
 * is, and nothing is written. */
int vxs_tile_depths(vxs_blocks_map map, vxs_block_cursor *cursor, int32_t tile_x, int32_t tile_y, int32_t depth[64]);

#endif
