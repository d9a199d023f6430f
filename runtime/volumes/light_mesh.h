/* What makers of a mesh about what a light reaches share: light_mesh.c, in C, once; mesh.c and mesh_adaptive.c, in shaders, in each frame. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef LIGHT_MESH_H
#define LIGHT_MESH_H

#include "volumes_state.h"
#include "vxs_light_mesh.h"

/* The side of a map is two to the power of how many?   Returns -1 for one that is none, or has more than 8192 texels */
int vxs_mesh_levels(uint32_t side_px);

/* The shape of the mesh of a light's map, whose side is one of those. A sun's box is about its map and a place, and far_metres about both.
 * about_ls  [3] light space; NULL: none */
vxs_mesh_shape vxs_light_mesh_shape(const vxs_light_constants *light, uint32_t side_px, double far_metres, const double *about_ls);

/* A light and its mesh, for the shaders that follow.
 * map    NULL: of a mesh that was made in C
 * shape  [out] of the map's mesh
 * Returns VXS_OK; VXS_E_ARGUMENT without a frame, such a light, or an inverse of the view, and for a mesh of more corners than an int counts. */
vxs_result vxs_mesh_begin(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, vxs_mesh_shape *shape);

/* How a mesh is drawn. */
typedef struct mesh_draw {
    gl_name program, texture; /* texture: of a buffer; 0: none */
    gl_name vertex_array;     /* of elements; 0: shaders make all vertices */
    gl_name commands;         /* a buffer that begins with how many are drawn; 0: as the next says */
    int     corners;
} mesh_draw;

/* Add the light of the frame. */
void vxs_mesh_add(vxs_volumes *v, const vxs_shadow_depth_map *map, const mesh_draw *draw);

#endif
