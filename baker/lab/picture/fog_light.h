/* A baked light in fog.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_LIGHT_H
#define FOG_LIGHT_H

#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

typedef struct fog_light {
    const vxs_baked_light *light;
    light_shape            shape;         /* its range is the end of its light, in the air and on surfaces */
    double                 colour[3];     /* suns: irradiance; lamps: intensity, irradiance times square metres */
    double                 cos_inner;     /* of spot lights */
    double                 radius_metres; /* of lamps, > 0 */
} fog_light;

#endif
