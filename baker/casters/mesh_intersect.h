/* Find the triangles of a soup that touch or cross each other, with exact predicates.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_INTERSECT_H
#define MESH_INTERSECT_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

struct box; /* baker/base/box.h */

/* Welded triangles: corners at equal positions have equal numbers. Everything is borrowed. */
typedef struct mesh_soup {
    const double   *positions_ws; /* [3 * vertices] finite */
    const uint32_t *indices;      /* [3 * triangle_count] */
    size_t          triangle_count;
} mesh_soup;

typedef struct mesh_search {
    int (*wanted)(void *user, uint32_t a, uint32_t b); /* 0: skip this pair; called by several threads at once */
    int (*found)(void *user, uint32_t a, uint32_t b);  /* the pair meets; each pair once, one call at a time; 1: stop */
    void    *user;
    uint32_t threads;                 /* 0 and 1: the calling thread only; then the order of the pairs is deterministic */
    uint64_t overlaps_max, tests_max; /* limits on pairs with overlapping boxes, and on pairs tested exactly */
    uint64_t overlaps, tests;         /* [out] numbers of pairs until the search ended */
    int      gave_up;                 /* [out] 1: a limit was reached; pairs are missing */
} mesh_search;

/* Find pairs of triangles with a common point that is not just a common corner or edge. Two triangles with a common edge are a pair
 * if they overlap; two with equal corners always are. Triangles without area are in no pair: the edges of other triangles cover
 * their points.
 * Boxes are compared first (Zomorodian and Edelsbrunner 2000), in slabs of space, then CGAL's exact predicates are used.
 * Returns VXS_OK or VXS_E_MEMORY; never throws. The set of pairs does not depend on the number of threads, unless a limit is
 * reached. */
vxs_result mesh_find_intersections(const mesh_soup *s, mesh_search *search);

/* Find pairs of boxes with a common point.
 * boxes  [count]
 * found  called once for each pair; 1 ends the search
 * Returns VXS_OK or VXS_E_MEMORY; never throws. Deterministic; threads: none. */
vxs_result mesh_find_overlaps(const struct box *boxes, size_t count, int (*found)(void *user, uint32_t a, uint32_t b), void *user);

/* 1 when the corners of a triangle are exactly collinear. */
int mesh_is_flat(const mesh_soup *s, size_t triangle);

#ifdef __cplusplus
}
#endif
#endif
