/* A bounding volume tree of points: finds the points near a segment.
 *
 * Each node splits its points in half across the longest side of its box, down to small leaves. So the depth depends on the number
 * of points alone, not on their distribution. The cost of a search depends on the points near the segment, not on its length.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef POINT_TREE_H
#define POINT_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/box.h"

typedef struct tree_point {
    double   at[3];
    double   reach; /* [0, inf) search radius of the point */
    uint32_t name;  /* identifier for the caller */
} tree_point;

typedef struct point_tree {
    size_t      count;
    tree_point *points; /* [count] in the order of the tree; borrowed */
    box        *boxes;  /* boxes of nodes, enlarged by the reach of their points; node n has the children 2n + 1 and 2n + 2 */
    uint64_t    visits; /* remaining budget of visits of nodes and points, over all searches */
} point_tree;

/* Build a tree.
 * points  [count] finite; borrowed, and reordered
 * Returns 0 without memory; released with point_tree_free either way. */
int point_tree_init(point_tree *t, tree_point *points, size_t count, uint64_t visits);

void point_tree_free(point_tree *t);

/* Called with a point that may be near. Returns 1 to end the search. */
typedef int point_tree_visitor(void *user, size_t point);

/* Visit all points within `radius` of the segment along each axis, and possibly others, in the order of the tree.
 * Returns 0 when t->visits is used up: then points may be missing. */
int point_tree_search(point_tree *t, const double a[3], const double b[3], const double radius[3], point_tree_visitor *visit,
                      void *user);

#endif
