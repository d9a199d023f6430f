/* Visibility masks of 8 x 8 tiles, each with the depth up to which it holds.
 * Source: [CPVS16] 3.4.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MASKS_H
#define MASKS_H

#include "baker/columns/columns.h"

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

#endif
