/* Airlight by voxelized triangles, on llvmpipe, against that in their exact shadows, turned to all sides, too; triangles that are
 * none, and misuse.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "casting.h"
#include "triangle_shadows.h"

static const char *const kind_names[VXS_VOXELS_KINDS] = {"light rays", "solid", "covered"};

/* What pixels have of a light in the exact shadows of triangles.   metres  of each pixel's ray */
static void exact_image(const volumes_scene *s, const vxs_volumes_light *l, const volumes_camera *at, triangles t,
                        const double *metres, double *wanted)
{
    vxs_air_light air = scene_air_light(s, l);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3], in_fog[2], *to = wanted + 3 * (size_t)n;
        camera_ray(s, at, n % WIDE, n / WIDE, direction);
        vxs_air_path path = vxs_air_path_of(&air, at->eye, direction, metres[n], VXS_AIR_EVERYWHERE, in_fog);
        triangles_airlight(t.places, t.corners, t.count, &haze, &air, &path, at->eye, direction, to);
        for (int i = 0; i < 3; i++) to[i] *= (double)l->colour[i];
    }
}

/* Airlight by triangles, against that in their exact shadows: as near as the grid is fine. */
static void test_converges(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    static double        metres[PIXELS], wanted[3 * PIXELS];
    float                pixels[4 * PIXELS];
    enum { SIZES = 4 };
    vxs_shadow_grid *grids[SIZES] = {0};
    const uint32_t   sizes = repeats(SIZES - 1, SIZES), step = repeats(2, 1);
    for (uint32_t n = 0; n < sizes; n += step) grids[n] = casting_grid(s, 64U << n, 64U << n, 64U << n);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light l     = bare_light(s, light);
            volumes_camera    at    = camera_at(eyes[camera], looks[camera], 0.8);
            vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            exact_image(s, &l, &at, scene_triangles(BOX_TRIANGLES), metres, wanted);
            for (vxs_voxels kind = 0; kind < VXS_VOXELS_KINDS; kind++) {
                vxs_casters c     = casters_of(s, scene_triangles(BOX_TRIANGLES), kind);
                double      first = 0, last = 0;
                print_message("light %d, camera %d, %s: RMS", light, camera, kind_names[kind]);
                for (uint32_t n = 0; n < sizes; n += step) {
                    assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
                    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, grids[n], 0, &c, 1), VXS_OK);
                    scene_read(s, pixels);
                    last  = error_of(pixels, wanted, PIXELS);
                    first = n ? first : last;
                    print_message(" %.5f at %u^3", last, 64U << n);
                }
                print_message("\n");
                assert_true(last < (kind == VXS_VOXELS_RAYS ? 1e-2 : 2e-2));
                if (kind != VXS_VOXELS_SOLID) assert_true(last < first / 1.6);
            }
        }
    for (int n = 0; n < SIZES; n++) vxs_shadow_grid_destroy(grids[n]);
}

static void turn_about(double turn[3][3], float *v)
{
    double from[3] = {(double)v[0], (double)v[1], (double)v[2]};
    for (int i = 0; i < 3; i++) v[i] = (float)dot(turn[i], from);
}

/* Copies of the scene, turned to all sides by the matrix of its casters, agree. */
static void test_turned(void **state)
{
    (void)state;
    static const int     cameras[SCENE_LIGHTS] = {1, 2, 3};
    const volumes_scene *s                     = opened();
    static double        metres[PIXELS], wanted[3 * PIXELS];
    float                pixels[4 * PIXELS];
    rng                  r    = {11};
    vxs_shadow_grid     *grid = casting_grid(s, 128, 128, 128);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l     = bare_light(s, light);
        volumes_camera    at    = camera_at(eyes[cameras[light]], looks[cameras[light]], 0.8);
        vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
        vxs_casters       c     = casters_of(s, scene_triangles(BOX_TRIANGLES), VXS_VOXELS_RAYS);
        double            most  = 0;
        exact_image(s, &l, &at, scene_triangles(BOX_TRIANGLES), metres, wanted);
        for (uint32_t n = 0; n < repeats(7, 66); n++) {
            vxs_light_constants turned = vxs_gl_constants(s->shadows)[light];
            vxs_volumes_frame   f      = frame;
            double              turn[3][3];
            random_direction(&r, turn[0]);
            random_direction(&r, turn[1]);
            cross(turn[0], turn[1], turn[2]);
            make_unit(turn[2]);
            cross(turn[2], turn[0], turn[1]);
            for (int i = 0; i < 9 && n < 6; i++) turn[i / 3][i % 3] = i % 3 == (i / 3 + (int)n) % 3 ? n < 3 ? 1 : -1 : 0;
            for (int i = 0; i < 3; i++) turn_about(turn, turned.ls_from_ws + 4 * i);
            for (int i = 0; i < 4; i++) turn_about(turn, f.view.point_from_depth + 4 * i);
            for (int i = 0; i < 9; i++) c.point_from_place[4 * (i % 3) + i / 3] = (float)turn[i / 3][i % 3];
            turn_about(turn, f.eye);
            l.constants = &turned;
            assert_int_equal(vxs_volumes_begin(s->volumes, &f), VXS_OK);
            assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, grid, 0, &c, 1), VXS_OK);
            scene_read(s, pixels);
            most = fmax(most, error_of(pixels, wanted, PIXELS));
        }
        print_message("light %d: turned copies differ from exact shadows by an RMS of %.5f at most\n", light, most);
        assert_true(most < 1.5e-2);
    }
    vxs_shadow_grid_destroy(grid);
}

