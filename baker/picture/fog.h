/* Fog in the light of baked lights, without a march: along a ray from the eye the asset says where it is lit, exactly, and between the ends
 * of each lit interval airlight has a closed form (runtime/volumes/vxs_air.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_H
#define FOG_H

#include "baker/scene/fog_medium.h"
#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

/* A baked light, and how bright it is. */
typedef struct fog_light {
    const vxs_baked_light *light;
    light_shape            shape;
    double                 colour[3];     /* suns: irradiance; lamps: intensity, times square metres */
    double                 cos_inner;     /* of spot lights */
    double                 radius_metres; /* of lamps, > 0 */
} fog_light;

/* Add what fog scatters toward the eye between it and `metres`, finite, along a direction of length 1.
 * lights    [light_count]
 * airlight  [in, out] */
void fog_add_airlight(const fog_medium *f, const fog_light *lights, uint32_t light_count, const double eye_ws[3],
                      const double direction[3], double metres, double airlight[3]);

/* What it leaves of light that comes from there.   left  [out] 0 to 1 */
void fog_left(const fog_medium *f, const double eye_ws[3], const double direction[3], double metres, double left[3]);

#endif
