/* One light of a bake: from casters to the DAG of its shadows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHT_H
#define BAKE_LIGHT_H

#include "baker/bake.h"
#include "baker/maps/baseline.h"
#include "baker/maps/gl.h"
#include "baker/scene/light_choice.h"

/* Time and memory of the stage that is at work. */
typedef struct stage_timer {
    bake_report *report;
    double       start;
} stage_timer;

stage_timer stage_begin(bake_report *report);

/* Add what has passed since the timer began, or last ended a stage, to a stage. */
void stage_end(stage_timer *t, bake_stage stage);

/* What all lights of a bake share; borrowed. */
typedef struct light_baker {
    const bake_options *options;
    gl_context         *gl;
    const casters      *casters;
    bake_report        *report;
} light_baker;

/* Bake a light.
 * out    [out] its DAG, a root for each map; released with dag_free, whatever is returned
 * base   [out] a sample of its depth maps; released with baseline_free
 * light  [out] what is to be told
 * Returns VXS_OK; VXS_E_NO_CASTER (no message) when the light reaches no caster; VXS_E_ARGUMENT, VXS_E_GL, VXS_E_MEMORY. */
vxs_result bake_light(const light_baker *b, const chosen_light *chosen, dag *out, baseline *base, light_report *light, message *m);

#endif
