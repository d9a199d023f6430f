/* State of the walk over a page, and its borders: depths of the texels above the next record (`above`) and on its left (`left`),
 * from which values are predicted. They are relative to the node, and modulo 2^16. They only select odds and predictions, so a
 * wrong depth only costs bytes.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_BORDERS_H
#define VXS_PAGE_BORDERS_H

#include "vxs_page_layout.h"
#include "vxs_page_odds.h"

/* the words being written, the records so far, and the source of the encoder ---------------------------------------------------- */

enum {
    NODE_PX      = 256,
    BLOCK_PX     = 32,
    TILE_PX      = 8,
    NEVER        = 0xffff,            /* a uniform depth: never in shadow */
    PRIVATE_ZERO = 8192,              /* base 0 of a tile with a private palette, as stored in the low bits of its word */
    LISTS        = VXS_PATTERN_KINDS, /* one for each kind of pattern; the list of blocks has the place of the unused kind 1 */
    LIST_CHUNK   = 256,
    LATELY_KEPT  = 64, /* number of patterns of planes used last */
    COLUMNS_KEPT = 64, /* columns, and rows, of squares with a stored border */
    BORDERS_KEPT = 2048,
    PATTERN_SETS = 4096, /* contexts of patterns */
    USED_SETS    = 8192, /* contexts of the entries that a tile uses */
};

struct vxs_page_scratch {
    page_odds odds;
    int16_t   below[COLUMNS_KEPT][NODE_PX], right[COLUMNS_KEPT][NODE_PX]; /* of the last node in a column or row of squares */
    uint32_t  below_of[COLUMNS_KEPT][3], right_of[COLUMNS_KEPT][3];       /* map + 1, x, y; map + 1 = 0: none */
    uint64_t  border[BORDERS_KEPT];                          /* of patterns used lately, indexed by ref modulo BORDERS_KEPT */
    uint32_t  border_ref[BORDERS_KEPT];                      /* ref + 1; 0: none */
    uint16_t  chunk[LISTS][VXS_PAGE_WORDS_MAX / LIST_CHUNK]; /* chunks of the lists of vxs_page_tiles.h */
    uint16_t  listed[VXS_PAGE_WORDS_MAX + LISTS * LIST_CHUNK];
    /* sets of vxs_page_tiles.h: words of tiles, as in lists; entries + 1 */
    _Alignas(16) uint16_t pattern_set[PATTERN_SETS][PATTERN_LANES], used_set[USED_SETS][USED_LANES];
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
    int               fine;             /* whether the page is of VXS_PACKING_FINE */
    uint32_t          last_shift;       /* of a palette */
    int16_t           corner;           /* beside the current block or tile: above[x0 - 1] before the one on its left was drawn */
    int32_t           slope_x, slope_y; /* of the last node */
    sheet   sheet_above[NODE_PX / TILE_PX], sheet_left[NODE_PX / TILE_PX], last_plane, last_private; /* of a block, of a pattern */
    uint8_t known_above[NODE_PX / TILE_PX], known_left[NODE_PX / TILE_PX]; /* kinds of these sheets; NO_SHEET: an old one */
    const uint32_t *source;       /* [word_count] encoder only, like the next two: the page to code */
    uint16_t       *pattern_rank; /* [2^18] by ref: rank in its list, or any number if it is not there */
    uint16_t       *block_rank;   /* [65536] by word */
    /* the last one in each row and column, + 1; 0: none yet */
    uint32_t        block_left[NODE_PX / BLOCK_PX], block_above[NODE_PX / BLOCK_PX];   /* words of blocks */
    uint32_t        private_left[NODE_PX / TILE_PX], private_above[NODE_PX / TILE_PX]; /* patterns of planes, by ref */
    /* patterns of planes used last, ref + 1, most recent first */
    uint32_t        private_lately[LATELY_KEPT], private_lately_count;
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

/* borders ----------------------------------------------------------------------------------------------------------------------- */

/* Whether the depths at p differ. */
PAGE_INLINE uint32_t varied(const int16_t *p, uint32_t count)
{
#ifdef PAGE_SSE2
    __m128i first = _mm_set1_epi16(p[0]), same = _mm_cmpeq_epi16(first, _mm_loadu_si128((const __m128i *)p));
    for (uint32_t n = 8; n < count; n += 8)
        same = _mm_and_si128(same, _mm_cmpeq_epi16(first, _mm_loadu_si128((const __m128i *)(p + n))));
    return _mm_movemask_epi8(same) != 0xffff;
#else
    uint32_t other = 0;
    for (uint32_t n = 1; n < count; n++) other |= (uint32_t)(p[n] != p[0]);
    return other;
#endif
}

/* How often the depth changes along the side of a block. */
PAGE_INLINE uint32_t changes_along(const int16_t *p)
{
    uint32_t count = 0;
#ifdef PAGE_SSE2
    __m128i same = _mm_setzero_si128(); /* in each lane, minus the depths that equal the next one; the last depth counts */
    for (uint32_t n = 0; n < BLOCK_PX; n += 8) {
        __m128i eight = _mm_loadu_si128((const __m128i *)(p + n));
        __m128i next  = n + 8 < BLOCK_PX ? _mm_loadu_si128((const __m128i *)(p + n + 1))
                                         : _mm_insert_epi16(_mm_srli_si128(eight, 2), p[BLOCK_PX - 1], 7);
        same          = _mm_add_epi16(same, _mm_cmpeq_epi16(eight, next));
    }
    same  = _mm_add_epi16(same, _mm_srli_si128(same, 8));
    same  = _mm_add_epi16(same, _mm_srli_si128(same, 4));
    count = BLOCK_PX + (uint32_t)(int16_t)_mm_cvtsi128_si32(_mm_add_epi16(same, _mm_srli_si128(same, 2)));
#else
    for (uint32_t n = 1; n < BLOCK_PX; n++) count += (uint32_t)(p[n] != p[n - 1]);
#endif
    return count;
}

/* How often the depth changes along the sides of a block, above it and on its left: a class, 0..7. */
static uint32_t changes_beside(const walk *w, uint32_t x0, uint32_t y0)
{
    static const uint8_t class[16] = {0, 1, 2, 3, 4, 4, 5, 5, 5, 6, 6, 6, 6, 6, 6, 7};
    uint32_t count                 = changes_along(w->above + 8 + x0) + changes_along(w->left + y0);
    return class[count < 15 ? count : 15];
}

/* A bit for each of 16 depths: whether it equals `depth`. */
PAGE_INLINE uint32_t equal_depths(const int16_t *palette, int16_t depth)
{
#ifdef PAGE_SSE2
    __m128i all = _mm_set1_epi16(depth);
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(_mm_cmpeq_epi16(all, _mm_load_si128((const __m128i *)palette)),
                                                       _mm_cmpeq_epi16(all, _mm_load_si128((const __m128i *)palette + 1))));
#else
    uint32_t equal = 0;
    for (uint32_t n = 0; n < 16; n++) equal |= (uint32_t)(palette[n] == depth) << n;
    return equal;
#endif
}

