/* Storage of a DAG under construction; see dag.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/dag.h"

#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "baker/base/array.h"

void dag_free(dag *d)
{
    for (uint32_t l = 0; l < DAG_LEVELS_MAX; l++) {
        free(d->level[l].nodes);
        free(d->level[l].hash);
    }
    free(d->masks);
    free(d->roots);
    memset(d, 0, sizeof *d);
}

/* Whether there is a reference for one more of `count` elements. */
static int has_room(dag *d, uint32_t count)
{
    uint32_t limit = d->limit ? d->limit : UINT32_MAX - REF_FIRST;
    if (count < limit) return 1;
    d->full = 1;
    return 0;
}

vxs_result dag_failure(const dag *d)
{
    return d->full ? VXS_E_REFERENCES : VXS_E_MEMORY;
}

uint32_t dag_add_mask(dag *d, uint64_t mask)
{
    if (!has_room(d, d->mask_count)) return 0;
    if (!array_reserve(&d->masks, &d->mask_capacity, (size_t)d->mask_count + 1, sizeof *d->masks)) return 0;
    d->masks[d->mask_count] = mask;
    return REF_FIRST + d->mask_count++;
}

/* The hash of a child of a node at `level`. */
static uint64_t child_hash(const dag *d, uint32_t level, uint32_t ref)
{
    if (ref < REF_FIRST) return ref;
    /* a mask is its own hash: its parent's hash mixes it */
    return level ? d->level[level - 1].hash[ref - REF_FIRST] : d->masks[ref - REF_FIRST];
}

uint64_t dag_node_hash(const dag *d, uint32_t level, const dag_node *node)
{
    uint64_t children[8];
    for (int c = 0; c < 8; c++) children[c] = child_hash(d, level, node->child[c]);
    return XXH3_64bits(children, sizeof children);
}

uint32_t dag_add_node(dag *d, uint32_t level, const dag_node *node)
{
    return dag_add_node_hashed(d, level, node, dag_node_hash(d, level, node));
}

uint32_t dag_add_node_hashed(dag *d, uint32_t level, const dag_node *node, uint64_t hash)
{
    dag_level *l     = &d->level[level];
    size_t     count = (size_t)l->count + 1;
    if (!has_room(d, l->count)) return 0;
    if (!array_reserve(&l->nodes, &l->node_capacity, count, sizeof *l->nodes)) return 0;
    if (!array_reserve(&l->hash, &l->hash_capacity, count, sizeof *l->hash)) return 0;
    l->nodes[l->count] = *node;
    l->hash[l->count]  = hash;
    return REF_FIRST + l->count++;
}

uint64_t dag_node_count(const dag *d)
{
    uint64_t count = 0;
    for (uint32_t l = 0; l < d->level_count; l++) count += d->level[l].count;
    return count;
}

vxs_write_light dag_to_write(const vxs_light *light, const dag *d)
{
    vxs_write_light w = {.light = *light, .dag = {.level_count = d->level_count, .masks = d->masks, .mask_count = d->mask_count}};
    w.light.coding    = VXS_CODING_DAG;
    for (uint32_t map = 0; map < d->root_count; map++) w.dag.roots[map] = d->roots[map] - REF_FIRST;
    for (uint32_t l = 0; l < d->level_count; l++) {
        w.dag.nodes[l] = d->level[l].nodes ? d->level[l].nodes[0].child : NULL;
        w.dag.count[l] = d->level[l].count;
    }
    return w;
}

enum { NODE_BYTES = 32 };

int dag_put(const dag *d, vxs_bytes *out)
{
    int ok = put32(out, d->mask_count);
    for (uint32_t l = 0; l < d->level_count && ok; l++) ok = put32(out, d->level[l].count);
    for (uint32_t n = 0; n < d->mask_count && ok; n++) ok = put64(out, d->masks[n]);
    for (uint32_t l = 0; l < d->level_count; l++)
        for (uint32_t n = 0; n < d->level[l].count && ok; n++) ok = put32s(out, d->level[l].nodes[n].child, 8);
    return ok;
}

static vxs_result take_masks(dag *d, byte_reader *r, uint32_t count)
{
    if (!has(r, count, 8)) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < count; n++)
        if (!dag_add_mask(d, take64(r))) return dag_failure(d);
    return VXS_OK;
}

static vxs_result take_level(dag *d, byte_reader *r, uint32_t level, uint32_t count)
{
    uint32_t below = level ? d->level[level - 1].count : d->mask_count;
    if (!has(r, count, NODE_BYTES)) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < count; n++) {
        dag_node node;
        take32s(r, node.child, 8);
        for (int c = 0; c < 8; c++)
            if (node.child[c] >= REF_FIRST && node.child[c] - REF_FIRST >= below) return VXS_E_CORRUPT;
        if (!dag_add_node(d, level, &node)) return dag_failure(d);
    }
    return VXS_OK;
}

vxs_result dag_take(dag *d, byte_reader *r)
{
    uint32_t counts[DAG_LEVELS_MAX];
    if (!has(r, (uint64_t)d->level_count + 1, 4)) return VXS_E_CORRUPT;
    uint32_t masks = take32(r);
    take32s(r, counts, d->level_count);
    vxs_result result = take_masks(d, r, masks);
    for (uint32_t l = 0; l < d->level_count && result == VXS_OK; l++) result = take_level(d, r, l, counts[l]);
    return result;
}

