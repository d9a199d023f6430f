/* Random points on casters, stored in the file (formats/vxs.md section 16).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_POINTS_H
#define BAKE_POINTS_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

/* Scatter `count` points over the triangles, uniformly by area.
 * view  [out] the caller owns its points: free((void *)view->places_ws)
 * Returns VXS_OK, VXS_E_MEMORY; VXS_E_SCENE if the triangles have no area. */
vxs_result bake_points(vxs_points_view *view, const casters *c, uint32_t count, message *m);

#endif