/* A bit for each palette entry: whether one of eight texels has its depth.   texels  aligned to 16 bytes */
PAGE_CALL uint32_t depths_met(const int16_t *palette, uint32_t entries, const int16_t *texels)
{
    uint32_t met = 0;
#ifdef PAGE_SSE2
    __m128i low = _mm_load_si128((const __m128i *)palette), high = _mm_load_si128((const __m128i *)palette + 1),
            all = _mm_load_si128((const __m128i *)texels), a = _mm_setzero_si128(), b = a;
    for (uint32_t n = 0; n < 2; n++) {
        __m128i four = n ? _mm_unpackhi_epi16(all, all) : _mm_unpacklo_epi16(all, all), texel[4];
        texel[0] = _mm_shuffle_epi32(four, 0x00), texel[1] = _mm_shuffle_epi32(four, 0x55);
        texel[2] = _mm_shuffle_epi32(four, 0xaa), texel[3] = _mm_shuffle_epi32(four, 0xff);
        for (uint32_t k = 0; k < 4; k++) {
            a = _mm_or_si128(a, _mm_cmpeq_epi16(low, texel[k]));
            b = _mm_or_si128(b, _mm_cmpeq_epi16(high, texel[k]));
        }
    }
    met = (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(a, b)) & ((1u << entries) - 1);
#else
    for (uint32_t n = 0; n < entries; n++) {
        uint32_t equal = 0;
        for (uint32_t k = 0; k < 8; k++) equal |= (uint32_t)(texels[k] == palette[n]);
        met |= equal << n;
    }
#endif
    return met;
}

/* Context 0..4 from the neighbours on the left and above, each of which may be `none`. There is no branch, because it would
 * be unpredictable. */
PAGE_INLINE uint32_t likeness(uint32_t left, uint32_t above, uint32_t none)
{
    static const uint8_t alike[8] = {4, 1, 2, 0, 3, 1, 2, 0}; /* bits: left is none, above is none, both are equal */
    return alike[(uint32_t)(left == none) | (uint32_t)(above == none) << 1 | (uint32_t)(left == above) << 2];
}

