/* Patterns of tiles; see patterns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/blocks/patterns.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/simd.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

/* Bits of a mask that are searched first: every other texel, so that what differs in any part of a tile is met. */
#define CHECKERS 0xa5a5a5a5u

enum { DARK, LIT, HALF_ROWS, MASK_ROWS = 2 * HALF_ROWS };

/* The two halves of a mask that a search compares: texels of one colour of a checkerboard, and those of the other. */
static void mask_halves(uint64_t mask, uint32_t half[2])
{
    uint32_t low = (uint32_t)mask, high = (uint32_t)(mask >> 32);
    half[0] = (low & CHECKERS) | (high & ~CHECKERS);
    half[1] = (low & ~CHECKERS) | (high & CHECKERS);
}

/* And back: the exchange undoes itself. */
static uint64_t mask_of_halves(uint32_t first, uint32_t second)
{
    uint32_t half[2];
    mask_halves((uint64_t)second << 32 | first, half);
    return (uint64_t)half[1] << 32 | half[0];
}

static uint32_t *needs_row(const pattern_class *c, int mask, int half, int which)
{
    return c->needs + (size_t)(MASK_ROWS * mask + HALF_ROWS * half + which) * c->capacity;
}

static vxs_result class_grow(pattern_class *c, int masks)
{
    pattern_class grown = {.count = c->count, .capacity = c->capacity ? 2 * c->capacity : 64};
    grown.ids           = malloc(grown.capacity * sizeof *grown.ids);
    grown.needs         = malloc((size_t)MASK_ROWS * (size_t)masks * grown.capacity * sizeof *grown.needs);
    if (!grown.ids || !grown.needs) {
        free(grown.ids);
        free(grown.needs);
        return VXS_E_MEMORY;
    }
    if (c->count) {
        memcpy(grown.ids, c->ids, c->count * sizeof *c->ids);
        for (int row = 0; row < MASK_ROWS * masks; row++)
            memcpy(grown.needs + (size_t)row * grown.capacity, c->needs + (size_t)row * c->capacity, c->count * sizeof *c->needs);
    }
    free(c->ids);
    free(c->needs);
    *c = grown;
    return VXS_OK;
}

/* The needs of a tile as halves: [mask][half][DARK or LIT]. */
typedef uint32_t tile_needs[PALETTE_MAX - 1][2][2];

/* Whether nothing that either needs contradicts the other. */
static int agrees(const pattern_class *c, size_t at, const tile_needs t, int masks)
{
    uint32_t against = 0;
    for (int mask = 0; mask < masks && !against; mask++)
        for (int half = 0; half < 2; half++)
            against |= (needs_row(c, mask, half, DARK)[at] & t[mask][half][LIT]) |
                       (needs_row(c, mask, half, LIT)[at] & t[mask][half][DARK]);
    return !against;
}

static void swap_u32(uint32_t *a, uint32_t *b)
{
    uint32_t was = *a;
    *a           = *b;
    *b           = was;
}

/* The pattern at `at` takes on what a tile needs, and moves halfway to where searches begin: what is used often is found soon. */
static uint32_t take(pattern_class *c, size_t at, const tile_needs t, int masks)
{
    size_t   to = at + (c->count - at) / 2;
    uint32_t id = c->ids[at];
    swap_u32(&c->ids[at], &c->ids[to]);
    for (int mask = 0; mask < masks; mask++)
        for (int half = 0; half < 2; half++)
            for (int which = DARK; which <= LIT; which++) {
                uint32_t *row = needs_row(c, mask, half, which);
                row[at] |= t[mask][half][which];
                swap_u32(&row[at], &row[to]);
            }
    return id;
}

/* Which of the 16 patterns from `from` on agree in one half of one mask. */
typedef uint32_t find_agreeing(const uint32_t *dark, const uint32_t *lit, size_t from, uint32_t must_dark, uint32_t must_lit);

static ALWAYS_INLINE uint32_t agreeing(const uint32_t *dark, const uint32_t *lit, size_t from, uint32_t must_dark,
                                       uint32_t must_lit)
{
    u32x4 against[4], d = u32x4_all(must_dark), l = u32x4_all(must_lit);
    for (size_t n = 0; n < 4; n++) against[n] = (u32x4_load(dark + from + 4 * n) & l) | (u32x4_load(lit + from + 4 * n) & d);
    return u32x4_zeros(against);
}

