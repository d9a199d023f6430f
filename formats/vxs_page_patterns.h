/* Patterns: the palette index of each texel of a tile.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_PATTERNS_H
#define VXS_PAGE_PATTERNS_H

#include "vxs_page_borders.h"

/* Eight bits to eight bytes of 0 or 1. */
PAGE_INLINE uint64_t bytes_of_bits(uint32_t bits)
{
    uint64_t low = bits & 15, high = bits >> 4;
    return (low * 0x00204081 & 0x01010101) | (high * 0x00204081 & 0x01010101) << 32;
}

/* Indices of an unchecked pattern of the source, quadrant by quadrant. 0: invalid.   half  where its states, or its image, start */
static int read_source(const walk *w, uint32_t half, uint32_t depths, uint8_t *index)
{
    uint32_t own = half + depths / 2, none = 0;
    if ((source_half(w, half) & 0xff) == 0xff) {
        for (uint32_t z = 0; z < 64; z++) {
            uint32_t byte = 2 + (z & 31);
            index[z]      = source_half(w, half + byte / 2) >> (8 * (byte & 1) + (z >> 5) * 4) & 15;
            none |= index[z] >= depths;
        }
        return !none;
    }
    for (uint32_t c = 0; c < 4; c++) {
        uint32_t last = 0;
        uint64_t low = 0, high = 0;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            uint32_t state = source_half(w, half + n / 2) >> (8 * (n & 1) + 2 * c) & 3;
            if (state == 2) last = source_half(w, own++);
            uint32_t beyond = ~(state < 2 ? 0 - state : last); /* texels of a later depth */
            low += bytes_of_bits(beyond & 255);
            high += bytes_of_bits(beyond >> 8 & 255);
        }
        vxs_store64(index + 16 * c, low);
        vxs_store64(index + 16 * c + 8, high);
    }
    return 1;
}

/* Four bits to four nibbles of 0 or 1. */
PAGE_INLINE uint32_t nibbles_of_bits(uint32_t bits)
{
    return (bits | bits << 3 | bits << 6 | bits << 9) & 0x1111;
}

/* Eight bytes below 16 to eight nibbles. */
PAGE_INLINE uint32_t nibbles_of_bytes(uint64_t x)
{
    x = (x | x >> 4) & 0x00ff00ff00ff00ff;
    x = (x | x >> 8) & 0x0000ffff0000ffff;
    return (uint32_t)(x | x >> 16);
}

/* border_of, for known indices. */
PAGE_INLINE uint64_t border_of_indices(const uint8_t *index)
{
    uint64_t row = vxs_load32(index + 44) | (uint64_t)vxs_load32(index + 60) << 32, column = 0;
    for (uint32_t n = 0; n < 4; n++) column |= (index[19 + 4 * n] | (uint64_t)index[51 + 4 * n] << 32) << 8 * n;
    return nibbles_of_bytes(row) | (uint64_t)nibbles_of_bytes(column) << 32;
}

/* border_of, for a pattern stored as nibbles that start at a byte. */
static uint64_t border_of_image(const uint32_t *words, uint32_t byte)
{
    uint32_t row = 0, column = 0;
    for (uint32_t n = 0; n < 4; n++) {
        uint32_t right = get_byte(words, byte + 19 + 4 * n);
        row |= get_byte(words, byte + 12 + n) >> 4 << 4 * n | get_byte(words, byte + 28 + n) >> 4 << (16 + 4 * n);
        column |= (right & 15) << 4 * n | right >> 4 << (16 + 4 * n);
    }
    return row | (uint64_t)column << 32;
}

/* Indices in the last row (low half) and the last column of a valid pattern, a nibble each, as from read_source. There are
 * no branches on states, because they are hard to predict. */
