/* What the two makers of a mesh about what a light reaches share: light_mesh.c, in C, once, and mesh.c, in shaders, in each frame. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef LIGHT_MESH_H
#define LIGHT_MESH_H

#include "vxs.h"
#include "vxs_light_mesh.h"

/* The shape of the mesh of a light's map. A sun's box is about its map and a place, and far_metres about both.
 * about_ls  [3] light space; NULL: none */
vxs_mesh_shape vxs_light_mesh_shape(const vxs_light_constants *light, uint32_t side_px, double far_metres, const double *about_ls);

#endif
