/* Area lights as engines use them: an origin that follows a camera, a picture that moves, VPLs with baked shadows; and the extremes
 * of all their numbers.
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

#include "runtime/volumes/area/area_state.h"
#include "volumes_scene.h"

#include "area_scene.h"

static double metres[PIXELS];

/* Normals of what a camera sees, into their texture. */
static void put_normals(const volumes_camera *c)
{
    static float normal[4 * PIXELS];
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3], place[3];
        camera_ray(&scene, c, n % WIDE, n / WIDE, direction);
        for (int i = 0; i < 3; i++) place[i] = c->eye[i] + metres[n] * direction[i];
        area_normal(&scene, place, normal + 4 * (size_t)n);
    }
    scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
}

/* How far pixels are off a factor of others, of the brightest. */
static double difference(const float *a, double factor, const float *b)
{
    double most = 0, off = 0;
    for (int n = 0; n < 4 * PIXELS; n++) {
        most = fmax(most, fabs(factor * (double)b[n]));
        off  = fmax(off, fabs((double)a[n] - factor * (double)b[n]));
    }
    assert_true(most > 0);
    return off / most;
}

/* VPLs and maps stay where they are, and the origin is at the eye: air and surfaces are those of an origin that is
 * with the VPLs. */
static void test_origin_follows_the_eye(void **state)
{
    (void)state;
    enum { COUNT = 9 };
    static float  air[2][4 * PIXELS], surfaces[2][4 * PIXELS];
    vxs_vpl       vpls[COUNT];
    vxs_area_look asked = {.normal_texture = normals};
    screen_vpls(0, vpls, COUNT);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    cast(POINTS, 0);
    for (int camera = 0; camera < CAMERAS; camera++) {
        volumes_camera    c        = camera_at(eyes[camera], look, 0.5);
        vxs_volumes_frame frame    = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
        const float       there[3] = {-frame.eye[0], -frame.eye[1], -frame.eye[2]}, here[3] = {0};
        put_normals(&c);
        for (int turn = 0; turn < 2; turn++) {
            assert_int_equal(vxs_area_light_anchor(light, turn ? there : here), VXS_OK);
            if (turn) memcpy(frame.eye, here, sizeof here);
            if (turn) memcpy(frame.view.point_from_depth + 8, here, sizeof here);
            draw(&frame, &asked, air[turn]);
            scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof *surfaces, surfaces[turn]);
        }
        assert_int_equal(vxs_area_light_anchor(light, here), VXS_OK);
        double off[2] = {difference(air[1], 1, air[0]), difference(surfaces[1], 1, surfaces[0])};
        print_message("with the origin at the eye air differs by %.1e, surfaces by %.1e\n", off[0], off[1]);
        assert_true(off[0] < 5e-3 && off[1] < 5e-2); /* a ray between two columns takes either */
    }
    assert_int_equal(vxs_area_light_anchor(light, (float[3]){0, NAN, 0}), VXS_E_ARGUMENT);
}

/* Where nothing but colours changes shadow maps stay; where a VPL moves, turns, grows, or is one more, there are none. */
static void test_a_picture_moves(void **state)
{
    (void)state;
    enum { COUNT = 9 };
    static float      pixels[2][4 * PIXELS];
    vxs_vpl           vpls[COUNT], kept[COUNT];
    volumes_camera    c     = camera_at(eyes[0], look, 0.7);
    vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
    screen_vpls(0, vpls, COUNT);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    cast(POINTS, 0);
    draw(&frame, &(vxs_area_look){0}, pixels[0]);
    for (int n = 0; n < 3 * COUNT; n++) vpls[n / 3].colour[n % 3] *= 3;
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    assert_true(vxs_area_light_is_cast(light));
    draw(&frame, &(vxs_area_look){0}, pixels[1]);
    assert_true(difference(pixels[1], 3, pixels[0]) < 1e-5);
    for (int n = 0; n < 4; n++) {
        memcpy(kept, vpls, sizeof kept);
        assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
        cast(100, 0);
        if (n == 0) kept[4].place[1] += 1e-3F;
        if (n == 1) memcpy(kept[4].normal, (float[3]){0, 0, 1}, sizeof kept->normal);
        if (n == 2) kept[4].radius_metres *= 2;
        assert_int_equal(vxs_area_light_set(light, kept, n == 3 ? COUNT - 1 : COUNT), VXS_OK);
        assert_false(vxs_area_light_is_cast(light));
        assert_int_equal(vxs_volumes_area(scene.volumes, light, &(vxs_area_look){0}), VXS_E_ARGUMENT);
    }
}

