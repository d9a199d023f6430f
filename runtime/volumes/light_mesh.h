/* The mesh about what a light reaches, made in C of a light map: once, when a level is loaded; and the shape of such a mesh for shaders.
 * SPDX-License-Identifier: MIT */
#ifndef LIGHT_MESH_H
#define LIGHT_MESH_H

#include "vxs.h"
#include "vxs_light_mesh.h"

/* What is not named is 0, and means the default. It grows at its end only. */
typedef struct vxs_light_mesh_desc {
    size_t                     struct_size; /* sizeof(vxs_light_mesh_desc); 0: as it was at first, up to error_texels */
    const vxs_light_constants *light;       /* how its maps lie */
    const float *first; /* [layers][side_px][side_px] the light map, as vxs_light_map_create has it: rows, where shadow begins */
    uint32_t     side_px; /* a power of two, 1 to 8192; no more than the baked map has */
    float far_metres; /* > 0. Lamps without a range: how far their light goes. Suns: how far about their map. No eye ray sees farther */
    float error_texels; /* how far a quad of several texels may lie off the depth of any, in widths of a texel there; 0: a quad for every texel */
} vxs_light_mesh_desc;

typedef struct vxs_light_mesh_size {
    uint32_t vertex_count, triangle_count;
} vxs_light_mesh_size;

/* Bytes of working memory; 0 where the description makes no sense, or is too large for 32-bit indices. */
size_t vxs_light_mesh_room(const vxs_light_mesh_desc *desc);

/* Choose the quads, and say how large the mesh is.
 * room  [vxs_light_mesh_room] aligned as for uint32_t; vxs_light_mesh_fill reads it
 * size  [out]
 * Returns VXS_OK; VXS_E_ARGUMENT, and nothing is written.
 * Cost: about 0.1 us for each texel of the map. Threads: none shared. */
vxs_result vxs_light_mesh_plan(const vxs_light_mesh_desc *desc, void *room, vxs_light_mesh_size *size);

/* Write the mesh that was planned with the same description and room. It is closed: each edge is met by as many triangles one way as the other, at
 * equal vertices, or at vertices with equal places where faces of a cube meet. Depths that are no number count as 0.
 * places   [out] [3 * vertex_count] light space: of suns texels, texels and voxels of the baked map; of lamps metres about the light, along
 *          the axes of light space
 * corners  [out] [3 * triangle_count] vertices; counterclockwise as seen from where no light is, in a light space that is right-handed */
void vxs_light_mesh_fill(const vxs_light_mesh_desc *desc, const void *room, float *places, uint32_t *corners);

/* The shape of the mesh of a light's map. A sun's box is about its map and as far about a place as it is told.
 * about_ls  [3] light space; NULL: the map's box alone, and far_metres about it */
vxs_mesh_shape vxs_light_mesh_shape(const vxs_light_constants *light, uint32_t side_px, double far_metres, const double *about_ls);

#endif
