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
 * Voxels are those of the map that the lookup goes to, and rays are traced in the world. A place beyond the side of a cube's map is
 * a place in the world like any other.
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
#include "baker/truth/baked_light.h"
#include "baker/truth/light_volume.h"
#include "runtime/vxs.h"

enum { POINTS_AT_A_TIME = 256, REACH = 2, TIMED_RUNS = 5, TIMED_RAYS_MAX = 100000, TRIES = 20 };

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
    light_volume           volume; /* that random points are drawn from */

    compare_kind kind;     /* of the pass in work */
    uint8_t     *verdicts; /* [options->points] */
    float       *errors;   /* [filter points] of the filtered lookup, signed; INFINITY: not compared */
} comparison;

typedef struct sample {
    double  point_ws[3];
    double  normal_ws[3];
    double *normal;      /* normal_ws, or NULL for a random point */
    int     map;         /* that is looked up */
    double  truth_ls[3]; /* where the truth is asked, in the map's coordinates */
    double  truth_ws[3];
} sample;

/* Bounds of all triangles, 5 % larger; a flat scene gets some height too. */
static void measure_box(const casters *c, double box_min_ws[3], double box_max_ws[3])
{
    double min[3] = {INFINITY, INFINITY, INFINITY}, max[3] = {-INFINITY, -INFINITY, -INFINITY}, extent[3];
    for (size_t n = 0; n < 3 * c->triangle_count; n++)
        for (int i = 0; i < 3; i++) {
            double p = c->positions_ws[3 * (size_t)c->indices[n] + (size_t)i];
            min[i]   = fmin(min[i], p);
            max[i]   = fmax(max[i], p);
        }
    vec3_sub(max, min, extent);
    double diagonal = sqrt(vec3_dot(extent, extent));
    for (int i = 0; i < 3; i++) {
        double margin = fmax(0.025 * extent[i], 0.01 * diagonal);
        box_min_ws[i] = min[i] - margin;
        box_max_ws[i] = max[i] + margin;
    }
}

/* points ---------------------------------------------------------------------------------------------- */

static double uniform(rng *r)
{
    return ldexp((double)rng_u32(r), -32);
}

static int random_sample(const comparison *c, rng *r, sample *s)
{
    int32_t voxel[3];
    if (!light_volume_draw(&c->volume, r, s->point_ws)) return 0;
    s->normal = NULL;
    s->map    = vxs_voxel(c->light, s->point_ws, NULL, 1, voxel);
    baked_light_coordinates(c->light, s->map, s->point_ws, s->truth_ls);
    memcpy(s->truth_ws, s->point_ws, sizeof s->truth_ws);
    return 1;
}

/* Move the truth by what a lookup with this normal is moved by: whole voxels. Asking both from one place leaves the error of the map,
 * and keeps out how far the bias had to be rounded. */
static void move_with_bias(const comparison *c, uint32_t filter_px, sample *s)
{
    int32_t at[3], biased[3];
    vxs_voxel(c->light, s->point_ws, NULL, (int)filter_px, at);
    vxs_voxel(c->light, s->point_ws, s->normal_ws, (int)filter_px, biased);
    baked_light_coordinates(c->light, s->map, s->point_ws, s->truth_ls);
    for (int i = 0; i < 3; i++) s->truth_ls[i] += biased[i] - at[i];
    vxs_point(c->light, s->map, s->truth_ls, s->truth_ws);
}

/* A sheet is seen from both sides; a solid from outside. Returns 0 when the light does not reach the point. */
static int finish_surface_sample(const comparison *c, uint32_t filter_px, uint32_t triangle, rng *r, sample *s)
{
    int32_t voxel[3];
    int     flip = triangle >= c->casters->solid_triangle_count && rng_below(r, 2);
    for (int i = 0; i < 3 && flip; i++) s->normal_ws[i] = -s->normal_ws[i];
    s->normal = s->normal_ws;
    s->map    = vxs_voxel(c->light, s->point_ws, s->normal_ws, (int)filter_px, voxel);
    if (s->map < 0) return 0;
    move_with_bias(c, filter_px, s);
    return 1;
}

static int sample_by_area(const comparison *c, uint32_t filter_px, rng *r, sample *s)
{
    double   uniforms[3] = {uniform(r), uniform(r), uniform(r)};
    uint32_t triangle;
    return truth_sample_surface(c->truth, uniforms, s->point_ws, s->normal_ws, &triangle) &&
           finish_surface_sample(c, filter_px, triangle, r, s);
}

