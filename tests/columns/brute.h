/* Columns by brute force: every triangle of a projection against every texel of the cells that its box touches. Coverage is whole
 * numbers, depth is corners weighed by areas in long double; lists, patches, planes and vectors take no part.
 *
 * A depth is given as a range, a hair wide, in voxels: faces that lie within it of each other may have swapped places, and then
 * light may leave at several depths. What has to be lit is before e_least, what has to be dark behind x_most.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BRUTE_H
#define BRUTE_H

#include <math.h>
#include <stdlib.h>

#include "baker/columns/columns.h"
#include "baker/light/projection.h"
#include "baker/scene/scene.h"

typedef struct brute_column {
    double e_least, e_most, x_least, x_most; /* voxels */
} brute_column;

typedef struct brute {
    const projection *p;
    uint32_t          side_px;
    depth_scale       scale;
    int               nearest_back;
    int               free_behind; /* 1: free behind the last surface; set by whoever wants it, as is thickness */
    double            thickness;   /* of sheets: voxels of a directional light, else near distances */
    int64_t           grid;
    uint32_t          cell_px, across; /* of a cell; cells a side */
    size_t           *first;           /* [across^2 + 1] cell n may be touched by triangles ids[first[n]] to ids[first[n + 1]] */
    uint32_t         *ids;
} brute;

enum { BRUTE_HITS_MAX = 4096 };

typedef struct brute_hit {
    double depth; /* voxels */
    int    solid, front;
    int    thick; /* of a sheet that faces the light, and is seen from one side */
} brute_hit;

static inline int64_t brute_grid(const brute *b, double texels)
{
    return (int64_t)floor(texels * (double)b->grid + 0.5);
}

static inline void brute_corners(const brute *b, uint32_t t, int64_t x[3], int64_t y[3])
{
    for (int k = 0; k < 3; k++) {
        x[k] = brute_grid(b, b->p->vertices[b->p->indices[3 * (size_t)t + (size_t)k]].u);
        y[k] = brute_grid(b, b->p->vertices[b->p->indices[3 * (size_t)t + (size_t)k]].v);
    }
}

/* The cells of coordinates, in one direction: [*begin, *end). */
static inline void brute_range(const brute *b, const int64_t at[3], uint32_t *begin, uint32_t *end)
{
    int64_t low = at[0] < at[1] ? at[0] : at[1], high = at[0] > at[1] ? at[0] : at[1], cell = b->cell_px * b->grid;
    low    = low < at[2] ? low : at[2];
    high   = high > at[2] ? high : at[2];
    *begin = low < 0 ? 0 : (uint32_t)(low / cell < b->across ? low / cell : b->across);
    *end   = high < 0 ? 0 : (uint32_t)(high / cell < b->across ? high / cell + 1 : b->across);
}

/* Count the triangles of each cell, or note them. */
static inline void brute_walk(brute *b, int note)
{
    for (uint32_t t = 0; t < b->p->triangle_count; t++) {
        int64_t  x[3], y[3];
        uint32_t i0, i1, j0, j1;
        brute_corners(b, t, x, y);
        brute_range(b, x, &i0, &i1);
        brute_range(b, y, &j0, &j1);
        for (uint32_t j = j0; j < j1; j++)
            for (uint32_t i = i0; i < i1; i++) {
                size_t *at = &b->first[(size_t)j * b->across + i + 1];
                if (note) b->ids[*at] = t;
                at[!note]++;
            }
    }
}

enum { BRUTE_CELLS_MAX = 256 };

/* grid  subtexels of a texel that corners are snapped to
 * Returns 0 without memory; released with brute_free either way. p is borrowed. */
static inline int brute_init(brute *b, const projection *p, uint32_t side_px, int64_t grid, double voxel_log, int nearest_back)
{
    *b           = (brute){.p = p, .side_px = side_px, .grid = grid, .scale = {side_px, voxel_log}, .nearest_back = nearest_back};
    b->across    = side_px / 8 < BRUTE_CELLS_MAX ? side_px / 8 : BRUTE_CELLS_MAX;
    b->cell_px   = side_px / b->across;
    size_t cells = (size_t)b->across * b->across;
    b->first     = calloc(cells + 2, sizeof *b->first);
    if (!b->first) return 0;
    brute_walk(b, 0);
    for (size_t n = 0; n < cells; n++) b->first[n + 2] += b->first[n + 1];
    if (!(b->ids = malloc((b->first[cells + 1] + 1) * sizeof *b->ids))) return 0;
    brute_walk(b, 1);
    return 1;
}

static inline void brute_free(brute *b)
{
    free(b->first);
    free(b->ids);
    *b = (brute){0};
}

/* Of the two sides of an edge, that one owns it which is entered by a step to the right; along a level edge, by a step up. */
static inline int brute_inside(int64_t area, int64_t dx, int64_t dy)
{
    return area > 0 || (area == 0 && (dy < 0 || (dy == 0 && dx > 0)));
}

