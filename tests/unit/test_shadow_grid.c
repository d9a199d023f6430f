/* Voxelized shadow volumes of runtime/volumes/vxs_shadow_grid.h against exact traversal of the same shadow depth map.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "shadow_grid.h"

/* Spheres, a light and a view of them. */
typedef struct setting {
    fog_scene     scene;
    vxs_light     light;
    vxs_air_light air;
    vxs_medium    medium;
    fog_view      view;
} setting;

typedef enum light_place { ABOVE, BESIDE, IN_VIEW, BEHIND, AT_INFINITY, IN_A_CONE, LIGHT_PLACES } light_place;

static const char *const place_names[LIGHT_PLACES] = {"above the view", "beside it", "in view",
                                                      "behind the eye", "the sun",   "a spot light"};

static setting setting_make(light_place place, int wide, int high)
{
    static const double punctuals[LIGHT_PLACES][3] = {{2, 13, 1}, {9, 2, 14}, {1, 1, -9}, {1, 2, 30}, {0, 0, 0}, {2, 13, 1}};
    setting             s                          = {.scene.count = 12, .medium = {{0.04, 0.04, 0.04}, {0.05, 0.05, 0.05}, 0.3}};
    rng                 r                          = {7};
    double              towards[3] = {-0.1, -1, 0.05}, eye[3] = {0, 0.5, 18}, ahead[3] = {0, -0.05, -1};
    uint32_t            kind = place == AT_INFINITY ? VXS_LIGHT_KIND_DIRECTIONAL
                               : place == IN_A_CONE ? VXS_LIGHT_KIND_SPOT
                                                    : VXS_LIGHT_KIND_POINT;
    for (uint32_t n = 0; n < s.scene.count; n++) {
        for (int i = 0; i < 3; i++) s.scene.spheres[n][i] = uniform(&r, -6, 6);
        s.scene.spheres[n][3] = uniform(&r, 0.4, 1.4);
    }
    s.light = light_make(kind, punctuals[place], towards, 0.6, 40);
    s.air   = (vxs_air_light){.kind = kind, .cos_inner = cos(0.5), .cos_outer = cos(0.6), .radius_metres = 0.02};
    for (int i = 0; i < 3; i++) {
        s.air.place[i] = place == AT_INFINITY ? -s.light.direction_ws[i] : punctuals[place][i];
        s.air.axis[i]  = s.light.direction_ws[i];
    }
    s.view = view_make(eye, ahead, 0.5, wide, high, 40);
    return s;
}

/* Turned about the world's origin.   turn  rows of a rotation */
static void rotate(double turn[3][3], double *v)
{
    double from[3] = {v[0], v[1], v[2]};
    for (int i = 0; i < 3; i++) v[i] = dot(turn[i], from);
}

static setting rotated(const setting *s, double turn[3][3])
{
    setting t = *s;
    for (uint32_t n = 0; n < t.scene.count; n++) rotate(turn, t.scene.spheres[n]);
    for (int i = 0; i < 3; i++) rotate(turn, t.view.axes[i]);
    rotate(turn, t.view.eye);
    rotate(turn, t.air.axis);
    rotate(turn, t.air.place);
    t.light = light_make(s->light.kind, s->air.kind == VXS_LIGHT_KIND_DIRECTIONAL ? (double[3]){0, 0, 0} : t.air.place, t.air.axis,
                         0.6, 40);
    return t;
}

/* What a pixel's ray is. */
typedef struct pixel_ray {
    double       direction[3], metres;
    vxs_air_path path;
} pixel_ray;

static pixel_ray ray_of(const setting *s, int pixel)
{
    pixel_ray ray;
    double    in_fog[2];
    pixel_direction(&s->view, pixel % s->view.wide, pixel / s->view.wide, ray.direction);
    ray.metres = fmin(spheres_hit(&s->scene, s->view.eye, ray.direction), s->view.far_metres);
    ray.path   = vxs_air_path_of(&s->air, s->view.eye, ray.direction, ray.metres, VXS_AIR_EVERYWHERE, in_fog);
    return ray;
}

static double *traverse(const setting *s, const shadow_depth_map *m)
{
    int     pixels = s->view.wide * s->view.high;
    double *image  = malloc((size_t)pixels * 3 * sizeof *image);
    assert_non_null(image);
    for (int n = 0; n < pixels; n++) {
        pixel_ray ray = ray_of(s, n);
        map_airlight(m, &s->medium, &ray.path, s->view.eye, ray.direction, image + 3 * n);
    }
    return image;
}

