/* Finding patches; see patches.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/patches.h"

#include <stdlib.h>

#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/casters/mesh_edges.h"
#include "baker/casters/mesh_join.h"

enum { ALL_ENDS = 7, GRAIN = 1 << 14 };

typedef struct finder {
    const projection *p;
    const int8_t     *facing;
    uint32_t         *sorted; /* from mesh_sort_edges */
    uint32_t         *patch_of;
    uint8_t          *ends;
    uint8_t          *inner; /* [3 * p->triangle_count] 1: the half-edge is not on a border */
} finder;

/* Triangles with holes cover nothing. Solids and sheets share no edge. */
static int may_join(const finder *f, uint32_t a, uint32_t b)
{
    return f->facing[a] && f->facing[a] == f->facing[b] && a < f->p->holed_first && b < f->p->holed_first;
}

static void join_edge(void *user, uint32_t begin, uint32_t end)
{
    const finder *f = user;
    if (end - begin != 2 || mesh_edge_balance(f->p->indices, f->sorted, begin, end)) return;
    uint32_t a = f->sorted[begin], b = f->sorted[begin + 1];
    if (!may_join(f, a / 3, b / 3)) return;
    f->inner[a] = f->inner[b] = 1;
    mesh_join(f->patch_of, a / 3, b / 3);
}

static void settle(void *user, size_t begin, size_t end, uint32_t worker)
{
    const finder *f = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) {
        const uint8_t *inner = f->inner + 3 * t;
        f->ends[t]           = (uint8_t)(ALL_ENDS & ~(inner[0] | inner[1] << 1 | inner[2] << 2));
        mesh_settle(f->patch_of, (uint32_t)t);
    }
}

vxs_result patches_find(uint32_t *patch_of, uint8_t *ends, const int8_t *facing, const projection *p, uint32_t threads)
{
    size_t     edge_count = 3 * p->triangle_count;
    finder     f = {p, facing, pages_alloc((edge_count + 1) * sizeof *f.sorted), patch_of, ends, calloc(edge_count + 1, 1)};
    vxs_result r = VXS_E_MEMORY;
    if (f.sorted && f.inner) r = mesh_sort_edges(f.sorted, p->indices, p->triangle_count, p->vertex_count, threads);
    if (r == VXS_OK) {
        for (uint32_t t = 0; t < p->triangle_count; t++) patch_of[t] = t;
        mesh_for_each_edge(p->indices, f.sorted, p->triangle_count, threads, join_edge, &f);
        parallel_for(threads, p->triangle_count, GRAIN, settle, &f);
    }
    free(f.sorted);
    free(f.inner);
    return r;
}
