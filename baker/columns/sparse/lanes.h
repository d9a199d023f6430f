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

/* A number for each texel in some rows of a tile. With SSE2 it is two registers. They may wrap around. */
#ifdef __AVX512F__
enum { ROWS = 2 };
#else
enum { ROWS = 1 };
#endif
typedef uint32_t u32rows __attribute__((vector_size(32 * ROWS)));

static inline f64s f64s_all(double value)
{
    return value - (f64s){0};
}

static inline i64s i64s_all(int64_t value)
{
    return value - (i64s){0};
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

static inline u32rows u32rows_ramp(int32_t first, int32_t across, int32_t down)
{
#ifdef __AVX512F__
    const u32rows right = {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7},
                  under = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
    return (uint32_t)first + (uint32_t)across * right + (uint32_t)down * under;
#else
    (void)down;
    return (uint32_t)first + (uint32_t)across * (u32rows){0, 1, 2, 3, 4, 5, 6, 7};
#endif
}

/* Bit mask of the elements that are negative as int32_t. */
static inline uint32_t u32rows_negative(u32rows v)
{
#ifdef __AVX512F__
    return _mm512_movepi32_mask((__m512i)v);
#elif defined __AVX2__
    return (uint32_t)_mm256_movemask_ps((__m256)v);
#elif defined __SSE2__
    __m128 half[2];
    memcpy(half, &v, sizeof half);
    return (uint32_t)_mm_movemask_ps(half[0]) | (uint32_t)_mm_movemask_ps(half[1]) << 4;
#else
    uint32_t bits = 0;
    for (int n = 0; n < 8; n++) bits |= v[n] >> 31 << n;
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

/* Rounded up. */
static inline i32s f64s_up(f64s v)
{
#ifdef __AVX512F__
    return (i32s)_mm512_cvt_roundpd_epi32((__m512d)v, _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC);
#elif defined __AVX2__
    return (i32s)_mm256_cvttpd_epi32(_mm256_ceil_pd((__m256d)v));
#else
    const i32s down = __builtin_convertvector(v, i32s);
    return down - __builtin_convertvector((i64s)(__builtin_convertvector(down, f64s) < v), i32s);
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
#ifdef __AVX512F__
    return _mm512_reduce_max_pd((__m512d)v);
#else
    double greatest = v[0];
    for (int n = 1; n < LANES; n++) greatest = v[n] > greatest ? v[n] : greatest;
    return greatest;
#endif
}

static inline double f64s_least(f64s v)
{
#ifdef __AVX512F__
    return _mm512_reduce_min_pd((__m512d)v);
#else
    double least = v[0];
    for (int n = 1; n < LANES; n++) least = v[n] < least ? v[n] : least;
    return least;
#endif
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

/* Triangles --------------------------------------------------------------------------------------------------------------------- */

static inline uint64_t eight_bytes(const void *from)
{
    uint64_t bytes;
    memcpy(&bytes, from, sizeof bytes);
    return bytes;
}

/* Corners of LANES triangles, in subtexels: a triangle for each element. */
typedef struct lanes_corners {
    i64s x[3], y[3];
} lanes_corners;

static inline lanes_corners lanes_corners_of(const sparse_triangles *s, const uint32_t ids[LANES])
{
#define X01(n)  eight_bytes(&s->all[ids[n]].x[0])
#define X2Y0(n) eight_bytes(&s->all[ids[n]].x[2])
#define Y12(n)  eight_bytes(&s->all[ids[n]].y[1])
    const u64s    pairs[3] = {EACH_LANE(X01), EACH_LANE(X2Y0), EACH_LANE(Y12)};
    lanes_corners c;
    i64s         *to[6] = {&c.x[0], &c.x[1], &c.x[2], &c.y[0], &c.y[1], &c.y[2]};
    for (int n = 0; n < 3; n++) {
        *to[2 * n]     = __builtin_convertvector(__builtin_convertvector(pairs[n], i32s), i64s);
        *to[2 * n + 1] = __builtin_convertvector(__builtin_convertvector(pairs[n] >> 32, i32s), i64s);
    }
    return c;
}

/* Edges from corner k to the next, as sparse_edge, seen from a point. */
typedef struct lanes_edge {
    i64s a, b, at; /* at: its value at the point */
    i64s dx, dy;   /* from corner k to the point */
} lanes_edge;

static inline lanes_edge lanes_edge_of(const lanes_corners *t, int k, int64_t x, int64_t y)
{
    const int  next = k < 2 ? k + 1 : 0;
    lanes_edge e    = {.a = t->y[k] - t->y[next], .b = t->x[next] - t->x[k], .dx = x - t->x[k], .dy = y - t->y[k]};
    const i64s owns = (e.a << 32) + e.b; /* positive if the triangle owns the edge */
    e.at            = i64s_product(e.a, e.dx) + i64s_product(e.b, e.dy) - (i64s)((u64s)(owns - 1) >> 63);
    return e;
}

/* Absolute value. */
static inline i64s i64s_length(i64s v)
{
    const i64s sign = v >> 63;
    return (v ^ sign) - sign;
}

/* Depth of a triangle at (x, y), in subtexels, in three steps: a part for each column of texels, one for each row, then the sum. */
static inline f64s lanes_rise(const sparse_triangle *t, f64s x)
{
    return f64s_all(t->gx) * (x - f64s_all(t->x[0]));
}

static inline f64s lanes_fall(const sparse_triangle *t, f64s y)
{
    return f64s_all(t->zmin) + f64s_all(t->gy) * (y - f64s_all(t->y[0]));
}

static inline f64s lanes_depth(const sparse_triangle *t, f64s rise, f64s fall)
{
    return f64s_min(f64s_max(fall + rise, f64s_all(t->zmin)), f64s_all(t->zmax));
}

#endif
