/* Triangles against squares; see square_list.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_list.h"

#include <stdlib.h>

#include "baker/columns/sparse/lanes.h"

enum { QUARTERS = 4, LOADED_AHEAD = 16, LEAST_CAPACITY = 64 };

/* Constants for all triangles. */
typedef struct splitter {
    const sparse_triangles *s;
    int64_t                 x, y;      /* middle of the square, subtexels */
    int64_t                 step;      /* from there to the centres of the quarters, along x and y; 0: one square, not quarters */
    int64_t                 half;      /* of the side of the box of a quarter's texel centres */
    uint32_t                side_log2; /* of half of a quarter's side, subtexels */
    double                  middle_x[2], middle_y[2];
} splitter;

static splitter splitter_of(const sparse_triangles *s, texel_square square, uint32_t side)
{
    const int64_t x    = ((int64_t)(2 * square.u + square.side) << s->grid) / 2,
                  y    = ((int64_t)(2 * square.v + square.side) << s->grid) / 2;
    const int64_t step = ((int64_t)(square.side - side) << s->grid) / 2, half = ((int64_t)(side - 1) << s->grid) / 2;
    return (splitter){.s         = s,
                      .x         = x,
                      .y         = y,
                      .step      = step,
                      .half      = half,
                      .side_log2 = log2_u32(side) + s->grid - 1,
                      .middle_x  = {(double)(x - step), (double)(x + step)},
                      .middle_y  = {(double)(y - step), (double)(y + step)}};
}

/* LANES triangles: one in each element. */
typedef struct triangle_lanes {
    lanes_corners corners;
    f64s          x0, y0, zmin, zmax, gx, gy, slack;
    u64s          id, tags;
} triangle_lanes;

static inline triangle_lanes load(const sparse_triangles *s, const uint32_t ids[LANES])
{
#define TRIANGLE(n) (&s->all[ids[n]])
#define X0(n)       TRIANGLE(n)->x[0]
#define Y0(n)       TRIANGLE(n)->y[0]
#define ZMIN(n)     TRIANGLE(n)->zmin
#define ZMAX(n)     TRIANGLE(n)->zmax
#define GX(n)       TRIANGLE(n)->gx
#define GY(n)       TRIANGLE(n)->gy
#define SLACK(n)    TRIANGLE(n)->slack
#define ID(n)       ids[n]
#define TAGS(n)     eight_bytes(&s->tags[ids[n]])
    return (triangle_lanes){.corners = lanes_corners_of(s, ids),
                            .x0      = EACH_LANE(X0),
                            .y0      = EACH_LANE(Y0),
                            .zmin    = EACH_LANE(ZMIN),
                            .zmax    = EACH_LANE(ZMAX),
                            .gx      = EACH_LANE(GX),
                            .gy      = EACH_LANE(GY),
                            .slack   = EACH_LANE(SLACK),
                            .id      = EACH_LANE(ID),
                            .tags    = EACH_LANE(TAGS)};
}

/* Results for a quarter: negative elements mean yes. */
typedef struct quarter_answer {
    i64s missed, uncovered, unsampled, ended;
    f64s lo, hi;
} quarter_answer;

static inline f64s f64s_absolute(f64s v)
{
    return (f64s)((i64s)v & INT64_MAX);
}

/* Depth range of the triangles in a quarter. If it is empty, the plane is outside the triangle's depth range there. */
static inline quarter_answer depths_in(const splitter *w, const triangle_lanes *t, int quarter)
{
    const f64s     rise  = (f64s_absolute(t->gx) + f64s_absolute(t->gy)) * (double)w->half + t->slack;
    const f64s     depth = t->zmin + t->gy * (w->middle_y[quarter >> 1] - t->y0) + t->gx * (w->middle_x[quarter & 1] - t->x0);
    quarter_answer q     = {.lo = f64s_max(depth - rise, t->zmin), .hi = f64s_min(depth + rise, t->zmax)};
    q.missed             = (i64s)(q.lo > q.hi);
    return q;
}

/* Put the edge from corner k to the next into the answers. */
static inline void ask_edge(const splitter *w, const triangle_lanes *t, int k, quarter_answer *answers, int count)
{
    const lanes_edge e = lanes_edge_of(&t->corners, k, w->x, w->y);

    /* half of the side of the box of texel centres is that of the quarter, less half a texel */
    const i64s both = i64s_length(e.a) + i64s_length(e.b), reach = (both << w->side_log2) - (both << (w->s->grid - 1));

    /* the box of the edge, with `half` around it, from the middle */
    const i64s ends = (i64s)(t->tags << (63 - (40 + (uint32_t)k))), a_sign = e.a >> 63, b_sign = e.b >> 63;
    const i64s x0 = (e.b & b_sign) - w->half - e.dx, x1 = (e.b & ~b_sign) + w->half - e.dx;
    const i64s y0 = (-e.a & ~a_sign) - w->half - e.dy, y1 = (-e.a & a_sign) + w->half - e.dy;

    const i64s along_x = e.a << w->side_log2, along_y = e.b << w->side_log2;
    for (int n = 0; n < count; n++) {
        const int64_t x = n & 1 ? w->step : -w->step, y = n & 2 ? w->step : -w->step;
        const i64s    middle = count == 1 ? e.at : e.at + (n & 1 ? along_x : -along_x) + (n & 2 ? along_y : -along_y);
        const i64s    less = middle - reach, apart = (x1 - x) | (x - x0) | (y1 - y) | (y - y0);
        answers[n].missed |= middle + reach;
        answers[n].uncovered |= less;
        answers[n].unsampled |= middle;
        answers[n].ended |= less & ends & ~apart;
    }
}

