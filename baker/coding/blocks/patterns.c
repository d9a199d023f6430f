/* Patterns of tiles; see patterns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/patterns.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/simd.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

enum { DARK, LIT, MASK_ROWS };

/* Rows of a mask, DARK and LIT, `capacity` apart. */
static uint64_t *mask_rows(const pattern_class *c, int mask)
{
    return c->needs + (size_t)(MASK_ROWS * mask) * c->capacity;
}

static void swap_u64(uint64_t *a, uint64_t *b)
{
    uint64_t was = *a;
    *a           = *b;
    *b           = was;
}

/* Add a tile's needs to the pattern at `at`, and move it halfway to where searches begin, so that frequent patterns are found
 * fast. */
static uint32_t take(pattern_class *c, size_t at, const mask_need *needs, int masks)
{
    size_t   to = at + (c->count - at) / 2;
    uint32_t id = c->ids[at];
    c->ids[at]  = c->ids[to];
    c->ids[to]  = id;
    for (int mask = 0; mask < masks; mask++) {
        uint64_t *dark = mask_rows(c, mask), *lit = dark + c->capacity;
        dark[at] |= needs[mask].dark;
        lit[at] |= needs[mask].lit;
        swap_u64(&dark[at], &dark[to]);
        swap_u64(&lit[at], &lit[to]);
    }
    return id;
}

/* Which of 16 patterns agree with the needs of a mask, from their rows. Bits of places behind the last pattern are undefined. */
typedef uint32_t find_agreeing(const uint64_t *dark, const uint64_t *lit, mask_need need);

static ALWAYS_INLINE uint32_t agreeing(const uint64_t *dark, const uint64_t *lit, mask_need need)
{
    u64x2 against[8];
    for (size_t n = 0; n < 8; n++)
        against[n] = (u64x2_load(dark + 2 * n) & u64x2_all(need.lit)) | (u64x2_load(lit + 2 * n) & u64x2_all(need.dark));
    return u64x2_zeros(against);
}

/* Search places [stop, end) from the last, 16 at a time, for patterns that agree with the needs of a mask.   from  [out] first
 * of the 16
 * Returns the bits of those that agree; 0: none. */
static ALWAYS_INLINE uint32_t last_agreeing(find_agreeing *find, const uint64_t *dark, const uint64_t *lit, mask_need need,
                                            size_t stop, size_t end, size_t *from)
{
    while (end >= stop + 16) {
        end -= 16;
        uint32_t hits = find(dark + end, lit + end, need);
        *from         = end;
        if (hits) return hits;
    }
    *from = stop;
    return end > stop ? find(dark + stop, lit + stop, need) & ((1u << (end - stop)) - 1) : 0;
}

/* The last pattern that agrees in all masks, or the count: none. Compares 16 patterns at a time, mask by mask. */
static ALWAYS_INLINE size_t search_by(find_agreeing *find, const pattern_class *c, const mask_need *needs, int masks)
{
    /* the mask with the most needs is compared first */
    int first = 0, most = -1;
    for (int mask = 0; mask < masks; mask++) {
        int bits = __builtin_popcountll(needs[mask].dark | needs[mask].lit);
        if (bits <= most) continue;
        most  = bits;
        first = mask;
    }

    const size_t    stop = c->count > PATTERN_WINDOW ? c->count - PATTERN_WINDOW : 0;
    const uint64_t *dark = mask_rows(c, first), *lit = dark + c->capacity;
    for (size_t end = c->count, from; end > stop; end = from) {
        uint32_t hits = last_agreeing(find, dark, lit, needs[first], stop, end, &from);
        for (int mask = 0; mask < masks && hits; mask++)
            if (mask != first) hits &= find(mask_rows(c, mask) + from, mask_rows(c, mask) + c->capacity + from, needs[mask]);
        if (hits) return from + 31 - (size_t)__builtin_clz(hits);
    }
    return c->count;
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE uint32_t agreeing_avx2(const uint64_t *dark, const uint64_t *lit, mask_need need)
{
    const __m256i d = _mm256_set1_epi64x((long long)need.dark), l = _mm256_set1_epi64x((long long)need.lit);
    const __m256i zero = _mm256_setzero_si256();
    uint32_t      hits = 0;
    for (size_t n = 0; n < 16; n += 4) {
        __m256i is_dark = _mm256_loadu_si256((const __m256i *)(const void *)(dark + n));
        __m256i is_lit  = _mm256_loadu_si256((const __m256i *)(const void *)(lit + n));
        __m256i against = _mm256_or_si256(_mm256_and_si256(is_dark, l), _mm256_and_si256(is_lit, d));
        hits |= (uint32_t)_mm256_movemask_pd(_mm256_castsi256_pd(_mm256_cmpeq_epi64(against, zero))) << n;
    }
    return hits;
}

CPU_TARGET_AVX2 static size_t search_avx2(const pattern_class *c, const mask_need *needs, int masks)
{
    return search_by(agreeing_avx2, c, needs, masks);
}

#endif

static size_t search(int cpu, const pattern_class *c, const mask_need *needs, int masks)
{
#ifdef __x86_64__
    if (cpu >= CPU_AVX2) return search_avx2(c, needs, masks);
#endif
    (void)cpu;
    return search_by(agreeing, c, needs, masks);
}

/* Append a pattern, where searches begin. */
static vxs_result append(pattern_class *c, const mask_need *needs, int masks, uint32_t id)
{
    if (c->count == c->capacity) {
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
                memcpy(grown.needs + (size_t)row * grown.capacity, c->needs + (size_t)row * c->capacity,
                       c->count * sizeof *c->needs);
        }
        free(c->ids);
        free(c->needs);
        *c = grown;
    }
    for (int mask = 0; mask < masks; mask++) {
        uint64_t *dark               = mask_rows(c, mask);
        dark[c->count]               = needs[mask].dark;
        dark[c->capacity + c->count] = needs[mask].lit;
    }
    c->ids[c->count++] = id;
    return VXS_OK;
}

