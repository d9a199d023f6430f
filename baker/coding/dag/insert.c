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
 * Source: [CPVS16] 3.1, 3.2.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/coding/dag/dag.h"

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

/* The mask of a tile at depth k. */
static vxs_result place_slice(inserter *s, tree_tile *tile, uint32_t k, placed *out)
{
    const mask_run *runs = s->tree->runs;
    while (runs[tile->run].until <= k) {
        tile->run++;
        tile->run_ref = 0;
    }
    if (!tile->run_ref || !s->reuse) tile->run_ref = dag_add_mask(s->d, runs[tile->run].mask);
    *out = (placed){tile->run_ref, runs[tile->run].until};
    return out->ref ? VXS_OK : dag_failure(s->d);
}

static vxs_result add_slice_node(inserter *s, tree_square *q, uint32_t k0)
{
    dag_node node;
    q->until = UINT32_MAX;
    for (uint32_t n = 0; n < 8; n++) {
        placed     slice = {REF_SHADOW, UINT32_MAX};
        vxs_result r     = VXS_OK;
        if (k0 + n < q->xmin)
            slice = (placed){REF_LIT, q->xmin};
        else if (k0 + n < q->emax)
            r = place_slice(s, &s->tree->tiles[q->parts], k0 + n, &slice);
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
