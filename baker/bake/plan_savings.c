/* What options would save that change what a file promises; see plan.h.
 *
 * They are of sheets: of a solid the inside is free already. The maps are sampled as they would be with the option, and estimated by the same
 * coefficients as the plan.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/plan.h"
#include "baker/measure/clock.h"

/* Less is not worth a question. */
static const double LEAST_SHARE_SAVED = 0.1;

#define THICKNESS_M 0.02

static vxs_result estimate(bake_plan *plan, const bake_options *asked, const casters *c, plan_saving *out, message *m)
{
    double     bytes = (double)plan->file_bytes;
    vxs_result r     = VXS_OK;
    out->seconds     = plan->total_seconds;
    for (size_t n = 0; n < plan->light_count && r == VXS_OK; n++) {
        const plan_light *now   = &plan->lights[n];
        plan_light        other = *now;
        if (now->left_out) continue;
        r = plan_sample_light(plan, plan_count_maps(plan), &other, asked, c, m);
        plan_estimate_light(&other, asked);
        bytes += other.stored_bytes - now->stored_bytes;
        for (int s = 0; s < STAGE_COUNT; s++) out->seconds += other.seconds[s] - now->seconds[s];
    }
    out->file_bytes = bytes > 0 ? (uint64_t)bytes : 0;
    return r;
}

static vxs_result consider(bake_plan *plan, const bake_options *asked, const char *option, const casters *c, message *m)
{
    plan_saving saving = {.option = option};
    vxs_result  r      = estimate(plan, asked, c, &saving, m);
    if (r == VXS_OK && (double)saving.file_bytes <= (1 - LEAST_SHARE_SAVED) * (double)plan->file_bytes)
        plan->savings[plan->saving_count++] = saving;
    return r;
}

vxs_result plan_find_savings(bake_plan *plan, const bake_options *o, const casters *c, message *m)
{
    double       start  = clock_seconds();
    bake_options behind = *o, thick = *o;
    vxs_result   r    = VXS_OK;
    behind.behind     = BEHIND_FREE;
    thick.thickness_m = THICKNESS_M;
    if (o->maps != MAPS_SPARSE || c->solid_triangle_count == c->triangle_count) return r;
    if (o->behind != BEHIND_FREE) r = consider(plan, &behind, "--behind free", c, m);
    if (r == VXS_OK && !(o->thickness_m > 0)) r = consider(plan, &thick, "--thickness 0.02", c, m);
    plan->plan_seconds += clock_seconds() - start;
    return r;
}
