/* The lights of a bake: one after another on all threads, or several at once, each on one thread.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_LIGHTS_H
#define BAKE_LIGHTS_H

#include "baker/bake/bake_report.h"
#include "baker/bake/bake_squares.h"
#include "baker/bake/light_coder.h"

/* Bake the lights of report->plan that are not left out.
 * device  of the renderer; NULL if nothing is rendered
 * coded   [baked_count of the plan] zeroed; released with coded_light_free, whatever is returned
 * report  [in] plan, lights [baked_count] zeroed; [out] lights, light_count, pictures
 * The result does not depend on the number of threads. */
vxs_result bake_lights(const bake_options *o, const casters *c, void *device, coded_light *coded, bake_squares *squares,
                       bake_report *report, bake_context *ctx);

#endif