/* between_rows  1: of the two rows about a ray; 0: of its own */
static double *look_up(const setting *s, const shadow_grid *g, int eye_lit, int runs, int between_rows)
{
    int     pixels = s->view.wide * s->view.high;
    double *image  = malloc((size_t)pixels * 3 * sizeof *image);
    assert_non_null(image);
    for (int n = 0; n < pixels; n++) {
        pixel_ray        ray = ray_of(s, n);
        vxs_epipolar_ray eye = vxs_epipolar_eye(&g->space, ray.direction);
        vxs_grid_rows    rows =
            between_rows ? vxs_grid_rows_about(&g->space, &g->size, eye.theta) : vxs_grid_row_of(&g->space, &g->size, eye.theta);
        vxs_grid_airlight_of(g->words, &g->space, &g->size, &s->medium, &ray.path, &eye, &rows, ray.metres, runs, eye_lit,
                             image + 3 * n);
        for (int i = 0; i < 3; i++) assert_true(isfinite(image[3 * n + i]) && image[3 * n + i] >= 0);
    }
    return image;
}

/* RMS of the difference over that of the second. */
static double relative_rms(const double *image, const double *wanted, int pixels)
{
    double error = 0, all = 0;
    for (int n = 0; n < 3 * pixels; n++) {
        error += (image[n] - wanted[n]) * (image[n] - wanted[n]);
        all += wanted[n] * wanted[n];
    }
    return sqrt(error / all);
}

/* Between the light above the view and what can be seen. */
static const double cover[4] = {1.6, 11.5, 1.5, 1};

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* A bit is set where its voxel's middle is in shadow, and nowhere else: occluders between the light and what can be seen, seams,
 * poles, columns. */
static void test_every_bit(void **state)
{
    (void)state;
    for (int place = 0; place < LIGHT_PLACES; place++) {
        setting s = setting_make((light_place)place, 64, 48);
        memcpy(s.scene.spheres[s.scene.count++], cover, sizeof cover);
        shadow_depth_map m     = shadow_depth_map_make(&s.scene, &s.light, 256);
        shadow_grid      g     = grid_make(&m, &s.view, 61, 47, 150);
        uint32_t         asked = 0, wrong = 0, dark = 0, before = 0;
        for (int column = 0; column < g.size.columns; column++)
            for (int row = 0; row < g.size.rows; row++)
                for (int bit = 0; bit < g.size.bits; bit++) {
                    double angles[3] = {vxs_grid_middle(g.space.alpha, column, g.size.columns),
                                        vxs_grid_middle(g.space.theta, row, g.size.rows),
                                        vxs_grid_middle(g.space.phi, bit, g.size.bits)},
                           at[3];
                    if (g.space.away > 0 && angles[0] + angles[2] > M_PI - 1e-3) continue; /* light rays do not go there */
                    vxs_epipolar_place(&g.space, angles, at);
                    for (int i = 0; i < 3; i++) at[i] += s.view.eye[i];
                    int found = g.words[vxs_grid_word_of(&g.size, column, row, bit)] >> (bit & 31) & 1;
                    wrong += found == shadow_depth_map_lit(&m, at);
                    dark += found != 0;
                    before += found && column == 0;
                    asked++;
                }
        print_message("%s: %u voxels, %u in shadow, %u from the first column on, %u wrong\n", place_names[place], asked, dark,
                      before, wrong);
        assert_true(asked > 200000 && dark > 1000);
        assert_true(wrong <= asked / 100000); /* where rounding leads to the next texel */
        if (place == ABOVE || place == IN_A_CONE) assert_true(before > 100);
        free(g.words);
        free(m.first);
    }
}

