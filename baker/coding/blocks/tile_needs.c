/* Needs of a tile for a palette; see tile_needs.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/tile_needs.h"

#include "baker/base/cpu.h"
#include "baker/base/simd.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

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
                                       mask_need *needs)
{
    uint64_t left = UINT64_MAX, lit = 0,
             dark = 0; /* texels without an entry yet; texels that begin behind the last entry; texels that ended before this one */
    uint32_t used = 0;
    for (int entry = 0; entry < count && left; entry++) {
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

static uint32_t needs_plain(const int16_t *low, const int16_t *high, const int16_t *points, int count, mask_need *needs)
{
    return needs_by(behind, low, high, points, count, needs);
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

CPU_TARGET_AVX2 static uint32_t needs_avx2(const int16_t *low, const int16_t *high, const int16_t *points, int count,
                                           mask_need *needs)
{
    return needs_by(behind_avx2, low, high, points, count, needs);
}

#endif

uint32_t tile_needs(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, mask_need *needs, int cpu)
{
#ifdef __x86_64__
    if (cpu == CPU_AVX2) return needs_avx2(low, high, points, count, needs);
#endif
    (void)cpu;
    return needs_plain(low, high, points, count, needs);
}
