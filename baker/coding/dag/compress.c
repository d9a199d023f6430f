/* Compression of one DAG to its least number of nodes; see dag.h.
 * Source: [CPVS16] 4.1 (bottom-up), 4.2 (top-down).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/ref_table.h"
#include "baker/base/system.h"
#include "baker/coding/dag/dag.h"

/* Top-down --------------------------------------------------------------------------------------------------------------------
 *
 * From the roots down, a node is kept if no kept node of its level has an equal subtree. Only children of kept nodes are visited on
 * the next level. A hash finds a kept node that may be equal, and a comparison of the two subtrees decides. `alike` stores the
 * results, so that each dropped node is walked once for each node that it may equal. */

typedef struct top_down {
    const dag *d;
    uint32_t  *alike[DAG_LEVELS_MAX]; /* [node] 1 + index of a node with an equal subtree; 0: none yet */
    uint32_t  *ref[DAG_LEVELS_MAX];   /* [node] its reference in the compressed DAG; 0: not reached */
    uint32_t  *mask_ref;              /* [mask] the same */
} top_down;

static int equal_subtrees(top_down *t, uint32_t level, uint32_t a, uint32_t b)
{
    const dag *d = t->d;
    if (a == b || t->alike[level][b] == a + 1) return 1;
    if (d->level[level].hash[a] != d->level[level].hash[b]) return 0;
    const uint32_t *x = d->level[level].nodes[a].child;
    const uint32_t *y = d->level[level].nodes[b].child;
    for (int c = 0; c < 8; c++) {
        if (x[c] == y[c]) continue;
        if (x[c] < REF_FIRST || y[c] < REF_FIRST) return 0;
        if (level == 0 ? d->masks[x[c] - REF_FIRST] != d->masks[y[c] - REF_FIRST]
                       : !equal_subtrees(t, level - 1, x[c] - REF_FIRST, y[c] - REF_FIRST))
            return 0;
    }
    t->alike[level][b] = a + 1;
    return 1;
}

/* The new reference of a node. If no kept node is equal, the node is appended to `out` and kept. 0: out of memory. */
static uint32_t keep_node(top_down *t, dag *out, ref_table *table, uint32_t *kept, uint32_t level, uint32_t node)
{
    uint32_t *ref = &t->ref[level][node];
    if (*ref) return *ref;
    uint64_t hash = t->d->level[level].hash[node];
    uint64_t at   = ref_table_first(table, hash);
    for (uint32_t found; (found = ref_table_match(table, hash, &at)); at = ref_table_next(table, at))
        if (equal_subtrees(t, level, kept[found - REF_FIRST], node)) return *ref = found;
    *ref = dag_add_node_hashed(out, level, &t->d->level[level].nodes[node], hash);
    if (!*ref) return 0;
    kept[*ref - REF_FIRST] = node;
    ref_table_put(table, hash, at, *ref);
    return *ref;
}

static uint32_t keep_mask(top_down *t, dag *out, ref_table *table, uint32_t mask)
{
    uint32_t *ref = &t->mask_ref[mask];
    if (*ref) return *ref;
    uint64_t bits = t->d->masks[mask];
    uint64_t hash = ref_hash_mask(bits);
    uint64_t at   = ref_table_first(table, hash);
    for (uint32_t found; (found = ref_table_match(table, hash, &at)); at = ref_table_next(table, at))
        if (out->masks[found - REF_FIRST] == bits) return *ref = found;
    *ref = dag_add_mask(out, bits);
    if (*ref) ref_table_put(table, hash, at, *ref);
    return *ref;
}

/* Replace the children of the kept nodes of `level` (or the roots) by new references. */
static int keep_below(top_down *t, dag *out, uint32_t level)
{
    const dag *d         = t->d;
    uint32_t   below     = level ? d->level[level - 1].count : d->mask_count;
    uint32_t  *refs      = out->roots;
    size_t     ref_count = out->root_count;
    if (level < d->level_count) {
        ref_count = (size_t)out->level[level].count * 8;
        refs      = ref_count ? out->level[level].nodes[0].child : NULL;
    }
    ref_table table = {0};
    uint32_t *kept  = malloc(((size_t)below + 1) * sizeof *kept);
    int       ok    = kept && ref_table_reserve(&table, below);
    for (size_t n = 0; n < ref_count && ok; n++) {
        if (refs[n] < REF_FIRST) continue;
        uint32_t index = refs[n] - REF_FIRST;
        refs[n]        = level ? keep_node(t, out, &table, kept, level - 1, index) : keep_mask(t, out, &table, index);
        ok             = refs[n] != 0;
    }
    ref_table_free(&table);
    free(kept);
    return ok;
}

