/* Finding patches; see patches.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/patches.h"

#include <stdlib.h>
#include <string.h>

#include "baker/casters/mesh_edges.h"
#include "baker/casters/mesh_join.h"

enum { ALL_ENDS = 7 };

/* What has holes covers nothing. Solids and sheets have no edge in common. */
static int may_join(const projection *p, const int8_t *facing, uint32_t a, uint32_t b)
{
    return facing[a] && facing[a] == facing[b] && a < p->holed_first && b < p->holed_first;
}

vxs_result patches_find(uint32_t *patch_of, uint8_t *ends, const int8_t *facing, const projection *p)
{
    uint32_t  edge_count = (uint32_t)(3 * p->triangle_count);
    uint32_t *sorted     = malloc((edge_count + (size_t)1) * sizeof *sorted);
    if (!sorted || mesh_sort_edges(sorted, p->indices, p->triangle_count, p->vertex_count) != VXS_OK) {
        free(sorted);
        return VXS_E_MEMORY;
    }
    memset(ends, ALL_ENDS, p->triangle_count);
    for (uint32_t t = 0; t < p->triangle_count; t++) patch_of[t] = t;
    for (uint32_t begin = 0, end; begin < edge_count; begin = end) {
        end = mesh_edge_run(p->indices, sorted, begin, edge_count);
        if (end - begin != 2 || mesh_edge_balance(p->indices, sorted, begin, end)) continue;
        uint32_t a = sorted[begin], b = sorted[begin + 1];
        if (!may_join(p, facing, a / 3, b / 3)) continue;
        ends[a / 3] &= (uint8_t) ~(1u << a % 3);
        ends[b / 3] &= (uint8_t) ~(1u << b % 3);
        mesh_join(patch_of, a / 3, b / 3);
    }
    free(sorted);
    for (uint32_t t = 0; t < p->triangle_count; t++) patch_of[t] = mesh_find(patch_of, t);
    return VXS_OK;
}
