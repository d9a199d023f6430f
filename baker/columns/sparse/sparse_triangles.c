/* Exact triangles of a projection; see sparse_triangles.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/sparse_triangles.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/group.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/base/run_control.h"
#include "baker/columns/sparse/patches.h"

enum { GRAIN = 4096 };

typedef struct corner {
    int32_t x, y; /* subtexels */
    double  z;    /* grows away from the light */
} corner;

typedef struct maker {
    sparse_triangles *s;
    const projection *p;
    double            px;     /* subtexels per texel */
    double            extent; /* subtexels: greatest distance from a vertex to a point of the map */
    int8_t           *facing; /* [p->triangle_count] */
    uint32_t         *patch_of;
    uint8_t          *ends;
    uint32_t         *order; /* [s->count] index in p of each triangle of s */
} maker;

static int32_t snapped(const maker *w, double texels)
{
    return (int32_t)floor(texels * w->px + 0.5);
}

static corner corner_of(const maker *w, size_t triangle, int k)
{
    const vertex_ls *v = &w->p->vertices[w->p->indices[3 * triangle + (size_t)k]];
    return (corner){snapped(w, v->u), snapped(w, v->v), w->p->reversed ? -v->z : v->z};
}

/* Twice the area, exact. */
static int64_t area_of(const corner c[3])
{
    return ((int64_t)c[1].x - c[0].x) * ((int64_t)c[2].y - c[0].y) - ((int64_t)c[2].x - c[0].x) * ((int64_t)c[1].y - c[0].y);
}

static void find_facing(void *user, size_t begin, size_t end, uint32_t worker)
{
    maker *w = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) {
        const corner c[3] = {corner_of(w, t, 0), corner_of(w, t, 1), corner_of(w, t, 2)};
        int64_t      area = area_of(c);
        w->facing[t]      = (int8_t)((area > 0) - (area < 0));
    }
}

/* Put the corners into the order of sparse_triangle; `from` gets the old index of each. */
static void order_corners(const maker *w, size_t triangle, corner c[3], int from[3])
{
    corner at[3];
    int    near = 0;
    for (int k = 0; k < 3; k++) at[k] = corner_of(w, triangle, k);
    for (int k = 1; k < 3; k++) near = at[k].z < at[near].z ? k : near;
    int step = w->facing[triangle] > 0 ? 1 : 2;
    for (int k = 0; k < 3; k++) {
        from[k] = (near + k * step) % 3;
        c[k]    = at[from[k]];
    }
}

/* Border bits for the new order of corners: edge k begins at corner from[k]; if the direction is reversed, it ends there. */
static uint8_t ends_in_order(uint8_t ends, const int from[3], int facing)
{
    int in_order = 0;
    for (int k = 0; k < 3; k++) {
        int edge = facing > 0 ? from[k] : from[(k + 1) % 3];
        in_order |= (ends >> edge & 1) << k;
    }
    return (uint8_t)in_order;
}

/* Plane of depth through corner 0. The rounding error anywhere in the map is bounded by the terms of the slopes, which may be much
 * larger than the slopes. */
static void set_plane(sparse_triangle *t, const corner c[3], double extent)
{
    double x1 = (double)c[1].x - c[0].x, y1 = (double)c[1].y - c[0].y, z1 = c[1].z - c[0].z;
    double x2 = (double)c[2].x - c[0].x, y2 = (double)c[2].y - c[0].y, z2 = c[2].z - c[0].z;
    double area  = (double)llabs(area_of(c));
    double terms = fabs(z1 * y2) + fabs(z2 * y1) + fabs(z2 * x1) + fabs(z1 * x2);
    t->gx        = (z1 * y2 - z2 * y1) / area;
    t->gy        = (z2 * x1 - z1 * x2) / area;
    t->zmin      = c[0].z;
    t->zmax      = fmax(c[1].z, c[2].z);
    t->slack     = ldexp(terms / area * extent + fmax(fabs(t->zmin), fabs(t->zmax)), -49);
}

