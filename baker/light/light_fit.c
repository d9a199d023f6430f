/* Fit the maps of a light; see light_fit.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/light_fit.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/integer.h"
#include "baker/base/parallel.h"
#include "baker/base/portable_math.h"
#include "baker/base/vec3.h"
#include "baker/light/map_space.h"

enum { VERTICES_AT_ONCE = 1 << 14 };

/* Distances along the axes of the maps, metres. */
typedef struct reach {
    double near, far;
} reach;

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
 * plane to the light: for example, the ceiling around a recessed light. */
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
    double normal[3], side[3], ab[3], on_edge[3], nearest = INFINITY;
    normal_of(p, normal);
    int above = vec3_dot(normal, normal) > 0;
    for (int n = 0; n < p->count; n++) {
        const double *a = p->corners[n].at, *b = p->corners[(n + 1) % p->count].at;
        vec3_cross(a, b, side);
        above = above && vec3_dot(side, normal) >= 0;
        vec3_sub(b, a, ab);
        double length2 = vec3_dot(ab, ab);
        vec3_mad(a, length2 > 0 ? fmin(1, fmax(0, -vec3_dot(a, ab) / length2)) : 0, ab, on_edge);
        nearest = fmin(nearest, sqrt(vec3_dot(on_edge, on_edge)));
    }
    return above ? fabs(vec3_dot(p->corners[0].at, normal)) / sqrt(vec3_dot(normal, normal)) : nearest;
}

typedef struct measurer {
    const vxs_light *light;
    const casters   *c;
    double           range_metres;
    int              map;
    map_frame        frame;
    map_sides        sides;
    map_plane        planes[MAP_SIDES], along, against; /* the sides; distance along the map's axis, and its negative */
    reach            r;                                 /* so far */
} measurer;

/* Whether casters at these distances cannot change the reach, also when clipping rounds them. */
static int adds_nothing(const measurer *w, double least, double most)
{
    double rounding = 1e-12 * most;
    return least > w->range_metres * (1 + 1e-6) ||
           (least >= w->r.near + rounding && (most <= w->r.far - rounding || w->r.far >= w->range_metres));
}

static int skips_run(const measurer *w, const box *run)
{
    for (int n = 0; n < MAP_SIDES; n++)
        if (map_plane_most(&w->planes[n], run) < 0) return 1;
    return adds_nothing(w, -map_plane_most(&w->against, run), map_plane_most(&w->along, run));
}

static void measure_triangle(measurer *w, size_t n)
{
    map_polygon triangle, kept;
    triangle.count = 3;
    for (int k = 0; k < 3; k++) {
        map_corner *corner = &triangle.corners[k];
        corner->uv[0] = corner->uv[1] = 0;
        map_space_from_ws(&w->frame, w->c->positions_ws + 3 * (size_t)w->c->indices[3 * n + (size_t)k], corner->at);
    }
    double a = triangle.corners[0].at[2], b = triangle.corners[1].at[2], c = triangle.corners[2].at[2];
    if (adds_nothing(w, fmin(a, fmin(b, c)), fmax(a, fmax(b, c)))) return;
    if (!map_sides_touch(&w->sides, &triangle) || map_space_behind(w->light, w->map, &triangle) || edge_on(&triangle)) return;
    map_sides_clip(&w->sides, &triangle, &kept);

    if (kept.count < 3 || polygon_distance(&kept) > w->range_metres) return;
    for (int i = 0; i < kept.count; i++) {
        w->r.near = fmin(w->r.near, kept.corners[i].at[2]);
        w->r.far  = fmax(w->r.far, fmin(kept.corners[i].at[2], w->range_metres));
    }
}

/* Near and far of the casters in the light's maps and range. far is 0 when there are none. */
static reach measure(const vxs_light *light, const casters *c, double range_metres)
{
    measurer w    = {.light = light, .c = c, .range_metres = range_metres, .sides = map_sides_of(light, 0), .r = {INFINITY, 0}};
    int      maps = (int)vxs_map_count(light);
    for (w.map = 0; w.map < maps; w.map++) {
        w.frame   = map_frame_of(light, w.map);
        w.along   = map_plane_of(&w.frame, (double[4]){0, 0, 1, 0});
        w.against = map_plane_of(&w.frame, (double[4]){0, 0, -1, 0});
        for (int n = 0; n < MAP_SIDES; n++) w.planes[n] = map_plane_of(&w.frame, w.sides.n[n]);
        for (size_t n = 0; n < c->triangle_count; n++)
            if (n % CASTERS_RUN == 0 && c->runs && skips_run(&w, &c->runs[n / CASTERS_RUN]))
                n += CASTERS_RUN - 1;
            else
                measure_triangle(&w, n);
    }
    return w.r;
}

