/* Quadtree over a square of columns for the build of its DAG. It is refined only where bounds do not decide.
 *
 *     emax <= xmin         one depth separates lit from shadowed in the whole square: no masks, and no parts until insertion
 *     needs them.
 *                          Insertion needs them only if no boundary of a volume is in [emax, xmin]
 *     otherwise            its four parts are refined; tiles get their masks
 *     all columns equal    one part stands for all four
 *
 * So time and memory depend on silhouettes and surfaces, not on the number of texels.
 * Source: [CPVS16] 3 (min-max hierarchy), 3.4 (masks).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COLUMN_TREE_H
#define COLUMN_TREE_H

#include <stddef.h>

#include "baker/columns/columns.h"

/* Visibility masks of 8 x 8 tiles, each with the depth up to which it holds.
 * Source: [CPVS16] 3.4. */

typedef enum mask_rule {
    MASK_RULE_GREEDY, /* [CPVS16] 3.4: a mask is reused up to the nearest exit depth of its lit texels */
    MASK_RULE_SHADOW  /* [Sintorn 2014]: in a slice with lit and shadowed voxels, don't-care voxels are shadowed */
} mask_rule;

/* A visibility mask and its depth range: from the end of the previous run (first run of a tile: xmin) to k < until. */
typedef struct mask_run {
    uint64_t mask;  /* bit x + 8y: texel (x, y) is in shadow */
    uint32_t until; /* (xmin, emax] voxels */
} mask_run;

enum { TILE_RUNS_MAX = 64 }; /* every run except the last ends where a texel becomes shadowed */

/* The runs of a tile, near to far. The tile is lit in front of its xmin and shadowed behind its emax. If emax <= xmin, one depth
 * separates lit from shadowed, and there is no run.
 * bounds  [out] of the tile's columns, exact
 * Returns the number of runs, [0, TILE_RUNS_MAX]. The last run ends at emax. */
uint32_t tile_runs(const column_tile *columns, mask_rule rule, mask_run runs[TILE_RUNS_MAX], column_bounds *bounds);

enum { PARTS_UNKNOWN = UINT32_MAX };

typedef struct tree_square {
    uint32_t xmin, emax; /* [0, depth_vx] voxels: bounds, exact for tiles with masks */
    uint32_t parts;      /* index of the first of four parts; of a tile: index into tiles; or PARTS_UNKNOWN */
    uint32_t alike;      /* 1: all columns are equal, and so are all parts */
    uint32_t ref, until; /* insertion: last volume that became a node, 0: none; it holds for depths k < until */
} tree_square;

/* An 8 x 8 tile with masks. */
typedef struct tree_tile {
    uint32_t x, y;       /* in tiles, from the corner of the fetched square */
    uint32_t first, end; /* runs [first, end) */
    uint32_t run;        /* insertion: current run */
    uint32_t run_ref;    /* insertion: mask inserted for the current run; 0: none */
} tree_tile;

typedef struct column_tree {
    const column_square *columns; /* borrowed */
    uint32_t             level, i, j;
    mask_rule            rule;
    int                  share; /* 1: if all columns are equal, one part stands for all four */

    tree_square *squares; /* [square_count]; squares[0] is the whole */
    size_t       square_count, square_capacity;
    tree_tile   *tiles; /* [tile_count] in z order */
    size_t       tile_count, tile_capacity;
    mask_run    *runs; /* [run_count] */
    size_t       run_count, run_capacity;
} column_tree;

/* Build the tree of the square (i, j) of `level` of a fetched square of columns, down to the masks of its tiles.
 * share  1: equal parts of squares with equal columns are stored once
 * t      [out] zeroed on failure; released with column_tree_free
 * Returns VXS_OK, VXS_E_MEMORY, or what the columns return. Threads: no shared state. */
vxs_result column_tree_build(column_tree *t, const column_square *columns, uint32_t level, uint32_t i, uint32_t j, mask_rule rule,
                             int share);

/* Add the parts of square `at` of the tree, which is the square (i, j) of `level` >= 1 of the columns. */
vxs_result column_tree_look_into(column_tree *t, size_t at, uint32_t level, uint32_t i, uint32_t j);

/* Accepts a zeroed object. */
void column_tree_free(column_tree *t);

#endif
