/* Where a sun's map lies: all casters inside with the margins that lookups count on (baker/maps/light_fit.h).
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
#include "baker/maps/light_fit.h" /* before cmocka, whose fail() is a macro */

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
    message        m = {0};
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
    message        m = {0};
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
        message        m = {0};
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
        message        m = {0};
        d.texel_metres   = cases[n].texel;
        assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_OK);
        assert_int_equal(1u << l.levels, cases[n].side);
        assert_true(l.texel_metres == cases[n].texel);
        assert_axes(&l, down);
        assert_margins(&l, k.positions, POINTS, 1e-6);
    }
    light_fit_desc d = desc_of(down, 0);
    vxs_light      l;
    message        m = {0};
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
    message        m = {.quiet = 1};
    d.name           = name;
    assert_int_equal(light_fit(&l, &k.c, &d, &m), VXS_OK);
    assert_int_equal(strlen(l.name), sizeof l.name - 1);
    message_free(&m);
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
    };
    return cmocka_run_group_tests_name("light_fit", tests, NULL, NULL);
}