/* Which depths are alike on the left of a square, above it, at its corner, and behind those above it: 0..11. */
PAGE_INLINE uint32_t corner_context(const walk *w, uint32_t x0, uint32_t y0, uint32_t side_px)
{
    int16_t left = w->left[y0], above = w->above[8 + x0], behind = w->above[8 + x0 + side_px];
    if (!w->fine) return 0;
    return (uint32_t)(w->corner == left) + 2 * (uint32_t)(w->corner == above) + (behind == above ? 0 : behind == left ? 4 : 8);
}

/* The least of `depth ^ flip` for the depths on the left of a square and above it; INT16_MAX: none. NEVER, which is -1, is
 * ignored.   side_px  multiple of 8 */
PAGE_INLINE int32_t least_of_border(const walk *w, uint32_t x0, uint32_t y0, uint32_t side_px, int16_t flip)
{
#ifdef PAGE_SSE2
    __m128i least = _mm_set1_epi16(INT16_MAX), never = _mm_set1_epi16(-1);
    __m128i flipped_never = _mm_set1_epi16((int16_t)(INT16_MAX ^ ~flip)); /* turns NEVER ^ flip into INT16_MAX */
    for (uint32_t k = 0; k < side_px; k += 8) {
        __m128i l    = _mm_loadu_si128((const __m128i *)(w->left + y0 + k)),
                a    = _mm_loadu_si128((const __m128i *)(w->above + 8 + x0 + k));
        __m128i no_l = _mm_and_si128(_mm_cmpeq_epi16(l, never), flipped_never),
                no_a = _mm_and_si128(_mm_cmpeq_epi16(a, never), flipped_never);
        l            = _mm_xor_si128(_mm_xor_si128(l, _mm_set1_epi16(flip)), no_l);
        a            = _mm_xor_si128(_mm_xor_si128(a, _mm_set1_epi16(flip)), no_a);
        least        = _mm_min_epi16(least, _mm_min_epi16(l, a));
    }
    least = _mm_min_epi16(least, _mm_srli_si128(least, 8));
    least = _mm_min_epi16(least, _mm_srli_si128(least, 4));
    return (int16_t)_mm_cvtsi128_si32(_mm_min_epi16(least, _mm_srli_si128(least, 2)));
#else
    int32_t least = INT16_MAX;
    for (uint32_t k = 0; k < side_px; k++) {
        int32_t l = w->left[y0 + k], a = w->above[8 + x0 + k];
        if ((l ^ flip) < least && l != (int16_t)NEVER) least = l ^ flip;
        if ((a ^ flip) < least && a != (int16_t)NEVER) least = a ^ flip;
    }
    return least;
#endif
}

/* The least depth on the left of a square and above it; INT16_MAX: none. */
PAGE_CALL int32_t least_border_depth(const walk *w, uint32_t x0, uint32_t y0, uint32_t side_px)
{
    return least_of_border(w, x0, y0, side_px, 0);
}

/* The greatest of these depths of a block; INT16_MIN: none. */
PAGE_CALL int32_t greatest_border_depth(const walk *w, uint32_t x0, uint32_t y0)
{
    return ~least_of_border(w, x0, y0, BLOCK_PX, -1);
}

/* Mark that there is no plane beside the next squares. */
PAGE_CALL void leave_no_sheet(walk *w, uint32_t x0, uint32_t y0, uint32_t side_px)
{
    memset(w->known_above + x0 / TILE_PX, NO_SHEET, side_px / TILE_PX);
    memset(w->known_left + y0 / TILE_PX, NO_SHEET, side_px / TILE_PX);
}

/* Eight depths at once: they are read as a vector soon, which would wait for single ones. */
PAGE_INLINE void draw_eight(int16_t *to, const int16_t *depth, uint32_t index)
{
#ifdef PAGE_SSE2
    uint64_t four[2];
    for (uint32_t n = 0; n < 2; n++, index >>= 16)
        four[n] = (uint64_t)(uint16_t)depth[index & 15] | (uint64_t)(uint16_t)depth[index >> 4 & 15] << 16 |
                  (uint64_t)(uint16_t)depth[index >> 8 & 15] << 32 | (uint64_t)(uint16_t)depth[index >> 12 & 15] << 48;
    _mm_store_si128((__m128i *)to, _mm_set_epi64x((long long)four[1], (long long)four[0]));
#else
    for (uint32_t n = 0; n < TILE_PX; n++) to[n] = depth[index >> 4 * n & 15];
#endif
}

/* Set the borders after a tile with a pattern.
 * depth  of its pattern, by index */
