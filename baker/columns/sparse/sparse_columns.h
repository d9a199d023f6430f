/* The maps of a light straight from its triangles: a column source that renders nothing.
 *
 * Squares of texels are decided as wholes wherever lists of triangles tell enough of them; the rest is looked at in tiles of 8 x 8 texels.
 * Of what a square tells, e may be larger and x smaller than they are, where all columns have room for that: a file keeps the contract
 * by it, and chooses within it.
 *
 *     sparse_triangles.c   triangles on the grid of subtexels, edges, depth
 *     patches.c            those that hang together
 *     triangle_bins.c      cells of the map, from which the descent begins
 *     sparse_square.c      the descent: squares, quarters, tiles
 *       square_list.c        what a triangle is to a square
 *       square_bound.c       what a list tells of a square
 *       square_settle.c      whether that is as much as its texels would tell
 *       leaf.c               the texels of a tile
 *     sparse_key.c         what a square's columns follow from, as a hash
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_COLUMNS_H
#define SPARSE_COLUMNS_H

#include "baker/casters/casters.h"
#include "baker/columns/columns.h"
#include "baker/light/projection.h"
#include "formats/vxs_file.h"

enum { SPARSE_PARALLEL_PX = 1024 }; /* squares of so much, or less, may be fetched by many threads at once */

typedef struct sparse_columns {
    const casters   *casters;      /* that the light may reach; borrowed, as is the light */
    const vxs_light *light;        /* fitted */
    int              free_behind;  /* 1: nobody asks behind the last surface (dont_care.h) */
    double           thickness_m;  /* of sheets that face the light, metres along the axis of the map; 0: none */
    int              nearest_back; /* 1: light leaves solids at the nearest back face, also where they meet others */
    uint32_t         fetch_px;     /* a power of two: side of the squares that are computed at once, at most */
} sparse_columns;

/* Enter depths of a map as a coarser one has them: for pictures.
 * side_px   [8, side of the map] texels, a power of two
 * depth_vx  a power of two
 * enter     [out] [side_px^2] rows of texels, [0, depth_vx]; depth_vx: no caster
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result sparse_columns_enter(const sparse_columns *o, uint32_t map, uint32_t side_px, uint32_t depth_vx, uint32_t *enter,
                                bake_context *ctx);

/* Open a map of casters that are projected already, or of some of their triangles: then only squares that no other triangle may touch can be
 * fetched.
 * p    nothing is kept of it but its casters
 * out  [out] zeroed on failure; ends with out->close(out->data)
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result sparse_columns_open(const sparse_columns *o, const projection *p, column_map *out, bake_context *ctx);

/* The source; borrowed. Maps may be open at once, on any threads. */
column_source sparse_columns_source(sparse_columns *o);

#endif
