/* Triangles against squares; see square_list.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_list.h"
#include "baker/base/array.h"
#include "baker/columns/sparse/lanes.h"

enum { QUARTERS = 4, VECTORS = LANES < 4 ? 2 : 1 }; /* vectors that hold them */

/* A number for each quarter; of wider vectors the rest repeats them. */
typedef struct i64_quarters {
    i64s v[VECTORS];
} i64_quarters;

typedef struct f64_quarters {
    f64s v[VECTORS];
} f64_quarters;

/* What is asked of all triangles. */
typedef struct splitter {
    int64_t      x, y;        /* middle of the square, subtexels */
    int64_t      step;        /* from there to the middles of quarters, along x and along y; 0: all of them are the square itself */
    int64_t      half;        /* of the side of the box of a quarter's texel centres */
    i64_quarters left, below; /* masks of quarters */
    f64_quarters middle_x, middle_y;
} splitter;

static splitter splitter_of(const sparse_triangles *s, texel_square square, uint32_t side)
{
    splitter w = {.x    = ((int64_t)(2 * square.u + square.side) << s->grid) / 2,
                  .y    = ((int64_t)(2 * square.v + square.side) << s->grid) / 2,
                  .step = ((int64_t)(square.side - side) << s->grid) / 2,
                  .half = ((int64_t)(side - 1) << s->grid) / 2};
    for (int n = 0; n < VECTORS * LANES; n++) {
        int64_t left = n & 1 ? 0 : -1, below = n & 2 ? 0 : -1;
        w.left.v[n / LANES][n % LANES]     = left;
        w.below.v[n / LANES][n % LANES]    = below;
        w.middle_x.v[n / LANES][n % LANES] = (double)(left ? w.x - w.step : w.x + w.step);
        w.middle_y.v[n / LANES][n % LANES] = (double)(below ? w.y - w.step : w.y + w.step);
    }
    return w;
}

/* The number, or less than nothing of it where the mask is. */
static i64s turned(int64_t number, i64s mask)
{
    return (i64s_all(number) ^ mask) - mask;
}

/* Quarters as bits. */
typedef struct quarter_answer {
    uint32_t missed, uncovered, unsampled, ended;
    double   lo[VECTORS * LANES], hi[VECTORS * LANES];
} quarter_answer;

static uint32_t negative(const i64_quarters *q)
{
    uint32_t bits = 0;
    for (int n = 0; n < VECTORS; n++) bits |= i64s_negative(q->v[n]) << n * LANES;
    return bits;
}

/* Quarters whose box the box of an edge does not touch. */
static uint32_t apart_from(const splitter *w, const sparse_triangle *t, int k)
{
    const int     next = k < 2 ? k + 1 : 0;
    const int64_t x0 = min_i32(t->x[k], t->x[next]) - w->half - w->x, x1 = max_i32(t->x[k], t->x[next]) + w->half - w->x;
    const int64_t y0 = min_i32(t->y[k], t->y[next]) - w->half - w->y, y1 = max_i32(t->y[k], t->y[next]) + w->half - w->y;
    uint32_t      apart = 0;
    if (x1 < w->step || x0 > w->step) apart |= 10; /* the right ones */
    if (x1 < -w->step || x0 > -w->step) apart |= 5;
    if (y1 < w->step || y0 > w->step) apart |= 12; /* the upper ones */
    if (y1 < -w->step || y0 > -w->step) apart |= 3;
    return apart;
}

static void ask_edges(quarter_answer *q, const splitter *w, const sparse_triangle *t)
{
    i64_quarters outside[3] = {0}; /* the box, some of it, its middle */
    for (int k = 0; k < 3; k++) {
        const sparse_edge e  = sparse_edge_of(t, k);
        const int64_t     at = sparse_edge_at(&e, w->x, w->y), across = e.a * w->step, along = e.b * w->step;
        const i64s        reach   = i64s_all(((e.a < 0 ? -e.a : e.a) + (e.b < 0 ? -e.b : e.b)) * w->half);
        uint32_t          crossed = 0;
        for (int n = 0; n < VECTORS; n++) {
            i64s middle = i64s_all(at) + turned(across, w->left.v[n]) + turned(along, w->below.v[n]);
            i64s most = middle + reach, least = middle - reach;
            outside[0].v[n] |= most;
            outside[1].v[n] |= least;
            outside[2].v[n] |= middle;
            crossed |= i64s_negative(least) << n * LANES;
        }
        if (t->ends >> k & 1 && crossed) q->ended |= crossed & ~apart_from(w, t, k);
    }
    q->missed |= negative(&outside[0]);
    q->uncovered = negative(&outside[1]);
    q->unsampled = negative(&outside[2]);
}

