/* The 16-byte vector operations that the baker needs: SSE2 where available, else plain loops. Both give the same bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SIMD_H
#define SIMD_H

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

typedef int16_t  i16x8 __attribute__((vector_size(16)));
typedef int8_t   i8x8 __attribute__((vector_size(8)));
typedef int32_t  i32x4 __attribute__((vector_size(16)));
typedef float    f32x4 __attribute__((vector_size(16)));
typedef uint32_t u32x4 __attribute__((vector_size(16)));
typedef uint64_t u64x2 __attribute__((vector_size(16)));

static inline i16x8 i16x8_load(const int16_t *from)
{
    i16x8 v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline void i16x8_store(int16_t *to, i16x8 v)
{
    memcpy(to, &v, sizeof v);
}

static inline i16x8 i16x8_all(int16_t value)
{
    return (i16x8){value, value, value, value, value, value, value, value};
}

static inline i16x8 i16x8_select(i16x8 mask, i16x8 a, i16x8 b)
{
    return (a & mask) | (b & ~mask);
}

static inline i16x8 i16x8_max(i16x8 a, i16x8 b)
{
#ifdef __SSE2__
    return (i16x8)_mm_max_epi16((__m128i)a, (__m128i)b);
#else
    return i16x8_select((i16x8)(a > b), a, b);
#endif
}

static inline i16x8 i16x8_min(i16x8 a, i16x8 b)
{
#ifdef __SSE2__
    return (i16x8)_mm_min_epi16((__m128i)a, (__m128i)b);
#else
    return i16x8_select((i16x8)(a < b), a, b);
#endif
}

/* Saturating sum and difference. */
static inline i16x8 i16x8_adds(i16x8 a, i16x8 b)
{
#ifdef __SSE2__
    return (i16x8)_mm_adds_epi16((__m128i)a, (__m128i)b);
#else
    i16x8 sum;
    for (int n = 0; n < 8; n++) sum[n] = (int16_t)(a[n] + b[n] > 32767 ? 32767 : a[n] + b[n] < -32768 ? -32768 : a[n] + b[n]);
    return sum;
#endif
}

static inline i16x8 i16x8_subs(i16x8 a, i16x8 b)
{
#ifdef __SSE2__
    return (i16x8)_mm_subs_epi16((__m128i)a, (__m128i)b);
#else
    i16x8 rest;
    for (int n = 0; n < 8; n++) rest[n] = (int16_t)(a[n] - b[n] > 32767 ? 32767 : a[n] - b[n] < -32768 ? -32768 : a[n] - b[n]);
    return rest;
#endif
}

/* 1 when any bit of a mask is set. */
static inline int i16x8_any(i16x8 mask)
{
#ifdef __SSE2__
    return _mm_movemask_epi8((__m128i)mask) != 0;
#else
    uint64_t half[2];
    memcpy(half, &mask, sizeof half);
    return (half[0] | half[1]) != 0;
#endif
}

/* Bit n is set when element n of the 16 elements of two masks is set. */
static inline uint32_t i16x8_bits(i16x8 a, i16x8 b)
{
#ifdef __SSE2__
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16((__m128i)a, (__m128i)b));
#else
    uint32_t bits = 0;
    for (int n = 0; n < 8; n++) bits |= (uint32_t)(a[n] != 0) << n | (uint32_t)(b[n] != 0) << (n + 8);
    return bits;
#endif
}

static inline int i16x8_greatest(i16x8 v)
{
    int16_t at[8];
    i16x8_store(at, v);
    int greatest = at[0];
    for (int n = 1; n < 8; n++) greatest = at[n] > greatest ? at[n] : greatest;
    return greatest;
}

static inline int i16x8_least(i16x8 v)
{
    int16_t at[8];
    i16x8_store(at, v);
    int least = at[0];
    for (int n = 1; n < 8; n++) least = at[n] < least ? at[n] : least;
    return least;
}

/* Maximum or minimum of the first four elements, in each of them; of the last four likewise. */
static inline i16x8 i16x8_max_of_four(i16x8 v)
{
    v = i16x8_max(v, (i16x8){v[2], v[3], v[0], v[1], v[6], v[7], v[4], v[5]});
    return i16x8_max(v, (i16x8){v[1], v[0], v[3], v[2], v[5], v[4], v[7], v[6]});
}

static inline i16x8 i16x8_min_of_four(i16x8 v)
{
    v = i16x8_min(v, (i16x8){v[2], v[3], v[0], v[1], v[6], v[7], v[4], v[5]});
    return i16x8_min(v, (i16x8){v[1], v[0], v[3], v[2], v[5], v[4], v[7], v[6]});
}

static inline int i16x8_sum(i16x8 v)
{
    int16_t at[8];
    i16x8_store(at, v);
    int sum = 0;
    for (int n = 0; n < 8; n++) sum += at[n];
    return sum;
}

