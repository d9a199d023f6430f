/* Exact triangles of a projection; see sparse_triangles.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/sparse_triangles.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/group.h"
#include "baker/base/integer.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/base/run_control.h"
#include "baker/casters/mesh_edges.h"

enum { ALL_ENDS = 7, PATCH_GRAIN = 1 << 14 };

typedef struct finder {
    const projection *p;
    const int8_t     *facing;
    const uint32_t   *sorted; /* from mesh_sort_edges; NULL: not needed */
    const uint32_t   *mates;  /* of p, or own_mates */
    uint32_t         *own_mates;
    uint32_t         *patch_of;
    uint8_t          *ends;
} finder;

static void find_mates(void *user, uint32_t begin, uint32_t end)
{
    const finder *f = user;
    uint32_t      a = f->sorted[begin], b = f->sorted[end - 1];
    if (end - begin != 2 || mesh_edge_balance(f->p->indices, f->sorted, begin, end)) {
        for (uint32_t n = begin; n < end; n++) f->own_mates[f->sorted[n]] = UINT32_MAX;
        return;
    }
    f->own_mates[a] = b;
    f->own_mates[b] = a;
}

/* Returns VXS_OK or VXS_E_MEMORY. */
static vxs_result sort_mates(finder *f, uint32_t threads)
{
    const projection *p      = f->p;
    uint32_t         *sorted = pages_alloc((3 * p->triangle_count + 1) * sizeof *sorted);
    vxs_result        r      = VXS_E_MEMORY;
    f->sorted                = sorted;
    f->own_mates             = pages_alloc((3 * p->triangle_count + 1) * sizeof *f->own_mates);
    f->mates                 = f->own_mates;
    if (sorted && f->own_mates) r = mesh_sort_edges(sorted, p->indices, p->triangle_count, p->vertex_count, threads);
    if (r == VXS_OK) mesh_for_each_edge(p->indices, sorted, p->triangle_count, threads, find_mates, f);
    free(sorted);
    return r;
}

/* Solids and sheets share no edge, and triangles with holes cover nothing. */
static int is_inner(const finder *f, size_t t, uint32_t mate)
{
    return mate != UINT32_MAX && f->facing[t] && f->facing[t] == f->facing[mate / 3] && t < f->p->holed_first &&
           mate / 3 < f->p->holed_first;
}

static void join_triangles(void *user, size_t begin, size_t end, uint32_t worker)
{
    const finder *f = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) {
        unsigned inner = 0;
        for (size_t k = 0; k < 3; k++) {
            uint32_t mate = f->mates[3 * t + k];
            if (!is_inner(f, t, mate)) continue;
            inner |= 1u << k;
            if (mate / 3 < t) mesh_join(f->patch_of, (uint32_t)t, mate / 3);
        }
        f->ends[t] = (uint8_t)(ALL_ENDS & ~inner);
    }
}

static void settle(void *user, size_t begin, size_t end, uint32_t worker)
{
    const finder *f = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) mesh_settle(f->patch_of, (uint32_t)t);
}

