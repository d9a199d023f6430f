/* Minimum stabbing set; see stabbing_set.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/stabbing_set.h"

#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/integer.h"
#include "baker/base/simd.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

/* Fill the last vector with existing intervals. */
static void pad(intervals *s, int lanes)
{
    for (; s->count % lanes; s->count++) {
        s->low[s->count]  = s->low[0];
        s->high[s->count] = s->high[0];
    }
}

/* One pass over all intervals for each point, without branches: those that begin at or before a point have one, the next point is the
 * least end of the others. To remove intervals that have a point costs more than to read them again. */

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE int least_avx2(__m256i v)
{
    __m128i half = _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return _mm_extract_epi16(_mm_minpos_epu16(half), 0);
}

/* The greatest of nonnegative numbers. */
CPU_TARGET_AVX2 static ALWAYS_INLINE int greatest_avx2(__m256i v)
{
    return INT16_MAX - least_avx2(_mm256_sub_epi16(_mm256_set1_epi16(INT16_MAX), v));
}

/* What a pass finds: the greatest beginning of intervals at or before a point, and the least end of the others. */
typedef struct pass_avx2 {
    __m256i last_low, next;
} pass_avx2;

CPU_TARGET_AVX2 static ALWAYS_INLINE void meet_avx2(pass_avx2 *p, const intervals *s, int n, __m256i behind_point)
{
    __m256i low  = _mm256_loadu_si256((const __m256i *)(const void *)(s->low + n));
    __m256i high = _mm256_loadu_si256((const __m256i *)(const void *)(s->high + n)), met = _mm256_cmpgt_epi16(behind_point, low);
    p->last_low = _mm256_max_epi16(p->last_low, _mm256_and_si256(met, low));
    p->next     = _mm256_min_epu16(p->next, _mm256_or_si256(met, high));
}

/* The same with 16 lanes. */
CPU_TARGET_AVX2 static int stab_avx2(intervals *s, stab_group *groups, int most)
{
    const pass_avx2 none = {_mm256_setzero_si256(), _mm256_set1_epi16(-1)};
    pass_avx2       a = none, b = none;
    pad(s, 32);
    for (int n = 0; n < s->count; n += 16) {
        a.last_low = _mm256_max_epi16(a.last_low, _mm256_loadu_si256((const __m256i *)(const void *)(s->low + n)));
        a.next     = _mm256_min_epu16(a.next, _mm256_loadu_si256((const __m256i *)(const void *)(s->high + n)));
    }
    const int end = greatest_avx2(a.last_low);
    for (int count = 0, point = least_avx2(a.next);; point = least_avx2(_mm256_min_epu16(a.next, b.next))) {
        groups[count++] = (stab_group){(int16_t)end, (int16_t)point};
        if (point >= end) return count;
        const __m256i behind = _mm256_set1_epi16((int16_t)(point + 1));
        a = b = none;
        for (int n = 0; n < s->count; n += 32) {
            meet_avx2(&a, s, n, behind);
            meet_avx2(&b, s, n + 16, behind);
        }
        groups[count - 1].low = (int16_t)greatest_avx2(_mm256_max_epi16(a.last_low, b.last_low));
        if (count == most) return count;
    }
}

#endif

int minimum_stabbing_set(intervals *s, stab_group *groups, int most, int cpu)
{
#ifdef __x86_64__
    if (cpu >= CPU_AVX2) return stab_avx2(s, groups, most);
#endif
    (void)cpu;
    const i16x8 far      = i16x8_all(INT16_MAX);
    i16x8       last_low = i16x8_all(0), next = far;
    pad(s, 8);
    for (int n = 0; n < s->count; n += 8) {
        last_low = i16x8_max(last_low, i16x8_load(s->low + n));
        next     = i16x8_min(next, i16x8_load(s->high + n));
    }
    const int end = i16x8_greatest(last_low);
    for (int count = 0, point = i16x8_least(next);; point = i16x8_least(next)) {
        groups[count++] = (stab_group){(int16_t)end, (int16_t)point};
        if (point >= end) return count;
        const i16x8 at = i16x8_all((int16_t)point);
        last_low       = i16x8_all(0);
        next           = far;
        for (int n = 0; n < s->count; n += 8) {
            i16x8 low = i16x8_load(s->low + n), behind = (i16x8)(low > at);
            last_low = i16x8_max(last_low, low & ~behind);
            next     = i16x8_min(next, i16x8_select(behind, i16x8_load(s->high + n), far));
        }
        groups[count - 1].low = (int16_t)i16x8_greatest(last_low);
        if (count == most) return count;
    }
}

void points_of_ranges(const int16_t *low, const int16_t *high, int ranges, const int16_t *points, int count, uint8_t *first,
                      uint8_t *last)
{
    for (int n = 0; n < ranges; n += 8) {
        i16x8 l = i16x8_load(low + n), h = i16x8_load(high + n), from = i16x8_all(0), to = i16x8_all((int16_t)(count - 1));
        for (int point = 0; point < count; point++) {
            i16x8 at = i16x8_all(points[point]);
            from -= (i16x8)(l > at);
            to += (i16x8)(at > h);
        }
        i8x8 from_bytes = __builtin_convertvector(from, i8x8), to_bytes = __builtin_convertvector(to, i8x8);
        memcpy(first + n, &from_bytes, 8);
        memcpy(last + n, &to_bytes, 8);
    }
}

int axis_init(depth_axis *a, int32_t least_high, int32_t greatest_low)
{
    a->count = 0;
    a->floor = least_high > AXIS_MARGIN ? least_high - AXIS_MARGIN : 0;
    return greatest_low - a->floor <= INT16_MAX - AXIS_MARGIN;
}

