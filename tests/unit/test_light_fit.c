/* Where a light's maps lie: all casters inside with the margins that lookups count on (baker/light/light_fit.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/light/light_fit.h" /* before cmocka, whose fail() is a macro */
#include "runtime/vxs.h"

#include <cmocka.h>

enum { POINTS = 50 };

typedef struct cloud {
    double  positions[3 * POINTS];
    casters c;
} cloud;

/* Points in a box of these sizes around a centre; its corners are among them. */
static void make_cloud(cloud *k, const double centre[3], const double size[3], uint64_t seed)
{
    rng r = rng_split(seed, 0);
    memset(k, 0, sizeof *k);
    for (int n = 0; n < POINTS; n++)
        for (int axis = 0; axis < 3; axis++) {
            double at                  = n < 8 ? (n >> axis & 1) : rng_u32(&r) / 4294967296.0;
            k->positions[3 * n + axis] = centre[axis] + size[axis] * (at - 0.5);
        }
    k->c.positions_ws = k->positions;
    k->c.vertex_count = POINTS;
}

static light_fit_desc desc_of(const double direction[3], uint32_t resolution)
{
    static light_shape sun = {.kind = LIGHT_DIRECTIONAL};
    memcpy(sun.direction_ws, direction, sizeof sun.direction_ws);
    return (light_fit_desc){.name = "sun", .shape = &sun, .resolution = resolution, .resolution_max = 16384};
}

static void to_voxels(const vxs_light *l, const double p[3], double out[3])
{
    for (int row = 0; row < 3; row++) {
        const double *m = l->ls_from_ws + 4 * row;
        out[row]        = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
    }
}

/* u, v and the light's direction: unit, at right angles, right-handed; texels and voxels as long as the light says. */
static void assert_axes(const vxs_light *l, const double direction[3])
{
    double axis[3][3], cross[3];
    for (int row = 0; row < 3; row++)
        for (int n = 0; n < 3; n++) axis[row][n] = l->ls_from_ws[4 * row + n] * (row < 2 ? l->texel_metres : l->voxel_metres);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) assert_true(fabs(vec3_dot(axis[a], axis[b]) - (a == b)) < 1e-12);
    vec3_cross(axis[0], axis[1], cross);
    for (int n = 0; n < 3; n++) {
        assert_true(fabs(cross[n] - axis[2][n]) < 1e-12);
        assert_true(fabs(direction[n] - axis[2][n]) < 1e-12);
        assert_true(l->direction_ws[n] == direction[n]);
    }
    /* u is horizontal, so that vertical edges run along columns of texels */
    if (hypot(direction[0], direction[2]) > 1e-2) assert_true(fabs(axis[0][1]) < 1e-12);
}

/* One texel free at either side, one voxel before and two behind. The slack is the rounding of far-off coordinates. */
static void assert_margins(const vxs_light *l, const double *points, int count, double slack)
{
    double side = ldexp(1, (int)l->levels);
    for (int n = 0; n < count; n++) {
        double vx[3];
        to_voxels(l, points + 3 * n, vx);
        for (int row = 0; row < 2; row++) assert_true(vx[row] >= 1 - slack && vx[row] <= side - 1 + slack);
        assert_true(vx[2] >= 1 - slack && vx[2] <= side - 2 + slack);
    }
}

static void assert_fit(const cloud *k, const double direction[3], uint32_t resolution, double slack)
{
    light_fit_desc d = desc_of(direction, resolution);
    vxs_light      l;
    run_context    m = {0};
    assert_int_equal(light_fit(&l, &k->c, &d, &m), VXS_OK);
    assert_string_equal(l.name, "sun");
    assert_int_equal(l.kind, VXS_LIGHT_KIND_DIRECTIONAL);
    assert_int_equal(1u << l.levels, resolution);
    assert_true(l.voxel_metres >= l.texel_metres);
    assert_axes(&l, direction);
    assert_margins(&l, k->positions, POINTS, slack);
}

static void random_direction(double out[3], rng *r)
{
    double v[3];
    for (int n = 0; n < 3; n++) v[n] = rng_u32(r) / 2147483648.0 - 1;
    if (!vec3_unit(v, out)) out[1] = -1;
}

