/* Columns from formulas: a source that shares nothing with a renderer, of maps of any size.
 *
 * One shape in a map of side_px texels and as many voxels, in units of texels and voxels, u and v at the centres of texels:
 *
 *     box      [low, high) in u and v, from low to high in depth; a solid
 *     sphere   about a centre; a solid
 *     planes   the nearest of some planes, depth = a u + b v + c; sheets, without an inside
 *
 * Bounds are worked out for a square of any size: exact for a box, loose by the distance of texel centres for the others.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ANALYTIC_H
#define ANALYTIC_H

#include <math.h>
#include <stdatomic.h>
#include <stdint.h>

#include "baker/columns/columns.h"

typedef enum analytic_kind { ANALYTIC_BOX, ANALYTIC_SPHERE, ANALYTIC_PLANES, ANALYTIC_KINDS } analytic_kind;

enum { ANALYTIC_PLANES_MAX = 4 };

typedef struct analytic {
    analytic_kind kind;
    uint32_t      side_px;                       /* [8, 2^18] a power of two; also the depth */
    uint32_t      fetch_px;                      /* the widest square that is fetched */
    double        low[3], high[3];               /* box */
    double        centre[3], radius;             /* sphere */
    double        plane[ANALYTIC_PLANES_MAX][3]; /* a, b, c */
    uint32_t      plane_count;

    atomic_ullong calls;      /* of bounds and tile, on maps and squares, of open and fetch */
    atomic_ullong tile_calls; /* of tile alone */
    uint64_t      fail_at;    /* the number of the call that fails, from 1; 0: none */
    vxs_result    failure;
    atomic_int    open; /* maps and squares that were not closed and released */
} analytic;

/* Depths at a point, in voxels: where light enters, and where it first leaves. side_px, twice, where there is nothing. */
static inline void analytic_depths(const analytic *a, double u, double v, double *enter, double *exit)
{
    *enter = *exit = a->side_px;
    if (a->kind == ANALYTIC_BOX && u >= a->low[0] && u < a->high[0] && v >= a->low[1] && v < a->high[1]) {
        *enter = a->low[2];
        *exit  = a->high[2];
    }
    if (a->kind == ANALYTIC_SPHERE) {
        double du = u - a->centre[0], dv = v - a->centre[1], rest = a->radius * a->radius - du * du - dv * dv;
        if (rest >= 0) {
            *enter = a->centre[2] - sqrt(rest);
            *exit  = a->centre[2] + sqrt(rest);
        }
    }
    for (uint32_t n = 0; a->kind == ANALYTIC_PLANES && n < a->plane_count; n++)
        *enter = *exit = fmin(*enter, fmax(0, a->plane[n][0] * u + a->plane[n][1] * v + a->plane[n][2]));
}

static inline vxs_result analytic_call(analytic *a)
{
    return atomic_fetch_add(&a->calls, 1) + 1 == a->fail_at ? a->failure : VXS_OK;
}

static inline column_bounds analytic_box_bounds(const analytic *a, const double low[2], const double high[2])
{
    uint32_t n = a->side_px, e = (uint32_t)floor(a->low[2]), x = (uint32_t)ceil(a->high[2]);
    /* the first and the last texel centre of the square */
    int      any = 1, all = 1;
    for (int axis = 0; axis < 2; axis++) {
        any &= high[axis] >= a->low[axis] && low[axis] < a->high[axis] && ceil(a->low[axis] - 0.5) + 0.5 < a->high[axis];
        all &= low[axis] >= a->low[axis] && high[axis] < a->high[axis];
    }
    return all ? (column_bounds){e, e, x, x} : any ? (column_bounds){e, n, x, n} : bounds_empty(n);
}

static inline column_bounds analytic_sphere_bounds(const analytic *a, const double low[2], const double high[2])
{
    double nearest = 0, farthest = 0, r2 = a->radius * a->radius, z = a->centre[2];
    for (int axis = 0; axis < 2; axis++) {
        double c = a->centre[axis], to = c < low[axis] ? low[axis] - c : c > high[axis] ? c - high[axis] : 0;
        double from = fmax(fabs(low[axis] - c), fabs(high[axis] - c));
        nearest += to * to;
        farthest += from * from;
    }
    if (nearest > r2) return bounds_empty(a->side_px);
    double        deepest = sqrt(r2 - nearest), least = farthest <= r2 ? sqrt(r2 - farthest) : 0;
    column_bounds b = {(uint32_t)floor(z - deepest), a->side_px, (uint32_t)ceil(z + least), a->side_px};
    if (farthest <= r2) b.emax = (uint32_t)floor(z - least), b.xmax = (uint32_t)ceil(z + deepest);
    return b;
}

