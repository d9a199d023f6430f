/* State shared by the layout of a light's palette blocks as words. Only for block_layout.c, block_pages.c and block_words.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_LAYOUT_H
#define BLOCK_LAYOUT_H

#include <stddef.h>
#include <string.h>

#include "baker/coding/blocks/blocks.h"
#include "formats/vxs_format.h"
#include "formats/vxs_page.h"

enum {
    HEAD_WORDS  = 8,    /* words before the table of pages */
    FAR_BASE    = 8192, /* bases of private palettes from here on have words of their own */
    CELL_LEVELS = 15    /* maps of this many levels or more have cells above the entries of the top */
};

/* Bit of a cell or an entry of the top: the other bits are the one depth of its square. */
#define ENTRY_UNIFORM 0x80000000u

/* Depth of squares that are never in shadow. */
#define NEVER UINT32_MAX

/* A node without its position: nodes of equal shape are written once in a page. Parts lie as those of packed_node; depths are
 * relative to the base, or NEVER. */
typedef struct node_shape {
    node_slope slope;
    uint64_t   mixed, fresh;
    uint32_t   mixed_count, fresh_count;
    uint32_t   parts[2 * NODE_BLOCKS];
} node_shape;

/* Position of a node of the set in the layout. */
typedef struct node_place {
    uint32_t node, shape, base; /* shape: index of the first place with an equal shape; base: in steps of the map's depth */
    uint32_t words;             /* size of its record */
    uint32_t page, word;
    uint32_t last; /* of the first place of a shape, while pages are cut: the last place of this shape; NEVER: none yet */
} node_place;

/* End of a page. */
typedef struct page_end {
    uint32_t node, word; /* first node behind it; words of all pages up to here */
    uint32_t node_words; /* of the page: where its patterns begin */
} page_end;

typedef struct layout {
    block_set   *set;
    uint32_t     threads, levels, map_count, never, base_shift;
    intern       codes[2];     /* patterns as halves: [0] shared, [1] private palette */
    uint8_t     *code_size[2]; /* [code] number of halves */
    uint32_t    *code_of[2];   /* [0], [1]: by pattern id */
    node_place  *nodes;        /* [node_count + 1] in z order, map by map */
    uint16_t    *block_words;  /* [blocks] words of a block without its patterns */
    page_end    *page_end;     /* [page_count] */
    size_t       page_count, page_capacity;
    uint64_t     share;     /* words that a page is to have */
    uint32_t    *common[2]; /* [code] 1 + position of its half in the common pool; 0: not there */
    uint32_t     common_halves;
    uint8_t     *common_kinds; /* [common_count] kinds of patterns, in the order of the common pool */
    size_t       common_count, common_capacity;
    uint32_t    *top; /* tops and cells of all maps */
    size_t       top_count, top_capacity;
    uint32_t     top_start[VXS_CUBE_FACES];
    block_words *out;
} layout;

/* The halves of a code. They are stored behind their length and kind. */
static inline const uint16_t *code_halves(const layout *l, int is_private, uint32_t code)
{
    return (const uint16_t *)intern_at(&l->codes[is_private], code) + 1;
}

/* First word of a page, counted from the first page; for the index behind the last page: the end. */
static inline uint32_t page_place(const layout *l, size_t page)
{
    return page ? l->page_end[page - 1].word : 0;
}

/* Bytes of a shape that are used: equal shapes have equal ones. */
static inline size_t shape_bytes(const node_shape *s)
{
    return offsetof(node_shape, parts) + (2 * s->mixed_count + s->fresh_count) * sizeof *s->parts;
}

/* Depths that are never in shadow, with any slope, are NEVER: a block of one depth may no longer be fresh. */
static inline void shape_of(node_shape *shape, const layout *l, const node_place *place)
{
    const packed_node *n     = &l->set->nodes[place->node];
    const uint32_t     never = l->never + (uint32_t)slope_shift_max(n->slope), from = place->base << l->base_shift;
    const uint32_t    *parts = node_parts(l->set, n), mixed_count = n->mixed_count;
    uint32_t          *to = shape->parts + 2 * mixed_count, *fresh = to;
    shape->slope       = n->slope;
    shape->mixed       = n->mixed;
    shape->mixed_count = mixed_count;
    shape->fresh       = 0;
    memcpy(shape->parts, parts, mixed_count * sizeof *parts);
    for (uint32_t k = mixed_count; k < 2 * mixed_count; k++) shape->parts[k] = parts[k] - from;
    parts += 2 * mixed_count;
    for (uint64_t rest = n->fresh; rest; rest &= rest - 1, parts++) {
        const uint32_t depth = *parts >= never ? NEVER : *parts - from;
        if (to > fresh && to[-1] == depth) continue;
        *to++ = depth;
        shape->fresh |= rest & -rest;
    }
    shape->fresh_count = (uint32_t)(to - fresh);
}

/* Number of depths of a node's record. */
static inline uint32_t shape_depths(const node_shape *s)
{
    return s->mixed_count + s->fresh_count;
}

static inline int shape_is_wide(const node_shape *s)
{
    int wide = 0;
    for (const uint32_t *d = s->parts + s->mixed_count, *end = d + shape_depths(s); d < end; d++)
        wide |= *d != NEVER && *d > 0xfffe;
    return wide;
}

/* Whether a base of a private palette does not fit into the word of its tile. */
static inline int block_is_far(const block_parts *b)
{
    int far = 0;
    for (uint32_t n = 0; n < b->head.own_count; n++) {
        int32_t base;
        memcpy(&base, b->base + 4 * n, sizeof base);
        far |= base < -FAR_BASE || base >= FAR_BASE;
    }
    return far;
}

/* Blocks are scattered in memory: ask for those of a node early. */
static inline void layout_prefetch(const layout *l, const node_place *n)
{
    const packed_node *node = &l->set->nodes[n->node];
    const uint32_t    *ids  = node_parts(l->set, node);
    for (uint32_t k = 0; k < node->mixed_count; k++) __builtin_prefetch(intern_at(&l->set->blocks, ids[k]));
}

/* Words of a node's record. */
uint32_t layout_node_words(const node_shape *s);

/* Measure the blocks, and give the patterns of their tiles the numbers of their codes. */
vxs_result layout_measure_blocks(layout *l);

/* Find how many words each page of as few as possible has, and choose the common patterns. The pages are not the final ones, but their
 * words are about as many. */
vxs_result layout_share_pages(layout *l);

/* Cut the nodes into pages of about equal size, and place them.
 * ended  called after each page, whose nodes and end are final. Until then page_count is that of the pages before, and page_end does
 *        not move */
vxs_result layout_cut_pages(layout *l, void (*ended)(void *user, size_t page_count), void *user);

/* Cut the pages, and write them while the next ones are cut, on all threads.
 * before  words of space before the first page
 * memory  [out] zeroed but for the pages, with VXS_BLOCKS_SPARE_WORDS behind the last; released with free
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
vxs_result layout_write_pages(layout *l, size_t before, uint32_t **memory);

/* Write the common patterns; `to` must be zeroed. */
void layout_write_common(const layout *l, uint32_t *to);

#endif
