/* Index to find the casters that may lie in a spot light's map without testing each: for scenes with many lights.
 *
 * Consecutive triangles form runs, each with a bounding sphere. Only casters outside the map's sides are left out. So a map of the
 * reached casters equals the map of all casters, texel by texel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REACH_H
#define REACH_H

#include "baker/casters/casters.h"

typedef struct reach_run {
    double center_ws[3], radius_m;
} reach_run;

typedef struct reach_index {
    size_t     run_count;
    reach_run *runs; /* REACH_RUN triangles each; the last run may be shorter */
} reach_index;

enum { REACH_RUN = 64 };

/* Returns VXS_OK or VXS_E_MEMORY; released with reach_free either way. */
vxs_result reach_init(reach_index *x, const casters *c, message *m);
void       reach_free(reach_index *x);

/* The casters that may lie in a light's map, in their order. All of them, unless the light is a spot light with one map. May be
 * empty.
 * out  [out] zeroed on failure; released with reach_release. Borrows masks and images, and everything when it is all of c.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result reach_casters(casters *out, const reach_index *x, const casters *c, const light_shape *light, message *m);
void       reach_release(casters *out, const casters *c);

#endif