static uint64_t border_of(const uint32_t *words, uint32_t half, uint32_t depths)
{
    uint32_t row[4], column[4], own = half + depths / 2 - 1; /* row, column: of each quadrant; own: the last stored half */
    if (get_byte(words, 2 * half) == 0xff) return border_of_image(words, 2 * half + 2);
    for (uint32_t n = 0; n + 1 < depths; n++) own += (get_byte(words, 2 * half + n) & 3) == 2; /* the first one has no border */
    for (uint32_t c = 1; c < 4; c++) {
        row[c] = column[c] = 0;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            uint32_t state = get_byte(words, 2 * half + n) >> 2 * c & 3;
            own += state == 2;
            /* texels of a later depth */
            uint32_t beyond = ~(get_half(words, own) | (0 - (uint32_t)(state == 1))) | (0 - (uint32_t)(state == 0));
            row[c] += nibbles_of_bits(beyond >> 12 & 15);
            column[c] += beyond >> 3 & 0x1111;
        }
    }
    return row[2] | row[3] << 16 | (uint64_t)(column[1] | column[3] << 16) << 32;
}

/* Border of the pattern of a reference, cached: most patterns are used again soon.   half  where its states, or its image, start */
PAGE_CALL uint64_t border_of_ref(walk *w, uint32_t ref, uint32_t half, uint32_t depths)
{
    vxs_page_scratch *s  = w->s;
    uint32_t          at = ref % BORDERS_KEPT;
    if (s->border_ref[at] != ref + 1) {
        s->border_ref[at] = ref + 1;
        s->border[at]     = border_of(pool_of(w, ref), half, depths);
    }
    return s->border[at];
}

/* Cache the border of a new pattern. */
PAGE_INLINE void keep_border(walk *w, uint32_t ref, const uint8_t *index)
{
    w->s->border_ref[ref % BORDERS_KEPT] = ref + 1;
    w->s->border[ref % BORDERS_KEPT]     = border_of_indices(index);
}

/* Texels whose index is at most n: a bit for each, quadrant by quadrant.   n  below 15 */
PAGE_INLINE uint64_t texels_up_to(const uint8_t *index, uint32_t n)
{
    uint64_t texels = 0;
#ifdef PAGE_SSE2
    const __m128i *four = (const __m128i *)index, end = _mm_set1_epi8((char)(n + 1));
    for (uint32_t c = 0; c < 4; c++) texels |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_cmpgt_epi8(end, four[c])) << 16 * c;
#else
    for (uint32_t z = 0; z < 64; z++) texels |= (uint64_t)(index[z] <= n) << z;
#endif
    return texels;
}

/* The highest bit of each 16: whether they are not all 0. */
PAGE_INLINE uint64_t sixteens_set(uint64_t x)
{
    const uint64_t low = 0x7fff7fff7fff7fff;
    return (((x & low) + low) | x) & ~low;
}

/* Write a pattern at w->half, as masks or as an image, whichever is shorter. 0: no room.
 * All quadrants of a mask at once, and no branches on states, which are hard to predict. */
static int put_pattern(walk *w, const uint8_t *index, uint32_t depths)
{
    enum { WORDS = INDEX_HALVES / 2 + 1 };            /* that a pattern may touch */
    uint64_t  texels[DEPTHS_MAX], last = 0, owns = 0; /* owns: bit n of a quadrant: its mask n is stored */
    uint8_t   bytes[4 * WORDS] = {0}, *at = bytes + 2 * (w->half & 1);
    uint32_t *to = w->words + w->half / 2, count = w->word_count - w->half / 2, states = depths / 2;
    for (uint32_t n = 0; n + 1 < depths; n++) {
        uint64_t now = texels[n] = texels_up_to(index, n), some = sixteens_set(now), less = sixteens_set(~now);
        uint64_t fresh = sixteens_set(now ^ last) & less, state = (some & less) >> 14 | (some & ~fresh) >> 15;
        at[n] = (uint8_t)(state | state >> 14 | state >> 28 | state >> 42);
        owns |= fresh >> (15 - n);
        last = now;
    }
    uint32_t size = states + count_bits((uint32_t)owns) + count_bits((uint32_t)(owns >> 32));
    if (size > INDEX_HALVES) {
        size = INDEX_HALVES;
        vxs_store16(at, 0xff);
        for (uint32_t n = 0; n < 32; n++) at[2 + n] = (uint8_t)(index[n] | index[n + 32] << 4);
    } else
        for (at += 2 * states; owns; owns &= owns - 1, at += 2) {
            uint32_t own = page_first_bit_64(owns);
            vxs_store16(at, (uint16_t)(texels[own % 16] >> own / 16 * 16));
        }
    if (size > 2 * w->word_count - w->half) return 0;
    for (uint32_t n = 0; n < (count < WORDS ? count : WORDS); n++) to[n] |= vxs_load32(bytes + 4 * n);
    w->half += size;
    return 1;
}