/* Errors by size, against exact traversal. Rays near a punctual light in view are a class of their own. */
static void test_converges(void **state)
{
    (void)state;
    for (int place = 0; place < LIGHT_PLACES; place++) {
        setting          s      = setting_make((light_place)place, 48, 36);
        shadow_depth_map m      = shadow_depth_map_make(&s.scene, &s.light, (int)repeats(512, 1024));
        double          *wanted = traverse(&s, &m), last = 0, first = 0;
        int              eye_lit = shadow_depth_map_lit(&m, s.view.eye), pixels = s.view.wide * s.view.high;
        print_message("%s: RMS", place_names[place]);
        for (int side = 64; side <= 512; side *= (int)repeats(8, 2)) {
            shadow_grid g     = grid_make(&m, &s.view, side, side, side);
            double     *image = look_up(&s, &g, eye_lit, 16, 0), error = relative_rms(image, wanted, pixels);
            double     *mixed = look_up(&s, &g, eye_lit, 16, 1), less = relative_rms(mixed, wanted, pixels);
            print_message(" %.5f at %d^3, %.5f between rows;", error, side, less);
            assert_true(side == 64 ? less < 0.85 * error : less < 1.02 * error); /* the rest is of runs */
            free(mixed);
            if (side == 64) first = error;
            last = error;
            free(image);
            if (side == 512 && getenv("VXS_VERBOSE"))
                for (int runs = 1; runs <= 512; runs *= 4) {
                    image = look_up(&s, &g, eye_lit, runs, 0);
                    print_message("%s %.5f of %d", runs == 1 ? "; runs:" : "", relative_rms(image, wanted, pixels), runs);
                    free(image);
                }
            free(g.words);
        }
        print_message("\n");
        assert_true(last < 3e-3);
        assert_true(first / last > 4.1); /* 1.6 each time that the side is doubled */
        free(wanted);
        free(m.first);
    }
}

/* Copies of a scene, turned to all sides, agree: seams and poles are wherever they are. */
static void test_rotated(void **state)
{
    (void)state;
    rng r = {11};
    for (int place = 0; place < LIGHT_PLACES; place++) {
        setting          s      = setting_make((light_place)place, 32, 24);
        shadow_depth_map m      = shadow_depth_map_make(&s.scene, &s.light, 512);
        double          *wanted = traverse(&s, &m), most = 0;
        free(m.first);
        for (uint32_t n = repeats((uint32_t)place, 0); n < repeats(11, 64); n += repeats(6, 1)) {
            double turn[3][3];
            random_direction(&r, turn[0]);
            random_direction(&r, turn[1]);
            cross(turn[0], turn[1], turn[2]);
            make_unit(turn[2]);
            cross(turn[2], turn[0], turn[1]);
            if (n < 6) { /* to the axes of the world */
                memset(turn, 0, sizeof turn);
                for (int i = 0; i < 3; i++) turn[i][(i + (int)n % 3) % 3] = n < 3 ? 1 : -1;
            }
            setting t         = rotated(&s, turn);
            m                 = shadow_depth_map_make(&t.scene, &t.light, 512);
            shadow_grid g     = grid_make(&m, &t.view, 256, 1024, 512);
            double     *image = look_up(&t, &g, shadow_depth_map_lit(&m, t.view.eye), 32, 0);
            most              = fmax(most, relative_rms(image, wanted, 32 * 24));
            free(image);
            free(g.words);
            free(m.first);
        }
        print_message("%s: turned copies differ by an RMS of %.5f at most\n", place_names[place], most);
        assert_true(most < 2e-3);
        free(wanted);
    }
}

/* A sphere between the light and the frustum, which no eye ray meets, darkens what is in view. */
static void test_before_the_view(void **state)
{
    (void)state;
    setting s = setting_make(ABOVE, 32, 24);
    double *images[2], mean[2] = {0, 0};
    for (int n = 0; n < 2; n++) {
        s.scene.count = (uint32_t)n;
        memcpy(s.scene.spheres[0], cover, sizeof cover);
        for (int k = 0; k < 32 * 24; k++) assert_true(ray_of(&s, k).metres == s.view.far_metres);
        shadow_depth_map m      = shadow_depth_map_make(&s.scene, &s.light, 512);
        shadow_grid      g      = grid_make(&m, &s.view, 256, 256, 256);
        double          *wanted = traverse(&s, &m);
        images[n]               = look_up(&s, &g, shadow_depth_map_lit(&m, s.view.eye), 16, 0);
        for (int k = 0; k < 3 * 32 * 24; k++) mean[n] += images[n][k];
        assert_true(relative_rms(images[n], wanted, 32 * 24) < 1e-2);
        free(wanted);
        free(g.words);
        free(m.first);
    }
    print_message("a sphere before the view leaves %.3f of the light\n", mean[1] / mean[0]);
    assert_true(mean[1] < 0.7 * mean[0]);
    free(images[0]);
    free(images[1]);
}

/* Toward a punctual light and away from it, where all rays of a column are one: lit if nothing is between the light and the eye,
 * else dark. And all is lit for an eye in a punctual light, whatever bits say. */
