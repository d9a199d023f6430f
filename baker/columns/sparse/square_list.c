/* Triangles against squares; see square_list.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_list.h"

#include <math.h>

#include "baker/base/array.h"
#include "baker/base/integer.h"

enum { HALF_PX = SUBTEXELS_PER_PX / 2 };

/* An edge, and how far its function goes from the middle of a square to the corners of its box. */
typedef struct square_edge {
    sparse_edge edge;
    double      reach;
    double      x0, x1, y0, y1; /* the box of the edge */
    int         is_end;
} square_edge;

/* A triangle as squares of one size are asked about it. */
typedef struct asked_triangle {
    const sparse_triangle *t;
    square_edge            edge[3];
    int                    edges; /* 3; 0 where it is known to cover the squares */
    double                 half;  /* of the side of the box of a square's texel centres */
    double                 rise;  /* of depth, over it */
} asked_triangle;

static asked_triangle ask_about(const sparse_triangle *t, uint32_t side, int covers)
{
    asked_triangle a;
    a.t     = t;
    a.half  = (double)(side - 1) * HALF_PX;
    a.edges = covers ? 0 : 3;
    a.rise  = (fabs(t->gx) + fabs(t->gy)) * a.half + t->slack;
    for (int k = 0; k < a.edges; k++) {
        int         n = k < 2 ? k + 1 : 0;
        sparse_edge e = sparse_edge_of(t, k);
        a.edge[k]     = (square_edge){.edge   = e,
                                      .reach  = (fabs(e.a) + fabs(e.b)) * a.half,
                                      .x0     = min_i32(t->x[k], t->x[n]),
                                      .x1     = max_i32(t->x[k], t->x[n]),
                                      .y0     = min_i32(t->y[k], t->y[n]),
                                      .y1     = max_i32(t->y[k], t->y[n]),
                                      .is_end = t->ends >> k & 1};
    }
    return a;
}

/* Two squares of a row: the bits of those that the triangle may touch. */
typedef struct pair_answer {
    uint32_t touched, covered, sampled, ended;
    f64x2    lo, hi;
} pair_answer;

/* x, y  centres of the squares, subtexels */
static pair_answer ask_pair(const asked_triangle *a, f64x2 x, double y)
{
    f64x2 half = f64x2_all(a->half), zero = f64x2_all(0);
    i64x2 touched = {-1, -1}, covered = {-1, -1}, sampled = {-1, -1}, ended = {0, 0};
    f64x2 middle = f64x2_all(a->t->zmin + a->t->gy * (y - a->t->y[0])) + f64x2_all(a->t->gx) * (x - f64x2_all(a->t->x[0]));
    f64x2 lo     = f64x2_max(middle - f64x2_all(a->rise), f64x2_all(a->t->zmin));
    f64x2 hi     = f64x2_min(middle + f64x2_all(a->rise), f64x2_all(a->t->zmax));
    touched &= lo <= hi; /* else the plane passes the square out of the triangle's range */
    for (int k = 0; k < a->edges; k++) {
        const square_edge *e  = &a->edge[k];
        f64x2              at = f64x2_all(e->edge.a) * x + f64x2_all(e->edge.b * y + e->edge.c), reach = f64x2_all(e->reach);
        i64x2              crossed = at < reach; /* some of the box is outside by this edge */
        touched &= at + reach >= zero;
        covered &= ~crossed;
        sampled &= at >= zero;
        if (!e->is_end || e->y0 > y + a->half || e->y1 < y - a->half) continue;
        ended |= crossed & (f64x2_all(e->x0) <= x + half) & (f64x2_all(e->x1) >= x - half);
    }
    return (pair_answer){i64x2_bits(touched), i64x2_bits(covered), i64x2_bits(sampled), i64x2_bits(ended), lo, hi};
}

static int add(square_list *l, const pair_answer *p, int lane, uint32_t id, int holed)
{
    if (!(p->touched >> lane & 1)) return 1;
    if (l->count == l->capacity && !array_reserve(&l->items, &l->capacity, l->count + 1, sizeof *l->items)) return 0;
    uint32_t bits = (p->covered >> lane & 1 ? ENTRY_COVERS : 0u) | (p->sampled >> lane & 1 ? ENTRY_SAMPLE : 0u) |
                    (p->ended >> lane & 1 ? ENTRY_END : 0u);
    if (holed) bits = ENTRY_END; /* it covers nothing for sure, and may be anywhere */
    l->items[l->count++] = (square_entry){p->lo[lane], p->hi[lane], id, bits};
    return 1;
}

static double centre_of(uint32_t texel, uint32_t side)
{
    return (double)texel * SUBTEXELS_PER_PX + (double)side * HALF_PX;
}

int square_list_gather(square_list *l, const sparse_triangles *s, const uint32_t *ids, size_t count, texel_square square)
{
    double x = centre_of(square.u, square.side), y = centre_of(square.v, square.side);
    l->count = 0;
    for (size_t n = 0; n < count; n++) {
        const sparse_triangle *t = &s->all[ids[n]];
        asked_triangle         a = ask_about(t, square.side, 0);
        pair_answer            p = ask_pair(&a, f64x2_all(x), y);
        if (!add(l, &p, 0, ids[n], t->kind & SPARSE_HOLED)) return 0;
    }
    return 1;
}

int square_list_split(square_list quarter[4], const sparse_triangles *s, const square_list *l, texel_square square)
{
    uint32_t side = square.side / 2;
    f64x2    x    = {centre_of(square.u, side), centre_of(square.u + side, side)};
    double   y[2] = {centre_of(square.v, side), centre_of(square.v + side, side)};
    for (int k = 0; k < 4; k++) quarter[k].count = 0;
    for (size_t n = 0; n < l->count; n++) {
        const square_entry    *e = &l->items[n];
        const sparse_triangle *t = &s->all[e->id];
        asked_triangle         a = ask_about(t, side, e->bits & ENTRY_COVERS);
        for (int row = 0; row < 2; row++) {
            pair_answer p = ask_pair(&a, x, y[row]);
            for (int lane = 0; lane < 2; lane++)
                if (!add(&quarter[2 * row + lane], &p, lane, e->id, t->kind & SPARSE_HOLED)) return 0;
        }
    }
    return 1;
}