/* Palette indices of the texels around a tile, a byte each. */
typedef struct around {
    uint64_t above, left;
    uint32_t corner, right; /* of the texels before those above, and behind them */
} around;

/* The index of the nearest depth of its pattern.
 * depth  [depths] ascending */
static around indices_around(const walk *w, const int16_t *depth, uint32_t depths, uint32_t x0, uint32_t y0)
{
    const int16_t *above = w->above + 8 + x0, *left = w->left + y0;
    around         to = {0};
#ifdef PAGE_SSE2
    const __m128i zero = _mm_set1_epi16(depth[0]), none = _mm_setzero_si128();
    __m128i       a = _mm_sub_epi16(_mm_load_si128((const __m128i *)above), zero), n = none, m = none;
    __m128i       c = _mm_sub_epi16(_mm_load_si128((const __m128i *)left), zero);
    __m128i       e = _mm_sub_epi16(_mm_insert_epi16(_mm_cvtsi32_si128((uint16_t)above[-1]), above[8], 1), zero);
    for (uint32_t k = 0; k + 1 < depths; k++) {
        uint32_t between = (uint32_t)(uint16_t)(depth[k] - depth[0]) + (uint16_t)(depth[k + 1] - depth[0]);
        __m128i  t       = _mm_set1_epi16((int16_t)(between >> 1));
        n                = _mm_sub_epi8(n, _mm_packs_epi16(_mm_cmpgt_epi16(a, t), _mm_cmpgt_epi16(c, t)));
        m                = _mm_sub_epi16(m, _mm_cmpgt_epi16(e, t));
    }
    _mm_storel_epi64((__m128i *)&to.above, n);
    _mm_storel_epi64((__m128i *)&to.left, _mm_unpackhi_epi64(n, n));
    to.corner = (uint32_t)_mm_extract_epi16(m, 0);
    to.right  = (uint32_t)_mm_extract_epi16(m, 1);
#else
    uint8_t row[10] = {0}, column[8] = {0};
    for (uint32_t k = 0; k + 1 < depths; k++) {
        uint32_t between = (uint32_t)(uint16_t)(depth[k] - depth[0]) + (uint16_t)(depth[k + 1] - depth[0]);
        int16_t  t       = (int16_t)(between >> 1);
        for (int n = 0; n < 10; n++) row[n] += (int16_t)(above[n - 1] - depth[0]) > t;
        for (int n = 0; n < 8; n++) column[n] += (int16_t)(left[n] - depth[0]) > t;
    }
    to = (around){vxs_load64(row + 1), vxs_load64(column), row[0], row[9]};
#endif
    return to;
}

/* A bit for each of eight bytes: whether it is not 0. Bytes are below 128. */
PAGE_INLINE uint32_t bytes_set(uint64_t x)
{
    x = (x + 0x7f7f7f7f7f7f7f7f) >> 7 & 0x0101010101010101;
    return (uint32_t)(x * 0x0102040810204080 >> 56);
}

/* Index of a texel that differs from N, the one above it; W is on its left, NE on the right of N. There are no branches on
 * indices, because they are unpredictable. W may be the texel coded last, so whatever depends on it is short. */
