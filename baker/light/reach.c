/* Index of casters in reach of a light; see reach.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/vec3.h"
#include "baker/light/light_fit.h"

static reach_run run_of(const casters *c, size_t first, size_t end)
{
    box       around = box_empty();
    double    size[3];
    reach_run run;
    for (size_t n = 3 * first; n < 3 * end; n++) box_add(&around, c->positions_ws + 3 * (size_t)c->indices[n]);
    vec3_sub(around.max, around.min, size);
    vec3_mad(around.min, 0.5, size, run.center_ws);
    run.radius_m = 0.5 * sqrt(vec3_dot(size, size)) * (1 + 1e-9) + 1e-12;
    return run;
}

vxs_result reach_init(reach_index *x, const casters *c, message *m)
{
    x->run_count = (c->triangle_count + REACH_RUN - 1) / REACH_RUN;
    x->runs      = malloc((x->run_count + 1) * sizeof *x->runs);
    if (!x->runs) return fail(m, VXS_E_MEMORY, "out of memory for the reach of lights");
    for (size_t n = 0; n < x->run_count; n++) {
        size_t end = (n + 1) * REACH_RUN;
        x->runs[n] = run_of(c, n * REACH_RUN, end < c->triangle_count ? end : c->triangle_count);
    }
    return VXS_OK;
}

void reach_free(reach_index *x)
{
    free(x->runs);
    memset(x, 0, sizeof *x);
}

/* Slope of a cone around the whole map: its corners and its border, which is at most an eighth of the map's side at each side.
 * Rounded up a little. */
static double slope_around(const light_shape *light)
{
    return tan(light->outer_rad) * (4.0 / 3) * sqrt(2) * 1.02;
}

static int touches_cone(const reach_run *run, const light_shape *light, double slope)
{
    double from[3], across[3];
    vec3_sub(run->center_ws, light->position_ws, from);
    double along = vec3_dot(from, light->direction_ws);
    vec3_mad(from, -along, light->direction_ws, across);
    double beside = sqrt(vec3_dot(across, across)) - along * slope; /* distance from the axis minus the cone's radius */
    return along > -run->radius_m && beside <= run->radius_m * sqrt(1 + slope * slope);
}

/* arrays of the casters that are kept ------------------------------------------------------------------------------------------ */

typedef struct keeper {
    casters       *out;
    const casters *c;
    uint32_t      *slot; /* [c->vertex_count] 1 + vertex number in out; 0: not copied yet */
} keeper;

static uint32_t keep_vertex(keeper *k, uint32_t vertex)
{
    if (!k->slot[vertex]) {
        memcpy(k->out->positions_ws + 3 * k->out->vertex_count, k->c->positions_ws + 3 * (size_t)vertex, 3 * sizeof(double));
        k->slot[vertex] = (uint32_t)++k->out->vertex_count;
    }
    return k->slot[vertex] - 1;
}

static void keep_triangle(keeper *k, size_t t)
{
    casters       *out = k->out;
    const casters *c   = k->c;
    size_t         to  = out->triangle_count++;
    for (size_t n = 0; n < 3; n++) out->indices[3 * to + n] = keep_vertex(k, c->indices[3 * t + n]);
    if (t < c->solid_triangle_count && c->solid_meets) out->solid_meets[to] = c->solid_meets[t];
    if (t < c->solid_triangle_count) out->solid_triangle_count = to + 1;
    if (c->double_sided) out->double_sided[to] = c->double_sided[t];
    if (t < c->holed_first) {
        out->holed_first = to + 1;
        return;
    }
    memcpy(out->hole_uvs + 6 * (to - out->holed_first), c->hole_uvs + 6 * (t - c->holed_first), 6 * sizeof *c->hole_uvs);
    size_t mask = 0;
    while (t >= c->alpha_mask_first[mask + 1]) mask++;
    out->alpha_mask_first[mask + 1]++;
}

static void keep_runs(keeper *k, const uint8_t *kept, size_t run_count)
{
    for (size_t n = 0; n < run_count; n++)
        for (size_t t = n * REACH_RUN; t < (n + 1) * REACH_RUN && t < k->c->triangle_count && kept[n]; t++) keep_triangle(k, t);
    casters *out = k->out;
    if (!out->alpha_mask_first) return;
    /* prefix sums: counts of each mask become first indices */
    out->alpha_mask_first[0] = out->holed_first;
    for (size_t mask = 0; mask < out->alpha_mask_count; mask++) out->alpha_mask_first[mask + 1] += out->alpha_mask_first[mask];
}

static int allocate(keeper *k, size_t triangles)
{
    casters       *out    = k->out;
    const casters *c      = k->c;
    out->alpha_mask_count = c->alpha_mask_count;
    out->alpha_masks      = c->alpha_masks;
    out->images           = c->images;
    out->positions_ws     = malloc((9 * triangles + 1) * sizeof *out->positions_ws);
    out->indices          = malloc((3 * triangles + 1) * sizeof *out->indices);
    out->hole_uvs         = malloc((6 * triangles + 1) * sizeof *out->hole_uvs);
    out->alpha_mask_first = calloc(c->alpha_mask_count + 1, sizeof *out->alpha_mask_first);
    out->solid_meets      = c->solid_meets ? malloc(triangles + 1) : NULL;
    out->double_sided     = c->double_sided ? malloc(triangles + 1) : NULL;
    k->slot               = calloc(c->vertex_count + 1, sizeof *k->slot);
    return out->positions_ws && out->indices && out->hole_uvs && out->alpha_mask_first && k->slot &&
           (out->solid_meets || !c->solid_meets) && (out->double_sided || !c->double_sided);
}

vxs_result reach_casters(casters *out, const reach_index *x, const casters *c, const light_shape *light, message *m)
{
    *out = *c;
    if (light->kind != LIGHT_SPOT || light->outer_rad > LAMP_SPOT_MAX_RAD) return VXS_OK;
    uint8_t *kept  = malloc(x->run_count + 1);
    size_t   count = 0;
    double   slope = slope_around(light);
    keeper   k     = {.out = out, .c = c};
    int      ok    = kept != NULL;
    for (size_t n = 0; n < x->run_count && kept; n++) count += kept[n] = (uint8_t)touches_cone(&x->runs[n], light, slope);
    if (kept && count == x->run_count) goto done;

    memset(out, 0, sizeof *out);
    if ((ok = kept && allocate(&k, count * REACH_RUN))) keep_runs(&k, kept, x->run_count);
done:
    free(k.slot);
    free(kept);
    if (ok) return VXS_OK;
    reach_release(out, c);
    return fail(m, VXS_E_MEMORY, "out of memory for the casters that a light reaches");
}

void reach_release(casters *out, const casters *c)
{
    if (out->positions_ws != c->positions_ws) {
        free(out->positions_ws);
        free(out->indices);
        free(out->hole_uvs);
        free(out->alpha_mask_first);
        free(out->solid_meets);
        free(out->double_sided);
    }
    memset(out, 0, sizeof *out);
}
