/* A node of palette blocks while it is built: its tiles, the block at hand, and the depths that are chosen.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_BUILD_H
#define BLOCK_BUILD_H

#include "baker/coding/blocks/blocks.h"
#include "baker/coding/blocks/stabbing_set.h"

enum {
    PRIVATE_FROM    = 10, /* a tile that needs this many depths gets a private palette */
    NODE_TILE_COUNT = NODE_TILES * NODE_TILES,
};

/* A tile of the current block that is not uniform, with the slope added. */
typedef struct tile_in {
    tile_ranges    ranges;            /* of texels, in the order of patterns.h */
    int16_t        low[64], high[64]; /* the same as codes of the block's depth axis */
    int32_t        shift;             /* depth that the slope added */
    int            depths;            /* number of depths that it needs, up to PRIVATE_FROM; 0: not counted */
    private_planes plane;             /* a plane or two through this tile alone */
} tile_in;

/* Depths of a block; count 0: they are not chosen yet. */
typedef struct block_depths {
    uint32_t count;
    int32_t  depth[PALETTE_MAX];
} block_depths;

/* Range of single depths that suit a whole run of squares. */
typedef struct run_range {
    int32_t low, high;
} run_range;

typedef struct node_builder {
    block_set           *set;
    const column_square *columns;
    uint32_t             tile_x, tile_y; /* position of the node, in tiles of the columns */
    block_node           node;
    column_bounds        bounds[NODE_BLOCKS]; /* of the columns of each block */
    run_range            may[NODE_BLOCKS];    /* depths that it may have as its single depth; low > high: it has none */
    int32_t      emax[NODE_TILE_COUNT], xmin[NODE_TILE_COUNT]; /* of tiles of mixed blocks; with the slope after add_slope */
    block_depths chosen[NODE_BLOCKS];
    int          fine; /* whether pages will be of VXS_PACKING_FINE */

    /* the current block */
    uint32_t   number;
    uint32_t   of_kind[TILE_KINDS];                            /* bits of its tiles of each kind */
    int32_t    tile_emax[BLOCK_TILES], tile_xmin[BLOCK_TILES]; /* over all texels of a tile, with the slope added */
    int16_t    tile_low[BLOCK_TILES], tile_high[BLOCK_TILES];  /* the same as codes */
    tile_in    tile[BLOCK_TILES];
    depth_axis axis;
} node_builder;

/* Add a square to the run if a common depth is left. */
static inline int run_takes(run_range *run, int32_t low, int32_t high)
{
    low  = max_i32(low, run->low);
    high = min_i32(high, run->high);
    if (low > high) return 0;
    *run = (run_range){low, high};
    return 1;
}

/* Fetch the columns of tile (tile_x, tile_y) of the node as tile n of the block, and add the slope. */
vxs_result block_fetch_tile(node_builder *b, uint32_t n, uint32_t tile_x, uint32_t tile_y);

/* Prepare ranges of tile n for planes, relative to depth `from`. Returns 0 if they are too far from it. */
int tile_ranges_from(plane_ranges *to, const node_builder *b, uint32_t n, int32_t from);

/* Make all blocks of a node whose blocks are mixed, if one plane passes through all of it.   on  [out] whether there is one */
vxs_result node_on_plane(node_builder *b, int *on);

/* Build block b->number of the node, which has no single depth.
 * id    [out] its number in the set
 * base  [out] the first depth of its palette
 * Returns VXS_OK, VXS_E_MEMORY or what the columns return. */
vxs_result block_build(node_builder *b, uint32_t *id, int32_t *base);

#endif
