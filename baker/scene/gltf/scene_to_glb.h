/* Convert a loaded scene to a glb_scene for writing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_TO_GLB_H
#define SCENE_TO_GLB_H

#include "baker/scene/gltf/glb_write.h"

/* Convert everything that a bake reads: triangles in order within each material, double-sidedness, alpha masks, lights, positions
 * of cameras, names of the scene and its lights. Positions are rounded to float as by glb_round_positions.
 * out        [out] zeroed on failure; borrows the scene's name; released with glb_scene_free
 * origin_ws  from glb_find_origin
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result glb_from_scene(glb_scene *out, const scene *s, const double origin_ws[3], message *m);

/* Find an origin for the positions of a GLB, so that floats are precise enough. 0,0,0, unless the scene is far from there relative
 * to its size, as georeferenced scenes are. Then it is the origin of the longest run of triangles, which preserves their original
 * floats, or the centre of the scene, if that moves vertices less. */
void glb_find_origin(const scene *s, double origin_ws[3]);

/* Round positions to floats relative to an origin, as a GLB stores them. Vertices with equal positions stay equal; different
 * positions may become equal. Warns when a vertex moves by more than a millimetre.
 * Returns VXS_OK, VXS_E_SCENE when a position exceeds the range of a float, or VXS_E_STRICT. */
vxs_result glb_round_positions(scene *s, const double origin_ws[3], message *m);

#endif
