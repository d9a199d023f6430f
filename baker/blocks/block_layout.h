/* The layout of a light's palette blocks as words while it is made: what its parts share. Only for block_layout.c, block_pages.c and
 * block_top.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_LAYOUT_H
#define BLOCK_LAYOUT_H

#include "baker/blocks/block_words.h"
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

typedef struct layout {
    const block_set *set;
    uint32_t         threads, levels, map_count, never, base_shift;
    intern           shapes, codes[2]; /* patterns as halves: shared ones, own ones */
    uint32_t        *code_of[2];       /* by id of a pattern */
    node_place      *nodes;            /* [node_count] in z order, map by map */
    uint32_t        *page_end;         /* [page_count] the first node that is not in it */
    size_t           page_count, page_capacity;
    in_page         *shape_at, *block_at, *code_at[2];
    uint32_t         stamp;
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

static inline const node_shape *shape_of(const layout *l, const node_place *n)
{
    return intern_at(&l->shapes, n->shape);
}

/* Cut the nodes into pages, no more than it takes and alike in size, and choose the patterns that are kept once for all of them. */
vxs_result layout_cut_pages(layout *l);

/* Write all pages, one after the other, and note where nodes are.
 * words   [out] grown with array_reserve; [count]
 * starts  [page_count] [out] where in them each page begins */
vxs_result layout_write_pages(layout *l, uint32_t **words, size_t *count, uint32_t *starts);

/* Write the patterns that are kept once; `to` has zeros. */
void layout_write_common(const layout *l, uint32_t *to);

/* The tops of all maps, after pages have placed their nodes: cells count from the first word of all tops. */
vxs_result layout_build_top(layout *l);

#endif
