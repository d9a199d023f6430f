/* Parts of caster classification that use CGAL: which closed shells have something inside.
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

#ifdef __cplusplus
}
#endif
#endif
