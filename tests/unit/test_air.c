/* Airlight of runtime/volumes/vxs_air.h against adaptive quadrature in double (tests/volumes/airlight.h), in C and in a shader.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include "repeats.h"
/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_points.h"

#include "air_questions.h"

static void air_of(const question *q, double airlight[3])
{
    vxs_medium  medium;
    vxs_air_ray ray;
    ask_c(q, &medium, &ray);
    vxs_air_punctual(&medium, &ray, q->begin, q->length, airlight);
}

typedef question random_maker(rng *r, double least_beside, int spots);

static errors errors_in_c(random_maker *random, int spots, uint32_t least)
{
    rng      r     = {(uint64_t)(1 + spots)};
    errors   e     = {0};
    uint32_t count = repeats(least, 100000);
    for (uint32_t n = 0; n < count; n++) {
        question q = random(&r, 1e-6, spots);
        double   found[3];
        air_of(&q, found);
        count_errors(&e, &q, found);
    }
    return e;
}

static void test_points(void **state)
{
    (void)state;
    errors e = errors_in_c(random_question, 0, 4000);
    check_errors(&e, 1e-3 * repeats(5, 60), 1e-4, 0.02, repeats(4000, 100000));
}

static void test_spots(void **state)
{
    (void)state;
    errors e = errors_in_c(random_question, 1, 1500);
    check_errors(&e, 1e-2, 1e-4, 0.01, repeats(1500, 100000));
}

/* Punctual lights whose range ends in the segment, or behind it. */
static void test_ranges(void **state)
{
    (void)state;
    errors points = errors_in_c(random_question_in_range, 0, 2000), spots = errors_in_c(random_question_in_range, 1, 600);
    errors points_below = errors_in_c(random_question_below_in_range, 0, 600),
           spots_below  = errors_in_c(random_question_below_in_range, 1, 300);
    check_errors(&points, 1e-3 * repeats(5, 60), 1e-4, 0.02, repeats(2000, 100000));
    check_errors(&spots, 1e-2, 1e-4, 0.01, repeats(600, 100000));
    check_errors(&points_below, 1e-3 * repeats(5, 60), 5e-5, 0.01, repeats(900, 100000));
    check_errors(&spots_below, 1e-2, 1e-4, 0.01, repeats(400, 80000));
}

/* Faces, which shine to one side: the part of the ray before them, and airlight there. */
static void test_faces(void **state)
{
    (void)state;
    rng      r    = {8};
    uint32_t part = 0, none = 0, bad = 0;
    double   mean = 0, most = 0, channels = 0;
    for (uint32_t n = 0; n < repeats(1000, 50000); n++) {
        double     to_light[3], direction[3], normal[3], before[2] = {0, uniform(&r, 1, 40)}, found[3];
        vxs_medium medium = {.anisotropy = uniform(&r, -0.8, 0.8)};
        random_direction(&r, direction);
        random_direction(&r, normal);
        for (int i = 0; i < 3; i++) {
            to_light[i]          = uniform(&r, -10, 10);
            medium.extinction[i] = medium.scattering[i] = spread(&r, 1e-3, 1);
        }
        double      end = before[1];
        vxs_air_ray ray = vxs_air_ray_of_face(to_light, direction, 1e-2, normal);
        vxs_air_before_face(&ray, before);
        for (int k = 0; k < 10; k++) {
            double x = uniform(&r, 0, end), way[3];
            for (int i = 0; i < 3; i++) way[i] = direction[i] * x - to_light[i];
            if (fabs(dot(way, normal)) > 1e-9) assert_int_equal(dot(way, normal) > 0, x >= before[0] && x <= before[1]);
        }
        part += before[1] > before[0] && before[1] - before[0] < end;
        none += !(before[1] > before[0]);
        if (!(before[1] > before[0])) continue;
        air_passing p = air_passing_of(direction, to_light, 1e-2, normal, 1, 0);
        p.is_face     = 1;
        vxs_air_punctual(&medium, &ray, before[0], before[1] - before[0], found);
        for (int i = 0; i < 3; i++) {
            double wanted = medium.scattering[i] *
                            air_of_punctual(&p, medium.anisotropy, medium.extinction[i], before[0], before[1] - before[0]);
            double error = fabs(found[i] / wanted - 1);
            most         = fmax(most, error);
            mean += error;
            bad += error > 1e-3;
            channels++;
        }
    }
    print_message("%.0f channels of faces: relative error %.1e at most, %.1e in the mean, 1e-3 and more in %u\n", channels, most,
                  mean / channels, bad);
    assert_true(part > 100 && none > 100 && channels > 1000);
    assert_true(most < 2e-2 && mean / channels < 1e-4);
}

