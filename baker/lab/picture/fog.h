/* Fog in the light of baked lights, without a march: the asset gives the exact lit intervals of a ray from the eye, and airlight
 * of an interval has a closed form (runtime/volumes/vxs_air.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_H
#define FOG_H

#include "baker/scene/scene.h"
#include "baker/scene/smoke.h"
#include "formats/vxs_file.h"

typedef struct fog_light {
    const vxs_baked_light *light;
    light_shape            shape;         /* its range is the end of its light, in the air and on surfaces */
    double                 colour[3];     /* suns: irradiance; punctual lights: intensity, irradiance times square metres */
    double                 cos_inner;     /* of spot lights */
    double                 radius_metres; /* of punctual lights, > 0 */
} fog_light;

/* Add the airlight between the eye and `metres`, finite, along a direction of length 1.
 * lights    [light_count]
 * airlight  [in, out] */
void fog_add_airlight(const fog_medium *f, const fog_light *lights, uint32_t light_count, const double eye_ws[3],
                      const double direction[3], double metres, double airlight[3]);

/* Light that reaches a place, before shadows, by the same law as its airlight (runtime/volumes/vxs_air_light.h).
 * to_light  [out] of length 1;   reaches  [out] times the light's colour */
void fog_reaches(const fog_medium *f, const fog_light *light, const double place_ws[3], double to_light[3], double reaches[3]);

/* Transmittance of the fog along a ray from the eye.   left  [out] 0 to 1 */
void fog_left(const fog_medium *f, const double eye_ws[3], const double direction[3], double metres, double left[3]);

#endif
