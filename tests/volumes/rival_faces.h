/* A rival of area lights: a march of each punctual light of a surface that shines, by a shadow map of its own: what
 * vxs_volumes_march does of punctual lights that shine to all sides.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_FACES_H
#define RIVAL_FACES_H

#include "runtime/volumes/vxs_area_light.h"

typedef struct rival_faces rival_faces;

/* Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL */
vxs_result rival_faces_create(rival_faces **faces, vxs_volumes *v);
void       rival_faces_destroy(rival_faces *faces);

/* Add the airlight of a punctual light to the frame, at `steps` even steps of angle.
 * map  of a baked light where the light is, and `baked` is its number */
vxs_result rival_faces_march(rival_faces *faces, const vxs_vpl *punctual, uint32_t baked, const vxs_shadow_depth_map *map,
                             uint32_t steps);

#endif
