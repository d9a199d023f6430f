/* Sub-DAGs into one DAG; see dag.h.
 *
 * Sub-DAGs are added one after the other, each from its masks up: when a level's references have been turned into those of the
 * merged DAG, equal contents mean equal subtrees, and one table a level finds them. So each can be freed as soon as it was added.
 * [CPVS16] 4.3 merges sorted levels instead; tables keep the order of arrival, in which neighbours stay neighbours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/dag/dag.h"
#include "baker/dag/ref_table.h"

struct dag_merger {
    dag       merged;
    ref_table table[DAG_LEVELS_MAX];
    ref_table mask_table;
    uint32_t  map_count;
    uint32_t *grid; /* [map][slab][j][i] references to the sub-DAGs' roots */
    uint32_t  grid_side;
    uint32_t  sub_levels; /* levels of a sub-DAG */
    int       unify;
};

vxs_result dag_merger_create(dag_merger **out, uint32_t side_px, uint32_t sub_side_px, uint32_t map_count, int unify)
{
    *out          = NULL;
    dag_merger *g = calloc(1, sizeof *g);
    if (!g) return VXS_E_MEMORY;
    g->unify              = unify;
    g->map_count          = map_count;
    g->grid_side          = side_px / sub_side_px;
    g->sub_levels         = dag_levels(sub_side_px);
    g->merged.level_count = dag_levels(side_px);
    g->grid               = calloc((size_t)map_count * g->grid_side * g->grid_side * g->grid_side, sizeof *g->grid);
    if (!g->grid) {
        dag_merger_destroy(g);
        return VXS_E_MEMORY;
    }
    *out = g;
    return VXS_OK;
}

void dag_merger_destroy(dag_merger *g)
{
    if (!g) return;
    for (uint32_t l = 0; l < DAG_LEVELS_MAX; l++) ref_table_free(&g->table[l]);
    ref_table_free(&g->mask_table);
    dag_free(&g->merged);
    free(g->grid);
    free(g);
}

/* Room in a table, which only unifying needs. */
static int reserve(const dag_merger *g, ref_table *table, uint64_t more)
{
    return !g->unify || ref_table_reserve(table, more);
}

static uint32_t merged_mask(dag_merger *g, uint64_t mask)
{
    if (!g->unify) return dag_add_mask(&g->merged, mask);
    uint64_t hash = ref_hash_mask(mask);
    uint64_t at   = ref_table_first(&g->mask_table, hash);
    for (uint32_t found; (found = ref_table_match(&g->mask_table, hash, &at)); at = ref_table_next(&g->mask_table, at))
        if (g->merged.masks[found - REF_FIRST] == mask) return found;
    uint32_t ref = dag_add_mask(&g->merged, mask);
    if (ref) ref_table_put(&g->mask_table, hash, at, ref);
    return ref;
}

/* hash: of the subtree; the node refers to nodes of the merged DAG. The table has room. */
static uint32_t merged_node(dag_merger *g, uint32_t level, const dag_node *node, uint64_t hash)
{
    if (!g->unify) return dag_add_node_hashed(&g->merged, level, node, hash);
    ref_table *table = &g->table[level];
    uint64_t   at    = ref_table_first(table, hash);
    for (uint32_t found; (found = ref_table_match(table, hash, &at)); at = ref_table_next(table, at))
        if (!memcmp(&g->merged.level[level].nodes[found - REF_FIRST], node, sizeof *node)) return found;
    uint32_t ref = dag_add_node_hashed(&g->merged, level, node, hash);
    if (ref) ref_table_put(table, hash, at, ref);
    return ref;
}