/* Border texels at each side of the cone, or of a side of the cube. */
static uint32_t border_px(uint32_t side)
{
    return min_u32(PUNCTUAL_BORDER_PX, side / 8);
}

/* Width of a texel at one metre, when `side` texels cover the cone and its border. */
static double slope_of(double half_slope, uint32_t side)
{
    return half_slope / (side / 2.0 - border_px(side));
}

/* Part of light_fit for spot and point lights, in light_fit.c.
 * light  [in] with its name set
 * axes   rows: u, v, and the light's direction; right-handed */
static vxs_result punctual_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, double axes[3][3], run_context *m)
{
    const light_shape *shape = desc->shape;
    int                spot  = shape->kind == LIGHT_SPOT;
    int                cube  = !spot || shape->outer_rad > PUNCTUAL_SPOT_MAX_RAD;
    double             slope = cube ? 1 : portable_tan(shape->outer_rad);
    uint32_t           side  = desc->resolution ? desc->resolution : 8;

    light->kind         = spot ? VXS_LIGHT_KIND_SPOT : VXS_LIGHT_KIND_POINT;
    light->flags        = cube ? VXS_LIGHT_CUBE : 0;
    light->range_metres = isfinite(shape->range_metres) ? shape->range_metres : 0;
    light->cos_outer    = spot ? fmax(0, portable_cos(shape->outer_rad)) : 0;
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
    reach r             = measure(light, c, shape->range_metres);
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
    double near         = fmax(r.near, r.far / PUNCTUAL_FAR_NEAR_MAX);
    light->voxel_metres = fmax(portable_log(r.far / near) / (side - 3), light->texel_metres);
    light->near_metres  = near * portable_exp(-light->voxel_metres);
    if (!(light->near_metres > 0) || !isfinite(r.far))
        return fail(m, VXS_E_ARGUMENT, "the casters lie %g to %g m from light '%s': no map can be fitted to them", r.near, r.far,
                    desc->name);
    return VXS_OK;
}

/* extent  along the axes, metres */
static void extend_along(box *extent, double axes[3][3], const double *point)
{
    box_add(extent, (double[3]){vec3_dot(axes[0], point), vec3_dot(axes[1], point), vec3_dot(axes[2], point)});
}

typedef struct extender {
    const casters *c;
    double (*axes)[3];
    box *extents; /* [threads] */
} extender;

static void extend_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    const extender *x = user;
    box             b = x->extents[worker];
    for (size_t n = begin; n < end; n++) extend_along(&b, x->axes, x->c->positions_ws + 3 * n);
    x->extents[worker] = b;
}

/* Of the region, or of all casters. */
static box extent_of(const casters *c, const light_fit_desc *desc, double axes[3][3])
{
    box           extents[PARALLEL_THREADS_MAX], all = box_empty();
    extender      x = {c, axes, extents};
    const double *b = desc->region_ws;
    for (int corner = 0; corner < 8 && b; corner++)
        extend_along(&all, axes, (double[3]){b[corner & 1 ? 3 : 0], b[corner & 2 ? 4 : 1], b[corner & 4 ? 5 : 2]});
    if (b) return all;
    for (int n = 0; n < PARALLEL_THREADS_MAX; n++) extents[n] = box_empty();
    parallel_for(desc->threads, c->vertex_count, VERTICES_AT_ONCE, extend_some, &x);
    for (int n = 0; n < PARALLEL_THREADS_MAX; n++) {
        if (!(extents[n].min[0] <= extents[n].max[0])) continue; /* a thread without vertices */
        box_add(&all, extents[n].min);
        box_add(&all, extents[n].max);
    }
    return all;
}

