/* Which triangles of a soup touch or cross each other, exactly.
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

/* Welded triangles: corners at one position have one number. Everything is borrowed. */
typedef struct mesh_soup {
    const double   *positions_ws; /* [3 * vertices] finite */
    const uint32_t *indices;      /* [3 * triangle_count] */
    size_t          triangle_count;
} mesh_soup;

typedef struct mesh_search {
    int (*wanted)(void *user, uint32_t a, uint32_t b); /* 0: this pair does not matter; by several threads at once */
    int (*found)(void *user, uint32_t a, uint32_t b);  /* they touch or cross; 1 ends the search; each pair once, one at a time */
    void    *user;
    uint32_t threads;                 /* 0 and 1: the caller alone, and pairs come in the same order each time */
    uint64_t overlaps_max, tests_max; /* pairs whose boxes overlap; pairs that are tested exactly */
    uint64_t overlaps, tests;         /* [out] how many there were until the search ended */
    int      gave_up;                 /* [out] 1: a limit was met, pairs are left out */
} mesh_search;

/* Find pairs of triangles that have a point in common which is not just their common corner or edge. Two with a common edge are a
 * pair where they lie on each other, two with the same corners always are. Triangles without area are in no pair: what they cover
 * belongs to the edges of others.
 * Boxes first (Zomorodian and Edelsbrunner 2000), slab by slab of space, then CGAL's exact predicates.
 * Returns VXS_OK or VXS_E_MEMORY; never throws.  The pairs are the same at any thread count, when no limit is met. */
vxs_result mesh_find_intersections(const mesh_soup *s, mesh_search *search);

/* Find pairs of boxes that have a point in common.
 * boxes  [count]
 * found  called with each pair once; 1 ends the search
 * Returns VXS_OK or VXS_E_MEMORY; never throws.  Deterministic; threads: none. */
vxs_result mesh_find_overlaps(const struct box *boxes, size_t count, int (*found)(void *user, uint32_t a, uint32_t b), void *user);

/* 1 when the corners of a triangle lie on one line, exactly. */
int mesh_is_flat(const mesh_soup *s, size_t triangle);

#ifdef __cplusplus
}
#endif
#endif
