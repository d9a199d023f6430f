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

#ifdef __AVX2__
#define AT_LEVEL(name) name##_avx2
#define LANES          4
#else
#define AT_LEVEL(name) name##_sse2
#define LANES          2
#endif

typedef double   f64s __attribute__((vector_size(8 * LANES)));
typedef int64_t  i64s __attribute__((vector_size(8 * LANES)));
typedef uint64_t u64s __attribute__((vector_size(8 * LANES)));
typedef int32_t  i32s __attribute__((vector_size(4 * LANES)));

static inline f64s f64s_all(double value)
{
    return value - (f64s){0};
}

static inline i64s i64s_all(int64_t value)
{
    return value - (i64s){0};
}

/* first, first + step, and so on. */
static inline i64s i64s_ramp(int64_t first, int64_t step)
{
#if LANES == 4
    return (i64s){first, first + step, first + 2 * step, first + 3 * step};
#else
    return (i64s){first, first + step};
#endif
}

static inline f64s f64s_ramp(double first, double step)
{
#if LANES == 4
    return first + step * (f64s){0, 1, 2, 3};
#else
    return first + step * (f64s){0, 1};
#endif
}

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

/* Bit mask of the negative elements. */
static inline uint32_t i64s_negative(i64s v)
{
#ifdef __AVX2__
    return (uint32_t)_mm256_movemask_pd((__m256d)v);
#elif defined __SSE2__
    return (uint32_t)_mm_movemask_pd((__m128d)v);
#else
    return (uint32_t)(v[0] < 0) | (uint32_t)(v[1] < 0) << 1;
#endif
}

/* Maximum; the result for NaN is not defined. */
static inline f64s f64s_max(f64s a, f64s b)
{
#ifdef __AVX2__
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
#ifdef __AVX2__
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
#ifdef __AVX2__
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