static void every_caster_is_inside(void **state)
{
    static const double sizes[][3] = {{10, 10, 10},           {1000, 1, 1},     {1, 1000, 1},
                                      {0.001, 0.002, 0.0005}, {2048, 20, 2048}, {1e6, 3, 5e5}};
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++) {
        rng    r = rng_split(seed, 1);
        cloud  k;
        double direction[3], centre[3];
        for (int n = 0; n < 3; n++) centre[n] = rng_between(&r, -50, 50);
        random_direction(direction, &r);
        make_cloud(&k, centre, sizes[seed % 6], seed);
        for (uint32_t resolution = 8; resolution <= 16384; resolution *= 2) assert_fit(&k, direction, resolution, 1e-6);
    }
}

/* Straight down, straight up, along the horizon, and so nearly so that no axis may get lost. */
static void special_directions(void **state)
{
    static const double directions[][3] = {{0, -1, 0},      {0, 1, 0},       {1, 0, 0},        {0, 0, 1},       {0, 0, -1},
                                           {1e-9, -1, 0},   {0, -1, 1e-4},   {1e-3, -1, 1e-3}, {2e-3, -1, 0},   {-1, 1e-7, 0},
                                           {0, -1e-300, 1}, {1e-160, -1, 0}, {0.7, -0.7, 0},   {-0.5, -1, -0.3}};
    (void)state;
    cloud k;
    make_cloud(&k, (const double[3]){1, 2, 3}, (const double[3]){10, 20, 30}, 1);
    for (size_t n = 0; n < sizeof directions / sizeof *directions; n++) {
        double unit[3];
        assert_true(vec3_unit(directions[n], unit));
        assert_fit(&k, unit, 1024, 1e-6);
    }
}

static void huge_coordinates(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 50; seed++) {
        rng    r = rng_split(seed, 2);
        cloud  k;
        double direction[3];
        random_direction(direction, &r);
        make_cloud(&k, (const double[3]){3e6, -1e6, 5e6}, (const double[3]){100, 10, 100}, seed);
        assert_fit(&k, direction, 4096, 1e-3); /* doubles near 6e6 are 1e-9 apart: 4e-8 of these texels a step */
        make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){1e30, 1e30, 1e28}, seed);
        assert_fit(&k, direction, 4096, 1e-6);
        make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){1e-30, 1e-30, 1e-28}, seed);
        assert_fit(&k, direction, 64, 1e-6);
    }
}

/* Seen edge-on, a flat scene has no width, or no depth: still a map. */
static void flat_scenes(void **state)
{
    (void)state;
    for (int flat = 0; flat < 3; flat++)
        for (int along = 0; along < 3; along++) {
            double direction[3] = {0}, size[3] = {10, 10, 10};
            cloud  k;
            size[flat]       = 0;
            direction[along] = -1;
            make_cloud(&k, (const double[3]){5, 5, 5}, size, 1);
            assert_fit(&k, direction, 256, 1e-6);
        }
    for (int along = 0; along < 3; along++) { /* a line, seen from its end and from its side */
        double direction[3] = {0};
        cloud  k;
        direction[along] = -1;
        make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){0, 10, 0}, 1);
        assert_fit(&k, direction, 256, 1e-6);
    }
}

static void a_point_cannot_be_fitted(void **state)
{
    (void)state;
    cloud k;
    make_cloud(&k, (const double[3]){1, 1, 1}, (const double[3]){0, 0, 0}, 1);
    light_fit_desc d = desc_of((const double[3]){0, -1, 0}, 256);
    vxs_light      l;
    run_context    m = {0};
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_E_ARGUMENT);
    assert_non_null(strstr(m.error, "sun"));
    make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){1.7e308, 1.7e308, 1.7e308}, 1);
    d = desc_of((const double[3]){0.6, -0.8, 0}, 256);
    memset(&m, 0, sizeof m);
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_E_ARGUMENT);
}

