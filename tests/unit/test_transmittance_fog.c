/* Airlight of lights whose smoke dims them: marches on llvmpipe against the same steps in double, each of which looks through all
 * capsules towards the light; places out of view; and what is refused.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "transmittance_maps.h"

enum { FINE_SIDE = 64, BALLS = 10, STEPS = 24, FOG_WIDE = 12, FOG_HIGH = 9 };

static vxs_capsule balls[BALLS];

/* Puffs that texels of these maps are small beside, the same for all tests. */
static void make_balls(void)
{
    rng r = {11};
    for (int n = 0; n < BALLS; n++) {
        balls[n] = (vxs_capsule){.radius_metres = (float)uniform(&r, 1, 2), .extinction = (float)uniform(&r, 0.2, 0.8)};
        for (int i = 0; i < 3; i++) {
            balls[n].begin[i] = (float)(i == 1 ? uniform(&r, 0.5, 5) : uniform(&r, -4, 4));
            balls[n].end[i]   = balls[n].begin[i] + (n % 4 ? 0 : (float)uniform(&r, -2, 2));
        }
    }
}

/* How much of a light reaches a place, by all capsules between. */
static double left_of(const vxs_air_light *air, const double place[3])
{
    static smoke_part parts[BALLS];
    double            way[3], metres = 100;
    for (int n = 0; n < 3; n++) way[n] = air->kind == VXS_LIGHT_KIND_DIRECTIONAL ? air->place[n] : air->place[n] - place[n];
    if (air->kind != VXS_LIGHT_KIND_DIRECTIONAL) metres = sqrt(dot(way, way));
    make_unit(way);
    return smoke_left(parts, smoke_parts(balls, BALLS, place, way, parts), metres);
}

static int is_lit(int light, const double place[3])
{
    return vxs_lookup(vxs_asset_light(s.asset, (uint32_t)light), place, NULL, vxs_box(1)) != 0;
}

/* A march of even steps.   dimmed  0: as if there was no smoke */
static double marched(int light, const vxs_volumes_light *l, const vxs_medium *haze, const double eye[3], const double direction[3],
                      double metres, int dimmed)
{
    vxs_air_light air = scene_air_light(&s, l);
    double        in_fog[2], sum = 0;
    vxs_air_path  path = vxs_air_path_of(&air, eye, direction, metres, 1e30, in_fog);
    if (!(path.end > path.begin)) return 0;
    for (int n = 0; n < STEPS; n++) {
        double x = path.begin + (n + 0.5) * (path.end - path.begin) / STEPS, place[3], at[3];
        for (int i = 0; i < 3; i++) place[i] = eye[i] + x * direction[i];
        if (!is_lit(light, place)) continue;
        vxs_air_at(haze, &path, x, at);
        sum += at[0] * (path.end - path.begin) / STEPS * (dimmed ? left_of(&air, place) : 1);
    }
    return (double)l->colour[0] * sum;
}

static vxs_transmittance_map *fine_map(int light)
{
    vxs_transmittance_map *map;
    vxs_transmittance_desc desc = {
        .baked_number = vxs_baked_number((uint32_t)light), .side_px = FINE_SIDE, .capsules = BALLS, .segments = 1 << 18};
    vxs_capsules smoke = {.list = balls, .count = BALLS};
    assert_int_equal(vxs_transmittance_map_create(&map, s.volumes, &desc), VXS_OK);
    assert_int_equal(vxs_transmittance_map_build(map, &smoke, NULL), VXS_OK);
    assert_int_equal(vxs_transmittance_map_counts(map).merged, 0);
    return map;
}

static void test_marches_are_dimmed(void **state)
{
    (void)state;
    static double    metres[FOG_WIDE * FOG_HIGH];
    static float     pixels[FOG_WIDE * FOG_HIGH * 4];
    const vxs_medium haze   = {{0.05, 0.05, 0.05}, {0.06, 0.06, 0.06}, 0.3};
    const double     eye[3] = {9, 6, 7}, to[3] = {0, 2, 0};
    volumes_camera   c = camera_at(eye, to, 0.7);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_transmittance_map *map     = fine_map(light);
        vxs_shadow_depth_map  *opaque  = opaque_map(light);
        vxs_volumes_frame      frame   = scene_frame(&s, &c, &haze, 1e30, 20, metres);
        vxs_volumes_light      shining = scene_light(light);
        shining.smoke                  = map;
        shining.smoke_lookup           = VXS_CURVE_EXPONENTIALS;
        assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_march(s.volumes, &shining, NULL, STEPS, VXS_STEPS_EVEN), VXS_OK);
        double square = 0, clear = 0, size = 0, sums[3] = {0};
        scene_read(&s, pixels);
        for (uint32_t n = 0; n < FOG_WIDE * FOG_HIGH; n++) {
            double direction[3];
            camera_ray(&s, &c, n % FOG_WIDE, n / FOG_WIDE, direction);
            double wanted = marched(light, &shining, &haze, eye, direction, metres[n], 1);
            square += pow((double)pixels[4 * n] - wanted, 2);
            clear += pow(marched(light, &shining, &haze, eye, direction, metres[n], 0) - wanted, 2);
            size += wanted * wanted;
            sums[0] += (double)pixels[4 * n];
        }
        for (int which = 1; which < 3; which++) { /* steps alike in angle, of the asset; even ones, of a map of 32 texels a side */
            assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
            assert_int_equal(vxs_volumes_march(s.volumes, &shining, which == 2 ? opaque : NULL, 4 * STEPS,
                                               which == 2 ? VXS_STEPS_EVEN : VXS_STEPS_EQUIANGULAR),
                             VXS_OK);
            scene_read(&s, pixels);
            for (uint32_t n = 0; n < FOG_WIDE * FOG_HIGH; n++) sums[which] += (double)pixels[4 * n];
        }
        print_message("light %d: relative RMS %.4f, without smoke %.3f; by angles %.3f, by a map %.3f of all\n", light,
                      sqrt(square / size), sqrt(clear / size), sums[1] / sums[0], sums[2] / sums[0]);
        assert_true(sqrt(square / size) < 0.02 && sqrt(clear / size) > 0.05);
        assert_true(fabs(sums[1] / sums[0] - 1) < 0.06 && fabs(sums[2] / sums[0] - 1) < 0.06);
        vxs_shadow_depth_map_destroy(opaque);
        vxs_transmittance_map_destroy(map);
    }
}