/* Bit n is set when byte n is at most `limit`. */
static inline uint64_t bytes_at_most(const uint8_t bytes[64], uint8_t limit)
{
    uint64_t bits = 0;
#ifdef __SSE2__
    const __m128i top = _mm_set1_epi8((char)limit);
    for (int n = 0; n < 64; n += 16) {
        __m128i v = _mm_loadu_si128((const __m128i *)(const void *)(bytes + n));
        bits |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(v, top), top)) << n;
    }
#else
    for (int n = 0; n < 64; n++) bits |= (uint64_t)(bytes[n] <= limit) << n;
#endif
    return bits;
}

static inline i32x4 i32x4_load(const void *from)
{
    i32x4 v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline i32x4 i32x4_all(int32_t value)
{
    return (i32x4){value, value, value, value};
}

static inline i32x4 i32x4_select(i32x4 mask, i32x4 a, i32x4 b)
{
    return (a & mask) | (b & ~mask);
}

static inline i32x4 i32x4_max(i32x4 a, i32x4 b)
{
    return i32x4_select((i32x4)(a > b), a, b);
}

static inline i32x4 i32x4_min(i32x4 a, i32x4 b)
{
    return i32x4_select((i32x4)(a < b), a, b);
}

static inline int32_t i32x4_greatest(i32x4 v)
{
    int32_t a = v[0] > v[1] ? v[0] : v[1], b = v[2] > v[3] ? v[2] : v[3];
    return a > b ? a : b;
}

static inline int32_t i32x4_least(i32x4 v)
{
    int32_t a = v[0] < v[1] ? v[0] : v[1], b = v[2] < v[3] ? v[2] : v[3];
    return a < b ? a : b;
}

/* Narrow both to 16 bits, with saturation. */
static inline i16x8 i16x8_clamped(i32x4 a, i32x4 b)
{
#ifdef __SSE2__
    return (i16x8)_mm_packs_epi32((__m128i)a, (__m128i)b);
#else
    const i32x4 least = i32x4_all(INT16_MIN), most = i32x4_all(INT16_MAX);
    a = i32x4_max(i32x4_min(a, most), least);
    b = i32x4_max(i32x4_min(b, most), least);
    return (i16x8){(int16_t)a[0], (int16_t)a[1], (int16_t)a[2], (int16_t)a[3],
                   (int16_t)b[0], (int16_t)b[1], (int16_t)b[2], (int16_t)b[3]};
#endif
}

static inline f32x4 f32x4_load(const float *from)
{
    f32x4 v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline f32x4 f32x4_all(float value)
{
    return (f32x4){value, value, value, value};
}

/* For NaN the result is unspecified. */
static inline f32x4 f32x4_max(f32x4 a, f32x4 b)
{
#ifdef __wasm_simd128__
    return (f32x4)__builtin_wasm_pmax_f32x4(b, a);
#elif defined __SSE2__
    return (f32x4)_mm_max_ps((__m128)a, (__m128)b);
#else
    return (f32x4)i32x4_select((i32x4)(a > b), (i32x4)a, (i32x4)b);
#endif
}

static inline f32x4 f32x4_min(f32x4 a, f32x4 b)
{
#ifdef __wasm_simd128__
    return (f32x4)__builtin_wasm_pmin_f32x4(b, a);
#elif defined __SSE2__
    return (f32x4)_mm_min_ps((__m128)a, (__m128)b);
#else
    return (f32x4)i32x4_select((i32x4)(a < b), (i32x4)a, (i32x4)b);
#endif
}

/* Bit n is set when element n of a mask is set. */
static inline uint32_t i32x4_bits(i32x4 mask)
{
#ifdef __SSE2__
    return (uint32_t)_mm_movemask_ps((__m128)mask);
#else
    return (uint32_t)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

/* Bit n is set when element n of 16 is zero, v[0] first. */
static inline uint32_t u32x4_zeros(const u32x4 v[4])
{
#ifdef __SSE2__
    const __m128i zero = _mm_setzero_si128();
    __m128i       a    = _mm_packs_epi32(_mm_cmpeq_epi32((__m128i)v[0], zero), _mm_cmpeq_epi32((__m128i)v[1], zero));
    __m128i       b    = _mm_packs_epi32(_mm_cmpeq_epi32((__m128i)v[2], zero), _mm_cmpeq_epi32((__m128i)v[3], zero));
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(a, b));
#else
    uint32_t bits = 0;
    for (int n = 0; n < 16; n++) bits |= (uint32_t)(v[n / 4][n % 4] == 0) << n;
    return bits;
#endif
}

static inline u64x2 u64x2_load(const uint64_t *from)
{
    u64x2 v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline u64x2 u64x2_all(uint64_t value)
{
    return (u64x2){value, value};
}

/* The same for 16 elements of 64 bits. */
static inline uint32_t u64x2_zeros(const u64x2 v[8])
{
    u32x4 either[4]; /* OR of the two halves of each element */
    for (int n = 0; n < 4; n++) {
        u32x4 a = (u32x4)v[2 * n], b = (u32x4)v[2 * n + 1];
        either[n] = (u32x4){a[0], a[2], b[0], b[2]} | (u32x4){a[1], a[3], b[1], b[3]};
    }
    return u32x4_zeros(either);
}

#endif
