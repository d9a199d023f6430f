/* The shape of a baked light, and where in its maps a point lies.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKED_LIGHT_H
#define BAKED_LIGHT_H

#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

/* Kind, place, direction, cone and range, in world space. */
light_shape baked_light_shape(const vxs_light *light);

/* The light-space coordinates of a point in a map: texels u, v and depth in voxels, none of them whole; vxs_point leads back.
 * map  0, or 0 to 5 of a light with six maps: the point lies before it, as in the map that vxs_voxel returns */
void baked_light_coordinates(const vxs_light *light, int map, const double point_ws[3], double coordinates[3]);

#endif
