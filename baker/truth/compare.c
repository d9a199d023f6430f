/* A baked light against the ray-traced truth; see compare.h.
 *
 * Points are made from (seed, kind, index), so none is stored and every thread makes its own. A pass over all of them
 * writes one verdict each; counts and examples are taken from the verdicts in order.
 *
 * A lookup with a normal is moved off the surface by whole voxels, and the truth is asked there: that judges the map. The
 * answer is also held against a ray from the surface, which judges map and bias together; it is counted apart.
 *
 * Single taps: the asset samples the truth at texel centres and whole voxels. So an honest wrong answer has a point nearby
 * where it would be right, and the search for one looks where the asset looked:
 *
 *        u ->      +-----+-----+-----+-----+-----+
 *      depth       |  .  |  .  |  .  |  .  |  .  |      p  the point;   .  rays about it, two voxels to each side
 *        |         |     |     |     |     |  :  |      :  rays through the centre of the texel looked up
 *        v         |  .  |  .  | p.  |  .  | .:  |
 *                  |     |     |     |     |  :  |
 *
 * Source: [CPVS16] 5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/truth/compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "runtime/vxs.h"

enum { POINTS_AT_A_TIME = 256, REACH = 2, TIMED_RUNS = 5, TIMED_RAYS_MAX = 100000, TRIES = 100 };

/* A rasterizer may move an edge by half of this, and its corner by as much again: in texels. */
#define SNAP (1.0 / 256)

typedef enum verdict {
    VERDICT_OUTSIDE,
    VERDICT_INSIDE_SOLID,
    VERDICT_RIGHT,
    VERDICT_NEAR_BOUNDARY,
    VERDICT_NEAR_SURFACE,
    VERDICT_UNEXPLAINED,
    VERDICT_CAUSE            = 7,  /* a mask for the above */
    VERDICT_LEAK             = 8,  /* a flag for the wrong ones: asset lit, truth shadow */
    VERDICT_AT_SURFACE       = 16, /* flags for surface points: checked there, */
    VERDICT_WRONG_AT_SURFACE = 32  /* and wrong */
} verdict;

typedef struct comparison {
    const truth           *truth;
    const casters         *casters;
    const vxs_light       *light;
    light_shape            shape; /* of the light, for the truth */
    const compare_options *options;
    double                 box_min_ws[3], box_max_ws[3];
    double                 ws_from_ls[12];
    int                    from_map; /* random points are drawn in the map, not the box */

    compare_kind kind;     /* of the pass in work */
    uint8_t     *verdicts; /* [options->points] */
    float       *errors;   /* [filter points] of the filtered lookup, signed; INFINITY: not compared */
} comparison;

typedef struct sample {
    double  point_ws[3];
    double  normal_ws[3];
    double *normal;      /* normal_ws, or NULL for a random point */
    double  truth_ws[3]; /* where the truth is asked */
} sample;

/* geometry -------------------------------------------------------------------------------------------- */

static void transform(const double m[12], const double p[3], double out[3])
{
    for (int row = 0; row < 3; row++) out[row] = vec3_dot(m + 4 * row, p) + m[4 * row + 3];
}

/* The inverse of a 3 x 4 matrix whose rows are linearly independent, by cofactors. */
static void invert(const double m[12], double out[12])
{
    double cofactors[3][3];
    for (int row = 0; row < 3; row++) vec3_cross(m + 4 * ((row + 1) % 3), m + 4 * ((row + 2) % 3), cofactors[row]);
    double determinant = vec3_dot(m, cofactors[0]);
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3; k++) out[4 * row + k] = cofactors[k][row] / determinant;
        out[4 * row + 3] = -(out[4 * row] * m[3] + out[4 * row + 1] * m[7] + out[4 * row + 2] * m[11]);
    }
}

