/* What a list of triangles tells of a square without looking at a texel.
 *
 *     depth ->      . . . e e e e e F          F: no texel of the square is entered behind it
 *                             xmin . . . .     xmin: none is left before it
 *
 * F comes from what covers the square: a triangle; or a patch no end of which is in the square, and which covers its middle, and so all of
 * it. Of a patch that does end there, or covers the square in several layers, triangles are taken by depth: those that a gap
 * parts from the others hang together alone, and are a patch of their own here.
 * What begins behind F is left out from here on. The nearest back face of a solid among it is kept as K: where a list has no back face
 * for a texel any more, light leaves at K or behind.
 *
 * Where more is to be free (dont_care.h), what lies behind where light leaves matters, too: what may end a sheet's thickness stays, and, until it
 * is known that something lies behind F in all texels, all does.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_BOUND_H
#define SQUARE_BOUND_H

#include "baker/columns/sparse/dont_care.h"
#include "baker/columns/sparse/square_list.h"

typedef struct square_bound {
    double enter_most; /* F; at first the depth that means no caster */
    double left_out;   /* K; INFINITY: no back face was left out */
    double exit_least; /* xmin */
    int    behind;     /* 1: it is known that a surface lies behind F in all texels */
} square_bound;

/* Tighten what is known of a square from the larger one around it by its own list, and take out of the list what no longer matters. */
void square_bound_tighten(square_bound *b, square_list *l, const sparse_triangles *s, const dont_care_rules *f);

#endif
