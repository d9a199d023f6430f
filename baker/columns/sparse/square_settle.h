/* Whether a small square can be settled by its list as well as by its texels.
 *
 * A square is parted when all of its texels are entered before any is left. But who builds of it what is stored chooses a depth between the
 * two, and has the less to choose from the less is known: so a small square is looked at texel by texel, unless its list tells where light
 * leaves it. A texel leaves at the first back face up to which there are no more front faces than back faces: of layers that cover
 * the square, and are apart in depth, that is known without looking.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_SETTLE_H
#define SQUARE_SETTLE_H

#include "baker/columns/sparse/square_bound.h"

enum { SETTLE_LIST_MAX = 16 }; /* longer lists are of places where little can be told */

/* What is told of a square. */
typedef struct square_parting {
    double enter_most; /* no texel is entered behind */
    double exit_least; /* none is left before */
    int    is_certain; /* 1: and some texel is left there, or where that is not known of smaller squares either */
} square_parting;

/* l      as split from the larger square, of which `outer` is known
 * Returns 0 where nothing is told. */
int square_settle(const square_list *l, const sparse_triangles *s, texel_square at, const square_bound *outer, int nearest_back,
                  square_parting *out);

#endif
