/* A rival: froxels. Airlight from the eye on, in a grid of columns of the view and slices of distance, one question to the light
 * map a cell; pixels read it between cells.
 * Source: Wronski, Volumetric fog, SIGGRAPH 2014 courses; as engines have it, without what they gather over frames.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_FROXELS_H
#define RIVAL_FROXELS_H

#include "runtime/volumes/vxs_area_light.h"

typedef struct rival_froxels rival_froxels;

/* wide, high  columns of the view; 1 to 2^14
 * deep        slices, 1 to GL_MAX_ARRAY_TEXTURE_LAYERS; they grow with distance
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL */
vxs_result rival_froxels_create(rival_froxels **froxels, vxs_volumes *v, uint32_t wide, uint32_t high, uint32_t deep);
void       rival_froxels_destroy(rival_froxels *froxels);

/* Add a light's airlight to the frame, as vxs_volumes_march does. */
vxs_result rival_froxels_add(rival_froxels *froxels, const vxs_volumes_light *light, const vxs_shadow_depth_map *map);

/* The same of a rectangle: all its light, without a shadow but that of its centre, as engines have local lights of any shape in
 * their froxels, which have one shadow map each.
 * rectangle  its texture counts by its mean
 * centre     a punctual light that stands there, and the map of it */
vxs_result rival_froxels_create_rectangle(rival_froxels **froxels, vxs_volumes *v, uint32_t wide, uint32_t high, uint32_t deep);
vxs_result rival_froxels_add_rectangle(rival_froxels *froxels, const vxs_area_rectangle *rectangle, const vxs_volumes_light *centre,
                                       const vxs_shadow_depth_map *map);

#endif
