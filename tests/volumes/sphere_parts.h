/* Oracle of spheres: lit parts of a ray by formulas. What a sphere keeps light from is itself and, behind the circle where light
 * grazes it, a cylinder of the sun's, a cone of a punctual light's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPHERE_PARTS_H
#define SPHERE_PARTS_H

#include "baker/scene/scene.h"
#include "tests/volumes/lit_parts.h"

typedef struct sphere {
    double centre[3], radius; /* metres */
} sphere;

/* They may meet. */
typedef struct lit_spheres {
    const sphere *at; /* [count] */
    size_t        count;
    light_shape   light; /* a sun, or a point light outside of all of them */
} lit_spheres;

/* A lit_oracle of lit_spheres, exact to rounding. */
void sphere_parts(const void *spheres, const eye_ray *ray, lit_parts *parts);

#endif
