/* A plane that nothing shades, or a wall on it, below a light: where the bias of a lookup with a normal can be measured. For
 * tests/bench/bias.c and tests/unit/test_bias.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BIAS_STAGE_H
#define BIAS_STAGE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/vxs_bake.h"
#include "runtime/vxs.h"

#define BIAS_PI              3.14159265358979323846
#define BIAS_COSINE          0.08 /* of the angle between the normal and the light, at least */
#define BIAS_PUNCTUAL_METRES 2.0  /* from a spot or point light to the plane */
#define BIAS_WALL_METRES     1.0  /* how high a wall is */

enum { BIAS_CORNERS = 3 + 3 + 6 };

typedef struct bias_setup {
    vxs_bake_light_kind kind;
    /* Of a punctual light: metres to a caster behind it that shades nothing of the plane, as a fixture does; of a sun: metres from
     * the plane to a caster behind it, of a map some 20 m wide. Either makes voxels deeper than texels are wide. 0: none */
    double              other_caster_metres;
    int                 wall;
    uint32_t            side_px;
    vxs_bake_coding     coding;
} bias_setup;

typedef struct bias_stage {
    double   foot_ws[3];     /* below a punctual light; where axes begin, and what corners count from */
    double   axes_ws[3][3];  /* two in the plane, and its normal */
    double   plane_metres;   /* the plane's height above the foot: of its corners, as they were rounded to floats */
    double   light_ws[3];    /* a punctual light's place */
    double   to_light_ws[3]; /* against a sun's direction, or a spot's axis */
    float    corners[3 * BIAS_CORNERS];
    uint32_t corner_count;
} bias_stage;

static inline void bias_random_axes(rng *r, double axes[3][3])
{
    double v[2][3];
    for (int n = 0; n < 2; n++) do
            for (int k = 0; k < 3; k++) v[n][k] = 2 * rng_unit(r) - 1;
        while (vec3_dot(v[n], v[n]) > 1 || vec3_dot(v[n], v[n]) < 0.01);
    vec3_unit(v[0], axes[2]);
    vec3_cross(axes[2], v[1], axes[0]);
    vec3_unit(axes[0], axes[0]);
    vec3_cross(axes[2], axes[0], axes[1]);
}

/* x and y along the plane and up, from the foot; and the point at x, y of the plane and up from it, in the world. */
static inline void bias_from_foot(const bias_stage *s, double x, double y, double up, double out[3])
{
    for (int n = 0; n < 3; n++) out[n] = x * s->axes_ws[0][n] + y * s->axes_ws[1][n] + up * s->axes_ws[2][n];
}

static inline void bias_point(const bias_stage *s, double x, double y, double up, double point_ws[3])
{
    bias_from_foot(s, x, y, up + s->plane_metres, point_ws);
    vec3_mad(point_ws, 1, s->foot_ws, point_ws);
}

/* A direction at an angle from the normal, turned in the plane by another: radians. */
static inline void bias_direction(const bias_stage *s, double angle, double turn, double out[3])
{
    bias_from_foot(s, sin(angle) * cos(turn), sin(angle) * sin(turn), cos(angle), out);
}

static inline void bias_add_corner(bias_stage *s, const double from_foot[3])
{
    for (int n = 0; n < 3; n++) s->corners[3 * s->corner_count + n] = (float)from_foot[n];
    s->corner_count++;
}

/* An equilateral triangle about a place, across a direction. */
static inline void bias_add_triangle(bias_stage *s, const double from_foot[3], const double across[3], double radius)
{
    double u[3], v[3], other[3] = {fabs(across[0]) < 0.5, fabs(across[0]) >= 0.5, 0};
    vec3_cross(across, other, u);
    vec3_unit(u, u);
    vec3_cross(across, u, v);
    for (int n = 0; n < 3; n++) {
        double p[3];
        vec3_mad(from_foot, radius * cos(n * 2 * BIAS_PI / 3), u, p);
        vec3_mad(p, radius * sin(n * 2 * BIAS_PI / 3), v, p);
        bias_add_corner(s, p);
    }
}

/* Axes and foot that fit the plane's corners as they were rounded. */
static inline void bias_settle(bias_stage *s)
{
    double a[3], b[3], first[3], normal[3];
    for (int n = 0; n < 3; n++) {
        first[n] = (double)s->corners[n];
        a[n]     = (double)s->corners[3 + n] - first[n];
        b[n]     = (double)s->corners[6 + n] - first[n];
    }
    vec3_cross(a, b, normal);
    vec3_unit(normal, normal);
    if (vec3_dot(normal, s->axes_ws[2]) < 0)
        for (int n = 0; n < 3; n++) normal[n] = -normal[n];
    memcpy(s->axes_ws[2], normal, sizeof normal);
    vec3_mad(s->axes_ws[0], -vec3_dot(s->axes_ws[0], normal), normal, s->axes_ws[0]);
    vec3_unit(s->axes_ws[0], s->axes_ws[0]);
    vec3_cross(normal, s->axes_ws[0], s->axes_ws[1]);
    s->plane_metres = vec3_dot(first, normal);
}

static inline double bias_wall_x(const bias_setup *o)
{
    return o->kind == VXS_BAKE_DIRECTIONAL ? 0 : 0.9;
}

