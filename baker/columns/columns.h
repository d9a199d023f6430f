/* The column seam: all that the codings know of a scene (docs/overview.md, "Seams").
 *
 * A column is the pair (e, x) of one texel: enter depth rounded down and exit depth rounded up to whole voxels. Voxel k of the
 * column must be lit if k < e, must be shadowed if k >= x, and is a don't-care voxel otherwise. This is exactly the contract of an
 * asset: the far side k + 1 of a voxel is at or before a depth d if k < floor(d), and its near side k is at or behind d if k >=
 * ceil(d). A texel without a caster has e = x = depth_vx.
 * A source may give fewer don't-care voxels than there are, with a later e and an earlier x, as long as e <= x. A coding that keeps
 * to these columns then keeps the contract.
 *
 *     column_source     a light: its maps can be opened, several at once
 *       column_map      an open map: bounds of any square at low cost; squares can be fetched
 *         column_square   a fetched square: bounds of its parts, columns of its tiles
 *
 * Each call may fail with a result of vxs_result.h. A square is named by level, i, j: it has 8 << level texels a side, and is in
 * column i and row j of such squares, counted from the corner of the map or of the fetched square.
 * Sources: opengl/ renders, sparse/ computes from triangles, tests/columns/ has stored maps and formulas.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COLUMNS_H
#define COLUMNS_H

#include <math.h>
#include <stdint.h>

#include "baker/base/context.h"
#include "baker/base/integer.h"
#include "baker/base/portable_quick.h"

/* Bounds of all columns of a square. They may be loose (emin, xmin too small; emax, xmax too large), but are never wrong. */
typedef struct column_bounds {
    uint32_t emin, emax, xmin, xmax; /* [0, depth_vx] voxels */
} column_bounds;

/* The columns of one tile of 8 x 8 texels; texel (x, y) is element x + 8y. */
typedef struct column_tile {
    uint32_t e[64], x[64]; /* [0, depth_vx] voxels, e <= x */
} column_tile;

/* A fetched square of columns. Threads: bounds and tile may be called from any number of threads at once. */
typedef struct column_square {
    void    *data;
    uint32_t side_px;    /* [8, side of the map] texels, a power of two */
    uint32_t depth_vx;   /* [8, 2^18] voxels, a power of two */
    uint32_t u_px, v_px; /* position of its corner in the map */

    /* Bounds of a part of it; 8 << level <= side_px. */
    vxs_result (*bounds)(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out);

    /* The columns of tile (i, j), counted in tiles of 8 x 8 texels. */
    vxs_result (*tile)(void *data, uint32_t i, uint32_t j, column_tile *out);
} column_square;

/* Hash of all that decides the columns of a square: equal keys mean equal columns. */
typedef struct column_key {
    uint64_t low, high;
} column_key;

typedef struct square_cache square_cache; /* square_record.h */

/* An open map. Threads: one call at a time, unless the source allows more. */
typedef struct column_map {
    void    *data;
    uint32_t side_px, depth_vx; /* [8, 2^18], powers of two */
    uint32_t fetch_px;          /* [8, side_px] a power of two: side of the widest square that can be fetched */
    uint32_t parallel_px;       /* [8, fetch_px] a power of two: greatest side for fetches by many threads at once; 0: none */

    /* Bounds of a square of any level before it is fetched, at low cost; [0, depth_vx] where nothing is known. */
    vxs_result (*bounds)(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out);

    /* Compute the columns of a square of at most fetch_px a side. Release it before the next fetch.
     * ctx  NULL: the calling thread works alone, on a square of at most parallel_px, while other threads may fetch and release
     *      other squares
     * out  [out] zeroed on failure */
    vxs_result (*fetch)(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx);
    void (*release)(void *data, column_square *square);

    void (*close)(void *data);

    /* Key of a square that can be fetched; it does not depend on other parts of the map. NULL: the source has no keys. */
    vxs_result (*key)(void *data, uint32_t level, uint32_t i, uint32_t j, column_key *out);

    const square_cache *cache; /* square cache, set by the caller after open; NULL: none */
} column_map;