vxs_result pattern_find(pattern_set *s, int depths, const mask_need *needs, uint32_t *id)
{
    pattern_class *c     = &s->by_depths[depths];
    int            masks = depths - 1;
    size_t         at    = c->count ? search(s->cpu, c, needs, masks) : 0;
    if (at < c->count) {
        *id = take(c, at, needs, masks);
        return VXS_OK;
    }
    *id = s->count;
    if (append(c, needs, masks, *id) != VXS_OK) return VXS_E_MEMORY;
    s->count++;
    return VXS_OK;
}

vxs_result pattern_put(pattern_set *s, int depths, const mask_need *needs, uint32_t id)
{
    s->count++;
    return append(&s->by_depths[depths], needs, depths - 1, id);
}

void pattern_needs(const pattern_set *s, int depths, size_t n, mask_need *needs)
{
    const pattern_class *c = &s->by_depths[depths];
    for (int mask = 0; mask < depths - 1; mask++) {
        const uint64_t *dark = mask_rows(c, mask);
        needs[mask]          = (mask_need){dark[n], dark[c->capacity + n]};
    }
}

/* choosing -------------------------------------------------------------------------------------------------------------------- */

/* All texels of the quadrants that have one of these. */
static uint64_t whole_quadrants(uint64_t texels)
{
    const uint64_t tops = 0x8000800080008000;
    uint64_t       any  = (((texels & ~tops) + ~tops) | texels) & tops;
    return any | (any - (any >> 15));
}

/* Add 1 to the bytes of these texels. */
static void count_texels(uint64_t bytes[8], uint64_t texels)
{
    for (int n = 0; n < 8; n++) {
        uint64_t bit = ((texels >> 8 * n & 0xff) * 0x0101010101010101) & 0x8040201008040201; /* bit k stays in byte k */
        bytes[n] += (bit + 0x7f7f7f7f7f7f7f7f) >> 7 & 0x0101010101010101;
    }
}

/* may, due  [depths] texels that may and that must have one of the depths up to each; the last must have all */
static void choose(const uint64_t *may, const uint64_t *due, int depths, uint8_t index[64])
{
    /* The fewest depths for each quadrant, by stabbing its ranges from the front: where a range without a depth ends, its last
     * depth is used, and all ranges without a depth that contain it take it. */
    uint64_t allowed[64]; /* texels for which each depth is in range and used in their quadrant */
    uint64_t left = UINT64_MAX, before = 0, once = 0, several = 0, bytes[8] = {0};
    for (int depth = 0; depth < depths; depth++) {
        uint64_t quadrants = whole_quadrants(left & due[depth]);
        left &= ~(may[depth] & quadrants);
        allowed[depth] = may[depth] & ~before & quadrants;
        before         = due[depth];
        several |= once & allowed[depth];
        once |= allowed[depth];
        if (left) count_texels(bytes, left);
    }
    for (int n = 0; n < 64; n++) index[n] = (uint8_t)(bytes[n / 8] >> 8 * (n % 8));

    /* Give a texel the depth of an earlier neighbour if it is allowed: masks get simple outlines. */
    static const int beside[4][2] = {{-1, 0}, {0, -1}, {-1, -1}, {1, -1}};
    for (int y = 0; y < 8; y++) {
        int      at  = pattern_texel(0, y);
        uint32_t row = (uint32_t)(several >> at & 15) | (uint32_t)(several >> at >> 16 & 15) << 4;
        for (; row; row &= row - 1) {
            int x = __builtin_ctz(row), n = pattern_texel(x, y);
            for (int b = 0; b < 4; b++) {
                int from_x = x + beside[b][0], from_y = y + beside[b][1];
                if (from_x < 0 || from_x > 7 || from_y < 0) continue;
                int other = index[pattern_texel(from_x, from_y)];
                if (!(allowed[other] >> n & 1)) continue;
                index[n] = (uint8_t)other;
                break;
            }
        }
    }
}

