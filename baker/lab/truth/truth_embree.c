/* The ray-traced truth, by Embree 3; see truth.h.
 *
 * Embree's space, "unit space" below: the casters' bounds centred on 0 and scaled by a power of two, so that their half
 * diagonal is in [0.5, 1). All triangles are one geometry, so that Embree's primID is the caster's triangle index.
 *
 *        point outside        first point where the ray can meet a caster
 *             o ---- skipped ----o------------->      rays begin at the casters' bounding sphere at the earliest,
 *                              (   bounds   )         so that rounding of the origin is small relative to the casters
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/truth/truth.h"

#include <embree3/rtcore.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/box.h"
#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/scene/scene.h"

/* Rounding error relative to the sphere that holds the ray's origin and the casters: 16 roundings to float of the largest
 * coordinate, for origin, direction, vertices, and Embree's edge products. */
#define FLOAT_SLACK 0x1p-20

#define LIFT 1e-5

#define SURFACE_TRIES 64 /* points drawn before surfaces are taken as consisting of holes only */

struct truth {
    const casters *casters;
    RTCDevice      device;
    RTCScene       scene;
    double         centre_ws[3];
    double         radius;    /* metres: half the diagonal of the bounds */
    double         scale;     /* unit space per metre, a power of two */
    double        *area_sums; /* [triangle_count] in unit space: cumulative sums, each including its triangle */
};

/* building --------------------------------------------------------------------------------------------------------------------- */

static const double *corner(const casters *c, size_t triangle, int i)
{
    return &c->positions_ws[3 * (size_t)c->indices[3 * triangle + (size_t)i]];
}

/* A normal with twice the area as length, by winding; in unit space, so that doubles do not overflow for any size of scene. */
static void scaled_normal(const truth *t, size_t triangle, double normal[3])
{
    const double *a = corner(t->casters, triangle, 0);
    double        ab[3], ac[3];
    vec3_sub(corner(t->casters, triangle, 1), a, ab);
    vec3_sub(corner(t->casters, triangle, 2), a, ac);
    for (int i = 0; i < 3; i++) {
        ab[i] *= t->scale;
        ac[i] *= t->scale;
    }
    vec3_cross(ab, ac, normal);
}

static vxs_result measure_bounds(truth *t, run_context *m)
{
    const casters *c = t->casters;
    for (size_t i = 0; i < 9 * c->triangle_count; i++)
        if (!isfinite(c->positions_ws[3 * (size_t)c->indices[i / 3] + i % 3]))
            return fail(m, VXS_E_SCENE, "triangle %zu has a position that is not finite", i / 9);

    box    b = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double half[3];
    for (int i = 0; i < 3; i++) {
        t->centre_ws[i] = 0.5 * b.min[i] + 0.5 * b.max[i];
        half[i]         = 0.5 * b.max[i] - 0.5 * b.min[i];
    }
    t->radius = sqrt(vec3_dot(half, half));
    if (!(t->radius < 1e100)) return fail(m, VXS_E_SCENE, "the scene is too large to trace: %g m", 2 * t->radius);

    int exponent;
    frexp(t->radius, &exponent);
    t->scale = t->radius > 1e-100 ? ldexp(1, -exponent) : 1;
    return VXS_OK;
}

static void unit_from_ws(const truth *t, const double ws[3], float unit[3])
{
    for (int i = 0; i < 3; i++) unit[i] = (float)((ws[i] - t->centre_ws[i]) * t->scale);
}

/* The last error on this device, as a result. */
static vxs_result check_embree(RTCDevice device, run_context *m)
{
    enum RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return VXS_OK;
    if (error == RTC_ERROR_OUT_OF_MEMORY) return fail(m, VXS_E_MEMORY, "out of memory while building the scene for ray tracing");
    return fail(m, VXS_E_PROGRAM, "Embree cannot trace rays here%s (error %d)",
                error == RTC_ERROR_UNSUPPORTED_CPU ? ": it does not know this processor" : "", (int)error);
}

/* Embree owns the buffers: it requires padding behind the last vertex, which it then adds itself. */
static vxs_result fill_geometry(const truth *t, RTCGeometry geometry, run_context *m)
{
    const casters *c = t->casters;
    float         *positions =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), c->vertex_count);
    uint32_t *indices =
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), c->triangle_count);
    if (!positions || !indices) {
        vxs_result r = check_embree(t->device, m);
        return r != VXS_OK ? r : fail(m, VXS_E_MEMORY, "out of memory while building the scene for ray tracing");
    }

    for (size_t i = 0; i < c->vertex_count; i++) unit_from_ws(t, &c->positions_ws[3 * i], &positions[3 * i]);
    for (size_t i = 0; i < 3 * c->triangle_count; i++) indices[i] = c->indices[i];
    return VXS_OK;
}

