/* Bounds of a square from its list of triangles, without a look at texels.
 *
 *     depth ->      . . . e e e e e F          F: every enter depth of the square is at or before it
 *                             xmin . . . .     xmin: every exit depth is at or behind it
 *
 * F comes from what covers the square: one triangle, or a patch whose border does not cross the square and that covers its middle,
 * and therefore all of it. If the border of a patch crosses the square, or the patch covers it in several layers, its triangles are
 * sorted by depth. A group that a gap in depth separates from the others is connected by itself, and is treated as a patch.
 * Triangles that begin behind F are removed from the list. The nearest back face of a solid among them is kept as K: where a list
 * has no further back face for a texel, the exit is at K or behind.
 *
 * With more don't-care voxels (dont_care.h) the surfaces behind the exit matter too: triangles that may limit the thickness of a
 * sheet stay. All triangles stay until it is known that a surface lies behind F in every texel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_BOUND_H
#define SQUARE_BOUND_H

#include "baker/columns/sparse/dont_care.h"
#include "baker/columns/sparse/square_list.h"

typedef struct square_bound {
    double enter_most; /* F; initially the depth that means no caster */
    double left_out;   /* K; INFINITY: no back face was removed */
    double exit_least; /* xmin */
    int    behind;     /* 1: a surface is known to lie behind F in every texel */
} square_bound;

/* Tighten the bounds of the larger square around it with the square's own list, and remove triangles that no longer matter from
 * the list. */
void square_bound_tighten(square_bound *b, square_list *l, const sparse_triangles *s, const dont_care_rules *f);

#endif
