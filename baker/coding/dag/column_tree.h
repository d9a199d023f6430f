/* What is known of a square of columns while its DAG is built: a quadtree, looked into only where bounds do not decide.
 *
 *     emax <= xmin       one depth parts lit from shadowed in all of the square: no mask lies under it, and it has no parts until
 *                        insertion asks for them, which it does only where no boundary of a volume falls into [emax, xmin]
 *     otherwise          its four parts are looked into; tiles get their masks
 *     all columns alike  its parts are one part, which stands for all four
 *
 * So time and memory follow silhouettes and surfaces, not the number of texels.
 * Source: [CPVS16] 3 (min-max hierarchy), 3.4 (masks).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COLUMN_TREE_H
#define COLUMN_TREE_H

#include <stddef.h>

#include "baker/coding/dag/masks.h"

enum { PARTS_UNKNOWN = UINT32_MAX };

typedef struct tree_square {
    uint32_t xmin, emax; /* [0, depth_vx] voxels: bounds, exact for tiles with masks */
    uint32_t parts;      /* index of the first of its four parts, of a tile's entry in tiles, or PARTS_UNKNOWN */
    uint32_t alike;      /* 1: all columns are equal, and so are all parts */
    uint32_t ref,
        until; /* insertion: the last volume in it that became a node, 0 for none; its contents hold for depths k < until */
} tree_square;

/* An 8 x 8 tile with masks. */
typedef struct tree_tile {
    uint32_t x, y;       /* counted in tiles from the corner of the fetched square */
    uint32_t first, end; /* runs */
    uint32_t run;        /* insertion: the run that it has come to */
    uint32_t run_ref;    /* insertion: the mask that was inserted for that run; 0 for none */
} tree_tile;

typedef struct column_tree {
    const column_square *columns; /* borrowed */
    uint32_t             level, i, j;
    mask_rule            rule;
    int                  share; /* 1: where all columns are alike, one part stands for four */

    tree_square *squares; /* [square_count]; the whole is squares[0] */
    size_t       square_count, square_capacity;
    tree_tile   *tiles; /* [tile_count] in z order */
    size_t       tile_count, tile_capacity;
    mask_run    *runs; /* [run_count] */
    size_t       run_count, run_capacity;
} column_tree;

/* Look into the square (i, j) of `level` of a fetched square of columns, down to the masks of its tiles.
 * share  1: equal parts of squares whose columns are all alike are kept once
 * t      [out] zeroed on failure; released with column_tree_free
 * Returns VXS_OK, VXS_E_MEMORY, or what the columns return. Threads: none shared. */
vxs_result column_tree_build(column_tree *t, const column_square *columns, uint32_t level, uint32_t i, uint32_t j, mask_rule rule,
                             int share);

/* Make the parts of a square known: square `at` of the tree, which is the square (i, j) of `level` >= 1 of the columns. */
vxs_result column_tree_look_into(column_tree *t, size_t at, uint32_t level, uint32_t i, uint32_t j);

/* Accepts a zeroed object. */
void column_tree_free(column_tree *t);

#endif
