/* Oracle T0: lit parts of a ray by asking whether places are lit, of rays that are traced or of a formula; ends by bisection.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRACED_PARTS_H
#define TRACED_PARTS_H

#include "baker/lab/truth/truth.h"
#include "tests/volumes/lit_parts.h"

/* What is queried. What is dark between two samples and nowhere else is not seen. */
typedef struct traced_light {
    int (*lit)(const void *user, const double point[3]); /* 1: the light reaches it */
    const void *user;
    light_shape shape;   /* samples of punctual lights lie at even angles about the light, of suns at even distances */
    size_t      samples; /* >= 2; TRACED_SAMPLES for a reference */
} traced_light;

enum { TRACED_SAMPLES = 4096 };

/* A lit_oracle of a traced_light. Ends are exact to 1e-12 of the ray's length, or as `lit` is. */
void traced_parts(const void *light, const eye_ray *ray, lit_parts *parts);

/* traced_light.lit of Embree's rays: to truth_precision. */
typedef struct traced_scene {
    const truth       *truth;
    const light_shape *shape;
} traced_scene;

int traced_scene_lit(const void *subject, const double point[3]);

#endif