/* Where the ray of a texel meets a triangle. */
static inline int brute_meet(const brute *b, uint32_t t, uint32_t u, uint32_t v, brute_hit *out)
{
    const projection *p = b->p;
    int64_t           x[3], y[3], px = (int64_t)u * b->grid + b->grid / 2, py = (int64_t)v * b->grid + b->grid / 2, w[3];
    brute_corners(b, t, x, y);
    int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (!area) return 0;
    for (int k = 0; k < 3; k++) {
        int     a = (k + 1) % 3, c = (k + 2) % 3; /* the edge that corner k is not on */
        int64_t dx = x[c] - x[a], dy = y[c] - y[a], turn = area < 0 ? -1 : 1;
        w[k] = turn * (dx * (py - y[a]) - dy * (px - x[a]));
        if (!brute_inside(w[k], turn * dx, turn * dy)) return 0;
    }
    long double depth = 0, hu = 0, hv = 0, hq = 0;
    for (int k = 0; k < 3; k++) {
        depth += (long double)w[k] * (long double)p->vertices[p->indices[3 * (size_t)t + (size_t)k]].z;
        if (t < p->holed_first) continue;
        hu += (long double)w[k] * (long double)p->uvq[t - p->holed_first][k].u;
        hv += (long double)w[k] * (long double)p->uvq[t - p->holed_first][k].v;
        hq += (long double)w[k] * (long double)p->uvq[t - p->holed_first][k].q;
    }
    depth /= (long double)(area < 0 ? -area : area);
    if (t >= p->holed_first) {
        size_t mask = 0;
        while (t >= p->alpha_mask_first[mask + 1]) mask++;
        const alpha_mask *m = &p->casters->alpha_masks[mask];
        if (!alpha_mask_opaque(m, &p->casters->images[m->image], (double)(hu / hq), (double)(hv / hq))) return 0;
    }
    double z = p->reversed ? -(double)depth : (double)depth, far = p->reversed ? 0 : 1;
    int    solid = t < p->solid_triangle_count, two_sided = p->double_sided && p->double_sided[t];
    *out = (brute_hit){depth_in_voxels(b->scale, z < far - 1 ? far - 1
                                                 : z > far   ? far
                                                             : z),
                       solid, area < 0, area < 0 && !solid && !two_sided && t < p->holed_first};
    return 1;
}

static inline int brute_compare(const void *a, const void *b)
{
    double x = ((const brute_hit *)a)->depth, y = ((const brute_hit *)b)->depth;
    return (x > y) - (x < y);
}

/* Front faces less back faces of solids, those up to a depth. */
static inline int brute_open(const brute_hit *hits, size_t count, double fronts_to, double backs_to)
{
    int open = 0;
    for (size_t n = 0; n < count; n++)
        if (hits[n].solid) open += hits[n].front ? hits[n].depth <= fronts_to : -(hits[n].depth <= backs_to);
    return open;
}

/* Where a sheet of a depth in voxels ends that is thick: voxels are equal, or shares of the logarithm of the distance. */
static inline double brute_through(const brute *b, double depth)
{
    const double log_vx = b->scale.voxel_log;
    return log_vx == 0 ? depth + b->thickness : log(exp(depth * log_vx) + b->thickness) / log_vx;
}

/* The column of texel (u, v). Of more than BRUTE_HITS_MAX hits the rest is not looked at. */
static inline brute_column brute_at(const brute *b, uint32_t u, uint32_t v)
{
    brute_hit hits[BRUTE_HITS_MAX];
    size_t    count = 0;
    double    far = b->scale.depth_vx, hair = 1e-9 * far, sheet = INFINITY, solid = INFINITY, least = far, most = far;
    size_t    cell = (size_t)(v / b->cell_px) * b->across + u / b->cell_px;
    for (size_t n = b->first[cell]; n < b->first[cell + 1] && count < BRUTE_HITS_MAX; n++)
        count += (size_t)brute_meet(b, b->ids[n], u, v, &hits[count]);
    qsort(hits, count, sizeof *hits, brute_compare);
    int found_least = 0, found_most = 0;
    for (size_t n = 0; n < count; n++) {
        double d = hits[n].depth;
        if (hits[n].solid && d < solid) solid = d;
        if (!hits[n].solid && d < sheet) sheet = d;
        if (!hits[n].solid || hits[n].front) continue;
        if (!found_least && (b->nearest_back || brute_open(hits, count, d - hair, d + hair) <= 0)) found_least = 1, least = d;
        if (!found_most && (b->nearest_back || brute_open(hits, count, d + hair, d + hair) <= 0)) found_most = 1, most = d;
    }
    if (count == 0) return (brute_column){far, far, far, far};
    double e = fmin(fmin(sheet, solid), far), next = count > 1 ? hits[1].depth : far, sheet_x = e, last = hits[count - 1].depth;
    int    sheet_alone = sheet <= solid - hair || solid == INFINITY;
    if (hits[0].thick && b->thickness > 0) sheet_x = fmin(brute_through(b, e), next);
    if (sheet <= solid + hair) least = fmin(sheet_x, least);
    if (sheet_alone) most = sheet_x;
    if (e <= hair) least = e; /* what lies before the map may have been thick there */
    if (b->free_behind && last <= (sheet_alone ? e : most) + hair) most = far;
    if (b->free_behind && count == 1 && sheet_alone) least = far;
    return (brute_column){e - hair, e + hair, least - hair, most + hair};
}

#endif