/* Bounds of all triangles, 5 % larger; a flat scene gets some height too. */
static void measure_box(comparison *c)
{
    double min[3] = {INFINITY, INFINITY, INFINITY}, max[3] = {-INFINITY, -INFINITY, -INFINITY}, extent[3];
    for (size_t n = 0; n < 3 * c->casters->triangle_count; n++)
        for (int i = 0; i < 3; i++) {
            double p = c->casters->positions_ws[3 * (size_t)c->casters->indices[n] + (size_t)i];
            min[i]   = fmin(min[i], p);
            max[i]   = fmax(max[i], p);
        }
    vec3_sub(max, min, extent);
    double diagonal = sqrt(vec3_dot(extent, extent));
    for (int i = 0; i < 3; i++) {
        double margin    = fmax(0.025 * extent[i], 0.01 * diagonal);
        c->box_min_ws[i] = min[i] - margin;
        c->box_max_ws[i] = max[i] + margin;
    }
}

/* Random points lie both in the box and in the light's volume: draw in the smaller, leave out what is not in the other. A volume
 * that no region bounds has no end along the light, and was fitted to the casters. */
static void choose_where_to_draw(comparison *c)
{
    double axes[3][3], across[3], box = 1;
    for (int i = 0; i < 3; i++) {
        box *= c->box_max_ws[i] - c->box_min_ws[i];
        for (int k = 0; k < 3; k++) axes[k][i] = ldexp(c->ws_from_ls[4 * i + k], (int)c->light->levels);
    }
    vec3_cross(axes[0], axes[1], across);
    c->from_map = (c->light->flags & VXS_LIGHT_BOUNDED) && fabs(vec3_dot(across, axes[2])) < box;
}

/* points ---------------------------------------------------------------------------------------------- */

static double uniform(rng *r)
{
    return ldexp((double)rng_u32(r), -32);
}

static void draw_point(const comparison *c, rng *r, double point_ws[3])
{
    double u[3] = {uniform(r), uniform(r), uniform(r)}, p[3];
    for (int i = 0; i < 3; i++) p[i] = ldexp(u[i], (int)c->light->levels);
    if (c->from_map) transform(c->ws_from_ls, p, point_ws);
    for (int i = 0; i < 3 && !c->from_map; i++) point_ws[i] = c->box_min_ws[i] + u[i] * (c->box_max_ws[i] - c->box_min_ws[i]);
}

static int in_box(const comparison *c, const double point_ws[3])
{
    for (int i = 0; i < 3; i++)
        if (point_ws[i] < c->box_min_ws[i] || point_ws[i] > c->box_max_ws[i]) return 0;
    return 1;
}

static int random_sample(const comparison *c, rng *r, sample *s)
{
    int found = 0;
    s->normal = NULL;
    for (int n = 0; n < TRIES && !found; n++) {
        draw_point(c, r, s->point_ws);
        found = in_box(c, s->point_ws) && vxs_lookup(c->light, s->point_ws, NULL, 1) >= 0;
    }
    memcpy(s->truth_ws, s->point_ws, sizeof s->truth_ws);
    return found;
}

/* Move the truth by what a lookup with this normal is moved by: whole voxels. Asking both from one place leaves the error of the map,
 * and keeps out how far the bias had to be rounded. */
static void move_with_bias(const comparison *c, uint32_t filter_px, sample *s)
{
    int32_t at[3], biased[3];
    vxs_voxel(c->light, s->point_ws, NULL, (int)filter_px, at);
    vxs_voxel(c->light, s->point_ws, s->normal_ws, (int)filter_px, biased);
    for (int row = 0; row < 3; row++) {
        s->truth_ws[row] = s->point_ws[row];
        for (int k = 0; k < 3; k++) s->truth_ws[row] += c->ws_from_ls[4 * row + k] * (biased[k] - at[k]);
    }
}

