/* How far a wrong answer is from a right one, what the bake left free, and faults of the bias; see compare_points.h.
 *
 * Boundary: probes go in 26 directions from the point where the truth was traced, in the coordinates of the map, where a texel and
 * a voxel's depth have the same length: as from the centre of a cube to its corners and to the centres of its edges and faces.
 *
 *        \ | /        In each direction the truth is traced at 1/2, 1, 1 1/2, 2, 3, 4, 6 and 8 texels. Where it first agrees
 *       -- p --       with the asset, the last step is halved six times. The result is the least distance of all directions. For
 *        / | \        a flat boundary it is at most 13 % too large; features thinner than a step may be missed. Insides of
 *                     solids are dark.
 *
 * Don't-care voxels: a ray is traced from the point p back to the light:
 *
 *     light ---------- s ======= L . . . . . p -----> nothing
 *
 * Behind the last surface: there is no surface beyond p; L is where light leaves the sheet, or the solids, that it meets first.
 * Within a sheet's thickness: L is such a sheet, it is the first surface, and p is not too far behind it.
 *
 * Bias, on surfaces; both tests ignore its effects near the edges of shadows:
 *
 *      light      self-shadow: rays go to the light from the plane of the surface, one under each texel of the filter and of a
 *     | | | |     ring around it. If all of them reach the light, only the surface itself can have darkened the lookup.
 *     | |p| |
 *     ----------- deep leak: rays go to the light from each of these texels, from a depth before the point by more than the
 *                 filter's width. If none of them reaches the light, no bias may move the lookup into the light.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/lab/truth/truth.h"
#include "runtime/vxs.h"

/* rounding --------------------------------------------------------------------------------------------------------------------- */

/* A rasterizer may move an edge by half of this, and its corner by the same amount: in texels. */
#define SNAP (1.0 / 256)

