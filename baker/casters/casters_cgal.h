/* What the casters need of CGAL: which closed shells have something inside.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CASTERS_CGAL_H
#define CASTERS_CGAL_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

struct box; /* baker/base/box.h */

/* Connected components of a triangle soup; everything is borrowed. */
typedef struct shell_set {
    const double     *positions_ws; /* [3 * vertices] finite */
    const uint32_t   *indices;      /* [3 * triangles] */
    size_t            count;        /* components */
    const uint32_t   *first;        /* [count + 1] component i owns members[first[i]] .. members[first[i + 1] - 1] */
    const uint32_t   *members;      /* triangle numbers, grouped by component */
    const struct box *boxes;        /* [count] of each component */
    size_t            point_count;
    const double     *points; /* [3 * point_count] lights and cameras */
} shell_set;

/* For every component i with wanted[i] nonzero, set occupied[i] to 1 when one of the points, or another whole component
 * (wanted or not), is inside it or on its surface, else to 0; other entries are left alone.
 * A wanted component must be balanced: each edge used equally often in both directions. It may be non-manifold and may cross
 * itself: a point is inside where the winding number is not zero. The predicates are exact. A component on which CGAL fails
 * counts as occupied.
 * A component of more than 4096 vertices is judged by 4096 of them, evenly spread: one that reaches out only between
 * these counts as inside.
 * Returns VXS_OK or VXS_E_MEMORY; never throws.  The same at any thread count. */
vxs_result shells_find_occupied(const shell_set *s, const uint8_t *wanted, uint8_t *occupied, uint32_t threads);

/* A component and another one that may be inside it. */
typedef struct shell_pair {
    uint32_t outer, inner;
    uint8_t  inside; /* [out] */
} shell_pair;

/* For every pair, is the first corner of the inner one in the outer one, or on its surface? Where surfaces do not touch that decides
 * for all of it. The outer ones must be balanced, see above. A component on which CGAL fails has everything inside.
 * pairs  [count] sorted by outer
 * Returns VXS_OK or VXS_E_MEMORY; never throws.  Deterministic; threads: none. */
vxs_result shells_find_inside(const shell_set *s, shell_pair *pairs, size_t count);

#ifdef __cplusplus
}
#endif
#endif