vxs_result patches_find(uint32_t *patch_of, uint8_t *ends, const int8_t *facing, const projection *p, uint32_t threads)
{
    finder     f = {.p = p, .facing = facing, .mates = p->edge_mates, .patch_of = patch_of, .ends = ends};
    vxs_result r = f.mates ? VXS_OK : sort_mates(&f, threads);
    if (r == VXS_OK) {
        for (uint32_t t = 0; t < p->triangle_count; t++) patch_of[t] = t;
        parallel_for(threads, p->triangle_count, PATCH_GRAIN, join_triangles, &f);
        parallel_for(threads, p->triangle_count, PATCH_GRAIN, settle, &f);
    }
    free(f.own_mates);
    return r;
}

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
    double  at    = texels * w->px + 0.5; /* floor() and fmax() would be calls */
    int32_t whole = (int32_t)at;
    return whole - (at < whole);
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
    t->zmax      = c[1].z > c[2].z ? c[1].z : c[2].z;
    t->slack     = 0x1p-49 * (terms / area * extent + (fabs(t->zmin) > fabs(t->zmax) ? fabs(t->zmin) : fabs(t->zmax)));
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

        /* put the corners into the order of sparse_triangle */
        corner at[3];
        int    near = 0;
        for (int k = 0; k < 3; k++) at[k] = corner_of(w, from, k);
        for (int k = 1; k < 3; k++) near = at[k].z < at[near].z ? k : near;
        int step = w->facing[from] > 0 ? 1 : 2;
        for (int k = 0; k < 3; k++) {
            was[k] = (near + k * step) % 3;
            c[k]   = at[was[k]];
        }

        for (int k = 0; k < 3; k++) {
            t->x[k] = c[k].x;
            t->y[k] = c[k].y;
        }
        set_plane(t, c, w->extent);
        w->s->tags[n] = (sparse_tags){.patch = w->patch_of[from],
                                      .kind  = (uint8_t)((solid ? SPARSE_SOLID : 0) | (back ? SPARSE_BACK : 0) |
                                                        (holed ? SPARSE_HOLED : 0) | (faces ? SPARSE_FACES : 0))};

        /* border bits in the new order: edge k begins at corner was[k]; if the direction is reversed, it ends there */
        int in_order = 0;
        for (int k = 0; k < 3; k++) {
            int edge = facing > 0 ? was[k] : was[(k + 1) % 3];
            in_order |= (w->ends[from] >> edge & 1) << k;
        }
        w->s->tags[n].ends = (uint8_t)in_order;

        for (int k = 0; k < 3 && holed; k++) w->s->uvq[n - w->s->holed_first][k] = p->uvq[from - p->holed_first][was[k]];
    }
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

    /* sort all triangles that are not edge-on by patch; triangles with holes are patches of their own, and come last */
    uint32_t *first   = pages_alloc((count + 1) * sizeof *first);
    uint32_t *members = pages_alloc((count + 1) * sizeof *members);
    r                 = VXS_E_MEMORY;
    if (first && members && (r = group_by_key(first, members, w->patch_of, count, count, threads)) == VXS_OK)
        for (size_t n = 0; n < count; n++) {
            if (!w->facing[members[n]]) continue;
            w->s->holed_first += members[n] < w->p->holed_first;
            members[w->s->count++] = members[n];
        }
    free(first);
    w->order = members;
    if (r != VXS_OK || (r = take_masks(w)) != VXS_OK) return r;
    w->s->all = pages_alloc((w->s->count + 1) * (sizeof *w->s->all + sizeof *w->s->tags)); /* one array: it ends on a large page */
    if (!w->s->all) return VXS_E_MEMORY;
    w->s->tags = (sparse_tags *)(w->s->all + w->s->count + 1);
    parallel_for(threads, w->s->count, GRAIN, make_triangles, w);
    return VXS_OK;
}

