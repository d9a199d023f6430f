/* Tiles around silhouettes; see silhouettes.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/exact/silhouettes.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/array.h"
#include "baker/base/random.h"

/* An edge of a triangle; those of neighbours have the same ends. */
typedef struct edge {
    uint32_t low, high; /* vertices */
    int      facing;    /* of the triangle: 1, -1; 0: seen from its edge */
} edge;

static int compare_edges(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    return x->low != y->low ? (x->low > y->low) - (x->low < y->low) : (x->high > y->high) - (x->high < y->high);
}

static int facing_of(const projection *p, size_t t)
{
    const vertex_ls *a = &p->vertices[p->indices[3 * t]], *b = &p->vertices[p->indices[3 * t + 1]],
                    *c = &p->vertices[p->indices[3 * t + 2]];
    double area        = (b->u - a->u) * (c->v - a->v) - (c->u - a->u) * (b->v - a->v);
    return (area > 0) - (area < 0);
}

/* All silhouettes of a projection, in the place of its edges. */
static size_t find_silhouettes(edge *edges, const projection *p)
{
    size_t count = 3 * p->triangle_count, kept = 0;
    for (size_t n = 0; n < count; n++) {
        uint32_t a = p->indices[n], b = p->indices[n % 3 < 2 ? n + 1 : n - 2];
        edges[n] = (edge){a < b ? a : b, a < b ? b : a, facing_of(p, n / 3)};
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t n = 0, next; n < count; n = next) {
        int ways = 0;
        for (next = n; next < count && !compare_edges(&edges[n], &edges[next]); next++) ways |= 1 << (edges[next].facing + 1);
        if (next == n + 1 || (ways & (ways - 1))) edges[kept++] = edges[n];
    }
    return kept;
}

typedef struct tile_list {
    map_tile *items;
    size_t    count, capacity;
} tile_list;

static int compare_tiles(const void *a, const void *b)
{
    const map_tile *x = a, *y = b;
    return x->j != y->j ? (x->j > y->j) - (x->j < y->j) : (x->i > y->i) - (x->i < y->i);
}

/* The tile of a point, and those about it. Returns 0 without memory. */
static int add_tiles(tile_list *l, double u, double v, uint32_t across)
{
    if (!array_reserve(&l->items, &l->capacity, l->count + 9, sizeof *l->items)) return 0;
    for (int n = 0; n < 9; n++) {
        double i = floor(u / 8) + n % 3 - 1, j = floor(v / 8) + n / 3 - 1;
        if (i >= 0 && j >= 0 && i < across && j < across) l->items[l->count++] = (map_tile){(uint32_t)j, (uint32_t)i};
    }
    return 1;
}

static void keep_once(tile_list *l)
{
    size_t kept = 0;
    if (l->count) qsort(l->items, l->count, sizeof *l->items, compare_tiles);
    for (size_t n = 0; n < l->count; n++)
        if (!kept || compare_tiles(&l->items[kept - 1], &l->items[n])) l->items[kept++] = l->items[n];
    l->count = kept;
}

/* Walk an edge in steps of less than a tile. */
static int add_edge(tile_list *l, const vertex_ls *a, const vertex_ls *b, uint32_t across)
{
    int steps = 1 + (int)(fmax(fabs(b->u - a->u), fabs(b->v - a->v)) / 6);
    for (int n = 0; n <= steps; n++)
        if (!add_tiles(l, a->u + (b->u - a->u) * n / steps, a->v + (b->v - a->v) * n / steps, across)) return 0;
    return 1;
}

vxs_result silhouette_tiles(map_tile **tiles, size_t *tile_count, const projection *p, uint32_t side_px, uint32_t count,
                            uint64_t seed)
{
    edge     *edges  = malloc((3 * p->triangle_count + 1) * sizeof *edges);
    size_t    found  = edges ? find_silhouettes(edges, p) : 0;
    rng       random = rng_split(seed, 1);
    tile_list l      = {0};
    int       ok     = edges != NULL;
    for (size_t n = 0; ok && n < count && n < found; n++) {
        size_t chosen = n + rng_below(&random, (uint32_t)(found - n));
        edge   e      = edges[chosen];
        edges[chosen] = edges[n];
        ok            = add_edge(&l, &p->vertices[e.low], &p->vertices[e.high], side_px / 8);
    }
    free(edges);
    keep_once(&l);
    *tiles      = l.items;
    *tile_count = l.count;
    return ok ? VXS_OK : VXS_E_MEMORY;
}
