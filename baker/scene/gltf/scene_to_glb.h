/* A loaded scene as one that can be written.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_TO_GLB_H
#define SCENE_TO_GLB_H

#include "baker/scene/gltf/glb_write.h"

/* What a bake reads of a scene: triangles in their order within each material, double-sidedness, alpha masks, lights, places of cameras,
 * names of the scene and of its lights. Positions are rounded to float, as glb_round_positions does it.
 * out        [out] zeroed on failure; borrows the scene's name; released with glb_scene_free
 * origin_ws  of glb_find_origin
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result glb_from_scene(glb_scene *out, const scene *s, const double origin_ws[3], message *m);

/* Where positions of a GLB should count from, so that floats hold them well: 0,0,0, unless the scene lies far from there for its size, as
 * georeferenced ones do. Then it is what the longest run of triangles was placed from, which keeps their floats as they were; or the middle of the
 * scene, where that moves vertices less. */
void glb_find_origin(const scene *s, double origin_ws[3]);

/* Round positions to what a GLB can hold, floats from an origin. Vertices at one position stay together, and some that were apart may come
 * together. Warns when a vertex moves by more than a millimetre.
 * Returns VXS_OK, VXS_E_SCENE when a position is beyond the range of a float, or VXS_E_STRICT. */
vxs_result glb_round_positions(scene *s, const double origin_ws[3], message *m);

#endif