/* Top-down insertion in z order, with reuse of the neighbour nearer to the light; see dag.h.
 *
 * A volume is a square of columns and a range of depth as long as the square is wide. From the bounds of its columns it is
 *
 *     lit         if it ends at or before xmin: nothing in it must be shadowed
 *     shadowed    if it starts at or behind emax: nothing in it must be lit
 *     a copy      of the volume before it, if the contents of that one hold up to the end of this one
 *     a node      otherwise; its eight parts are inserted, the four nearer to the light first
 *
 * Contents "hold until" a depth if every column keeps its state from the start of the node up to there. This depth is the least
 * over the parts: xmin for a lit one, infinite for a shadowed one, the end of its run for a mask. A node holds until its own end
 * only if nothing changes inside it. So only volumes that are equal at every depth are copied.
 *
 * Source: [CPVS16] 3.1, 3.2. */

typedef struct inserter {
    dag         *d;
    column_tree *tree;
    int          reuse;
} inserter;

/* An inserted volume. */
typedef struct placed {
    uint32_t ref;
    uint32_t until; /* voxels: the contents of ref hold until here */
} placed;

static vxs_result add_slice_node(inserter *s, tree_square *q, uint32_t k0)
{
    dag_node node;
    q->until = UINT32_MAX;
    for (uint32_t n = 0; n < 8; n++) {
        placed     slice = {REF_SHADOW, UINT32_MAX};
        vxs_result r     = VXS_OK;
        if (k0 + n < q->xmin)
            slice = (placed){REF_LIT, q->xmin};
        else if (k0 + n < q->emax) {
            tree_tile      *tile = &s->tree->tiles[q->parts];
            const mask_run *runs = s->tree->runs;
            while (runs[tile->run].until <= k0 + n) {
                tile->run++;
                tile->run_ref = 0;
            }
            if (!tile->run_ref || !s->reuse) tile->run_ref = dag_add_mask(s->d, runs[tile->run].mask);
            slice = (placed){tile->run_ref, runs[tile->run].until};
            r     = slice.ref ? VXS_OK : dag_failure(s->d);
        }
        if (r != VXS_OK) return r;
        node.child[n] = slice.ref;
        q->until      = min_u32(q->until, slice.until);
    }
    q->ref = dag_add_node(s->d, 0, &node);
    return q->ref ? VXS_OK : dag_failure(s->d);
}

static vxs_result place(inserter *s, size_t at, uint32_t level, uint32_t i, uint32_t j, uint32_t k0, placed *out);

/* A node of eight parts. Insertion of parts may move the array of squares. */
static vxs_result add_octree_node(inserter *s, size_t at, uint32_t level, uint32_t i, uint32_t j, uint32_t k0)
{
    column_tree *t = s->tree;
    vxs_result   r;
    if (t->squares[at].parts == PARTS_UNKNOWN && (r = column_tree_look_into(t, at, level, i, j)) != VXS_OK) return r;
    uint32_t first = t->squares[at].parts, until = UINT32_MAX;
    int      alike = t->share && t->squares[at].alike;
    dag_node node;
    for (uint32_t c = 0; c < 8; c++) {
        placed   part;
        uint32_t square = c & 3;
        if (alike && square) {
            node.child[c] = node.child[c & 4];
            continue;
        }
        r = place(s, first + square, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1 & 1), k0 + (c >> 2) * (4u << level), &part);
        if (r != VXS_OK) return r;
        node.child[c] = part.ref;
        until         = min_u32(until, part.until);
    }
    tree_square *q = &t->squares[at];
    q->until       = until;
    q->ref         = dag_add_node(s->d, level, &node);
    return q->ref ? VXS_OK : dag_failure(s->d);
}

/* Insert the volume of square (i, j) of `level`, index `at` of the tree, that starts at depth k0. */
static vxs_result place(inserter *s, size_t at, uint32_t level, uint32_t i, uint32_t j, uint32_t k0, placed *out)
{
    tree_square *q   = &s->tree->squares[at];
    uint32_t     end = k0 + (8u << level);
    vxs_result   r   = VXS_OK;
    if (end <= q->xmin) {
        *out = (placed){REF_LIT, q->xmin};
        return VXS_OK;
    }
    if (k0 >= q->emax) {
        *out = (placed){REF_SHADOW, UINT32_MAX};
        return VXS_OK;
    }
    if (!s->reuse || !q->ref || end > q->until) r = level ? add_octree_node(s, at, level, i, j, k0) : add_slice_node(s, q, k0);
    q    = &s->tree->squares[at];
    *out = (placed){q->ref, q->until};
    return r;
}

vxs_result dag_insert(dag *d, column_tree *tree, int reuse)
{
    memset(d, 0, sizeof *d);
    uint32_t   side = 8u << tree->level;
    inserter   s    = {.d = d, .tree = tree, .reuse = reuse};
    vxs_result r    = VXS_OK;
    d->level_count  = tree->level + 1;
    d->root_count   = tree->columns->depth_vx / side;
    d->roots        = malloc(d->root_count * sizeof *d->roots);
    if (!d->roots) return VXS_E_MEMORY;
    for (uint32_t slab = 0; slab < d->root_count && r == VXS_OK; slab++) {
        placed root    = {0};
        r              = place(&s, 0, tree->level, tree->i, tree->j, slab * side, &root);
        d->roots[slab] = root.ref;
    }
    if (r != VXS_OK) dag_free(d);
    return r;
}