/* Set the rows of ls_from_ws: casters centred in u and v, one voxel behind the near plane. Returns the determinant. */
static double set_transform(vxs_light *light, const box *extent, double axes[3][3])
{
    double side = ldexp(1, (int)light->levels), determinant = 1;
    for (int row = 0; row < 3; row++) {
        double unit   = row < 2 ? light->texel_metres : light->voxel_metres;
        double before = row < 2 ? (side - (extent->max[row] - extent->min[row]) / unit) / 2 : 1;
        for (int n = 0; n < 3; n++) light->ls_from_ws[row * 4 + n] = axes[row][n] / unit;
        light->ls_from_ws[row * 4 + 3] = before - extent->min[row] / unit;
        determinant /= unit;
    }
    return determinant;
}

static vxs_result sun_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, double axes[3][3], run_context *m)
{
    box    extent = extent_of(c, desc, axes);
    double length[3];
    vec3_sub(extent.max, extent.min, length);
    double   width = fmax(length[0], length[1]), depth = length[2];
    uint32_t side  = desc->resolution;
    double   texel = desc->texel_metres;
    if (side) {
        texel = fmax(width, depth * 1e-3) / (side - 2);
    } else {
        for (side = 8; side < desc->resolution_max && (side - 2) * texel < width; side *= 2) {}
        if ((side - 2) * texel < width)
            return fail(
                m, VXS_E_ARGUMENT,
                "--texel %g: the scene is %g m wide seen from light '%s', which needs more than %u texels; at least --texel "
                "%s=%.3g",
                texel, width, desc->name, desc->resolution_max, desc->name, 1.005 * width / (desc->resolution_max - 2));
    }
    double voxel = fmax(depth / (side - 3), texel);
    if (desc->region_ws && fmax(width, depth) < texel)
        warn(m,
             "light '%s': --region is %.3g x %.3g m seen from it, and a texel is %.3g m: one voxel holds all; give a smaller "
             "--texel or a larger region",
             desc->name, width, depth, texel);
    if (!(texel > 0) || !isfinite(1 / texel) || !isfinite(width) || !isfinite(depth))
        return fail(m, VXS_E_ARGUMENT, "the casters span %g x %g m seen from light '%s': no map can be fitted to them", width,
                    depth, desc->name);

    light->kind         = VXS_LIGHT_KIND_DIRECTIONAL;
    light->flags        = desc->region_ws ? VXS_LIGHT_BOUNDED : 0;
    light->levels       = log2_u32(side);
    light->texel_metres = texel;
    light->voxel_metres = voxel;

    double determinant = set_transform(light, &extent, axes); /* the format requires an invertible transform */
    if (!isfinite(determinant) || determinant == 0)
        return fail(m, VXS_E_ARGUMENT, "%s spans %g x %g m seen from light '%s': no map can be fitted to it",
                    desc->region_ws ? "--region" : "the scene", width, depth, desc->name);
    return VXS_OK;
}

vxs_result light_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, run_context *m)
{
    static const double ahead[3] = {0, 0, 1}; /* a point light's cube is aligned with the world axes */
    double              axes[3][3];
    memset(light, 0, sizeof *light);

    /* the format stores up to 63 bytes; longer names are cut between UTF-8 characters */
    const char *name = desc->name;
    size_t      size = strlen(name);
    if (size > VXS_LIGHT_NAME_BYTES - 1) {
        size = VXS_LIGHT_NAME_BYTES - 1;
        while (size && ((unsigned char)name[size] & 0xc0) == 0x80) size--;
        warn(m, "light '%s': the name is cut to its first %zu bytes, by which it will be looked up; rename it in the scene", name,
             size);
    }
    memcpy(light->name, name, size);
    memcpy(light->direction_ws, desc->shape->kind == LIGHT_POINT ? ahead : desc->shape->direction_ws, sizeof light->direction_ws);

    const double       *direction = light->direction_ws;
    static const double up[3] = {0, 1, 0}, east[3] = {1, 0, 0};
    double              v[3];
    vec3_cross(up, direction, axes[0]);
    /* light from straight above has no unique horizontal axis: use world x for u */
    if (vec3_dot(axes[0], axes[0]) < 1e-6) {
        vec3_cross(direction, east, v);
        vec3_cross(v, direction, axes[0]);
    }
    double length = sqrt(vec3_dot(axes[0], axes[0]));
    for (int n = 0; n < 3; n++) axes[0][n] /= length;
    vec3_cross(direction, axes[0], axes[1]);
    memcpy(axes[2], direction, sizeof axes[2]);

    return desc->shape->kind == LIGHT_DIRECTIONAL ? sun_fit(light, c, desc, axes, m) : punctual_fit(light, c, desc, axes, m);
}
