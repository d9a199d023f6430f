/* Epipolar space of runtime/volumes/vxs_epipolar.h: places to angles and back, in C and in a shader, and the angles that a view can
 * see.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "random_light.h"
#include "repeats.h"
#include "runtime/volumes/vxs_epipolar.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_points.h"
#include "read_text.h"

/* Uniform in the logarithm. */
static double spread(rng *r, double low, double high)
{
    return exp(uniform(r, log(low), log(high)));
}

/* An image of any size, seen to any side: from a telescope to nearly half of all ways. */
static vxs_epipolar_view random_view(rng *r, double far_metres)
{
    vxs_epipolar_view view = {.far_metres = far_metres};
    double            ahead[3], up[3], right[3], wide = spread(r, 1e-4, 10), high = wide * spread(r, 0.3, 3);
    random_direction(r, ahead);
    random_direction(r, up);
    cross(ahead, up, right);
    make_unit(right);
    cross(right, ahead, up);
    for (int n = 0; n < 4; n++) {
        double x = n == 1 || n == 2 ? wide : -wide, y = n >= 2 ? high : -high;
        for (int i = 0; i < 3; i++) view.corners[n][i] = 3 * (ahead[i] + x * right[i] + y * up[i]);
    }
    return view;
}

/* A way through the image: to a side of it (least < 1), or anywhere in it. */
static void random_in_view(rng *r, const vxs_epipolar_view *view, double *direction)
{
    double x = uniform(r, 0, 1), y = uniform(r, 0, 1);
    if (!rng_below(r, 4)) x = rng_below(r, 2);
    if (!rng_below(r, 4)) y = rng_below(r, 2);
    for (int i = 0; i < 3; i++)
        direction[i] = (1 - y) * ((1 - x) * view->corners[0][i] + x * view->corners[1][i]) +
                       y * ((1 - x) * view->corners[3][i] + x * view->corners[2][i]);
    make_unit(direction);
}

/* Punctual lights and suns: before the eye and behind it, on the axis of the view and off it, near and far. */
static vxs_epipolar random_space(rng *r, const vxs_epipolar_view *view, double *to_light, int *is_sun)
{
    double distance = spread(r, 1e-3, 1e4), sign = rng_below(r, 2) ? 1 : -1;
    *is_sun = !rng_below(r, 4);
    switch (rng_below(r, 4)) {
    case 0: /* in the view, or opposite */ random_in_view(r, view, to_light); break;
    case 1: /* on its axis, or next to it */
        for (int i = 0; i < 3; i++)
            to_light[i] =
                view->corners[0][i] + view->corners[2][i] + (rng_below(r, 2) ? 0 : uniform(r, -1, 1) * spread(r, 1e-12, 1e-3));
        make_unit(to_light);
        break;
    default: random_direction(r, to_light);
    }
    for (int i = 0; i < 3; i++) to_light[i] *= sign * distance;
    return *is_sun ? vxs_epipolar_of_sun(to_light, view) : vxs_epipolar_of_punctual(to_light, view);
}