/* Whatever lies behind a random point of the light's volume. */
static int sample_along_light(const comparison *c, uint32_t filter_px, rng *r, sample *s)
{
    double   from_ws[3], way_ws[3], distance;
    uint32_t triangle;
    if (!light_volume_draw(&c->volume, r, from_ws)) return 0;
    vec3_sub(from_ws, c->shape.position_ws, way_ws);
    if (!vec3_unit(way_ws, way_ws)) return 0;
    if (!truth_first_hit(c->truth, from_ws, way_ws, &distance, s->normal_ws, &triangle)) return 0;
    vec3_mad(from_ws, distance, way_ws, s->point_ws);
    return finish_surface_sample(c, filter_px, triangle, r, s);
}

/* A spot may reach little of what there is: look elsewhere, and at last where it shines. */
static int surface_sample(const comparison *c, uint32_t filter_px, rng *r, sample *s)
{
    if (c->light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return sample_by_area(c, filter_px, r, s);
    int found = 0;
    for (int n = 0; n < TRIES && !found; n++) found = sample_by_area(c, filter_px, r, s);
    for (int n = 0; n < TRIES && !found; n++) found = sample_along_light(c, filter_px, r, s);
    return found;
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

static int lit_at(const comparison *c, int map, double u, double v, double depth)
{
    double p[3];
    vxs_point(c->light, map, (double[3]){u, v, depth}, p);
    return truth_lit(c->truth, p, &c->shape);
}

/* 1 when one of the rays around a place of a map, REACH steps to each side, has this answer. Steps of depth are whole voxels. */
static int answered_about(const comparison *c, int map, const double at[3], double texel_step, int lit)
{
    for (int k = -REACH; k <= REACH; k++)
        for (int j = -REACH; j <= REACH; j++)
            for (int i = -REACH; i <= REACH; i++)
                if (lit_at(c, map, at[0] + texel_step * i, at[1] + texel_step * j, at[2] + k) == lit) return 1;
    return 0;
}

/* 1 when a caster crosses the light's way to a place of a map, REACH voxels before it to as many behind. */
static int surface_along(const comparison *c, int map, const double at[3])
{
    double begin_ws[3], end_ws[3], way_ws[3], distance;
    vxs_point(c->light, map, (double[3]){at[0], at[1], at[2] - REACH}, begin_ws);
    vxs_point(c->light, map, (double[3]){at[0], at[1], at[2] + REACH}, end_ws);
    vec3_sub(end_ws, begin_ws, way_ws);
    double length = sqrt(vec3_dot(way_ws, way_ws));
    return vec3_unit(way_ws, way_ws) && truth_first_hit(c->truth, begin_ws, way_ws, &distance, NULL, NULL) && distance <= length;
}

static int near_surface(const comparison *c, const sample *s, const double middle[3])
{
    double reach = REACH * baked_light_texel_m(c->light, s->map, s->truth_ws);
    if (truth_distance(c->truth, s->truth_ws, 2 * reach) <= reach) return 1;

    /* a sun's voxel is as deep as its texel is wide; a narrow spot's is many times deeper, and one that holds a surface is free */
    return c->shape.kind != LIGHT_DIRECTIONAL && (surface_along(c, s->map, middle) || surface_along(c, s->map, s->truth_ls));
}

static verdict explain(const comparison *c, const sample *s, int asset_lit)
{
    int32_t voxel[3];
    vxs_voxel(c->light, s->point_ws, s->normal, 1, voxel);
    const double middle[3] = {voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5};
    if (answered_about(c, s->map, middle, SNAP, asset_lit)) return VERDICT_NEAR_BOUNDARY;
    if (answered_about(c, s->map, s->truth_ls, 1, asset_lit)) return VERDICT_NEAR_BOUNDARY;
    return near_surface(c, s, middle) ? VERDICT_NEAR_SURFACE : VERDICT_UNEXPLAINED;
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
    e->map = vxs_voxel(c->light, s.point_ws, s.normal, 1, e->voxel);
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
static double filtered_truth(const comparison *c, int map, const int32_t voxel[3])
{
    int half = (int)c->options->filter_px / 2, lit = 0;
    for (int j = -half; j <= half; j++)
        for (int i = -half; i <= half; i++) lit += lit_at(c, map, voxel[0] + i + 0.5, voxel[1] + j + 0.5, voxel[2] + 0.5);
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
    return (float)(lookup - filtered_truth(c, s.map, voxel));
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
    comparison work     = {.truth = t, .casters = c, .light = light, .shape = baked_light_shape(light), .options = o};
    vxs_result r        = VXS_OK;
    double     box_min_ws[3], box_max_ws[3];
    memset(out, 0, sizeof *out);
    measure_box(c, box_min_ws, box_max_ws);
    light_volume_init(&work.volume, light, box_min_ws, box_max_ws);

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
