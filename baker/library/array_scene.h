/* Makes a scene of a program's arrays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ARRAY_SCENE_H
#define ARRAY_SCENE_H

#include "baker/scene/scene.h"
#include "baker/vxs_bake.h"

/* Copy arrays into a scene; nothing is borrowed.
 * s  [out] zeroed on failure; released with scene_free
 * Returns VXS_OK, VXS_E_MEMORY, or VXS_E_ARGUMENT: an index out of range, a number that is not finite, an invalid light. */
vxs_result scene_from_arrays(scene *s, const vxs_bake_arrays *arrays, run_context *m);

#endif
