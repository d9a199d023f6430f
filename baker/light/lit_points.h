/* Which casters a light reaches, and random points on them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIT_POINTS_H
#define LIT_POINTS_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

/* Index to find the casters that may lie in a spot light's map without testing each: for scenes with many lights.
 *
 * Consecutive triangles form runs, each with a bounding sphere. Only casters outside the map's sides are left out. So a map of the
 * reached casters equals the map of all casters, texel by texel. */

typedef struct reach_run {
    double center_ws[3], radius_metres;
} reach_run;

typedef struct reach_index {
    size_t     run_count;
    reach_run *runs; /* REACH_RUN triangles each; the last run may be shorter */
} reach_index;

enum { REACH_RUN = 64 };

/* Returns VXS_OK or VXS_E_MEMORY; released with reach_free either way. */
vxs_result reach_init(reach_index *x, const casters *c, run_context *m);
void       reach_free(reach_index *x);

/* The casters that may lie in a light's map, in their order. All of them, unless the light is a spot light with one map. May be
 * empty.
 * out  [out] zeroed on failure; released with reach_release. Borrows masks and images, and everything when it is all of c.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result reach_casters(casters *out, const reach_index *x, const casters *c, const light_shape *light, run_context *m);
void       reach_release(casters *out, const casters *c);

/* Random points on the casters within a light's maps and range: a sample of the surfaces that it can light. */

typedef struct lit_point {
    double   at_ws[3];
    double   along_metres; /* spot, point: distance from the light along the axis of its map; directional: 0 */
    double   weight;       /* surface area that the point represents, square metres */
    uint32_t triangle;     /* index in the casters */
} lit_point;

typedef struct lit_points_desc {
    const casters     *c;
    const reach_index *reach; /* index of c */
    const light_shape *shape;
    const vxs_light   *light; /* fitted to `shape` */

    const uint32_t *object_of; /* [components] triangles of components of object `without` get no points; NULL: all triangles may */
    uint32_t        without;
    size_t          triangles_max; /* larger sets of triangles are thinned evenly; 0: no limit */
} lit_points_desc;

/* Choose points. For half of them each square metre is equally likely, for the other half each triangle. So both a wide ground of
 * two triangles and a statue of a million triangles get a share. Parts of triangles outside the light's maps or range get no
 * points.
 * points  [count] out
 * Returns the number of points, at most `count`; 0 also without memory. Deterministic. Time: 20 ns for each triangle in reach. */
size_t lit_points_choose(lit_point *points, size_t count, const lit_points_desc *desc);

#endif
