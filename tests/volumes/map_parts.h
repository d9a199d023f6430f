/* Oracle T1: lit parts of a ray by the texels of a shadow depth map ("where shadow begins on the light ray through a texel's
 * centre"), each of which the ray crosses: in double, and without any stepping. All planes between texels are cut with the ray, and
 * sorted.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MAP_PARTS_H
#define MAP_PARTS_H

#include "formats/vxs_file.h"
#include "tests/volumes/lit_parts.h"

typedef struct shadow_depth_map {
    const vxs_light *light;        /* how its maps lie */
    uint32_t         side, layers; /* texels; 1, or 6 of a light with a cube */
    const float     *first; /* [layers][side][side]: suns: voxels of the light; punctual lights: metres along the axis of the map */
} shadow_depth_map;

/* A lit_oracle of a shadow_depth_map. Outside the maps, and of suns outside their depth, all is lit. Cone and range do not count.
 * Cost: a division for each row and column of each map. */
void map_parts(const void *map, const eye_ray *ray, lit_parts *parts);

/* Whether a place is lit. */
int map_lit(const shadow_depth_map *map, const double point[3]);

#endif
