/* The columns of a tile of 8 x 8 texels from the triangles that may touch it.
 *
 * Enter depth e: nearest solid face s and nearest sheet h, e = min(s, h). A ray that meets a sheet first, or at the same depth, leaves it
 * at once: x = e. Otherwise x is the first back face behind which no solid is open: up to it there are no more front faces than back faces.
 * What begins behind F (square_bound.h) is not in the list, and need not be: a tile is entered before F, and what is left behind F decides
 * nothing. There the next back face known, of the list or left out of it, stands for the exit.
 *
 * Where more is to be free (dont_care.h), it matters what a ray meets behind where light leaves: the nearest of it ends a sheet's thickness, and
 * where there is none, x is the end of the map. The list has all of it, or it is known that no texel's exit is the last surface.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LEAF_H
#define LEAF_H

#include "baker/columns/columns.h"
#include "baker/columns/depth_scale.h"
#include "baker/columns/sparse/square_bound.h"

/* What a worker needs for it. Zero it; arrays are the owner's to free. */
typedef struct leaf_scratch {
    struct leaf_face *faces;
    struct leaf_hit  *hits;
    double           *depths;
    uint8_t          *backs;
    size_t            face_capacity, hit_capacity, depth_capacity, back_capacity;
} leaf_scratch;

typedef struct leaf_desc {
    const sparse_triangles *triangles;
    depth_scale             scale;
    int                     nearest_back; /* 1: light leaves at the nearest back face, whatever is open */
    int                     every_texel;  /* 1: all columns of a tile are wanted, also where one depth parts them */
    dont_care_rules         dont_care;
} leaf_desc;

/* out     [out] the columns, where one depth does not part all that is lit from all that is in shadow
 * bounds  [out] of the columns; where one depth parts them, emin = emax <= xmin = xmax, and out has nothing unless every texel is wanted
 * Returns 0 without memory. */
typedef int leaf_columns(leaf_scratch *s, const leaf_desc *d, const square_list *l, const square_bound *b, texel_square square,
                         column_tile *out, column_bounds *bounds);

/* For the levels of cpu.h; see lanes.h. */
leaf_columns leaf_columns_sse2, leaf_columns_avx2;

#endif