static void make_triangles(void *user, size_t begin, size_t end, uint32_t worker)
{
    maker            *w = user;
    const projection *p = w->p;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        size_t           from   = w->order[n];
        int              facing = w->facing[from], back = facing > 0, was[3]; /* the map is a mirror image of what the light sees */
        int              solid = from < p->solid_triangle_count, holed = from >= p->holed_first;
        int              faces = !solid && !holed && !back && !(p->double_sided && p->double_sided[from]);
        corner           c[3];
        sparse_triangle *t = &w->s->all[n];
        run_control_wait_each(256, n);
        order_corners(w, from, c, was);
        for (int k = 0; k < 3; k++) {
            t->x[k] = c[k].x;
            t->y[k] = c[k].y;
        }
        set_plane(t, c, w->extent);
        t->patch = w->patch_of[from];
        t->kind  = (uint8_t)((solid ? SPARSE_SOLID : 0) | (back ? SPARSE_BACK : 0) | (holed ? SPARSE_HOLED : 0) |
                            (faces ? SPARSE_FACES : 0));
        t->ends  = ends_in_order(w->ends[from], was, facing);
        for (int k = 0; k < 3 && holed; k++) w->s->uvq[n - w->s->holed_first][k] = p->uvq[from - p->holed_first][was[k]];
    }
}

/* Sort all triangles that are not edge-on by patch. Triangles with holes are patches of their own, and come last. */
static vxs_result order_by_patch(maker *w, uint32_t threads)
{
    size_t     count   = w->p->triangle_count;
    uint32_t  *first   = pages_alloc((count + 1) * sizeof *first);
    uint32_t  *members = pages_alloc((count + 1) * sizeof *members);
    vxs_result r       = VXS_E_MEMORY;
    if (first && members && (r = group_by_key(first, members, w->patch_of, count, count, threads)) == VXS_OK)
        for (size_t n = 0; n < count; n++) {
            if (!w->facing[members[n]]) continue;
            w->s->holed_first += members[n] < w->p->holed_first;
            members[w->s->count++] = members[n];
        }
    free(first);
    w->order = members;
    return r;
}

static vxs_result take_masks(const maker *w)
{
    sparse_triangles *s     = w->s;
    size_t            count = s->count - s->holed_first;
    uint32_t          mask  = 0;
    s->uvq                  = malloc((count + 1) * sizeof *s->uvq);
    s->mask_of              = malloc((count + 1) * sizeof *s->mask_of);
    if (!s->uvq || !s->mask_of) return VXS_E_MEMORY;
    for (size_t n = 0; n < count; n++) {
        while (w->order[s->holed_first + n] >= w->p->alpha_mask_first[mask + 1]) mask++;
        s->mask_of[n] = mask;
    }
    return VXS_OK;
}

static vxs_result make(maker *w, uint32_t threads)
{
    size_t     count = w->p->triangle_count;
    vxs_result r     = VXS_E_MEMORY;
    w->facing        = malloc(count + 1);
    w->patch_of      = pages_alloc((count + 1) * sizeof *w->patch_of);
    w->ends          = malloc(count + 1);
    if (!w->facing || !w->patch_of || !w->ends) return r;
    parallel_for(threads, count, GRAIN, find_facing, w);
    if ((r = patches_find(w->patch_of, w->ends, w->facing, w->p, threads)) != VXS_OK) return r;
    if ((r = order_by_patch(w, threads)) != VXS_OK || (r = take_masks(w)) != VXS_OK) return r;
    if (!(w->s->all = pages_alloc((w->s->count + 1) * sizeof *w->s->all))) return VXS_E_MEMORY;
    parallel_for(threads, w->s->count, GRAIN, make_triangles, w);
    return VXS_OK;
}

uint64_t sparse_triangles_bytes(const projection *p)
{
    const maker *w     = NULL; /* for sizeof only */
    uint64_t     whole = sizeof *w->facing + sizeof *w->patch_of + sizeof *w->ends + sizeof *w->order + sizeof *w->s->all;
    return p->triangle_count * whole + (p->triangle_count - p->holed_first) * (sizeof *w->s->uvq + sizeof *w->s->mask_of);
}

vxs_result sparse_triangles_init(sparse_triangles *s, const projection *p, uint32_t side_px, uint32_t threads)
{
    *s           = (sparse_triangles){.grid = sparse_grid(side_px), .casters = p->casters};
    maker      w = {.s = s, .p = p, .px = ldexp(1, (int)s->grid), .extent = ldexp(4.0 * side_px, (int)s->grid)};
    vxs_result r = make(&w, threads);
    free(w.facing);
    free(w.patch_of);
    free(w.ends);
    free(w.order);
    return r;
}

void sparse_triangles_free(sparse_triangles *s)
{
    free(s->all);
    free(s->uvq);
    free(s->mask_of);
    *s = (sparse_triangles){0};
}