/* The place of a pattern that agrees in all, or the count: none. The half that needs most is looked at first, 16 patterns at a time. */
static ALWAYS_INLINE size_t search_by(find_agreeing *find, const pattern_class *c, const tile_needs t, int masks)
{
    int mask = 0, half = 0, most = -1;
    for (int m = 0; m < masks; m++)
        for (int h = 0; h < 2; h++) {
            int bits = __builtin_popcount(t[m][h][DARK] | t[m][h][LIT]);
            if (bits <= most) continue;
            most = bits;
            mask = m;
            half = h;
        }
    const uint32_t *dark = needs_row(c, mask, half, DARK), *lit = needs_row(c, mask, half, LIT);
    uint32_t        must_dark = t[mask][half][DARK], must_lit = t[mask][half][LIT];
    size_t          stop = c->count > PATTERN_WINDOW ? c->count - PATTERN_WINDOW : 0;
    for (size_t end = c->count; end > stop;) {
        size_t   from = end >= stop + 16 ? end - 16 : end - 1;
        uint32_t hits =
            end >= stop + 16 ? find(dark, lit, from, must_dark, must_lit) : !((dark[from] & must_lit) | (lit[from] & must_dark));
        while (hits) {
            uint32_t last = 31 - (uint32_t)__builtin_clz(hits);
            if (agrees(c, from + last, t, masks)) return from + last;
            hits ^= 1u << last;
        }
        end = from;
    }
    return c->count;
}

static size_t search_plain(const pattern_class *c, const tile_needs t, int masks)
{
    return search_by(agreeing, c, t, masks);
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE uint32_t agreeing_avx2(const uint32_t *dark, const uint32_t *lit, size_t from,
                                                            uint32_t must_dark, uint32_t must_lit)
{
    const __m256i d = _mm256_set1_epi32((int)must_dark), l = _mm256_set1_epi32((int)must_lit), zero = _mm256_setzero_si256();
    uint32_t      hits = 0;
    for (size_t n = 0; n < 16; n += 8) {
        __m256i is_dark = _mm256_loadu_si256((const __m256i *)(const void *)(dark + from + n));
        __m256i is_lit  = _mm256_loadu_si256((const __m256i *)(const void *)(lit + from + n));
        __m256i against = _mm256_or_si256(_mm256_and_si256(is_dark, l), _mm256_and_si256(is_lit, d));
        hits |= (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(against, zero))) << n;
    }
    return hits;
}

CPU_TARGET_AVX2 static size_t search_avx2(const pattern_class *c, const tile_needs t, int masks)
{
    return search_by(agreeing_avx2, c, t, masks);
}

CPU_TARGET_AVX512 static ALWAYS_INLINE uint32_t agreeing_avx512(const uint32_t *dark, const uint32_t *lit, size_t from,
                                                                uint32_t must_dark, uint32_t must_lit)
{
    __m512i is_dark = _mm512_loadu_si512(dark + from), is_lit = _mm512_loadu_si512(lit + from);
    __m512i against = _mm512_or_si512(_mm512_and_si512(is_dark, _mm512_set1_epi32((int)must_lit)),
                                      _mm512_and_si512(is_lit, _mm512_set1_epi32((int)must_dark)));
    return _mm512_testn_epi32_mask(against, against);
}

CPU_TARGET_AVX512 static size_t search_avx512(const pattern_class *c, const tile_needs t, int masks)
{
    return search_by(agreeing_avx512, c, t, masks);
}

#endif

static size_t search(int cpu, const pattern_class *c, const tile_needs t, int masks)
{
#ifdef __x86_64__
    if (cpu == CPU_AVX512) return search_avx512(c, t, masks);
    if (cpu == CPU_AVX2) return search_avx2(c, t, masks);
#endif
    (void)cpu;
    return search_plain(c, t, masks);
}

static void halves_of_needs(tile_needs t, const mask_need *needs, int masks)
{
    for (int mask = 0; mask < masks; mask++) {
        uint32_t dark[2], lit[2];
        mask_halves(needs[mask].dark, dark);
        mask_halves(needs[mask].lit, lit);
        for (int half = 0; half < 2; half++) {
            t[mask][half][DARK] = dark[half];
            t[mask][half][LIT]  = lit[half];
        }
    }
}

/* One more pattern, where searches begin. */
static vxs_result append(pattern_class *c, const tile_needs t, int masks, uint32_t id)
{
    if (c->count == c->capacity && class_grow(c, masks) != VXS_OK) return VXS_E_MEMORY;
    for (int mask = 0; mask < masks; mask++)
        for (int half = 0; half < 2; half++)
            for (int which = DARK; which <= LIT; which++) needs_row(c, mask, half, which)[c->count] = t[mask][half][which];
    c->ids[c->count++] = id;
    return VXS_OK;
}

