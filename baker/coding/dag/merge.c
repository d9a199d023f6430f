/* Merges squares into one DAG; see dag.h.
 *
 * DAGs are added one after the other, each from its masks up. Once the references of a level are those of the merged DAG, equal
 * contents mean equal subtrees, and one hash table per level finds them. So an added DAG can be freed at once.
 * [CPVS16] 4.3 merges sorted levels instead. Tables keep the order of arrival, in which neighbours stay neighbours.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/dag.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"

/* nodes and masks ------------------------------------------------------------------------------------------------------------- */

/* Reserve space in a table; only `unify` needs it. */
static int reserve(const dag_merger *g, ref_table *table, uint64_t more)
{
    return !g->unify || ref_table_reserve(table, more);
}

/* Returns 0 on failure: see dag_failure. The table must have space. */
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

/* hash: of the subtree. The node has references of the merged DAG. Returns the same. */
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

/* References in the merged DAG: ref[l][n] for node n of level l. */
typedef struct adopted {
    uint32_t *ref[DAG_LEVELS_MAX];
} adopted;

static vxs_result adopt_masks(dag_merger *g, const dag *from, uint32_t **refs)
{
    *refs = malloc(((size_t)from->mask_count + 1) * sizeof **refs);
    if (!*refs || !reserve(g, &g->mask_table, from->mask_count)) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < from->mask_count; n++)
        if (!((*refs)[n] = merged_mask(g, from->masks[n]))) return dag_failure(&g->merged);
    return VXS_OK;
}

static vxs_result adopt_level(dag_merger *g, const dag_level *from, uint32_t level, const uint32_t *below, uint32_t **refs)
{
    *refs = malloc(((size_t)from->count + 1) * sizeof **refs);
    if (!*refs || !reserve(g, &g->table[level], from->count)) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < from->count; n++) {
        dag_node node = from->nodes[n];
        for (int c = 0; c < 8; c++)
            if (node.child[c] >= REF_FIRST) node.child[c] = below[node.child[c] - REF_FIRST];
        if (!((*refs)[n] = merged_node(g, level, &node, from->hash[n]))) return dag_failure(&g->merged);
    }
    return VXS_OK;
}

/* stacks ---------------------------------------------------------------------------------------------------------------------- */

static uint32_t top_level(const dag_merger *g)
{
    return g->merged.level_count - 1;
}

/* Number of slabs of a square of `level` over the whole depth. */
static uint32_t slabs_of(const dag_merger *g, uint32_t level)
{
    return 1u << (top_level(g) - level);
}

static void stack_free(dag_stack *s)
{
    free(s->runs);
    *s = (dag_stack){0};
}

/* capacity  of s->runs */
static int stack_push(dag_stack *s, size_t *capacity, uint32_t ref, uint32_t end)
{
    if (s->count && s->runs[s->count - 1].ref == ref) {
        s->runs[s->count - 1].end = end;
        return 1;
    }
    if (!array_reserve(&s->runs, capacity, (size_t)s->count + 1, sizeof *s->runs)) return 0;
    s->runs[s->count++] = (stack_run){ref, end};
    return 1;
}

/* A node with these children; if all are lit, or all shadowed, that reference. Returns 0 on failure: see dag_failure. */
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

/* Make the stack of a square of `level` from the stacks of its four parts. */
static vxs_result stack_compose(dag_merger *g, uint32_t level, const dag_stack *const part[4], dag_stack *out)
{
    uint32_t at[4] = {0}, slabs = slabs_of(g, level), ref;
    size_t   capacity = 0;
    *out              = (dag_stack){0};
    for (uint32_t slab = 0, same; slab < slabs; slab += same) {
        dag_node node;
        for (int q = 0; q < 4; q++)
            while (part[q]->runs[at[q]].end <= 2 * slab) at[q]++;

        /* The children of the slab: the run at[] of each part contains its near half. `same` slabs have these children. */
        same = UINT32_MAX;
        for (int q = 0; q < 4; q++) {
            const stack_run *near = &part[q]->runs[at[q]], *far = near->end > 2 * slab + 1 ? near : near + 1;
            node.child[q]     = near->ref;
            node.child[4 + q] = far->ref;
            same              = min_u32(same, near == far ? near->end / 2 - slab : 1);
        }

        if (!g->unify) same = 1; /* without unify, each slab has a node of its own */
        if (!merged_parent(g, level, &node, &ref) || !stack_push(out, &capacity, ref, slab + same)) {
            stack_free(out);
            return dag_failure(&g->merged);
        }
    }
    return VXS_OK;
}

