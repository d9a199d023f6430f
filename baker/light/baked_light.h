/* Shape of a baked light, and coordinates of points in its maps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKED_LIGHT_H
#define BAKED_LIGHT_H

#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

/* Kind, position, direction, cone and range, in world space. */
light_shape baked_light_shape(const vxs_light *light);

/* Light-space coordinates of a point in a map: texels u, v and depth in voxels, not rounded. Inverse of vxs_point.
 * map  0, or 0 to 5 for a light with six maps: the map that vxs_voxel returns, in front of which the point lies */
void baked_light_coordinates(const vxs_light *light, int map, const double point_ws[3], double coordinates[3]);

#endif