PAGE_INLINE uint32_t code_other(coder *c, nibble_odds odds[5][3], nibble_odds *far, uint32_t depths, uint32_t value, uint32_t W,
                                uint32_t N, uint32_t NE)
{
    uint32_t     end = (uint32_t)(N != 0) + (uint32_t)(N + 1 == depths), flat = (uint32_t)(N == NE), symbol = 0;
    nibble_odds *by = odds[4 - 2 * flat] + end, *as_NE = odds[3] + end, *as_N = odds[1 - flat] + end;
    if (PAGE_ENCODING) {
        uint32_t step = value > N ? 2 * (value - N) : 1 + 2 * (N - value);
        symbol        = value == W ? 0 : value == NE ? 1 : step < 15 ? step : 15;
    }
    by     = W == NE ? as_NE : by;
    by     = W == N ? as_N : by;
    symbol = code_nibble_here(c, by, symbol);
    if (symbol == 15) return code_nibble_here(c, far, value);
    uint32_t odd = 0 - (symbol & 1), step = N + ((symbol >> 1) ^ odd) - odd, beside = W ^ ((W ^ NE) & odd);
    return step ^ ((step ^ beside) & (0 - (uint32_t)(symbol < 2)));
}

/* The indices of the texels of a pattern, row by row: first which texels differ from the one above, four per nibble, then
 * the index of each of these. 0: invalid index.
 * o  indices beside the tile */
static int code_indices(walk *w, around o, uint32_t depths, uint8_t *index)
{
    coder        c    = w->c; /* a local copy can stay in registers */
    page_odds   *odds = w->odds;
    nibble_odds *far = &odds->far, (*other)[3] = odds->other[depths < 4 ? 0 : depths < 6 ? 1 : depths < 9 ? 2 : 3];
    uint64_t     last   = o.above; /* the row above: a byte per texel */
    uint32_t     corner = o.corner, right = o.right, differs = 0;
    for (uint32_t y = 0; y < 8; y++, o.left >>= 8) {
        uint32_t     left = o.left & 255, side = left != corner;
        uint32_t     beside = bytes_set(last ^ (last << 8 | corner)) | (uint32_t)(right != last >> 56) << 8;
        nibble_odds *by     = odds->differs[depths > 2][y != 0];
        uint8_t     *texels = index + 32 * (y >> 2) + 4 * (y & 3), row[16];
        uint64_t     now = last, value = PAGE_ENCODING ? vxs_load32(texels) | (uint64_t)vxs_load32(texels + 16) << 32 : 0;
        /* differs is still that of the row above */
        nibble_odds *low  = by + ((beside & 31) | side << 5 | (uint32_t)((differs & 15) != 0) << 6),
                    *high = by + (beside >> 4 | (uint32_t)(differs >> 4 != 0) << 6);
        differs           = code_two_nibbles(&c, low, high, 1 << 5, PAGE_ENCODING ? bytes_set(last ^ value) : 0);
        if (depths == 2)
            now ^= bytes_of_bits(differs);
        else {
            row[0] = (uint8_t)left; /* left of each texel, unless it differs from the one above, and above, and behind */
            vxs_store64(row + 1, last);
            row[9] = (uint8_t)right;
            for (uint32_t rest = differs, got = left, next = 0; rest; rest &= rest - 1) {
                uint32_t x = page_first_bit(rest), W = row[x], N = row[x + 1];
                got = code_other(&c, other, far, depths, value >> 8 * x & 255, x == next ? got : W, N, row[x + 2]);
                if (got >= depths) return 0;
                now ^= (uint64_t)(N ^ got) << 8 * x;
                next = x + 1;
            }
        }
        vxs_store32(texels, (uint32_t)now);
        vxs_store32(texels + 16, (uint32_t)(now >> 32));
        last   = now;
        corner = left;
        right  = (uint32_t)(now >> 56); /* nothing is known on the right of the tile */
    }
    w->c = c;
    return 1;
}

static int code_image(walk *w, const int16_t *depth, uint32_t depths, uint32_t x0, uint32_t y0, uint8_t *index)
{
    return code_indices(w, indices_around(w, depth, depths, x0, y0), depths, index);
}

#endif