static void draw_pattern(walk *w, uint64_t border, const int16_t *depth, uint32_t x0, uint32_t y0)
{
    draw_eight(w->above + 8 + x0, depth, (uint32_t)border);
    draw_eight(w->left + y0, depth, (uint32_t)(border >> 32));
    leave_no_sheet(w, x0, y0, TILE_PX);
}

PAGE_CALL void draw_uniform(walk *w, uint32_t x0, uint32_t y0, uint32_t side_px, int16_t depth)
{
#ifdef PAGE_SSE2
    __m128i eight = _mm_set1_epi16(depth);
    for (uint32_t n = 0; n < side_px; n += 8) {
        _mm_store_si128((__m128i *)(w->above + 8 + x0 + n), eight);
        _mm_store_si128((__m128i *)(w->left + y0 + n), eight);
    }
#else
    for (uint32_t n = 0; n < side_px; n++) w->above[8 + x0 + n] = w->left[y0 + n] = depth;
#endif
    leave_no_sheet(w, x0, y0, side_px);
}

/* Depth that the slope of the node adds to a tile, in 1/256 voxel; never negative. */
PAGE_INLINE int32_t slope_sum(int32_t nx, int32_t ny, int32_t tx, int32_t ty)
{
    return (nx < 0 ? nx * (tx - 31) : nx * tx) + (ny < 0 ? ny * (ty - 31) : ny * ty);
}

PAGE_INLINE int32_t slope_shift(int32_t nx, int32_t ny, int32_t tx, int32_t ty)
{
    return slope_sum(nx, ny, tx, ty) >> 8;
}

/* Depths of a side of a node in another node, except NEVER, which stays: each tile's are moved by base + sign * (slope >> 8), and
 * the next tile's slope is `step` more. */
PAGE_INLINE void move_side(int16_t *to, const int16_t *from, int32_t base, int32_t sign, int32_t slope, int32_t step)
{
    for (uint32_t k = 0; k < NODE_PX; k += TILE_PX, slope += step) {
        int16_t by = (int16_t)(base + sign * (slope >> 8));
#ifdef PAGE_SSE2
        __m128i was = _mm_loadu_si128((const __m128i *)(from + k)), never = _mm_cmpeq_epi16(was, _mm_set1_epi16(-1));
        _mm_storeu_si128((__m128i *)(to + k), _mm_add_epi16(was, _mm_andnot_si128(never, _mm_set1_epi16(by))));
#else
        for (uint32_t n = k; n < k + TILE_PX; n++) to[n] = (int16_t)(from[n] == (int16_t)NEVER ? from[n] : from[n] + by);
#endif
    }
}

/* Set the borders of a node: from its neighbours in the page, else the base of the node. */
static void open_borders(walk *w, const vxs_page_node *n, int32_t nx, int32_t ny)
{
    const vxs_page_scratch *s  = w->s;
    const uint32_t         *up = s->below_of[n->x % COLUMNS_KEPT], *side = s->right_of[n->y % COLUMNS_KEPT];
    int                     above = up[0] == n->map + 1 && up[1] == n->x && up[2] + 1 == n->y,
        left                      = side[0] == n->map + 1 && side[1] + 1 == n->x && side[2] == n->y;
    const int16_t *below = s->below[n->x % COLUMNS_KEPT], *right = s->right[n->y % COLUMNS_KEPT];
    const int32_t  slope = slope_sum(nx, ny, 0, 0);
    if (above)
        move_side(w->above + 8, below, -n->base, 1, slope, nx);
    else
        memset(w->above + 8, 0, NODE_PX * sizeof *w->above);
    if (left)
        move_side(w->left, right, -n->base, 1, slope, ny);
    else
        memset(w->left, 0, NODE_PX * sizeof *w->left);
    for (uint32_t k = 0; k < 8; k++) {
        w->above[k]               = w->above[8];
        w->above[8 + NODE_PX + k] = w->above[7 + NODE_PX];
    }
    leave_no_sheet(w, 0, 0, NODE_PX);
}

static void close_borders(walk *w, const vxs_page_node *n, int32_t nx, int32_t ny)
{
    vxs_page_scratch *s  = w->s;
    uint32_t         *up = s->below_of[n->x % COLUMNS_KEPT], *side = s->right_of[n->y % COLUMNS_KEPT];
    up[0] = side[0] = n->map + 1;
    up[1] = side[1] = n->x;
    up[2] = side[2] = n->y;
    move_side(s->below[n->x % COLUMNS_KEPT], w->above + 8, n->base, -1, slope_sum(nx, ny, 0, 31), nx);
    move_side(s->right[n->y % COLUMNS_KEPT], w->left, n->base, -1, slope_sum(nx, ny, 31, 0), ny);
}

#endif