/* Punctual lights above the level top of fog, at it, and far above. */
static void test_points_below_top(void **state)
{
    (void)state;
    errors e = errors_in_c(random_question_below, 0, 1000);
    check_errors(&e, 1e-3 * repeats(5, 60), 5e-5, 0.01, repeats(1500, 150000));
}

static void test_spots_below_top(void **state)
{
    (void)state;
    errors e = errors_in_c(random_question_below, 1, 400);
    check_errors(&e, 1e-2, 1e-4, 0.01, repeats(600, 100000));
}

/* The sun's, in fog with a top or without, against the same integrand place by place. */
static void test_sun(void **state)
{
    (void)state;
    rng      r      = {5};
    uint32_t rising = 0;
    for (uint32_t n = 0; n < repeats(10000, 100000); n++) {
        double up = uniform(&r, -1, 1), to_sun_y = uniform(&r, 0.05, 1), height = uniform(&r, -100, 100),
               top     = uniform(&r, -100, 100);
        double part[2] = {0, spread(&r, 1e-6, 1e4)}, cosine = uniform(&r, -1, 1), airlight[3];
        vxs_air_in_fog(height, up, top, part);
        for (int k = 0; k < 20; k++) { /* it is in the part where it is in fog */
            double x = uniform(&r, 0, 200);
            if (part[1] > part[0] && x > part[0] + 1e-9 && x < part[1] - 1e-9) assert_true(height + up * x <= top + 1e-6);
            if (x < part[0] - 1e-9) assert_true(height + up * x >= top - 1e-6);
        }
        if (part[1] <= part[0]) continue;
        vxs_medium medium = {.anisotropy = uniform(&r, -0.99, 0.99)};
        double     way = (top - height - up * part[0]) / to_sun_y, slope = 1 - up / to_sun_y, length = part[1] - part[0];
        for (int i = 0; i < 3; i++) medium.scattering[i] = medium.extinction[i] = i ? spread(&r, 1e-6, 1e2) / length : 0;
        vxs_air_sun(&medium, cosine, length, way, slope, airlight);
        rising += slope < 0;
        for (int i = 0; i < 3; i++) {
            double wanted =
                medium.scattering[i] * air_of_sun(cosine, medium.anisotropy, medium.extinction[i], way, slope, 0, length);
            assert_true(isfinite(airlight[i]) && airlight[i] >= 0);
            if (wanted > 1e-200) assert_true(fabs(airlight[i] / wanted - 1) < 1e-9);
        }
    }
    assert_true(rising > 1000);
}

/* All light that turns goes somewhere. */
static void test_phase(void **state)
{
    (void)state;
    for (int n = -99; n <= 99; n += 3) {
        enum { STEPS = 100000 };
        double sum = 0;
        for (int k = 0; k < STEPS; k++) {
            double angle = M_PI * (k + 0.5) / STEPS;
            sum += 2 * M_PI * sin(angle) * vxs_air_phase(n / 100.0, cos(angle)) * M_PI / STEPS;
        }
        assert_float_equal(sum, 1, 1e-5);
    }
}

