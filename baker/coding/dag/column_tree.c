/* The quadtree of a square of columns; see column_tree.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/column_tree.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"

static vxs_result bound_square(const column_tree *t, tree_square *q, uint32_t level, uint32_t i, uint32_t j)
{
    column_bounds b;
    vxs_result    r = t->columns->bounds(t->columns->data, level, i, j, &b);
    if (r != VXS_OK) return r;
    *q = (tree_square){.xmin = b.xmin, .emax = b.emax, .parts = PARTS_UNKNOWN, .alike = (uint32_t)bounds_alike(&b)};
    return VXS_OK;
}

vxs_result column_tree_look_into(column_tree *t, size_t at, uint32_t level, uint32_t i, uint32_t j)
{
    uint32_t   count = t->share && t->squares[at].alike ? 1 : 4;
    size_t     first = t->square_count;
    vxs_result r;
    if (first + 4 >= PARTS_UNKNOWN) return VXS_E_REFERENCES;
    if (!array_reserve(&t->squares, &t->square_capacity, first + count, sizeof *t->squares)) return VXS_E_MEMORY;
    t->squares[at].parts = (uint32_t)first;
    t->square_count += count;
    if (count == 1) {
        t->squares[first]       = t->squares[at];
        t->squares[first].parts = PARTS_UNKNOWN;
        t->squares[first].ref   = 0;
        return VXS_OK;
    }
    for (uint32_t c = 0; c < 4; c++) {
        tree_square *part = &t->squares[first + c];
        if ((r = bound_square(t, part, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1))) != VXS_OK) return r;
        /* the bounds of a part may be looser than those of the whole: a decision about the whole must hold for its parts */
        part->xmin = max_u32(part->xmin, t->squares[at].xmin);
        part->emax = min_u32(part->emax, t->squares[at].emax);
    }
    return VXS_OK;
}

/* Parts in z order, so that neighbours in the map are neighbours in the arrays. */
static vxs_result find_masks(column_tree *t, size_t at, uint32_t level, uint32_t i, uint32_t j)
{
    vxs_result r;
    if (t->squares[at].emax <= t->squares[at].xmin) return VXS_OK;
    if (level == 0) {
        column_tile   columns;
        column_bounds bounds;
        r = t->columns->tile(t->columns->data, i, j, &columns);
        if (r != VXS_OK) return r;
        if (!array_reserve(&t->runs, &t->run_capacity, t->run_count + TILE_RUNS_MAX, sizeof *t->runs)) return VXS_E_MEMORY;
        if (!array_reserve(&t->tiles, &t->tile_capacity, t->tile_count + 1, sizeof *t->tiles)) return VXS_E_MEMORY;
        uint32_t     first = (uint32_t)t->run_count, count = tile_runs(&columns, t->rule, t->runs + first, &bounds);
        tree_square *q = &t->squares[at];
        q->xmin        = bounds.xmin;
        q->emax        = bounds.emax;
        if (!count) return VXS_OK;
        q->parts                  = (uint32_t)t->tile_count;
        t->tiles[t->tile_count++] = (tree_tile){.x = i, .y = j, .first = first, .end = first + count, .run = first};
        t->run_count += count;
        return VXS_OK;
    }
    if ((r = column_tree_look_into(t, at, level, i, j)) != VXS_OK) return r;
    uint32_t first = t->squares[at].parts;
    for (uint32_t c = 0; c < 4; c++)
        if ((r = find_masks(t, first + c, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1))) != VXS_OK) return r;
    return VXS_OK;
}

vxs_result column_tree_build(column_tree *t, const column_square *columns, uint32_t level, uint32_t i, uint32_t j, mask_rule rule,
                             int share)
{
    vxs_result r;
    *t = (column_tree){.columns = columns, .level = level, .i = i, .j = j, .rule = rule, .share = share};
    r  = array_reserve(&t->squares, &t->square_capacity, 1, sizeof *t->squares) ? VXS_OK : VXS_E_MEMORY;
    if (r == VXS_OK) r = bound_square(t, &t->squares[t->square_count++], level, i, j);
    if (r == VXS_OK) r = find_masks(t, 0, level, i, j);
    if (r != VXS_OK) column_tree_free(t);
    return r;
}

void column_tree_free(column_tree *t)
{
    free(t->squares);
    free(t->tiles);
    free(t->runs);
    memset(t, 0, sizeof *t);
}
