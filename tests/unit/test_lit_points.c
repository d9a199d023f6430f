/* Random points of what a light can light, against areas in closed form (baker/light/lit_points.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "baker/light/light_fit.h" /* before cmocka, whose fail() is a macro */
#include "baker/light/lit_points.h"

#include <cmocka.h>

enum { POINTS = 8192, GRID = 8, TRIANGLES = 2 + 2 * GRID * GRID };
static const double PI = 3.14159265358979323846, SIDE = 40, SMALL = 1;

/* A floor of two triangles at height 0, component 0, and a finely divided square above its corner, component 1. */
typedef struct floor_scene {
    double   positions[3 * 3 * TRIANGLES];
    uint32_t indices[3 * TRIANGLES], component_of[TRIANGLES];
    size_t   mask_first[1];
    casters  c;
} floor_scene;

static void add_square(floor_scene *s, double x, double y, double z, double side, uint32_t component)
{
    static const int corners[6][2] = {{0, 0}, {0, 1}, {1, 1}, {0, 0}, {1, 1}, {1, 0}};
    for (int n = 0; n < 6; n++) {
        double *p                              = s->positions + 3 * s->c.vertex_count;
        p[0]                                   = x + side * corners[n][0];
        p[1]                                   = y;
        p[2]                                   = z + side * corners[n][1];
        s->indices[s->c.vertex_count]          = (uint32_t)s->c.vertex_count;
        s->component_of[s->c.vertex_count / 3] = component;
        s->c.vertex_count++;
    }
    s->c.triangle_count = s->c.holed_first = s->mask_first[0] = s->c.vertex_count / 3;
}

static void make(floor_scene *s)
{
    run_context m = {0};
    memset(s, 0, sizeof *s);
    s->c.positions_ws     = s->positions;
    s->c.indices          = s->indices;
    s->c.component_of     = s->component_of;
    s->c.alpha_mask_first = s->mask_first;
    add_square(s, -SIDE / 2, 0, -SIDE / 2, SIDE, 0);
    for (int n = 0; n < GRID * GRID; n++)
        add_square(s, 18 + SMALL * (n % GRID) / GRID, 1, 18 + SMALL * (n / GRID) / GRID, SMALL / GRID, 1);
    assert_int_equal(casters_find_runs(&s->c, &m), VXS_OK);
}

/* The points of a light, and the sum of what they stand for, square metres. */
static size_t choose(floor_scene *s, const light_shape *shape, const uint32_t *object_of, uint32_t without, size_t triangles_max,
                     lit_point *points, double *area)
{
    run_context    m = {0};
    vxs_light      light;
    light_fit_desc fit = {.name = "l", .shape = shape, .resolution = 1024};
    assert_int_equal(light_fit(&light, &s->c, &fit, &m), VXS_OK);
    lit_points_desc d     = {&s->c, shape, &light, object_of, without, triangles_max};
    size_t          count = lit_points_choose(points, POINTS, &d);
    *area                 = 0;
    for (size_t n = 0; n < count; n++) {
        assert_true(light_reaches(shape, points[n].at_ws));
        *area += points[n].weight;
    }
    return count;
}

static void assert_about(double found, double expected, double share)
{
    if (!(fabs(found - expected) <= share * expected)) print_message("found %g, expected %g\n", found, expected);
    assert_true(fabs(found - expected) <= share * expected);
}

static lit_point points[POINTS], others[POINTS];

static void test_a_sun_reaches_all(void **state)
{
    static floor_scene s;
    light_shape        sun = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {0.3, -0.9, 0.1}};
    double             area;
    size_t             on_small = 0;
    (void)state;
    make(&s);
    assert_int_equal(choose(&s, &sun, NULL, 0, 0, points, &area), POINTS);
    assert_about(area, SIDE * SIDE + SMALL * SMALL, 0.03);
    for (size_t n = 0; n < POINTS; n++) {
        const double *p     = points[n].at_ws;
        int           small = points[n].triangle >= 2;
        on_small += (size_t)small;
        assert_true(fabs(p[1] - small) < 1e-9 && fabs(p[0]) <= SIDE / 2 && fabs(p[2]) <= SIDE / 2 && points[n].along_metres == 0);
    }
    assert_in_range(on_small, POINTS * 45 / 100, POINTS * 55 / 100); /* the half that goes by triangles */
    free(s.c.runs);
}