/* What a VPL sends to surfaces, nothing dimmed, one channel: where a map of the asset's lets it through, as rays to the VPL do. */
static void exact_surfaces(const volumes_camera *c, const vxs_vpl *vpl_of, double *wanted)
{
    static float normal[4 * PIXELS];
    scene.gl->GetTextureImage(normals, 0, GL_RGBA, GL_FLOAT, sizeof normal, normal);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3], place[3], above[3], way[3], from[3], here = 0;
        camera_ray(&scene, c, n % WIDE, n / WIDE, direction);
        for (uint32_t i = 0; i < 3; i++) {
            place[i] = c->eye[i] + metres[n] * direction[i];
            above[i] = place[i] + 1e-4 * (double)normal[4 * n + i];
            from[i]  = (double)vpl_of->place[i];
            way[i]   = from[i] - place[i];
            here += way[i] * (double)normal[4 * n + i];
        }
        double square = dot(way, way);
        if (here > 0 && area_is_free(&scene, from, above)) wanted[n] += (double)vpl_of->colour[0] * here / (square * sqrt(square));
    }
}

/* VPLs of a screen and of a sky in one light, in turn: air and surfaces are the sums of what either gives alone, with and without a
 * top of the fog. */
static void test_near_and_far_together(void **state)
{
    (void)state;
    enum { SUM, NEAR, FAR, BOTH, COUNT = 8 };
    static float found[BOTH + 1][2][4 * PIXELS];
    vxs_vpl      vpls[COUNT], some[COUNT];
    screen_vpls(0, vpls, COUNT);
    for (int n = 1; n < COUNT; n += 2) {
        vpls[n].is_far        = 1;
        vpls[n].radius_metres = 13;
        for (int i = 0; i < 3; i++) vpls[n].colour[i] *= 10;
        memcpy(vpls[n].place, (float[3]){0, 2, 0}, sizeof vpls->place);
        memcpy(vpls[n].normal, (float[3]){0.6F * (float)(n - 4) / 4, -0.8F, 0}, sizeof vpls->normal);
        vpls[n].normal[2] = sqrtf(0.36F - vpls[n].normal[0] * vpls[n].normal[0]);
    }
    for (int n = 0; n < 4; n++) {
        volumes_camera    c     = camera_at(eyes[n % CAMERAS], look, 0.5);
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, n < 2 ? 1e30 : 3, 30, metres);
        vxs_area_look     asked = {.normal_texture = normals, .gather = n % 2 ? VXS_AREA_QUARTER : VXS_AREA_EACH};
        put_normals(&c);
        for (int which = NEAR; which <= BOTH; which++) {
            uint32_t count = 0;
            for (int k = 0; k < COUNT; k++)
                if (which == BOTH || (which == FAR) == (vpls[k].is_far != 0)) some[count++] = vpls[k];
            assert_int_equal(vxs_area_light_set(light, some, count), VXS_OK);
            cast(POINTS / 10, 1); /* whole: which points are drawn depends on the number of the VPL */
            draw(&frame, &asked, found[which][0]);
            scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof *found[which],
                                      found[which][1]);
        }
        for (int layer = 0; layer < 2; layer++) {
            float *sum = found[SUM][layer];
            for (size_t k = 0; k < 4 * PIXELS; k++) sum[k] = found[NEAR][layer][k] + found[FAR][layer][k];
            assert_true(difference(found[BOTH][layer], 1, sum) < 1e-5);
            assert_true(difference(found[NEAR][layer], 1, sum) > 1e-3 && difference(found[FAR][layer], 1, sum) > 1e-3);
        }
    }
}