static int compress_top_down(const dag *d, dag *out)
{
    top_down t  = {.d = d};
    int      ok = 1;
    for (uint32_t l = 0; l < d->level_count; l++) {
        t.alike[l] = calloc((size_t)d->level[l].count + 1, sizeof *t.alike[l]);
        t.ref[l]   = calloc((size_t)d->level[l].count + 1, sizeof *t.ref[l]);
        ok &= t.alike[l] && t.ref[l];
    }
    t.mask_ref = calloc((size_t)d->mask_count + 1, sizeof *t.mask_ref);
    ok &= t.mask_ref != NULL;

    for (uint32_t level = d->level_count + 1; level-- > 0 && ok;) ok = keep_below(&t, out, level);

    for (uint32_t l = 0; l < d->level_count; l++) {
        free(t.alike[l]);
        free(t.ref[l]);
    }
    free(t.mask_ref);
    return ok;
}

/* Bottom-up -------------------------------------------------------------------------------------------------------------------
 *
 * From the masks up: sort a level by contents, unify equal neighbours, and update the references of the level above. */

static int compare_masks(const void *a, const void *b, void *user)
{
    const uint64_t *masks = user;
    uint32_t        x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    if (masks[x] != masks[y]) return masks[x] < masks[y] ? -1 : 1;
    return x < y ? -1 : x > y;
}

static int compare_nodes(const void *a, const void *b, void *user)
{
    const dag_node *nodes = user;
    uint32_t        x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    int             order = memcmp(&nodes[x], &nodes[y], sizeof *nodes);
    if (order) return order;
    return x < y ? -1 : x > y;
}

/* Indices [0, count) sorted by contents; NULL without memory. */
static uint32_t *sorted(uint32_t count, int (*compare)(const void *, const void *, void *), void *contents)
{
    uint32_t *order = malloc(((size_t)count + 1) * sizeof *order);
    if (!order) return NULL;
    for (uint32_t n = 0; n < count; n++) order[n] = n;
    system_sort(order, count, sizeof *order, compare, contents);
    return order;
}

static int unify_masks(const dag *d, dag *out, uint32_t *ref)
{
    uint32_t *order = sorted(d->mask_count, compare_masks, d->masks);
    int       ok    = order != NULL;
    for (uint32_t n = 0; n < d->mask_count && ok; n++) {
        uint64_t mask = d->masks[order[n]];
        int      same = n && mask == d->masks[order[n - 1]];
        ref[order[n]] = same ? ref[order[n - 1]] : dag_add_mask(out, mask);
        ok            = ref[order[n]] != 0;
    }
    free(order);
    return ok;
}

/* below: new references of the level below; `ref` gets those of this level. */
static int unify_nodes(const dag *d, dag *out, uint32_t level, const uint32_t *below, uint32_t *ref)
{
    const dag_level *l     = &d->level[level];
    dag_node        *nodes = malloc(((size_t)l->count + 1) * sizeof *nodes);
    if (!nodes) return 0;
    for (uint32_t n = 0; n < l->count; n++)
        for (int c = 0; c < 8; c++) {
            uint32_t child    = l->nodes[n].child[c];
            nodes[n].child[c] = child < REF_FIRST ? child : below[child - REF_FIRST];
        }

    uint32_t *order = sorted(l->count, compare_nodes, nodes);
    int       ok    = order != NULL;
    for (uint32_t n = 0; n < l->count && ok; n++) {
        int same      = n && !memcmp(&nodes[order[n]], &nodes[order[n - 1]], sizeof *nodes);
        ref[order[n]] = same ? ref[order[n - 1]] : dag_add_node_hashed(out, level, &nodes[order[n]], l->hash[order[n]]);
        ok            = ref[order[n]] != 0;
    }
    free(order);
    free(nodes);
    return ok;
}

static int compress_bottom_up(const dag *d, dag *out)
{
    uint32_t *below = malloc(((size_t)d->mask_count + 1) * sizeof *below);
    int       ok    = below && unify_masks(d, out, below);
    for (uint32_t level = 0; level < d->level_count && ok; level++) {
        uint32_t *ref = malloc(((size_t)d->level[level].count + 1) * sizeof *ref);
        ok            = ref && unify_nodes(d, out, level, below, ref);
        free(below);
        below = ref;
    }
    for (uint32_t n = 0; n < d->root_count && ok; n++)
        if (d->roots[n] >= REF_FIRST) out->roots[n] = below[d->roots[n] - REF_FIRST];
    free(below);
    return ok;
}

vxs_result dag_compress(dag *d, compress_order order)
{
    if (order == COMPRESS_NONE) return VXS_OK;
    dag out   = {.level_count = d->level_count, .root_count = d->root_count};
    out.roots = malloc(((size_t)d->root_count + 1) * sizeof *out.roots);
    int ok    = out.roots != NULL;
    if (ok) memcpy(out.roots, d->roots, d->root_count * sizeof *out.roots);
    if (ok) ok = order == COMPRESS_TOP_DOWN ? compress_top_down(d, &out) : compress_bottom_up(d, &out);
    if (!ok) {
        dag_free(&out);
        return VXS_E_MEMORY;
    }
    dag_free(d);
    *d = out;
    return VXS_OK;
}
