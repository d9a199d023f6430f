/* Palette blocks in the baker: nodes of 256 x 256 texels, blocks of 32 x 32, tiles of 8 x 8, patterns; their build from columns,
 * and the words that lookups read.
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
#include "baker/coding/blocks/patterns.h"
#include "baker/coding/blocks/plane.h"
#include "baker/coding/blocks/private_patterns.h"
#include "baker/columns/columns.h"

enum { BLOCK_TILES = 16 };

typedef enum tile_kind { TILE_UNIFORM, TILE_PATTERN, TILE_PRIVATE, TILE_PLANE, TILE_KINDS } tile_kind;

/* Unused fields are 0, so that equal tiles have equal fields. */
typedef struct block_tile {
    uint16_t kind;
    uint16_t palette; /* uniform: the entry; pattern: bit n: entry n is used */
    uint32_t pattern; /* id of a pattern, or of a private-palette pattern */
    int32_t  base;    /* private palette: base of its depths, relative to the block's */
} block_tile;

static inline int tile_has_pattern(const block_tile *t)
{
    return t->kind == TILE_PATTERN || t->kind == TILE_PRIVATE;
}

/* A palette block during the build. */
typedef struct block {
    uint32_t   depths;             /* [1, PALETTE_MAX] entries of the palette */
    int32_t    depth[PALETTE_MAX]; /* [depths] ascending from 0 */
    plane      plane;              /* for the tiles on it, relative to the block's base, without the node's slope */
    block_tile tile[BLOCK_TILES];  /* rows */
} block;

/* Packed blocks in a set, a fifth of their size. They are as in a page (formats/vxs.md 13.2), except for names of patterns and for
 * bases, which change when sets are merged. Equal blocks have equal bytes. This form is never written to the asset.
 *
 *     head       which tiles have which fields
 *     patterns   of tiles that have one, 4 bytes each
 *     bases      of private palettes, 4 bytes each
 *     plane      if there is one
 *     used       palette entries of the other tiles with a pattern, 2 bytes each
 *     tail       deltas of depths, the entries of fresh tiles; padded to words */

enum { BLOCK_PACKED_MAX = sizeof(block) };

/* Bit n of a mask is tile n. */
typedef struct block_head {
    uint16_t mixed, own, planar; /* tiles with a pattern; those with a private palette; tiles on the plane */
    uint16_t fresh;              /* tiles of a single depth whose entry is not that of the one before */
    uint8_t  depths, has_plane, shift, width;
    uint8_t  mixed_count, own_count; /* number of tiles in these masks */
    uint8_t  tail_words;
    uint8_t  padding; /* 0: packed blocks are compared by bytes */
} block_head;
_Static_assert(sizeof(block_head) == 16, "all bytes of block_head are fields");

/* Returns the number of bytes, padded with zeros to a multiple of 8. */
size_t block_pack(const block *b, uint8_t bytes[BLOCK_PACKED_MAX]);

/* Where the parts of a packed block are. */
typedef struct block_parts {
    block_head     head;
    const uint8_t *pattern, *base, *plane, *used, *tail;
} block_parts;

block_parts block_parts_of(const uint8_t *bytes);

void block_unpack(block *b, const uint8_t *bytes);

/* Renumber patterns: private-palette ones become privates[was], others shared[was]; private_base[was] is added to the bases of
 * private-palette ones; NULL: nothing is added. */
void block_renumber(uint8_t *bytes, const uint32_t *shared, const uint32_t *privates, const int32_t *private_base);

enum {
    NODE_BLOCKS = 64,
    FINE_LEVELS = 15,     /* maps of this many levels or more have pages of VXS_PACKING_FINE */
    FAR_DEPTH   = 1 << 20 /* behind all maps: a column is never in shadow */
};

/* A square of NODE_PX texels, while it is built. */
typedef struct block_node {
    uint32_t   map, x, y;  /* index of the light's map; position in squares of NODE_PX */
    uint32_t   emin, xmax; /* bounds of its columns */
    node_slope slope;
    uint64_t   mixed;              /* bit n: block n, by rows, is a block; else it has one depth */
    int32_t    depth[NODE_BLOCKS]; /* base of the block's palette, or its single depth; FAR_DEPTH or more: never in shadow */
    uint32_t   block[NODE_BLOCKS]; /* ids of the mixed ones */
} block_node;