vxs_result pattern_find(pattern_set *s, int depths, const mask_need *needs, uint32_t *id)
{
    pattern_class *c     = &s->by_depths[depths];
    int            masks = depths - 1;
    tile_needs     t;
    halves_of_needs(t, needs, masks);
    size_t at = c->count ? search(s->cpu, c, t, masks) : 0;
    if (at < c->count) {
        *id = take(c, at, t, masks);
        return VXS_OK;
    }
    *id = s->count;
    if (append(c, t, masks, *id) != VXS_OK) return VXS_E_MEMORY;
    s->count++;
    return VXS_OK;
}

vxs_result pattern_put(pattern_set *s, int depths, const mask_need *needs, uint32_t id)
{
    tile_needs t;
    halves_of_needs(t, needs, depths - 1);
    s->count++;
    return append(&s->by_depths[depths], t, depths - 1, id);
}

void pattern_needs(const pattern_set *s, int depths, size_t n, mask_need *needs)
{
    const pattern_class *c = &s->by_depths[depths];
    for (int mask = 0; mask < depths - 1; mask++) {
        needs[mask].dark = mask_of_halves(needs_row(c, mask, 0, DARK)[n], needs_row(c, mask, 1, DARK)[n]);
        needs[mask].lit  = mask_of_halves(needs_row(c, mask, 0, LIT)[n], needs_row(c, mask, 1, LIT)[n]);
    }
}

/* choosing -------------------------------------------------------------------------------------------------------------------- */

/* The fewest depths that each quadrant can do with, by piercing its ranges from the front: a depth is used where a range ends at it that has
 * none yet, and all that have none take it, if they may.
 * used  [out] the bits of those of each quadrant;   index  [out] [64] of each texel */
static void choose_in_quadrants(const uint8_t low[64], const uint8_t high[64], uint64_t used[4], uint8_t index[64])
{
    uint64_t left = UINT64_MAX;
    for (int q = 0; q < 4; q++) used[q] = 0;
    for (int depth = 0; left; depth++) {
        uint64_t due = left & bytes_at_most(high, (uint8_t)depth);
        if (!due) continue;
        uint64_t may = left & bytes_at_most(low, (uint8_t)depth);
        for (int q = 0; q < 4; q++) {
            uint64_t quadrant = 0xffffull << 16 * q;
            if (!(due & quadrant)) continue;
            used[q] |= 1ull << depth;
            left &= ~(may & quadrant);
            for (uint64_t rest = may & quadrant; rest; rest &= rest - 1) index[__builtin_ctzll(rest)] = (uint8_t)depth;
        }
    }
}

/* A texel takes the depth of a neighbour that was met before, where it may and its quadrant uses it: masks get plain outlines. */
static void follow_neighbours(const uint8_t *low, const uint8_t *high, const uint64_t used[4], uint8_t *index)
{
    static const int beside[4][2] = {{-1, 0}, {0, -1}, {-1, -1}, {1, -1}};
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            int n = pattern_texel(x, y);
            if (low[n] == high[n]) continue;
            for (int b = 0; b < 4; b++) {
                int from_x = x + beside[b][0], from_y = y + beside[b][1];
                if (from_x < 0 || from_x > 7 || from_y < 0) continue;
                int other = index[pattern_texel(from_x, from_y)];
                if (other < low[n] || other > high[n] || !(used[n >> 4] >> other & 1)) continue;
                index[n] = (uint8_t)other;
                break;
            }
        }
}

void pattern_choose_within(const uint8_t low[64], const uint8_t high[64], uint8_t index[64])
{
    uint64_t used[4];
    choose_in_quadrants(low, high, used, index);
    follow_neighbours(low, high, used, index);
}

void pattern_choose(const mask_need *needs, int depths, uint8_t index[64])
{
    uint8_t low[64] = {0}, high[64];
    memset(high, depths - 1, sizeof high);
    for (int mask = 0; mask < depths - 1; mask++)
        for (int n = 0; n < 64; n++) {
            low[n]  = (uint8_t)(low[n] + (needs[mask].lit >> n & 1));
            high[n] = (uint8_t)(high[n] - (needs[mask].dark >> n & 1));
        }
    pattern_choose_within(low, high, index);
}

void pattern_set_free(pattern_set *s)
{
    for (int p = 0; p <= PALETTE_MAX; p++) {
        free(s->by_depths[p].ids);
        free(s->by_depths[p].needs);
    }
    memset(s, 0, sizeof *s);
}