/* A sheet is seen from both sides; a solid from outside. */
static int surface_sample(const comparison *c, uint32_t filter_px, rng *r, sample *s)
{
    double   uniforms[3] = {uniform(r), uniform(r), uniform(r)};
    uint32_t triangle;
    if (!truth_sample_surface(c->truth, uniforms, s->point_ws, s->normal_ws, &triangle)) return 0;
    int flip = triangle >= c->casters->solid_triangle_count && rng_below(r, 2);
    for (int i = 0; i < 3 && flip; i++) s->normal_ws[i] = -s->normal_ws[i];
    s->normal = s->normal_ws;
    move_with_bias(c, filter_px, s);
    return 1;
}

/* Point `index` of the kind in work. Returns 0 when there is none: casters without area, or outside the light's volume. */
static int make_sample(const comparison *c, size_t index, uint32_t filter_px, sample *s)
{
    rng kind = rng_split(c->options->seed, (uint64_t)c->kind);
    rng r    = rng_split(kind.state, index);
    if (c->kind == COMPARE_SURFACE) return surface_sample(c, filter_px, &r, s);
    return random_sample(c, &r, s);
}

/* single taps ----------------------------------------------------------------------------------------- */

static int lit_at_voxel(const comparison *c, double u, double v, double z)
{
    double p[3];
    transform(c->ws_from_ls, (double[3]){u, v, z}, p);
    return truth_lit(c->truth, p, &c->shape);
}

/* 1 when one of the rays around (u, v, z), REACH steps to each side, has this answer. Steps along z are whole voxels. */
static int answered_about(const comparison *c, double u, double v, double z, double texel_step, int lit)
{
    for (int k = -REACH; k <= REACH; k++)
        for (int j = -REACH; j <= REACH; j++)
            for (int i = -REACH; i <= REACH; i++)
                if (lit_at_voxel(c, u + texel_step * i, v + texel_step * j, z + k) == lit) return 1;
    return 0;
}

static verdict explain(const comparison *c, const sample *s, int asset_lit)
{
    double  p[3];
    int32_t voxel[3];
    vxs_voxel(c->light, s->point_ws, s->normal, 1, voxel);
    transform(c->light->ls_from_ws, s->truth_ws, p);
    if (answered_about(c, voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5, SNAP, asset_lit)) return VERDICT_NEAR_BOUNDARY;
    if (answered_about(c, p[0], p[1], p[2], 1, asset_lit)) return VERDICT_NEAR_BOUNDARY;

    /* a voxel is not flatter than a texel is wide: two texels away is within two voxels */
    double reach = REACH * c->light->texel_metres;
    return truth_distance(c->truth, s->truth_ws, 2 * reach) <= reach ? VERDICT_NEAR_SURFACE : VERDICT_UNEXPLAINED;
}

/* The answer against a ray from the surface itself. */
static uint8_t judge_at_surface(const comparison *c, const sample *s, int asset_lit)
{
    double p[3];
    truth_lift(c->truth, s->point_ws, s->normal, p);
    if (truth_inside_solid(c->truth, p)) return 0;
    int wrong = truth_lit(c->truth, p, &c->shape) != asset_lit;
    return VERDICT_AT_SURFACE | (wrong ? VERDICT_WRONG_AT_SURFACE : 0);
}

/* The answer against a ray from where it was looked up. */
static uint8_t judge_lookup(const comparison *c, const sample *s, int asset_lit)
{
    if (truth_inside_solid(c->truth, s->truth_ws)) return VERDICT_INSIDE_SOLID;
    if (truth_lit(c->truth, s->truth_ws, &c->shape) == asset_lit) return VERDICT_RIGHT;
    return (uint8_t)(explain(c, s, asset_lit) | (asset_lit ? VERDICT_LEAK : 0));
}

static uint8_t judge(const comparison *c, size_t index)
{
    sample s;
    if (!make_sample(c, index, 1, &s)) return VERDICT_OUTSIDE;
    float lookup = vxs_lookup(c->light, s.point_ws, s.normal, 1);
    if (lookup < 0) return VERDICT_OUTSIDE;
    return judge_lookup(c, &s, lookup > 0) | (s.normal ? judge_at_surface(c, &s, lookup > 0) : 0);
}