static void test_poles(void **state)
{
    (void)state;
    for (int n = 0; n < 4; n++) {
        int     toward = n & 1, covered = n >> 1;
        setting s = setting_make(toward ? IN_VIEW : BEHIND, 32, 24);
        double  to_light[3], wanted[3], found[3], in_fog[2];
        for (int i = 0; i < 3; i++) {
            to_light[i]           = s.air.place[i] - s.view.eye[i];
            s.scene.spheres[0][i] = s.view.eye[i] + to_light[i] / 2;
        }
        s.scene.spheres[0][3]    = 0.5;
        s.scene.count            = (uint32_t)covered;
        shadow_depth_map m       = shadow_depth_map_make(&s.scene, &s.light, 256);
        shadow_grid      g       = grid_make(&m, &s.view, 32, 32, 128);
        int              eye_lit = shadow_depth_map_lit(&m, s.view.eye);
        assert_int_equal(eye_lit, !covered);
        make_unit(to_light);
        for (int k = 0; k < 16; k++) {
            double direction[3];
            for (int i = 0; i < 3; i++) direction[i] = (toward ? 1 : -1) * to_light[i] + 2e-4 * ((k * (i + 3) % 7) - 3);
            make_unit(direction);
            double       metres = toward ? fmin(spheres_hit(&s.scene, s.view.eye, direction), s.view.far_metres) : 1;
            vxs_air_path path   = vxs_air_path_of(&s.air, s.view.eye, direction, metres, VXS_AIR_EVERYWHERE, in_fog);
            map_airlight(&m, &s.medium, &path, s.view.eye, direction, wanted);
            vxs_grid_airlight(g.words, &g.space, &g.size, &s.medium, &path, direction, metres, 16, eye_lit, found);
            for (int i = 0; i < 3; i++) {
                assert_true(covered ? wanted[i] == 0 && found[i] == 0 : wanted[i] > 0 && fabs(found[i] / wanted[i] - 1) < 1e-9);
            }
            vxs_air_lit(&s.medium, &path, path.begin, path.end, wanted);
            vxs_grid_airlight(g.words, &g.space, &g.size, &s.medium, &path, direction, metres, 16, 2, found);
            for (int i = 0; i < 3; i++) assert_true(found[i] == wanted[i]);
        }
        free(g.words);
        free(m.first);
    }
}

/* Each bit alone, the last of a layer among them, takes its part of the ray and no other. */
static void test_single_bits(void **state)
{
    (void)state;
    setting s               = setting_make(BESIDE, 32, 24);
    s.scene.count           = 0;
    shadow_depth_map m      = shadow_depth_map_make(&s.scene, &s.light, 64);
    shadow_grid      g      = grid_make(&m, &s.view, 16, 16, 256);
    pixel_ray        ray    = ray_of(&s, 10 * 32 + 9);
    vxs_epipolar_ray eye    = vxs_epipolar_eye(&g.space, ray.direction);
    int              column = vxs_grid_voxel(vxs_grid_before(g.space.alpha, eye.alpha, 16), 16),
        row                 = vxs_grid_voxel(vxs_grid_before(g.space.theta, eye.theta, 16), 16);
    int last                = (int)(256 * vxs_epipolar_phi_at(&g.space, &eye, ray.metres) / g.space.phi[1]) -
               3; /* the last one's is what is behind it, too */
    assert_true(last > 130);
    for (int bit = 0; bit < last; bit++) {
        double all[3], part[3], found[3], ends[2], turned[2];
        memset(g.words, 0, (size_t)vxs_grid_words(&g.size) * sizeof *g.words);
        vxs_grid_airlight(g.words, &g.space, &g.size, &s.medium, &ray.path, ray.direction, ray.metres, 256, 1, all);
        g.words[vxs_grid_word_of(&g.size, column, row, bit)] = 1U << (bit & 31);
        vxs_grid_airlight(g.words, &g.space, &g.size, &s.medium, &ray.path, ray.direction, ray.metres, 256, 1, found);
        for (int n = 0; n < 2; n++) {
            vxs_epipolar_turn_of(&g.space, g.space.phi[1] * (bit + n) / 256, turned);
            ends[n] = vxs_epipolar_distance(&g.space, &eye, turned, ray.metres);
        }
        vxs_air_lit(&s.medium, &ray.path, ends[0], ends[1], part);
        for (int i = 0; i < 3; i++) assert_true(part[i] > 0 && fabs(all[i] - found[i] - part[i]) < 1e-3 * part[i]);
    }
    free(g.words);
    free(m.first);
}

