/* Top-down insertion in z order, with reuse of the neighbour nearer the light; see dag.h.
 *
 * A volume is a square of columns times a range of depth as long as the square is wide. From the bounds of its columns it is
 *
 *     lit         when it ends at or before xmin: nothing in it has to be dark
 *     shadowed    when it starts at or behind emax: nothing in it has to be lit
 *     a copy      of the volume before it, when the contents of that one hold up to this one's end
 *     a node      otherwise, and its eight parts are looked at, the four nearer the light first
 *
 * Contents "hold until" a depth: up to there every column keeps the state it has at the node's start. It is the least over the
 * parts: xmin for a lit one, for ever for a shadowed one, the end of its run for a mask. Since a node holds until its own end only
 * if nothing changes inside it, a copy is made only of volumes that are the same at every depth.
 *
 * Source: [CPVS16] 3.1, 3.2.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/dag/dag.h"

/* What is known of a square of columns: its bounds, and the last volume in it that became a node. */
typedef struct square {
    uint32_t xmin, emax;
    uint32_t ref;   /* 0 until there is one */
    uint32_t until; /* voxels: the contents of ref hold until here */
} square;

typedef struct inserter {
    dag              *d;
    const tile_masks *masks;
    square           *level[DAG_LEVELS_MAX]; /* [l]: squares of 8 << l texels, in rows; level[0] owns all */
    uint32_t         *run;                   /* [tiles] the run that each tile has come to */
    uint32_t         *run_ref;               /* [tiles] the mask that was inserted for it, 0 when none was */
    int               reuse;
    int               failed;
} inserter;

/* The reference to a tile's mask at depth k; *until becomes the depth to which it holds. */
static uint32_t slice_ref(inserter *s, uint32_t tile, uint32_t k, uint32_t *until)
{
    const tile_masks *t = s->masks;
    while (t->until[s->run[tile]] <= k) {
        s->run[tile]++;
        s->run_ref[tile] = 0;
    }
    if (!s->run_ref[tile] || !s->reuse) s->run_ref[tile] = dag_add_mask(s->d, t->mask[s->run[tile]]);
    *until = t->until[s->run[tile]];
    return s->run_ref[tile];
}

static uint32_t add_slice_node(inserter *s, square *q, uint32_t tile, uint32_t k0)
{
    dag_node node;
    uint32_t until = UINT32_MAX;
    for (uint32_t n = 0; n < 8; n++) {
        uint32_t k = k0 + n;
        if (k < q->xmin) {
            node.child[n] = REF_LIT;
            until         = min_u32(until, q->xmin);
        } else if (k >= q->emax) {
            node.child[n] = REF_SHADOW;
        } else {
            uint32_t holds;
            node.child[n] = slice_ref(s, tile, k, &holds);
            until         = min_u32(until, holds);
            s->failed |= !node.child[n];
        }
    }
    q->until      = until;
    return q->ref = dag_add_node(s->d, 0, &node);
}

/* The volume of square (i, j) at `level` that starts at depth k0; *until becomes the depth to which it holds. */
static uint32_t place(inserter *s, uint32_t level, uint32_t i, uint32_t j, uint32_t k0, uint32_t *until)
{
    uint32_t side = (s->masks->side_tiles >> level);
    square  *q    = &s->level[level][(size_t)j * side + i];
    uint32_t end  = k0 + (8u << level);
    if (end <= q->xmin) {
        *until = q->xmin;
        return REF_LIT;
    }
    if (k0 >= q->emax) {
        *until = UINT32_MAX;
        return REF_SHADOW;
    }
    if (s->reuse && q->ref && end <= q->until) {
        *until = q->until;
        return q->ref;
    }

    if (level == 0) {
        s->failed |= !add_slice_node(s, q, j * side + i, k0);
    } else {
        dag_node node;
        uint32_t least = UINT32_MAX;
        uint32_t half  = 4u << level;
        for (uint32_t c = 0; c < 8 && !s->failed; c++) {
            uint32_t holds;
            node.child[c] = place(s, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1 & 1), k0 + (c >> 2) * half, &holds);
            least         = min_u32(least, holds);
        }
        if (s->failed) return REF_LIT;
        q->until = least;
        q->ref   = dag_add_node(s->d, level, &node);
        s->failed |= !q->ref;
    }
    *until = q->until;
    return q->ref;
}

static int inserter_init(inserter *s, const column_source *source, uint32_t i, uint32_t j, uint32_t level_count)
{
    uint32_t side  = s->masks->side_tiles;
    size_t   tiles = (size_t)side * side;
    size_t   total = 0;
    for (uint32_t l = 0; l < level_count; l++) total += tiles >> (2 * l);
    s->level[0] = malloc(total * sizeof *s->level[0]);
    s->run      = malloc(tiles * sizeof *s->run);
    s->run_ref  = calloc(tiles, sizeof *s->run_ref);
    if (!s->level[0] || !s->run || !s->run_ref) return 0;

    memcpy(s->run, s->masks->first, tiles * sizeof *s->run);
    square *q = s->level[0];
    for (size_t t = 0; t < tiles; t++) *q++ = (square){.xmin = s->masks->xmin[t], .emax = s->masks->emax[t]};
    for (uint32_t l = 1; l < level_count; l++) {
        side /= 2;
        s->level[l] = q;
        for (uint32_t y = 0; y < side; y++)
            for (uint32_t x = 0; x < side; x++) {
                column_bounds b = source->bounds(source->data, l, i * side + x, j * side + y);
                *q++            = (square){.xmin = b.xmin, .emax = b.emax};
            }
    }
    return 1;
}

vxs_result dag_insert(dag *d, const column_source *source, uint32_t i, uint32_t j, uint32_t level_count, const tile_masks *masks,
                      int reuse)
{
    memset(d, 0, sizeof *d);
    uint32_t side  = 4u << level_count; /* texels: 8 << (level_count - 1) */
    d->level_count = level_count;
    d->root_count  = source->depth_vx / side;
    d->roots       = malloc(d->root_count * sizeof *d->roots);
    inserter s     = {.d = d, .masks = masks, .reuse = reuse};
    s.failed       = !d->roots || !inserter_init(&s, source, i, j, level_count);

    for (uint32_t slab = 0; slab < d->root_count && !s.failed; slab++) {
        uint32_t until;
        d->roots[slab] = place(&s, level_count - 1, 0, 0, slab * side, &until);
    }

    free(s.level[0]);
    free(s.run);
    free(s.run_ref);
    if (s.failed) dag_free(d);
    return s.failed ? VXS_E_MEMORY : VXS_OK;
}
