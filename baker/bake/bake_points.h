/* Points of what casts, for the file (formats/vxs.md section 16).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_POINTS_H
#define BAKE_POINTS_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

/* Scatter so many over the triangles, by area.
 * view  [out] its places are the caller's, to be freed with free((void *)view->places_ws)
 * Returns VXS_OK, VXS_E_MEMORY; VXS_E_SCENE where the triangles have no area. */
vxs_result bake_points(vxs_points_view *view, const casters *c, uint32_t count, message *m);

#endif