void pattern_choose_within(const uint8_t low[64], const uint8_t high[64], uint8_t index[64])
{
    uint64_t may[64], due[64];
    int      depths = 0;
    do {
        may[depths] = bytes_at_most(low, (uint8_t)depths);
        due[depths] = bytes_at_most(high, (uint8_t)depths);
    } while (due[depths++] != UINT64_MAX);
    choose(may, due, depths, index);
}

void pattern_choose(const mask_need *needs, int depths, uint8_t index[64])
{
    uint64_t may[PALETTE_MAX], due[PALETTE_MAX];
    for (int mask = 0; mask < depths - 1; mask++) {
        may[mask] = ~needs[mask].lit;
        due[mask] = needs[mask].dark;
    }
    may[depths - 1] = due[depths - 1] = UINT64_MAX;
    choose(may, due, depths, index);
}

void pattern_set_free(pattern_set *s)
{
    for (int p = 0; p <= PALETTE_MAX; p++) {
        free(s->by_depths[p].ids);
        free(s->by_depths[p].needs);
    }
    memset(s, 0, sizeof *s);
}

enum { STATE_LIT, STATE_DARK, STATE_OWN, STATE_SAME, IMAGE = 0xff };
enum { PRIVATE_BYTES, PRIVATE_HALVES, PRIVATE_WORDS, RAW_NIBBLES, RAW_BYTES };

/* Bytes are stored low byte first in halves. */
static void put_byte(uint16_t *halves, uint32_t at, uint32_t byte)
{
    if (at & 1)
        halves[at / 2] |= (uint16_t)(byte << 8);
    else
        halves[at / 2] = (uint16_t)byte;
}

/* Texels below 32 are in the low nibbles of 32 bytes, the others in the high nibbles. */
static void put_nibbles(uint16_t *halves, const uint8_t nibble[64])
{
    for (uint32_t n = 0; n < 32; n++) put_byte(halves, n, nibble[n] | (uint32_t)nibble[n + 32] << 4);
}

uint32_t pattern_encode(const uint8_t index[64], int depths, uint16_t *halves)
{
    int      masks = depths - 1;
    uint64_t mask_bits[PRIVATE_DEPTHS_MAX];
    uint16_t own[4 * (PRIVATE_DEPTHS_MAX - 1)];
    uint8_t  states[PRIVATE_DEPTHS_MAX] = {0};
    uint32_t count                      = 0;
    for (int mask = 0; mask < masks; mask++) mask_bits[mask] = bytes_at_most(index, (uint8_t)mask);
    for (int q = 0; q < 4; q++)
        for (int mask = 0, owned = 0; mask < masks; mask++) {
            uint16_t bits = (uint16_t)(mask_bits[mask] >> 16 * q);
            int state = !bits ? STATE_LIT : bits == 0xffff ? STATE_DARK : owned && own[count - 1] == bits ? STATE_SAME : STATE_OWN;
            states[mask] |= (uint8_t)(state << 2 * q);
            if (state != STATE_OWN) continue;
            own[count++] = bits;
            owned        = 1;
        }
    uint32_t head = (uint32_t)(masks + 1) / 2;
    if (head + count > PATTERN_HALVES_MAX) {
        halves[0] = IMAGE;
        put_nibbles(halves + 1, index);
        return PATTERN_HALVES_MAX;
    }
    for (int n = 0; n < masks; n++) put_byte(halves, (uint32_t)n, states[n]);
    memcpy(halves + head, own, count * sizeof *own);
    return head + count;
}

/* private-palette patterns ---------------------------------------------------------------------------------------------------- */

