/* Sorting edges; see mesh_edges.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/mesh_edges.h"

#include <stdlib.h>

#include "baker/base/group.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/casters/mesh_join.h"

enum { GRAIN = 1 << 14 };

/* --- sort ------------------------------------------------------------------------------------------------------------- */

typedef struct edge_sorter {
    const uint32_t *indices;
    uint32_t       *low;    /* [3 * triangle_count] lower vertex of each half-edge */
    uint32_t       *first;  /* [vertex_count + 1] first half-edge of each lower vertex in `sorted` */
    uint32_t       *sorted; /* [3 * triangle_count] sorted by lower vertex */
} edge_sorter;

static void find_low(void *user, size_t begin, size_t end, uint32_t worker)
{
    edge_sorter *w = user;
    (void)worker;
    for (size_t h = begin; h < end; h++) w->low[h] = mesh_edge_low(w->indices, (uint32_t)h);
}

static int by_high(const void *a, const void *b, void *indices)
{
    uint32_t h = *(const uint32_t *)a, g = *(const uint32_t *)b;
    uint32_t p = mesh_edge_high(indices, h), q = mesh_edge_high(indices, g);
    return p != q ? p < q ? -1 : 1 : h < g ? -1 : h > g;
}

/* Sort half-edges with the same lower vertex. There are few of them, except at the centre of a large fan. */
static void sort_by_high(uint32_t *edges, uint32_t count, const uint32_t *indices)
{
    enum { FEW = 32 };
    uint32_t high[FEW];
    if (count > FEW) {
        qsort_r(edges, count, sizeof *edges, by_high, (void *)(size_t)indices);
        return;
    }
    for (uint32_t n = 0; n < count; n++) {
        uint32_t h = edges[n], key = mesh_edge_high(indices, h), k = n;
        for (; k > 0 && high[k - 1] > key; k--) {
            high[k]  = high[k - 1];
            edges[k] = edges[k - 1];
        }
        high[k]  = key;
        edges[k] = h;
    }
}

static void sort_vertices(void *user, size_t begin, size_t end, uint32_t worker)
{
    edge_sorter *w = user;
    (void)worker;
    for (size_t v = begin; v < end; v++) sort_by_high(w->sorted + w->first[v], w->first[v + 1] - w->first[v], w->indices);
}

vxs_result mesh_sort_edges(uint32_t *sorted, const uint32_t *indices, size_t triangle_count, size_t vertex_count, uint32_t threads)
{
    size_t      edge_count = 3 * triangle_count;
    edge_sorter w          = {.indices = indices,
                              .low     = pages_alloc((edge_count + 1) * sizeof *w.low),
                              .first   = pages_alloc((vertex_count + 1) * sizeof *w.first),
                              .sorted  = sorted};
    vxs_result  r          = VXS_E_MEMORY;
    if (w.low && w.first) {
        parallel_for(threads, edge_count, GRAIN, find_low, &w);
        r = group_by_key(w.first, sorted, w.low, edge_count, vertex_count, threads);
    }
    free(w.low);
    if (r == VXS_OK) parallel_for(threads, vertex_count, GRAIN, sort_vertices, &w);
    free(w.first);
    return r;
}

/* --- edges ------------------------------------------------------------------------------------------------------------ */

typedef struct edge_walk {
    const uint32_t *indices, *sorted;
    uint32_t        edge_count;
    void (*body)(void *user, uint32_t begin, uint32_t end);
    void *user;
} edge_walk;

/* Visit the edges whose runs begin in [part_begin, part_end). */
static void walk_edges(void *user, size_t part_begin, size_t part_end, uint32_t worker)
{
    const edge_walk *w     = user;
    uint32_t         begin = (uint32_t)part_begin;
    (void)worker;
    while (begin && begin < part_end && mesh_same_edge(w->indices, w->sorted[begin - 1], w->sorted[begin])) begin++;
    for (uint32_t end; begin < part_end; begin = end) {
        end = mesh_edge_run(w->indices, w->sorted, begin, w->edge_count);
        w->body(w->user, begin, end);
    }
}

void mesh_for_each_edge(const uint32_t *indices, const uint32_t *sorted, size_t triangle_count, uint32_t threads,
                        void (*body)(void *user, uint32_t begin, uint32_t end), void *user)
{
    edge_walk w = {indices, sorted, (uint32_t)(3 * triangle_count), body, user};
    parallel_for(threads, w.edge_count, GRAIN, walk_edges, &w);
}

/* --- components ------------------------------------------------------------------------------------------------------- */

typedef struct joining {
    uint32_t       *component_of; /* first the parents in a union-find forest */
    const uint32_t *sorted;
} joining;

static void join_edge(void *user, uint32_t begin, uint32_t end)
{
    const joining *j = user;
    for (uint32_t i = begin + 1; i < end; i++) mesh_join(j->component_of, j->sorted[begin] / 3, j->sorted[i] / 3);
}

static void find_roots(void *user, size_t begin, size_t end, uint32_t worker)
{
    const joining *j = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) mesh_settle(j->component_of, (uint32_t)t);
}

size_t mesh_find_components(uint32_t *component_of, const uint32_t *sorted, const uint32_t *indices, size_t triangle_count,
                            uint32_t threads)
{
    joining j     = {component_of, sorted};
    size_t  count = 0;
    for (uint32_t t = 0; t < triangle_count; t++) component_of[t] = t;
    mesh_for_each_edge(indices, sorted, triangle_count, threads, join_edge, &j);
    parallel_for(threads, triangle_count, GRAIN, find_roots, &j);
    /* a root is the first triangle of its component, so its number is known before its members need it */
    for (uint32_t t = 0; t < triangle_count; t++)
        component_of[t] = component_of[t] == t ? (uint32_t)count++ : component_of[component_of[t]];
    return count;
}
