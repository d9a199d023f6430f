/* What is coded of a page, and in what order: one text for both ways. Internal to vxs_page_*.c, which say PAGE_ENCODING. Not installed.
 *
 * The walk goes from node to node, block to block, tile to tile, and lays each record out where it belongs in `words`: the decoder
 * makes the page so, and the encoder a second one, which has to come out as the page that it was given. The encoder reads from
 * `source` what it codes; nothing is assumed of it.
 *
 * What is alike is found through depths: `above` holds those of the texels above what comes next, `left` those on its left, both
 * relative to the node and modulo 2^16. They only choose odds and predict, so that a depth that does not fit costs bytes, no more.
 *
 *     node     slope; which blocks are mixed, four a nibble; of the uniform ones depths: the left's, the upper's, the last's, another
 *     block    base, by the least depth about it; one met before, by its place in a list in which what is used moves half the way to
 *              the front, or: its palette; for each row of four tiles which are mixed; of uniform tiles the index: as depths above
 *     tile     which palette entries are used, four a nibble, by whether the borders have them; none at all: depths of its own. Then
 *              the pattern: new, from the common pool, or met before, by its place in the list of its kind
 *     pattern  four texels a nibble: which differ from the texel above; of those, if there are more than two depths, what they are
 *     depths   that are no palette: a nibble each, the difference to left + above - the one between them
 *
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_MODEL_H
#define VXS_PAGE_MODEL_H

#include "vxs_page.h"
#include "vxs_page_coder.h"

enum {
    NODE_PX      = 256,
    BLOCK_PX     = 32,
    TILE_PX      = 8,
    NODE_HALVES  = 11, /* before its lists */
    PALETTE_MAX  = 14,
    DEPTHS_MAX   = 16,            /* of a pattern of its own */
    DEPTH_END    = 1 << 24,       /* no depth or base is as far: sums stay within 32 bits */
    SIGNED_MOST  = (1 << 26) - 1, /* of differences */
    NEVER        = 0xffff,        /* a uniform depth that is never reached */
    REF_COMMON   = 0x20000,
    OWN_ZERO     = 8192, /* base of an own tile 0, in the low bits of its word */
    KIND_OWN     = 0,
    INDEX_HALVES = 17, /* of a pattern as an image of indices */
    LIST_CHUNK   = 256,
    COLUMNS_KEPT = 64, /* columns of squares whose last borders are kept */
};

/* Kinds of a pattern with depths of its own, bits 12..15 of its first half. */
enum { OWN_BYTES, OWN_HALVES, OWN_WORDS, OWN_NIBBLES, OWN_RAW1, OWN_RAW2, OWN_RAW3, OWN_KINDS };

/* odds ------------------------------------------------------------------------------------------------------------------------- */

typedef struct number_odds {
    nibble_odds size, top[15];
} number_odds;

typedef struct signed_odds {
    nibble_odds sign;
    number_odds size;
} signed_odds;

/* Of nibble_odds and nothing else. */
typedef struct page_odds {
    /* nodes */
    nibble_odds node_mixed[64], depth_like[8];
    nibble_odds wide, same_slope, no_slope;
    signed_odds slope, depth;
    number_odds high, fresh_count;
    /* blocks */
    number_odds block;
    signed_odds base;
    nibble_odds entries[4], delta_form[2], delta_shift, delta_width;
    number_odds delta[16][2], delta_wide;
    nibble_odds round[12], own_round[12];
    nibble_odds block_mixed[5][64], index[5][3];
    /* tiles */
    nibble_odds used[4][256]; /* [entries left of four, 0: all] */
    number_odds pattern[VXS_PATTERN_KINDS], common[VXS_PATTERN_KINDS];
    signed_odds own_base;
    /* patterns */
    nibble_odds differs[2][2][128], other[4][5][3], far;
    nibble_odds own_kind, own_shift, own_count, residual[3][6];
    number_odds own_delta, raw_far, raw_base;
} page_odds;

struct vxs_page_scratch {
    page_odds   start, odds;                                                /* of every page; of this one, as they learn */
    int16_t     below[COLUMNS_KEPT][NODE_PX], right[COLUMNS_KEPT][NODE_PX]; /* of the last node in a column or row of squares */
    uint32_t    below_of[COLUMNS_KEPT][3], right_of[COLUMNS_KEPT][3];       /* map + 1, x, y; map + 1 = 0: none */
    uint16_t    chunk[VXS_PATTERN_KINDS][VXS_PAGE_WORDS_MAX / LIST_CHUNK];  /* where the lists of patterns lie */
    vxs_pattern pattern[VXS_PAGE_WORDS_MAX + VXS_PATTERN_KINDS * LIST_CHUNK];
    uint16_t    block[VXS_PAGE_WORDS_MAX / 2]; /* words where blocks start */
};

/* Nibbles whose bits are 1 independently, bit n with odds chance[(states >> n & 1) + 2 * (states >> (n + 4) & 1)] of 256. */
static void start_mask(nibble_odds *odds, uint32_t states, const uint8_t chance[4], uint32_t bits)
{
    uint32_t weight[16];
    for (uint32_t mask = 0; mask < 16; mask++) {
        weight[mask] = 1;
        for (uint32_t n = 0; n < 4; n++) {
            uint32_t one = n < bits ? chance[(states >> n & 1) + 2 * (states >> (n + 4) & 1)] : 0;
            weight[mask] *= mask >> n & 1 ? one : 256 - one;
        }
    }
    nibble_start(odds, weight, 5);
}

/* Which of four texels differ from those above; bits 0..4 of k: texels above differ from those on their left; 5: the texel on the left
 * of the four does from the one above it. */
static void start_differs(nibble_odds *odds, uint32_t k)
{
    uint32_t weight[16];
    for (uint32_t mask = 0; mask < 16; mask++) {
        uint32_t left = k >> 5 & 1;
        weight[mask]  = 1;
        for (uint32_t n = 0; n < 4; n++) {
            uint32_t one = left ? 128 : k >> n & 3 ? 77 : 10;
            left         = mask >> n & 1;
            weight[mask] *= left ? one : 256 - one;
        }
    }
    nibble_start(odds, weight, 5);
}

static void start_odds(page_odds *odds)
{
    static const uint8_t used[4] = {38, 64, 128, 218}, mixed[4] = {51, 179};
    uint32_t             even[16];
    for (uint32_t n = 0; n < 16; n++) even[n] = 1;
    nibble_start((nibble_odds *)odds, even, 0);
    for (size_t n = 1; n < sizeof *odds / sizeof(nibble_odds); n++) ((nibble_odds *)odds)[n] = *(nibble_odds *)odds;
    for (uint32_t k = 0; k < 64; k++) {
        start_mask(&odds->node_mixed[k], k & 15, mixed, 4);
        for (uint32_t q = 0; q < 5; q++) odds->block_mixed[q][k] = odds->node_mixed[k];
    }
    for (uint32_t left = 0; left < 4; left++)
        for (uint32_t k = 0; k < 256; k++) start_mask(&odds->used[left][k], k, used, left ? left : 4);
    for (uint32_t kind = 0; kind < 4; kind++)
        for (uint32_t k = 0; k < 128; k++) start_differs(&odds->differs[kind >> 1][kind & 1][k], k);
}

PAGE_INLINE uint32_t code_flag(coder *c, nibble_odds *odds, uint32_t value)
{
    return code_nibble(c, odds, value) != 0;
}

/* Any number below 2^32 - 1: how many bits v + 1 has, up to four bits behind its first, and the rest as it is. */
PAGE_INLINE uint32_t code_number(coder *c, number_odds *odds, uint32_t value)
{
    uint32_t size = 0;
    if (PAGE_ENCODING) size = page_last_bit(value + 1) < 15 ? page_last_bit(value + 1) : 15;
    size = code_nibble(c, &odds->size, size);
    if (!size) return 0;
    if (size == 15) {
        uint32_t high = code_plain(c, 8, value >> 24), middle = code_plain(c, 12, value >> 12 & 0xfff);
        return high << 24 | middle << 12 | code_plain(c, 12, value & 0xfff);
    }
    uint32_t low = size > 4 ? size - 4 : 0, rest = value + 1 - (1u << size);
    uint32_t top = code_nibble(c, &odds->top[size], rest >> low & 15);
    rest         = low ? code_plain(c, low, rest & ((1u << low) - 1)) : 0;
    return (1u << size) + (top << low | rest) - 1;
}

