/* Depths of texels, for both codings: bounds on the shadow depth of squares of texels, and the depth of each texel of a tile. A
 * lookup compares a voxel's depth with the records of a file; here the depth itself is read. Internal to the runtime; not
 * installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_TILE_DEPTHS_H
#define VXS_TILE_DEPTHS_H

#include "vxs_depths.h"
#include "vxs_file.h"
#include "vxs_query.h"

/* palette blocks: every texel has a depth (formats/vxs.md 13) ------------------------------------------------------------------- */

enum { VXS_CELL_PX = 2048, VXS_SQUARE_PX = 256, VXS_BLOCK_PX = 32, VXS_TILE_PX = 8 };

/* A map of a light's words. */
typedef struct vxs_blocks_map {
    const uint32_t *words;
    uint32_t        map, levels;
} vxs_blocks_map;

typedef vxs_depths_square vxs_depth_square; /* side VXS_CELL_PX to VXS_TILE_PX, or 1 */

/* The last used block of 32 x 32 texels, so that its tiles look it up only once. Zero it first. */
typedef struct vxs_block_cursor {
    uint32_t         block; /* 1 + its number in the map; 0: none */
    int32_t          found; /* 0: its page is missing */
    vxs_blocks_node  node;  /* its k is for depth 0 */
    vxs_blocks_block record;
    int32_t          low, high; /* bounds of all depths of the square */
    int32_t          whole;     /* uniform depth of the whole square; -1: not uniform */
} vxs_block_cursor;

/* Find the largest square around texel (i, j) whose voxels at depth k all have one state; for negative k, whose texels all have
 * one depth. At least one texel.
 * least_px  1, VXS_TILE_PX, VXS_BLOCK_PX or VXS_SQUARE_PX: smaller squares are not searched, and the result may be mixed
 * i, j      a texel of the map */
vxs_depth_square vxs_depth_square_at(vxs_blocks_map map, int32_t i, int32_t j, int32_t k, int32_t least_px);

enum { VXS_TILE_MISSING, VXS_TILE_WHOLE, VXS_TILE_MIXED };

/* Read the depths of tile (tile_x, tile_y), which must be in the map.
 * cursor  zero, or as the last call with this map left it
 * depth   [out] texel (x, y) at [x + 8 y]
 * Returns VXS_TILE_MIXED; VXS_TILE_WHOLE when all texels have depth[0], and only that is written; or VXS_TILE_MISSING when its
 * page is missing, and nothing is written. */
int vxs_tile_depths(vxs_blocks_map map, vxs_block_cursor *cursor, int32_t tile_x, int32_t tile_y, int32_t depth[64]);

/* DAG: columns may be lit again behind the first shadowed voxel, where voxels are don't-care (formats/vxs.md 2) -----------------
 * */

/* Find the first shadowed voxel of texels of tile (tile_x, tile_y).
 * wanted  one bit for each wanted texel; depths of the others are not written
 * depth   [out] texel (x, y) at [x + 8 y]; 2^levels: no shadow */
void vxs_dag_first_shadows(const vxs_baked_light *baked, uint32_t map, uint32_t tile_x, uint32_t tile_y, uint64_t wanted,
                           int32_t depth[64]);

#endif
