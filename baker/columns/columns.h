/* The column source: all that the DAG builder knows of a scene (docs/overview.md, "Seams").
 *
 * A column is one texel's pair (e, x): enter depth rounded down and exit depth rounded up to whole voxels. Voxel k of the column
 * must be lit when k < e, must be shadowed when k >= x, and is free between: exactly the contract of an asset, since a voxel's
 * far side k + 1 is at or before a depth d when k < floor(d), and its near side k at or behind d when k >= ceil(d).
 * A texel without a caster has e = x = depth_vx.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COLUMNS_H
#define COLUMNS_H

#include <stdint.h>

/* Of all columns of a square. May be loose (emin, xmin too small; emax, xmax too large), never wrong. */
typedef struct column_bounds {
    uint32_t emin, emax, xmin, xmax; /* voxels, [0, depth_vx] */
} column_bounds;

/* The columns of one tile of 8 x 8 texels; texel (x, y) is element x + 8y. */
typedef struct column_tile {
    uint32_t e[64], x[64]; /* voxels, [0, depth_vx], e <= x */
} column_tile;

/* A square of columns. Threads: bounds and tile may be called from any number of threads at once. */
typedef struct column_source {
    const void *data;
    uint32_t    side_px;  /* texels a side; a power of two, at least 8 */
    uint32_t    depth_vx; /* voxels in depth */

    /* Bounds of the square of 8 << level texels a side at (i, j), counted in such squares; 8 << level <= side_px. */
    column_bounds (*bounds)(const void *data, uint32_t level, uint32_t i, uint32_t j);

    /* The columns of tile (i, j), counted in tiles of 8 x 8 texels. */
    void (*tile)(const void *data, uint32_t i, uint32_t j, column_tile *out);
} column_source;

#endif
