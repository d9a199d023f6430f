/* A fetched square: a pyramid of bounds, and the columns of the tiles that no single depth decides.
 *
 * A square is split until what is known of it decides it: when nothing in it is entered behind where something is left, all of its columns
 * are said to be alike, entered at F and left at xmin. Whoever keeps to that keeps to what is there, but has less to choose from than
 * there is. So small squares are decided only where their lists tell as much as their texels would (square_settle.h), and lose nothing to
 * those who look at them; tiles of the others are looked at texel by texel, and keep all that is free before F. Files get smaller by it: a city
 * at 16384 texels from 12 to 2 % more than when it is rendered.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_SQUARE_H
#define SPARSE_SQUARE_H

#include "baker/base/context.h"
#include "baker/columns/sparse/leaf.h"
#include "baker/columns/sparse/triangle_bins.h"

enum { SPARSE_LEVELS_MAX = 20 };

typedef struct leaf_page     leaf_page;
typedef struct square_worker square_worker;

typedef struct sparse_square {
    texel_square   at;
    depth_scale    scale;
    column_bounds *pyramid[SPARSE_LEVELS_MAX]; /* [l]: squares of 8 << l texels, rows of squares; pyramid[0] owns all */
    column_tile  **tiles;                      /* [(side / 8)^2] NULL: all columns are as the bounds say */
    int            is_settled;                 /* 1: as a whole, by these bounds, and there is no pyramid */
    column_bounds  settled;
    square_worker *workers; /* [worker_count] what each thread needs, and the pages that own the tiles */
    uint32_t       worker_count;
} sparse_square;

/* The functions of a level of cpu.h. */
typedef struct sparse_level {
    square_list_gather *gather;
    square_list_split  *split;
    leaf_columns       *leaf;
} sparse_level;

extern const sparse_level sparse_levels[2];

/* Compute a square. Its bins are as large as it is, or the square as large as one of them or smaller.
 * q    zeroed, or cleared: what it holds serves again
 * ctx  the run's, which may hold so much; nothing is told to it
 * Returns VXS_OK or VXS_E_MEMORY; released with sparse_square_free either way. */
vxs_result sparse_square_make(sparse_square *q, const sparse_level *level, const leaf_desc *d, const triangle_bins *bins,
                              texel_square at, uint32_t threads, const bake_context *ctx);

/* Release the columns, and keep arrays for the next square. Accepts a zeroed object. */
void sparse_square_clear(sparse_square *q);

/* Accepts a zeroed object. */
void sparse_square_free(sparse_square *q);

/* As columns; valid where q lies. */
column_square sparse_square_columns(sparse_square *q);

#endif
