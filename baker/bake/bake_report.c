/* The report of a bake; see bake_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/files/json_value.h"

static void leave_out(bake_report *report, const char *name, const char *why)
{
    light_left_out *l = &report->left_out[report->left_out_count++];
    snprintf(l->name, sizeof l->name, "%s", name);
    l->why = why;
}

vxs_result bake_report_begin(bake_report *report, const scene *s, const casters *c, run_context *m)
{
    report->casters      = *c;
    casters *counts      = &report->casters; /* without arrays, which belong to the casters */
    counts->positions_ws = NULL;
    counts->indices = counts->component_of = counts->edge_mates = NULL;
    counts->kind_of = counts->solid_meets = NULL;
    counts->parts_of                      = NULL;
    counts->boxes                         = NULL;
    counts->double_sided                  = NULL;
    counts->alpha_masks                   = NULL;
    counts->alpha_mask_first              = NULL;
    counts->hole_uvs                      = NULL;
    counts->images                        = NULL;
    box all                               = casters_bounds(c);
    memcpy(report->casters_min_ws, all.min, sizeof all.min);
    memcpy(report->casters_max_ws, all.max, sizeof all.max);

    report->capsule_count   = s->smoke.count;
    report->exclusion_count = s->exclusion_count;
    report->exclusions      = malloc((s->exclusion_count + 1) * sizeof *report->exclusions);
    if (!report->exclusions) return fail(m, VXS_E_MEMORY, "out of memory for %zu exclusions", s->exclusion_count);
    if (s->exclusion_count) memcpy(report->exclusions, s->exclusions, s->exclusion_count * sizeof *report->exclusions);

    /* lights that were not chosen, are dark, faulty or hidden, and lights that reach nothing */
    const bake_plan *plan = report->plan;
    report->left_out      = calloc(s->light_count + s->lost_light_count + plan->light_count + 1, sizeof *report->left_out);
    if (!report->left_out) return fail(m, VXS_E_MEMORY, "out of memory for %zu lights", s->light_count);
    for (size_t n = 0; n < s->light_count; n++) {
        int is_chosen = 0;
        for (size_t k = 0; k < plan->light_count; k++)
            is_chosen |= !strncmp(s->lights[n].name, plan->lights[k].name, VXS_LIGHT_NAME_BYTES - 1);
        if (!is_chosen) leave_out(report, s->lights[n].name, s->lights[n].dark ? "dark" : "not requested");
    }
    for (size_t n = 0; n < s->lost_light_count; n++)
        leave_out(report, s->lost_lights[n].name, s->lost_lights[n].why ? "cannot be baked" : "hidden");
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l = &plan->lights[n];
        if (l->left_out) leave_out(report, l->name, l->left_out);
    }
    return VXS_OK;
}

square_counts report_squares(const bake_report *r)
{
    square_counts sum = {0, 0};
    for (uint32_t n = 0; n < r->light_count; n++) {
        sum.all += r->lights[n].squares;
        sum.made += r->lights[n].squares_made;
    }
    return sum;
}

json_t *report_left_out_json(const bake_report *r)
{
    json_t *lights = json_array();
    for (size_t n = 0; n < r->left_out_count; n++)
        json_append(&lights, json_pack("{s:o, s:s}", "name", json_text(r->left_out[n].name), "why", r->left_out[n].why));
    return lights;
}

void bake_report_free(bake_report *r)
{
    json_decref(r->inputs);
    free(r->lights);
    free(r->left_out);
    free(r->exclusions);
    if (r->plan) plan_free(r->plan);
    free(r->plan);
    for (uint32_t n = 0; n < r->picture_count; n++) light_picture_free(&r->pictures[n]);
    memset(r, 0, sizeof *r);
}