static inline column_bounds analytic_plane_bounds(const analytic *a, const double low[2], const double high[2])
{
    double nearest = a->side_px, farthest = a->side_px; /* over the square, of the nearest plane */
    for (uint32_t n = 0; n < a->plane_count; n++) {
        const double *p     = a->plane[n];
        double        least = p[2], most = p[2];
        for (int axis = 0; axis < 2; axis++) {
            least += fmin(p[axis] * low[axis], p[axis] * high[axis]);
            most += fmax(p[axis] * low[axis], p[axis] * high[axis]);
        }
        nearest  = fmin(nearest, fmax(0, least));
        farthest = fmin(farthest, fmax(0, most));
    }
    return (column_bounds){(uint32_t)floor(nearest), (uint32_t)floor(farthest), (uint32_t)ceil(nearest), (uint32_t)ceil(farthest)};
}

/* Of the square of `side` texels whose first texel is (u, v). */
static inline column_bounds analytic_bounds_at(const analytic *a, uint32_t u, uint32_t v, uint32_t side)
{
    double low[2] = {u + 0.5, v + 0.5}, high[2] = {u + side - 0.5, v + side - 0.5};
    if (a->kind == ANALYTIC_BOX) return analytic_box_bounds(a, low, high);
    return a->kind == ANALYTIC_SPHERE ? analytic_sphere_bounds(a, low, high) : analytic_plane_bounds(a, low, high);
}

/* the seam -------------------------------------------------------------------------------------------------------------------- */

static inline vxs_result analytic_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    analytic *a = data;
    *out        = analytic_bounds_at(a, i * (8u << level), j * (8u << level), 8u << level);
    return analytic_call(a);
}

/* A fetched square: the source, and where it starts. */
typedef struct analytic_square {
    analytic *a;
    uint32_t  u, v;
} analytic_square;

static inline vxs_result analytic_square_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    analytic_square *s    = data;
    uint32_t         side = 8u << level;
    *out                  = analytic_bounds_at(s->a, s->u + i * side, s->v + j * side, side);
    return analytic_call(s->a);
}

static inline vxs_result analytic_tile(void *data, uint32_t i, uint32_t j, column_tile *out)
{
    analytic_square *s = data;
    for (uint32_t n = 0; n < 64; n++) {
        double e, x;
        analytic_depths(s->a, s->u + 8 * i + n % 8 + 0.5, s->v + 8 * j + n / 8 + 0.5, &e, &x);
        out->e[n] = (uint32_t)floor(e);
        out->x[n] = (uint32_t)ceil(x);
    }
    atomic_fetch_add(&s->a->tile_calls, 1);
    return analytic_call(s->a);
}

static inline vxs_result analytic_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    analytic        *a    = data;
    uint32_t         side = 8u << level;
    analytic_square *s    = malloc(sizeof *s);
    vxs_result       r    = s ? analytic_call(a) : VXS_E_MEMORY;
    (void)ctx;
    *out = (column_square){0};
    if (r != VXS_OK) {
        free(s);
        return r;
    }
    *s   = (analytic_square){a, i * side, j * side};
    *out = (column_square){.data     = s,
                           .side_px  = side,
                           .depth_vx = a->side_px,
                           .u_px     = s->u,
                           .v_px     = s->v,
                           .bounds   = analytic_square_bounds,
                           .tile     = analytic_tile};
    atomic_fetch_add(&a->open, 1);
    return VXS_OK;
}

static inline void analytic_release(void *data, column_square *square)
{
    atomic_fetch_sub(&((analytic *)data)->open, 1);
    free(square->data);
}

static inline void analytic_close(void *data)
{
    atomic_fetch_sub(&((analytic *)data)->open, 1);
}

/* All maps of the source are the same. */
static inline vxs_result analytic_open(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    analytic  *a = data;
    vxs_result r = analytic_call(a);
    (void)map;
    (void)ctx;
    *out = (column_map){0};
    if (r != VXS_OK) return r;
    *out = (column_map){.data     = a,
                        .side_px  = a->side_px,
                        .depth_vx = a->side_px,
                        .fetch_px = a->fetch_px,
                        .bounds   = analytic_bounds,
                        .fetch    = analytic_fetch,
                        .release  = analytic_release,
                        .close    = analytic_close};
    atomic_fetch_add(&a->open, 1);
    return VXS_OK;
}

static inline column_source analytic_source(analytic *a)
{
    return (column_source){.data = a, .map_count = 1, .open = analytic_open};
}

/* A shape in the middle of a map. Its edges lie within tiles of 8 x 8 texels at every size, never between them. */
static inline analytic analytic_shape(analytic_kind kind, uint32_t side_px)
{
    double n = side_px;
    return (analytic){.kind        = kind,
                      .side_px     = side_px,
                      .fetch_px    = side_px,
                      .low         = {n / 3, n * 2 / 7, n / 3},
                      .high        = {n * 2 / 3, n * 5 / 7, n * 4 / 7},
                      .centre      = {0.4937 * n, 0.5113 * n, 0.4471 * n},
                      .radius      = 0.2311 * n,
                      .plane       = {{0, 0, 0.7193 * n}, {0.3137, -0.2219, 0.4177 * n}, {-0.4471, 0.1193, 0.6911 * n}},
                      .plane_count = 3};
}

#endif
