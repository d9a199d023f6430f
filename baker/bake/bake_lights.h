/* The lights of a bake: one after another on all threads, or several at once, each on one thread.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHTS_H
#define BAKE_LIGHTS_H

#include "baker/bake/bake_report.h"
#include "baker/bake/bake_squares.h"
#include "baker/bake/light_coder.h"

/* What all lights of a bake share. */
typedef struct lights_job {
    const bake_options *o;
    const casters      *c;
    void               *device; /* of the renderer; NULL if nothing is rendered */
    coded_light        *coded;  /* [baked_count of the plan] zeroed; released with coded_light_free, whatever is returned */
    bake_squares       *squares;
    bake_report        *report; /* [in] plan, lights [baked_count] zeroed; [out] lights, light_count, pictures */
} lights_job;

/* Bake the lights of the plan that are not left out. The result does not depend on the number of threads. */
vxs_result bake_lights(const lights_job *job, bake_context *ctx);

#endif
