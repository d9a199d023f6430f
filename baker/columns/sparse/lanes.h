/* SIMD vectors, as wide as the target of the compiled file allows: doubles and 64-bit integers.
 *
 * leaf.c and square_list.c are compiled once for each level of cpu.h. Every external function has the level in its name. All levels
 * do the same arithmetic on each number, so their results are equal bit by bit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LANES_H
#define LANES_H

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <immintrin.h>
#endif

#include "baker/columns/sparse/sparse_triangles.h"

#ifdef __AVX512F__
#define AT_LEVEL(name) name##_avx512
#define LANES          8
#elif defined __AVX2__
#define AT_LEVEL(name) name##_avx2
#define LANES          4
#else
#define AT_LEVEL(name) name##_sse2
#define LANES          2
#endif

enum { LANES_MAX = 8, ALL_LANES = (1 << LANES) - 1 };

typedef double   f64s __attribute__((vector_size(8 * LANES)));
typedef int64_t  i64s __attribute__((vector_size(8 * LANES)));
typedef uint64_t u64s __attribute__((vector_size(8 * LANES)));
typedef int32_t  i32s __attribute__((vector_size(4 * LANES)));

/* A number for each texel in a row of a tile, at all levels: with SSE2 it is two registers. */
typedef int32_t i32row __attribute__((vector_size(32)));

static inline f64s f64s_all(double value)
{
    return value - (f64s){0};
}

static inline i64s i64s_all(int64_t value)
{
    return value - (i64s){0};
}

/* first, first + step, and so on. */
static inline f64s f64s_ramp(double first, double step)
{
#if LANES == 8
    return first + step * (f64s){0, 1, 2, 3, 4, 5, 6, 7};
#elif LANES == 4
    return first + step * (f64s){0, 1, 2, 3};
#else
    return first + step * (f64s){0, 1};
#endif
}

/* A vector of of(0), of(1), and so on. */
#if LANES == 8
#define EACH_LANE(of)                                                                                                              \
    {                                                                                                                              \
        of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)                                                                     \
    }
#elif LANES == 4
#define EACH_LANE(of)                                                                                                              \
    {                                                                                                                              \
        of(0), of(1), of(2), of(3)                                                                                                 \
    }
#else
#define EACH_LANE(of)                                                                                                              \
    {                                                                                                                              \
        of(0), of(1)                                                                                                               \
    }
#endif

static inline f64s f64s_load(const double *from)
{
    f64s v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline void f64s_store(double *to, f64s v)
{
    memcpy(to, &v, sizeof v);
}

/* Product of numbers that fit 32 bits. */
static inline i64s i64s_product(i64s a, i64s b)
{
#ifdef __AVX512F__
    return (i64s)_mm512_mul_epi32((__m512i)a, (__m512i)b);
#elif defined __AVX2__
    return (i64s)_mm256_mul_epi32((__m256i)a, (__m256i)b);
#else
    return a * b;
#endif
}

/* Bit mask of the negative elements. */
static inline uint32_t i64s_negative(i64s v)
{
#ifdef __AVX512F__
    return _mm512_movepi64_mask((__m512i)v);
#elif defined __AVX2__
    return (uint32_t)_mm256_movemask_pd((__m256d)v);
#elif defined __SSE2__
    return (uint32_t)_mm_movemask_pd((__m128d)v);
#else
    return (uint32_t)(v[0] < 0) | (uint32_t)(v[1] < 0) << 1;
#endif
}

static inline uint32_t i32row_negative(i32row v)
{
#ifdef __AVX2__
    return (uint32_t)_mm256_movemask_ps((__m256)v);
#elif defined __SSE2__
    __m128 half[2];
    memcpy(half, &v, sizeof half);
    return (uint32_t)_mm_movemask_ps(half[0]) | (uint32_t)_mm_movemask_ps(half[1]) << 4;
#else
    uint32_t bits = 0;
    for (int n = 0; n < 8; n++) bits |= (uint32_t)(v[n] < 0) << n;
    return bits;
#endif
}

/* Maximum; the result for NaN is not defined. */
static inline f64s f64s_max(f64s a, f64s b)
{
#ifdef __AVX512F__
    return (f64s)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif defined __AVX2__
    return (f64s)_mm256_max_pd((__m256d)a, (__m256d)b);
#elif defined __wasm_simd128__
    return (f64s)__builtin_wasm_pmax_f64x2(b, a);
#elif defined __SSE2__
    return (f64s)_mm_max_pd((__m128d)a, (__m128d)b);
#else
    return (f64s){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}

static inline f64s f64s_min(f64s a, f64s b)
{
#ifdef __AVX512F__
    return (f64s)_mm512_min_pd((__m512d)a, (__m512d)b);
#elif defined __AVX2__
    return (f64s)_mm256_min_pd((__m256d)a, (__m256d)b);
#elif defined __wasm_simd128__
    return (f64s)__builtin_wasm_pmin_f64x2(b, a);
#elif defined __SSE2__
    return (f64s)_mm_min_pd((__m128d)a, (__m128d)b);
#else
    return (f64s){a[0] < b[0] ? a[0] : b[0], a[1] < b[1] ? a[1] : b[1]};
#endif
}

/* Element of a where its bit is set, else of b. */
static inline f64s f64s_select(uint32_t bits, f64s a, f64s b)
{
#ifdef __AVX512F__
    return (f64s)_mm512_mask_blend_pd((__mmask8)bits, (__m512d)b, (__m512d)a);
#elif defined __AVX2__
    i64s sign = i64s_all(bits) << (i64s){63, 62, 61, 60};
    return (f64s)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)sign);
#else
    static const i64s masks[4] = {{0, 0}, {-1, 0}, {0, -1}, {-1, -1}};
    return (f64s)(((i64s)a & masks[bits]) | ((i64s)b & ~masks[bits]));
#endif
}