/* A region is what is looked up: it is inside, whatever casts from outside. */
static void regions(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 50; seed++) {
        rng    r = rng_split(seed, 3);
        cloud  k, box;
        double direction[3];
        random_direction(direction, &r);
        make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){1000, 1000, 1000}, seed);
        make_cloud(&box, (const double[3]){40, 5, -30}, (const double[3]){20, 10, 30}, seed);
        const double   region[6] = {30, 0, -45, 50, 10, -15};
        light_fit_desc d         = desc_of(direction, 512);
        vxs_light      l;
        run_context    m = {0};
        d.region_ws      = region;
        assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_OK);
        assert_margins(&l, box.positions, POINTS, 1e-6);
        assert_axes(&l, direction);
        assert_true(l.texel_metres < 0.1); /* fitted to the region, not to the kilometre around it */
    }
}

/* A texel's size gives the least power of two that holds the scene. */
static void texel_sizes(void **state)
{
    (void)state;
    const double down[3] = {0, -1, 0};
    cloud        k;
    make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){100, 10, 60}, 1);
    const struct {
        double   texel;
        uint32_t side;
    } cases[] = {{100, 8}, {20, 8}, {100 / 6.0, 8}, {16, 16}, {1, 128}, {100 / 126.0, 128}, {0.79, 256}, {100 / 16382.0, 16384}};
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        light_fit_desc d = desc_of(down, 0);
        vxs_light      l;
        run_context    m = {0};
        d.texel_metres   = cases[n].texel;
        assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_OK);
        assert_int_equal(1u << l.levels, cases[n].side);
        assert_true(l.texel_metres == cases[n].texel);
        assert_axes(&l, down);
        assert_margins(&l, k.positions, POINTS, 1e-6);
    }
    light_fit_desc d = desc_of(down, 0);
    vxs_light      l;
    run_context    m = {0};
    d.texel_metres   = 0.006;
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_E_ARGUMENT);
    assert_non_null(strstr(m.error, "--texel"));
}

/* A name that is too long for the file is cut, never run over. */
static void long_names(void **state)
{
    char  name[200];
    cloud k;
    (void)state;
    memset(name, 'a', sizeof name - 1);
    name[sizeof name - 1] = 0;
    make_cloud(&k, (const double[3]){0, 0, 0}, (const double[3]){1, 1, 1}, 1);
    const double   down[3] = {0, -1, 0};
    light_fit_desc d       = desc_of(down, 64);
    vxs_light      l;
    run_context    m = {0};
    d.name           = name;
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_OK);
    assert_int_equal(strlen(l.name), sizeof l.name - 1);
    run_free(&m);
}

/* spot and point lights -------------------------------------------------------------------------------------------------------- */

enum { TRIANGLES = 12 };

typedef struct soup {
    double   positions[9 * TRIANGLES];
    uint32_t indices[3 * TRIANGLES];
    casters  c;
} soup;

static void soup_init(soup *k, size_t triangles)
{
    for (uint32_t n = 0; n < 3 * TRIANGLES; n++) k->indices[n] = n;
    k->c =
        (casters){.positions_ws = k->positions, .indices = k->indices, .vertex_count = 3 * triangles, .triangle_count = triangles};
}

static double between(rng *r, double low, double high)
{
    return low + (high - low) * (rng_u32(r) / 4294967296.0);
}

/* A point of triangle t. */
static void sample_triangle(const soup *k, size_t t, rng *r, double out[3])
{
    double a = between(r, 0, 1), b = between(r, 0, 1);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    for (int n = 0; n < 3; n++) {
        const double *p = k->positions + 9 * t + n;
        out[n]          = p[0] + a * (p[3] - p[0]) + b * (p[6] - p[0]);
    }
}

static light_fit_desc punctual_desc(const light_shape *shape, uint32_t resolution)
{
    return (light_fit_desc){.name = "lamp", .shape = shape, .resolution = resolution, .resolution_max = 16384};
}

static vxs_result fit_punctual(vxs_light *l, const soup *k, const light_shape *shape, uint32_t resolution)
{
    light_fit_desc d = punctual_desc(shape, resolution);
    run_context    m = {0};
    vxs_result     r = light_fit(l, &k->c, &d, &m);
    if (r == VXS_OK || r == VXS_E_NO_CASTER) assert_string_equal(m.error, "");
    return r;
}

