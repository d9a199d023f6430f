/* Points in a tree of boxes: which of them lie near a segment.
 *
 * A node halves its points across the longest side of their box, down to leaves of a few, so that the tree is as deep over points that are
 * spread evenly as over a city in an ocean. What a search costs follows what lies near the segment, not its length.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef POINT_TREE_H
#define POINT_TREE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/box.h"

typedef struct tree_point {
    double   at[3];
    double   reach; /* [0, inf) it is found from so far away */
    uint32_t name;  /* the caller's */
} tree_point;

typedef struct point_tree {
    size_t      count;
    tree_point *points; /* [count] in the tree's order; borrowed */
    box        *boxes;  /* of nodes, with the reach of their points: node n has children 2n + 1 and 2n + 2 */
    uint64_t    visits; /* of nodes and points that searches may still make: what they cost all together is bounded */
} point_tree;

/* Sort points into a tree.   points  [count] finite; borrowed, and reordered
 * Returns 0 without memory; released with point_tree_free either way. */
int point_tree_init(point_tree *t, tree_point *points, size_t count, uint64_t visits);

void point_tree_free(point_tree *t);

/* Shown a point that may be near. Returns 1 to end the search. */
typedef int point_tree_visitor(void *user, size_t point);

/* Show all points within `radius` of the segment along each axis, and maybe others; those of the tree's order that come first, first.
 * Returns 0 when t->visits are used up: then some may not have been shown. */
int point_tree_search(point_tree *t, const double a[3], const double b[3], const double radius[3], point_tree_visitor *visit,
                      void *user);

#endif
