/* Triangles against squares; see square_list.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_list.h"
#include "baker/base/array.h"
#include "baker/columns/sparse/lanes.h"

enum { QUARTERS = 4, AT_ONCE = 64 }; /* triangles between checks of the lists' capacity */

/* Vectors of four quarters, at all levels: with SSE2 each is two registers. The type is not used outside this file. */
typedef double  f64x4 __attribute__((vector_size(32)));
typedef int64_t i64x4 __attribute__((vector_size(32)));

static inline f64x4 f64x4_all(double value)
{
    return value - (f64x4){0};
}

static inline f64x4 f64x4_max(f64x4 a, f64x4 b)
{
#ifdef __AVX2__
    return (f64x4)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
    const i64x4 mask = (i64x4)(a > b);
    return (f64x4)(((i64x4)a & mask) | ((i64x4)b & ~mask));
#endif
}

static inline f64x4 f64x4_min(f64x4 a, f64x4 b)
{
#ifdef __AVX2__
    return (f64x4)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
    const i64x4 mask = (i64x4)(a < b);
    return (f64x4)(((i64x4)a & mask) | ((i64x4)b & ~mask));
#endif
}

static inline uint32_t i64x4_negative(i64x4 v)
{
#ifdef __AVX2__
    return (uint32_t)_mm256_movemask_pd((__m256d)v);
#else
    return (uint32_t)(v[0] < 0) | (uint32_t)(v[1] < 0) << 1 | (uint32_t)(v[2] < 0) << 2 | (uint32_t)(v[3] < 0) << 3;
#endif
}

/* Constants for all triangles. */
typedef struct splitter {
    int64_t x, y; /* middle of the square, subtexels */
    int64_t step; /* from there to the centres of the quarters, along x and y; 0: the whole square in place of quarters */
    int64_t half; /* of the side of the box of a quarter's texel centres */
    f64x4   middle_x, middle_y;
} splitter;

static const i64x4 left = {-1, 0, -1, 0}, below = {-1, -1, 0, 0}; /* masks of quarters */

static splitter splitter_of(const sparse_triangles *s, texel_square square, uint32_t side)
{
    splitter w = {.x    = ((int64_t)(2 * square.u + square.side) << s->grid) / 2,
                  .y    = ((int64_t)(2 * square.v + square.side) << s->grid) / 2,
                  .step = ((int64_t)(square.side - side) << s->grid) / 2,
                  .half = ((int64_t)(side - 1) << s->grid) / 2};
    for (int n = 0; n < QUARTERS; n++) {
        w.middle_x[n] = (double)(n & 1 ? w.x + w.step : w.x - w.step);
        w.middle_y[n] = (double)(n & 2 ? w.y + w.step : w.y - w.step);
    }
    return w;
}

/* The number, negated where the mask is set. */
static i64x4 turned(int64_t number, i64x4 mask)
{
    return ((number - (i64x4){0}) ^ mask) - mask;
}

/* Results for the four quarters, as bits. */
typedef struct quarter_answer {
    uint32_t missed, uncovered, unsampled, ended;
    double   lo[QUARTERS], hi[QUARTERS];
} quarter_answer;

/* Quarters whose box does not overlap the box of an edge. */
static uint32_t apart_from(const splitter *w, const sparse_triangle *t, int k)
{
    const int     next = k < 2 ? k + 1 : 0;
    const int64_t x0 = min_i32(t->x[k], t->x[next]) - w->half - w->x, x1 = max_i32(t->x[k], t->x[next]) + w->half - w->x;
    const int64_t y0 = min_i32(t->y[k], t->y[next]) - w->half - w->y, y1 = max_i32(t->y[k], t->y[next]) + w->half - w->y;
    uint32_t      outside = 0;
    if (x1 < w->step || x0 > w->step) outside |= 10; /* the right ones */
    if (x1 < -w->step || x0 > -w->step) outside |= 5;
    if (y1 < w->step || y0 > w->step) outside |= 12; /* the upper ones */
    if (y1 < -w->step || y0 > -w->step) outside |= 3;
    return outside;
}

