/* The layout of a light's palette blocks as words while it is made: what its parts share. Only for block_layout.c, block_pages.c and
 * block_top.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_LAYOUT_H
#define BLOCK_LAYOUT_H

#include "baker/coding/blocks/block_words.h"
#include "formats/vxs_format.h"
#include "formats/vxs_page.h"

enum {
    HEAD_WORDS  = 8, /* before the table of pages */
    CELL_LEVELS = 15 /* maps of so many levels have cells above the entries of the top */
};

/* The square has one depth: a bit of cells and entries of the top, and the depth in the others. */
#define ENTRY_UNIFORM 0x80000000u

/* The depth of what is never in shadow. */
#define NEVER UINT32_MAX

/* A node without its place: nodes of equal shapes are one. */
typedef struct node_shape {
    node_slope slope;
    uint64_t   mixed;
    uint32_t   depth[NODE_BLOCKS]; /* of the base on; NEVER */
    uint32_t   block[NODE_BLOCKS];
} node_shape;

/* A node of the set as it is laid out. */
typedef struct node_place {
    uint32_t node, shape, base; /* the base is in steps of the map's depth */
    uint32_t page, word;
} node_place;

/* Where a thing is in the page in work: what has another stamp is not there yet. */
typedef struct in_page {
    uint32_t stamp, at;
} in_page;

/* The pattern of a tile, as it is written. */
typedef struct tile_code {
    int      own;
    uint32_t code;
} tile_code;

/* What is in the page in work. */
typedef struct page_scratch {
    in_page  *shape_at, *block_at, *code_at[2];
    uint32_t  stamp;
    uint32_t  fresh_count; /* patterns that the last node is the first to use */
    tile_code fresh[NODE_BLOCKS * BLOCK_TILES];
} page_scratch;

/* Where a page ends. */
typedef struct page_end {
    uint32_t node, word; /* the first node that is not in it; words of all pages up to here */
} page_end;

typedef struct layout {
    const block_set *set;
    uint32_t         threads, levels, map_count, never, base_shift;
    intern           shapes, codes[2]; /* patterns as halves: shared ones, own ones */
    uint32_t        *code_of[2];       /* by id of a pattern */
    node_place      *nodes;            /* [node_count] in z order, map by map */
    uint16_t        *block_words;      /* [blocks] that a block takes, without its patterns */
    page_end        *page_end;         /* [page_count] */
    size_t           page_count, page_capacity;
    page_scratch     scratch;   /* of the thread that cuts */
    uint32_t        *common[2]; /* [code] 1 + the half of the common pool where it starts; 0: it is not there */
    uint32_t         common_halves;
    uint8_t         *common_kinds; /* [common_count] of patterns as they lie in the common pool */
    size_t           common_count, common_capacity;
    uint32_t        *top; /* all maps' tops and cells */
    size_t           top_count, top_capacity;
    uint32_t         top_start[VXS_CUBE_FACES];
    block_words     *out;
} layout;

/* Codes are kept with their length and their kind before them. */
static inline const uint16_t *code_halves(const layout *l, int own, uint32_t code, uint32_t *count)
{
    const uint16_t *halves = intern_at(&l->codes[own], code);
    *count                 = halves[0] & 0xff;
    return halves + 1;
}

/* The word where a page begins, from the first one on; of the page behind the last one: where that ends. */
static inline uint32_t page_place(const layout *l, size_t page)
{
    return page ? l->page_end[page - 1].word : 0;
}

static inline const node_shape *shape_of(const layout *l, const node_place *n)
{
    return intern_at(&l->shapes, n->shape);
}

/* Cut the nodes into pages, no more than it takes and alike in size, and place them; choose the patterns that are kept once for all of them. */
vxs_result layout_cut_pages(layout *l);

/* Write all pages, one behind the other, on all threads; `to` has zeros. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result layout_write_pages(layout *l, uint32_t *to);

/* Write the patterns that are kept once; `to` has zeros. */
void layout_write_common(const layout *l, uint32_t *to);

/* The tops of all maps, after nodes have their places: cells count from the first word of all tops. */
vxs_result layout_build_top(layout *l);

#endif
