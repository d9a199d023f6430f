/* A baked light against the ray-traced truth; see compare.h.
 *
 * A pass over all points of a kind writes one verdict for each. Counts and examples are taken from the verdicts in order. Then the
 * distance of wrong answers from a boundary is measured.
 *
 * A voxel follows the ray through the centre of its texel: it is lit before casters, in shadow behind them, and either where that
 * ray is inside a solid or meets a surface. So a wrong answer has one of two explanations, or it is a fault:
 *
 *        u ->      +-----+-----+-----+        p  the point    c  the ray through the centre of the texel that was looked up
 *      depth       |     |  c p|/////|
 *        |         +-----+--c--+/////+        near a boundary: where c is in the voxel, the truth agrees with the asset
 *        v         |     |  c /|/////|        near a surface: c is inside a solid there, or meets a surface
 *                  +-----+--c--+-----+
 *
 * A rasterizer moves edges a little, and depths and rays are rounded. So rays are tried around the centre, and voxels count as
 * somewhat deeper. Rays are traced in the world, so places beyond the side of a cube's map need no special case.
 *
 * Source: [CPVS16] 5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/spread.h"
#include "baker/base/vec3.h"
#include "baker/lab/compare/compare_points.h"
#include "baker/lab/truth/truth.h"
#include "baker/light/map_space.h"
#include "runtime/vxs.h"

/* time of lookups and rays, on one thread -------------------------------------------------------------------------------------- */

enum { TIMED_RUNS = 5, TIMED_RAYS_MAX = 100000 };

typedef struct timed {
    const comparison *comparison;
    double           *points_ws; /* [3 * count] */
    float            *lit;       /* [count] */
    size_t            count;
    vxs_filter        filter;
} timed;

/* Seconds for one point, of lookups or of rays: the median of some runs. */
static double time_runs(timed *t, int is_rays)
{
    const comparison *c = t->comparison;
    double            seconds[TIMED_RUNS];
    if (!t->count) return 0;
    for (int run = 0; run < TIMED_RUNS; run++) {
        double start = clock_seconds();
        if (!is_rays) vxs_lookup_many(c->baked, t->points_ws, NULL, t->count, t->filter, t->lit);
        for (size_t n = 0; n < t->count && is_rays; n++) t->lit[n] = (float)truth_lit(c->truth, t->points_ws + 3 * n, &c->shape);
        seconds[run] = clock_seconds() - start;
    }
    return spread_of(seconds, TIMED_RUNS).median / (double)t->count;
}

/* Measure the time of lookups, and of filtered ones. Only points within the map count: others cost nothing, and
 * would make the mean too low.
 * Returns VXS_OK or VXS_E_MEMORY. */
static vxs_result compare_measure_time(const comparison *c, compare_result *out, run_context *m)
{
    const compare_options *o     = c->options;
    size_t                 limit = o->points < COMPARE_TIMED_POINTS_MAX ? o->points : COMPARE_TIMED_POINTS_MAX;
    timed                  t     = {.comparison = c, .filter = vxs_box(1)};
    vxs_result             r     = VXS_OK;
    t.points_ws                  = malloc(3 * limit * sizeof *t.points_ws);
    t.lit                        = malloc(limit * sizeof *t.lit);
    if (!t.points_ws || !t.lit) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %zu points", limit);
        goto done;
    }
    sample s;
    for (size_t n = 0; n < limit; n++)
        if (compare_point(t.comparison, COMPARE_RANDOM, n, &s)) memcpy(t.points_ws + 3 * t.count++, s.point_ws, sizeof s.point_ws);
    out->time.points   = t.count;
    out->time.lookup_s = time_runs(&t, 0);
    for (uint32_t n = 0; n < o->filter_count; n++) {
        t.filter                 = o->filters[n];
        out->filters[n].lookup_s = time_runs(&t, 0);
    }
    if (t.count > TIMED_RAYS_MAX) t.count = TIMED_RAYS_MAX;
    out->time.truth_s = time_runs(&t, 1);
done:
    free(t.points_ws);
    free(t.lit);
    return r;
}

/* filtered lookups against filtered rays --------------------------------------------------------------------------------------- */

enum { FILTERED_AT_A_TIME = 64 };

typedef struct filter_pass {
    const comparison *comparison;
    compare_kind      kind;
    vxs_filter        filter;
    size_t            count;  /* points, spread evenly over all of the kind */
    float            *errors; /* [count] of the lookup, signed; INFINITY: not compared */
    uint8_t          *faults; /* [count] compare_fault */
} filter_pass;