/* A node in a set. Its parts lie one behind the other: ids of the mixed blocks, their depths, and the depths of fresh blocks. */
typedef struct packed_node {
    uint32_t   map, x, y, emin, xmax;
    uint16_t   mixed_count, fresh_count;
    node_slope slope;
    uint64_t   mixed, fresh; /* fresh: blocks of one depth that is not that of the one before */
    size_t     first;        /* of its parts, in those of the set */
} packed_node;

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
    packed_node    *nodes;
    uint32_t       *parts; /* of nodes */
    size_t          uniform_count, uniform_capacity, node_count, node_capacity, part_count, part_capacity;
    intern          blocks; /* packed */
    pattern_set     patterns;
    private_set     privates;
    plane           recent[PLANES_RECENT]; /* slopes of blocks */
    plane           recent_nodes[PLANES_RECENT];
    uint64_t        tile_count;      /* tiles with a pattern */
    uint64_t        squares_fetched; /* number of fetched squares of columns */
    int             fast;            /* [in] whether pages will be of VXS_PACKING_FAST */
} block_set;

/* Find the id of an equal block, or add the block. Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
vxs_result block_set_find(block_set *s, const block *b, uint32_t *id);

block block_at(const block_set *s, uint32_t id);

vxs_result block_set_add_uniform(block_set *s, const uniform_square *u);
vxs_result block_set_add_node(block_set *s, const block_node *n);

/* Ids of the mixed blocks of a node, [mixed_count]; behind them its depths. */
static inline uint32_t *node_parts(const block_set *s, const packed_node *n)
{
    return s->parts + n->first;
}

/* Add everything in `from`, which is empty afterwards; equal patterns and blocks become one. */
vxs_result block_set_merge(block_set *s, block_set *from);

void block_set_free(block_set *s);

/* Add the node (x, y), counted in squares of NODE_PX from the corner of fetched columns. A smaller map is added as a whole.
 * map  index of the light's map. Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the columns return. */
vxs_result block_build_node(block_set *s, const column_square *columns, uint32_t map, uint32_t x, uint32_t y);

/* Side of the squares that are built at once, each with its own patterns, before they are merged in z order. The source must be
 * able to fetch squares of this side. */
uint32_t block_square_side(uint32_t map_side_px);

/* Add map `map` of a light, from its open columns. Bytes do not depend on the number of threads or the size of fetched squares.
 * ctx  threads; STAGE_MASKS is timed here, and a step of progress is done for each square of fetch_px
 * Returns the same, or VXS_E_ARGUMENT if fetch_px is less than block_square_side. */
vxs_result block_build_map(block_set *s, uint32_t map, const column_map *columns, bake_context *ctx);

/* Contents of a light's words. */
typedef struct block_counts {
    uint32_t pages, nodes, blocks, tiles, private_tiles, patterns, private_patterns; /* equal ones in a page are counted once */
    uint32_t top_words, common_words, node_words, block_words, pattern_words;        /* their sizes; patterns in pages only */
} block_counts;

/* The words that lookups read: the top, common patterns, and pages (formats/vxs.md). */
typedef struct block_words {
    void        *memory; /* with the words */
    uint32_t    *words;  /* [count + VXS_BLOCKS_SPARE_WORDS] the spare words are 0 */
    uint32_t     count;
    uint8_t     *common_kinds; /* [common_count] patterns in the order of the common pool: number of depths; 0: private palette */
    uint32_t     common_count, common_halves;
    block_counts counts;
} block_words;

/* Lay out the maps of a light: map_count maps of 2^levels texels a side. The set must have all squares of them.
 * out      [out] zeroed on failure; released with block_words_free
 * s        is used up: afterwards only its counts of nodes and tiles are valid
 * threads  that share the work; words do not depend on it
 * Returns VXS_OK, VXS_E_MEMORY; VXS_E_REFERENCES for more than 32767 pages or 2^32 - 1 words. */
vxs_result block_words_lay_out(block_words *out, block_set *s, uint32_t levels, uint32_t map_count, uint32_t threads);

/* Accepts a zeroed object. */
void block_words_free(block_words *w);

#endif