static void judge_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    comparison *c = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) c->verdicts[n] = judge(c, n);
}

static void add_example(const comparison *c, size_t index, int asset_lit, compare_result *out)
{
    if (out->example_count == COMPARE_EXAMPLES_MAX) return;
    compare_example *e = &out->examples[out->example_count++];
    sample           s;
    make_sample(c, index, 1, &s);
    *e = (compare_example){.kind = c->kind, .asset_lit = asset_lit, .truth_lit = !asset_lit};
    memcpy(e->point_ws, s.point_ws, sizeof e->point_ws);
    if (s.normal) memcpy(e->normal_ws, s.normal, sizeof e->normal_ws);
    vxs_voxel(c->light, s.point_ws, s.normal, 1, e->voxel);
}

static void count_verdicts(const comparison *c, compare_result *out)
{
    compare_counts *n = &out->counts[c->kind];
    n->points         = c->options->points;
    for (size_t i = 0; i < c->options->points; i++) {
        int cause = c->verdicts[i] & VERDICT_CAUSE, leak = (c->verdicts[i] & VERDICT_LEAK) != 0;
        n->outside += cause == VERDICT_OUTSIDE;
        n->inside_solid += cause == VERDICT_INSIDE_SOLID;
        n->checked += cause >= VERDICT_RIGHT;
        n->leaks += leak;
        n->false_shadows += cause > VERDICT_RIGHT && !leak;
        n->near_boundary += cause == VERDICT_NEAR_BOUNDARY;
        n->near_surface += cause == VERDICT_NEAR_SURFACE;
        n->unexplained += cause == VERDICT_UNEXPLAINED;
        n->checked_at_surface += (c->verdicts[i] & VERDICT_AT_SURFACE) != 0;
        n->wrong_at_surface += (c->verdicts[i] & VERDICT_WRONG_AT_SURFACE) != 0;
        if (cause == VERDICT_UNEXPLAINED) add_example(c, i, leak, out);
    }
}

uint64_t compare_wrong(const compare_counts *n)
{
    return n->leaks + n->false_shadows;
}

/* filters --------------------------------------------------------------------------------------------- */

/* The lookup's own box of texels, from rays through their centres, at the depth of its voxels' middle. */
static double filtered_truth(const comparison *c, const int32_t voxel[3])
{
    int half = (int)c->options->filter_px / 2, lit = 0;
    for (int j = -half; j <= half; j++)
        for (int i = -half; i <= half; i++) lit += lit_at_voxel(c, voxel[0] + i + 0.5, voxel[1] + j + 0.5, voxel[2] + 0.5);
    return (double)lit / (double)(c->options->filter_px * c->options->filter_px);
}

static float filter_error(const comparison *c, size_t index)
{
    sample  s;
    int32_t voxel[3];
    int     filter_px = (int)c->options->filter_px;
    if (!make_sample(c, index, c->options->filter_px, &s)) return INFINITY;
    float lookup = vxs_lookup(c->light, s.point_ws, s.normal, filter_px);
    if (lookup < 0 || truth_inside_solid(c->truth, s.truth_ws)) return INFINITY;
    vxs_voxel(c->light, s.point_ws, s.normal, filter_px, voxel);
    return (float)(lookup - filtered_truth(c, voxel));
}

static void filter_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    comparison *c = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) c->errors[n] = filter_error(c, n);
}

static void compare_filtered(comparison *c, size_t count, compare_filter *out)
{
    double squares = 0;
    parallel_for(c->options->threads, count, POINTS_AT_A_TIME, filter_points, c);
    for (size_t n = 0; n < count; n++) {
        if (isinf(c->errors[n])) continue;
        out->points++;
        squares += (double)c->errors[n] * (double)c->errors[n];
        out->max_error = fmax(out->max_error, fabs((double)c->errors[n]));
    }
    if (out->points) out->rmse = sqrt(squares / (double)out->points);
}

/* time ------------------------------------------------------------------------------------------------ */