/* A number that is the step from `last` + 1 to one that is likely to be round: low bits of the sum are coded, not of the step. */
PAGE_INLINE uint32_t code_step(coder *c, number_odds *odds, nibble_odds *round, uint32_t last, uint32_t value)
{
    uint32_t size = 0;
    if (PAGE_ENCODING) size = page_last_bit(value + 1) < 15 ? page_last_bit(value + 1) : 15;
    size = code_nibble(c, &odds->size, size);
    if (!size) return 0;
    if (size == 15) {
        uint32_t high = code_plain(c, 8, value >> 24), middle = code_plain(c, 12, value >> 12 & 0xfff);
        return high << 24 | middle << 12 | code_plain(c, 12, value & 0xfff);
    }
    uint32_t low = size > 4 ? size - 4 : 0, rest = value + 1 - (1u << size), mask = (1u << low) - 1;
    uint32_t step = (1u << size) + (code_nibble(c, &odds->top[size], rest >> low & 15) << low); /* at least */
    if (!low) return step - 1;
    uint32_t bits  = (last + value + 1) & mask;
    uint32_t zeros = code_nibble(c, &round[low], bits ? page_first_bit(bits) : low), more = zeros < low ? low - zeros - 1 : 0;
    bits = zeros < low ? (code_plain(c, more, bits >> (zeros + 1)) << 1 | 1) << zeros : 0;
    return step + ((bits - last - step) & mask) - 1;
}

/* A number from -SIGNED_MOST to SIGNED_MOST. */
PAGE_INLINE int32_t code_signed(coder *c, signed_odds *odds, int32_t value)
{
    uint32_t size = code_number(c, &odds->size, (uint32_t)(value < 0 ? -value : value)) & SIGNED_MOST;
    if (!size) return 0;
    return code_flag(c, &odds->sign, value < 0) ? -(int32_t)size : (int32_t)size;
}

/* words ------------------------------------------------------------------------------------------------------------------------ */

PAGE_INLINE uint32_t get_half(const uint32_t *words, uint32_t half)
{
    return words[half >> 1] >> 16 * (half & 1) & 0xffff;
}

/* Over zeros. */
PAGE_INLINE void put_half(uint32_t *words, uint32_t half, uint32_t value)
{
    words[half >> 1] |= (value & 0xffff) << 16 * (half & 1);
}

PAGE_INLINE uint32_t get_byte(const uint32_t *words, uint32_t byte)
{
    return words[byte >> 2] >> 8 * (byte & 3) & 0xff;
}

PAGE_INLINE void put_byte(uint32_t *words, uint32_t byte, uint32_t value)
{
    words[byte >> 2] |= (value & 0xff) << 8 * (byte & 3);
}

PAGE_INLINE uint32_t count_bits(uint32_t x)
{
    x -= x >> 1 & 0x55555555;
    x = (x & 0x33333333) + (x >> 2 & 0x33333333);
    return ((x + (x >> 4)) & 0x0f0f0f0f) * 0x01010101 >> 24;
}

/* A page while it is walked. */
typedef struct walk {
    coder             c;
    page_odds        *odds;
    vxs_page_scratch *s;
    uint32_t         *words; /* [word_count] being laid out */
    uint32_t          word_count, node_words;
    uint32_t          word, half; /* where the next record, and the next pattern go */
    const vxs_common *common;
    uint32_t          patterns[VXS_PATTERN_KINDS], chunks, blocks; /* how many are in the lists */
    int32_t           slope_x, slope_y;                            /* of the last node */
    const uint32_t   *source;                                   /* [word_count] of the encoder, like the next two: what is coded */
    uint32_t         *pattern_rank;                             /* [2^18] by ref: where in its list, + 1; 0: not yet met */
    uint32_t         *block_rank;                               /* [65536] by word */
    _Alignas(16) int16_t above[8 + NODE_PX + 8], left[NODE_PX]; /* [8 + x], [y] */
} walk;

/* Of the source, which may be anything: beyond its words are zeros. The decoder has none. */
PAGE_INLINE uint32_t source_word(const walk *w, uint32_t word)
{
    return PAGE_ENCODING && word < w->word_count ? w->source[word] : 0;
}

PAGE_INLINE uint32_t source_half(const walk *w, uint32_t half)
{
    return source_word(w, half >> 1) >> 16 * (half & 1) & 0xffff;
}

/* patterns --------------------------------------------------------------------------------------------------------------------- */

/* Nibbles of 8 bits. */
PAGE_INLINE uint32_t nibbles_of_bits(uint32_t x)
{
    x = (x | x << 12) & 0x000f000f;
    x = (x | x << 6) & 0x03030303;
    return (x | x << 3) & 0x11111111;
}

/* Indices of depths of a pattern of `depths` depths whose states, or image, start at a half. Whoever calls knows that it is whole.
 * index  [64] quadrant by quadrant */
static void read_pattern(const uint32_t *words, uint32_t half, uint32_t depths, uint8_t *index)
{
    if (get_byte(words, 2 * half) == 0xff) {
        for (uint32_t z = 0; z < 64; z++) index[z] = get_byte(words, 2 * half + 2 + (z & 31)) >> (z >> 5) * 4 & 15;
        return;
    }
    uint32_t own = half + depths / 2;
    memset(index, 0, 64);
    for (uint32_t c = 0; c < 4; c++) {
        uint32_t last = 0;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            uint32_t state = get_byte(words, 2 * half + n) >> 2 * c & 3;
            if (state == 2) last = get_half(words, own++);
            uint32_t mask = state < 2 ? 0 - state : last;
            for (uint32_t z = 0; z < 16; z++) index[16 * c + z] += !(mask >> z & 1);
        }
    }
}

/* A pattern of the source, of which nothing is known. 0: it is none. */
static int read_source(const walk *w, uint32_t half, uint32_t depths, uint8_t *index)
{
    uint32_t copy[(DEPTHS_MAX / 2 + 4 * DEPTHS_MAX) / 2] = {0}, none = 0;
    for (uint32_t n = 0; n < DEPTHS_MAX / 2 + 4 * DEPTHS_MAX; n++) put_half(copy, n, source_half(w, half + n));
    read_pattern(copy, 0, depths, index);
    for (uint32_t z = 0; z < 64; z++) none |= index[z] >= depths;
    return !none;
}

/* Nibbles of what lies in the last row, and in the last column, of 64 bytes, quadrant by quadrant. */
static uint64_t border_of(const uint8_t *index)
{
    uint32_t row = 0, column = 0;
    for (uint32_t n = 0; n < 4; n++) {
        row |= (uint32_t)index[32 + 12 + n] << 4 * n | (uint32_t)index[48 + 12 + n] << (16 + 4 * n);
        column |= (uint32_t)index[16 + 4 * n + 3] << 4 * n | (uint32_t)index[48 + 4 * n + 3] << (16 + 4 * n);
    }
    return row | (uint64_t)column << 32;
}

/* Lay out a pattern at w->half, as masks or as an image, whichever is shorter. 0: there is no room. */
static int put_pattern(walk *w, const uint8_t *index, uint32_t depths)
{
    uint8_t  state[DEPTHS_MAX] = {0};
    uint16_t own[4 * DEPTHS_MAX + 1];
    uint32_t owns = 0;
    for (uint32_t c = 0; c < 4; c++) {
        uint32_t last = 0x10000;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            uint32_t mask = 0;
#ifdef PAGE_SSE2
            mask = (uint32_t)_mm_movemask_epi8(
                _mm_cmpgt_epi8(_mm_set1_epi8((char)(n + 1)), _mm_load_si128((const __m128i *)(index + 16 * c))));
#else
            for (uint32_t z = 0; z < 16; z++) mask |= (uint32_t)(index[16 * c + z] <= n) << z;
#endif
            uint32_t s = mask == 0 ? 0 : mask == 0xffff ? 1 : mask == last ? 3 : 2;
            own[owns]  = (uint16_t)mask;
            owns += s == 2;
            last = s == 2 ? mask : last;
            state[n] |= (uint8_t)(s << 2 * c);
        }
    }
    uint32_t states = depths / 2, size = states + owns, image = size > INDEX_HALVES;
    if (image) size = INDEX_HALVES;
    if (size > 2 * w->word_count - w->half) return 0;
    if (image) {
        put_half(w->words, w->half, 0xff);
        for (uint32_t n = 0; n < 32; n++) put_byte(w->words, 2 * w->half + 2 + n, index[n] | (uint32_t)index[n + 32] << 4);
    } else {
        for (uint32_t n = 0; n < states; n++) put_half(w->words, w->half + n, state[2 * n] | (uint32_t)state[2 * n + 1] << 8);
        for (uint32_t n = 0; n < owns; n++) put_half(w->words, w->half + states + n, own[n]);
    }
    w->half += size;
    return 1;
}

