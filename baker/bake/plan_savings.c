/* Savings of options that change what a file promises; see plan.h.
 *
 * These options affect sheets; the inside of solids is don't-care already. The maps are sampled as with the option, and estimated
 * with the coefficients of the plan.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/bake/plan.h"
#include "baker/base/box.h"
#include "baker/base/clock.h"
#include "baker/base/vec3.h"

/* A smaller saving is not reported. --closed on demands more of the scene, so it must save more. */
static const double LEAST_SHARE_SAVED = 0.1, LEAST_SHARE_CLOSED = 0.2;

/* Fewer triangles change little, and are not sampled. */
enum { TWO_SIDED_SHARE = 4 };

#define THICKNESS_METRES 0.02

/* Add a saving, unless it is below a share of the whole. */
static vxs_result consider(bake_plan *plan, const bake_options *asked, const casters *c, plan_saving saving, double least_share,
                           run_context *m)
{
    bake_plan as_if = *plan;
    as_if.lights    = malloc(plan->light_count * sizeof *as_if.lights);
    if (!as_if.lights) return fail(m, VXS_E_MEMORY, "out of memory for an estimate of %s", saving.option);
    memcpy(as_if.lights, plan->lights, plan->light_count * sizeof *as_if.lights);
    vxs_result r      = plan_estimate(&as_if, asked, c, m);
    saving.file_bytes = as_if.file_bytes;
    saving.seconds    = as_if.total_seconds;
    free(as_if.lights);
    if (r == VXS_OK && (double)saving.file_bytes <= (1 - least_share) * (double)plan->file_bytes)
        plan->savings[plan->saving_count++] = saving;
    return r;
}

/* closed double-sided components ---------------------------------------------------------------------------------------------- */

/* Copy triangles of one kind to position `at` and on: closed double-sided components, or all others between solids and masks. */
static size_t take_sheets(casters *out, const casters *c, const double *volumes, int closed, size_t at)
{
    for (size_t t = c->solid_triangle_count; t < c->holed_first; t++) {
        uint32_t k = c->component_of[t];
        if ((c->kind_of[k] == COMPONENT_SHEET_DOUBLE_SIDED) != closed) continue;
        for (size_t n = 0; n < 3; n++) /* turn inward triangles outward */
            out->indices[3 * at + n] = c->indices[3 * t + (closed && volumes[k] < 0 ? 2 - n : n)];
        out->double_sided[at++] = c->double_sided[t];
    }
    return at;
}

vxs_result plan_find_closed(bake_plan *plan, const bake_options *o, const casters *c, run_context *m)
{
    double      start  = clock_seconds();
    plan_saving saving = {.option = "--closed on", .triangles = c->triangles_of_kind[COMPONENT_SHEET_DOUBLE_SIDED]};
    casters     closed;
    vxs_result  r = VXS_OK;
    if (o->maps != MAPS_SPARSE || o->closed != CLOSED_AUTO || TWO_SIDED_SHARE * saving.triangles < casters_whole_count(c)) return r;

    /* The casters with these components as solids, which is the main effect of --closed on. The result owns only indices,
     * runs and double_sided. */
    double *volumes     = calloc(casters_component_count(c) + 1, sizeof *volumes);
    closed              = *c;
    closed.edge_mates   = NULL; /* triangles get other numbers */
    closed.runs         = NULL;
    closed.indices      = malloc(3 * c->triangle_count * sizeof *closed.indices);
    closed.double_sided = malloc(c->triangle_count);
    int ok              = volumes && closed.indices && closed.double_sided;
    if (ok) {
        memcpy(closed.indices, c->indices, 3 * c->triangle_count * sizeof *closed.indices);
        memcpy(closed.double_sided, c->double_sided, c->triangle_count);

        /* Add the volumes of components, times 6, relative to a corner of their boxes. volumes [components] zeroed */
        for (size_t t = c->solid_triangle_count; t < c->holed_first; t++) {
            uint32_t k = c->component_of[t];
            double   from[3][3], normal[3];
            for (size_t n = 0; n < 3; n++) vec3_sub(c->positions_ws + 3 * (size_t)c->indices[3 * t + n], c->boxes[k].min, from[n]);
            vec3_cross(from[1], from[2], normal);
            volumes[k] += vec3_dot(from[0], normal);
        }

        closed.solid_triangle_count = take_sheets(&closed, c, volumes, 1, c->solid_triangle_count);
        take_sheets(&closed, c, volumes, 0, closed.solid_triangle_count);
    }
    free(volumes);
    if (!ok) r = fail(m, VXS_E_MEMORY, "out of memory for an estimate of --closed on");

    if (r == VXS_OK && c->runs) r = casters_find_runs(&closed, m);
    if (r == VXS_OK) r = consider(plan, o, &closed, saving, LEAST_SHARE_CLOSED, m);
    free(closed.runs);
    free(closed.indices);
    free(closed.double_sided);
    plan->plan_seconds += clock_seconds() - start;
    return r;
}

vxs_result plan_find_savings(bake_plan *plan, const bake_options *o, const casters *c, run_context *m)
{
    double       start  = clock_seconds();
    bake_options behind = *o, thick = *o;
    vxs_result   r         = VXS_OK;
    behind.behind          = BEHIND_FREE;
    thick.thickness_metres = THICKNESS_METRES;
    if (o->maps != MAPS_SPARSE || c->solid_triangle_count == c->triangle_count) return r;
    if (o->behind != BEHIND_FREE) r = consider(plan, &behind, c, (plan_saving){.option = "--behind free"}, LEAST_SHARE_SAVED, m);
    if (r == VXS_OK && !(o->thickness_metres > 0))
        r = consider(plan, &thick, c, (plan_saving){.option = "--thickness 0.02"}, LEAST_SHARE_SAVED, m);
    plan->plan_seconds += clock_seconds() - start;
    return r;
}
