/* State of the walk over a page: the words being written, the records so far, and the source of the encoder.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_WALK_H
#define VXS_PAGE_WALK_H

#include "vxs_page_layout.h"
#include "vxs_page_odds.h"

enum {
    NODE_PX      = 256,
    BLOCK_PX     = 32,
    TILE_PX      = 8,
    NEVER        = 0xffff,            /* a uniform depth: never in shadow */
    OWN_ZERO     = 8192,              /* base 0 of an own tile, as stored in the low bits of its word */
    LISTS        = VXS_PATTERN_KINDS, /* one for each kind of pattern; the list of blocks has the place of the unused kind 1 */
    LIST_CHUNK   = 256,
    LATELY_KEPT  = 64, /* number of patterns of planes used last */
    COLUMNS_KEPT = 64, /* columns, and rows, of squares with a stored border */
    BORDERS_KEPT = 1024,
};

struct vxs_page_scratch {
    page_odds odds;
    int16_t   below[COLUMNS_KEPT][NODE_PX], right[COLUMNS_KEPT][NODE_PX]; /* of the last node in a column or row of squares */
    uint32_t  below_of[COLUMNS_KEPT][3], right_of[COLUMNS_KEPT][3];       /* map + 1, x, y; map + 1 = 0: none */
    uint64_t  border[BORDERS_KEPT];                          /* of patterns used lately, indexed by ref modulo BORDERS_KEPT */
    uint32_t  border_ref[BORDERS_KEPT];                      /* ref + 1; 0: none */
    uint16_t  chunk[LISTS][VXS_PAGE_WORDS_MAX / LIST_CHUNK]; /* chunks of the lists of vxs_page_lists.h */
    uint16_t  listed[VXS_PAGE_WORDS_MAX + LISTS * LIST_CHUNK];
};

/* Kind of the record that a plane belongs to. */
enum { NO_SHEET, OF_PATTERN, OF_BLOCK };

/* A plane at a tile, in 1/256 voxel: increase of depth per texel across and down, and depth of texel (0, 0) in the node
 * without the slope of the node, modulo 2^32. */
typedef struct sheet {
    int32_t  x, y;
    uint32_t at;
    uint8_t  shift, known; /* known: NO_SHEET.. */
} sheet;

/* State of the walk over a page. */
typedef struct walk {
    coder             c;
    page_odds        *odds;
    vxs_page_scratch *s;
    uint32_t         *words; /* [word_count] being written */
    uint32_t          word_count, node_words;
    uint32_t          word, half; /* where the next record and the next pattern go */
    uint32_t          tile;       /* word of the current tile */
    const vxs_common *common;
    /* entries in each list; chunks in use */
    uint32_t          listed[LISTS], chunks;
    int32_t           slope_x, slope_y;                                                        /* of the last node */
    sheet sheet_above[NODE_PX / TILE_PX], sheet_left[NODE_PX / TILE_PX], last_plane, last_own; /* of a block, of a pattern */
    const uint32_t *source;       /* [word_count] encoder only, like the next two: the page to code */
    uint32_t       *pattern_rank; /* [2^18] by ref: rank in its list, + 1; 0: not in the list yet */
    uint32_t       *block_rank;   /* [65536] by word */
    /* the last one in each row and column, + 1; 0: none yet */
    uint32_t        block_left[NODE_PX / BLOCK_PX], block_above[NODE_PX / BLOCK_PX]; /* words of blocks */
    uint32_t        own_left[NODE_PX / TILE_PX], own_above[NODE_PX / TILE_PX];       /* patterns of planes, by ref */
    /* patterns of planes used last, ref + 1, most recent first */
    uint32_t        own_lately[LATELY_KEPT], own_lately_count;
    _Alignas(16) int16_t above[8 + NODE_PX + 8], left[NODE_PX]; /* [8 + x], [y] */
} walk;

/* Words of the pool that contains a pattern. */
PAGE_INLINE const uint32_t *pool_of(const walk *w, uint32_t ref)
{
    return ref & REF_COMMON ? w->common->words : w->words;
}

/* A word of the source, which is unchecked: 0 beyond its end. The decoder has no source. */
PAGE_INLINE uint32_t source_word(const walk *w, uint32_t word)
{
    return PAGE_ENCODING ? word_or_zero(w->source, w->word_count, word) : 0;
}

PAGE_INLINE uint32_t source_half(const walk *w, uint32_t half)
{
    return source_word(w, half >> 1) >> 16 * (half & 1) & 0xffff;
}

#endif