/* Widen a stack to a square of level `to` whose parts are all equal. */
static vxs_result stack_widen(dag_merger *g, dag_stack *s, uint32_t level, uint32_t to)
{
    for (; level < to; level++) {
        const dag_stack *const part[4] = {s, s, s, s};
        dag_stack              wider;
        vxs_result             r = stack_compose(g, level + 1, part, &wider);
        if (r != VXS_OK) return r;
        stack_free(s);
        *s = wider;
    }
    return VXS_OK;
}

/* squares --------------------------------------------------------------------------------------------------------------------- */

/* Take four empty squares. Returns the index of the first, or 0 without memory. */
static uint32_t take_four(dag_merger *g)
{
    uint32_t first = g->spare;
    if (first) {
        g->spare = g->squares[first].parts;
    } else {
        if (!array_reserve(&g->squares, &g->square_capacity, g->square_count + 4, sizeof *g->squares)) return 0;
        first = (uint32_t)g->square_count;
        g->square_count += 4;
    }
    memset(&g->squares[first], 0, 4 * sizeof *g->squares);
    return first;
}

static int are_complete(const dag_merger *g, uint32_t first)
{
    for (uint32_t c = 0; c < 4; c++)
        if (!g->squares[first + c].stack.runs) return 0;
    return 1;
}

/* Replace four complete parts by the stack of their square. */
static vxs_result close_square(dag_merger *g, uint32_t at, uint32_t level)
{
    uint32_t               first   = g->squares[at].parts;
    const dag_stack *const part[4] = {&g->squares[first].stack, &g->squares[first + 1].stack, &g->squares[first + 2].stack,
                                      &g->squares[first + 3].stack};
    dag_stack              whole;
    vxs_result             r = stack_compose(g, level, part, &whole);
    if (r != VXS_OK) return r;
    for (uint32_t c = 0; c < 4; c++) stack_free(&g->squares[first + c].stack);
    g->squares[first].parts = g->spare;
    g->spare                = first;
    g->squares[at]          = (merge_square){.stack = whole};
    return VXS_OK;
}

/* Put a stack at its place below square `at` of `top`, and close the squares that this completes. The merger owns the stack
 * afterwards. */
static vxs_result put_stack(dag_merger *g, uint32_t at, uint32_t top, uint32_t level, uint32_t i, uint32_t j, dag_stack *stack)
{
    vxs_result r;
    if (g->squares[at].stack.runs) return VXS_E_ARGUMENT;
    if (top == level) {
        if (g->squares[at].parts) return VXS_E_ARGUMENT;
        g->squares[at].stack = *stack;
        *stack               = (dag_stack){0};
        return VXS_OK;
    }
    if (!g->squares[at].parts) {
        uint32_t first = take_four(g);
        if (!first) return VXS_E_MEMORY;
        g->squares[at].parts = first;
    }
    uint32_t bit = top - 1 - level, first = g->squares[at].parts;
    if ((r = put_stack(g, first + (i >> bit & 1) + 2 * (j >> bit & 1), top - 1, level, i, j, stack)) != VXS_OK) return r;
    return are_complete(g, first) ? close_square(g, at, top) : VXS_OK;
}

/* Add a square whose stack refers to nodes of the merger. Always releases the stack. Returns what dag_merger_add returns. */
static vxs_result add_stack(dag_merger *g, uint32_t map, uint32_t level, uint32_t i, uint32_t j, dag_stack *stack)
{
    vxs_result r = VXS_E_ARGUMENT;
    if (map < g->map_count && level <= top_level(g) && i < slabs_of(g, level) && j < slabs_of(g, level))
        r = put_stack(g, map, top_level(g), level, i, j, stack);
    stack_free(stack);
    return r;
}

/* the merger ------------------------------------------------------------------------------------------------------------------ */

vxs_result dag_merger_init(dag_merger *g, uint32_t side_px, uint32_t map_count, int unify)
{
    *g                    = (dag_merger){.map_count = map_count, .unify = unify};
    g->merged.level_count = dag_levels(side_px);
    if (!array_reserve(&g->squares, &g->square_capacity, map_count, sizeof *g->squares)) return VXS_E_MEMORY;
    g->square_count = map_count;
    memset(g->squares, 0, map_count * sizeof *g->squares);
    return VXS_OK;
}

