/* The plan of a frame's smoke: which lights it dims, by how large maps, which it does not, and why.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_PLAN_H
#define SMOKE_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "formats/vxs_file.h"

/* The decision on a light. */
typedef enum smoke_fate {
    SMOKE_DIMS,
    SMOKE_OUT_OF_REACH, /* no capsule is in its range, cone or prism */
    SMOKE_OUT_OF_VIEW,  /* its range is not in view */
    SMOKE_NO_ROOM,      /* all maps are taken */
    SMOKE_FATES
} smoke_fate;

/* The plan of one light. A built map stays. */
typedef struct smoke_light_plan {
    smoke_fate fate;
    uint32_t   segments, merged, cut_texels; /* of its map, as in vxs_transmittance_counts */
} smoke_light_plan;

typedef struct smoke_plan {
    uint32_t lights[SMOKE_FATES];
    uint32_t built; /* maps, in this frame */
} smoke_plan;

/* A line; with `verbose` a line for each light.   capsules  of the scene;   side_px  of maps */
void smoke_plan_print(FILE *to, const smoke_plan *plan, uint32_t capsules, uint32_t side_px, const smoke_light_plan *lights,
                      const vxs_baked_light *const *names, uint32_t light_count, int verbose);

/* For a frame: the number of lights with each decision, and of maps that were built. */
json_t *smoke_plan_counts(const smoke_plan *plan);

/* Of the picture: each light. */
json_t *smoke_plan_lights(const smoke_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count);

#endif