double compare_step_px(const comparison *c, int map, double u, double v, double depth)
{
    /* the error of rounded rays is largest in texels at the caster nearest to the light, on the way to the texel or to its
     * neighbours; for a directional light it is the same everywhere */
    static const double about[5][2]   = {{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    double              caster_metres = c->shape.kind == LIGHT_DIRECTIONAL ? 1 : INFINITY;
    for (int n = 0; n < 5 && c->shape.kind != LIGHT_DIRECTIONAL; n++) {
        double end_ws[3], way_ws[3], distance;
        vxs_point(c->light, map, (double[3]){u + about[n][0], v + about[n][1], depth}, end_ws);
        vec3_sub(end_ws, c->shape.position_ws, way_ws);
        if (vec3_unit(way_ws, way_ws) && truth_first_hit(c->truth, c->shape.position_ws, way_ws, &distance, NULL, NULL))
            caster_metres = fmin(caster_metres, distance);
    }
    double ray_metres = COMPARE_RAY_SLACK * truth_precision(c->truth);
    return fmin(COMPARE_SLACK_MAX, 2 * SNAP + ray_metres / (caster_metres * c->light->texel_metres)) / COMPARE_STEPS;
}

/* distance to a boundary ------------------------------------------------------------------------------------------------------- */

enum { ANSWERS_AT_A_TIME = 16, HALVINGS = 6 };

static const double steps[] = {0.5, 1, 1.5, 2, 3, 4, 6, 8};
enum { STEPS = sizeof steps / sizeof *steps };

typedef struct search {
    const comparison *comparison;
    compare_kind      kind;
    wrong_answer     *answers;
} search;

/* The truth at a distance from a point: `way` has the length of a texel. */
static int lit_along(const comparison *c, const sample *s, const double way[3], double texels)
{
    const double *at = s->truth_ls;
    return compare_lit_at(c, s->map, at[0] + texels * way[0], at[1] + texels * way[1], at[2] + texels * way[2]);
}

/* The nearest boundary between two steps, over all directions; INFINITY when there is none. */
static double nearest_between(const comparison *c, const sample *s, int lit, double from, double to)
{
    double nearest = INFINITY;
    for (int n = 0; n < 27; n++) {
        double way[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}, length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        if (length == 0) continue;
        for (int i = 0; i < 3; i++) way[i] /= length;
        if (lit_along(c, s, way, to) != lit) continue;
        double low = from, high = to; /* at `low` the truth differs from the asset, at `high` they agree */
        for (int i = 0; i < HALVINGS; i++) {
            double middle = 0.5 * (low + high);
            if (lit_along(c, s, way, middle) == lit)
                high = middle;
            else
                low = middle;
        }
        nearest = fmin(nearest, 0.5 * (low + high));
    }
    return nearest;
}

static void search_answers(void *user, size_t begin, size_t end, uint32_t worker)
{
    search *f = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        wrong_answer *a       = &f->answers[n];
        double        nearest = INFINITY;
        sample        s;
        compare_point(f->comparison, f->kind, a->index, &s);
        for (int k = 0; k < STEPS && isinf(nearest); k++)
            nearest = nearest_between(f->comparison, &s, a->asset_lit, k ? steps[k - 1] : 0, steps[k]);
        a->texels = (float)nearest;
    }
}

static int by_distance(const void *a, const void *b)
{
    float x = ((const wrong_answer *)a)->texels, y = ((const wrong_answer *)b)->texels;
    return (x > y) - (x < y);
}

/* The value below which this share of the answers is; [count] sorted, count > 0. */
static double quantile(const wrong_answer *answers, size_t count, double share)
{
    return (double)answers[(size_t)(share * (double)(count - 1) + 0.5)].texels;
}

compare_distance compare_boundary(const comparison *c, compare_kind kind, wrong_answer *answers, size_t count)
{
    search           f   = {c, kind, answers};
    compare_distance out = {0};
    double           sum = 0;
    parallel_for(c->options->threads, count, ANSWERS_AT_A_TIME, search_answers, &f);
    qsort(answers, count, sizeof *answers, by_distance);

    while (out.points < count && !isinf(answers[out.points].texels)) sum += (double)answers[out.points++].texels;
    out.beyond = count - out.points;
    if (!out.points) return out;
    out.mean   = sum / (double)out.points;
    out.median = quantile(answers, out.points, 0.5);
    out.p95    = quantile(answers, out.points, 0.95);
    out.max    = quantile(answers, out.points, 1);
    return out;
}

/* don't-care voxels ------------------------------------------------------------------------------------------------------------ */

enum { SURFACES_MAX = 1024 }; /* on one ray; places beyond them are never don't-care */

/* A surface on the way to the light. */
typedef struct met {
    double   distance; /* from the start of the search */
    double   normal_ws[3];
    uint32_t triangle;
} met;

/* The direction from a point to the light, and the distance. */
static int way_to_light(const comparison *c, const double p[3], double way_ws[3], double *distance)
{
    *distance = INFINITY;
    if (c->shape.kind == LIGHT_DIRECTIONAL) {
        for (int n = 0; n < 3; n++) way_ws[n] = -c->shape.direction_ws[n];
        return vec3_unit(way_ws, way_ws);
    }
    vec3_sub(c->shape.position_ws, p, way_ws);
    *distance = sqrt(vec3_dot(way_ws, way_ws));
    return vec3_unit(way_ws, way_ws);
}

static int meets(const comparison *c, const double from_ws[3], const double way_ws[3], double most, met *out)
{
    return truth_first_hit(c->truth, from_ws, way_ws, &out->distance, out->normal_ws, &out->triangle) && out->distance < most;
}

/* Move past a surface, by the least distance that rays resolve. Returns the distance from the start of the search. */
static double pass(const comparison *c, double p[3], const double way_ws[3], const met *s)
{
    double step = s->distance + 2 * truth_precision(c->truth);
    vec3_mad(p, step, way_ws, p);
    return step;
}

/* Whether no surface lies behind p, and the last one before p is where light leaves the first caster that it meets. Surfaces inside
 * solids are ignored. */
static int is_behind_last(const comparison *c, const double from_ws[3])
{
    double way_ws[3], away_ws[3], to_light, p[3] = {from_ws[0], from_ws[1], from_ws[2]};
    met    s;
    if (!way_to_light(c, p, way_ws, &to_light)) return 0;
    for (int n = 0; n < 3; n++) away_ws[n] = -way_ws[n];
    if (meets(c, p, away_ws, INFINITY, &s)) return 0;
    for (int n = 0; n < SURFACES_MAX && meets(c, p, way_ws, to_light, &s); n++) {
        to_light -= pass(c, p, way_ws, &s);
        if (!truth_inside_solid(c->truth, p)) return !meets(c, p, way_ws, to_light, &s);
    }
    return 0;
}

static int is_within_thickness(const comparison *c, const double from_ws[3], double depth_vx)
{
    const casters *all = c->casters;
    double         way_ws[3], to_light, p[3] = {from_ws[0], from_ws[1], from_ws[2]};
    met            s, before;
    if (!way_to_light(c, p, way_ws, &to_light) || !meets(c, p, way_ws, to_light, &s)) return 0;
    if (s.triangle < c->casters->solid_triangle_count || s.triangle >= all->holed_first) return 0;
    if (all->double_sided && all->double_sided[s.triangle]) return 0;
    if (vec3_dot(s.normal_ws, way_ws) <= 0) return 0;
    double deep = 1; /* metres along the axis of the map for each metre towards the light */
    if (c->shape.kind != LIGHT_DIRECTIONAL) deep = c->light->near_metres * exp(depth_vx * c->light->voxel_metres) / to_light;
    if (s.distance * deep > c->dont_care.thickness_metres) return 0;
    to_light -= pass(c, p, way_ws, &s);
    return !meets(c, p, way_ws, to_light, &before);
}

int compare_left_free(const comparison *c, int map, double u, double v, double near_vx, double far_vx)
{
    double near_ws[3], far_ws[3];
    vxs_point(c->light, map, (double[3]){u, v, near_vx}, near_ws);
    vxs_point(c->light, map, (double[3]){u, v, far_vx}, far_ws);
    return (c->dont_care.behind && is_behind_last(c, far_ws)) ||
           (c->dont_care.thickness_metres > 0 && is_within_thickness(c, near_ws, near_vx));
}

/* faults of the bias ----------------------------------------------------------------------------------------------------------- */

/* Height of a ray's origin above the plane, in truth_precision: above its own surface, and below everything on top of it. */
enum { LIFT = 4 };

/* The deepest bias: about two voxels, rounded up. */
#define BIAS_VOXELS 3

/* Whether rays around the centre of a texel reach the light. They begin just above the surface's plane, on the light's ray through
 * texel coordinates; at the far end of the map if that misses the plane. */
static int all_arrive(const comparison *c, const sample *s, double u, double v, double step_px)
{
    double side = ldexp(1, (int)c->light->levels);
    for (int n = 0; n < (2 * COMPARE_STEPS + 1) * (2 * COMPARE_STEPS + 1); n++) {
        double at_u = u + step_px * (n % (2 * COMPARE_STEPS + 1) - COMPARE_STEPS);
        double at_v = v + step_px * (n / (2 * COMPARE_STEPS + 1) - COMPARE_STEPS);
        double near_ws[3], far_ws[3], way_ws[3], to_plane_ws[3], p[3];
        vxs_point(c->light, s->map, (double[3]){at_u, at_v, 0}, near_ws);
        vxs_point(c->light, s->map, (double[3]){at_u, at_v, side}, far_ws);
        vec3_sub(far_ws, near_ws, way_ws);
        vec3_sub(s->point_ws, near_ws, to_plane_ws);
        double sinks = vec3_dot(way_ws, s->normal_ws), depth = vec3_dot(to_plane_ws, s->normal_ws);
        vec3_mad(near_ws, sinks < 0 ? depth / sinks : 1, way_ws, p);
        vec3_mad(p, LIFT * truth_precision(c->truth), s->normal_ws, p);
        if (!truth_lit(c->truth, p, &c->shape)) return 0;
    }
    return 1;
}

static int is_deep_in_shadow(const comparison *c, const sample *s, const filter_taps *taps)
{
    /* outside the map of a directional light, lookups are always lit */
    int32_t side = (int32_t)1 << c->light->levels;
    if (taps->first[0] < 0 || taps->first[1] < 0 || taps->first[0] + taps->count[0] > side ||
        taps->first[1] + taps->count[1] > side)
        return 0;

    double width_vx =
        (taps->count[0] > taps->count[1] ? taps->count[0] : taps->count[1]) * c->light->texel_metres / c->light->voxel_metres;
    double depth = s->truth_ls[2] - width_vx - BIAS_VOXELS;
    for (int j = -1; j <= taps->count[1]; j++)
        for (int i = -1; i <= taps->count[0]; i++) {
            double p[3];
            vxs_point(c->light, s->map, (double[3]){taps->first[0] + i + 0.5, taps->first[1] + j + 0.5, depth}, p);
            if (truth_lit(c->truth, p, &c->shape) || truth_inside_solid(c->truth, p)) return 0;
        }
    return 1;
}

compare_fault compare_bias_fault(const comparison *c, const sample *s, vxs_filter filter, float lookup, int lit)
{
    double to_light_ws[3];
    if (!s->normal || (lit ? lookup >= 1 : lookup <= 0)) return FAULT_NONE;
    for (int n = 0; n < 3; n++) to_light_ws[n] = -c->shape.direction_ws[n];
    if (c->shape.kind != LIGHT_DIRECTIONAL) vec3_sub(c->shape.position_ws, s->point_ws, to_light_ws);
    if (lit && vec3_dot(to_light_ws, s->normal_ws) <= 0) return FAULT_NONE; /* the surface faces away from the light */
    filter_taps taps = filter_taps_of(c->light, s->point_ws, s->normal, filter);
    if (!lit) return is_deep_in_shadow(c, s, &taps) ? FAULT_DEEP_LEAK : FAULT_NONE;

    double step_px =
        compare_step_px(c, s->map, taps.first[0] + 0.5 * taps.count[0], taps.first[1] + 0.5 * taps.count[1], taps.depth);
    for (int j = -1; j <= taps.count[1]; j++)
        for (int i = -1; i <= taps.count[0]; i++)
            if (!all_arrive(c, s, taps.first[0] + i + 0.5, taps.first[1] + j + 0.5, step_px)) return FAULT_NONE;
    return FAULT_SELF_SHADOW;
}
