/* A loaded scene as one that can be written.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_TO_GLB_H
#define SCENE_TO_GLB_H

#include "baker/gltf/glb_write.h"

/* What a bake reads of a scene: triangles in their order within each material, double-sidedness, alpha masks, lights, places of cameras,
 * names of the scene and of its lights. Positions are rounded to float, as glb_round_positions does it.
 * out  [out] zeroed on failure; borrows the scene's name; released with glb_scene_free
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result glb_from_scene(glb_scene *out, const scene *s, message *m);

/* Round positions to what a GLB can hold. Vertices at one position stay together, and some that were apart may come together.
 * Returns VXS_OK, or VXS_E_SCENE when a position is beyond the range of a float. */
vxs_result glb_round_positions(scene *s, message *m);

#endif
