/* The maps of a light, computed straight from its triangles: a column source without a renderer.
 *
 * Squares of texels are decided as a whole where their lists of triangles allow it; the rest is evaluated in tiles of 8 x 8 texels.
 * The bounds of a decided square may have e larger and x smaller than the true ones, within the limits of all of its columns. A
 * file that keeps to these bounds keeps the contract.
 *
 *     sparse_triangles.c   triangles on the grid of subtexels, edges, depth
 *     sparse_triangles.c            patches of adjacent triangles
 *     sparse_triangles.c      cells of the map, where the descent begins
 *     sparse_square.c      the descent: squares, quarters, tiles
 *       square_list.c        a triangle against a square
 *       square_bound.c       bounds of a square from its list
 *       square_bound.c      whether these are as good as a look at each texel
 *       leaf.c               the texels of a tile
 *     sparse_columns.c         hash of the input of a square's columns
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_COLUMNS_H
#define SPARSE_COLUMNS_H

#include "baker/casters/casters.h"
#include "baker/columns/columns.h"
#include "baker/light/projection.h"
#include "formats/vxs_file.h"

enum { SPARSE_PARALLEL_PX = 1024 }; /* squares of this side or less can be fetched by many threads at once */

typedef struct sparse_columns {
    const casters   *casters;          /* that the light may reach; borrowed, as is the light */
    const vxs_light *light;            /* fitted */
    int              free_behind;      /* 1: voxels behind the last surface are don't-care voxels (square_bound.h) */
    double           thickness_metres; /* of sheets that face the light, metres along the map's axis; 0: none */
    int              nearest_back;     /* 1: light exits a solid at the nearest back face, also where solids overlap */
    uint32_t         fetch_px;         /* a power of two: greatest side of the squares that are computed at once */
} sparse_columns;

/* Enter depths of a map at the resolution of a coarser one, for pictures.
 * side_px   [8, side of the map] texels, a power of two
 * depth_vx  a power of two
 * enter     [out] [side_px^2] rows of texels, [0, depth_vx]; depth_vx: no caster
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result sparse_columns_enter(const sparse_columns *o, uint32_t map, uint32_t side_px, uint32_t depth_vx, uint32_t *enter,
                                bake_context *ctx);

/* Open a map of casters that are projected already. The projection may hold only some triangles; then only squares that no other
 * triangle may touch can be fetched.
 * p    only its casters are kept
 * out  [out] zeroed on failure; ends with out->close(out->data)
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result sparse_columns_open(const sparse_columns *o, const projection *p, column_map *out, bake_context *ctx);

/* The source; borrows o. Several maps may be open at once, on any threads. */
column_source sparse_columns_source(sparse_columns *o);

#endif
