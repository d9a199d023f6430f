/* Fit the maps of a spot or point light; see light_fit.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/light_fit.h"

#include <float.h>
#include <math.h>

#include "baker/base/integer.h"
#include "baker/base/vec3.h"
#include "baker/light/map_space.h"

/* Distances along the axes of the maps, metres. */
typedef struct reach {
    double near, far;
} reach;

static double segment_distance(const double a[3], const double b[3])
{
    double ab[3], nearest[3];
    vec3_sub(b, a, ab);
    double length2 = vec3_dot(ab, ab);
    double along   = length2 > 0 ? fmin(1, fmax(0, -vec3_dot(a, ab) / length2)) : 0;
    vec3_mad(a, along, ab, nearest);
    return sqrt(vec3_dot(nearest, nearest));
}

/* Sum over all corners, because clipping may produce duplicate corners. */
static void normal_of(const map_polygon *p, double normal[3])
{
    double ab[3], ac[3], part[3];
    for (int n = 0; n < 3; n++) normal[n] = 0;
    for (int n = 1; n + 1 < p->count; n++) {
        vec3_sub(p->corners[n].at, p->corners[0].at, ab);
        vec3_sub(p->corners[n + 1].at, p->corners[0].at, ac);
        vec3_cross(ab, ac, part);
        vec3_mad(normal, 1, part, normal);
    }
}

/* 1 when the light is in the plane of the triangle, up to rounding. Then the triangle covers no texel, and must not pull the near
 * plane to the light: for example, the ceiling around a recessed lamp. */
static int edge_on(const map_polygon *triangle)
{
    const double rounding = 1e-12;
    double       normal[3], farthest = 0;
    normal_of(triangle, normal);
    for (int n = 0; n < triangle->count; n++) farthest = fmax(farthest, vec3_dot(triangle->corners[n].at, triangle->corners[n].at));
    return fabs(vec3_dot(triangle->corners[0].at, normal)) <= rounding * sqrt(farthest * vec3_dot(normal, normal));
}

/* Distance from the light to a convex polygon: to its plane if the foot of the perpendicular is inside, else to the nearest
 * edge. */
static double polygon_distance(const map_polygon *p)
{
    double normal[3], side[3], nearest = INFINITY;
    normal_of(p, normal);
    int above = vec3_dot(normal, normal) > 0;
    for (int n = 0; n < p->count; n++) {
        const double *a = p->corners[n].at, *b = p->corners[(n + 1) % p->count].at;
        vec3_cross(a, b, side);
        above   = above && vec3_dot(side, normal) >= 0;
        nearest = fmin(nearest, segment_distance(a, b));
    }
    return above ? fabs(vec3_dot(p->corners[0].at, normal)) / sqrt(vec3_dot(normal, normal)) : nearest;
}

static void extend(reach *r, const map_polygon *p, double range_m)
{
    if (p->count < 3 || polygon_distance(p) > range_m) return;
    for (int n = 0; n < p->count; n++) {
        r->near = fmin(r->near, p->corners[n].at[2]);
        r->far  = fmax(r->far, fmin(p->corners[n].at[2], range_m));
    }
}

/* Near and far of the casters in the light's maps and range. far is 0 when there are none. */
static reach measure(const vxs_light *light, const casters *c, double range_m)
{
    reach     r    = {INFINITY, 0};
    int       maps = (int)vxs_map_count(light);
    map_sides s    = map_sides_of(light, 0);
    for (int map = 0; map < maps; map++) {
        map_frame frame = map_frame_of(light, map);
        for (size_t n = 0; n < c->triangle_count; n++) {
            map_polygon triangle = {.count = 3}, kept;
            for (int k = 0; k < 3; k++)
                map_space_from_ws(&frame, c->positions_ws + 3 * (size_t)c->indices[3 * n + k], triangle.corners[k].at);
            if (!map_sides_touch(&s, &triangle) || map_space_behind(light, map, &triangle) || edge_on(&triangle)) continue;
            map_sides_clip(&s, &triangle, &kept);
            extend(&r, &kept, range_m);
        }
    }
    return r;
}

/* Border texels at each side of the cone, or of a side of the cube. */
static uint32_t border_px(uint32_t side)
{
    return min_u32(LAMP_BORDER_PX, side / 8);
}

/* Width of a texel at one metre, when `side` texels cover the cone and its border. */
static double slope_of(double half_slope, uint32_t side)
{
    return half_slope / (side / 2.0 - border_px(side));
}

vxs_result lamp_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, double axes[3][3], message *m)
{
    const light_shape *shape = desc->shape;
    int                spot  = shape->kind == LIGHT_SPOT;
    int                cube  = !spot || shape->outer_rad > LAMP_SPOT_MAX_RAD;
    double             slope = cube ? 1 : tan(shape->outer_rad);
    uint32_t           side  = desc->resolution ? desc->resolution : 8;

    light->kind         = spot ? VXS_LIGHT_KIND_SPOT : VXS_LIGHT_KIND_POINT;
    light->flags        = cube ? VXS_LIGHT_CUBE : 0;
    light->range_metres = isfinite(shape->range_m) ? shape->range_m : 0;
    light->cos_outer    = spot ? fmax(0, cos(shape->outer_rad)) : 0;
    if (spot && !(light->cos_outer < 1 && slope > 0))
        return fail(m, VXS_E_ARGUMENT, "light '%s': a cone of %g degrees is too narrow for a map", desc->name,
                    shape->outer_rad * 2 * 180 / 3.14159265358979);
    for (int row = 0; row < 3; row++) {
        for (int n = 0; n < 3; n++) light->ls_from_ws[4 * row + n] = axes[row][n];
        light->ls_from_ws[4 * row + 3] = -vec3_dot(axes[row], shape->position_ws);
    }

    /* the visible casters depend on the resolution only through the border */
    light->levels       = log2_u32(side);
    light->texel_metres = slope_of(slope, side);
    light->near_metres  = DBL_MIN;
    reach r             = measure(light, c, shape->range_m);
    if (!(r.far > 0)) return VXS_E_NO_CASTER;
    if (!desc->resolution) {
        double px = 2 * slope * r.far / desc->texel_metres;
        while (side < desc->resolution_max && side - 2 * border_px(side) < px) side *= 2;
        if (side - 2 * border_px(side) < px)
            return fail(m, VXS_E_ARGUMENT,
                        "--texel %g: light '%s' is %g m wide where it ends, which needs more than %u texels; at least --texel "
                        "%s=%.3g",
                        desc->texel_metres, desc->name, 2 * slope * r.far, desc->resolution_max, desc->name,
                        1.005 * 2 * slope * r.far / (side - 2 * border_px(side)));
        light->levels       = log2_u32(side);
        light->texel_metres = slope_of(slope, side);
    }

    /* margins: one voxel in front of the casters and two behind, as for directional lights; a voxel is not thinner than a texel is
     * wide */
    double near         = fmax(r.near, r.far / LAMP_FAR_NEAR_MAX);
    light->voxel_metres = fmax(log(r.far / near) / (side - 3), light->texel_metres);
    light->near_metres  = near * exp(-light->voxel_metres);
    if (!(light->near_metres > 0) || !isfinite(r.far))
        return fail(m, VXS_E_ARGUMENT, "the casters lie %g to %g m from light '%s': no map can be fitted to them", r.near, r.far,
                    desc->name);
    return VXS_OK;
}
