/* Smoke, hair and dust of a scene: capsules that dim light.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_H
#define SMOKE_H

#include <stdint.h>

#include "runtime/volumes/vxs_capsule.h"

#define SMOKE_CAPSULES_MAX (1u << 24) /* of a scene; as of a map of transmittance */

typedef struct scene_smoke {
    double   origin_ws[3]; /* places of capsules count from there: floats do for a cloud, but not for where in the world it is */
    uint32_t count;
    vxs_capsule *list;   /* [count] radii and extinctions more than 0; owned by the scene */
    float (*albedos)[3]; /* [count] the share of what a capsule takes that it scatters, linear, 0 to 1; owned likewise */
} scene_smoke;

#endif