/* VPLs that stay where they are, each with the shadow depth map of a light of the asset: together they are what each is alone, in
 * the air and on surfaces; on surfaces as rays to the VPL say, of the one that shines to all sides. */
static void test_baked_lights(void **state)
{
    (void)state;
    enum { COUNT = 2 };
    static const int            baked[COUNT] = {SCENE_POINT, SCENE_SPOT};
    static float                pixels[COUNT + 1][4 * PIXELS], surfaces[COUNT + 1][4 * PIXELS];
    static double               wanted[PIXELS];
    vxs_shadow_depth_map       *maps[COUNT];
    vxs_vpl                     vpls[COUNT];
    const vxs_shadow_depth_map *given[COUNT];
    double                      off = 0, size = 0, lit[2] = {0};
    for (int n = 0; n < COUNT; n++) {
        vxs_volumes_light   l   = scene_light(baked[n]);
        const vxs_air_light air = scene_air_light(&scene, &l);
        vpls[n]                 = (vxs_vpl){.colour = {l.colour[0], l.colour[1], l.colour[2]}, .radius_metres = l.radius_metres};
        for (int i = 0; i < 3; i++) vpls[n].place[i] = (float)air.place[i];
        assert_int_equal(
            vxs_shadow_depth_map_create(&maps[n], scene.volumes,
                                        &(vxs_shadow_depth_map_desc){.baked_number = vxs_baked_number((uint32_t)baked[n])}),
            VXS_OK);
        while (vxs_shadow_depth_map_fill(maps[n], 1 << 20)) continue;
        given[n] = maps[n];
    }
    const vxs_medium thin = {
        {1e-6, 1e-6, 1e-6}, {1e-6, 1e-6, 1e-6}, 0}; /* so that surfaces are not dimmed, and there is airlight */
    volumes_camera    c     = camera_at(eyes[2], look, 0.7);
    vxs_volumes_frame frame = scene_frame(&scene, &c, &thin, 1e30, 30, metres);
    put_normals(&c);
    exact_surfaces(&c, &vpls[0], wanted);
    for (uint32_t n = 0; n <= COUNT; n++) {
        uint32_t first = n < COUNT ? n : 0;
        assert_int_equal(vxs_area_light_set(light, vpls + first, n < COUNT ? 1 : COUNT), VXS_OK);
        draw(&frame, &(vxs_area_look){.maps = given + first, .normal_texture = normals}, pixels[n]);
        scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof *surfaces, surfaces[n]);
    }
    for (uint32_t n = 0; n < PIXELS; n++) {
        double more = (double)surfaces[0][4 * n] - wanted[n];
        off += more * more;
        size += wanted[n] * wanted[n];
        lit[0] += (double)surfaces[0][4 * n];
        lit[1] += wanted[n];
    }
    print_message("surfaces by a shadow depth map of 64 x 64 texels: RMS %.3f, %.3f of the light\n", sqrt(off / size),
                  lit[0] / lit[1]);
    assert_true(sqrt(off / size) < 0.15 && fabs(lit[0] / lit[1] - 1) < 0.03);
    for (int n = 0; n < 4 * PIXELS; n++) {
        pixels[0][n] += pixels[1][n];
        surfaces[0][n] += surfaces[1][n];
    }
    assert_true(difference(pixels[COUNT], 1, pixels[0]) < 1e-5 && difference(surfaces[COUNT], 1, surfaces[0]) < 1e-5);
    for (int n = 0; n < COUNT; n++) vxs_shadow_depth_map_destroy(maps[n]);
}