void dag_merger_free(dag_merger *g)
{
    for (uint32_t l = 0; l < DAG_LEVELS_MAX; l++) ref_table_free(&g->table[l]);
    ref_table_free(&g->mask_table);
    dag_free(&g->merged);
    for (size_t n = 0; n < g->square_count; n++) stack_free(&g->squares[n].stack);
    free(g->squares);
    memset(g, 0, sizeof *g);
}

vxs_result dag_merger_add(dag_merger *g, const dag *sub, uint32_t map, uint32_t level, uint32_t i, uint32_t j)
{
    adopted    a;
    dag_stack  stack    = {0};
    size_t     capacity = 0;
    uint32_t   own      = sub->level_count - 1;
    vxs_result r;
    if (own > level || level > top_level(g) || sub->root_count != slabs_of(g, own)) return VXS_E_ARGUMENT;
    uint32_t *masks = NULL;
    memset(&a, 0, sizeof a);
    r = adopt_masks(g, sub, &masks);
    for (uint32_t l = 0; l < sub->level_count && r == VXS_OK; l++)
        r = adopt_level(g, &sub->level[l], l, l ? a.ref[l - 1] : masks, &a.ref[l]);
    free(masks);

    for (uint32_t slab = 0; slab < sub->root_count && r == VXS_OK; slab++) {
        uint32_t root = sub->roots[slab];
        if (!stack_push(&stack, &capacity, root < REF_FIRST ? root : a.ref[own][root - REF_FIRST], slab + 1)) r = VXS_E_MEMORY;
    }
    for (uint32_t l = 0; l < DAG_LEVELS_MAX; l++) free(a.ref[l]);
    if (r == VXS_OK) r = stack_widen(g, &stack, own, level);
    if (r == VXS_OK) return add_stack(g, map, level, i, j, &stack);
    stack_free(&stack);
    return r;
}

vxs_result dag_merger_add_split(dag_merger *g, uint32_t map, uint32_t level, uint32_t i, uint32_t j, uint32_t slab_level,
                                uint32_t lit_slabs)
{
    dag_stack stack    = {0};
    size_t    capacity = 0;
    if (level > top_level(g) || slab_level > level || lit_slabs > slabs_of(g, slab_level)) return VXS_E_ARGUMENT;
    uint32_t   slabs = slabs_of(g, slab_level);
    vxs_result r     = VXS_E_MEMORY;
    if ((!lit_slabs || stack_push(&stack, &capacity, REF_LIT, lit_slabs)) &&
        (lit_slabs == slabs || stack_push(&stack, &capacity, REF_SHADOW, slabs)))
        r = stack_widen(g, &stack, slab_level, level);
    if (r == VXS_OK) return add_stack(g, map, level, i, j, &stack);
    stack_free(&stack);
    return r;
}

/* Complete a square: parts that were never added are lit. */
static vxs_result finish_square(dag_merger *g, uint32_t at, uint32_t level)
{
    vxs_result r = VXS_OK;
    if (g->squares[at].stack.runs) return VXS_OK;
    if (!g->squares[at].parts) {
        size_t capacity = 0;
        return stack_push(&g->squares[at].stack, &capacity, REF_LIT, slabs_of(g, level)) ? VXS_OK : VXS_E_MEMORY;
    }
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) r = finish_square(g, g->squares[at].parts + c, level - 1);
    return r == VXS_OK ? close_square(g, at, level) : r;
}

/* The root of a map: a node, even if the map is all lit or shadowed. Returns 0 on failure: see dag_failure. */
static uint32_t root_node(dag_merger *g, uint32_t root)
{
    dag_node node;
    if (root >= REF_FIRST) return root;
    for (int c = 0; c < 8; c++) node.child[c] = root;
    return dag_add_node(&g->merged, top_level(g), &node);
}

vxs_result dag_merger_finish(dag_merger *g, dag *out)
{
    dag       *d = &g->merged;
    vxs_result r = VXS_OK;
    for (uint32_t map = 0; map < g->map_count && r == VXS_OK; map++) r = finish_square(g, map, top_level(g));
    if (r != VXS_OK) return r;
    if (!(d->roots = malloc(g->map_count * sizeof *d->roots))) return VXS_E_MEMORY;
    d->root_count = g->map_count;
    for (uint32_t map = 0; map < g->map_count; map++)
        if (!(d->roots[map] = root_node(g, g->squares[map].stack.runs[0].ref))) return dag_failure(d);
    *out = *d;
    memset(d, 0, sizeof *d);
    return VXS_OK;
}
