/* Fog among spheres, by formulas alone: where rays are lit, and airlight between.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPHERE_FOG_H
#define SPHERE_FOG_H

#include "baker/lab/picture/fog.h"
#include "tests/volumes/sphere_parts.h"

/* As fog_add_airlight, of a light that nothing but spheres keeps from places; its asset is not queried.   Threads: any. */
void sphere_fog_add_airlight(const fog_medium *f, const fog_light *light, const lit_spheres *spheres, const double eye_ws[3],
                             const double direction[3], double metres, double airlight[3]);

#endif
