/* Minimum stabbing set; see stabbing_set.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/stabbing_set.h"

#include <string.h>

#include "baker/base/cpu.h"
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

/* One pass for each point. A vector without remaining intervals is replaced by the last one, which was visited before. The next
 * point is found in the same pass. */
static int stab_plain(intervals *s, stab_group *groups, int most)
{
    const i16x8 far = i16x8_all(INT16_MAX);
    pad(s, 8);
    i16x8 next = far;
    for (int n = 0; n < s->count; n += 8) next = i16x8_min(next, i16x8_load(s->high + n));

    for (int count = 0;;) {
        int   point = i16x8_least(next);
        i16x8 at = i16x8_all((int16_t)point), last_low = i16x8_all(INT16_MIN);
        next = far;
        for (int n = s->count - 8; n >= 0; n -= 8) {
            i16x8 low = i16x8_load(s->low + n), high = i16x8_load(s->high + n), behind = (i16x8)(low > at);
            last_low = i16x8_max(last_low, i16x8_select(behind, last_low, low));
            next     = i16x8_min(next, i16x8_select(behind, high, far));
            if (i16x8_any(behind)) continue;
            s->count -= 8;
            i16x8_store(s->low + n, i16x8_load(s->low + s->count));
            i16x8_store(s->high + n, i16x8_load(s->high + s->count));
        }
        groups[count++] = (stab_group){(int16_t)i16x8_greatest(last_low), (int16_t)point};
        if (!s->count || count == most) return count;
    }
}

#ifdef __x86_64__

/* The least and the greatest of nonnegative numbers. */
CPU_TARGET_AVX2 static ALWAYS_INLINE int least_avx2(__m256i v)
{
    __m128i half = _mm_min_epi16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return _mm_extract_epi16(_mm_minpos_epu16(half), 0);
}

CPU_TARGET_AVX2 static ALWAYS_INLINE int greatest_avx2(__m256i v)
{
    return INT16_MAX - least_avx2(_mm256_sub_epi16(_mm256_set1_epi16(INT16_MAX), v));
}

/* The same with 16 lanes. */
CPU_TARGET_AVX2 static int stab_avx2(intervals *s, stab_group *groups, int most)
{
    const __m256i far  = _mm256_set1_epi16(INT16_MAX);
    __m256i       next = far;
    pad(s, 16);
    for (int n = 0; n < s->count; n += 16)
        next = _mm256_min_epi16(next, _mm256_loadu_si256((const __m256i *)(const void *)(s->high + n)));
    for (int count = 0;;) {
        int     point = least_avx2(next);
        __m256i at = _mm256_set1_epi16((int16_t)point), last_low = _mm256_setzero_si256();
        next = far;
        for (int n = s->count - 16; n >= 0; n -= 16) {
            __m256i low  = _mm256_loadu_si256((const __m256i *)(const void *)(s->low + n));
            __m256i high = _mm256_loadu_si256((const __m256i *)(const void *)(s->high + n)), behind = _mm256_cmpgt_epi16(low, at);
            last_low = _mm256_max_epi16(last_low, _mm256_andnot_si256(behind, low));
            next     = _mm256_min_epi16(next, _mm256_blendv_epi8(far, high, behind));
            if (!_mm256_testz_si256(behind, behind)) continue;
            s->count -= 16;
            memcpy(s->low + n, s->low + s->count, sizeof low);
            memcpy(s->high + n, s->high + s->count, sizeof high);
        }
        groups[count++] = (stab_group){(int16_t)greatest_avx2(last_low), (int16_t)point};
        if (!s->count || count == most) return count;
    }
}

#endif

int minimum_stabbing_set(intervals *s, stab_group *groups, int most, int cpu)
{
#ifdef __x86_64__
    if (cpu == CPU_AVX2) return stab_avx2(s, groups, most);
#endif
    (void)cpu;
    return stab_plain(s, groups, most);
}

void points_of_ranges(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, uint8_t first[64],
                      uint8_t last[64])
{
    for (int n = 0; n < 64; n += 8) {
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
