/* A fetched square: a pyramid of bounds, and the columns of those tiles that no single depth decides.
 *
 * A square is split until its list decides it. If no enter depth is behind any exit depth, the square stores one column for all
 * texels: enter depth F and exit depth xmin. This column keeps the contract of every texel, but leaves the coding fewer don't-care
 * voxels than there are. So small squares are decided only if their lists give as much as their texels do (square_bound.h). In the
 * other small squares tiles are evaluated texel by texel, and keep all don't-care voxels before F. This makes files smaller: a city
 * at 16384 texels was 12 % larger than with rendered maps, and is 2 % larger now.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_SQUARE_H
#define SPARSE_SQUARE_H

#include "baker/base/context.h"
#include "baker/columns/sparse/leaf.h"
#include "baker/columns/sparse/sparse_triangles.h"

enum { SPARSE_LEVELS_MAX = 20 };

typedef struct leaf_page     leaf_page;
typedef struct square_worker square_worker;

typedef struct sparse_square {
    texel_square   at;
    depth_scale    scale;
    column_bounds *pyramid[SPARSE_LEVELS_MAX]; /* [l]: squares of 8 << l texels, rows of squares; unset within a settled square.
                                                  pyramid[0] owns all */
    column_tile  **tiles;                      /* [(side / 8)^2] of level 0. NULL: all columns equal the bounds */
    uint8_t       *levels;                     /* [(side / 8)^2] level of the square that is settled around a tile, or 0 */
    square_worker *workers;                    /* [worker_count] scratch memory of each thread, and the pages that own the tiles */
    uint32_t       worker_count;
} sparse_square;

/* The functions of one level of cpu.h. */
typedef struct sparse_level {
    square_list_gather *gather;
    square_list_split  *split;
    leaf_columns       *leaf;
} sparse_level;

extern const sparse_level sparse_levels[3];

/* Compute a square. Its bins have the side of the square; or the square has the side of a bin, or less.
 * q    zeroed, or cleared: its arrays are used again
 * ctx  read only: memory limit; no progress is reported
 * Returns VXS_OK or VXS_E_MEMORY; released with sparse_square_free either way. */
vxs_result sparse_square_make(sparse_square *q, const sparse_level *level, const leaf_desc *d, const triangle_bins *bins,
                              texel_square at, uint32_t threads, const bake_context *ctx);

/* Release the columns; keep the arrays for the next square. Accepts a zeroed object. */
void sparse_square_clear(sparse_square *q);

/* Accepts a zeroed object. */
void sparse_square_free(sparse_square *q);

/* The square as a column_square; valid as long as q is at its address. */
column_square sparse_square_columns(sparse_square *q);

#endif
