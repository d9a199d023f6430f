/* Faults of the bias of lookups on surfaces; see compare_points.h.
 *
 *      light      self-shadow: rays go to the light from the plane of the surface, one under each texel of the filter and of a
 *     | | | |     ring around it. If all of them reach the light, only the surface itself can have darkened the lookup.
 *     | |p| |
 *     ----------- deep leak: rays go to the light from each of these texels, from a depth before the point by more than the
 *     filter's
 *                 width. If none of them reaches the light, no bias may move the lookup into the light.
 *
 * Both ignore the effects of a bias near the edges of shadows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "baker/base/vec3.h"
#include "baker/lab/compare/compare_points.h"
#include "baker/lab/truth/truth_filter.h"
#include "runtime/vxs.h"

/* Height of a ray's origin above the plane, in truth_precision: above its own surface, and below everything on top of it. */
enum { LIFT = 4 };

/* The deepest bias: about two voxels, rounded up. */
#define BIAS_VOXELS 3

/* The point just above a surface's plane on the light's ray through texel coordinates; at the far end of the map if the ray
 * misses the plane. */
static void plane_point(const comparison *c, const sample *s, double u, double v, double out_ws[3])
{
    double near_ws[3], far_ws[3], way_ws[3], to_plane_ws[3], side = ldexp(1, (int)c->light->levels);
    vxs_point(c->light, s->map, (double[3]){u, v, 0}, near_ws);
    vxs_point(c->light, s->map, (double[3]){u, v, side}, far_ws);
    vec3_sub(far_ws, near_ws, way_ws);
    vec3_sub(s->point_ws, near_ws, to_plane_ws);
    double sinks = vec3_dot(way_ws, s->normal_ws), depth = vec3_dot(to_plane_ws, s->normal_ws);
    vec3_mad(near_ws, sinks < 0 ? depth / sinks : 1, way_ws, out_ws);
    vec3_mad(out_ws, LIFT * truth_precision(c->truth), s->normal_ws, out_ws);
}

/* Rays around the centre of a texel. */
static int all_arrive(const comparison *c, const sample *s, double u, double v, double step_px)
{
    for (int n = 0; n < (2 * COMPARE_STEPS + 1) * (2 * COMPARE_STEPS + 1); n++) {
        double p[3];
        int    i = n % (2 * COMPARE_STEPS + 1) - COMPARE_STEPS, j = n / (2 * COMPARE_STEPS + 1) - COMPARE_STEPS;
        plane_point(c, s, u + step_px * i, v + step_px * j, p);
        if (!truth_lit(c->truth, p, &c->shape)) return 0;
    }
    return 1;
}

static int is_unobstructed(const comparison *c, const sample *s, const filter_taps *taps)
{
    double middle[2], step_px;
    for (int axis = 0; axis < 2; axis++) middle[axis] = taps->first[axis] + 0.5 * taps->count[axis];
    step_px = compare_step_px(c, s->map, middle[0], middle[1], taps->depth);
    for (int j = -1; j <= taps->count[1]; j++)
        for (int i = -1; i <= taps->count[0]; i++)
            if (!all_arrive(c, s, taps->first[0] + i + 0.5, taps->first[1] + j + 0.5, step_px)) return 0;
    return 1;
}

/* Beside the map of a directional light, the file is always lit, whatever the truth is. */
static int leaves_map(const comparison *c, const filter_taps *taps)
{
    int32_t side = (int32_t)1 << c->light->levels;
    return taps->first[0] < 0 || taps->first[1] < 0 || taps->first[0] + taps->count[0] > side ||
           taps->first[1] + taps->count[1] > side;
}

static int is_deep_in_shadow(const comparison *c, const sample *s, const filter_taps *taps)
{
    if (leaves_map(c, taps)) return 0;
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

/* Whether the light is on the outer side of the surface. */
static int faces_light(const comparison *c, const sample *s)
{
    double to_light_ws[3];
    for (int n = 0; n < 3; n++) to_light_ws[n] = -c->shape.direction_ws[n];
    if (c->shape.kind != LIGHT_DIRECTIONAL) vec3_sub(c->shape.position_ws, s->point_ws, to_light_ws);
    return vec3_dot(to_light_ws, s->normal_ws) > 0;
}

compare_fault compare_bias_fault(const comparison *c, const sample *s, int filter_px, float lookup, int lit)
{
    if (!s->normal || (lit ? lookup >= 1 || !faces_light(c, s) : lookup <= 0)) return FAULT_NONE;
    filter_taps taps = filter_taps_of(c->light, s->point_ws, s->normal, filter_px);
    if (lit) return is_unobstructed(c, s, &taps) ? FAULT_SELF_SHADOW : FAULT_NONE;
    return is_deep_in_shadow(c, s, &taps) ? FAULT_DEEP_LEAK : FAULT_NONE;
}