static void assert_punctual_axes(const vxs_light *l, const light_shape *shape)
{
    double at[3], cross[3];
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) assert_true(fabs(vec3_dot(l->ls_from_ws + 4 * a, l->ls_from_ws + 4 * b) - (a == b)) < 1e-12);
    vec3_cross(l->ls_from_ws, l->ls_from_ws + 4, cross);
    for (int n = 0; n < 3; n++) assert_true(fabs(cross[n] - l->ls_from_ws[8 + n]) < 1e-12);
    for (int n = 0; n < 3; n++) assert_true(l->direction_ws[n] == l->ls_from_ws[8 + n]);
    if (shape->kind == LIGHT_SPOT)
        for (int n = 0; n < 3; n++) assert_true(l->direction_ws[n] == shape->direction_ws[n]);
    to_voxels(l, shape->position_ws, at); /* metres about the light */
    double far_off = fabs(shape->position_ws[0]) + fabs(shape->position_ws[1]) + fabs(shape->position_ws[2]);
    for (int n = 0; n < 3; n++) assert_true(fabs(at[n]) <= 1e-15 * far_off);
    assert_true(l->voxel_metres >= l->texel_metres); /* no voxel flatter than a texel is wide */
}

/* Distance along the axis of the map that a point is in, and how far inside the map's border it is, in texels. */
static double inside_border(const vxs_light *l, const double point[3], double *along)
{
    double side = ldexp(1, (int)l->levels), border = fmin(PUNCTUAL_BORDER_PX, side / 8), ls[3], p[3];
    to_voxels(l, point, ls);
    for (int n = 0; n < 3; n++) p[n] = fabs(ls[n]);
    *along = ls[2];
    if (!(l->flags & VXS_LIGHT_CUBE)) return side / 2 - border - fmax(p[0], p[1]) / ls[2] / l->texel_metres;
    *along = fmax(p[0], fmax(p[1], p[2]));
    return side / 2 - border - 1 / l->texel_metres; /* what is nearer another axis is in another map */
}

/* Points of casters in cone and range are within the border of a map and its near and far sides: one voxel in front, two behind. */
static int assert_punctual_holds(const vxs_light *l, const soup *k, const light_shape *shape, double slack, uint64_t seed)
{
    rng    r     = rng_split(seed, 40);
    int    asked = 0;
    double side = ldexp(1, (int)l->levels), far = l->near_metres * exp((side - 2) * l->voxel_metres);
    for (int n = 0; n < 400; n++) {
        double  point[3], along;
        int32_t voxel[3];
        sample_triangle(k, rng_below(&r, (uint32_t)k->c.triangle_count), &r, point);
        if (!light_reaches(shape, point)) continue;
        double border = inside_border(l, point, &along);
        if (!(along > 0)) continue; /* on the edge of a cone of 180 degrees */
        assert_true(border > -slack * side);
        double depth = log(along / l->near_metres) / l->voxel_metres;
        assert_true(depth <= side - 2 + slack * side);
        if (along > far / PUNCTUAL_FAR_NEAR_MAX * 1.01) assert_true(depth >= 1 - slack * side);
        if (vxs_voxel(l, point, NULL, vxs_box(1), voxel) >= 0) assert_true(voxel[2] < (int32_t)side);
        asked++;
    }
    return asked;
}

static light_shape random_shape(rng *r)
{
    static const double degrees[] = {1, 10, 60, 119, 120, 121, 179, 180};
    light_shape         s         = {.kind = rng_below(r, 3) ? LIGHT_SPOT : LIGHT_POINT, .range_metres = INFINITY};
    random_direction(s.direction_ws, r);
    s.outer_rad = degrees[rng_below(r, 8)] * acos(-1) / 360;
    if (rng_below(r, 2)) s.range_metres = between(r, 0.5, 12);
    return s;
}