/* Add the triangles in `valid` elements to a list, unless the quarter is missed. */
static inline void add(square_list *l, const triangle_lanes *t, const quarter_answer *q, uint32_t valid)
{
    const u64s holed = (u64s)((i64s)(t->tags << (63 - 34)) >> 63); /* it may cover any texels */
    u64s       bits  = ((u64s)~q->uncovered >> 63) * ENTRY_COVERS | ((u64s)q->ended >> 63) * ENTRY_END |
                ((u64s)~q->unsampled >> 63) * ENTRY_SAMPLE;
    bits                = (bits & ~holed) | (ENTRY_END & holed);
    const uint32_t kept = ~i64s_negative(q->missed) & valid;
    lanes_pack(l->lo + l->count, kept, (i64s)q->lo);
    lanes_pack(l->hi + l->count, kept, (i64s)q->hi);
    lanes_pack(l->items + l->count, kept, (i64s)(t->id | bits << 32));
    lanes_pack(l->tags + l->count, kept, (i64s)t->tags);
    l->count += (size_t)__builtin_popcount(kept);
}

/* Add triangles to the lists of quarters, or to one list.   covers  those that cover the larger square */
static inline void ask(const splitter *w, const triangle_lanes *t, i64s covers, square_list *lists, int count, uint32_t valid)
{
    quarter_answer answers[QUARTERS];
    const i64s     tested = ~covers;
    for (int n = 0; n < count; n++) answers[n] = depths_in(w, t, n);
    if (i64s_negative(tested)) {
        quarter_answer edges[QUARTERS] = {0};
        for (int k = 0; k < 3; k++) ask_edge(w, t, k, edges, count);
        for (int n = 0; n < count; n++) {
            answers[n].missed |= edges[n].missed & tested;
            answers[n].uncovered = edges[n].uncovered & tested;
            answers[n].unsampled = edges[n].unsampled & tested;
            answers[n].ended     = edges[n].ended & tested;
        }
    }
    for (int n = 0; n < count; n++) add(&lists[n], t, &answers[n], valid);
}

/* Empty a list, with room for `count` entries and those that lanes_pack stores after them. */
static int empty(square_list *l, size_t count)
{
    l->count = 0;
    if (count <= l->capacity && l->lo) return 1;
    size_t room = LEAST_CAPACITY;
    while (room < count) room *= 2;
    free(l->lo);
    *l = (square_list){.lo       = malloc((room + LANES_MAX) * (2 * sizeof *l->lo + sizeof *l->items + sizeof *l->tags)),
                       .capacity = room};
    if (!l->lo) return 0;
    l->hi    = l->lo + room + LANES_MAX;
    l->items = (square_entry *)(l->hi + room + LANES_MAX);
    l->tags  = (sparse_tags *)(l->items + room + LANES_MAX);
    return 1;
}

int AT_LEVEL(square_list_gather)(square_list *l, const sparse_triangles *s, const uint32_t *ids, size_t count, texel_square square)
{
    const splitter w = splitter_of(s, square, square.side);
    if (!empty(l, count)) return 0;
    for (size_t n = 0; n < count; n += LANES) {
        uint32_t some[LANES];
        for (size_t k = 0; k < LANES; k++) {
            some[k] = ids[n + k < count ? n + k : count - 1];
            __builtin_prefetch(&s->all[ids[n + k + LOADED_AHEAD < count ? n + k + LOADED_AHEAD : count - 1]]);
        }
        const triangle_lanes t = load(s, some);
        ask(&w, &t, i64s_all(0), l, 1, count - n < LANES ? (1u << (count - n)) - 1 : ALL_LANES);
    }
    return 1;
}

int AT_LEVEL(square_list_split)(square_list quarter[4], const sparse_triangles *s, const square_list *l, texel_square square)
{
    const splitter w = splitter_of(s, square, square.side / 2);
    for (int k = 0; k < QUARTERS; k++)
        if (!empty(&quarter[k], l->count)) return 0;
    for (size_t n = 0; n < l->count; n += LANES) {
        uint32_t some[LANES];
        u64s     covers = {0};
        for (size_t k = 0; k < LANES; k++) {
            const square_entry e = l->items[n + k < l->count ? n + k : l->count - 1];
            some[k]              = e.id;
            covers[k]            = e.bits & ENTRY_COVERS;
        }
        const triangle_lanes t = load(s, some);
        ask(&w, &t, -(i64s)covers, quarter, QUARTERS, l->count - n < LANES ? (1u << (l->count - n)) - 1 : ALL_LANES);
    }
    return 1;
}
