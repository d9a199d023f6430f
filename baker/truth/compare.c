/* A baked light against the ray-traced truth; see compare.h.
 *
 * A pass over all points of a kind writes one verdict each; counts and examples are taken from the verdicts in order. Then it is
 * measured how far the wrong ones are from a boundary (compare_boundary.h).
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

#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/truth/baked_light.h"
#include "baker/truth/compare_boundary.h"
#include "baker/truth/compare_filter.h"
#include "baker/truth/compare_points.h"
#include "baker/truth/compare_time.h"
#include "runtime/vxs.h"

enum { POINTS_AT_A_TIME = 256, REACH = 2 };

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
    VERDICT_AT_SURFACE       = 16, /* flags for points with a normal: checked at the surface, */
    VERDICT_WRONG_AT_SURFACE = 32  /* and wrong */
} verdict;

typedef struct judgement {
    const comparison *comparison;
    compare_kind      kind;
    uint8_t          *verdicts; /* [compare_point_count] */
} judgement;

/* 1 when one of the rays around a place of a map, REACH steps to each side, has this answer. Steps of depth are whole voxels. */
static int answered_about(const comparison *c, int map, const double at[3], double texel_step, int lit)
{
    for (int k = -REACH; k <= REACH; k++)
        for (int j = -REACH; j <= REACH; j++)
            for (int i = -REACH; i <= REACH; i++)
                if (compare_lit_at(c, map, at[0] + texel_step * i, at[1] + texel_step * j, at[2] + k) == lit) return 1;
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

static uint8_t judge(const judgement *j, size_t index)
{
    const comparison *c = j->comparison;
    sample            s;
    if (!compare_point(c, j->kind, index, 1, &s)) return VERDICT_OUTSIDE;
    float lookup = vxs_lookup(c->light, s.point_ws, s.normal, 1);
    if (lookup < 0) return VERDICT_OUTSIDE;
    return judge_lookup(c, &s, lookup > 0) | (s.normal ? judge_at_surface(c, &s, lookup > 0) : 0);
}

static void judge_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    judgement *j = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) j->verdicts[n] = judge(j, n);
}

/* counts ---------------------------------------------------------------------------------------------- */

static int is_wrong(uint8_t v)
{
    return (v & VERDICT_CAUSE) > VERDICT_RIGHT;
}

static void add_example(const judgement *j, size_t index, int asset_lit, compare_result *out)
{
    if (out->example_count == COMPARE_EXAMPLES_MAX) return;
    compare_example *e = &out->examples[out->example_count++];
    sample           s;
    compare_point(j->comparison, j->kind, index, 1, &s);
    *e = (compare_example){.kind = j->kind, .asset_lit = asset_lit, .truth_lit = !asset_lit};
    memcpy(e->point_ws, s.point_ws, sizeof e->point_ws);
    if (s.normal) memcpy(e->normal_ws, s.normal, sizeof e->normal_ws);
    e->map = vxs_voxel(j->comparison->light, s.point_ws, s.normal, 1, e->voxel);
}

static void count_verdicts(const judgement *j, compare_result *out)
{
    compare_counts *n = &out->counts[j->kind];
    n->points         = compare_point_count(j->comparison, j->kind);
    for (size_t i = 0; i < n->points; i++) {
        int cause = j->verdicts[i] & VERDICT_CAUSE, leak = (j->verdicts[i] & VERDICT_LEAK) != 0;
        n->outside += cause == VERDICT_OUTSIDE;
        n->inside_solid += cause == VERDICT_INSIDE_SOLID;
        n->checked += cause >= VERDICT_RIGHT;
        n->leaks += leak;
        n->false_shadows += is_wrong(j->verdicts[i]) && !leak;
        n->near_boundary += cause == VERDICT_NEAR_BOUNDARY;
        n->near_surface += cause == VERDICT_NEAR_SURFACE;
        n->unexplained += cause == VERDICT_UNEXPLAINED;
        n->checked_at_surface += (j->verdicts[i] & VERDICT_AT_SURFACE) != 0;
        n->wrong_at_surface += (j->verdicts[i] & VERDICT_WRONG_AT_SURFACE) != 0;
        if (cause == VERDICT_UNEXPLAINED) add_example(j, i, leak, out);
    }
}

uint64_t compare_wrong(const compare_counts *n)
{
    return n->leaks + n->false_shadows;
}

static vxs_result measure_distances(const judgement *j, compare_counts *n, message *m)
{
    size_t        count = 0, wrong = compare_wrong(n);
    wrong_answer *answers = wrong ? malloc(wrong * sizeof *answers) : NULL;
    if (!wrong) return VXS_OK;
    if (!answers) return fail(m, VXS_E_MEMORY, "out of memory for %zu wrong answers", wrong);
    for (size_t i = 0; i < n->points; i++)
        if (is_wrong(j->verdicts[i])) answers[count++] = (wrong_answer){i, (j->verdicts[i] & VERDICT_LEAK) != 0, 0};
    n->boundary = compare_boundary(j->comparison, j->kind, answers, count);
    free(answers);
    return VXS_OK;
}

/* all of it ------------------------------------------------------------------------------------------- */

static vxs_result compare_points_of_kind(const comparison *c, compare_kind kind, compare_result *out, message *m)
{
    const compare_options *o     = c->options;
    size_t                 count = compare_point_count(c, kind);
    judgement              j     = {c, kind, malloc(count)};
    if (count && !j.verdicts) return fail(m, VXS_E_MEMORY, "out of memory for %zu points", count);
    parallel_for(o->threads, count, POINTS_AT_A_TIME, judge_points, &j);
    count_verdicts(&j, out);
    vxs_result r = measure_distances(&j, &out->counts[kind], m);
    for (uint32_t n = 0; n < o->filter_count && r == VXS_OK; n++)
        r = compare_filtered(c, kind, o->filters_px[n], &out->filters[n].error[kind], m);
    free(j.verdicts);
    return r;
}

vxs_result compare_light(compare_result *out, const truth *t, const casters *c, const vxs_light *light, const compare_options *o,
                         message *m)
{
    comparison work;
    vxs_result r = VXS_OK;
    memset(out, 0, sizeof *out);
    comparison_init(&work, t, c, light, o);
    for (int kind = 0; kind < COMPARE_KINDS && r == VXS_OK; kind++) r = compare_points_of_kind(&work, (compare_kind)kind, out, m);
    return r == VXS_OK ? compare_measure_time(&work, out, m) : r;
}