typedef struct timed {
    const comparison *comparison;
    double           *points_ws; /* [3 * count] */
    float            *lit;       /* [count] */
    size_t            count;
    int               filter_px;
} timed;

static void run_lookups(timed *t)
{
    vxs_lookup_many(t->comparison->light, t->points_ws, NULL, t->count, t->filter_px, t->lit);
}

static void run_rays(timed *t)
{
    const comparison *c = t->comparison;
    for (size_t n = 0; n < t->count; n++) t->lit[n] = (float)truth_lit(c->truth, t->points_ws + 3 * n, &c->shape);
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Seconds for one point: the median of some runs. */
static double time_runs(void (*run)(timed *t), timed *t)
{
    double seconds[TIMED_RUNS];
    if (!t->count) return 0;
    for (int n = 0; n < TIMED_RUNS; n++) {
        double start = clock_seconds();
        run(t);
        seconds[n] = clock_seconds() - start;
    }
    qsort(seconds, TIMED_RUNS, sizeof *seconds, by_value);
    return seconds[TIMED_RUNS / 2] / (double)t->count;
}

/* Only points that the map reaches: others cost nothing, and would flatter. */
static void gather_timed_points(comparison *c, timed *t, size_t limit)
{
    sample s;
    c->kind = COMPARE_RANDOM;
    for (size_t n = 0; n < limit; n++)
        if (make_sample(c, n, 1, &s)) memcpy(t->points_ws + 3 * t->count++, s.point_ws, sizeof s.point_ws);
}

static vxs_result measure_time(comparison *c, compare_time *out, message *m)
{
    size_t     limit = c->options->points < COMPARE_TIMED_POINTS_MAX ? c->options->points : COMPARE_TIMED_POINTS_MAX;
    timed      t     = {.comparison = c, .filter_px = 1};
    vxs_result r     = VXS_OK;
    t.points_ws      = malloc(3 * limit * sizeof *t.points_ws);
    t.lit            = malloc(limit * sizeof *t.lit);
    if (!t.points_ws || !t.lit) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %zu points", limit);
        goto done;
    }
    gather_timed_points(c, &t, limit);
    out->points   = t.count;
    out->lookup_s = time_runs(run_lookups, &t);
    t.filter_px   = (int)c->options->filter_px;
    if (t.filter_px > 1) out->filter_s = time_runs(run_lookups, &t);
    if (t.count > TIMED_RAYS_MAX) t.count = TIMED_RAYS_MAX;
    out->truth_s = time_runs(run_rays, &t);
done:
    free(t.points_ws);
    free(t.lit);
    return r;
}

/* all of it ------------------------------------------------------------------------------------------- */

vxs_result compare_light(compare_result *out, const truth *t, const casters *c, const vxs_light *light, const compare_options *o,
                         message *m)
{
    size_t     filtered = o->points < COMPARE_FILTER_POINTS_MAX ? o->points : COMPARE_FILTER_POINTS_MAX;
    comparison work     = {.truth = t, .casters = c, .light = light, .options = o};
    vxs_result r        = VXS_OK;
    memcpy(work.shape.direction_ws, light->direction_ws, sizeof work.shape.direction_ws);
    memset(out, 0, sizeof *out);
    measure_box(&work);
    invert(light->ls_from_ws, work.ws_from_ls);
    choose_where_to_draw(&work);

    work.verdicts = malloc(o->points);
    work.errors   = malloc(filtered * sizeof *work.errors);
    if (!work.verdicts || !work.errors) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %u points", o->points);
        goto done;
    }
    for (int kind = 0; kind < COMPARE_KINDS; kind++) {
        work.kind = (compare_kind)kind;
        parallel_for(o->threads, o->points, POINTS_AT_A_TIME, judge_points, &work);
        count_verdicts(&work, out);
        if (o->filter_px > 1) compare_filtered(&work, filtered, &out->filter[kind]);
    }
    r = measure_time(&work, &out->time, m);
done:
    free(work.verdicts);
    free(work.errors);
    return r;
}
