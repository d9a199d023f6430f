/* Random points of the casters that lie in a light's maps and within its range: what a light can light, as a sample.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIT_POINTS_H
#define LIT_POINTS_H

#include "baker/casters/casters.h"
#include "baker/light/reach.h"
#include "formats/vxs_file.h"

typedef struct lit_point {
    double   at_ws[3];
    double   along_m;  /* spot, point: from the light along the axis of its map; sun: 0 */
    double   weight;   /* how much surface it stands for, in square metres */
    uint32_t triangle; /* of the casters */
} lit_point;

typedef struct lit_points_desc {
    const casters     *c;
    const reach_index *reach; /* of c */
    const light_shape *shape;
    const vxs_light   *light; /* fitted to it */

    const uint32_t *object_of; /* [components] triangles of components of object `without` give no point; NULL: all triangles do */
    uint32_t        without;
    size_t          triangles_max; /* more triangles are thinned out evenly; 0: none is left out */
} lit_points_desc;

/* Choose points: half of them so that each square metre is as likely as another, half so that each triangle is; a wide ground of two
 * triangles and a statue of a million both get their share. What of a triangle lies outside the light's maps or its range gives no point.
 * points  [count] out
 * Returns how many there are, `count` at most; 0 without memory, too. Same input, same points. Time: 20 ns a triangle in reach. */
size_t lit_points_choose(lit_point *points, size_t count, const lit_points_desc *desc);

#endif