/* A depth, and its index in the input. */
typedef struct placed_depth {
    int32_t depth, place;
} placed_depth;

void axis_init_by_depths(depth_axis *a, const int32_t *depths, int16_t *codes, int count)
{
    placed_depth first[AXIS_DEPTHS_MAX], second[AXIS_DEPTHS_MAX], *ordered = first, *other = second;
    int32_t      least = INT32_MAX, most = 0;
    for (int n = 0; n < count; n++) {
        least    = min_i32(least, depths[n]);
        most     = max_i32(most, depths[n]);
        first[n] = (placed_depth){depths[n], n};
    }
    for (int shift = 0; shift < 32 && (most - least) >> shift; shift += 8) {
        /* a step of a stable radix sort, by one byte of the depths relative to `least` */
        placed_depth *was       = ordered;
        int           next[256] = {0}, before = 0;
        for (int n = 0; n < count; n++) next[(ordered[n].depth - least) >> shift & 255]++;
        for (int byte = 0; byte < 256; byte++) {
            int of_byte = next[byte];
            next[byte]  = before;
            before += of_byte;
        }
        for (int n = 0; n < count; n++) other[next[(ordered[n].depth - least) >> shift & 255]++] = ordered[n];

        ordered = other;
        other   = was;
    }
    a->count = 0;
    for (int n = 0; n < count; n++) {
        if (!n || ordered[n].depth != a->depths[a->count - 1]) a->depths[a->count++] = ordered[n].depth;
        codes[ordered[n].place] = (int16_t)(2 * a->count - 1);
    }
}

void axis_codes(const depth_axis *a, const int32_t *depths, int16_t *codes, int count)
{
    if (a->count) {
        for (int n = 0; n < count; n++) {
            int from = 0, to = a->count;
            while (from < to) {
                int middle = (from + to) / 2;
                if (a->depths[middle] < depths[n])
                    from = middle + 1;
                else
                    to = middle;
            }
            codes[n] = (int16_t)(2 * from + (from < a->count && a->depths[from] == depths[n]));
        }
        return;
    }
    int n = 0;
    for (; n + 8 <= count; n += 8) {
        i16x8 code = i16x8_clamped(i32x4_load(depths + n) - a->floor, i32x4_load(depths + n + 4) - a->floor);
        i16x8_store(codes + n, i16x8_max(code, i16x8_all(0)));
    }
    for (; n < count; n++) {
        int32_t code = depths[n] - a->floor;
        codes[n]     = (int16_t)(code < 0 ? 0 : code > INT16_MAX ? INT16_MAX : code);
    }
}

int32_t axis_depth(const depth_axis *a, int16_t code)
{
    return a->count ? a->depths[code >> 1] : a->floor + code;
}

/* Bits of the codes that are greater than a point. */
typedef uint64_t find_behind(const int16_t codes[64], int16_t point);

static ALWAYS_INLINE uint64_t behind(const int16_t codes[64], int16_t point)
{
    const i16x8 at   = i16x8_all(point);
    uint64_t    bits = 0;
    for (int n = 0; n < 64; n += 16)
        bits |= (uint64_t)i16x8_bits((i16x8)(i16x8_load(codes + n) > at), (i16x8)(i16x8_load(codes + n + 8) > at)) << n;
    return bits;
}

/* At entry n, texels without an entry whose range ends before entry n + 1 must take entry n. */
static ALWAYS_INLINE uint32_t needs_by(find_behind *find, const int16_t *low, const int16_t *high, const int16_t *points, int count,
                                       int from, mask_need *needs)
{
    uint64_t left = UINT64_MAX, lit = 0,
             dark = 0; /* texels without an entry yet; texels that begin behind the last entry; texels that ended before this one */
    uint32_t used = 0;
    for (int entry = from; entry < count && left; entry++) {
        uint64_t ends = entry + 1 < count ? ~find(high, (int16_t)(points[entry + 1] - 1)) : UINT64_MAX;
        if (ends & left) { /* otherwise all texels without an entry can wait for the next one */
            if (used) *needs++ = (mask_need){.dark = dark, .lit = lit};
            used |= 1u << entry;
            lit = find(low, points[entry]);
            left &= lit;
        }
        dark = ends;
    }
    return used;
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE uint64_t behind_avx2(const int16_t codes[64], int16_t point)
{
    const __m256i at   = _mm256_set1_epi16(point);
    uint64_t      bits = 0;
    for (int n = 0; n < 64; n += 32) {
        __m256i a = _mm256_cmpgt_epi16(_mm256_loadu_si256((const __m256i *)(const void *)(codes + n)), at);
        __m256i b = _mm256_cmpgt_epi16(_mm256_loadu_si256((const __m256i *)(const void *)(codes + n + 16)), at);
        __m256i c = _mm256_permute4x64_epi64(_mm256_packs_epi16(a, b), 0xd8); /* because packs works on each half of the vector */
        bits |= (uint64_t)(uint32_t)_mm256_movemask_epi8(c) << n;
    }
    return bits;
}

CPU_TARGET_AVX2 static uint32_t needs_avx2(const int16_t *low, const int16_t *high, const int16_t *points, int count, int from,
                                           mask_need *needs)
{
    return needs_by(behind_avx2, low, high, points, count, from, needs);
}

#endif

uint32_t tile_needs(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, int from, mask_need *needs,
                    int cpu)
{
#ifdef __x86_64__
    if (cpu >= CPU_AVX2) return needs_avx2(low, high, points, count, from, needs);
#endif
    (void)cpu;
    return needs_by(behind, low, high, points, count, from, needs);
}