/* The part of a ray in a cone is where its places are. */
static void test_cones(void **state)
{
    (void)state;
    rng      r      = {6};
    uint32_t inside = 0;
    for (uint32_t n = 0; n < repeats(20000, 200000); n++) {
        double to_light[3], direction[3], axis[3], cosine = cos(uniform(&r, 0.05, M_PI / 2)), part[2] = {0, 100};
        random_direction(&r, direction);
        random_direction(&r, axis);
        for (int i = 0; i < 3; i++) to_light[i] = uniform(&r, -30, 30);
        vxs_air_ray ray = vxs_air_ray_of_spot(to_light, direction, 1e-3, axis, 1, cosine);
        vxs_air_in_cone(&ray, cosine, part);
        for (int k = 0; k < 20; k++) {
            double x = uniform(&r, 0, 100), way[3], dot = 0, square = 0;
            for (int i = 0; i < 3; i++) {
                way[i] = direction[i] * x - to_light[i];
                dot += way[i] * axis[i];
                square += way[i] * way[i];
            }
            double margin = dot - cosine * sqrt(square);
            if (fabs(margin) < 1e-6) continue;
            assert_int_equal(margin > 0, x >= part[0] && x <= part[1]);
            inside += margin > 0;
        }
    }
    assert_true(inside > 20000);
}

/* One interval of a ray in a cone, by places.   Returns how many places are in the cone */
static uint32_t check_cone(const double to_light[3], const double direction[3], const double axis[3], double cosine)
{
    enum { PLACES = 400 };
    vxs_air_ray ray     = vxs_air_ray_of_spot(to_light, direction, 1e-9, axis, 1, cosine);
    double      part[2] = {0, 100};
    uint32_t    inside  = 0;
    vxs_air_in_cone(&ray, cosine, part);
    assert_true(part[0] == part[0] && part[1] == part[1]);
    for (int k = 0; k < PLACES; k++) {
        double x = k % 2 ? 100.0 * k / PLACES : pow(10, -6 + 8.0 * k / PLACES), way[3], dot = 0, square = 0;
        for (int i = 0; i < 3; i++) {
            way[i] = direction[i] * x - to_light[i];
            dot += way[i] * axis[i];
            square += way[i] * way[i];
        }
        double margin = dot - cosine * sqrt(square);
        if (fabs(margin) < 1e-7 * (1 + sqrt(square)) * (1 + cosine)) continue; /* on the side itself */
        if ((margin > 0) != (x >= part[0] && x <= part[1]))
            fail_msg("at %g of a ray (%g %g %g) the lamp at (%g %g %g), cosine %g: margin %g, part [%g, %g]", x, direction[0],
                     direction[1], direction[2], to_light[0], to_light[1], to_light[2], cosine, margin, part[0], part[1]);
        inside += margin > 0;
    }
    return inside;
}

/* Rays that are parallel to a side of the cone to the last bit, and turned a little; through its tip, along its axis, along its
 * side, and inside. */