/* Indices of the depths that the texels about a tile have, among those of its pattern; row[0] and row[1] are left of the corner.
 * depth  [depths] ascending
 * row    [16] from two texels left of the tile
 * column [8] */
static void border_indices(const walk *w, const int16_t *depth, uint32_t depths, uint32_t x0, uint32_t y0, uint8_t *row,
                           uint8_t *column)
{
    const int16_t *above = w->above + 8 + x0 - 2, *left = w->left + y0;
#ifdef PAGE_SSE2
    const __m128i zero = _mm_set1_epi16(depth[0]);
    __m128i       a = _mm_sub_epi16(_mm_loadu_si128((const __m128i *)above), zero), n = _mm_setzero_si128(), m = n;
    __m128i       b = _mm_sub_epi16(_mm_loadu_si128((const __m128i *)(above + 8)), zero);
    __m128i       c = _mm_sub_epi16(_mm_loadu_si128((const __m128i *)left), zero);
    for (uint32_t k = 0; k + 1 < depths; k++) {
        uint32_t between = (uint32_t)(uint16_t)(depth[k] - depth[0]) + (uint16_t)(depth[k + 1] - depth[0]);
        __m128i  t       = _mm_set1_epi16((int16_t)(between >> 1));
        n                = _mm_sub_epi8(n, _mm_packs_epi16(_mm_cmpgt_epi16(a, t), _mm_cmpgt_epi16(b, t)));
        m                = _mm_sub_epi8(m, _mm_packs_epi16(_mm_cmpgt_epi16(c, t), _mm_setzero_si128()));
    }
    _mm_storeu_si128((__m128i *)row, n);
    _mm_storel_epi64((__m128i *)column, m);
#else
    memset(row, 0, 16);
    memset(column, 0, 8);
    for (uint32_t k = 0; k + 1 < depths; k++) {
        uint32_t between = (uint32_t)(uint16_t)(depth[k] - depth[0]) + (uint16_t)(depth[k + 1] - depth[0]);
        int16_t t = (int16_t)(between >> 1);
        for (int n = 0; n < 16; n++) row[n] += (int16_t)(above[n] - depth[0]) > t;
        for (int n = 0; n < 8; n++) column[n] += (int16_t)(left[n] - depth[0]) > t;
    }
#endif
}

/* Which of eight bytes below 128 are not 0. */
PAGE_INLINE uint32_t bytes_set(uint64_t x)
{
    x = (x + 0x7f7f7f7f7f7f7f7f) >> 7 & 0x0101010101010101;
    return (uint32_t)(x * 0x0102040810204080 >> 56);
}

/* A texel that differs from N, the one above it; W is on its left, NE on the right of N. */
PAGE_INLINE uint32_t code_other(coder *c, page_odds *odds, uint32_t depths, uint32_t value, uint32_t W, uint32_t N, uint32_t NE)
{
    uint32_t like = W == N ? NE != N : NE == N ? 2 : NE == W ? 3 : 4, end = N == 0 ? 0 : N + 1 == depths ? 2 : 1, symbol = 0;
    if (PAGE_ENCODING) {
        uint32_t step = value > N ? 2 * (value - N) : 1 + 2 * (N - value);
        symbol        = value == W ? 0 : value == NE ? 1 : step < 15 ? step : 15;
    }
    symbol = code_nibble(c, &odds->other[depths < 4 ? 0 : depths < 6 ? 1 : depths < 9 ? 2 : 3][like][end], symbol);
    if (symbol == 15) return code_nibble(c, &odds->far, value);
    return symbol == 0 ? W : symbol == 1 ? NE : symbol & 1 ? N - (symbol >> 1) : N + (symbol >> 1);
}

/* The indices of a pattern's texels, row by row: four texels at once say which differ from the texel above, and those that do say
 * what they are. 0: an index is none. */
static int code_image(walk *w, const int16_t *depth, uint32_t depths, uint32_t x0, uint32_t y0, uint8_t *index)
{
    uint8_t border[16], left[8];
    border_indices(w, depth, depths, x0, y0, border, left);
    coder      c    = w->c; /* a copy may live in registers */
    page_odds *odds = w->odds;
    uint64_t   last = vxs_load64(border + 2), before = last; /* the row above, and the one above that: a byte a texel */
    uint32_t   corner = border[1], right = border[10];
    for (uint32_t y = 0; y < 8; y++) {
        uint32_t beside = bytes_set(last ^ (last << 8 | corner)) | (uint32_t)(right != last >> 56) << 8,
                 was    = bytes_set(last ^ before);
        uint32_t W = left[y], side = W != corner, half[2];
        for (uint32_t h = 0; h < 2; h++) {
            uint32_t k = (beside >> 4 * h & 31) | side << 5 | (uint32_t)((was >> 4 * h & 15) != 0) << 6, differs = 0;
            uint32_t above = (uint32_t)(last >> 32 * h), now = above, value = 0;
            uint8_t *texels = index + 32 * (y >> 2) + 16 * h + 4 * (y & 3);
            if (PAGE_ENCODING) differs = bytes_set(above ^ (value = vxs_load32(texels)));
            differs = code_nibble(&c, &odds->differs[depths > 2][y != 0][k], differs);
            side    = differs >> 3;
            if (depths == 2)
                now ^= differs * 0x00204081 & 0x01010101;
            else
                for (; differs; differs &= differs - 1) {
                    uint32_t x = page_first_bit(differs), at = 8 * x, N = above >> at & 255;
                    uint32_t NE  = x < 3 ? above >> (at + 8) & 255 : h ? right : (uint32_t)(last >> 32) & 255;
                    uint32_t got = code_other(&c, odds, depths, value >> at & 255, x ? now >> (at - 8) & 255 : W, N, NE);
                    if (got >= depths) return 0;
                    now ^= (N ^ got) << at;
                }
            vxs_store32(texels, half[h] = now);
            W = now >> 24;
        }
        before = last;
        last   = half[0] | (uint64_t)half[1] << 32;
        corner = left[y];
        right  = W; /* nothing is known on the right of the tile */
    }
    w->c = c;
    return 1;
}

/* What a tile leaves for those on its right and below.
 * depth  of its pattern, by index */
static void draw_pattern(walk *w, uint64_t border, const int16_t *depth, uint32_t x0, uint32_t y0)
{
    int16_t *above = w->above + 8 + x0, *left = w->left + y0;
    for (uint32_t n = 0; n < TILE_PX; n++) {
        above[n] = depth[border >> 4 * n & 15];
        left[n]  = depth[border >> (32 + 4 * n) & 15];
    }
}

PAGE_INLINE void draw_uniform(walk *w, uint32_t x0, uint32_t y0, uint32_t side_px, int16_t depth)
{
    for (uint32_t n = 0; n < side_px; n++) w->above[8 + x0 + n] = w->left[y0 + n] = depth;
}

/* patterns with depths of their own -------------------------------------------------------------------------------------------- */

/* Where texel (x, y) lies, quadrant by quadrant. */
PAGE_INLINE uint32_t texel_at(uint32_t x, uint32_t y)
{
    return ((x >> 2) + 2 * (y >> 2)) * 16 + (y & 3) * 4 + (x & 3);
}

/* Palette of an own pattern whose first half is `head`; deltas start at a half. */
static uint32_t own_delta(const uint32_t *words, uint32_t half, uint32_t head, uint32_t n)
{
    uint32_t kind = head >> 12, shift = head >> 8 & 15;
    if (kind == OWN_BYTES) return get_byte(words, 2 * half + n) << shift;
    if (kind == OWN_HALVES) return get_half(words, half + n) << shift;
    return (get_half(words, half + 2 * n) | get_half(words, half + 2 * n + 1) << 16) << shift;
}

