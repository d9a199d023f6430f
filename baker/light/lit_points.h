/* Random points on the casters that a light reaches.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIT_POINTS_H
#define LIT_POINTS_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

/* Random points on the casters within a light's maps and range: a sample of the surfaces that it can light. */

typedef struct lit_point {
    double   at_ws[3];
    double   along_metres; /* spot, point: distance from the light along the axis of its map; directional: 0 */
    double   weight;       /* surface area that the point represents, square metres */
    uint32_t triangle;     /* index in the casters */
} lit_point;

typedef struct lit_points_desc {
    const casters     *c;
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