static void test_rays_along_cones(void **state)
{
    (void)state;
    static const double turns[]        = {0, 1e-16, 1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3};
    static const double axis[3]        = {0, -1, 0};
    static const double punctuals[][3] = {{-1, 5, 0}, {1, 5, 0},  {-3, 2, 0}, {-3, 2, 1}, {3, -2, 0}, {0, 5, 0},
                                          {0, 1, 0},  {0, -4, 0}, {5, 0, 0},  {0, 0, 2},  {0, 0, 0}};
    uint32_t            parallel = 0, inside = 0;
    double              most = 0;
    for (int angle = 0; angle <= 90; angle += 5)
        for (size_t t = 0; t < sizeof turns / sizeof *turns; t++)
            for (size_t l = 0; l < sizeof punctuals / sizeof *punctuals; l++)
                for (int back = -1; back <= 1; back += 2) {
                    double cosine = angle == 90 ? 0 : cos(angle * M_PI / 180), side = sin(angle * M_PI / 180);
                    double direction[3] = {back * side + turns[t], -back * cosine, 0}, size = 0, found[3];
                    for (int i = 0; i < 3; i++) size += direction[i] * direction[i];
                    for (int i = 0; i < 3 && turns[t] != 0; i++) direction[i] /= sqrt(size);
                    parallel += fabs(direction[1]) == cosine;
                    inside += check_cone(punctuals[l], direction, axis, cosine);
                    check_cone(punctuals[l], direction, (const double[]){0, 1, 0}, cosine);
                    if (angle == 0 || punctuals[l][0] * punctuals[l][0] + punctuals[l][2] * punctuals[l][2] == 0) continue;
                    /* and what that part scatters */
                    vxs_medium  medium = {{0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}, 0.2};
                    double      inner  = cosine + 0.3 * (1 - cosine);
                    vxs_air_ray ray    = vxs_air_ray_of_spot(punctuals[l], direction, 1e-2, axis, inner, cosine);
                    air_passing p = air_passing_of(direction, punctuals[l], 1e-2, axis, inner, cosine), all = p;
                    all.is_spot = 0;
                    vxs_air_punctual(&medium, &ray, 0, 50, found);
                    double wanted = 0.1 * air_of_punctual(&p, 0.2, 0.1, 0, 50),
                           scale  = fmax(wanted, 0.001 * air_of_punctual(&all, 0.2, 0.1, 0, 50));
                    assert_true(isfinite(found[0]));
                    most = fmax(most, fabs(found[0] - wanted) / scale);
                }
    print_message("%u rays of cosines that are equal, %u places in cones; airlight off by %.1e at most\n", parallel, inside, most);
    assert_true(parallel > 200 && inside > 10000);
    assert_true(most < 5e-3);
}

/* Airlight of a metre is what reaches the place, times what turns there and is left on the way to the eye; where no path is,
 * nothing reaches a place in the fog. */
static void test_reaches(void **state)
{
    (void)state;
    rng      r  = {9};
    uint32_t on = 0, off = 0, above = 0;
    for (uint32_t n = 0; n < repeats(20000, 400000); n++) {
        vxs_air_light light  = {.kind = 1 + rng_below(&r, 3), .cos_outer = uniform(&r, 0, 1), .radius_metres = 1e-9};
        vxs_medium    medium = {.anisotropy = uniform(&r, -0.9, 0.9)};
        double eye[3], way[3], at[3], to_light[3], reaches[3], air[3], in_fog[2], metres = 100, x = uniform(&r, 0, 100), facing = 0;
        double top      = rng_below(&r, 2) ? uniform(&r, -20, 20) : VXS_AIR_EVERYWHERE;
        light.cos_inner = uniform(&r, light.cos_outer, 1);
        if (light.kind != VXS_LIGHT_KIND_DIRECTIONAL && rng_below(&r, 2)) light.range_metres = uniform(&r, 1, 80);
        random_direction(&r, way);
        random_direction(&r, light.axis);
        random_direction(&r, light.place);
        for (int i = 0; i < 3; i++) {
            eye[i] = uniform(&r, -20, 20);
            at[i]  = eye[i] + x * way[i];
            if (light.kind != VXS_LIGHT_KIND_DIRECTIONAL) light.place[i] = uniform(&r, -20, 20);
            medium.extinction[i] = uniform(&r, 0, 0.1);
            medium.scattering[i] = medium.extinction[i] * rng_unit(&r);
        }
        vxs_air_path path = vxs_air_path_of(&light, eye, way, metres, top, in_fog);
        vxs_air_reaches(&medium, &light, at, top, to_light, reaches);
        if (fabs(x - path.begin) < 1e-6 || fabs(x - path.end) < 1e-6 || fabs(x - in_fog[0]) < 1e-6 || fabs(x - in_fog[1]) < 1e-6)
            continue;
        if (x < path.begin || x > path.end) {
            if (x < in_fog[0] || x > in_fog[1]) continue;
            for (int i = 0; i < 3; i++) assert_true(reaches[i] < 1e-12);
            off++;
            continue;
        }
        for (int i = 0; i < 3; i++) facing += to_light[i] * way[i];
        vxs_air_at(&medium, &path, x, air);
        for (int i = 0; i < 3; i++) {
            double wanted = medium.scattering[i] * vxs_air_phase(medium.anisotropy, facing) * reaches[i] *
                            exp(-medium.extinction[i] * (x - in_fog[0]));
            assert_true(fabs(air[i] - wanted) <= 1e-9 * wanted + 1e-15);
        }
        above += top < VXS_AIR_EVERYWHERE && light.kind != VXS_LIGHT_KIND_DIRECTIONAL && light.place[1] > top;
        on++;
    }
    assert_true(on > 5000 && off > 1000 && above > 300);
    /* glTF's window and rim */
    assert_true(vxs_air_window(2, 0.5) == 0 && vxs_air_window(3, 0.5) == 0 && vxs_air_window(9, 0) == 1);
    assert_true(fabs(vxs_air_window(1, 0.5) - 15 / 16.0) < 1e-15);
    assert_true(fabs(vxs_air_rim(0.75, 1, 0.5) - 0.25) < 1e-15 && vxs_air_rim(0.4, 1, 0.5) == 0);
}