/* Towards the light from -x, or from anywhere. */
static inline void bias_place_light(bias_stage *s, const bias_setup *o, rng *r)
{
    double cosine = o->wall ? 0.25 + 0.6 * rng_unit(r) : BIAS_COSINE + (1 - BIAS_COSINE) * rng_unit(r);
    double turn = o->wall ? BIAS_PI + rng_unit(r) - 0.5 : 2 * BIAS_PI * rng_unit(r), angle = acos(cosine);
    bias_point(s, 0, 0, BIAS_PUNCTUAL_METRES, s->light_ws);
    if (o->kind == VXS_BAKE_SPOT && o->wall) turn = BIAS_PI, angle = 30 / 180.0 * BIAS_PI;
    if (o->kind == VXS_BAKE_SPOT && !o->wall)
        angle = (50 + 25 * rng_unit(r)) / 180 * BIAS_PI; /* the cone sees more than the plane */
    bias_direction(s, angle, turn, s->to_light_ws);
    if (!(o->other_caster_metres > 0)) return;

    double away[3], at[3];
    if (o->kind == VXS_BAKE_DIRECTIONAL) {
        for (int n = 0; n < 3; n++) away[n] = -s->to_light_ws[n];
        for (int n = 0; n < 3; n++) at[n] = o->other_caster_metres * away[n];
        bias_add_triangle(s, at, away, 1);
    } else {
        /* point light: above it. Spot: in its cone, 104 degrees from the direction of the plane, and so narrow that no filter
         * reaches it */
        bias_direction(s, o->kind == VXS_BAKE_POINT ? 0 : 76 / 180.0 * BIAS_PI, turn + BIAS_PI, away);
        bias_from_foot(s, 0, 0, BIAS_PUNCTUAL_METRES, at);
        vec3_mad(at, o->other_caster_metres, away, at);
        bias_add_triangle(s, at, away, 0.005 * o->other_caster_metres);
    }
}

static inline void bias_add_wall(bias_stage *s, const bias_setup *o)
{
    static const int order[6] = {0, 1, 3, 0, 3, 2};
    for (int n = 0; n < 6; n++) {
        double p[3];
        bias_from_foot(s, bias_wall_x(o), order[n] & 1 ? 0.8 : -0.8, order[n] & 2 ? BIAS_WALL_METRES : 0, p);
        bias_add_corner(s, p);
    }
}

/* Same setup and seed, same stage. */
static inline bias_stage bias_stage_make(const bias_setup *o, uint64_t seed)
{
    rng        r = rng_split(seed, (uint64_t)o->kind + 16 * (uint64_t)o->wall);
    bias_stage s = {.corner_count = 0};
    for (int n = 0; n < 3; n++) s.foot_ws[n] = 20 * rng_unit(&r) - 10;
    bias_random_axes(&r, s.axes_ws);
    bias_add_triangle(&s, (double[3]){0, 0, 0}, s.axes_ws[2], o->kind == VXS_BAKE_DIRECTIONAL ? 10 : 60);
    bias_settle(&s);
    bias_place_light(&s, o, &r);
    if (o->wall) bias_add_wall(&s, o);
    return s;
}

/* A point of the plane, at an angle to a punctual light of which all cosines from BIAS_COSINE on are alike likely; for a sun
 * anywhere. */
static inline void bias_draw_point(const bias_stage *s, const bias_setup *o, rng *r, double point_ws[3])
{
    double turn = 2 * BIAS_PI * rng_unit(r), cosine = BIAS_COSINE + (1 - BIAS_COSINE) * rng_unit(r);
    double away = o->kind == VXS_BAKE_DIRECTIONAL ? 4.5 * rng_unit(r) : BIAS_PUNCTUAL_METRES * sqrt(1 / (cosine * cosine) - 1);
    bias_point(s, away * cos(turn), away * sin(turn), 0, point_ws);
}

static inline void print_of_stage(vxs_severity severity, const char *text, void *user)
{
    (void)user;
    if (severity == VXS_SEVERITY_ERROR) fprintf(stderr, "no stage: %s\n", text);
}

/* Bake the stage. The asset is closed by the caller; the program ends where there is none. */
static inline vxs_asset *bias_stage_bake(const bias_stage *s, const bias_setup *o)
{
    vxs_bake_mesh    mesh    = {.positions = s->corners, .vertex_count = s->corner_count, .triangle_count = s->corner_count / 3};
    vxs_bake_light   light   = {.name = "light", .kind = o->kind, .cos_outer = cos(55 / 180.0 * BIAS_PI)};
    vxs_bake_arrays  arrays  = {.meshes = &mesh, .mesh_count = 1, .lights = &light, .light_count = 1};
    vxs_bake_options options = vxs_bake_defaults();
    vxs_bake_bytes   bytes   = {0};
    vxs_asset       *asset   = NULL;
    memcpy(mesh.origin_ws, s->foot_ws, sizeof mesh.origin_ws);
    memcpy(light.position_ws, s->light_ws, sizeof light.position_ws);
    for (int n = 0; n < 3; n++) light.direction_ws[n] = -s->to_light_ws[n];
    options.arrays     = &arrays;
    options.resolution = o->side_px;
    options.coding     = o->coding;
    options.zstd_level = 1;
    options.log        = print_of_stage;
    if (vxs_bake(&options, &bytes) != VXS_OK || vxs_asset_open(&asset, bytes.data, bytes.size_bytes, NULL) != VXS_OK) {
        exit(1);
    }
    vxs_bake_bytes_free(&bytes);
    return asset;
}

#endif