static uint32_t own_delta_halves(uint32_t kind, uint32_t deltas)
{
    return kind == OWN_BYTES ? (deltas + 1) / 2 : kind == OWN_HALVES ? deltas : 2 * deltas;
}

/* Of patterns that are no palette. */
static const uint32_t raw_halves[OWN_KINDS] = {0, 0, 0, 1 + 2 + 16, 1 + 32, 1 + 64, 1 + 96};

/* Depth of texel z of a raw pattern, before the shift. */
static uint32_t raw_depth(const uint32_t *words, uint32_t half, uint32_t kind, uint32_t z)
{
    uint32_t byte = 2 * half + 2;
    if (kind == OWN_NIBBLES) return get_byte(words, byte + z / 16) + (get_byte(words, byte + 4 + (z & 31)) >> (z >> 5) * 4 & 15);
    if (kind == OWN_RAW1) return get_byte(words, byte + z);
    if (kind == OWN_RAW2) return get_half(words, half + 1 + z);
    return get_byte(words, byte + 3 * z) | get_byte(words, byte + 3 * z + 1) << 8 | get_byte(words, byte + 3 * z + 2) << 16;
}

/* What an own tile leaves. base: of the tile, in the node. */
static void draw_own(walk *w, const uint32_t *words, const vxs_pattern *pattern, uint32_t half, int32_t base, uint32_t x0,
                     uint32_t y0)
{
    uint32_t head = get_half(words, half), kind = head >> 12;
    if (kind <= OWN_WORDS) {
        int16_t  depth[DEPTHS_MAX];
        uint32_t depths = head & 0xff;
        depth[0]        = (int16_t)base;
        for (uint32_t n = 0; n + 1 < depths; n++) depth[n + 1] = (int16_t)(base + (int32_t)own_delta(words, half + 1, head, n));
        draw_pattern(w, pattern->border, depth, x0, y0);
        return;
    }
    for (uint32_t n = 0; n < TILE_PX; n++) {
        uint32_t shift       = head >> 8 & 15;
        w->above[8 + x0 + n] = (int16_t)(base + (int32_t)(raw_depth(words, half, kind, texel_at(n, 7)) << shift));
        w->left[y0 + n]      = (int16_t)(base + (int32_t)(raw_depth(words, half, kind, texel_at(7, n)) << shift));
    }
}

/* A palette and the pattern over it. from: the half of the source where the pattern starts. */
static int code_own_palette(walk *w, uint32_t kind, uint32_t from, int32_t base, uint32_t x0, uint32_t y0, uint64_t *border)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   head = source_half(w, from), shift = code_nibble(c, &odds->own_shift, head >> 8 & 15);
    uint32_t   depths = code_nibble(c, &odds->own_count, (head - 2) & 15) + 2, half = w->half, last = 0;
    uint32_t   halves = own_delta_halves(kind, depths - 1), end = kind == OWN_BYTES    ? 1 << 8
                                                                  : kind == OWN_HALVES ? 1 << 16
                                                                                       : DEPTH_END;
    int16_t    depth[DEPTHS_MAX] = {(int16_t)base};
    if (depths > DEPTHS_MAX || 1 + halves > 2 * w->word_count - half) return 0;
    put_half(w->words, half, head = kind << 12 | shift << 8 | depths);
    for (uint32_t n = 0; n + 1 < depths; n++) {
        uint32_t delta = 0;
        if (PAGE_ENCODING) {
            uint32_t at = from + 1 + (kind == OWN_BYTES ? n / 2 : kind == OWN_HALVES ? n : 2 * n);
            delta       = kind == OWN_BYTES    ? source_half(w, at) >> 8 * (n & 1) & 255
                          : kind == OWN_HALVES ? source_half(w, at)
                                               : source_half(w, at) | source_half(w, at + 1) << 16;
            if (delta <= last || delta >= end) return 0;
        }
        delta = code_step(c, &odds->own_delta, odds->own_round, last, delta - last - 1);
        if (delta >= end - 1 - last || (uint64_t)(last + delta + 1) << shift >= DEPTH_END) return 0;
        last += delta + 1;
        depth[n + 1] = (int16_t)(base + (int32_t)(last << shift));
        if (kind == OWN_BYTES)
            put_byte(w->words, 2 * half + 2 + n, last);
        else if (kind == OWN_HALVES)
            put_half(w->words, half + 1 + n, last);
        else {
            put_half(w->words, half + 1 + 2 * n, last);
            put_half(w->words, half + 2 + 2 * n, last >> 16);
        }
    }
    w->half += 1 + halves;
    _Alignas(16) uint8_t index[64];
    if (PAGE_ENCODING && !read_source(w, from + 1 + halves, depths, index)) return 0;
    if (!code_image(w, depth, depths, x0, y0, index) || !put_pattern(w, index, depths)) return 0;
    *border = border_of(index);
    return 1;
}

/* What a depth of a raw pattern is likely to be, by those on its left and above; where it has none, by what is beside the tile.
 * d  of [8][8] */
PAGE_INLINE int32_t raw_like(const walk *w, const uint32_t *d, uint32_t x, uint32_t y, int32_t base, uint32_t shift, uint32_t x0,
                             uint32_t y0)
{
    const int16_t *above = w->above + 8 + x0 + x, *left = w->left + y0 + y;
    if (x && y) return (int32_t)(d[-1] + d[-8] - d[-9]);
    if (x) return (int32_t)d[-1] + ((int16_t)(above[0] - above[-1]) >> shift);
    if (y) return (int32_t)d[-8] + ((int16_t)(left[0] - left[-1]) >> shift);
    return (int16_t)((left[0] < above[0] ? left[0] : above[0]) - base) >> shift;
}

/* 64 depths as they are. explicit_bases: the four bases of OWN_NIBBLES are not the least depths of their quadrants. */
static int code_own_raw(walk *w, uint32_t kind, int explicit_bases, uint32_t from, int32_t base_depth, uint32_t x0, uint32_t y0)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   half = w->half, shift = code_nibble(c, &odds->own_shift, source_half(w, from) >> 8 & 15);
    uint32_t   depth[8][8], base[4] = {~0u, ~0u, ~0u, ~0u}, last = 0;
    uint32_t   end = kind == OWN_NIBBLES ? 255 + 16 : kind == OWN_RAW1 ? 1 << 8 : kind == OWN_RAW2 ? 1 << 16 : 1 << 24;
    if (raw_halves[kind] > 2 * w->word_count - half) return 0;
    for (uint32_t y = 0; y < 8; y++)
        for (uint32_t x = 0; x < 8; x++) {
            uint32_t z = texel_at(x, y), *d = &depth[y][x];
            int32_t  like = raw_like(w, d, x, y, base_depth, shift, x0, y0);
            like          = like < 0 ? 0 : like >= (int32_t)end ? (int32_t)end - 1 : like;

            int32_t  off    = PAGE_ENCODING ? (int32_t)raw_depth(w->source, from, kind, z) - like : 0;
            uint32_t zigzag = off < 0 ? 2 * (uint32_t)-off - 1 : 2 * (uint32_t)off;
            uint32_t symbol = code_nibble(c, &odds->residual[x || y ? x && y : 2][last], zigzag < 15 ? zigzag : 15);
            zigzag          = symbol < 15 ? symbol : 15 + code_number(c, &odds->raw_far, zigzag - 15);
            if (zigzag >= 2u * DEPTH_END) return 0;
            last = (2 * last + zigzag + 1) / 4;
            last = last > 5 ? 5 : last;

            int32_t here = zigzag & 1 ? like - (int32_t)((zigzag + 1) / 2) : like + (int32_t)(zigzag / 2);
            if (here < 0 || here >= (int32_t)end || (uint64_t)here << shift >= DEPTH_END) return 0;
            *d = (uint32_t)here;
            if (base[z / 16] > *d) base[z / 16] = *d;
        }
    put_half(w->words, half, kind << 12 | shift << 8);
    for (uint32_t n = 0; n < 4 && kind == OWN_NIBBLES; n++) {
        if (explicit_bases) base[n] = code_number(c, &odds->raw_base, source_half(w, from + 1 + n / 2) >> 8 * (n & 1) & 255);
        if (base[n] > 255) return 0;
        put_byte(w->words, 2 * half + 2 + n, base[n]);
    }
    for (uint32_t z = 0; z < 64; z++) {
        uint32_t d = depth[(z >> 5) * 4 + (z >> 2 & 3)][(z >> 4 & 1) * 4 + (z & 3)], byte = 2 * half + 2;
        if (kind == OWN_NIBBLES) {
            d -= base[z / 16];
            if (d > 15) return 0;
            put_byte(w->words, byte + 4 + (z & 31), d << (z >> 5) * 4);
        } else if (kind == OWN_RAW1)
            put_byte(w->words, byte + z, d);
        else if (kind == OWN_RAW2)
            put_half(w->words, half + 1 + z, d);
        else
            for (uint32_t n = 0; n < 3; n++) put_byte(w->words, byte + 3 * z + n, d >> 8 * n);
    }
    w->half += raw_halves[kind];
    return 1;
}

