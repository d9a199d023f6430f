/* What area lights are judged by, and their rivals, against exact visibility among boxes: the reference of traced shadows is right,
 * marches of faces and froxels of a rectangle reach their own limits as their knobs grow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "tests/volumes/area_reference.h"
#include "tests/volumes/rival_faces.h"
#include "tests/volumes/rival_froxels.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/area/area_state.h"
#include "volumes_scene.h"

#include "area_scene.h"

static int is_free(const void *boxes, const double from[3], const double to[3])
{
    return area_is_free(boxes, from, to);
}

/* The reference, by a mean of places, and the parts of rays that boxes leave lit to 2048 VPLs: with few samples its error is about
 * the one that it reports. */
static void test_reference(void **state)
{
    (void)state;
    enum { RAYS = 24, SETS = 8, SAMPLES = 4096 };
    vxs_area_rectangle screen = {{-1.5F, 4.5F, -1}, {3, 0, 0}, {0, -0.6F, 1.8F}, {10, 8, 6}, NULL, 0, 0};
    const area_source  source = {&screen, {0, 0, 0}, is_free, &scene};
    fog_medium         fog    = {.anisotropy = haze.anisotropy, .top_ws = INFINITY};
    double             wrong = 0, size = 0, off = 0;
    for (int n = 0; n < 3; n++) {
        fog.scattering[n] = haze.scattering[n];
        fog.extinction[n] = haze.extinction[n];
    }
    for (uint32_t ray = 0; ray < RAYS; ray++) {
        volumes_camera c         = camera_at(eyes[ray % CAMERAS], look, 0.7);
        double         wanted[3] = {0}, found[3] = {0}, direction[3];
        vxs_vpl        vpls[VXS_VPLS_MAX];
        camera_ray(&scene, &c, 7 * ray % WIDE, 5 * ray % HIGH, direction);
        double metres = fmin(scene_trace(&scene, c.eye, direction), 30);
        for (uint32_t seed = 1; seed <= SETS; seed++) {
            screen_vpls(seed, vpls, VXS_VPLS_MAX);
            area_airlight(&scene, vpls, VXS_VPLS_MAX, &haze, c.eye, direction, metres, wanted);
        }
        off += 3 * pow(area_reference_add(&source, &fog, c.eye, direction, metres, SAMPLES, ray, found), 2);
        for (int n = 0; n < 3; n++) {
            wrong += pow(found[n] - wanted[n] / SETS, 2);
            size += pow(wanted[n] / SETS, 2);
        }
    }
    print_message("the reference is off by %.4f, and says %.4f\n", sqrt(wrong / size), sqrt(off / size));
    assert_true(sqrt(wrong / size) < 0.01 && sqrt(off / size) < 0.02);
}

/* A VPL where the scene's point light is, that shines down; its map; and a view of it. */
typedef struct one_vpl {
    vxs_vpl               vpl;
    vxs_shadow_depth_map *map;
    vxs_volumes_light     light;
    vxs_volumes_frame     frame;
    volumes_camera        camera;
    double                metres[PIXELS];
} one_vpl;

static void open_one(one_vpl *o, int camera)
{
    const vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number(SCENE_POINT)};
    o->light                             = scene_light(SCENE_POINT);
    const vxs_air_light air              = scene_air_light(&scene, &o->light);
    o->vpl                               = (vxs_vpl){.normal = {0, -1, 0}, .colour = {4, 3, 2}, .radius_metres = 0.1F};
    for (int n = 0; n < 3; n++) o->vpl.place[n] = (float)air.place[n];
    o->camera = camera_at(eyes[camera], look, 0.7);
    o->frame  = scene_frame(&scene, &o->camera, &haze, 1e30, 30, o->metres);
    assert_int_equal(vxs_shadow_depth_map_create(&o->map, scene.volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(o->map, 1 << 20)) continue;
}

static void march(const one_vpl *o, rival_faces *faces, uint32_t steps, float *pixels)
{
    assert_int_equal(vxs_volumes_begin(scene.volumes, &o->frame), VXS_OK);
    assert_int_equal(rival_faces_march(faces, &o->vpl, SCENE_POINT, o->map, steps), VXS_OK);
    scene_read(&scene, pixels);
}

/* Marches come to what is lit by the map, and that to exact visibility. */
static void test_faces(void **state)
{
    (void)state;
    static const uint32_t steps[] = {4, 32, 512};
    static double         wanted[3 * PIXELS];
    static float          pixels[4 * PIXELS];
    double                errors[3];
    one_vpl               o;
    rival_faces          *faces;
    open_one(&o, 0);
    o.vpl.colour[0] = 40;
    assert_int_equal(rival_faces_create(&faces, scene.volumes), VXS_OK);
    memset(wanted, 0, sizeof wanted);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        camera_ray(&scene, &o.camera, n % WIDE, n / WIDE, direction);
        area_airlight(&scene, &o.vpl, 1, &haze, o.camera.eye, direction, o.metres[n], wanted + 3 * (size_t)n);
    }
    for (int n = 0; n < 3; n++) {
        march(&o, faces, steps[n], pixels);
        errors[n] = relative_rms(pixels, wanted, 1);
    }
    print_message("marches of a face: %.4f, %.4f, %.4f\n", errors[0], errors[1], errors[2]);
    assert_true(errors[1] < 0.5 * errors[0] && errors[2] < errors[1] && errors[2] < 0.02); /* of a map of 64 x 64 texels */
    rival_faces_destroy(faces);
    vxs_shadow_depth_map_destroy(o.map);
}

/* A rectangle that is small is a VPL. */
static void test_rectangle(void **state)
{
    (void)state;
    static const uint32_t slices[] = {16, 128, 1024};
    const float           side     = 0.02F;
    static double         wanted[3 * PIXELS];
    static float          pixels[4 * PIXELS];
    double                errors[3];
    one_vpl               o;
    rival_faces          *faces;
    open_one(&o, 1);
    assert_int_equal(rival_faces_create(&faces, scene.volumes), VXS_OK);
    march(&o, faces, 4096, pixels);
    for (size_t n = 0; n < 3 * PIXELS; n++) wanted[n] = (double)pixels[n / 3 * 4 + n % 3];
    vxs_area_rectangle small = {.across = {side, 0, 0}, .up = {0, 0, side}};
    for (int n = 0; n < 3; n++) {
        small.corner[n]   = o.vpl.place[n] - 0.5F * (small.across[n] + small.up[n]);
        small.radiance[n] = o.vpl.colour[n] / (side * side);
    }
    for (int n = 0; n < 3; n++) {
        rival_froxels *froxels;
        assert_int_equal(rival_froxels_create_rectangle(&froxels, scene.volumes, WIDE, HIGH, slices[n]), VXS_OK);
        assert_int_equal(vxs_volumes_begin(scene.volumes, &o.frame), VXS_OK);
        assert_int_equal(rival_froxels_add_rectangle(froxels, &small, &o.light, o.map), VXS_OK);
        scene_read(&scene, pixels);
        errors[n] = relative_rms(pixels, wanted, 1);
        rival_froxels_destroy(froxels);
    }
    print_message("froxels of a small rectangle: %.4f, %.4f, %.4f\n", errors[0], errors[1], errors[2]);
    assert_true(errors[1] < 0.5 * errors[0] && errors[2] < 0.5 * errors[1] && errors[2] < 0.02);
    rival_faces_destroy(faces);
    vxs_shadow_depth_map_destroy(o.map);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_faces),
        cmocka_unit_test(test_rectangle),
    };
    return cmocka_run_group_tests(tests, area_set_up, area_tear_down);
}
