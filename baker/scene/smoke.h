/* Smoke, hair and dust of a scene: capsules that dim light.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_H
#define SMOKE_H

#include <math.h>
#include <stdint.h>

#include "runtime/volumes/vxs_capsule.h"

#define SMOKE_CAPSULES_MAX (1u << 24) /* of a scene; as of a map of transmittance */

typedef struct scene_smoke {
    double   origin_ws[3]; /* places of capsules count from there: floats do for a cloud, but not for where in the world it is */
    uint32_t count;
    vxs_capsule *list;   /* [count] radii and extinctions more than 0; owned by the scene */
    float (*albedos)[3]; /* [count] the share of what a capsule takes that it scatters, linear, 0 to 1; owned likewise */
} scene_smoke;

/* As wide as a radius at least, and as much less dense as it is larger then, a cylinder and a ball: what rays far apart miss at times, they meet, and it takes as much
 * light in all, while that is little. */
static inline vxs_capsule smoke_widened(vxs_capsule c, double least_metres)
{
    double radius = (double)c.radius_metres, part = radius / least_metres, square = 0;
    if (!(part < 1)) return c;
    for (int n = 0; n < 3; n++) square += ((double)c.end[n] - (double)c.begin[n]) * ((double)c.end[n] - (double)c.begin[n]);
    double length   = sqrt(square);
    c.radius_metres = (float)least_metres;
    c.extinction    = (float)((double)c.extinction * part * part * (length + 4.0 / 3 * radius) / (length + 4.0 / 3 * least_metres));
    return c;
}

/* Places from the eye, and not from the origin. */
static inline void smoke_from_eye(const scene_smoke *smoke, vxs_capsule *c, const double eye_ws[3])
{
    for (int n = 0; n < 3; n++) {
        c->begin[n] = (float)((double)c->begin[n] + (smoke->origin_ws[n] - eye_ws[n]));
        c->end[n]   = (float)((double)c->end[n] + (smoke->origin_ws[n] - eye_ws[n]));
    }
}

#endif