/* any numbers ------------------------------------------------------------------------------------------------------------------ */

static double power_of_ten(rng *r, double least, double most)
{
    return pow(10, uniform(r, least, most));
}

/* Rectangles of any size anywhere, with black, sharp and huge textures: VPLs are numbers, on it, and as bright as it where a
 * texture is even. */
static void test_any_rectangle(void **state)
{
    (void)state;
    enum { COUNT = 16, SIDE_MOST_PX = 5 };
    rng      r       = {31};
    uint32_t sampled = 0;
    for (uint32_t n = 0; n < repeats(4000, 40000); n++) {
        float              texture[3 * SIDE_MOST_PX * SIDE_MOST_PX];
        vxs_vpl            vpls[COUNT];
        double             size = power_of_ten(&r, -6, 6), away = rng_below(&r, 2) ? 1e6 : 1;
        vxs_area_rectangle a = {
            .texture = texture, .wide_px = 1 + rng_below(&r, SIDE_MOST_PX), .high_px = 1 + rng_below(&r, SIDE_MOST_PX)};
        for (int i = 0; i < 3; i++) {
            a.corner[i]   = (float)(away * uniform(&r, -1, 1));
            a.across[i]   = (float)(size * uniform(&r, -1, 1));
            a.up[i]       = (float)(size * uniform(&r, -1, 1));
            a.radiance[i] = rng_below(&r, 4) ? (float)power_of_ten(&r, -6, 6) : 0;
        }
        for (int i = 0; i < 3 * SIDE_MOST_PX * SIDE_MOST_PX; i++)
            texture[i] = rng_below(&r, 1 + n % 4) ? 0 : (float)power_of_ten(&r, -6, 6);
        if (n % 9 == 0) a.texture = NULL;
        uint32_t count = 1 + rng_below(&r, COUNT);
        if (vxs_area_sample(&a, (vxs_area_places)rng_below(&r, 4), rng_below(&r, 3), vpls, count) != VXS_OK) continue;
        sampled++;
        for (uint32_t k = 0; k < count; k++) {
            double square = 0;
            for (int i = 0; i < 3; i++) {
                assert_true(isfinite(vpls[k].place[i]) && isfinite(vpls[k].colour[i]) && vpls[k].colour[i] >= 0);
                square += (double)vpls[k].normal[i] * (double)vpls[k].normal[i];
            }
            assert_true(fabs(square - 1) < 1e-3 && vpls[k].radius_metres > 0 && isfinite(vpls[k].radius_metres));
            assert_int_equal(vxs_area_light_set(light, vpls + k, 1), VXS_OK);
        }
    }
    assert_true(sampled > 3900);
}

/* Triangles of any size, flat ones, and none: points are on their boxes. */
static void test_any_triangles(void **state)
{
    (void)state;
    enum { TRIANGLES = 5, COUNT = 40 };
    rng r = {32};
    for (uint32_t n = 0; n < repeats(2000, 20000); n++) {
        float          places[9 * TRIANGLES];
        uint32_t       corners[3 * TRIANGLES];
        vxs_area_point found[COUNT];
        double         size = power_of_ten(&r, -6, 6);
        for (int i = 0; i < 9 * TRIANGLES; i++) places[i] = (float)(size * uniform(&r, -1, 1));
        for (int i = 0; i < 3 * TRIANGLES; i++) corners[i] = rng_below(&r, n % 3 ? 3 * TRIANGLES : 2);
        double area = vxs_area_scatter(places, corners, TRIANGLES, found, COUNT), sum = 0;
        assert_true(isfinite(area) && area >= 0);
        for (int k = 0; k < COUNT && area > 0; k++) {
            for (int i = 0; i < 3; i++) assert_true(fabs((double)found[k].place[i]) <= 1.0001 * size);
            sum += (double)found[k].square_metres;
        }
        assert_true(fabs(sum - area) <= 1e-5 * area);
    }
}