/* A new own pattern. */
static int code_own(walk *w, uint32_t from, int32_t base, uint32_t x0, uint32_t y0, uint64_t *border)
{
    uint32_t kind = source_half(w, from) >> 12;
    if (PAGE_ENCODING) {
        if (kind >= OWN_KINDS || (kind >= OWN_NIBBLES && from + raw_halves[kind] > 2 * w->word_count)) return 0;
        for (uint32_t c = 0, bases = kind == OWN_NIBBLES; c < 4 && bases; c++) {
            uint32_t least = 0, first = get_byte(w->source, 2 * from + 2 + c);
            for (uint32_t z = 16 * c; z < 16 * c + 16; z++) least |= raw_depth(w->source, from, OWN_NIBBLES, z) == first;
            if (!least) kind = OWN_KINDS;
        }
    }
    kind    = code_nibble(&w->c, &w->odds->own_kind, kind);
    *border = 0;
    if (kind > OWN_KINDS) return 0;
    if (kind <= OWN_WORDS) return code_own_palette(w, kind, from, base, x0, y0, border);
    return kind == OWN_KINDS ? code_own_raw(w, OWN_NIBBLES, 1, from, base, x0, y0) : code_own_raw(w, kind, 0, from, base, x0, y0);
}

/* lists of patterns ------------------------------------------------------------------------------------------------------------ */

PAGE_INLINE vxs_pattern *pattern_at(walk *w, uint32_t kind, uint32_t rank)
{
    return w->s->pattern + w->s->chunk[kind][rank / LIST_CHUNK] * (uint32_t)LIST_CHUNK + rank % LIST_CHUNK;
}

/* Append to its list. There is room: each comes with a tile, and a tile is a word. */
static vxs_pattern *add_pattern(walk *w, vxs_pattern pattern)
{
    uint32_t kind = pattern.kind, rank = w->patterns[kind]++;
    if (rank % LIST_CHUNK == 0) w->s->chunk[kind][rank / LIST_CHUNK] = (uint16_t)w->chunks++;
    if (PAGE_ENCODING) w->pattern_rank[pattern.ref] = rank + 1;
    vxs_pattern *at = pattern_at(w, kind, rank);
    *at             = pattern;
    return at;
}

/* Of a list, what is used moves half the way to the front, and changes places with what is there. */
static vxs_pattern *use_pattern(walk *w, uint32_t kind, uint32_t rank)
{
    vxs_pattern *from = pattern_at(w, kind, rank), *to = pattern_at(w, kind, rank / 2), other = *to;
    *to   = *from;
    *from = other;
    if (PAGE_ENCODING) {
        w->pattern_rank[from->ref] = rank + 1;
        w->pattern_rank[to->ref]   = rank / 2 + 1;
    }
    return to;
}

/* 0: a new one; 1: the common pool's; else rank in its list + 2. */
static uint32_t find_pattern(walk *w, uint32_t kind, uint32_t ref)
{
    uint32_t rank = w->pattern_rank[ref];
    if (rank && rank <= w->patterns[kind] && pattern_at(w, kind, rank - 1)->ref == ref) return rank + 1;
    return ref & REF_COMMON ? 1 : 0;
}

static uint32_t find_common(const vxs_common *common, uint32_t kind, uint32_t ref)
{
    uint32_t low = common->first[kind], high = common->first[kind + 1];
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (common->patterns[middle].ref < ref)
            low = middle + 1;
        else
            high = middle;
    }
    return low - common->first[kind];
}

/* The pattern of a tile; NULL: not a page.
 * depth  [kind] of a pattern over the palette
 * ref    of the source
 * base   of an own pattern */
static const vxs_pattern *code_pattern(walk *w, uint32_t kind, const int16_t *depth, uint32_t ref, int32_t base, uint32_t x0,
                                       uint32_t y0)
{
    uint32_t place = code_number(&w->c, &w->odds->pattern[kind], PAGE_ENCODING ? find_pattern(w, kind, ref) : 0);
    if (place >= 2) return place - 2 < w->patterns[kind] ? use_pattern(w, kind, place - 2) : NULL;
    if (place == 1) {
        uint32_t n = code_number(&w->c, &w->odds->common[kind], PAGE_ENCODING ? find_common(w->common, kind, ref) : 0);
        if (n >= w->common->first[kind + 1] - w->common->first[kind]) return NULL;
        return add_pattern(w, w->common->patterns[w->common->first[kind] + n]);
    }
    vxs_pattern new = {.ref = w->half, .kind = kind};
    if (kind == KIND_OWN) return code_own(w, ref, base, x0, y0, &new.border) ? add_pattern(w, new) : NULL;
    _Alignas(16) uint8_t index[64];
    if (PAGE_ENCODING && !read_source(w, ref, kind, index)) return NULL;
    if (!code_image(w, depth, kind, x0, y0, index) || !put_pattern(w, index, kind)) return NULL;
    new.border = border_of(index);
    return add_pattern(w, new);
}

/* blocks ----------------------------------------------------------------------------------------------------------------------- */

/* A block while it is coded. */
typedef struct block {
    _Alignas(16) int16_t depth[16]; /* of the palette, in the node */
    uint32_t entries, class;        /* of the palette; a rough measure of how many, 0..4 */
    uint32_t mixed, fresh, own;
    uint64_t index; /* of fresh tiles, a nibble each */
    uint32_t fresh_count, mixed_count, far;
    int32_t  base;
    int32_t  own_base[16];
    uint32_t word;     /* where it goes */
    uint32_t from;     /* where it is in the source */
    uint16_t used[16]; /* palette entries that each tile uses */
} block;

/* Whether depths at p are not all one. */
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

/* Which of 16 depths are `depth`. */
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