static vxs_result build_scene(truth *t, uint32_t threads, run_context *m)
{
    vxs_result  r;
    RTCGeometry geometry = NULL;
    char        config[64];

    snprintf(config, sizeof config, "threads=%u,set_affinity=0", (unsigned)threads);
    t->device = rtcNewDevice(config);
    if (!t->device) return (r = check_embree(NULL, m)) != VXS_OK ? r : fail(m, VXS_E_PROGRAM, "Embree does not start");

    geometry = rtcNewGeometry(t->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    t->scene = rtcNewScene(t->device);
    if ((r = check_embree(t->device, m)) != VXS_OK) goto done;
    if ((r = fill_geometry(t, geometry, m)) != VXS_OK) goto done;

    /* medium quality: spatial splits (high) could pass one triangle to a filter twice, and winding numbers would be wrong */
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(t->scene, geometry);
    rtcSetSceneFlags(t->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    rtcSetSceneBuildQuality(t->scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(t->scene);
    r = check_embree(t->device, m);
done:
    if (geometry) rtcReleaseGeometry(geometry);
    return r;
}

vxs_result truth_create(truth **out, const casters *c, uint32_t threads, run_context *m)
{
    vxs_result r;
    *out = NULL;
    if (!c->triangle_count) return fail(m, VXS_E_NO_CASTER, "the scene has no triangle that casts a shadow");
    if (c->triangle_count >= UINT32_MAX || c->vertex_count >= UINT32_MAX)
        return fail(m, VXS_E_UNSUPPORTED, "the scene has %zu triangles, more than can be traced", c->triangle_count);

    truth *t = calloc(1, sizeof *t);
    if (!t) return fail(m, VXS_E_MEMORY, "out of memory");
    t->casters = c;
    if ((r = measure_bounds(t, m)) != VXS_OK) goto done;

    size_t count = t->casters->triangle_count;
    t->area_sums = count <= SIZE_MAX / sizeof *t->area_sums ? malloc(count * sizeof *t->area_sums) : NULL;
    if (!t->area_sums) {
        r = fail(m, VXS_E_MEMORY, "out of memory for the areas of %zu triangles", count);
        goto done;
    }

    double sum = 0;
    for (size_t triangle = 0; triangle < count; triangle++) {
        double normal[3];
        scaled_normal(t, triangle, normal);
        sum += 0.5 * sqrt(vec3_dot(normal, normal));
        t->area_sums[triangle] = sum;
    }

    if ((r = build_scene(t, threads, m)) != VXS_OK) goto done;
    *out = t;
    t    = NULL;
done:
    truth_destroy(t);
    return r;
}

void truth_destroy(truth *t)
{
    if (!t) return;
    if (t->scene) rtcReleaseScene(t->scene);
    if (t->device) rtcReleaseDevice(t->device);
    free(t->area_sums);
    free(t);
}

double truth_precision(const truth *t)
{
    return FLOAT_SLACK * t->radius;
}

void truth_lift(const truth *t, const double point_ws[3], const double normal_ws[3], double lifted_ws[3])
{
    vec3_mad(point_ws, LIFT * 2 * t->radius, normal_ws, lifted_ws);
}

/* rays ------------------------------------------------------------------------------------------------------------------------- */

static double segment_distance2(const double a[3], const double b[3])
{
    double ab[3], nearest[3];
    vec3_sub(b, a, ab);
    double length2 = vec3_dot(ab, ab);
    double along   = length2 > 0 ? fmin(1, fmax(0, -vec3_dot(a, ab) / length2)) : 0;
    vec3_mad(a, along, ab, nearest);
    return vec3_dot(nearest, nearest);
}

/* The squared distance from 0 to a triangle, which may have no area: to its plane where 0 projects into the triangle, else to an
 * edge. */
static double triangle_distance2(const double a[3], const double b[3], const double c[3])
{
    double ab[3], ac[3], normal[3], side[3];
    vec3_sub(b, a, ab);
    vec3_sub(c, a, ac);
    vec3_cross(ab, ac, normal);

    const double *corners[4] = {a, b, c, a};
    int           above      = vec3_dot(normal, normal) > 0;
    for (int i = 0; i < 3 && above; i++) {
        vec3_cross(corners[i], corners[i + 1], side);
        above = vec3_dot(side, normal) >= 0;
    }
    if (above) {
        double height = vec3_dot(a, normal);
        return height * height / vec3_dot(normal, normal);
    }
    return fmin(segment_distance2(a, b), fmin(segment_distance2(b, c), segment_distance2(c, a)));
}

/* A ray in unit space.
 * skipped  [out] metres between origin_ws and the start of the ray
 * Returns 0 when the ray misses the bounds, or only touches them so that it can meet no caster. */
static int ray_begin(const truth *t, const double origin_ws[3], const double direction_ws[3], struct RTCRay *ray, double *skipped)
{
    double from_centre[3], begin_ws[3];
    vec3_sub(origin_ws, t->centre_ws, from_centre);
    double radius = 1.001 * t->radius;
    double along  = vec3_dot(from_centre, direction_ws);

    *skipped = 0;
    if (vec3_dot(from_centre, from_centre) > radius * radius) {
        if (along >= 0) return 0;
        *skipped = fmax(0, -along - radius);
    }
    vec3_mad(from_centre, *skipped, direction_ws, begin_ws);
    if (!(vec3_dot(begin_ws, begin_ws) <= 4 * radius * radius)) return 0;

    *ray = (struct RTCRay){.org_x = (float)(begin_ws[0] * t->scale),
                           .org_y = (float)(begin_ws[1] * t->scale),
                           .org_z = (float)(begin_ws[2] * t->scale),
                           .dir_x = (float)direction_ws[0],
                           .dir_y = (float)direction_ws[1],
                           .dir_z = (float)direction_ws[2],
                           .tnear = 0,
                           .tfar  = INFINITY,
                           .mask  = UINT32_MAX};
    return 1;
}

/* Whether a triangle has a hole where its second and third corner have these weights. */
static int is_hole(const casters *c, size_t triangle, double second, double third)
{
    if (!c->alpha_mask_count || triangle < c->holed_first) return 0;
    size_t low = 0, high = c->alpha_mask_count - 1; /* the last mask that begins at or before the triangle */
    while (low < high) {
        size_t middle = high - (high - low) / 2;
        if (c->alpha_mask_first[middle] <= triangle)
            low = middle;
        else
            high = middle - 1;
    }

    const alpha_mask *mask = &c->alpha_masks[low];
    const float      *uv   = &c->hole_uvs[6 * (triangle - c->holed_first)];
    double            at[2];
    for (int i = 0; i < 2; i++)
        at[i] = (1 - second - third) * (double)uv[i] + second * (double)uv[2 + i] + third * (double)uv[4 + i];
    return !alpha_mask_opaque(mask, &c->images[mask->image], at[0], at[1]);
}

/* Casters within this distance of a punctual light, in unit space, are tested in double: there, rounding to float turns a ray by
 * too much. */
#define AT_LIGHT 0x1p-10

/* Corners of a triangle relative to a point, in metres. */
static void corners_from(const truth *t, size_t triangle, const double from_ws[3], double corners[3][3])
{
    for (int k = 0; k < 3; k++) vec3_sub(corner(t->casters, triangle, k), from_ws, corners[k]);
}

static int is_at_light(const truth *t, size_t triangle, const double light_ws[3])
{
    double corners[3][3], limit = AT_LIGHT / t->scale;
    corners_from(t, triangle, light_ws, corners);
    return triangle_distance2(corners[0], corners[1], corners[2]) <= limit * limit;
}

/* One ray, for which only the first caster on its way counts. */
typedef struct way_context {
    struct RTCIntersectContext embree; /* first member: the filter gets a pointer to it */
    const truth               *truth;
    const double              *light_ws; /* NULL for a directional light */
} way_context;

/* Holes let light pass. Embree's barycentric weights are off by the rounding displacement of the ray, which truth_precision
 * includes. Casters at the light are left to query_at_light. */
static void pass_holes(const struct RTCFilterFunctionNArguments *args)
{
    const way_context   *way = (const way_context *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit; /* N is 1: the plain struct */
    if (is_hole(way->truth->casters, hit->primID, (double)hit->u, (double)hit->v)) args->valid[0] = 0;
    if (way->light_ws && is_at_light(way->truth, hit->primID, way->light_ws)) args->valid[0] = 0;
}

static int is_occluded(const truth *t, struct RTCRay ray, const double *light_ws)
{
    way_context way = {.truth = t, .light_ws = light_ws};
    rtcInitIntersectContext(&way.embree);
    if (t->casters->alpha_mask_count || light_ws) way.embree.filter = pass_holes;
    rtcOccluded1(t->scene, &way.embree, &ray);
    return ray.tfar < 0; /* Embree sets -infinity when occluded */
}

/* Test casters near a punctual light, in double, between it and a point. */
typedef struct light_query {
    const truth  *truth;
    const double *light_ws;
    double        way_ws[3]; /* unit, from the light */
    double        end;       /* metres: casters farther away are ignored */
    int           occluded;
} light_query;

/* Moeller and Trumbore, 1997. */
static bool query_at_light(struct RTCPointQueryFunctionArguments *args)
{
    light_query *q = args->userPtr;
    double       corners[3][3], ab[3], ac[3], p[3], r[3];
    if (q->occluded || !is_at_light(q->truth, args->primID, q->light_ws)) return false;
    corners_from(q->truth, args->primID, q->light_ws, corners);
    vec3_sub(corners[1], corners[0], ab);
    vec3_sub(corners[2], corners[0], ac);
    vec3_cross(q->way_ws, ac, p);
    vec3_cross(ab, corners[0], r);
    double volume = vec3_dot(ab, p);
    double second = -vec3_dot(corners[0], p) / volume, third = vec3_dot(q->way_ws, r) / volume, at = vec3_dot(ac, r) / volume;
    if (!(second >= 0 && third >= 0 && second + third <= 1)) return false;
    if (!(at > 1e-9 * q->end && at < q->end)) return false; /* a punctual light may be in a ceiling */
    q->occluded = !is_hole(q->truth->casters, args->primID, second, third);
    return false;
}

/* The direction from a point to a light, and the distance: INFINITY for a directional light. */
static double way_to_light(const light_shape *light, const double point_ws[3], double way_ws[3])
{
    double to_light[3];
    for (int i = 0; i < 3; i++) way_ws[i] = -light->direction_ws[i];
    if (light->kind == LIGHT_DIRECTIONAL) return INFINITY;
    vec3_sub(light->position_ws, point_ws, to_light);
    return vec3_unit(to_light, way_ws) ? sqrt(vec3_dot(to_light, to_light)) : 0;
}

int truth_lit(const truth *t, const double point_ws[3], const light_shape *light)
{
    double        to_light_ws[3], skipped;
    double        distance = way_to_light(light, point_ws, to_light_ws);
    struct RTCRay ray;
    if (!ray_begin(t, point_ws, to_light_ws, &ray, &skipped)) return 1;
    if (skipped == 0) ray.tnear = FLOAT_SLACK; /* the surface of the point itself does not count */
    if (distance < INFINITY) {
        double own = skipped == 0 ? truth_precision(t) : 0;

        /* Is the light itself within a caster? */
        light_query          q = {.truth    = t,
                                  .light_ws = light->position_ws,
                                  .way_ws   = {-to_light_ws[0], -to_light_ws[1], -to_light_ws[2]},
                                  .end      = distance - own};
        float                at[3];
        struct RTCPointQuery query = {.radius = 2 * (float)AT_LIGHT};
        unit_from_ws(t, light->position_ws, at);
        query.x = at[0], query.y = at[1], query.z = at[2];
        struct RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(t->scene, &query, &context, query_at_light, &q);
        if (q.occluded) return 0;

        ray.tfar = (float)((distance - skipped) * t->scale - AT_LIGHT / 2);
        if (ray.tfar <= ray.tnear) return 1;
    }
    const double *light_ws = distance < INFINITY ? light->position_ws : NULL;
    if (is_occluded(t, ray, light_ws)) return 0;

    /* Embree is watertight along edges, but rarely a ray towards a vertex passes through it, and points on a grid do aim at
     * vertices: a second ray must reach the light, too */

    /* turn the ray about its origin, by half of the allowed rounding error */
    const double along[3] = {ray.dir_x, ray.dir_y, ray.dir_z};
    const double axis[3]  = {fabs(along[0]) < 0.6, fabs(along[0]) >= 0.6, 0}; /* not nearly parallel to the ray */
    double       across[3], tilted[3];
    vec3_cross(along, axis, across);
    vec3_unit(across, across);
    vec3_mad(along, FLOAT_SLACK / 2, across, tilted);
    ray.dir_x = (float)tilted[0];
    ray.dir_y = (float)tilted[1];
    ray.dir_z = (float)tilted[2];

    return !is_occluded(t, ray, light_ws);
}

/* At equal distances, Embree keeps the triangle that its tree visits last, and trees depend on threads: choose by number. */
typedef struct nearest_context {
    struct RTCIntersectContext embree; /* first member: the filter gets a pointer to it */
    const casters             *casters;
    float                      distance;
    uint32_t                   triangle;
} nearest_context;

static void keep_lower_of_equals(const struct RTCFilterFunctionNArguments *args)
{
    nearest_context     *nearest  = (nearest_context *)args->context;
    float                distance = ((const struct RTCRay *)args->ray)->tfar; /* N is 1: the plain structs */
    const struct RTCHit *hit      = (const struct RTCHit *)args->hit;
    int                  first = distance < nearest->distance || (distance == nearest->distance && hit->primID < nearest->triangle);
    if (first && !is_hole(nearest->casters, hit->primID, (double)hit->u, (double)hit->v)) {
        nearest->distance = distance;
        nearest->triangle = hit->primID;
    } else {
        args->valid[0] = 0;
    }
}

int truth_first_hit(const truth *t, const double origin_ws[3], const double direction_ws[3], double *distance, double normal_ws[3],
                    uint32_t *triangle)
{
    struct RTCRayHit query = {.hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .primID = RTC_INVALID_GEOMETRY_ID}};
    double           skipped;
    if (!ray_begin(t, origin_ws, direction_ws, &query.ray, &skipped)) return 0;

    nearest_context nearest = {.casters = t->casters, .distance = INFINITY, .triangle = UINT32_MAX};
    rtcInitIntersectContext(&nearest.embree);
    nearest.embree.filter = keep_lower_of_equals;
    rtcIntersect1(t->scene, &nearest.embree, &query);
    if (nearest.triangle == UINT32_MAX) return 0;

    /* the triangle's plane, in double, gives a more precise distance, unless the ray is nearly parallel to it */
    double normal[3], unit[3] = {0, 0, 0}, to_corner[3];
    double metres = skipped + nearest.distance / t->scale;
    scaled_normal(t, nearest.triangle, normal);
    if (vec3_unit(normal, unit)) {
        vec3_sub(corner(t->casters, nearest.triangle, 0), origin_ws, to_corner);
        double slope = vec3_dot(direction_ws, unit);
        if (fabs(slope) > 1e-3) metres = vec3_dot(to_corner, unit) / slope;
    }
    if (distance) *distance = fmax(0, metres);
    if (normal_ws)
        for (int i = 0; i < 3; i++) normal_ws[i] = unit[i];
    if (triangle) *triangle = nearest.triangle;
    return 1;
}

/* inside ----------------------------------------------------------------------------------------------------------------------- */

/* Signed crossings along one ray. A ray that passes an edge within the rounding error may cross both of its triangles instead of
 * one; such a ray is doubtful, and another direction is tried. */
typedef struct winding_context {
    struct RTCIntersectContext embree; /* first member: the filter gets a pointer to it */
    const truth               *truth;
    double                     origin_ws[3];
    double                     direction_ws[3];
    double                     slack; /* metres */
    int64_t                    winding;
    int                        doubtful;
} winding_context;

static void count_crossing(const struct RTCFilterFunctionNArguments *args)
{
    winding_context *w        = (winding_context *)args->context;
    const casters   *c        = w->truth->casters;
    uint32_t         triangle = ((const struct RTCHit *)args->hit)->primID; /* N is 1: the plain struct */

    args->valid[0] = 0; /* go on to the next one */
    if (triangle >= c->solid_triangle_count) return;

    double from_origin[3][3];
    for (int i = 0; i < 3; i++) vec3_sub(corner(c, triangle, i), w->origin_ws, from_origin[i]);
    for (int i = 0; i < 3; i++) {
        /* the distance between the ray's line and an edge's line */
        const double *a = from_origin[i], *b = from_origin[(i + 1) % 3];
        double        edge[3], between[3], a_cross_b[3];
        vec3_sub(b, a, edge);
        vec3_cross(w->direction_ws, edge, between);
        vec3_cross(a, b, a_cross_b);
        if (fabs(vec3_dot(w->direction_ws, a_cross_b)) <= w->slack * sqrt(vec3_dot(between, between))) w->doubtful = 1;
    }

    double normal[3];
    scaled_normal(w->truth, triangle, normal);
    w->winding += vec3_dot(normal, w->direction_ws) > 0 ? 1 : -1; /* the ray leaves a solid: the point was inside it */
}

int truth_inside_solid(const truth *t, const double point_ws[3])
{
    /* unit vectors that are not parallel to usual sides of objects */
    static const double directions_ws[7][3] = {
        {0.270598050073, 0.900968867902, 0.339164873902},    {-0.629320391050, 0.611507863021, -0.479585031072},
        {0.412938472910, -0.350871947123, 0.840472639151},   {0.782304984125, 0.193847561029, -0.591976352714},
        {-0.153827461905, -0.917364528193, -0.367105629384}, {-0.841236509172, -0.173925481036, 0.511912847365},
        {0.092837465192, 0.487261903845, -0.868301726451},
    };
    enum { DIRECTIONS = sizeof directions_ws / sizeof *directions_ws };

    int votes[2] = {0, 0}, doubtful_votes[2] = {0, 0};
    for (int i = 0; i < DIRECTIONS && votes[0] < 2 && votes[1] < 2; i++) {
        winding_context  w     = {.truth = t, .slack = 2 * truth_precision(t)};
        struct RTCRayHit query = {.hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .primID = RTC_INVALID_GEOMETRY_ID}};
        double           skipped;
        vec3_unit(directions_ws[i], w.direction_ws);
        if (!ray_begin(t, point_ws, w.direction_ws, &query.ray, &skipped)) return 0;

        for (int k = 0; k < 3; k++) w.origin_ws[k] = point_ws[k];
        rtcInitIntersectContext(&w.embree);
        w.embree.filter = count_crossing;
        rtcIntersect1(t->scene, &w.embree, &query);
        ++*(w.doubtful ? &doubtful_votes[w.winding > 0] : &votes[w.winding > 0]);
    }
    return votes[0] != votes[1] ? votes[1] > votes[0] : doubtful_votes[1] > doubtful_votes[0];
}

/* surface points --------------------------------------------------------------------------------------------------------------- */

/* A point of the triangles, ignoring holes. Returns 0 in a hole. */
static int draw_surface_point(const truth *t, const double uniforms[3], double point_ws[3], size_t *triangle)
{
    double total = t->area_sums[t->casters->triangle_count - 1];
    /* for u just below 1, u * total may round up to total */

    /* the first triangle whose cumulative sum exceeds `area`: never one without area */
    double area   = fmin(uniforms[0] * total, nextafter(total, 0));
    size_t chosen = 0, high = t->casters->triangle_count - 1;
    while (chosen < high) {
        size_t middle = chosen + (high - chosen) / 2;
        if (t->area_sums[middle] > area)
            high = middle;
        else
            chosen = middle + 1;
    }

    /* uniform over a triangle: Turk, "Generating Random Points in Triangles", Graphics Gems, 1990 */
    double        root = sqrt(uniforms[1]);
    double        wb = root * (1 - uniforms[2]), wc = root * uniforms[2];
    const double *a = corner(t->casters, chosen, 0), *b = corner(t->casters, chosen, 1), *c = corner(t->casters, chosen, 2);
    for (int i = 0; i < 3; i++) point_ws[i] = a[i] + wb * (b[i] - a[i]) + wc * (c[i] - a[i]);
    *triangle = chosen;
    return !is_hole(t->casters, chosen, wb, wc);
}

int truth_sample_surface(const truth *t, const double uniforms[3], double point_ws[3], double normal_ws[3], uint32_t *triangle)
{
    double drawn_from[3] = {uniforms[0], uniforms[1], uniforms[2]}, found[3], normal[3];
    size_t chosen;
    int    tries = 1;
    if (!(t->area_sums[t->casters->triangle_count - 1] > 0)) return 0;

    /* after a hole, continue with random numbers that are derived from the given ones, so that the result is deterministic */
    rng again = {(uint64_t)ldexp(uniforms[0], 60) ^ (uint64_t)ldexp(uniforms[1], 52) ^ (uint64_t)ldexp(uniforms[2], 44)};
    while (!draw_surface_point(t, drawn_from, found, &chosen)) {
        if (tries++ == SURFACE_TRIES) return 0;
        for (int i = 0; i < 3; i++) drawn_from[i] = rng_unit(&again);
    }
    scaled_normal(t, chosen, normal);
    for (int i = 0; i < 3; i++) point_ws[i] = found[i];
    if (normal_ws) vec3_unit(normal, normal_ws);
    if (triangle) *triangle = (uint32_t)chosen;
    return 1;
}
