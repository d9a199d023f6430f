/* The column seam: all that the DAG builder knows of a scene (docs/overview.md, "Seams").
 *
 * A column is one texel's pair (e, x): enter depth rounded down and exit depth rounded up to whole voxels. Voxel k of the column
 * must be lit when k < e, must be shadowed when k >= x, and is free between: exactly the contract of an asset, since a voxel's
 * far side k + 1 is at or before a depth d when k < floor(d), and its near side k at or behind d when k >= ceil(d).
 * A texel without a caster has e = x = depth_vx.
 * A source may say less than is free, e later and x earlier, as long as e <= x: whoever keeps to that keeps to what is there.
 *
 *     column_source     a light: its maps can be opened, several at once
 *       column_map      an open map: what is known of any square before anything is computed; squares can be fetched
 *         column_square   a fetched square: bounds of its parts, columns of its tiles
 *
 * Each call may fail with a result of vxs_result.h. Squares are named by level, i, j: the square of 8 << level texels a side at column i
 * and row j of such squares, counted from the corner of the map, or of the fetched square.
 * Sources: opengl/ renders, sparse/ looks at triangles, stored/ holds depth maps in memory, tests/columns/ has formulas.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COLUMNS_H
#define COLUMNS_H

#include <stdint.h>

#include "baker/base/context.h"
#include "baker/base/integer.h"

/* Of all columns of a square. May be loose (emin, xmin too small; emax, xmax too large), never wrong. */
typedef struct column_bounds {
    uint32_t emin, emax, xmin, xmax; /* [0, depth_vx] voxels */
} column_bounds;

/* The columns of one tile of 8 x 8 texels; texel (x, y) is element x + 8y. */
typedef struct column_tile {
    uint32_t e[64], x[64]; /* [0, depth_vx] voxels, e <= x */
} column_tile;

/* A square of columns, ready to be asked. Threads: bounds and tile may be called from any number of threads at once. */
typedef struct column_square {
    void    *data;
    uint32_t side_px;    /* [8, side of the map] texels, a power of two */
    uint32_t depth_vx;   /* [8, 2^18] voxels, a power of two */
    uint32_t u_px, v_px; /* the texel of the map where it starts */

    /* Bounds of a square of it; 8 << level <= side_px. */
    vxs_result (*bounds)(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out);

    /* The columns of tile (i, j), counted in tiles of 8 x 8 texels. */
    vxs_result (*tile)(void *data, uint32_t i, uint32_t j, column_tile *out);
} column_square;

/* Stands for all that decides the columns of a square: where keys are equal, columns are. */
typedef struct column_key {
    uint64_t low, high;
} column_key;

typedef struct square_keeper square_keeper; /* square_keeper.h */

/* An open map. Threads: one at a time, unless a source says otherwise. */
typedef struct column_map {
    void    *data;
    uint32_t side_px, depth_vx; /* [8, 2^18], powers of two */
    uint32_t fetch_px;          /* [8, side_px] a power of two: the widest square that can be fetched */
    uint32_t
        parallel_px; /* [8, fetch_px] a power of two: squares of so much, or less, can be fetched by many threads at once; 0: none */

    /* What is known of a square of any level, at next to no cost: bounds of what may be there, [0, depth_vx] where nothing is known. */
    vxs_result (*bounds)(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out);

    /* Compute the columns of a square of at most fetch_px a side; released before the next one is fetched.
     * ctx  NULL: the calling thread does it alone, of a square of at most parallel_px, while others may fetch and release others
     * out  [out] zeroed on failure */
    vxs_result (*fetch)(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx);
    void (*release)(void *data, column_square *square);

    void (*close)(void *data);

    /* The key of a square that may be fetched, which does not depend on what is elsewhere in the map. NULL: the source knows of none. */
    vxs_result (*key)(void *data, uint32_t level, uint32_t i, uint32_t j, column_key *out);

    const square_keeper *keeper; /* of what becomes of its squares, set by whoever opened it; NULL: nobody */
} column_map;

/* The maps of a light. */
typedef struct column_source {
    void    *data;
    uint32_t map_count; /* 1 or 6 */

    /* Open map `map`, [0, map_count).   out  [out] zeroed on failure; ends with out->close(out->data). */
    vxs_result (*open)(void *data, uint32_t map, column_map *out, bake_context *ctx);
} column_source;

/* The level of a square of side_px texels. */
static inline uint32_t square_level(uint32_t side_px)
{
    return log2_u32(side_px) - 3;
}

/* Nothing is known. */
static inline column_bounds bounds_unknown(uint32_t depth_vx)
{
    return (column_bounds){0, depth_vx, 0, depth_vx};
}

/* Whether all columns that have these bounds are equal. */
static inline int bounds_alike(const column_bounds *b)
{
    return b->emin == b->emax && b->xmin == b->xmax;
}

/* Of a tile's own columns. */
static inline column_bounds tile_bounds(const column_tile *t)
{
    column_bounds b = {UINT32_MAX, 0, UINT32_MAX, 0};
    for (int n = 0; n < 64; n++) {
        b.emin = min_u32(b.emin, t->e[n]);
        b.emax = max_u32(b.emax, t->e[n]);
        b.xmin = min_u32(b.xmin, t->x[n]);
        b.xmax = max_u32(b.xmax, t->x[n]);
    }
    return b;
}

/* No caster. */
static inline column_bounds bounds_empty(uint32_t depth_vx)
{
    return (column_bounds){depth_vx, depth_vx, depth_vx, depth_vx};
}

#endif