/* Whether some tap is in a don't-care voxel. */
static int is_some_tap_free(const comparison *c, const filter_taps *taps)
{
    for (int n = 0; n < taps->count[0] * taps->count[1]; n++) {
        double u = taps->first[0] + n % taps->count[0] + 0.5, v = taps->first[1] + n / taps->count[0] + 0.5;
        if (compare_left_free(c, taps->map, u, v, taps->depth, taps->depth + 1)) return 1;
    }
    return 0;
}

static void filter_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    filter_pass      *f = user;
    const comparison *c = f->comparison;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        size_t index = (size_t)((uint64_t)n * compare_point_count(c, f->kind) / f->count);
        sample s;
        f->faults[n] = FAULT_NONE;
        f->errors[n] = INFINITY;
        if (!compare_point(c, f->kind, index, &s)) continue;
        float lookup = vxs_lookup(c->baked, s.point_ws, s.normal, f->filter);
        if (lookup < 0 || truth_inside_solid(c->truth, s.truth_ws)) continue;
        filter_taps taps = filter_taps_of(c->light, s.point_ws, s.normal, f->filter);
        if (compare_leaves_free(c) && is_some_tap_free(c, &taps)) continue;
        f->faults[n] = (uint8_t)compare_bias_fault(c, &s, f->filter, lookup, truth_lit(c->truth, s.truth_ws, &c->shape));
        f->errors[n] = (float)(lookup - truth_filtered(c->truth, c->light, &c->shape, &taps));
    }
}

/* Compare filtered lookups with the same filter over rays, for COMPARE_FILTER_POINTS_MAX points at most,
 * spread evenly over the points of the kind.
 * out  [out] written only when VXS_OK is returned.   Returns VXS_OK or VXS_E_MEMORY. */
static vxs_result compare_filtered(const comparison *c, compare_kind kind, vxs_filter filter, compare_error *out, run_context *m)
{
    size_t      all = compare_point_count(c, kind), count = all < COMPARE_FILTER_POINTS_MAX ? all : COMPARE_FILTER_POINTS_MAX;
    double      squares = 0;
    filter_pass f       = {c, kind, filter, count, malloc(count * sizeof(float)), malloc(count)};
    vxs_result  r       = VXS_OK;
    *out                = (compare_error){0};
    if (count && (!f.errors || !f.faults)) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %zu points", count);
        goto done;
    }
    parallel_for(c->options->threads, count, FILTERED_AT_A_TIME, filter_points, &f);
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

/* verdicts --------------------------------------------------------------------------------------------------------------------- */

enum { POINTS_AT_A_TIME = 256 };

/* The maximum error of depths, in voxels. */
#define DEPTH_SLACK 0.05

typedef enum verdict {
    VERDICT_OUTSIDE,
    VERDICT_INSIDE_SOLID,
    VERDICT_RIGHT,
    VERDICT_NEAR_BOUNDARY,
    VERDICT_NEAR_SURFACE,
    VERDICT_UNEXPLAINED,
    VERDICT_LEFT_FREE,
    VERDICT_CAUSE       = 7,  /* a mask for the above */
    VERDICT_LEAK        = 8,  /* flag for wrong answers: asset lit, truth in shadow */
    VERDICT_SELF_SHADOW = 16, /* and faults of the bias, as in compare_fault */
    VERDICT_DEEP_LEAK   = 32
} verdict;

typedef struct judgement {
    const comparison *comparison;
    compare_kind      kind;
    uint8_t          *verdicts; /* [compare_point_count] */
} judgement;

/* A voxel around the centre of its texel, and the distance by which rounding may have moved it. */
typedef struct centre {
    int    map;
    double u, v, near_vx, far_vx; /* near and far side, including the tolerance */
    double step_px;               /* distance between the places that are tried */
} centre;

/* 1 when the truth agrees at the near side of the voxel, in its middle, or at its far side. */
static int truth_agrees(const comparison *c, const centre *at, double u, double v, int lit)
{
    return compare_lit_at(c, at->map, u, v, at->near_vx) == lit ||
           compare_lit_at(c, at->map, u, v, 0.5 * (at->near_vx + at->far_vx)) == lit ||
           compare_lit_at(c, at->map, u, v, at->far_vx) == lit;
}