/* `scale` metres about `origin`; some triangles pass near the light or through its plane. */
static void random_soup(soup *k, rng *r, light_shape *shape, const double origin[3], double scale)
{
    soup_init(k, 1 + rng_below(r, TRIANGLES));
    for (int n = 0; n < 3; n++) shape->position_ws[n] = origin[n] + scale * between(r, -2, 2);
    shape->range_metres *= scale;
    for (size_t t = 0; t < k->c.triangle_count; t++) {
        double centre[3], size = scale * pow(10, between(r, -1.5, 1.5));
        for (int n = 0; n < 3; n++) centre[n] = origin[n] + scale * between(r, -6, 6);
        for (int n = 0; n < 9; n++) k->positions[9 * t + (size_t)n] = centre[n % 3] + size * between(r, -1, 1);
    }
}

static void punctuals_hold_what_they_reach(void **state)
{
    (void)state;
    int held = 0, none = 0;
    for (uint64_t seed = 0; seed < 6000; seed++) {
        rng          r       = rng_split(seed, 30);
        light_shape  shape   = random_shape(&r);
        const double here[3] = {0};
        soup         k;
        vxs_light    l;
        random_soup(&k, &r, &shape, here, 1);
        vxs_result result = fit_punctual(&l, &k, &shape, 8u << rng_below(&r, 9));
        if (result == VXS_E_NO_CASTER) {
            none++;
            for (int n = 0; n < 400; n++) { /* indeed */
                double point[3];
                sample_triangle(&k, rng_below(&r, (uint32_t)k.c.triangle_count), &r, point);
                assert_false(light_reaches(&shape, point));
            }
            continue;
        }
        assert_int_equal(result, VXS_OK);
        assert_punctual_axes(&l, &shape);
        assert_int_equal(l.kind, shape.kind == LIGHT_SPOT ? VXS_LIGHT_KIND_SPOT : VXS_LIGHT_KIND_POINT);
        assert_int_equal(l.flags, shape.kind == LIGHT_SPOT && shape.outer_rad < 1.048 ? 0 : VXS_LIGHT_CUBE);
        assert_true(l.range_metres == (isfinite(shape.range_metres) ? shape.range_metres : 0));
        assert_true(shape.kind == LIGHT_SPOT ? fabs(l.cos_outer - cos(shape.outer_rad)) < 1e-15 : l.cos_outer == 0);
        held += assert_punctual_holds(&l, &k, &shape, 1e-6, seed);
    }
    assert_true(held > 100000 && none > 500);
}

static void punctuals_far_off_and_tiny(void **state)
{
    (void)state;
    int held = 0;
    for (uint64_t seed = 0; seed < 600; seed++) {
        rng         r     = rng_split(seed, 31);
        light_shape shape = random_shape(&r);
        soup        k;
        vxs_light   l;
        int         far       = seed % 2;
        double      origin[3] = {far ? 1e7 : 0, far ? -3e6 : 0, far ? 8e6 : 0};
        random_soup(&k, &r, &shape, origin, far ? 1 : 1e-6);
        if (fit_punctual(&l, &k, &shape, 1024) != VXS_OK) continue;
        assert_punctual_axes(&l, &shape);
        held += assert_punctual_holds(&l, &k, &shape, far ? 1e-4 : 1e-6, seed);
    }
    assert_true(held > 10000);
}

/* A wall of known place in front of the light: near and far are its ends, to the voxel. */
static void punctuals_fit_tightly(void **state)
{
    (void)state;
    static const double walls[2][9] = {{-0.5, -0.5, 4, 0.5, -0.5, 4, 0, 0.5, 7}, {-1e3, -1e3, 2, 1e3, -1e3, 2, 0, 2e3, 2}};
    for (int wall = 0; wall < 2; wall++)
        for (uint32_t side = 32; side <= 4096; side *= 2) {
            light_shape shape = {.kind = LIGHT_SPOT, .direction_ws = {0, 0, 1}, .outer_rad = 0.7, .range_metres = INFINITY};
            soup        k;
            vxs_light   l;
            soup_init(&k, 1);
            memcpy(k.positions, walls[wall], sizeof walls[wall]);
            assert_int_equal(fit_punctual(&l, &k, &shape, side), VXS_OK);
            double near = wall ? 2 : 4, far = wall ? 2 : 7;
            assert_true(fabs(l.near_metres * exp(l.voxel_metres) - near) < 1e-9);
            assert_true(fabs(l.voxel_metres - fmax(log(far / near) / (side - 3), l.texel_metres)) < 1e-12);
            assert_true(fabs(l.texel_metres - tan(0.7) / (side / 2 - fmin(PUNCTUAL_BORDER_PX, side / 8))) < 1e-12);
        }
}

