/* A page while it is walked: the words being laid out, what was met so far, and the source that the encoder reads.
 * Internal to vxs_page_*.c, which say PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_WALK_H
#define VXS_PAGE_WALK_H

#include "vxs_page_layout.h"
#include "vxs_page_odds.h"

enum {
    NODE_PX      = 256,
    BLOCK_PX     = 32,
    TILE_PX      = 8,
    NEVER        = 0xffff,            /* a uniform depth that is never reached */
    OWN_ZERO     = 8192,              /* base of an own tile 0, in the low bits of its word */
    LISTS        = VXS_PATTERN_KINDS, /* one of each kind of pattern; that of blocks has the place of the kind that is none */
    LIST_CHUNK   = 256,
    LATELY_KEPT  = 64, /* patterns of planes that were used last */
    COLUMNS_KEPT = 64, /* columns of squares whose last borders are kept */
    BORDERS_KEPT = 1024,
};

struct vxs_page_scratch {
    page_odds odds;
    int16_t   below[COLUMNS_KEPT][NODE_PX], right[COLUMNS_KEPT][NODE_PX]; /* of the last node in a column or row of squares */
    uint32_t  below_of[COLUMNS_KEPT][3], right_of[COLUMNS_KEPT][3];       /* map + 1, x, y; map + 1 = 0: none */
    uint64_t  border[BORDERS_KEPT];                          /* of patterns that were met lately, by ref modulo their number */
    uint32_t  border_ref[BORDERS_KEPT];                      /* whose, + 1; 0: nobody's */
    uint16_t  chunk[LISTS][VXS_PAGE_WORDS_MAX / LIST_CHUNK]; /* where the lists of vxs_page_lists.h lie */
    uint16_t  listed[VXS_PAGE_WORDS_MAX + LISTS * LIST_CHUNK];
};

/* Whose plane it is. */
enum { NO_SHEET, OF_PATTERN, OF_BLOCK };

/* A plane where a tile lies on it, in 1/256 voxel: how much deeper it is a texel on, and a texel down; how deep its texel (0, 0) is in the
 * node without its slope, modulo 2^32. */
typedef struct sheet {
    int32_t  x, y;
    uint32_t at;
    uint8_t  shift, known; /* known: NO_SHEET.. */
} sheet;

/* A page while it is walked. */
typedef struct walk {
    coder             c;
    page_odds        *odds;
    vxs_page_scratch *s;
    uint32_t         *words; /* [word_count] being laid out */
    uint32_t          word_count, node_words;
    uint32_t          word, half; /* where the next record, and the next pattern go */
    uint32_t          tile;       /* the word of the tile at hand */
    const vxs_common *common;
    uint32_t          listed[LISTS], chunks;                                                   /* how many are in the lists */
    int32_t           slope_x, slope_y;                                                        /* of the last node */
    sheet sheet_above[NODE_PX / TILE_PX], sheet_left[NODE_PX / TILE_PX], last_plane, last_own; /* of a block, of a pattern */
    const uint32_t *source;       /* [word_count] of the encoder, like the next two: what is coded */
    uint32_t       *pattern_rank; /* [2^18] by ref: where in its list, + 1; 0: not yet met */
    uint32_t       *block_rank;   /* [65536] by word */
    /* what was last in a row and in a column, + 1; 0: nothing yet */
    uint32_t        block_left[NODE_PX / BLOCK_PX], block_above[NODE_PX / BLOCK_PX]; /* words of blocks */
    uint32_t        own_left[NODE_PX / TILE_PX], own_above[NODE_PX / TILE_PX];       /* patterns of planes, by ref */
    uint32_t        own_lately[LATELY_KEPT], own_lately_count;                       /* of these, by ref, the last one first */
    _Alignas(16) int16_t above[8 + NODE_PX + 8], left[NODE_PX];                      /* [8 + x], [y] */
} walk;

/* Words of the pool that a pattern lies in. */
PAGE_INLINE const uint32_t *pool_of(const walk *w, uint32_t ref)
{
    return ref & REF_COMMON ? w->common->words : w->words;
}

/* Of the source, which may be anything: beyond its words are zeros. The decoder has none. */
PAGE_INLINE uint32_t source_word(const walk *w, uint32_t word)
{
    return PAGE_ENCODING ? word_or_zero(w->source, w->word_count, word) : 0;
}

PAGE_INLINE uint32_t source_half(const walk *w, uint32_t half)
{
    return source_word(w, half >> 1) >> 16 * (half & 1) & 0xffff;
}

#endif
