/* Whether the list of a small square settles it without a loss against a look at each texel.
 *
 * A square can be settled if all of its enter depths are at or before all of its exit depths. But the coding chooses a stored depth
 * between the two, and narrow bounds leave it fewer choices. So a small square is evaluated texel by texel, unless its list gives
 * the exact exit depth. The exit of a texel is the first back face up to which there are no more front faces than back faces. It is
 * known without evaluation if layers cover the whole square and do not overlap in depth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_SETTLE_H
#define SQUARE_SETTLE_H

#include "baker/columns/sparse/square_bound.h"

enum { SETTLE_LIST_MAX = 16 }; /* longer lists rarely give a result */

/* Depths of a square that its list gives. */
typedef struct square_parting {
    double enter_most; /* no enter depth is greater */
    double exit_least; /* no exit depth is less */
    int    is_certain; /* 1: some texel has exactly this exit depth, or smaller squares would not give a better one either */
} square_parting;

/* l      as it was split from the larger square, whose bound is `outer`
 * Returns 0 if the list settles nothing. */
int square_settle(const square_list *l, const sparse_triangles *s, texel_square at, const square_bound *outer, int nearest_back,
                  square_parting *out);

#endif
