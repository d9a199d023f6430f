/* What fills the air of a scene: fog, and capsules of smoke, hair and dust.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_H
#define SMOKE_H

#include <math.h>
#include <stdint.h>

#include "runtime/volumes/vxs_capsule.h"

/* vxs_medium with an upper bound. */
typedef struct fog_medium {
    double scattering[3], extinction[3]; /* per metre */
    double anisotropy;
    double top_ws; /* height of its horizontal top, metres; INFINITY: unbounded */
} fog_medium;

#define SMOKE_CAPSULES_MAX (1u << 24) /* limit of a scene, and of a transmittance map */

typedef struct scene_smoke {
    double       origin_ws[3]; /* origin of the capsules' coordinates: floats are precise enough within a cloud, but not for its
                              position in the world */
    uint32_t     count;
    vxs_capsule *list;   /* [count] radii and extinctions are positive; owned by the scene */
    float (*albedos)[3]; /* [count] single-scattering albedo: scattering / extinction, linear, [0, 1]; owned by the scene */
} scene_smoke;

/* Widen a capsule to a minimum radius, and reduce its extinction by the ratio of the volumes, so that its total attenuation stays
 * the same while it is small. Then sparse rays do not miss thin capsules. */
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

/* Make positions relative to the eye instead of the origin. */
static inline void smoke_from_eye(const scene_smoke *smoke, vxs_capsule *c, const double eye_ws[3])
{
    for (int n = 0; n < 3; n++) {
        c->begin[n] = (float)((double)c->begin[n] + (smoke->origin_ws[n] - eye_ws[n]));
        c->end[n]   = (float)((double)c->end[n] + (smoke->origin_ws[n] - eye_ws[n]));
    }
}

#endif