/* VPLs as small as 1e-6 m, 1e6 m away, at the eye and at each other; points on VPLs, and of any size; air as dense as ink. Nothing
 * is no number, or negative. */
static void test_any_view(void **state)
{
    (void)state;
    enum { COUNT = 3, CASTERS = 200 };
    static float          pixels[2][4 * PIXELS];
    static vxs_area_point some[CASTERS];
    rng                   r = {33};
    GLuint                buffer;
    scene.gl->GenBuffers(1, &buffer);
    for (uint32_t n = 0; n < repeats(24, 1000); n++) {
        double     away   = n % 3 ? power_of_ten(&r, -3, 6) : 1, eye[3], to[3];
        vxs_medium medium = {.anisotropy = uniform(&r, -0.99, 0.99)};
        vxs_vpl    vpls[COUNT];
        for (int i = 0; i < 3; i++) {
            medium.extinction[i] = rng_below(&r, 4) ? power_of_ten(&r, -8, 4) : 0;
            medium.scattering[i] = medium.extinction[i];
            eye[i]               = uniform(&r, -9, 9);
            to[i]                = uniform(&r, -5, 5);
        }
        for (int k = 0; k < COUNT; k++) {
            double normal[3];
            random_direction(&r, normal);
            vpls[k] = (vxs_vpl){.radius_metres = (float)power_of_ten(&r, -6, 1), .colour = {(float)power_of_ten(&r, -6, 6), 0, 1}};
            for (int i = 0; i < 3; i++) {
                vpls[k].place[i]  = (float)(rng_below(&r, 4) ? away * uniform(&r, -1, 1) : eye[i]);
                vpls[k].normal[i] = (float)normal[i];
            }
            if (n % 5 == 0) memcpy(vpls[k].place, vpls[0].place, sizeof vpls->place);
        }
        for (int k = 0; k < CASTERS; k++) {
            for (int i = 0; i < 3; i++) some[k].place[i] = k % 3 ? (float)(away * uniform(&r, -1, 1)) : vpls[k % COUNT].place[i];
            some[k].square_metres = (float)power_of_ten(&r, -12, 12);
        }
        scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
        scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof some, some, GL_STATIC_DRAW);
        volumes_camera    c = camera_at(eye, to, power_of_ten(&r, -3, 0.5));
        vxs_volumes_frame frame =
            scene_frame(&scene, &c, &medium, rng_below(&r, 3) ? 1e30 : uniform(&r, -1, 5), power_of_ten(&r, -3, 7), metres);
        put_normals(&c);
        assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
        assert_int_equal(vxs_area_light_anchor(light, (float[3]){n % 4 ? 0 : (float)away, 0, 0}), VXS_OK);
        assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, CASTERS, rng_below(&r, 2)}), VXS_OK);
        draw(&frame,
             &(vxs_area_look){.gather = (vxs_area_gather)rng_below(&r, 3), .runs = rng_below(&r, 20), .normal_texture = normals},
             pixels[0]);
        scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof *pixels, pixels[1]);
        for (size_t k = 0; k < 8 * PIXELS; k++) {
            float value = pixels[k / (4 * PIXELS)][k % (4 * PIXELS)];
            if (!(isfinite(value) && value >= 0)) fail_msg("frame %u, value %zu: %g", n, k, (double)value);
        }
    }
    assert_int_equal(vxs_area_light_anchor(light, (float[3]){0, 0, 0}), VXS_OK);
    scene.gl->DeleteBuffers(1, &buffer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_origin_follows_the_eye),
        cmocka_unit_test(test_a_picture_moves),
        cmocka_unit_test(test_near_and_far_together),
        cmocka_unit_test(test_baked_lights),
        cmocka_unit_test(test_any_rectangle),
        cmocka_unit_test(test_any_triangles),
        cmocka_unit_test(test_any_view),
    };
    return cmocka_run_group_tests(tests, area_set_up, area_tear_down);
}
