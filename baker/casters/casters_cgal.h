/* Parts of caster classification that use CGAL: which closed shells have something inside.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CASTERS_CGAL_H
#define CASTERS_CGAL_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

/* WebAssembly has no rounding modes: without the first macro, CGAL's intervals would be wrong. Its assertions check them. */
#if defined __cplusplus && defined __EMSCRIPTEN__ && (!defined CGAL_ALWAYS_ROUND_TO_NEAREST || defined NDEBUG)
#error "for WebAssembly, CGAL needs CGAL_ALWAYS_ROUND_TO_NEAREST, and no NDEBUG"
#endif

#ifdef __cplusplus
extern "C" {
#endif

struct box; /* baker/base/box.h */

/* Connected components of a triangle soup; everything is borrowed. */
typedef struct shell_set {
    const double     *positions_ws; /* [3 * vertices] finite */
    const uint32_t   *indices;      /* [3 * triangles] */
    size_t            count;        /* number of components */
    const uint32_t   *first;        /* [count + 1] component i owns members[first[i]] .. members[first[i + 1] - 1] */
    const uint32_t   *members;      /* triangle numbers, grouped by component */
    const struct box *boxes;        /* [count] bounding box of each component */
    size_t            point_count;
    const double     *points; /* [3 * point_count] positions of lights and cameras */
} shell_set;

/* For every component i with wanted[i] nonzero: set occupied[i] to 1 when a point, or another whole component (wanted or not), is
 * inside it or on its surface, else to 0. Other entries do not change.
 * A wanted component must be balanced: each edge is used equally often in both directions. It may be non-manifold and may cross
 * itself: a point is inside where the winding number is not zero. The predicates are exact. A component on which CGAL fails counts
 * as occupied.
 * For an inner component of more than 4096 vertices, 4096 evenly spread vertices are tested: if only others are outside, it counts
 * as inside.
 * Returns VXS_OK or VXS_E_MEMORY; never throws. The result does not depend on the number of threads. */
vxs_result shells_find_occupied(const shell_set *s, const uint8_t *wanted, uint8_t *occupied, uint32_t threads);

/* A component and another one that may be inside. */
typedef struct shell_pair {
    uint32_t outer, inner;
    uint8_t  inside; /* [out] */
} shell_pair;

/* For every pair, test whether the first corner of the inner component is inside the outer one or on its surface. If the surfaces
 * do not touch, this holds for the whole component. The outer ones must be balanced, see above. A component on which CGAL fails
 * contains everything.
 * pairs  [count] sorted by outer
 * Returns VXS_OK or VXS_E_MEMORY; never throws. Deterministic; threads: none. */
vxs_result shells_find_inside(const shell_set *s, shell_pair *pairs, size_t count);

/* Find the triangles of a soup that touch or cross each other, with exact predicates. */

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