static quarter_answer ask(const splitter *w, const sparse_triangle *t, int covers)
{
    /* Depth range of the triangle in each quarter. If it is empty, the plane is outside the triangle's depth range there. */
    const double   steep = (t->gx < 0 ? -t->gx : t->gx) + (t->gy < 0 ? -t->gy : t->gy), rise = steep * (double)w->half + t->slack;
    const f64x4    depth = t->zmin + t->gy * (w->middle_y - t->y[0]) + t->gx * (w->middle_x - t->x[0]);
    const f64x4    lo = f64x4_max(depth - rise, f64x4_all(t->zmin)), hi = f64x4_min(depth + rise, f64x4_all(t->zmax));
    quarter_answer q = {.missed = i64x4_negative((i64x4)(lo > hi))};
    memcpy(q.lo, &lo, sizeof lo);
    memcpy(q.hi, &hi, sizeof hi);
    if (covers) return q;

    i64x4 missed = {0}, uncovered = {0}, unsampled = {0}; /* negative: the box is missed, not all covered, its centre is not
                                                             covered */
    for (int k = 0; k < 3; k++) {
        const sparse_edge e  = sparse_edge_of(t, k);
        const int64_t     at = sparse_edge_at(&e, w->x, w->y), reach = ((e.a < 0 ? -e.a : e.a) + (e.b < 0 ? -e.b : e.b)) * w->half;
        const i64x4       middle = at + turned(e.a * w->step, left) + turned(e.b * w->step, below), least = middle - reach;
        missed |= middle + reach;
        uncovered |= least;
        unsampled |= middle;
        if (t->ends >> k & 1) {
            uint32_t crossed = i64x4_negative(least);
            if (crossed) q.ended |= crossed & ~apart_from(w, t, k);
        }
    }
    q.missed |= i64x4_negative(missed);
    q.uncovered = i64x4_negative(uncovered);
    q.unsampled = i64x4_negative(unsampled);
    return q;
}

/* Add the triangle to a list with spare capacity, unless the quarter is missed. */
static inline void add(square_list *l, const quarter_answer *q, int quarter, uint32_t id, int holed)
{
    uint32_t bits = (q->uncovered >> quarter & 1 ? 0u : ENTRY_COVERS) | (q->unsampled >> quarter & 1 ? 0u : ENTRY_SAMPLE) |
                    (q->ended >> quarter & 1 ? ENTRY_END : 0u);
    if (holed) bits = ENTRY_END; /* it may cover any texels */
    l->items[l->count] = (square_entry){q->lo[quarter], q->hi[quarter], id, bits};
    l->count += !(q->missed >> quarter & 1);
}

static int make_room(square_list *l)
{
    return array_reserve(&l->items, &l->capacity, l->count + AT_ONCE, sizeof *l->items);
}

int AT_LEVEL(square_list_gather)(square_list *l, const sparse_triangles *s, const uint32_t *ids, size_t count, texel_square square)
{
    const splitter w = splitter_of(s, square, square.side);
    l->count         = 0;
    for (size_t n = 0; n < count; n++) {
        if (n % AT_ONCE == 0 && !make_room(l)) return 0;
        const sparse_triangle *t = &s->all[ids[n]];
        quarter_answer         q = ask(&w, t, 0);
        add(l, &q, 0, ids[n], t->kind & SPARSE_HOLED);
    }
    return 1;
}

int AT_LEVEL(square_list_split)(square_list quarter[4], const sparse_triangles *s, const square_list *l, texel_square square)
{
    const splitter w = splitter_of(s, square, square.side / 2);
    for (int k = 0; k < QUARTERS; k++) quarter[k].count = 0;
    for (size_t n = 0; n < l->count; n++) {
        for (int k = 0; k < QUARTERS && n % AT_ONCE == 0; k++)
            if (!make_room(&quarter[k])) return 0;
        const square_entry    *e = &l->items[n];
        const sparse_triangle *t = &s->all[e->id];
        quarter_answer         q = ask(&w, t, e->bits & ENTRY_COVERS);
        for (int k = 0; k < QUARTERS; k++) add(&quarter[k], &q, k, e->id, t->kind & SPARSE_HOLED);
    }
    return 1;
}