/* Only what is nearer than the range counts, wherever a triangle's foot and corners are: on the map's sides, too. */
static void range_is_to_the_nearest_point(void **state)
{
    (void)state;
    for (uint32_t side = 8; side <= 512; side *= 2)
        for (int turn = 0; turn < 6 * 4 * 3; turn++) {
            double edge       = 0.5 * side / (side / 2.0 - fmin(PUNCTUAL_BORDER_PX, side / 8)) * 4,
                   flat[3][2] = {{edge, -1}, {90, 300}, {-90, -1}};
            light_shape shape = {.kind = LIGHT_POINT, .range_metres = 4.01};
            soup        k;
            vxs_light   l;
            soup_init(&k, 1);
            for (int corner = 0; corner < 3; corner++) {
                double *at = k.positions + 3 * ((corner + turn) % 3), p[2] = {flat[corner][0], flat[corner][1]};
                for (int q = 0; q < turn / 3 % 4; q++) { /* quarters of a turn about the axis */
                    double t = p[0];
                    p[0] = -p[1], p[1] = t;
                }
                int axis           = turn / 12 % 3;
                at[axis]           = turn / 36 ? -4 : 4;
                at[(axis + 1) % 3] = p[0];
                at[(axis + 2) % 3] = p[1];
            }
            assert_int_equal(fit_punctual(&l, &k, &shape, side), VXS_OK);
            assert_true(fabs(l.near_metres * exp(l.voxel_metres) - 4) < 0.02 || l.near_metres < 4);
            assert_true(l.near_metres * exp(l.voxel_metres * (side - 2)) > 4 - 1e-9);
            shape.range_metres = 3.99;
            assert_int_equal(fit_punctual(&l, &k, &shape, side), VXS_E_NO_CASTER);
        }
}

/* A caster at the light does not take all depth for itself. */
static void far_and_near_keep_together(void **state)
{
    (void)state;
    for (int n = 0; n < 2; n++) {
        light_shape  shape    = {.kind = LIGHT_POINT, .range_metres = n ? 70 : INFINITY};
        const double wall[18] = {-1,   -1,   0,  1,   -1,   0,  0, 1,   1e-9,
                                 -100, -100, 80, 100, -100, 80, 0, 100, 40}; /* through the light */
        soup         k;
        vxs_light    l;
        soup_init(&k, 2);
        memcpy(k.positions, wall, sizeof wall);
        assert_int_equal(fit_punctual(&l, &k, &shape, 1024), VXS_OK);
        double near = l.near_metres * exp(l.voxel_metres), far = l.near_metres * exp(1022 * l.voxel_metres);
        assert_true(fabs(far / near / PUNCTUAL_FAR_NEAR_MAX - 1) < 1e-9);
        assert_true(n ? fabs(far - 70) < 1e-6 : far > 79 && far < 101);
    }
}

/* The ceiling that a punctual light is set into casts nothing: depth begins at what hangs below it. */
static void a_plane_through_the_light_is_no_caster(void **state)
{
    (void)state;
    light_shape  shape      = {.kind = LIGHT_POINT, .position_ws = {0.1, 0.3, 0.7}, .range_metres = INFINITY};
    const double planes[18] = {-5, -5, 0.7, 5, -5, 0.7, 0, 5, 0.7, -5, -5, 2.7, 5, -5, 2.7, 0, 5, 2.7};
    soup         k;
    vxs_light    l;
    soup_init(&k, 2);
    memcpy(k.positions, planes, sizeof planes);
    assert_int_equal(fit_punctual(&l, &k, &shape, 1024), VXS_OK);
    double near = l.near_metres * exp(l.voxel_metres);
    assert_true(near > 1 && near <= 2);
}