vxs_result dag_merger_add(dag_merger *g, const dag *sub, uint32_t map, uint32_t i, uint32_t j)
{
    uint32_t *below = malloc(((size_t)sub->mask_count + 1) * sizeof *below);
    int       ok    = below && reserve(g, &g->mask_table, sub->mask_count);
    for (uint32_t n = 0; n < sub->mask_count && ok; n++) ok = (below[n] = merged_mask(g, sub->masks[n])) != 0;

    for (uint32_t level = 0; level < g->sub_levels && ok; level++) {
        const dag_level *l   = &sub->level[level];
        uint32_t        *ref = malloc(((size_t)l->count + 1) * sizeof *ref);
        ok                   = ref && reserve(g, &g->table[level], l->count);
        for (uint32_t n = 0; n < l->count && ok; n++) {
            dag_node node = l->nodes[n];
            for (int c = 0; c < 8; c++)
                if (node.child[c] >= REF_FIRST) node.child[c] = below[node.child[c] - REF_FIRST];
            ok = (ref[n] = merged_node(g, level, &node, l->hash[n])) != 0;
        }
        free(below);
        below = ref;
    }

    uint32_t *grid = g->grid + (size_t)map * g->grid_side * g->grid_side * g->grid_side;
    for (uint32_t slab = 0; slab < sub->root_count && ok; slab++) {
        uint32_t root                                              = sub->roots[slab];
        grid[((size_t)slab * g->grid_side + j) * g->grid_side + i] = root < REF_FIRST ? root : below[root - REF_FIRST];
    }
    free(below);
    return ok ? VXS_OK : VXS_E_MEMORY;
}

/* A reference to a node of these eight children, or to what all of them are when that is lit or shadowed. */
static int merged_parent(dag_merger *g, uint32_t level, const dag_node *node, uint32_t *ref)
{
    int same = node->child[0] < REF_FIRST;
    for (int c = 1; c < 8; c++) same &= node->child[c] == node->child[0];
    if (same) {
        *ref = node->child[0];
        return 1;
    }
    if (!reserve(g, &g->table[level], 1)) return 0;
    *ref = merged_node(g, level, node, dag_node_hash(&g->merged, level, node));
    return *ref != 0;
}

/* Replace the grid by that of the squares twice as wide. */
static int merge_level(dag_merger *g, uint32_t level)
{
    size_t    side = g->grid_side, half = side / 2, of_map = half * half * half;
    uint32_t *parents = malloc(g->map_count * of_map * sizeof *parents);
    int       ok      = parents != NULL;
    for (size_t n = 0; n < g->map_count * of_map && ok; n++) {
        const uint32_t *grid = g->grid + n / of_map * side * side * side;
        size_t          i = n % half, j = n / half % half, k = n % of_map / half / half;
        dag_node        node;
        for (size_t c = 0; c < 8; c++)
            node.child[c] = grid[((2 * k + (c >> 2)) * side + 2 * j + (c >> 1 & 1)) * side + 2 * i + (c & 1)];
        ok = merged_parent(g, level, &node, &parents[n]);
    }
    free(g->grid);
    g->grid      = parents;
    g->grid_side = (uint32_t)half;
    return ok;
}

/* The root of a map, as a node even where it is all lit or shadowed. */
static uint32_t root_node(dag_merger *g, uint32_t root)
{
    dag_node node;
    if (root >= REF_FIRST) return root;
    for (int c = 0; c < 8; c++) node.child[c] = root;
    return dag_add_node(&g->merged, g->merged.level_count - 1, &node);
}

vxs_result dag_merger_finish(dag_merger *g, dag *out)
{
    int ok = 1;
    for (uint32_t level = g->sub_levels; level < g->merged.level_count && ok; level++) ok = merge_level(g, level);
    g->merged.roots = ok ? malloc(g->map_count * sizeof *g->merged.roots) : NULL;
    if (!g->merged.roots) return VXS_E_MEMORY;
    for (uint32_t map = 0; map < g->map_count; map++)
        if (!(g->merged.roots[map] = root_node(g, g->grid[map]))) return VXS_E_MEMORY;
    g->merged.root_count = g->map_count;
    *out                 = g->merged;
    memset(&g->merged, 0, sizeof g->merged);
    return VXS_OK;
}