/* Any places, within maps and beside them: the result in C for the same curves. What stands before and behind the numbers that are
 * written stays. */
static void test_places(void **state)
{
    (void)state;
    enum { PLACES = 300, FIRST = 7, NUMBERS = FIRST + PLACES + 5 };
    static float places[PLACES][4], left[NUMBERS];
    GLuint       buffers[2];
    rng          r = {3};
    for (int n = 0; n < PLACES; n++)
        for (int i = 0; i < 4; i++) places[n][i] = (float)(i == 1 ? uniform(&r, 0, 6) : uniform(&r, -12, 12));
    s.gl->GenBuffers(2, buffers);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_transmittance_map *map    = map_of(light, light == SCENE_SPOT ? SORTED : STREAMED);
        texels                 t      = texels_of(light, NODES);
        double                 square = 0;
        uint32_t               partly = 0;
        build(map, balls, BALLS, NULL, &t);
        for (int n = 0; n < NUMBERS; n++) left[n] = -2;
        s.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[0]);
        s.gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof places, places, GL_STATIC_DRAW);
        s.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[1]);
        s.gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof left, left, GL_STATIC_DRAW);
        assert_int_equal(vxs_volumes_transmittance_at(s.volumes, map, buffers[0], PLACES, buffers[1], FIRST, VXS_CURVE_LINES),
                         VXS_OK);
        s.gl->GetNamedBufferSubData(buffers[1], 0, sizeof left, left);
        for (int n = 0; n < NUMBERS; n++) {
            if (n < FIRST || n >= FIRST + PLACES) {
                assert_true(left[n] == -2);
                continue;
            }
            const float *at     = places[n - FIRST];
            double       wanted = look_up(&t, (const double[3]){(double)at[0], (double)at[1], (double)at[2]}, 0);
            square += pow((double)left[n] - wanted, 2);
            partly += wanted > 0.05 && wanted < 0.95;
        }
        print_message("light %d: RMS %.1e, %u of %d places dimmed\n", light, sqrt(square / PLACES), partly, PLACES);
        assert_true(sqrt(square / PLACES) < 1e-4 && partly > 20);
        free(t.curves);
    }
    s.gl->DeleteBuffers(2, buffers);
}

static void test_what_is_refused(void **state)
{
    (void)state;
    const vxs_medium       haze   = {{0.05, 0.05, 0.05}, {0.06, 0.06, 0.06}, 0.3};
    const double           eye[3] = {9, 6, 7}, to[3] = {0, 2, 0};
    volumes_camera         c       = camera_at(eye, to, 0.7);
    vxs_transmittance_map *map     = fine_map(SCENE_SUN);
    vxs_shadow_depth_map  *opaque  = opaque_map(SCENE_SUN);
    vxs_volumes_frame      frame   = scene_frame(&s, &c, &haze, 1e30, 20, NULL);
    vxs_volumes_light      shining = scene_light(SCENE_SUN), other = scene_light(SCENE_SPOT);
    vxs_shadow_grid       *grid;
    vxs_shadow_grid_desc   of = {.columns = 16, .rows = 32, .bits = 32};
    shining.smoke = other.smoke = map;
    assert_int_equal(vxs_shadow_grid_create(&grid, s.volumes, &of), VXS_OK);
    assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
    assert_int_equal(vxs_volumes_march(s.volumes, &other, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT); /* another light's */
    assert_int_equal(vxs_volumes_intervals(s.volumes, &shining), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_grid(s.volumes, &shining, NULL, grid, 0), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_map(s.volumes, &shining, opaque), VXS_E_ARGUMENT);
    shining.smoke_lookup = 2;
    assert_int_equal(vxs_volumes_march(s.volumes, &shining, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_transmittance_at(s.volumes, map, 0, 1, 1, 0, VXS_CURVE_LINES), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_transmittance_at(s.volumes, map, 1, 2, 1, UINT32_MAX - 1, VXS_CURVE_LINES), VXS_E_ARGUMENT);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    vxs_shadow_grid_destroy(grid);
    vxs_shadow_depth_map_destroy(opaque);
    vxs_transmittance_map_destroy(map);
}

static int open_all(void **state)
{
    (void)state;
    make_balls();
    scene_open(&s, RESOLUTION, FOG_WIDE, FOG_HIGH);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_marches_are_dimmed),
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_what_is_refused),
    };
    return cmocka_run_group_tests(tests, open_all, close_scene);
}
