/* The casters that may lie in a spot light's map, found without looking at each: for scenes of many lights.
 *
 * Triangles are taken by runs of neighbours, each with a sphere around it. What is left out lies outside the map's sides, so that maps
 * of the casters that are reached are those of all casters, texel by texel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REACH_H
#define REACH_H

#include "baker/casters/casters.h"

typedef struct reach_run {
    double center_ws[3], radius_m;
} reach_run;

typedef struct reach_index {
    size_t     run_count;
    reach_run *runs; /* of REACH_RUN triangles each, the last one of what is left */
} reach_index;

enum { REACH_RUN = 64 };

/* Returns VXS_OK or VXS_E_MEMORY; released with reach_free either way. */
vxs_result reach_init(reach_index *x, const casters *c, message *m);
void       reach_free(reach_index *x);

/* The casters that a light's map may hold, in their order: all of them unless the light is a spot with one map. May be none.
 * out  [out] zeroed on failure; released with reach_release. Borrows masks and images, and everything when it is all of c.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result reach_casters(casters *out, const reach_index *x, const casters *c, const light_shape *light, message *m);
void       reach_release(casters *out, const casters *c);

#endif