static void punctuals_that_reach_nothing(void **state)
{
    (void)state;
    const struct {
        light_shape shape;
        vxs_result  wanted;
    } cases[] = {
        {{LIGHT_SPOT, {0, 0, 0}, {0, 0, 1}, 0.5, INFINITY}, VXS_OK},
        {{LIGHT_SPOT, {0, 0, 0}, {0, 0, -1}, 0.5, INFINITY}, VXS_E_NO_CASTER},  /* behind */
        {{LIGHT_SPOT, {0, 0, 0}, {0, 0, -1}, 1.57, INFINITY}, VXS_E_NO_CASTER}, /* six maps, none of whose cone looks there */
        {{LIGHT_SPOT, {0, 0, 0}, {1, 0, 0}, 0.5, INFINITY}, VXS_E_NO_CASTER},   /* beside */
        {{LIGHT_SPOT, {0, 0, 0}, {0, 0, 1}, 0.5, 9.99}, VXS_E_NO_CASTER},       /* too far */
        {{LIGHT_SPOT, {0, 0, 0}, {0, 0, 1}, 0.5, 10.01}, VXS_OK},
        {{LIGHT_POINT, {0, 0, 0}, {0, 0, 0}, 0, 9.99}, VXS_E_NO_CASTER},
        {{LIGHT_POINT, {0, 0, 0}, {0, 0, 0}, 0, 10.01}, VXS_OK},
        {{LIGHT_POINT, {0, 0, 11}, {0, 0, 0}, 0, 1.01}, VXS_OK},
        {{LIGHT_SPOT, {0, 0, 11}, {0, 0, 1}, 1.0, INFINITY}, VXS_E_NO_CASTER},
        {{LIGHT_SPOT, {0, 0, 0}, {0, 0, 1}, 1e-9, INFINITY}, VXS_E_ARGUMENT}, /* no cosine tells it from 1 */
    };
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        soup      k;
        vxs_light l;
        soup_init(&k, 1);
        memcpy(k.positions, (const double[9]){-3, -3, 10, 3, -3, 10, 0, 3, 10}, 9 * sizeof(double));
        assert_int_equal(fit_punctual(&l, &k, &cases[n].shape, 256), cases[n].wanted);
    }
}

/* The least power of two whose texels are no larger where the light ends. */
static void punctual_texel_sizes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 500; seed++) {
        rng            r       = rng_split(seed, 32);
        light_shape    shape   = random_shape(&r);
        const double   here[3] = {0};
        soup           k;
        vxs_light      l;
        run_context    m = {0};
        light_fit_desc d = punctual_desc(&shape, 0);
        random_soup(&k, &r, &shape, here, 1);
        d.texel_metres    = pow(10, between(&r, -2.5, 0.5));
        vxs_result result = light_fit(&l, &k.c, &d, &m);
        if (result == VXS_E_NO_CASTER) continue;
        if (result == VXS_E_ARGUMENT) {
            assert_non_null(strstr(m.error, "--texel"));
            assert_int_equal(fit_punctual(&l, &k, &shape, d.resolution_max), VXS_OK); /* indeed the largest map is too small */
            assert_true(l.near_metres * exp((d.resolution_max - 2) * l.voxel_metres) * l.texel_metres > d.texel_metres);
            continue;
        }
        assert_int_equal(result, VXS_OK);
        assert_punctual_holds(&l, &k, &shape, 1e-6, seed);
        double side = ldexp(1, (int)l.levels), far = l.near_metres * exp((side - 2) * l.voxel_metres);
        double half    = l.texel_metres * (side / 2 - fmin(PUNCTUAL_BORDER_PX, side / 8)),
               coarser = half / (side / 4 - fmin(PUNCTUAL_BORDER_PX, side / 16));
        int loose      = l.voxel_metres == l.texel_metres; /* then the far side is behind what is reached */
        if (!loose) assert_true(far * l.texel_metres <= d.texel_metres * (1 + 1e-9));
        if (!loose && side > 8) assert_true(far * coarser > d.texel_metres * (1 - 1e-9));
    }
    light_shape    shape = {.kind = LIGHT_POINT, .range_metres = INFINITY};
    light_fit_desc d     = punctual_desc(&shape, 0);
    soup           k;
    vxs_light      l;
    run_context    m = {0};
    soup_init(&k, 1);
    memcpy(k.positions, (const double[9]){-3, -3, 10, 3, -3, 10, 0, 3, 10}, 9 * sizeof(double));
    d.texel_metres = 0.001;
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_E_ARGUMENT);
    assert_non_null(strstr(m.error, "--texel"));
    d.texel_metres = 0.05;
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_OK);
    assert_int_equal(l.levels, 9); /* 20 m in 400 texels and two borders */
}

