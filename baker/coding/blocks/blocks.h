/* Palette blocks as the baker holds them: nodes of 256 x 256 texels, blocks of 32 x 32, tiles of 8 x 8, patterns.
 *
 * A column's contract is an interval, so that an area of a map needs few different depths. A block has a palette of at most PALETTE_MAX;
 * a tile says which entries it uses, and which of its texels begin to be in shadow at each: a pattern without depths, shared by the map.
 * All depths are relative to what is above, so that equal shapes at different depths are one; a node has a slope, which is added before.
 * How this is laid out for lookups is formats/vxs.md; formats/vxs_lookup_blocks.h walks it.
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
    FAR_DEPTH   = 1 << 20 /* where a column may be lit for ever */
};

/* A square of NODE_PX texels. */
typedef struct block_node {
    uint32_t   map, x, y;  /* of the light's maps; in squares, from the corner of the map */
    uint32_t   emin, xmax; /* of its columns */
    node_slope slope;
    uint64_t   mixed;              /* bit n: block n, of rows, is a block; else it has one depth */
    int32_t    depth[NODE_BLOCKS]; /* the base of the block's palette, or the depth: FAR_DEPTH or more is never */
    uint32_t   block[NODE_BLOCKS]; /* of mixed ones */
} block_node;

/* A square of a map that has one depth. */
typedef struct uniform_square {
    uint32_t map, level, x, y; /* in squares of 8 << level texels; a square of NODE_PX at least */
    uint32_t depth;            /* [0, 2^18]: of the map's side, or more: never */
} uniform_square;

/* The depth of a square whose columns may all have the same: parts of what is never in shadow are neither. */
static inline uint32_t uniform_depth(const column_bounds *b, uint32_t depth_vx)
{
    return b->xmin >= depth_vx ? depth_vx : b->emax;
}

/* What squares of maps hold. Zero it. */
typedef struct block_set {
    uniform_square *uniform;
    block_node     *nodes;
    size_t          uniform_count, uniform_capacity, node_count, node_capacity;
    intern          blocks; /* packed (block_pack.h) */
    pattern_set     patterns;
    own_set         own;
    plane           recent[PLANES_RECENT]; /* slopes of blocks */
    uint64_t        tile_count;            /* tiles with a pattern */
    uint64_t        squares_fetched;       /* of columns */
} block_set;

/* The id of a block: of an equal one, or a new one. Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
vxs_result block_set_find(block_set *s, const block *b, uint32_t *id);

block block_at(const block_set *s, uint32_t id);

vxs_result block_set_add_uniform(block_set *s, const uniform_square *u);
vxs_result block_set_add_node(block_set *s, const block_node *n);

/* Add all that is in `from`, which is used up; patterns and blocks that both have become one. */
vxs_result block_set_merge(block_set *s, block_set *from);

void block_set_free(block_set *s);

#endif
