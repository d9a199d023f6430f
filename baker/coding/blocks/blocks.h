/* Palette blocks in the baker: nodes of 256 x 256 texels, blocks of 32 x 32, tiles of 8 x 8, patterns.
 *
 * The contract of a column is an interval, so an area of a map needs few different depths. A block has a palette of at most
 * PALETTE_MAX depths. A tile stores which palette entries it uses, and a pattern: which of its texels begin to be in shadow at each
 * entry. Patterns do not contain depths, and the whole map shares them. All depths are relative to the level above, so that equal
 * shapes at different depths are stored once. A node has a slope, which is added to the depths of its tiles first.
 * formats/vxs.md documents the layout for lookups; formats/vxs_lookup_blocks.h reads it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCKS_H
#define BLOCKS_H

#include "baker/base/intern.h"
#include "baker/coding/blocks/block.h"
#include "baker/coding/blocks/own_patterns.h"
#include "baker/coding/blocks/patterns.h"
#include "baker/coding/blocks/plane.h"
#include "baker/coding/blocks/slope.h"
#include "baker/columns/columns.h"

enum {
    NODE_BLOCKS = 64,
    FAR_DEPTH   = 1 << 20 /* behind all maps: a column is never in shadow */
};

/* A square of NODE_PX texels. */
typedef struct block_node {
    uint32_t   map, x, y;  /* index of the light's map; position in squares of NODE_PX */
    uint32_t   emin, xmax; /* bounds of its columns */
    node_slope slope;
    uint64_t   mixed;              /* bit n: block n, by rows, is a block; else it has one depth */
    int32_t    depth[NODE_BLOCKS]; /* base of the block's palette, or its single depth; FAR_DEPTH or more: never in shadow */
    uint32_t   block[NODE_BLOCKS]; /* ids of the mixed ones */
} block_node;

/* A square of a map that has one depth. */
typedef struct uniform_square {
    uint32_t map, level, x, y; /* position in squares of 8 << level texels; at least NODE_PX wide */
    uint32_t depth;            /* [0, 2^18]; the side of the map or more: never in shadow */
} uniform_square;

/* Depth of a square whose columns may all have the same one. If no column is in shadow anywhere, this is the whole depth. */
static inline uint32_t uniform_depth(const column_bounds *b, uint32_t depth_vx)
{
    return b->xmin >= depth_vx ? depth_vx : b->emax;
}

/* The contents of squares of maps. Zero it. */
typedef struct block_set {
    uniform_square *uniform;
    block_node     *nodes;
    size_t          uniform_count, uniform_capacity, node_count, node_capacity;
    intern          blocks; /* packed (block_pack.h) */
    pattern_set     patterns;
    own_set         own;
    plane           recent[PLANES_RECENT]; /* slopes of blocks */
    uint64_t        tile_count;            /* tiles with a pattern */
    uint64_t        squares_fetched;       /* number of fetched squares of columns */
} block_set;

/* Find the id of an equal block, or add the block. Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
vxs_result block_set_find(block_set *s, const block *b, uint32_t *id);

block block_at(const block_set *s, uint32_t id);

vxs_result block_set_add_uniform(block_set *s, const uniform_square *u);
vxs_result block_set_add_node(block_set *s, const block_node *n);

/* Add everything in `from`, which is empty afterwards; equal patterns and blocks become one. */
vxs_result block_set_merge(block_set *s, block_set *from);

void block_set_free(block_set *s);

#endif
