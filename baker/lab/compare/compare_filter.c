/* Filtered lookups against filtered rays; see compare_points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/lab/truth/truth_filter.h"
#include "runtime/vxs.h"

enum { POINTS_AT_A_TIME = 64 };

typedef struct filter_pass {
    const comparison *comparison;
    compare_kind      kind;
    uint32_t          filter_px;
    size_t            count;  /* points, spread evenly over all of the kind */
    float            *errors; /* [count] of the lookup, signed; INFINITY: not compared */
    uint8_t          *faults; /* [count] compare_fault */
} filter_pass;

/* Whether some tap is in a don't-care voxel. */
static int is_left_free(const comparison *c, const filter_taps *taps)
{
    for (int n = 0; n < taps->count[0] * taps->count[1]; n++) {
        double u = taps->first[0] + n % taps->count[0] + 0.5, v = taps->first[1] + n / taps->count[0] + 0.5;
        if (compare_left_free(c, taps->map, u, v, taps->depth, taps->depth + 1)) return 1;
    }
    return 0;
}

static float filter_error(const filter_pass *f, size_t n, uint8_t *fault)
{
    const comparison *c     = f->comparison;
    size_t            index = (size_t)((uint64_t)n * compare_point_count(c, f->kind) / f->count);
    sample            s;
    int               filter_px = (int)f->filter_px;
    *fault                      = FAULT_NONE;
    if (!compare_point(c, f->kind, index, &s)) return INFINITY;
    float lookup = vxs_lookup(c->baked, s.point_ws, s.normal, filter_px);
    if (lookup < 0 || truth_inside_solid(c->truth, s.truth_ws)) return INFINITY;
    filter_taps taps = filter_taps_of(c->light, s.point_ws, s.normal, filter_px);
    if (compare_leaves_free(c) && is_left_free(c, &taps)) return INFINITY;
    *fault = (uint8_t)compare_bias_fault(c, &s, filter_px, lookup, truth_lit(c->truth, s.truth_ws, &c->shape));
    return (float)(lookup - truth_filtered(c->truth, c->light, &c->shape, &taps));
}

static void filter_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    filter_pass *f = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) f->errors[n] = filter_error(f, n, &f->faults[n]);
}

vxs_result compare_filtered(const comparison *c, compare_kind kind, uint32_t filter_px, compare_error *out, message *m)
{
    size_t      all = compare_point_count(c, kind), count = all < COMPARE_FILTER_POINTS_MAX ? all : COMPARE_FILTER_POINTS_MAX;
    double      squares = 0;
    filter_pass f       = {c, kind, filter_px, count, malloc(count * sizeof(float)), malloc(count)};
    vxs_result  r       = VXS_OK;
    *out                = (compare_error){0};
    if (count && (!f.errors || !f.faults)) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %zu points", count);
        goto done;
    }
    parallel_for(c->options->threads, count, POINTS_AT_A_TIME, filter_points, &f);
    for (size_t n = 0; n < count; n++) {
        if (isinf(f.errors[n])) continue;
        out->points++;
        squares += (double)f.errors[n] * (double)f.errors[n];
        out->max_error = fmax(out->max_error, fabs((double)f.errors[n]));
        out->bias.self_shadows += f.faults[n] == FAULT_SELF_SHADOW;
        out->bias.deep_leaks += f.faults[n] == FAULT_DEEP_LEAK;
    }
    if (out->points) out->rmse = sqrt(squares / (double)out->points);
done:
    free(f.errors);
    free(f.faults);
    return r;
}
