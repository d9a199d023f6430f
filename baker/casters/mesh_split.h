/* Borders that meet, made of the same vertices.
 *
 * A sheet's border may end in the middle of another one's edge (a T-junction), and vertices that stand for one place may differ by
 * rounding. A map takes vertices to its grid one by one, so that such borders part there or overlap, by up to a step of the grid, and a
 * texel whose centre lies between them sees light that no gap lets through. Here the vertices of borders that lie within a tolerance of
 * each other become one, and edges of borders are split where vertices of borders lie on them:
 *
 *      a-----------b         a-----------b
 *      | \         |         | \         |
 *      |   \       |         |   \       |
 *      |     \     |   ->    |     \     |
 *      c-----------d         c--e--f-----d       c, d and e, f are of different sheets
 *      ------e--f-----         /|  |\
 *
 * so that a map covers each texel there once. An edge that is not open stays as it is: where a border ends on the bent edge of a box, or boxes
 * stand side by side, a map may still part them by a step of its grid.
 *
 * The tolerance is MESH_SPLIT_STEPS steps of a float at the vertex's distance from the origin of its node: coordinates are floats counted
 * from there, whatever the transform that follows in double. A place that is stored twice differs by two steps at most; where a tool has
 * also turned and moved it in floats, by some three more each. Nothing larger is taken for rounding: a wider gap is one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_SPLIT_H
#define MESH_SPLIT_H

#include "baker/casters/mesh_weld.h"

enum { MESH_SPLIT_STEPS = 8 };

/* A piece of a triangle: where its corners are between those of the triangle, which sum up to 1. */
typedef struct mesh_piece {
    uint32_t triangle; /* its number after splitting */
    double   weights[3][3];
} mesh_piece;

typedef struct mesh_split {
    size_t open_count;   /* edges that are open; one that several triangles share counts once */
    size_t split_count;  /* edges that were split at vertices that lie on them */
    size_t left_count;   /* edges not looked at, as there would have been no end of it */
    size_t added_count;  /* triangles more than before */
    size_t joined_count; /* vertices that took another one's place */

    uint32_t   *parents; /* [triangle_count after] which triangle it is, or is a piece of, ascending; NULL: as they were */
    size_t      piece_count;
    mesh_piece *pieces; /* [piece_count] in the order of their triangles */
} mesh_split;

/* Weld and split the borders of a welded mesh. Vertices that have gone stay in w->positions_ws, where no triangle names them. No triangle goes;
 * a piece does that is narrower than the tolerance. What it costs follows the border, but for one pass over all triangles where something is
 * done.
 *
 * w       in and out: indices, from, triangle_count
 * border  [border_count] half-edges that are open, those of one edge together
 * s       that w is made of: its origins
 * out     [out] released with mesh_split_free
 * Returns VXS_OK, VXS_E_MEMORY.  Deterministic; threads: none. */
vxs_result mesh_split_borders(mesh_split *out, mesh_weld *w, const uint32_t *border, size_t border_count, const scene *s,
                              message *m);

void mesh_split_free(mesh_split *split);

#endif
