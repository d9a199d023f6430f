/* The columns of a tile of 8 x 8 texels from the triangles that may touch it.
 *
 * Enter depth e: nearest solid face s and nearest sheet h, e = min(s, h). A ray that meets a sheet first, or at the same depth, leaves it
 * at once: x = e. Otherwise x is the first back face behind which no solid is open: up to it there are no more front faces than back faces.
 * What begins behind F (square_bound.h) is not in the list, and need not be: a tile is entered before F, and what is left behind F decides
 * nothing. There the next back face known, of the list or left out of it, stands for the exit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LEAF_H
#define LEAF_H

#include "baker/columns/columns.h"
#include "baker/columns/depth_scale.h"
#include "baker/columns/sparse/square_bound.h"

enum { EXIT_LAYERS_MAX = 255 }; /* back faces of a texel that are looked at; a ray through more leaves at the first of them */

/* What a worker needs for it. Zero it. */
typedef struct leaf_scratch {
    f64x2   *depths; /* of 64 texels, for each triangle of solids */
    uint8_t *is_exit;
    size_t   depth_capacity, exit_capacity;
} leaf_scratch;

typedef struct leaf_desc {
    const sparse_triangles *triangles;
    depth_scale             scale;
    int                     nearest_back; /* 1: light leaves at the nearest back face, whatever is open */
} leaf_desc;

/* Returns 0 without memory. */
int leaf_columns(leaf_scratch *s, const leaf_desc *d, const square_list *l, const square_bound *b, texel_square square,
                 column_tile *out);

void leaf_scratch_free(leaf_scratch *s);

#endif