/* The light's distance from the ray is a difference in a shader: it is no less than a thousandth of the distance here. */
static errors errors_in_shader(const drawing *d, random_maker *random, int spots, uint32_t least)
{
    enum { ASKED = QUERIES / 3 };
    static question questions[ASKED];
    static query    queries[QUERIES];
    static float    answers[QUERIES];
    rng             r = {(uint64_t)(3 + spots)};
    errors          e = {0};
    for (int n = 0; n < ASKED; n++) questions[n] = random(&r, 1e-3, spots);
    bind_buffer(d, GL_SHADER_STORAGE_BUFFER, sizeof questions, questions);
    draw(d, queries, answers);
    for (uint32_t n = 0; n < repeats(least, ASKED); n++) {
        double found[3];
        for (int i = 0; i < 3; i++) found[i] = (double)answers[3 * n + i];
        count_errors(&e, &questions[n], found);
    }
    return e;
}

static void test_shader(void **state)
{
    (void)state;
    drawing d = drawing_make();
    use_air(&d, "#define ask_lamp vxs_air_punctual\n");
    errors points = errors_in_shader(&d, random_question, 0, QUERIES / 3), spots = errors_in_shader(&d, random_question, 1, 1500);
    errors points_below    = errors_in_shader(&d, random_question_below, 0, 1000),
           spots_below     = errors_in_shader(&d, random_question_below, 1, 400);
    errors points_in_range = errors_in_shader(&d, random_question_in_range, 0, 1500),
           spots_in_range  = errors_in_shader(&d, random_question_in_range, 1, 400);
    check_errors(&points, 1e-2, 2e-4, 0.03, 6000);
    check_errors(&spots, 1.1, 1e-3, 0.025, repeats(1500, 6000)); /* one that runs along the side of a cone ends anywhere */
    check_errors(&points_below, 1e-2, 1e-4, 0.015, repeats(1500, 6000));
    check_errors(&spots_below, 1.1, 1e-3, 0.025, repeats(600, 6000));
    check_errors(&points_in_range, 1e-2, 2e-4, 0.03, repeats(2500, 6000));
    check_errors(&spots_in_range, 1.1, 1e-3, 0.025, repeats(500, 6000));
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points),
        cmocka_unit_test(test_faces),
        cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_spots),
        cmocka_unit_test(test_points_below_top),
        cmocka_unit_test(test_spots_below_top),
        cmocka_unit_test(test_sun),
        cmocka_unit_test(test_phase),
        cmocka_unit_test(test_cones),
        cmocka_unit_test(test_rays_along_cones),
        cmocka_unit_test(test_reaches),
        cmocka_unit_test(test_shader),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
