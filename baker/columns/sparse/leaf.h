/* Columns of a tile of 8 x 8 texels, computed from the triangles that may touch it.
 *
 * Enter depth e: with the nearest solid face s and the nearest sheet h, e = min(s, h). If a ray meets a sheet first, or at the same
 * depth, x = e. Otherwise x is the depth of the first back face up to which there are no more front faces than back faces: no solid
 * is open there. The list may lack triangles that begin behind F (square_bound.h): the ray enters before F in every texel, and exit
 * depths behind F make no difference. If the exit lies behind F, the next known back face stands for it, from the list or among
 * the triangles that were left out.
 *
 * With more don't-care voxels (square_bound.h) the surfaces behind the exit matter too: the nearest one limits the thickness of a
 * sheet, and if there is none, x is the end of the map. Then the list has all of these surfaces, or it is known that no texel
 * exits at the last surface.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LEAF_H
#define LEAF_H

#include "baker/columns/columns.h"
#include "baker/columns/sparse/square_bound.h"

/* Scratch memory of one worker. Zero it; the owner frees `room`. */
typedef struct leaf_scratch {
    void  *room;
    size_t capacity; /* triangles of a list */
} leaf_scratch;

typedef struct leaf_desc {
    const sparse_triangles *triangles;
    depth_scale             scale;
    int                     nearest_back; /* 1: the exit is the nearest back face, even if a solid is open there */
    int                     every_texel;  /* 1: compute all columns of a tile, also if one depth separates lit from shadowed */
    dont_care_rules         dont_care;
} leaf_desc;

/* out     [out] the columns, unless several depths separate lit from shadowed in all of them
 * bounds  [out] of the columns; if several depths do, emin = emax < xmin = xmax, and out is set only with every_texel
 * Returns 0 without memory. */
typedef int leaf_columns(leaf_scratch *s, const leaf_desc *d, const square_list *l, const square_bound *b, texel_square square,
                         column_tile *out, column_bounds *bounds);

/* One for each level of cpu.h; see lanes.h. */
leaf_columns leaf_columns_sse2, leaf_columns_avx2, leaf_columns_avx512;

#endif
