/* Shared by the code that builds a mesh around the lit volume of a light: light_mesh.c, once, in C; mesh.c and mesh_adaptive.c,
 * in each frame, in shaders. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef LIGHT_MESH_H
#define LIGHT_MESH_H

#include "volumes_state.h"
#include "vxs_light_mesh.h"

/* log2 of the side of a map.   Returns -1 if side_px is not a power of two, or above 8192 */
int vxs_mesh_levels(uint32_t side_px);

/* The shape of the mesh of a light's map; its side must be valid for vxs_mesh_levels. The box of a sun contains its map and a
 * point, with a margin of far_metres around both.
 * about_ls  [3] the point, in light space; NULL: none */
vxs_mesh_shape vxs_light_mesh_shape(const vxs_light_constants *light, uint32_t side_px, double far_metres, const double *about_ls);

/* Set a light and its mesh for the shaders that follow.
 * map    NULL: the mesh was made in C
 * shape  [out] of the map's mesh
 * Returns VXS_OK; VXS_E_ARGUMENT without a frame, if the light is invalid, if the view has no inverse, or for a mesh with more
 * corners than an int can count. */
vxs_result vxs_mesh_begin(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, vxs_mesh_shape *shape);

/* How a mesh is drawn. */
typedef struct mesh_draw {
    gl_name program, texture; /* texture: a buffer texture; 0: none */
    gl_name vertex_array;     /* with an element buffer; 0: shaders generate all vertices */
    gl_name commands;         /* an indirect draw buffer; 0: the count below is used */
    int     corners;
} mesh_draw;

/* The program that draws a mesh, with lines of #define. */
gl_name vxs_mesh_program(vxs_volumes *v, const char *names);

/* Add the light of the frame. */
void vxs_mesh_add(vxs_volumes *v, const vxs_shadow_depth_map *map, const mesh_draw *draw);

#endif