/* The maps of a light. */
typedef struct column_source {
    void    *data;
    uint32_t map_count; /* 1 or 6 */

    /* Open map `map`, [0, map_count).   out  [out] zeroed on failure; ends with out->close(out->data). */
    vxs_result (*open)(void *data, uint32_t map, column_map *out, bake_context *ctx);
} column_source;

static inline uint32_t square_level(uint32_t side_px)
{
    return log2_u32(side_px) - 3;
}

/* Bounds when nothing is known. */
static inline column_bounds bounds_unknown(uint32_t depth_vx)
{
    return (column_bounds){0, depth_vx, 0, depth_vx};
}

/* Whether all columns with these bounds are equal. */
static inline int bounds_alike(const column_bounds *b)
{
    return b->emin == b->emax && b->xmin == b->xmax;
}

/* Exact bounds of a tile. */
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

/* Bounds of a square without a caster. */
static inline column_bounds bounds_empty(uint32_t depth_vx)
{
    return (column_bounds){depth_vx, depth_vx, depth_vx, depth_vx};
}

static inline column_bounds bounds_of_both(column_bounds a, column_bounds b)
{
    return (column_bounds){min_u32(a.emin, b.emin), max_u32(a.emax, b.emax), min_u32(a.xmin, b.xmin), max_u32(a.xmax, b.xmax)};
}

/* Bounds of a square from its quarters: two beside each other, and the next two. */
static inline column_bounds bounds_of_four(const column_bounds near[2], const column_bounds next[2])
{
    return bounds_of_both(bounds_of_both(near[0], near[1]), bounds_of_both(next[0], next[1]));
}

/* Conversion from the depths of a map to voxels. Depths grow away from the light. Directional light: shares of the whole depth, [0,
 * 1]; 1 is no caster. Perspective map: -near / z, [-1, 0]; 0 is no caster, and distance z is log(z / near) / voxel_log voxels
 * deep ([CPVS16] 5). */

typedef struct depth_scale {
    uint32_t depth_vx;  /* a power of two, so that scaling is exact */
    double   voxel_log; /* 0: depths are shares */
} depth_scale;

/* Depth that means no caster. The least depth is 1 less than that. */
static inline double depth_none(depth_scale s)
{
    return s.voxel_log == 0 ? 1 : 0;
}

/* Clamp a depth to the range between the near plane and the far plane. */
static inline double depth_clamped(depth_scale s, double depth)
{
    const double most = depth_none(s), least = most - 1; /* fmin() and fmax() would be calls */
    depth = depth < most ? depth : most;
    return depth > least ? depth : least;
}

PORTABLE_LOG(depth_log, double, uint64_t)

/* A depth in voxels, [0, depth_vx], not rounded: the depth in the contract of an asset (docs/overview.md). */
static inline double depth_in_voxels(depth_scale s, double depth)
{
    if (s.voxel_log == 0) return depth * s.depth_vx;
    /* depth 0 gives at least 708 / voxel_log, which is more than depth_vx */
    double voxels = -depth_log(0 - depth) / s.voxel_log;
    return voxels > 0 ? voxels < s.depth_vx ? voxels : s.depth_vx : 0;
}

static inline uint32_t depth_down(depth_scale s, double depth)
{
    return (uint32_t)depth_in_voxels(s, depth);
}

static inline uint32_t depth_up(depth_scale s, double depth)
{
    double   voxels = depth_in_voxels(s, depth);
    uint32_t down   = (uint32_t)voxels;
    return down + (down < voxels);
}

/* Fill the coarser levels of a pyramid of bounds from level 0: the bounds of a square are the union of those of its quarters.
 * pyramid  [l]: rows of (tiles >> l)^2 squares of 8 << l texels, down to one square; level 0 is given
 * tiles    along a side, a power of two
 * threads  that share the work; the result does not depend on it */
void bounds_pyramid_reduce(column_bounds *const *pyramid, uint32_t tiles, uint32_t threads);

#endif