/* Which depths of a palette eight texels have. */
PAGE_INLINE uint32_t depths_met(const int16_t *palette, uint32_t entries, const int16_t *texels)
{
    uint32_t met = 0;
#ifdef PAGE_SSE2
    __m128i low = _mm_load_si128((const __m128i *)palette), high = _mm_load_si128((const __m128i *)palette + 1),
            a = _mm_setzero_si128(), b = a;
    for (uint32_t n = 0; n < 8; n++) {
        __m128i texel = _mm_set1_epi16(texels[n]);
        a             = _mm_or_si128(a, _mm_cmpeq_epi16(low, texel));
        b             = _mm_or_si128(b, _mm_cmpeq_epi16(high, texel));
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

/* The least depth on the left of a square and above it, INT16_MAX: there is none. NEVER is none. */
static int32_t least_border_depth(const walk *w, uint32_t x0, uint32_t y0, uint32_t side_px)
{
    int32_t least = INT16_MAX;
    for (uint32_t k = 0; k < side_px; k++) {
        int32_t l = w->left[y0 + k], a = w->above[8 + x0 + k];
        if (l < least && l != (int16_t)NEVER) least = l;
        if (a < least && a != (int16_t)NEVER) least = a;
    }
    return least;
}

/* The palette: how many entries, what deltas are stored as, and how far they lie apart. Deltas go to delta[entries - 1], as stored. */
static int code_palette(walk *w, block *b, uint32_t *form, uint32_t *delta)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   head = source_word(w, b->from + 1) >> 16, last = 0;
    b->entries = code_nibble(c, &odds->entries[b->class], head & 15) + 1;
    if (b->entries > PALETTE_MAX) return 0;
    b->class       = b->entries <= 2 ? b->entries - 1 : b->entries < 5 ? 2 : b->entries < 9 ? 3 : 4;
    uint32_t shift = head >> 4 & 15, width = head >> 8 & 3, far = head >> 10 & 1;
    uint32_t simple = code_nibble(c, &odds->delta_form[b->entries == 1], width || far || shift == 15 ? 15 : shift);
    if (simple == 15) {
        shift = code_nibble(c, &odds->delta_shift, shift);
        width = code_nibble(c, &odds->delta_width, width | far << 2);
        if (width > 7 || (width & 3) > 2 || ((width & 3) == 2 && shift)) return 0;
        far = width >> 2;
        width &= 3;
    } else {
        shift = simple;
        width = far = 0;
    }
    b->far       = far;
    *form        = (b->entries - 1) | shift << 4 | width << 8 | far << 10;
    uint32_t end = width == 0 ? 1 << 8 : width == 1 ? 1 << 16 : DEPTH_END;
    b->depth[0]  = (int16_t)b->base;
    for (uint32_t n = 1; n < 16; n++) b->depth[n] = 0;
    for (uint32_t n = 0; n + 1 < b->entries; n++) {
        uint32_t value = 0;
        if (PAGE_ENCODING) {
            uint32_t at = b->from + 2 + count_bits(source_word(w, b->from) & 0xffff), byte = n << width;
            value = source_word(w, at + byte / 4) >> 8 * (byte & 3) & (width == 0 ? 0xff : width == 1 ? 0xffff : ~0u);
            if (value <= last || value >= end) return 0;
        }
        value = code_step(c, width == 2 ? &odds->delta_wide : &odds->delta[shift][n > 0], odds->round, last, value - last - 1);
        if (value >= end - 1 - last || (uint64_t)(last + value + 1) << shift >= DEPTH_END) return 0;
        delta[n]        = last += value + 1;
        b->depth[n + 1] = (int16_t)(b->base + (int32_t)(last << shift));
    }
    return 1;
}

static int code_uniform_tile(walk *w, block *b, uint32_t t, uint32_t x0, uint32_t y0, uint32_t *last)
{
    uint32_t index = 0;
    if (b->entries > 1) {
        uint32_t in = (1u << b->entries) - 1, none = 16;
        uint32_t left = equal_depths(b->depth, w->left[y0]) & in, above = equal_depths(b->depth, w->above[8 + x0]) & in;
        left  = left ? page_first_bit(left) : none;
        above = above ? page_first_bit(above) : none;
        if (PAGE_ENCODING) {
            uint32_t shape = source_word(w, b->from), mixed = count_bits(shape & 0xffff),
                     nth  = count_bits(shape >> 16 & ((2u << t) - 1)) - 1;
            uint32_t byte = ((b->entries - 1) << (source_word(w, b->from + 1) >> 24 & 3)) + (nth & 15) / 2;
            index         = source_word(w, b->from + 2 + mixed + byte / 4) >> (8 * (byte & 3) + 4 * (nth & 1)) & 15;
            index         = index == left ? 0 : index == above ? 1 : index < b->entries ? index + 2 : 0;
        }
        uint32_t like = left == none ? above != none : above == none ? 2 : left == above ? 3 : 4;
        index         = code_nibble(&w->c, &w->odds->index[like][b->entries < 4 ? 0 : b->entries < 9 ? 1 : 2], index);
        index         = index == 0 ? left : index == 1 ? above : index - 2;
        if (index >= b->entries) return 0;
    }
    if (index != *last) {
        b->fresh |= 1u << t;
        b->index |= (uint64_t)index << 4 * b->fresh_count++;
        *last = index;
    }
    b->used[t] = (uint16_t)(1u << index);
    draw_uniform(w, x0, y0, TILE_PX, b->depth[index]);
    return 1;
}

/* Which palette entries a tile uses; 0: none, it has depths of its own. */
static uint32_t code_used(walk *w, const block *b, uint32_t t, uint32_t value, uint32_t x0, uint32_t y0)
{
    coder    c    = w->c;
    uint32_t left = depths_met(b->depth, b->entries, w->left + y0), above = depths_met(b->depth, b->entries, w->above + 8 + x0);
    uint32_t tiles = (t & 3 ? b->used[t - 1] : 0u) | (t > 3 ? b->used[t - 4] : 0u), either = left | above, used = 0;
    uint32_t span =
        either ? (2u << page_last_bit(either)) - (1u << page_first_bit(either)) : 0; /* from the first to the last of the borders */
    uint32_t low = (left & above) | ((tiles | span) & ~either);
    for (uint32_t n = 0; n < b->entries; n += 4) {
        uint32_t k = (low >> n & 15) | (either >> n & 15) << 4, more = b->entries - n;
        used |= code_nibble(&c, &w->odds->used[more < 4 ? more : 0][k], value >> n & 15) << n;
    }
    w->c = c;
    return used;
}

static int code_mixed_tile(walk *w, block *b, uint32_t t, uint32_t x0, uint32_t y0)
{
    uint32_t word = 0, used = 0, low;
    if (PAGE_ENCODING) {
        uint32_t before = count_bits(source_word(w, b->from) & ((1u << t) - 1));
        word            = source_word(w, b->from + 2 + before);
        if (!(source_word(w, b->from + 1) >> t & 1)) used = word & ((1u << b->entries) - 1);
    }
    if (b->entries > 1) used = code_used(w, b, t, used, x0, y0);
    if (used >> b->entries) return 0;
    const vxs_pattern *pattern;
    if (used) {
        int16_t  depth[DEPTHS_MAX];
        uint32_t kind = 0;
        for (uint32_t bits = used; bits; bits &= bits - 1) depth[kind++] = b->depth[page_first_bit(bits)];
        if (kind < 2 || !(pattern = code_pattern(w, kind, depth, word >> 14, 0, x0, y0))) return 0;
        draw_pattern(w, pattern->border, depth, x0, y0);
        low = used;
    } else {
        int32_t base = 0;
        if (PAGE_ENCODING) {
            if (b->far) {
                uint32_t shape = source_word(w, b->from), mixed = count_bits(shape & 0xffff);
                uint32_t bytes = ((b->entries - 1) << (source_word(w, b->from + 1) >> 24 & 3)) + (count_bits(shape >> 16) + 1) / 2;
                base           = (int32_t)source_word(w, b->from + 2 + mixed + (bytes + 3) / 4 + count_bits(b->own));
            } else
                base = (int32_t)(word & 0x3fff) - OWN_ZERO;
            if (base <= -DEPTH_END || base >= DEPTH_END) return 0;
        }
        int32_t like = least_border_depth(w, x0, y0, TILE_PX);
        like         = like == INT16_MAX ? 0 : (int16_t)(like - b->base);
        base         = like + code_signed(&w->c, &w->odds->own_base, base - like);
        if (b->far ? base <= -DEPTH_END || base >= DEPTH_END : base < -OWN_ZERO || base >= OWN_ZERO) return 0;
        if (!(pattern = code_pattern(w, KIND_OWN, NULL, word >> 14, b->base + base, x0, y0))) return 0;
        const uint32_t *words = pattern->ref & REF_COMMON ? w->common->words : w->words;
        draw_own(w, words, pattern, pattern->ref & (REF_COMMON - 1), b->base + base, x0, y0);
        b->own_base[count_bits(b->own)] = base;
        b->own |= 1u << t;
        low = b->far ? 0 : (uint32_t)(base + OWN_ZERO);
    }
    b->used[t]                               = (uint16_t)used;
    w->words[b->word + 2 + b->mixed_count++] = pattern->ref << 14 | low;
    return 1;
}

/* A new block at w->word. base: in the node; from: word of the source. */
static int code_block(walk *w, int32_t base, uint32_t from, uint32_t x0, uint32_t y0)
{
    block    b = {.base  = base,
                  .word  = w->word,
                  .from  = from,
                  .class = varied(w->left + y0, BLOCK_PX) | varied(w->above + 8 + x0, BLOCK_PX) << 1};
    uint32_t form, delta[PALETTE_MAX], last = 16;
    if (!code_palette(w, &b, &form, delta)) return 0;
    for (uint32_t y = 0; y < 4; y++) {
        const int16_t *above = w->above + 8 + x0;
        uint32_t       k     = varied(w->left + y0 + 8 * y, TILE_PX) << 4 | (uint32_t)(w->left[y0 + 8 * y] != above[0]) << 5;
        for (uint32_t x = 0; x < 4; x++) k |= varied(above + 8 * x, TILE_PX) << x;
        uint32_t row = code_nibble(&w->c, &w->odds->block_mixed[b.class][k], source_word(w, from) >> 4 * y & 15);
        b.mixed |= row << 4 * y;
        if (2 + count_bits(b.mixed) > w->node_words - b.word) return 0;
        for (uint32_t x = 0; x < 4; x++) {
            uint32_t t = x + 4 * y;
            if (!(row >> x & 1 ? code_mixed_tile(w, &b, t, x0 + 8 * x, y0 + 8 * y)
                               : code_uniform_tile(w, &b, t, x0 + 8 * x, y0 + 8 * y, &last)))
                return 0;
        }
    }
    uint32_t width = form >> 8 & 3, at = b.word + 2 + b.mixed_count, byte = 4 * at, owns = b.far ? count_bits(b.own) : 0;
    uint32_t bytes = ((b.entries - 1) << width) + (b.fresh_count + 1) / 2;
    if (2 + b.mixed_count + (bytes + 3) / 4 + owns > w->node_words - b.word) return 0;
    w->words[b.word]     = b.mixed | b.fresh << 16;
    w->words[b.word + 1] = b.own | form << 16;
    for (uint32_t n = 0; n + 1 < b.entries; n++)
        for (uint32_t k = 0; k < 1u << width; k++) put_byte(w->words, byte++, delta[n] >> 8 * k);
    for (uint32_t n = 0; n < b.fresh_count; n += 2) put_byte(w->words, byte++, b.index >> 4 * n & 0xff);
    at += (bytes + 3) / 4;
    for (uint32_t n = 0; n < owns; n++) w->words[at++] = (uint32_t)b.own_base[n];
    w->word = at;
    return 1;
}

/* The borders of a block that was met before: of its last row and its last column of tiles. */
static void draw_block(walk *w, uint32_t word, int32_t base, uint32_t x0, uint32_t y0)
{
    const uint32_t *words = w->words;
    uint32_t        shape = words[word], head = words[word + 1], mixed = shape & 0xffff, entries = (head >> 16 & 15) + 1;
    uint32_t        shift = head >> 20 & 15, width = head >> 24 & 3, byte = 4 * (word + 2 + count_bits(mixed)),
             index_byte = byte + ((entries - 1) << width);
    int16_t depth[16]   = {(int16_t)base};
    for (uint32_t n = 0; n + 1 < entries; n++) {
        uint32_t delta = 0;
        for (uint32_t k = 0; k < 1u << width; k++) delta |= get_byte(words, byte + (n << width) + k) << 8 * k;
        depth[n + 1] = (int16_t)(base + (int32_t)(delta << shift));
    }
    for (uint32_t t = 0; t < 16; t++) {
        uint32_t x = x0 + 8 * (t & 3), y = y0 + 8 * (t >> 2);
        if ((t & 3) != 3 && t < 12) continue;
        if (!(mixed >> t & 1)) {
            uint32_t nth = count_bits(shape >> 16 & ((2u << t) - 1)) - 1;
            draw_uniform(w, x, y, TILE_PX, depth[get_byte(words, index_byte + nth / 2) >> 4 * (nth & 1) & 15]);
            continue;
        }
        uint32_t tile = words[word + 2 + count_bits(mixed & ((1u << t) - 1))], ref = tile >> 14, half = ref & (REF_COMMON - 1);
        const uint32_t      *pool = ref & REF_COMMON ? w->common->words : words;
        _Alignas(16) uint8_t index[64];
        vxs_pattern          pattern = {0};
        if (!(head >> t & 1)) {
            int16_t  used[DEPTHS_MAX];
            uint32_t kind = 0;
            for (uint32_t bits = tile & 0x3fff; bits; bits &= bits - 1) used[kind++] = depth[page_first_bit(bits)];
            read_pattern(pool, half, kind, index);
            draw_pattern(w, border_of(index), used, x, y);
            continue;
        }
        int32_t own = (int32_t)(tile & 0x3fff) - OWN_ZERO;
        if (head >> 26 & 1) {
            uint32_t bytes = ((entries - 1) << width) + (count_bits(shape >> 16) + 1) / 2;
            own            = (int32_t)words[byte / 4 + (bytes + 3) / 4 + count_bits(head & ((1u << t) - 1))];
        }
        uint32_t first = get_half(pool, half), depths = first & 0xff;
        if (first >> 12 <= OWN_WORDS) {
            read_pattern(pool, half + 1 + own_delta_halves(first >> 12, depths - 1), depths, index);
            pattern.border = border_of(index);
        }
        draw_own(w, pool, &pattern, half, base + own, x, y);
    }
}

/* A mixed block of a node: its base, and where it is. */
static int code_block_of(walk *w, int wide, uint32_t x0, uint32_t y0, uint32_t *ref, uint32_t *base)
{
    int32_t  like  = least_border_depth(w, x0, y0, BLOCK_PX), off;
    uint32_t place = 0, high = 0;
    if (like == INT16_MAX) like = 0;
    if (PAGE_ENCODING) place = w->block_rank[*ref];
    place = code_number(&w->c, &w->odds->block, place);
    off   = code_signed(&w->c, &w->odds->base, (int16_t)(*base - (uint32_t)like));
    if (wide) high = code_number(&w->c, &w->odds->high, *base >> 16);
    if (high >= DEPTH_END >> 16) return 0;
    *base = ((uint32_t)(like + off) & 0xffff) | high << 16;
    if (!place) {
        uint32_t word = w->word, from = *ref;
        *ref = word;
        if (w->blocks == VXS_PAGE_WORDS_MAX / 2 || word + 2 > w->node_words) return 0;
        w->s->block[w->blocks++] = (uint16_t)word;
        if (PAGE_ENCODING) w->block_rank[word] = w->blocks;
        return code_block(w, (int32_t)*base, from, x0, y0);
    }
    if (place > w->blocks) return 0;
    uint16_t *list = w->s->block, *from = list + place - 1, *to = list + (place - 1) / 2, other = *to;
    *to   = *from;
    *from = other;
    if (PAGE_ENCODING) {
        w->block_rank[*from] = (uint32_t)(from - list) + 1;
        w->block_rank[*to]   = (uint32_t)(to - list) + 1;
    }
    draw_block(w, *ref = *to, (int32_t)*base, x0, y0);
    return 1;
}

/* nodes ------------------------------------------------------------------------------------------------------------------------ */

/* What the node's slope adds to the depths of a tile; never negative. */
PAGE_INLINE int32_t slope_shift(int32_t nx, int32_t ny, int32_t tx, int32_t ty)
{
    return ((nx < 0 ? nx * (tx - 31) : nx * tx) + (ny < 0 ? ny * (ty - 31) : ny * ty)) >> 8;
}

/* The depths about a node: those of its neighbours in the page, or its base. */
static void open_borders(walk *w, const vxs_page_node *n, int32_t nx, int32_t ny)
{
    const vxs_page_scratch *s  = w->s;
    const uint32_t         *up = s->below_of[n->x % COLUMNS_KEPT], *side = s->right_of[n->y % COLUMNS_KEPT];
    int                     above = up[0] == n->map + 1 && up[1] == n->x && up[2] + 1 == n->y,
        left                      = side[0] == n->map + 1 && side[1] + 1 == n->x && side[2] == n->y;
    for (uint32_t k = 0; k < NODE_PX; k++) {
        int32_t a = s->below[n->x % COLUMNS_KEPT][k], l = s->right[n->y % COLUMNS_KEPT][k], t = (int32_t)(k >> 3);
        w->above[8 + k] = (int16_t)(!above ? 0 : a == (int16_t)NEVER ? a : a - n->base + slope_shift(nx, ny, t, 0));
        w->left[k]      = (int16_t)(!left ? 0 : l == (int16_t)NEVER ? l : l - n->base + slope_shift(nx, ny, 0, t));
    }
    for (uint32_t k = 0; k < 8; k++) {
        w->above[k]               = w->above[8];
        w->above[8 + NODE_PX + k] = w->above[7 + NODE_PX];
    }
}

static void close_borders(walk *w, const vxs_page_node *n, int32_t nx, int32_t ny)
{
    vxs_page_scratch *s  = w->s;
    uint32_t         *up = s->below_of[n->x % COLUMNS_KEPT], *side = s->right_of[n->y % COLUMNS_KEPT];
    up[0] = side[0] = n->map + 1;
    up[1] = side[1] = n->x;
    up[2] = side[2] = n->y;
    for (uint32_t k = 0; k < NODE_PX; k++) {
        int32_t a = w->above[8 + k], l = w->left[k], t = (int32_t)(k >> 3);
        s->below[n->x % COLUMNS_KEPT][k] = (int16_t)(a == (int16_t)NEVER ? a : a + n->base - slope_shift(nx, ny, t, 31));
        s->right[n->y % COLUMNS_KEPT][k] = (int16_t)(l == (int16_t)NEVER ? l : l + n->base - slope_shift(nx, ny, 31, t));
    }
}

static void code_slope(walk *w, int32_t *nx, int32_t *ny)
{
    page_odds *odds = w->odds;
    if (!code_flag(&w->c, &odds->same_slope, *nx == w->slope_x && *ny == w->slope_y)) {
        if (code_flag(&w->c, &odds->no_slope, !*nx && !*ny))
            *nx = *ny = 0;
        else {
            *nx = (int16_t)code_signed(&w->c, &odds->slope, *nx);
            *ny = (int16_t)code_signed(&w->c, &odds->slope, *ny);
        }
        w->slope_x = *nx;
        w->slope_y = *ny;
    }
    *nx = w->slope_x;
    *ny = w->slope_y;
}

/* A bit for each block: whether it is mixed. What the blocks above and on the left are is known; at the node's border, whether their
 * depths vary there. */
static uint64_t code_node_mixed(walk *w, uint64_t source)
{
    uint64_t mixed = 0;
    for (uint32_t n = 0; n < 16; n++) {
        uint32_t k = 0, x0 = n & 1 ? NODE_PX / 2 : 0, y0 = n / 2 * BLOCK_PX;
        if (n > 1) k = mixed >> (4 * n - 8) & 15;
        for (uint32_t x = 0; x < 4 && n < 2; x++) k |= varied(w->above + 8 + x0 + x * BLOCK_PX, BLOCK_PX) << x;
        k |= (n & 1 ? (uint32_t)(mixed >> (4 * n - 1) & 1) : varied(w->left + y0, BLOCK_PX)) << 4 | (n & 1) << 5;
        mixed |= (uint64_t)code_nibble(&w->c, &w->odds->node_mixed[k], source >> 4 * n & 15) << 4 * n;
    }
    return mixed;
}

/* Depth of a uniform block. last: of the uniform block before it. */
static uint32_t code_uniform_block(walk *w, int wide, uint32_t last, uint32_t depth, uint32_t x0, uint32_t y0)
{
    uint32_t left = (uint16_t)w->left[y0], above = (uint16_t)w->above[8 + x0], low = depth & 0xffff, high = 0, symbol = 0;
    uint32_t k =
        (left == above) | (uint32_t)((last & 0xffff) == left || (last & 0xffff) == above) << 1 | (uint32_t)(left == NEVER) << 2;
    if (PAGE_ENCODING) symbol = low == left ? 0 : low == above ? 1 : low == (last & 0xffff) ? 2 : low == NEVER ? 3 : 4;
    symbol = code_nibble(&w->c, &w->odds->depth_like[k], symbol);
    if (symbol >= 4) {
        uint32_t like = left != NEVER ? left : above != NEVER ? above : 0;
        low           = (like + (uint32_t)code_signed(&w->c, &w->odds->depth, (int16_t)(low - like))) & 0xffff;
    } else
        low = symbol == 0 ? left : symbol == 1 ? above : symbol == 2 ? last & 0xffff : NEVER;
    if (wide) high = code_number(&w->c, &w->odds->high, depth >> 16);
    return low | high << 16;
}

static int code_node(walk *w, const vxs_page_node *node)
{
    uint32_t start = w->word, from = 2 * node->offset;
    int32_t  nx = (int16_t)source_half(w, from + 8), ny = (int16_t)source_half(w, from + 9);
    uint64_t mixed = 0, fresh = 0;
    if (start != node->offset) return 0;
    if (PAGE_ENCODING) {
        for (uint32_t n = 0; n < 4; n++) {
            mixed |= (uint64_t)source_half(w, from + n) << 16 * n;
            fresh |= (uint64_t)source_half(w, from + 4 + n) << 16 * n;
        }
    }
    int wide = (int)code_flag(&w->c, &w->odds->wide, source_half(w, from + 10) & 1);
    code_slope(w, &nx, &ny);
    open_borders(w, node, nx, ny);
    mixed                = code_node_mixed(w, mixed);
    uint32_t mixed_count = count_bits((uint32_t)mixed) + count_bits((uint32_t)(mixed >> 32));
    uint32_t fresh_count =
        code_number(&w->c, &w->odds->fresh_count, count_bits((uint32_t)fresh) + count_bits((uint32_t)(fresh >> 32)));
    uint32_t size = wide ? 2 : 1;
    if (mixed_count + fresh_count > 64) return 0;
    uint32_t halves = NODE_HALVES + mixed_count + size * (mixed_count + fresh_count);
    if ((halves + 1) / 2 > w->node_words - start) return 0;
    w->word += (halves + 1) / 2;

    uint32_t ref_at = 2 * start + NODE_HALVES, base_at = ref_at + mixed_count, depth_at = base_at + size * mixed_count;
    uint32_t depth_end = depth_at + size * fresh_count, last = 0, met = 0;
    fresh = 0;
    for (uint32_t n = 0; n < 64; n++) {
        uint32_t x0 = n % 8 * BLOCK_PX, y0 = n / 8 * BLOCK_PX;
        if (mixed >> n & 1) {
            uint32_t at = from + (ref_at - 2 * start), ref = source_half(w, at), base_half = from + (base_at - 2 * start);
            uint32_t base = source_half(w, base_half) | (wide ? source_half(w, base_half + 1) << 16 : 0);
            if (!code_block_of(w, wide, x0, y0, &ref, &base)) return 0;
            put_half(w->words, ref_at++, ref);
            for (uint32_t k = 0; k < size; k++) put_half(w->words, base_at++, base >> 16 * k);
            continue;
        }
        uint32_t depth = 0;
        if (PAGE_ENCODING) {
            uint32_t fresh_here = source_half(w, from + 4 + n / 16) >> n % 16 & 1, at = from + (depth_at - 2 * start);
            depth = fresh_here ? source_half(w, at) | (wide ? source_half(w, at + 1) << 16 : 0) : last;
        }
        depth = code_uniform_block(w, wide, last, depth, x0, y0);
        draw_uniform(w, x0, y0, BLOCK_PX, (int16_t)depth);
        if (met && depth == last) continue;
        if (wide && depth >= DEPTH_END && depth != ~0u) return 0;
        if (depth_at == depth_end) return 0;
        for (uint32_t k = 0; k < size; k++) put_half(w->words, depth_at++, depth >> 16 * k);
        fresh |= (uint64_t)1 << n;
        last = depth;
        met  = 1;
    }
    if (depth_at != depth_end) return 0;
    for (uint32_t n = 0; n < 2; n++) {
        w->words[start + n]     = (uint32_t)(mixed >> 32 * n);
        w->words[start + 2 + n] = (uint32_t)(fresh >> 32 * n);
    }
    w->words[start + 4] = (uint16_t)nx | (uint32_t)(uint16_t)ny << 16;
    put_half(w->words, 2 * start + 10, (uint32_t)wide);
    close_borders(w, node, nx, ny);
    return 1;
}

/* All of a page: w says its size and what is known of it, its words are zeros. 0: this is no page. */
static int code_page(walk *w, const vxs_page_node *nodes, uint32_t node_count)
{
    *w->odds = w->s->start;
    memset(w->s->below_of, 0, sizeof w->s->below_of);
    memset(w->s->right_of, 0, sizeof w->s->right_of);
    w->half = 2 * w->node_words;
    for (uint32_t n = 0; n < node_count; n++)
        if (!code_node(w, &nodes[n])) return 0;
    return w->word == w->node_words && (w->half + 1) / 2 == w->word_count;
}

#endif
