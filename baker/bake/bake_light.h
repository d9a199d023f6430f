/* One light of a bake: from casters to the DAG of its shadows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHT_H
#define BAKE_LIGHT_H

#include "baker/bake/bake.h"
#include "baker/bake/baseline.h"
#include "baker/columns/opengl/gl.h"
#include "baker/bake/plan.h"

/* Time and memory of the stage that is at work. */
typedef struct stage_timer {
    bake_report *report;
    double       start;
} stage_timer;

stage_timer stage_begin(bake_report *report);

/* Add what has passed since the timer began, or last ended a stage, to a stage. */
void stage_end(stage_timer *t, bake_stage stage);

/* VXS_E_MEMORY when more was held than --memory allows: estimates may be wrong, the promise is kept. */
vxs_result bake_within_budget(const bake_options *o, const bake_report *report, message *m);

/* What all lights of a bake share; borrowed. */
typedef struct light_baker {
    const bake_options *options;
    const bake_plan    *plan;
    gl_context         *gl;
    const casters      *casters;
    bake_report        *report;
    double              start, past_seconds; /* of the clock, when the bake began; of the plan, what is done */
} light_baker;

/* Bake a light as planned.
 * picture  NULL, or of its maps, without casters yet
 * out    [out] its DAG, a root for each map; released with dag_free, whatever is returned
 * base   [out] a sample of its depth maps; released with baseline_free
 * light  [out] what is to be told
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result bake_light(light_baker *b, const plan_light *planned, dag *out, baseline *base, light_picture *picture,
                      light_report *light, message *m);

#endif