/* The distinct depths, ascending. Each search starts at the previous texel's depth, because neighbours are similar.
 * Returns their number, or PRIVATE_DEPTHS_MAX + 1. */
static int depths_of(const int32_t depth[64], int32_t *list)
{
    int count = 0, at = 0;
    for (int n = 0; n < 64; n++) {
        while (at && list[at - 1] >= depth[n]) at--;
        while (at < count && list[at] < depth[n]) at++;
        if (at < count && list[at] == depth[n]) continue;
        if (count == PRIVATE_DEPTHS_MAX) return PRIVATE_DEPTHS_MAX + 1;
        for (int m = count++; m > at; m--) list[m] = list[m - 1];
        list[at] = depth[n];
    }
    return count;
}

/* Encode as a palette and a pattern. Returns 0 if there are too many depths. */
static uint32_t encode_palette(const int32_t depth[64], int shift, int32_t greatest, uint16_t *halves)
{
    int32_t  list[PRIVATE_DEPTHS_MAX + 1];
    uint8_t  index[64];
    int      count = depths_of(depth, list), bytes = greatest >> shift <= 0xff, at_halves = greatest >> shift <= 0xffff;
    uint32_t at = 1;
    if (count < 2 || count > PRIVATE_DEPTHS_MAX) return 0;
    if (!bytes && !at_halves) shift = 0;
    halves[0] = (uint16_t)((bytes ? PRIVATE_BYTES : at_halves ? PRIVATE_HALVES : PRIVATE_WORDS) << 12 | shift << 8 | count);
    for (int n = 1; n < count; n++) {
        uint32_t delta = (uint32_t)(list[n] - list[0]) >> shift;
        if (bytes) {
            put_byte(halves + 1, (uint32_t)n - 1, delta);
            continue;
        }
        halves[at++] = (uint16_t)delta;
        if (!at_halves) halves[at++] = (uint16_t)(delta >> 16);
    }
    if (bytes) at += (uint32_t)count / 2;
    for (int n = 0; n < 64; n++) {
        index[n] = n && depth[n] >= depth[n - 1] ? index[n - 1] : 0;
        while (list[index[n]] != depth[n]) index[n]++;
    }
    return at + pattern_encode(index, count, halves + at);
}

/* Encode as nibbles over a base for each quadrant. Returns 0 if the depths of a quadrant span too much. */
static uint32_t encode_nibbles(const int32_t depth[64], int shift, uint16_t *halves)
{
    uint8_t nibble[64];
    halves[0] = (uint16_t)(RAW_NIBBLES << 12 | shift << 8);
    for (uint32_t q = 0; q < 4; q++) {
        int32_t least = depth[16 * q], most = least;
        for (uint32_t n = 16 * q; n < 16 * q + 16; n++) {
            least = depth[n] < least ? depth[n] : least;
            most  = depth[n] > most ? depth[n] : most;
        }
        if (least >> shift > 0xff || (most - least) >> shift > 15) return 0;
        for (uint32_t n = 16 * q; n < 16 * q + 16; n++) nibble[n] = (uint8_t)((depth[n] - least) >> shift);
        put_byte(halves + 1, q, (uint32_t)least >> shift);
    }
    put_nibbles(halves + 3, nibble);
    return 19;
}

uint32_t private_encode(const int32_t depth[64], uint16_t *halves)
{
    uint16_t other[PRIVATE_HALVES_MAX];
    int32_t  bits = 0, greatest = 0;
    for (int n = 0; n < 64; n++) {
        bits |= depth[n];
        greatest = depth[n] > greatest ? depth[n] : greatest;
    }
    int      shift = (int)common_shift((uint32_t)bits);
    uint32_t bytes = greatest >> shift <= 0xff ? 1 : greatest >> shift <= 0xffff ? 2 : 3, raw = 1 + 32 * bytes;
    uint32_t palette = encode_palette(depth, shift, greatest, halves), nibbles = encode_nibbles(depth, shift, other);
    uint32_t least = nibbles ? nibbles : raw;
    if (palette && palette < least) return palette;
    if (nibbles)
        memcpy(halves, other, nibbles * sizeof *other);
    else {
        halves[0] = (uint16_t)((RAW_BYTES + bytes - 1) << 12 | (uint32_t)shift << 8);
        for (uint32_t n = 0; n < 64; n++)
            for (uint32_t b = 0; b < bytes; b++) put_byte(halves + 1, bytes * n + b, (uint32_t)depth[n] >> shift >> 8 * b & 0xff);
    }
    return least;
}