/* 1 when the voxel may be lit or in shadow: its middle is inside a solid, or a surface crosses it. */
static int is_free(const comparison *c, const centre *at, double u, double v, int unused)
{
    double begin_ws[3], middle_ws[3], end_ws[3], way_ws[3], distance;
    (void)unused;
    vxs_point(c->light, at->map, (double[3]){u, v, at->near_vx}, begin_ws);
    vxs_point(c->light, at->map, (double[3]){u, v, 0.5 * (at->near_vx + at->far_vx)}, middle_ws);
    vxs_point(c->light, at->map, (double[3]){u, v, at->far_vx}, end_ws);
    if (truth_inside_solid(c->truth, middle_ws)) return 1;
    vec3_sub(end_ws, begin_ws, way_ws);
    double length = sqrt(vec3_dot(way_ws, way_ws));
    return vec3_unit(way_ws, way_ws) && truth_first_hit(c->truth, begin_ws, way_ws, &distance, NULL, NULL) && distance <= length;
}

/* 1 when it holds at any place around the centre. */
static int holds_about(const comparison *c, const centre *at, int lit,
                       int (*holds)(const comparison *c, const centre *at, double u, double v, int lit))
{
    for (int j = -COMPARE_STEPS; j <= COMPARE_STEPS; j++)
        for (int i = -COMPARE_STEPS; i <= COMPARE_STEPS; i++)
            if (holds(c, at, at->u + at->step_px * i, at->v + at->step_px * j, lit)) return 1;
    return 0;
}

/* 1 when it is a don't-care voxel of the asset. */
static int is_left_free(const comparison *c, const centre *at, double u, double v, int unused)
{
    (void)unused;
    return compare_left_free(c, at->map, u, v, at->near_vx, at->far_vx);
}

/* Why a wrong answer is no fault, or VERDICT_UNEXPLAINED. */
static verdict explain(const comparison *c, const sample *s, int asset_lit)
{
    const vxs_light *l    = c->light;
    int32_t          last = ((int32_t)1 << l->levels) - 1, voxel[3];
    double           from_light_ws[3], metres = 1;
    vxs_voxel(l, s->point_ws, s->normal, vxs_box(1), voxel);
    if (voxel[2] > last) voxel[2] = last; /* clamp points beyond the map's far end */

    vec3_sub(s->truth_ws, c->shape.position_ws, from_light_ws);
    if (c->shape.kind != LIGHT_DIRECTIONAL) metres = sqrt(vec3_dot(from_light_ws, from_light_ws));
    double ray_metres = COMPARE_RAY_SLACK * truth_precision(c->truth);
    double depth_vx   = fmin(COMPARE_SLACK_MAX, DEPTH_SLACK + ray_metres / (metres * l->voxel_metres));
    double u = voxel[0] + 0.5, v = voxel[1] + 0.5, step_px = compare_step_px(c, s->map, u, v, voxel[2] + 0.5);
    centre at = {s->map, u, v, voxel[2] - depth_vx, voxel[2] + 1 + depth_vx, step_px};

    if (asset_lit && compare_leaves_free(c) && holds_about(c, &at, asset_lit, is_left_free)) return VERDICT_LEFT_FREE;
    if (holds_about(c, &at, asset_lit, truth_agrees)) return VERDICT_NEAR_BOUNDARY;
    return holds_about(c, &at, asset_lit, is_free) ? VERDICT_NEAR_SURFACE : VERDICT_UNEXPLAINED;
}

static void judge_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    judgement        *j = user;
    const comparison *c = j->comparison;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        uint8_t *found = &j->verdicts[n];
        sample   s;
        *found = VERDICT_OUTSIDE;
        if (!compare_point(c, j->kind, n, &s)) continue;
        float lookup    = vxs_lookup(c->baked, s.point_ws, s.normal, vxs_box(1));
        int   asset_lit = lookup > 0;
        if (lookup < 0) continue;
        *found = VERDICT_INSIDE_SOLID;
        if (truth_inside_solid(c->truth, s.truth_ws)) continue;
        *found = VERDICT_RIGHT;
        if (truth_lit(c->truth, s.truth_ws, &c->shape) == asset_lit) continue;
        *found = (uint8_t)explain(c, &s, asset_lit);
        if (*found == VERDICT_LEFT_FREE) continue;
        compare_fault fault = compare_bias_fault(c, &s, vxs_box(1), lookup, !asset_lit);
        *found |= (asset_lit ? VERDICT_LEAK : 0) | (fault == FAULT_SELF_SHADOW ? VERDICT_SELF_SHADOW : 0) |
                  (fault == FAULT_DEEP_LEAK ? VERDICT_DEEP_LEAK : 0);
    }
}

/* counts ----------------------------------------------------------------------------------------------------------------------- */