uint64_t sparse_triangles_bytes(const projection *p)
{
    const maker *w = NULL; /* for sizeof only */
    uint64_t     whole =
        sizeof *w->facing + sizeof *w->patch_of + sizeof *w->ends + sizeof *w->order + sizeof *w->s->all + sizeof *w->s->tags;
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

enum {
    CHUNKS_MAX     = 64, /* chunks of triangles, counted and placed separately, so that bins do not depend on the number of
                            threads */
    IDS_A_TRIANGLE = 8,  /* on average, at most */
    LEAST_CELL_PX  = 256,
};

typedef struct binner {
    triangle_bins          *b;
    const sparse_triangles *s;
    uint32_t                cell_log2; /* subtexels of a cell */
    size_t                  chunks;
    size_t                 *place; /* [chunks * cells^2] number of ids of a chunk in a cell, then their position */
} binner;

typedef struct cell_range {
    uint32_t i0, i1, j0, j1;
} cell_range;

static uint32_t cell_of(const binner *w, int32_t subtexels)
{
    return subtexels < 0 ? 0 : min_u32((uint32_t)subtexels >> w->cell_log2, w->b->cells - 1);
}

static void walk_chunk(binner *w, size_t chunk, int place)
{
    triangle_bins *b     = w->b;
    size_t         count = (size_t)b->cells * b->cells, *at = w->place + chunk * count;
    cell_range     r;
    for (size_t n = w->s->count * chunk / w->chunks; n < w->s->count * (chunk + 1) / w->chunks; n++) {
        const sparse_triangle *t  = &w->s->all[n];
        int32_t                x0 = min_i32(min_i32(t->x[0], t->x[1]), t->x[2]), x1 = max_i32(max_i32(t->x[0], t->x[1]), t->x[2]);
        int32_t                y0 = min_i32(min_i32(t->y[0], t->y[1]), t->y[2]), y1 = max_i32(max_i32(t->y[0], t->y[1]), t->y[2]);
        int32_t                side = (int32_t)(w->b->cells << w->cell_log2);
        if (x1 < 0 || y1 < 0 || x0 > side || y0 > side) continue; /* outside the map */
        r = (cell_range){cell_of(w, x0), cell_of(w, x1), cell_of(w, y0), cell_of(w, y1)};
        for (uint32_t j = r.j0; j <= r.j1; j++)
            for (uint32_t i = r.i0; i <= r.i1; i++) {
                size_t *to = &at[(size_t)j * b->cells + i];
                if (place) b->ids[*to] = (uint32_t)n;
                ++*to;
            }
    }
}

static void count_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    for (size_t n = begin; n < end; n++) walk_chunk(user, n, 0);
}

static void place_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    for (size_t n = begin; n < end; n++) walk_chunk(user, n, 1);
}

/* Order ids by cell, and in each cell by chunk. Returns their number. */
static size_t counts_to_places(binner *w)
{
    size_t cells = (size_t)w->b->cells * w->b->cells, sum = 0;
    for (size_t cell = 0; cell < cells; cell++) {
        w->b->first[cell] = sum;
        for (size_t chunk = 0; chunk < w->chunks; chunk++) {
            size_t *at = &w->place[chunk * cells + cell], count = *at;
            *at = sum;
            sum += count;
        }
    }
    return w->b->first[cells] = sum;
}

static vxs_result bin(binner *w, uint32_t side_px, uint32_t threads)
{
    triangle_bins *b = w->b;
    for (b->cells = max_u32(min_u32(BINS_A_SIDE_MAX, side_px / LEAST_CELL_PX), 1);; b->cells /= 2) {
        size_t cells = (size_t)b->cells * b->cells;
        b->cell_px   = side_px / b->cells;
        w->cell_log2 = log2_u32(b->cell_px) + w->s->grid;
        free(w->place);
        free(b->first);
        w->place = calloc(w->chunks * cells, sizeof *w->place);
        b->first = malloc((cells + 1) * sizeof *b->first);
        if (!w->place || !b->first) return VXS_E_MEMORY;
        parallel_for(threads, w->chunks, 1, count_chunks, w);
        if (counts_to_places(w) <= IDS_A_TRIANGLE * (w->s->count + cells) || b->cells == 1) break;
    }
    b->ids = malloc((b->first[(size_t)b->cells * b->cells] + 1) * sizeof *b->ids);
    if (!b->ids) return VXS_E_MEMORY;
    parallel_for(threads, w->chunks, 1, place_chunks, w);
    return VXS_OK;
}

vxs_result triangle_bins_init(triangle_bins *b, const sparse_triangles *s, uint32_t side_px, uint32_t threads)
{
    binner w     = {.b = b, .s = s, .chunks = min_u32(1 + (uint32_t)(s->count / GRAIN), CHUNKS_MAX)};
    *b           = (triangle_bins){0};
    vxs_result r = bin(&w, side_px, threads);
    free(w.place);
    return r;
}

void triangle_bins_free(triangle_bins *b)
{
    free(b->first);
    free(b->ids);
    *b = (triangle_bins){0};
}