/* A corner that makes trouble: in the light, in the eye, on the axis, far away, no number. */
static void random_corner(rng *r, const double *eye, const double *light, float *corner)
{
    static const float extremes[] = {0, 1e-30F, -1e-30F, 1e14F, -1e14F, 1e30F, 3e38F, INFINITY, -INFINITY, NAN};
    double             along      = uniform(r, -1, 2);
    uint32_t           what       = rng_below(r, 8);
    for (int i = 0; i < 3; i++) {
        double at = what == 0   ? light[i]
                    : what == 1 ? eye[i]
                    : what == 2 ? eye[i] + along * (light[i] - eye[i])
                                : uniform(r, -9, 9);
        corner[i] = what == 3 ? extremes[rng_below(r, sizeof extremes / sizeof *extremes)] : (float)at;
    }
}

/* Cameras, lights and triangles at random, among them such that are none: nothing that is drawn is no number, or negative. */
static void test_any_triangles(void **state)
{
    (void)state;
    enum { TRIANGLES = 70, PLACES = 60 };
    const volumes_scene *s = opened();
    static double        metres[PIXELS];
    float                pixels[4 * PIXELS], places[4 * PLACES];
    uint32_t             corners[3 * TRIANGLES];
    rng                  r = {5};
    for (uint32_t n = 0; n < repeats(40, 3000); n++) {
        int                 light = (int)rng_below(&r, SCENE_LIGHTS);
        double              eye[3], to[3];
        vxs_volumes_light   l   = bare_light(s, light);
        const vxs_air_light air = scene_air_light(s, &l);
        for (int i = 0; i < 3; i++) {
            eye[i] = uniform(&r, -9, 9);
            to[i]  = rng_below(&r, 2) ? uniform(&r, -5, 5) : air.place[i];
        }
        if (!rng_below(&r, 8))
            for (int i = 0; i < 3; i++) eye[i] = air.place[i] + 1e-3 * uniform(&r, -1, 1);
        for (int k = 0; k < PLACES; k++) random_corner(&r, eye, air.place, places + 4 * k);
        for (int k = 0; k < 3 * TRIANGLES; k++)
            corners[k] = rng_below(&r, 40) ? rng_below(&r, PLACES) : rng_below(&r, 2) ? PLACES : rng_u32(&r);
        vxs_casters c = {.places         = buffer_of(s, places, sizeof places),
                         .place_words    = 4,
                         .corners        = rng_below(&r, 4) ? buffer_of(s, corners, sizeof corners) : 0,
                         .triangle_count = TRIANGLES + rng_below(&r, 100), /* more than there are */
                         .kind           = (vxs_voxels)rng_below(&r, VXS_VOXELS_KINDS)};
        memcpy(c.point_from_place, identity, sizeof identity);
        volumes_camera    at    = camera_at(eye, to, exp(uniform(&r, -4, 1)));
        vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, exp(uniform(&r, -3, 8)), n % 8 ? NULL : metres);
        assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, &c, 1), VXS_OK);
        scene_read(s, pixels);
        for (size_t k = 0; k < 4 * PIXELS; k++)
            if (!(isfinite(pixels[k]) && pixels[k] >= 0)) fail_msg("repeat %u, number %zu is %g", n, k, (double)pixels[k]);
        s->gl->DeleteBuffers(1, &c.places);
        s->gl->DeleteBuffers(1, &c.corners);
    }
}

/* A triangle that fills the view changes more bits of a row than llvmpipe's loops have rounds: it is reported. Of a smaller grid
 * they suffice. */