static int is_wrong(uint8_t v)
{
    int cause = v & VERDICT_CAUSE;
    return cause > VERDICT_RIGHT && cause != VERDICT_LEFT_FREE;
}

static void add_example(const judgement *j, size_t index, compare_fault fault, int asset_lit, compare_result *out)
{
    if (out->example_count == COMPARE_EXAMPLES_MAX) return;
    compare_example *e = &out->examples[out->example_count++];
    sample           s;
    compare_point(j->comparison, j->kind, index, &s);
    *e = (compare_example){.fault = fault, .kind = j->kind, .asset_lit = asset_lit, .truth_lit = !asset_lit};
    memcpy(e->point_ws, s.point_ws, sizeof e->point_ws);
    if (s.normal) memcpy(e->normal_ws, s.normal, sizeof e->normal_ws);
    e->map = vxs_voxel(j->comparison->light, s.point_ws, s.normal, vxs_box(1), e->voxel);
}

uint64_t compare_wrong(const compare_counts *n)
{
    return n->leaks + n->false_shadows;
}

static vxs_result compare_points_of_kind(const comparison *c, compare_kind kind, compare_result *out, run_context *m)
{
    const compare_options *o     = c->options;
    size_t                 count = compare_point_count(c, kind);
    judgement              j     = {c, kind, malloc(count)};
    if (count && !j.verdicts) return fail(m, VXS_E_MEMORY, "out of memory for %zu points", count);
    parallel_for(o->threads, count, POINTS_AT_A_TIME, judge_points, &j);

    compare_counts *counts = &out->counts[kind];
    counts->points         = count;
    for (size_t i = 0; i < count; i++) {
        int cause = j.verdicts[i] & VERDICT_CAUSE, leak = (j.verdicts[i] & VERDICT_LEAK) != 0;
        counts->outside += cause == VERDICT_OUTSIDE;
        counts->inside_solid += cause == VERDICT_INSIDE_SOLID;
        counts->left_free += cause == VERDICT_LEFT_FREE;
        counts->checked += cause >= VERDICT_RIGHT && cause != VERDICT_LEFT_FREE;
        counts->leaks += leak;
        counts->false_shadows += is_wrong(j.verdicts[i]) && !leak;
        counts->near_boundary += cause == VERDICT_NEAR_BOUNDARY;
        counts->near_surface += cause == VERDICT_NEAR_SURFACE;
        counts->unexplained += cause == VERDICT_UNEXPLAINED;
        counts->bias.self_shadows += (j.verdicts[i] & VERDICT_SELF_SHADOW) != 0;
        counts->bias.deep_leaks += (j.verdicts[i] & VERDICT_DEEP_LEAK) != 0;
        if (cause == VERDICT_UNEXPLAINED) add_example(&j, i, FAULT_UNEXPLAINED, leak, out);
        if (j.verdicts[i] & VERDICT_SELF_SHADOW) add_example(&j, i, FAULT_SELF_SHADOW, leak, out);
        if (j.verdicts[i] & VERDICT_DEEP_LEAK) add_example(&j, i, FAULT_DEEP_LEAK, leak, out);
    }

    size_t        wrong = compare_wrong(counts), collected = 0;
    wrong_answer *answers = malloc((wrong + 1) * sizeof *answers);
    vxs_result    r       = answers ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for %zu wrong answers", wrong);
    for (size_t i = 0; i < count && answers; i++)
        if (is_wrong(j.verdicts[i])) answers[collected++] = (wrong_answer){i, (j.verdicts[i] & VERDICT_LEAK) != 0, 0};
    if (collected) counts->boundary = compare_boundary(c, kind, answers, collected);
    free(answers);

    for (uint32_t n = 0; n < o->filter_count && r == VXS_OK; n++)
        r = compare_filtered(c, kind, o->filters[n], &out->filters[n].error[kind], m);
    free(j.verdicts);
    return r;
}

vxs_result compare_light(compare_result *out, const truth *t, const casters *c, const vxs_baked_light *light,
                         const compare_dont_care *dont_care, const compare_options *o, run_context *m)
{
    comparison work;
    vxs_result r = VXS_OK;
    memset(out, 0, sizeof *out);
    comparison_init(&work, t, c, light, o);
    work.dont_care = *dont_care;
    for (int kind = 0; kind < COMPARE_KINDS && r == VXS_OK; kind++) r = compare_points_of_kind(&work, (compare_kind)kind, out, m);
    return r == VXS_OK ? compare_measure_time(&work, out, m) : r;
}