/* Between which depths the triangle lies in each quarter. Where there are none, the plane passes the quarter out of the triangle's range. */
static void ask_depth(quarter_answer *q, const splitter *w, const sparse_triangle *t)
{
    const f64s   x0 = f64s_all(t->x[0]), y0 = f64s_all(t->y[0]), gx = f64s_all(t->gx), gy = f64s_all(t->gy);
    const double steep = (t->gx < 0 ? -t->gx : t->gx) + (t->gy < 0 ? -t->gy : t->gy);
    const f64s   rise = f64s_all(steep * (double)w->half + t->slack), zmin = f64s_all(t->zmin), zmax = f64s_all(t->zmax);
    for (int n = 0; n < VECTORS; n++) {
        f64s middle = zmin + gy * (w->middle_y.v[n] - y0) + gx * (w->middle_x.v[n] - x0);
        f64s lo = f64s_max(middle - rise, zmin), hi = f64s_min(middle + rise, zmax);
        f64s_store(q->lo + n * LANES, lo);
        f64s_store(q->hi + n * LANES, hi);
        q->missed |= i64s_negative((i64s)(lo > hi)) << n * LANES;
    }
}

static int add(square_list *l, const quarter_answer *q, int quarter, uint32_t id, int holed)
{
    if (q->missed >> quarter & 1) return 1;
    if (l->count == l->capacity && !array_reserve(&l->items, &l->capacity, l->count + 1, sizeof *l->items)) return 0;
    uint32_t bits = (q->uncovered >> quarter & 1 ? 0u : ENTRY_COVERS) | (q->unsampled >> quarter & 1 ? 0u : ENTRY_SAMPLE) |
                    (q->ended >> quarter & 1 ? ENTRY_END : 0u);
    if (holed) bits = ENTRY_END; /* it covers nothing for sure, and may be anywhere */
    l->items[l->count++] = (square_entry){q->lo[quarter], q->hi[quarter], id, bits};
    return 1;
}

static quarter_answer ask(const splitter *w, const sparse_triangle *t, int covers)
{
    quarter_answer q = {.missed = 0};
    ask_depth(&q, w, t);
    if (!covers) ask_edges(&q, w, t);
    return q;
}

int AT_LEVEL(square_list_gather)(square_list *l, const sparse_triangles *s, const uint32_t *ids, size_t count, texel_square square)
{
    const splitter w = splitter_of(s, square, square.side);
    l->count         = 0;
    for (size_t n = 0; n < count; n++) {
        const sparse_triangle *t = &s->all[ids[n]];
        quarter_answer         q = ask(&w, t, 0);
        if (!add(l, &q, 0, ids[n], t->kind & SPARSE_HOLED)) return 0;
    }
    return 1;
}

int AT_LEVEL(square_list_split)(square_list quarter[4], const sparse_triangles *s, const square_list *l, texel_square square)
{
    const splitter w = splitter_of(s, square, square.side / 2);
    for (int k = 0; k < QUARTERS; k++) quarter[k].count = 0;
    for (size_t n = 0; n < l->count; n++) {
        const square_entry    *e = &l->items[n];
        const sparse_triangle *t = &s->all[e->id];
        quarter_answer         q = ask(&w, t, e->bits & ENTRY_COVERS);
        for (int k = 0; k < QUARTERS; k++)
            if (!add(&quarter[k], &q, k, e->id, t->kind & SPARSE_HOLED)) return 0;
    }
    return 1;
}