/* Of the floor 5 m below a punctual light: a disc, which the cone or the range cuts out. */
static void test_a_punctual_reaches_a_disc(void **state)
{
    static floor_scene s;
    const double       height = 5;
    light_shape        spot   = {LIGHT_SPOT, {0, 5, 0}, {0, -1, 0}, 0.5, INFINITY},
                wide          = {LIGHT_SPOT, {0, 5, 0}, {0, -1, 0}, 1.2, INFINITY},
                bulb          = {.kind = LIGHT_POINT, .position_ws = {0, 5, 0}, .range_metres = 8};
    double area;
    (void)state;
    make(&s);
    size_t count = choose(&s, &spot, NULL, 0, 0, points, &area);
    assert_about(area, PI * pow(height * tan(0.5), 2), 0.05);
    for (size_t n = 0; n < count; n++) assert_true(fabs(points[n].along_metres - height) < 1e-9);
    choose(&s, &wide, NULL, 0, 0, points, &area);
    assert_about(area, PI * pow(height * tan(1.2), 2), 0.05);
    count = choose(&s, &bulb, NULL, 0, 0, points, &area);
    assert_about(area, PI * (64 - height * height), 0.05);
    for (size_t n = 0; n < count; n++) { /* along the axis of the cube's face that sees it */
        const double *p = points[n].at_ws;
        assert_true(fabs(points[n].along_metres - fmax(height, fmax(fabs(p[0]), fabs(p[2])))) < 1e-9);
    }
    free(s.c.runs);
}

static void test_without_an_object(void **state)
{
    static floor_scene    s;
    static const uint32_t object_of[2] = {0, 1};
    light_shape           bulb         = {.kind = LIGHT_POINT, .position_ws = {17, 4, 17}, .range_metres = INFINITY};
    double                area;
    (void)state;
    make(&s);
    size_t count = choose(&s, &bulb, object_of, 0, 0, points, &area);
    assert_about(area, SMALL * SMALL, 0.03);
    for (size_t n = 0; n < count; n++) assert_true(points[n].triangle >= 2);
    count = choose(&s, &bulb, object_of, 1, 0, points, &area);
    assert_about(area, SIDE * SIDE, 0.03);
    for (size_t n = 0; n < count; n++) assert_true(points[n].triangle < 2);
    free(s.c.runs);
}

static void test_thinned_out(void **state)
{
    static floor_scene s;
    light_shape        sun = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {0, -1, 0}},
                far        = {.kind = LIGHT_POINT, .position_ws = {900, 5, 0}, .range_metres = 3};
    double area, again;
    (void)state;
    make(&s);
    assert_int_equal(choose(&s, &sun, NULL, 0, 33, points, &area), POINTS);
    for (size_t n = 0; n < POINTS; n++) assert_int_equal(points[n].triangle % 4, 0); /* 130 triangles */
    choose(&s, &sun, NULL, 0, 33, others, &again);
    assert_true(area == again && !memcmp(points, others, sizeof points));

    vxs_light light = {.kind = VXS_LIGHT_KIND_POINT, .flags = VXS_LIGHT_CUBE, .levels = 8, .texel_metres = 0.01, .near_metres = 1};
    lit_points_desc d = {&s.c, &far, &light, NULL, 0, 0};
    assert_int_equal(lit_points_choose(points, POINTS, &d), 0);
    free(s.c.runs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_a_sun_reaches_all), cmocka_unit_test(test_a_punctual_reaches_a_disc),
                                       cmocka_unit_test(test_without_an_object), cmocka_unit_test(test_thinned_out)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