/* The same angles as the paper has them, by vectors. */
static void angles_of(const vxs_epipolar *space, const double *to_light, int is_sun, const double *place, double *angles)
{
    double axis[3], from[3], across[3];
    memcpy(axis, to_light, sizeof axis);
    make_unit(axis);
    cross(axis, place, across);
    angles[0] = atan2(sqrt(dot(across, across)), dot(axis, place));
    angles[1] = atan2(dot(space->side, place), dot(space->ahead, place));
    angles[2] = sqrt(dot(across, across));
    if (is_sun) return;
    for (int i = 0; i < 3; i++) from[i] = place[i] - to_light[i];
    cross(to_light, from, across);
    angles[2] = atan2(sqrt(dot(across, across)), -dot(to_light, from));
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

static void test_frame(void **state)
{
    (void)state;
    rng r = {1};
    for (uint32_t n = 0; n < repeats(20000, 200000); n++) {
        vxs_epipolar_view view = random_view(&r, 100);
        double            to_light[3], way[3];
        int               is_sun;
        vxs_epipolar      space = random_space(&r, &view, to_light, &is_sun);
        assert_true(fabs(dot(space.axis, space.ahead)) < 1e-14 && fabs(dot(space.axis, space.side)) < 1e-14 &&
                    fabs(dot(space.ahead, space.side)) < 1e-14);
        assert_float_equal(dot(space.axis, space.axis), 1, 1e-14);
        assert_float_equal(dot(space.ahead, space.ahead), 1, 1e-14);
        assert_float_equal(dot(space.side, space.side), 1, 1e-14);
        cross(space.axis, space.ahead, way);
        assert_true(dot(way, space.side) > 0.999);
        assert_true(dot(space.axis, to_light) > 0);
    }
}

/* Place to angles and back, and angles against those of vectors. */
static void test_round_trip(void **state)
{
    (void)state;
    rng      r     = {2};
    uint32_t asked = 0;
    double   most = 0, most_angle = 0;
    for (uint32_t n = 0; n < repeats(50000, 500000); n++) {
        vxs_epipolar_view view = random_view(&r, 100);
        double            to_light[3], place[3], angles[3], wanted[3], back[3], error = 0, size;
        int               is_sun;
        vxs_epipolar      space = random_space(&r, &view, to_light, &is_sun);
        random_direction(&r, place);
        size = spread(&r, 1e-3, 1e3) * (is_sun ? 1 : space.away);
        for (int i = 0; i < 3; i++) place[i] *= size;
        vxs_epipolar_from_place(&space, place, angles);
        angles_of(&space, to_light, is_sun, place, wanted);
        for (int i = 0; i < 3; i++) most_angle = fmax(most_angle, fabs(angles[i] - wanted[i]) / (is_sun && i == 2 ? size : 1));
        if (sin(angles[0]) < 1e-3 || (!is_sun && sin(angles[0] + angles[2]) < 1e-5)) continue; /* the axis, and what is endless */
        vxs_epipolar_place(&space, angles, back);
        for (int i = 0; i < 3; i++) error = fmax(error, fabs(back[i] - place[i]) / size);
        most = fmax(most, error);
        asked++;
    }
    print_message("%u places: %.1e of the distance, angles %.1e\n", asked, most, most_angle);
    assert_true(asked > repeats(40000, 400000));
    assert_true(most < 1e-9);
    assert_true(most_angle < 1e-12);
}

/* A light ray and an eye ray meet in the place of their angles. */
static void test_rays(void **state)
{
    (void)state;
    rng r = {3};
    for (uint32_t n = 0; n < repeats(50000, 500000); n++) {
        vxs_epipolar_view view = random_view(&r, 100);
        double            to_light[3], angles[3], turned[2], across[3], begin[3], way[3], at[3], found[3], metres, last = 0;
        int               is_sun;
        vxs_epipolar      space = random_space(&r, &view, to_light, &is_sun);
        double            scale = is_sun ? 1 : space.away;
        angles[1]               = uniform(&r, -M_PI, M_PI);
        angles[2]               = is_sun ? spread(&r, 1e-2, 1e2) : uniform(&r, 1e-3, M_PI - 1e-3);
        vxs_epipolar_turn_of(&space, angles[2], turned);
        vxs_epipolar_across(&space, angles[1], across);
        vxs_epipolar_light_ray(&space, across, turned, begin, way);
        assert_float_equal(dot(way, way), 1, 1e-14);
        for (metres = is_sun ? -100 : 1e-2 * scale; metres < 100 * scale; metres += (is_sun ? 7 : 0.1 * metres)) {
            for (int i = 0; i < 3; i++) at[i] = begin[i] + metres * way[i];
            angles[0] = vxs_epipolar_alpha_at(&space, turned, metres);
            assert_true(angles[0] > last); /* rising away from the light */
            last = angles[0];
            vxs_epipolar_from_place(&space, at, found);
            for (int i = 0; i < 3; i++) assert_float_equal(found[i], angles[i], 1e-10 * (is_sun && i == 2 ? 1e3 : 1));
        }
    }
}

/* No eye ray leaves the ranges, and they are no wider than they need to be. */
static void test_ranges(void **state)
{
    (void)state;
    enum { RAYS = 2000 };
    rng      r       = {4};
    uint32_t in_view = 0, beside = 0;
    for (uint32_t n = 0; n < repeats(2000, 20000); n++) {
        double            far_metres = spread(&r, 1e-2, 1e5);
        vxs_epipolar_view view       = random_view(&r, far_metres);
        double            to_light[3];
        int               is_sun;
        vxs_epipolar      space   = random_space(&r, &view, to_light, &is_sun);
        double            most[3] = {-10, -10, -10}, least[3] = {10, 10, 10}, scale = is_sun ? far_metres : 1;
        int               circle = space.theta[1] - space.theta[0] > 6.28;
        for (int k = 0; k < RAYS; k++) {
            double direction[3], end[3], angles[3];
            random_in_view(&r, &view, direction);
            for (int i = 0; i < 3; i++) end[i] = far_metres * direction[i];
            angles_of(&space, to_light, is_sun, end, angles);
            angles[2] /= scale;
            for (int i = 0; i < 3; i++) {
                most[i]  = fmax(most[i], angles[i]);
                least[i] = fmin(least[i], angles[i]);
            }
        }
        assert_true(least[0] >= space.alpha[0] - 1e-9 && most[0] <= space.alpha[1] + 1e-9);
        assert_true(least[1] >= space.theta[0] - 1e-6 && most[1] <= space.theta[1] + 1e-6);
        assert_true(space.phi[0] == 0 && most[2] <= space.phi[1] / scale + 1e-9);
        assert_true(space.alpha[0] < space.alpha[1] && space.theta[0] < space.theta[1] && space.phi[0] < space.phi[1]);
        double wide = most[0] - least[0];
        if (space.alpha[0] > 0) assert_true(least[0] - space.alpha[0] < 0.1 * wide + 1e-5);
        if (space.alpha[1] < M_PI) assert_true(space.alpha[1] - most[0] < 0.1 * wide + 1e-5);
        if (!circle) {
            assert_true(space.theta[1] - space.theta[0] <= M_PI + 1e-6);
            assert_true(space.theta[1] - most[1] < 0.1 * (most[1] - least[1]) + 1e-4);
            assert_true(least[1] - space.theta[0] < 0.1 * (most[1] - least[1]) + 1e-4);
        } else
            assert_true(space.alpha[0] < 1e-3 || space.alpha[1] > M_PI - 1e-3); /* only where the axis is in view */
        if (wide > 0.01 && space.alpha[0] > 0 && space.alpha[1] < M_PI) assert_true(space.phi[1] / scale < 1.3 * most[2] + 1e-5);
        in_view += circle != 0;
        beside += circle == 0;
    }
    assert_true(in_view > 400 && beside > 400);
}

/* What a spot light reaches has phi in its range. */
static void test_cone(void **state)
{
    (void)state;
    rng      r        = {5};
    uint32_t narrowed = 0;
    for (uint32_t n = 0; n < repeats(2000, 20000); n++) {
        vxs_epipolar_view view = random_view(&r, 100);
        double            to_light[3], axis[3], cone = uniform(&r, 0.01, 1.5), phi[2];
        random_direction(&r, to_light);
        random_direction(&r, axis);
        for (int i = 0; i < 3; i++) to_light[i] *= 20;
        vxs_epipolar space = vxs_epipolar_of_punctual(to_light, &view);
        memcpy(phi, space.phi, sizeof phi);
        vxs_epipolar_in_cone(&space, axis, cos(cone), space.phi);
        assert_true(space.phi[0] >= phi[0] && space.phi[0] < space.phi[1]);
        narrowed += space.phi[1] - space.phi[0] < 0.9 * (phi[1] - phi[0]);
        for (int k = 0; k < 100; k++) {
            double direction[3], at[3], from[3], angles[3], metres = uniform(&r, 0, 100);
            random_in_view(&r, &view, direction);
            for (int i = 0; i < 3; i++) at[i] = metres * direction[i], from[i] = at[i] - to_light[i];
            if (dot(from, axis) < cos(cone) * sqrt(dot(from, from))) continue;
            vxs_epipolar_from_place(&space, at, angles);
            assert_true(angles[2] >= space.phi[0] - 1e-9 && angles[2] <= space.phi[1] + 1e-9);
        }
    }
    assert_true(narrowed > 400);
}

static void check_finite(const vxs_epipolar *space)
{
    const double *numbers = (const double *)space;
    for (size_t n = 0; n < sizeof *space / sizeof *numbers; n++) assert_true(isfinite(numbers[n]));
    assert_true(space->alpha[0] < space->alpha[1] && space->theta[0] < space->theta[1] && space->phi[0] < space->phi[1]);
    assert_true(space->alpha[0] >= 0 && space->theta[0] >= -M_PI && space->phi[0] >= 0);
}

/* Punctual lights at the eye, on the view's axis, behind, as far away as a double goes; images of no size; all numbers stay
 * numbers. */
static void test_extremes(void **state)
{
    (void)state;
    static const double sizes[] = {0, 1e-300, 1e-160, 1e-30, 1e-10, 1e-3, 1, 1e3, 1e9, 1e15, 1e100, 1e200};
    enum { SIZES = sizeof sizes / sizeof *sizes };
    rng r = {6};
    for (int n = 0; n < 100 * SIZES * SIZES; n++) {
        vxs_epipolar_view view = random_view(&r, fmax(1e-30, fmin(1e30, sizes[n % SIZES])));
        double            to_light[3], ways[4][3] = {{0}}, angles[3], place[3];
        if (!rng_below(&r, 8)) memcpy(view.corners[1], view.corners[0], sizeof view.corners[0]);
        if (!rng_below(&r, 16))
            for (int k = 1; k < 4; k++) memcpy(view.corners[k], view.corners[0], sizeof view.corners[0]);
        if (!rng_below(&r, 32)) memset(view.corners, 0, sizeof view.corners);
        for (int i = 0; i < 3; i++) to_light[i] = view.corners[0][i] + view.corners[2][i];
        if (rng_below(&r, 2)) random_direction(&r, to_light);
        for (int i = 0; i < 3; i++) to_light[i] *= sizes[n / SIZES % SIZES] * (n & 1 ? 1 : -1);
        vxs_epipolar spaces[2] = {vxs_epipolar_of_punctual(to_light, &view), vxs_epipolar_of_sun(to_light, &view)};
        for (int k = 0; k < 2; k++) {
            check_finite(&spaces[k]);
            memcpy(ways[1], spaces[k].axis, sizeof ways[1]);
            for (int i = 0; i < 3; i++) ways[2][i] = -ways[1][i], ways[3][i] = view.corners[0][i];
            for (int w = 0; w < 4; w++) {
                vxs_epipolar_ray ray = vxs_epipolar_eye(&spaces[k], ways[w]);
                double           turned[2];
                assert_true(isfinite(ray.alpha) && isfinite(ray.theta) &&
                            isfinite(vxs_epipolar_phi_at(&spaces[k], &ray, view.far_metres)));
                vxs_epipolar_turn(fmin(spaces[k].phi[1], M_PI), turned);
                assert_true(vxs_epipolar_distance(&spaces[k], &ray, turned, 1e6) <= 1e6);
            }
            for (int i = 0; i < 8; i++) {
                angles[0] = spaces[k].alpha[i & 1];
                angles[1] = spaces[k].theta[i >> 1 & 1];
                angles[2] = spaces[k].phi[i >> 2];
                vxs_epipolar_place(&spaces[k], angles, place);
                assert_true(isfinite(place[0]) && isfinite(place[1]) && isfinite(place[2]));
            }
        }
    }
}

/* shaders ---------------------------------------------------------------------------------------------------------------------- */

/* A point of gl_points.h requests a number: the frame and the ranges, a place's angles, the place of these, alpha of it on its
 * light ray. */
enum { ANSWERS = 32 };
static const char ask_text[] =
    "struct question { vec4 light, corners[4], place; };\n" /* light.w: 1 for suns; place.w: the far end */
    "layout(std430, binding = 0) readonly buffer asked { question questions[]; };\n"
    "flat in int vertex;\n"
    "out float answer;\n"
    "void main() {\n"
    "    question q = questions[vertex / 32];\n"
    "    vxs_epipolar_view view;\n"
    "    vxs_epipolar space;\n"
    "    vec3 angles, place, across, begin, way;\n"
    "    vec2 turned;\n"
    "    for (int n = 0; n < 4; n++) view.corners[n] = q.corners[n].xyz;\n"
    "    view.far_metres = q.place.w;\n"
    "    if (q.light.w == 1.0) space = vxs_epipolar_of_sun(q.light.xyz, view);\n"
    "    else space = vxs_epipolar_of_punctual(q.light.xyz, view);\n"
    "    vxs_epipolar_from_place(space, q.place.xyz, angles);\n"
    "    vxs_epipolar_place(space, angles, place);\n"
    "    vxs_epipolar_across(space, angles.y, across);\n"
    "    vxs_epipolar_turn_of(space, angles.z, turned);\n"
    "    vxs_epipolar_light_ray(space, across, turned, begin, way);\n"
    "    float all[32] = float[32](space.axis.x, space.axis.y, space.axis.z, space.ahead.x, space.ahead.y, space.ahead.z, "
    "space.side.x,\n"
    "        space.side.y, space.side.z, space.away, space.alpha.x, space.alpha.y, space.theta.x, space.theta.y, space.phi.x, "
    "space.phi.y,\n"
    "        angles.x, angles.y, angles.z, place.x, place.y, place.z, vxs_epipolar_alpha_at(space, turned, dot(q.place.xyz - "
    "begin, way)),\n"
    "        way.x, way.y, way.z, begin.x, begin.y, begin.z, 0.0, 0.0, 0.0);\n"
    "    answer = all[vertex % 32];\n"
    "}\n";

/* Floats against doubles. Where the axis is nearly that of the view its frame turns about it by a rounding error, and ranges may be
 * all of theta in one and not in the other: such views are not queried. */
static void test_shader(void **state)
{
    (void)state;
    enum { ASKED = QUERIES / ANSWERS };
    static struct {
        float light[4], corners[4][4], place[4];
    } questions[ASKED];
    static vxs_epipolar spaces[ASKED];
    static double       sizes[ASKED];
    static query        queries[QUERIES];
    static float        answers[QUERIES];
    rng                 r = {7};
    drawing             d = drawing_make();
    enum { TEXTS = 7 };
    char       *texts[]        = {read_text("formats/vxs_lookup.h"),          read_text("formats/vxs_lookup_blocks.h"),
                                  read_text("formats/vxs_space.h"),           read_text("runtime/volumes/vxs_air_light.h"),
                                  read_text("runtime/volumes/vxs_air_ray.h"), read_text("runtime/volumes/vxs_air.h"),
                                  read_text("runtime/volumes/vxs_epipolar.h")};
    const char *all[TEXTS + 2] = {"#version 430\n#define vxs_word(dag, i) 0u\n"};
    memcpy(all + 1, texts, sizeof texts);
    all[TEXTS + 1] = ask_text;
    use_texts(&d, "vxs_epipolar.h", "#version 430", all, sizeof all / sizeof *all);
    for (int n = 0; n < TEXTS; n++) free(texts[n]);
    for (int n = 0; n < ASKED; n++) {
        vxs_epipolar_view view;
        double            to_light[3], place[3], angles[3], margin;
        int               is_sun;
        do {
            view      = random_view(&r, spread(&r, 1, 1e3));
            spaces[n] = random_space(&r, &view, to_light, &is_sun);
            random_direction(&r, place);
            sizes[n] = spread(&r, 1e-1, 10) * (is_sun ? 10 : spaces[n].away);
            for (int i = 0; i < 3; i++) place[i] *= sizes[n];
            vxs_epipolar_from_place(&spaces[n], place, angles);
            margin = fmin(sin(angles[0]), is_sun ? 1 : sin(angles[0] + angles[2]));
            for (int i = 0; i < 3; i++) to_light[i] = (float)to_light[i], place[i] = (float)place[i];
            for (int k = 0; k < 4; k++)
                for (int i = 0; i < 3; i++) view.corners[k][i] = (float)view.corners[k][i];
            view.far_metres = (float)view.far_metres;
            spaces[n]       = is_sun ? vxs_epipolar_of_sun(to_light, &view) : vxs_epipolar_of_punctual(to_light, &view);
        } while (margin < 0.05 || spaces[n].alpha[1] - spaces[n].alpha[0] < 0.01 || spaces[n].theta[1] - spaces[n].theta[0] > 3);
        questions[n].light[3] = (float)is_sun;
        questions[n].place[3] = (float)view.far_metres;
        for (int i = 0; i < 3; i++) {
            questions[n].light[i] = (float)to_light[i];
            questions[n].place[i] = (float)place[i];
            for (int k = 0; k < 4; k++) questions[n].corners[k][i] = (float)view.corners[k][i];
        }
    }
    bind_buffer(&d, GL_SHADER_STORAGE_BUFFER, sizeof questions, questions);
    draw(&d, queries, answers);
    double most_frame = 0, most_range = 0, most_angle = 0, most_back = 0, most_alpha = 0;
    for (int n = 0; n < ASKED; n++) {
        const vxs_epipolar *s = &spaces[n];
        const float        *a = answers + n * ANSWERS;
        double              place[3], angles[3], scale[3] = {1, 1, s->away > 0 ? 1 : sizes[n]}, ranges[6];
        for (int i = 0; i < 3; i++) place[i] = (double)questions[n].place[i];
        vxs_epipolar_from_place(s, place, angles);
        for (int i = 0; i < 2; i++) ranges[i] = s->alpha[i], ranges[2 + i] = s->theta[i], ranges[4 + i] = s->phi[i];
        for (int i = 0; i < 9; i++) most_frame = fmax(most_frame, fabs((double)a[i] - (&s->axis[0])[i]));
        for (int i = 0; i < 6; i++)
            most_range = fmax(most_range,
                              fabs((double)a[10 + i] - ranges[i]) / (i >= 4 && !(s->away > 0) ? (double)questions[n].place[3] : 1));
        for (int i = 0; i < 3; i++) {
            most_angle = fmax(most_angle, fabs((double)a[16 + i] - angles[i]) / scale[i]);
            most_back  = fmax(most_back, fabs((double)a[19 + i] - place[i]) / sizes[n]);
        }
        most_alpha = fmax(most_alpha, fabs((double)a[22] - angles[0]));
    }
    print_message(
        "%d places in a shader: frame %.1e, ranges %.1e, angles %.1e, back %.1e of the distance, alpha of light rays %.1e\n", ASKED,
        most_frame, most_range, most_angle, most_back, most_alpha);
    assert_true(most_frame < 1e-5);
    assert_true(most_range < 1e-5);
    assert_true(most_angle < 1e-5 && most_alpha < 1e-5);
    assert_true(most_back < 1e-5);
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frame),  cmocka_unit_test(test_round_trip), cmocka_unit_test(test_rays),
        cmocka_unit_test(test_ranges), cmocka_unit_test(test_cone),       cmocka_unit_test(test_extremes),
        cmocka_unit_test(test_shader),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