/* Element of a where the mask is all ones, else of b. */
static inline f64s f64s_choose(i64s mask, f64s a, f64s b)
{
    return (f64s)(((i64s)a & mask) | ((i64s)b & ~mask));
}

static inline double f64s_greatest(f64s v)
{
    double greatest = v[0];
    for (int n = 1; n < LANES; n++) greatest = v[n] > greatest ? v[n] : greatest;
    return greatest;
}

static inline double f64s_least(f64s v)
{
    double least = v[0];
    for (int n = 1; n < LANES; n++) least = v[n] < least ? v[n] : least;
    return least;
}

/* Store the elements whose bits are set, one after the other, and anything up to LANES elements.   to  8-byte numbers */
static inline void lanes_pack(void *to, uint32_t bits, i64s v)
{
#ifdef __AVX512F__
    v = (i64s)_mm512_maskz_compress_epi64((__mmask8)bits, (__m512i)v);
    memcpy(to, &v, sizeof v);
#elif defined __AVX2__
    /* halves of the elements that are kept; the last one counts for all that follow */
    static const uint32_t halves[16] = {0,    0x10,   0x32,   0x3210,   0x54,   0x5410,   0x5432,   0x543210,
                                        0x76, 0x7610, 0x7632, 0x763210, 0x7654, 0x765410, 0x765432, 0x76543210};
    const __m256i from = _mm256_srlv_epi32(_mm256_set1_epi32((int)halves[bits]), _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
    v                  = (i64s)_mm256_permutevar8x32_epi32((__m256i)v, from);
    memcpy(to, &v, sizeof v);
#else
    int64_t *numbers = to;
    memcpy(numbers, &(int64_t){v[0]}, sizeof *numbers);
    memcpy(numbers + (bits & 1), &(int64_t){v[1]}, sizeof *numbers);
#endif
}

/* Depth of a triangle at (x, y), in subtexels, in two steps: the part that is the same for all rows of texels, then the rest. */
static inline f64s lanes_rise(const sparse_triangle *t, f64s x)
{
    return f64s_all(t->gx) * (x - f64s_all(t->x[0]));
}

static inline f64s lanes_depth(const sparse_triangle *t, f64s rise, double y)
{
    f64s z = f64s_all(t->zmin + t->gy * (y - t->y[0])) + rise;
    return f64s_min(f64s_max(z, f64s_all(t->zmin)), f64s_all(t->zmax));
}

#endif
