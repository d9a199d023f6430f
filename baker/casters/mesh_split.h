/* Weld and split the borders of sheets that meet, so that they share vertices.
 *
 * A border of a sheet may end in the middle of another sheet's edge (a T-junction), and vertices meant to be equal may differ by
 * rounding. The rasterizer of a map snaps each vertex to its grid independently. Then such borders separate or overlap by up to a
 * step of the grid, and a texel centre between them becomes lit although there is no gap. To avoid this, border vertices within a
 * tolerance of each other are merged, and border edges are split at border vertices that lie on them:
 *
 *      a-----------b         a-----------b
 *      | \         |         | \         |
 *      |   \       |         |   \       |
 *      |     \     |   ->    |     \     |
 *      c-----------d         c--e--f-----d       c, d and e, f are of different sheets
 *      ------e--f-----         /|  |\
 *
 * Then a map covers each texel there once. Edges that are not open do not change: where a border ends on the bent edge of a box, or
 * boxes stand side by side, a map may still separate them by a step of its grid.
 *
 * The tolerance is MESH_SPLIT_STEPS float steps (ulps) at the vertex's distance from the origin of its node, because files store
 * coordinates as floats relative to this origin; later transforms are in double. A position that is stored twice differs by at most
 * two steps, and by about three more for each if a tool has transformed it in floats. Wider gaps are real gaps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_SPLIT_H
#define MESH_SPLIT_H

#include "baker/casters/mesh_edges.h"

enum { MESH_SPLIT_STEPS = 8 };

/* A piece of a triangle: barycentric coordinates of its corners in the triangle. */
typedef struct mesh_piece {
    uint32_t triangle; /* triangle number after splitting */
    double   weights[3][3];
} mesh_piece;

typedef struct mesh_split {
    size_t open_count;   /* open edges; an edge of several triangles counts once */
    size_t split_count;  /* edges that were split */
    size_t left_count;   /* edges not searched, because the limit of work was reached */
    size_t added_count;  /* number of triangles added */
    size_t joined_count; /* vertices merged into another vertex */

    uint32_t   *parents; /* [triangle_count after] original triangle of each triangle or piece, ascending; NULL: unchanged */
    size_t      piece_count;
    mesh_piece *pieces; /* [piece_count] in the order of triangles */
} mesh_split;

/* Weld and split the borders of a welded mesh. Merged vertices stay in w->positions_ws, but no triangle uses them. No triangle is
 * removed, but pieces narrower than the tolerance are. Cost: proportional to the borders, plus one pass over all triangles if
 * anything changes.
 *
 * w       in and out: indices, from, triangle_count
 * border  [border_count] open half-edges, grouped by edge
 * s       the scene of w, for its origins
 * out     [out] released with mesh_split_free
 * Returns VXS_OK, VXS_E_MEMORY. Deterministic; threads: none. */
vxs_result mesh_split_borders(mesh_split *out, mesh_weld *w, const uint32_t *border, size_t border_count, const scene *s,
                              run_context *m);

void mesh_split_free(mesh_split *split);

#endif