/* What the runtime promises of borders: from 256 texels no filter leaves the map, with the step along a normal that faces the
 * light. */
static void borders_hold_every_filter(void **state)
{
    (void)state;
    rng r     = {33};
    int asked = 0;
    for (int n = 0; n < 20000; n++) {
        light_shape shape = random_shape(&r);
        soup        k;
        vxs_light   l;
        shape.range_metres = INFINITY;
        soup_init(&k, 1);
        memcpy(k.positions, (const double[9]){-300, -300, 10, 300, -300, 10, 0, 300, 10}, 9 * sizeof(double));
        if (fit_punctual(&l, &k, &shape, n % 2 ? 256 : 512) != VXS_OK) continue;
        for (int q = 0; q < 20; q++) {
            double  way[3] = {0}, normal[3] = {0}, point[3], wide = 1 - pow(10, between(&r, -9, -2));
            int32_t voxel[3], side = 1 << l.levels;
            random_direction(way, &r);
            if (shape.kind == LIGHT_SPOT && shape.outer_rad < 1.05) /* the edge of the cone */
                for (int c = 0; c < 3; c++)
                    way[c] = cos(shape.outer_rad * wide) * shape.direction_ws[c] +
                             sin(shape.outer_rad * wide) * l.ls_from_ws[4 * (q & 1) + c] * (q & 2 ? 1 : -1);
            else if (shape.kind == LIGHT_POINT) /* an edge of the cube */
                for (int c = 0; c < 3; c++) way[c] = c == q % 3 ? 1 : c == (q + 1) % 3 ? wide * (q & 1 ? 1 : -1) : way[c] * 0.99;
            random_direction(normal, &r);
            double facing = vec3_dot(normal, way);
            for (int c = 0; c < 3; c++) point[c] = shape.position_ws[c] + 5 * way[c];
            if (facing > 0)
                for (int c = 0; c < 3; c++) normal[c] = -normal[c];
            if (q % 4 == 0) { /* grazed: the farthest step */
                for (int c = 0; c < 3; c++) normal[c] -= way[c] * vec3_dot(normal, way) / vec3_dot(way, way);
                double length = sqrt(vec3_dot(normal, normal));
                for (int c = 0; c < 3; c++) normal[c] /= length;
            }
            if (vxs_voxel(&l, point, normal, vxs_box(VXS_FILTER_MAX), voxel) < 0) continue;
            for (int c = 0; c < 2; c++) assert_true(voxel[c] >= VXS_FILTER_MAX / 2 && voxel[c] < side - VXS_FILTER_MAX / 2);
            asked++;
        }
    }
    assert_true(asked > 100000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_caster_is_inside),
        cmocka_unit_test(special_directions),
        cmocka_unit_test(huge_coordinates),
        cmocka_unit_test(flat_scenes),
        cmocka_unit_test(a_point_cannot_be_fitted),
        cmocka_unit_test(regions),
        cmocka_unit_test(texel_sizes),
        cmocka_unit_test(long_names),
        cmocka_unit_test(punctuals_hold_what_they_reach),
        cmocka_unit_test(punctuals_far_off_and_tiny),
        cmocka_unit_test(punctuals_fit_tightly),
        cmocka_unit_test(range_is_to_the_nearest_point),
        cmocka_unit_test(far_and_near_keep_together),
        cmocka_unit_test(a_plane_through_the_light_is_no_caster),
        cmocka_unit_test(punctuals_that_reach_nothing),
        cmocka_unit_test(punctual_texel_sizes),
        cmocka_unit_test(borders_hold_every_filter),
    };
    return cmocka_run_group_tests_name("light_fit", tests, NULL, NULL);
}