/* Any camera, light, medium and words: numbers, not negative, and no more than all the light there is. */
static void test_any_numbers(void **state)
{
    (void)state;
    rng r = {13};
    enum { COLUMNS = 9, ROWS = 7, BITS = 140 };
    static uint32_t words[4 * 2 * COLUMNS * ROWS];
    for (uint32_t n = 0; n < repeats(20000, 200000); n++) {
        fog_view v = {.far_metres = exp(uniform(&r, -10, 14)), .half_wide = exp(uniform(&r, -9, 2)), .wide = 8, .high = 8};
        double   eye[3], ahead[3], to[3], size = exp(uniform(&r, -20, 12)), all[3], found[3], in_fog[2], direction[3];
        random_direction(&r, ahead);
        random_direction(&r, to);
        for (int i = 0; i < 3; i++) eye[i] = uniform(&r, -1e3, 1e3);
        fog_view made = view_make(eye, ahead, 0.5, 8, 8, v.far_metres);
        memcpy(v.eye, made.eye, sizeof v.eye);
        memcpy(v.axes, made.axes, sizeof v.axes);
        v.half_high = v.half_wide;
        int choice  = (int)rng_below(&r, 4);
        if (choice == 0) memcpy(to, v.axes[2], sizeof to);
        if (choice == 1) pixel_direction(&v, 3, 4, to);
        if (rng_below(&r, 3) == 0)
            for (int i = 0; i < 3; i++) to[i] = -to[i];
        if (rng_below(&r, 16) == 0) size = 0;
        uint32_t      kinds[3] = {VXS_LIGHT_KIND_DIRECTIONAL, VXS_LIGHT_KIND_SPOT, VXS_LIGHT_KIND_POINT};
        vxs_air_light light    = {.kind          = kinds[rng_below(&r, 3)],
                                  .cos_inner     = 0.9,
                                  .cos_outer     = 0.7,
                                  .radius_metres = exp(uniform(&r, -9, 0)),
                                  .range_metres  = rng_below(&r, 2) ? exp(uniform(&r, -3, 6)) : 0};
        random_direction(&r, light.axis);
        int is_sun = light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
        for (int i = 0; i < 3; i++) light.place[i] = is_sun ? to[i] : eye[i] + size * to[i];
        vxs_medium medium = {.anisotropy = uniform(&r, -0.99, 0.99)};
        for (int i = 0; i < 3; i++) medium.scattering[i] = medium.extinction[i] = exp(uniform(&r, -12, 4));
        vxs_epipolar_view view = epipolar_view_of(&v);
        vxs_grid_size     grid = {COLUMNS, ROWS, BITS};
        double            to_light[3];
        for (int i = 0; i < 3; i++) to_light[i] = size * to[i];
        vxs_epipolar space = is_sun ? vxs_epipolar_of_sun(to, &view) : vxs_epipolar_of_punctual(to_light, &view);
        if (light.kind == VXS_LIGHT_KIND_SPOT) vxs_epipolar_in_cone(&space, light.axis, light.cos_outer, space.phi);
        pixel_direction(&v, (int)rng_below(&r, 8), (int)rng_below(&r, 8), direction);
        double       metres = v.far_metres * (rng_below(&r, 4) ? uniform(&r, 0, 1) : 1);
        vxs_air_path path   = vxs_air_path_of(&light, eye, direction, metres,
                                            rng_below(&r, 4) ? VXS_AIR_EVERYWHERE : eye[1] + uniform(&r, -1, 1), in_fog);
        vxs_air_lit(&medium, &path, path.begin, path.end, all);
        uint32_t kind_of_words = rng_below(&r, 3);
        for (int k = 0; k < vxs_grid_words(&grid); k++)
            words[k] = kind_of_words == 2 ? rng_u32(&r) : kind_of_words ? 0 : 0xffffffff;
        vxs_grid_airlight(words, &space, &grid, &medium, &path, direction, metres, (int)rng_between(&r, 1, 200),
                          (int)rng_below(&r, 3), found);
        for (int i = 0; i < 3; i++) {
            assert_true(isfinite(found[i]) && found[i] >= 0);
            assert_true(found[i] <= all[i] * 1.1 + 1e-12);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_bit),       cmocka_unit_test(test_converges), cmocka_unit_test(test_rotated),
        cmocka_unit_test(test_before_the_view), cmocka_unit_test(test_poles),     cmocka_unit_test(test_single_bits),
        cmocka_unit_test(test_any_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
