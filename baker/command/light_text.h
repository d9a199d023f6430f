/* A baked light as text and as JSON, for reports.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_TEXT_H
#define LIGHT_TEXT_H

#include <jansson.h>

#include "formats/vxs_file.h"

enum { LIGHT_TEXT_BYTES = 512 };

/* "directional (0, -1, 0), 512 x 512 texels of 0.1 m, voxels 0.1 m deep"
 * text  [LIGHT_TEXT_BYTES] out
 * Returns text. */
const char *light_text(char *text, const vxs_light *light);

/* An object with name, kind, direction, resolution_px, maps, texel_m, voxel_m; for spot and point lights also position_m,
 * near_m, far_m, and range_m if the light has one; for spots cone_degrees. NULL when out of memory. */
json_t *light_json(const vxs_light *light);

#endif
