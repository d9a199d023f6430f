/* Don't-care voxels of an asset; see compare_points.h.
 *
 * A ray is traced from the point back to the light:
 *
 *     light ---------- s ======= L . . . . . p -----> nothing
 *
 * Behind the last surface: there is no surface beyond p; L is where light leaves the sheet, or the solids, that it meets first.
 * Within a sheet's thickness: L is such a sheet, it is the first surface, and p is not too far behind it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <math.h>

#include "baker/base/vec3.h"
#include "runtime/vxs.h"

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

static int is_sheet(const comparison *c, const met *s)
{
    return s->triangle >= c->casters->solid_triangle_count;
}

/* Move past a surface, by the least distance that rays resolve. Returns the distance from the start of the search. */
static double pass(const comparison *c, double p[3], const double way_ws[3], const met *s)
{
    double step = s->distance + 2 * truth_precision(c->truth);
    vec3_mad(p, step, way_ws, p);
    return step;
}

/* Whether the last surface before p is where light leaves the first caster that it meets. Surfaces inside of solids are ignored. */
static int leaves_at_last(const comparison *c, const double from_ws[3], const double way_ws[3], double to_light)
{
    double p[3] = {from_ws[0], from_ws[1], from_ws[2]};
    met    s;
    for (int n = 0; n < SURFACES_MAX && meets(c, p, way_ws, to_light, &s); n++) {
        to_light -= pass(c, p, way_ws, &s);
        if (!truth_inside_solid(c->truth, p)) return !meets(c, p, way_ws, to_light, &s);
    }
    return 0;
}

static int is_behind_last(const comparison *c, const double p[3])
{
    double way_ws[3], away_ws[3], to_light;
    met    s;
    if (!way_to_light(c, p, way_ws, &to_light)) return 0;
    for (int n = 0; n < 3; n++) away_ws[n] = -way_ws[n];
    return !meets(c, p, away_ws, INFINITY, &s) && leaves_at_last(c, p, way_ws, to_light);
}

/* Metres along the axis of the map for each metre towards the light. */
static double metres_deep(const comparison *c, double depth_vx, double to_light)
{
    if (c->shape.kind == LIGHT_DIRECTIONAL) return 1;
    return c->light->near_metres * exp(depth_vx * c->light->voxel_metres) / to_light;
}

static int is_within_thickness(const comparison *c, const double from_ws[3], double depth_vx)
{
    const casters *all = c->casters;
    double         way_ws[3], to_light, p[3] = {from_ws[0], from_ws[1], from_ws[2]};
    met            s, before;
    if (!way_to_light(c, p, way_ws, &to_light) || !meets(c, p, way_ws, to_light, &s)) return 0;
    if (!is_sheet(c, &s) || s.triangle >= all->holed_first) return 0;
    if (all->double_sided && all->double_sided[s.triangle]) return 0;
    if (vec3_dot(s.normal_ws, way_ws) <= 0) return 0;
    if (s.distance * metres_deep(c, depth_vx, to_light) > c->dont_care.thickness_m) return 0;
    to_light -= pass(c, p, way_ws, &s);
    return !meets(c, p, way_ws, to_light, &before);
}

int compare_left_free(const comparison *c, int map, double u, double v, double near_vx, double far_vx)
{
    double near_ws[3], far_ws[3];
    vxs_point(c->light, map, (double[3]){u, v, near_vx}, near_ws);
    vxs_point(c->light, map, (double[3]){u, v, far_vx}, far_ws);
    return (c->dont_care.behind && is_behind_last(c, far_ws)) ||
           (c->dont_care.thickness_m > 0 && is_within_thickness(c, near_ws, near_vx));
}