static void test_cut(void **state)
{
    (void)state;
    static const float    places[9]  = {-400, -300, -12, 400, -300, -12, 0, 600, -12};
    static const uint32_t corners[3] = {0, 1, 2};
    const volumes_scene  *s          = opened();
    const double          eye[3] = {0, 1, 9}, to[3] = {0, 1, -9};
    vxs_volumes_light     l           = bare_light(s, SCENE_POINT);
    volumes_camera        at          = camera_at(eye, to, 0.8);
    vxs_volumes_frame     frame       = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 60, NULL);
    vxs_casters           c           = casters_of(s, (triangles){places, 3, corners, 1}, VXS_VOXELS_SOLID);
    vxs_shadow_grid      *grids[2]    = {casting_grid(s, 64, 64, 64), casting_grid(s, 2048, 64, 2048)};
    int                   is_llvmpipe = strstr(s->gl->names.renderer, "llvmpipe") != NULL;
    for (int n = 0; n < 2; n++) {
        assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, grids[n], 0, &c, 1), VXS_OK);
        assert_int_equal(vxs_shadow_grid_cut(grids[n]) > 0, n && is_llvmpipe);
        vxs_shadow_grid_destroy(grids[n]);
    }
}

/* An eye within a punctual light's radius, behind a shade beside the light: it sees the shadow of that, and none of another shade,
 * behind it. */
static void test_shade_in_punctual(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    static double        metres[PIXELS], wanted[3 * PIXELS];
    float                pixels[4 * PIXELS];
    vxs_shadow_grid     *grid = casting_grid(s, 256, 512, 256);
    for (int behind = 0; behind < 2; behind++) {
        vxs_volumes_light l   = bare_light(s, SCENE_POINT);
        vxs_air_light     air = scene_air_light(s, &l);
        double            eye[3], to[3];
        float             places[12];
        uint32_t          corners[6] = {0, 1, 2, 2, 1, 3};
        l.radius_metres              = 0.5F;
        air.radius_metres            = 0.5;
        for (int i = 0; i < 3; i++) {
            eye[i] = air.place[i] + (i == 0 ? 0.3 : 0);
            to[i]  = eye[i] + (i == 2 ? 1 : 0);
        }
        for (int k = 0; k < 4; k++) { /* across the way from the light to the eye */
            places[3 * k]     = (float)(air.place[0] + (behind ? 0.4 : 0.15));
            places[3 * k + 1] = (float)(air.place[1] + (k & 1 ? 0.1 : -0.1));
            places[3 * k + 2] = (float)(air.place[2] + (k & 2 ? 0.1 : -0.1));
        }
        volumes_camera    at    = camera_at(eye, to, 0.8);
        vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
        triangles         t     = {places, 4, corners, 2};
        vxs_casters       c     = casters_of(s, t, VXS_VOXELS_RAYS);
        exact_image(s, &l, &at, t, metres, wanted);
        assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, grid, 0, &c, 1), VXS_OK);
        scene_read(s, pixels);
        double error = error_of(pixels, wanted, PIXELS), first = 0;
        for (int n = 0; n < 3 * PIXELS; n++) first = fmax(first, wanted[n]);
        print_message("a shade %s the eye: RMS %.4f of at most %.3f\n", behind ? "behind" : "before", error, first);
        assert_true(error < 2e-2);
    }
    vxs_shadow_grid_destroy(grid);
}

static void test_misuse(void **state)
{
    (void)state;
    const volumes_scene *s        = opened();
    vxs_shadow_grid     *few_rows = casting_grid(s, 8, 7, 8), *other = make_grid(s, 8, 8, 8, 0);
    vxs_volumes_light    l     = bare_light(s, SCENE_SUN);
    volumes_camera       at    = camera_at(eyes[0], looks[0], 0.8);
    vxs_volumes_frame    frame = scene_frame(s, &at, &haze, 1e30, 30, NULL);
    const vxs_casters    good  = casters_of(s, scene_triangles(SCENE_TRIANGLES), VXS_VOXELS_COVERED);
    vxs_casters          bad[] = {good, good, good, good, good, good};
    bad[0].places              = 0;
    bad[1].place_words         = 2;
    bad[2].kind                = VXS_VOXELS_KINDS;
    bad[3].point_from_place[7] = NAN;
    bad[4].first_word          = UINT32_MAX;
    bad[5].triangle_count      = UINT32_MAX;
    assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++)
        assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, &bad[n], 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, NULL, 0),
                     VXS_E_ARGUMENT); /* no light ray has an end */
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, few_rows, 0, &good, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, other, 0, &good, 1), VXS_E_ARGUMENT); /* it does not cast */
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, &good, 1), VXS_OK);
    assert_int_equal(s->gl->GetError(), GL_NO_ERROR);
    vxs_shadow_grid_destroy(few_rows);
    vxs_shadow_grid_destroy(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_converges),         cmocka_unit_test(test_turned),
        cmocka_unit_test(test_any_triangles),     cmocka_unit_test(test_cut),
        cmocka_unit_test(test_shade_in_punctual), cmocka_unit_test(test_misuse),
    };
    return cmocka_run_group_tests(tests, NULL, close_scene);
}
