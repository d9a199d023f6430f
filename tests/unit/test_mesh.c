/* Polygonal light volumes of libvxs_volumes on llvmpipe: each pixel's airlight against the same mesh walked in double, the count of
 * its crossings, what is clamped, and no NaN.
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

#include "mesh_walk.h"
#include "volumes_scene.h"

enum { RESOLUTION = 256, WIDE = 40, HIGH = 32, PIXELS = WIDE * HIGH };

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* How a surface is drawn. */
typedef enum surface { OF_MAP, OF_MESH, OF_FEW, SURFACES } surface;

/* A light's map, its texels, and its mesh with a quad for each, and with few. */
typedef struct lit_surface {
    vxs_volumes_light     light;
    vxs_shadow_depth_map *map;
    float                *texels;
    mesh_lists            all, few;
    vxs_light_mesh       *meshes[SURFACES];
} lit_surface;

static lit_surface surface_make(const volumes_scene *s, const vxs_volumes_light *light, uint32_t side_px)
{
    lit_surface               out  = {.light = *light};
    vxs_shadow_depth_map_desc desc = {.baked_number = light->baked_number, .constants = light->constants, .side_px = side_px};
    assert_int_equal(vxs_shadow_depth_map_create(&out.map, s->volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(out.map, UINT64_MAX)) continue;
    uint32_t side = vxs_shadow_depth_map_side_px(out.map), layers = vxs_shadow_depth_map_layers(out.map);
    size_t   size = sizeof(float) * side * side * layers;
    out.texels    = malloc(size);
    assert_non_null(out.texels);
    s->gl->GetTextureImage(vxs_shadow_depth_map_texture(out.map), 0, GL_RED, GL_FLOAT, (GLsizei)size, out.texels);

    const vxs_light_constants *constants =
        light->constants ? light->constants : &vxs_gl_constants(s->shadows)[light->baked_number - 1];
    vxs_light_mesh_desc of = {.light = constants, .first = out.texels, .side_px = side, .far_metres = 60};
    out.all                = mesh_make(&of);
    of.error_texels        = 0.5F;
    out.few                = mesh_make(&of);
    assert_true(out.few.size.triangle_count < out.all.size.triangle_count);
    for (int n = OF_MESH; n < SURFACES; n++) {
        const mesh_lists *m = n == OF_FEW ? &out.few : &out.all;
        assert_int_equal(vxs_light_mesh_create(&out.meshes[n], s->volumes, m->places, m->corners, &m->size), VXS_OK);
    }
    return out;
}

static void surface_free(lit_surface *l)
{
    for (int n = OF_MESH; n < SURFACES; n++) vxs_light_mesh_destroy(l->meshes[n]);
    vxs_shadow_depth_map_destroy(l->map);
    mesh_free(&l->all);
    mesh_free(&l->few);
    free(l->texels);
}

/* The frame's airlight by one of its surfaces. */
static void draw_surface(const volumes_scene *s, const lit_surface *l, surface which, const vxs_volumes_frame *f, float *pixels)
{
    assert_int_equal(vxs_volumes_begin(s->volumes, f), VXS_OK);
    assert_int_equal(which == OF_MAP ? vxs_volumes_mesh_map(s->volumes, &l->light, l->map)
                                     : vxs_volumes_mesh(s->volumes, &l->light, l->meshes[which]),
                     VXS_OK);
    scene_read(s, pixels);
}

/* Airlight and count of a ray by the mesh: each crossing's, in double.   sum  [in, out] */
static int walk_airlight(const mesh_lists *m, const vxs_light *light, const vxs_air_path *path, const double eye[3],
                         const double direction[3], double metres, const float colour[3], double sum[3])
{
    double from[3], way[3], at, lit[3];
    int    count = 0;
    vxs_ls_from_ws(light, eye, 1, from);
    vxs_ls_from_ws(light, direction, 0, way);
    for (uint32_t t = 0; t < m->size.triangle_count; t++) {
        int sign = crossing(m, t, from, way, &at);
        if (!sign) continue;
        count += sign;
        vxs_air_lit(&haze, path, 0, fmin(at, metres), lit);
        for (int i = 0; i < 3; i++) sum[i] += sign * (double)colour[i] * lit[i];
    }
    return count;
}

/* In every pixel the ray leaves what is lit once more than it enters where the eye is in light, and as often else. */
static void test_counts(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    static double metres[PIXELS];
    uint32_t      lit = 0, asked = 0;
    rng           r = {1};
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l = scene_light(light);
        lit_surface       u = surface_make(&s, &l, 64);
        for (uint32_t n = 0; n < repeats(12, 500); n++) {
            volumes_camera    c      = scene_random_camera(&r);
            vxs_volumes_frame f      = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            int               wanted = mesh_is_lit(&u.all, &vxs_asset_light(s.asset, l.baked_number - 1)->light, c.eye);
            vxs_pixels        seen;
            int               few = mesh_is_lit(&u.few, &vxs_asset_light(s.asset, l.baked_number - 1)->light, c.eye);
            for (int which = 0; which < SURFACES; which++) {
                draw_surface(&s, &u, (surface)which, &f, pixels);
                vxs_volumes_cull(s.volumes, &l, &seen);
                for (uint32_t k = 0; k < PIXELS; k++) {
                    if (k % WIDE - seen.x >= seen.wide_px || k / WIDE - seen.y >= seen.high_px) continue; /* none of its light */
                    if (pixels[4 * k + 3] != (float)(which == OF_FEW ? few : wanted))
                        fail_msg("light %d, camera %u, surface %d, pixel %u: %g", light, n, which, k, (double)pixels[4 * k + 3]);
                    asked++;
                }
            }
            lit += (uint32_t)wanted;
        }
        surface_free(&u);
    }
    print_message("%u pixels, %u of %u eyes in light\n", asked, lit, repeats(12, 500) * SCENE_LIGHTS);
    assert_true(asked > 2000 * repeats(12, 500));
    assert_true(lit > repeats(12, 500) / 2 && lit < repeats(12, 500) * SCENE_LIGHTS - repeats(12, 500) / 2);
    scene_close(&s);
}

/* Airlight as the mesh has it: to 1e-3 of all, and where there is none, to 1e-3 of the brightest. */
static void test_airlight(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    static double metres[PIXELS], wanted[3 * PIXELS], few[3 * PIXELS];
    rng           r               = {2};
    double        worst[SURFACES] = {0}, least = 0;
    uint32_t      dark = 0;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l     = scene_light(light);
        lit_surface       u     = surface_make(&s, &l, 32);
        vxs_air_light     air   = scene_air_light(&s, &l);
        const vxs_light  *baked = &vxs_asset_light(s.asset, l.baked_number - 1)->light;
        for (uint32_t n = 0; n < repeats(3, 60); n++) {
            volumes_camera    c   = scene_random_camera(&r);
            double            top = n % 3 == 2 ? 2.5 : VXS_AIR_EVERYWHERE, in_fog[2], brightest = 0;
            vxs_volumes_frame f = scene_frame(&s, &c, &haze, top, 30, metres);
            memset(wanted, 0, sizeof wanted);
            memset(few, 0, sizeof few);
            for (uint32_t k = 0; k < PIXELS; k++) {
                double direction[3];
                camera_ray(&s, &c, k % WIDE, k / WIDE, direction);
                vxs_air_path path = vxs_air_path_of(&air, c.eye, direction, metres[k], top, in_fog);
                walk_airlight(&u.all, baked, &path, c.eye, direction, metres[k], l.colour, wanted + 3 * (size_t)k);
                walk_airlight(&u.few, baked, &path, c.eye, direction, metres[k], l.colour, few + 3 * (size_t)k);
                for (size_t i = 0; i < 3; i++) brightest = fmax(brightest, wanted[3 * (size_t)k + i]);
            }
            for (int which = 0; which < SURFACES; which++) {
                const double *w     = which == OF_FEW ? few : wanted;
                double        error = 0, size = 0;
                draw_surface(&s, &u, (surface)which, &f, pixels);
                for (size_t k = 0; k < PIXELS; k++)
                    for (size_t i = 0; i < 3; i++) {
                        double found = (double)pixels[4 * k + i], apart = found - w[3 * k + i];
                        error += apart * apart;
                        size += w[3 * k + i] * w[3 * k + i];
                        assert_true(found >= -1e-3 * brightest);
                        if (w[3 * k + i] > 1e-6 * brightest) continue;
                        dark++;
                        least = fmax(least, fabs(found) / fmax(brightest, 1e-30));
                    }
                if (!(size > 0)) continue; /* fog that no light reaches */
                worst[which] = fmax(worst[which], sqrt(error / size));
            }
        }
        surface_free(&u);
    }
    print_message("relative RMS at most %.1e of maps, %.1e of meshes, %.1e of few quads; %u dark, at most %.1e of the brightest\n",
                  worst[OF_MAP], worst[OF_MESH], worst[OF_FEW], dark, least);
    for (int which = 0; which < SURFACES; which++) assert_true(worst[which] < 1e-3);
    assert_true(dark > 1000 && least < 1e-3);
    scene_close(&s);
}

/* A face that is seen from its edge may be drawn in a pixel whose ray passes beside it: the pixel of a view that is farthest off
 * exact intervals is still as the mesh in double has it. */
static void test_edge_on(void **state)
{
    (void)state;
    enum { ACROSS = 160, UP = 120, ALL = ACROSS * UP };
    volumes_scene s;
    static float  pixels[4 * ALL], exact[4 * ALL];
    static double metres[ALL];
    rng           r = {19};
    scene_open(&s, RESOLUTION, ACROSS, UP);
    vxs_volumes_light l     = scene_light(SCENE_POINT);
    lit_surface       u     = surface_make(&s, &l, RESOLUTION);
    vxs_air_light     air   = scene_air_light(&s, &l);
    const vxs_light  *baked = &vxs_asset_light(s.asset, l.baked_number - 1)->light;
    for (uint32_t n = 0; n < repeats(2, 60); n++) {
        volumes_camera    c = scene_random_camera(&r);
        vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
        double            direction[3], wanted[3] = {0}, in_fog[2], brightest = 0;
        uint32_t          most = 0;
        draw_surface(&s, &u, OF_FEW, &f, pixels);
        assert_int_equal(vxs_volumes_begin(s.volumes, &f), VXS_OK);
        assert_int_equal(vxs_volumes_intervals(s.volumes, &l), VXS_OK);
        scene_read(&s, exact);
        for (uint32_t k = 0; k < ALL; k++) {
            if (fabsf(pixels[4 * k] - exact[4 * k]) > fabsf(pixels[4 * most] - exact[4 * most])) most = k;
            brightest = fmax(brightest, (double)exact[4 * k]);
        }
        camera_ray(&s, &c, most % ACROSS, most / ACROSS, direction);
        vxs_air_path path = vxs_air_path_of(&air, c.eye, direction, metres[most], VXS_AIR_EVERYWHERE, in_fog);
        walk_airlight(&u.few, baked, &path, c.eye, direction, metres[most], l.colour, wanted);
        double off = fabs((double)pixels[4 * most] - wanted[0]) / brightest;
        if (off > 1e-3) fail_msg("view %u, pixel %u: %g, not %g", n, most, (double)pixels[4 * most], wanted[0]);
    }
    surface_free(&u);
    scene_close(&s);
}

/* Light that nothing ends: what is drawn is the airlight before the walls, whatever lies behind them. */
static void test_clamped(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    static double metres[PIXELS];
    rng           r        = {3};
    double        worst[2] = {0}; /* of spot lights: a float does not know well where a ray along the side of a cone ends in it */
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_light_constants constants = vxs_gl_constants(s.shadows)[light];
        vxs_volumes_light   l         = scene_light(light);
        vxs_air_light       air       = scene_air_light(&s, &l);
        l.constants                   = &constants;
        int         spot              = constants.kind == VXS_LIGHT_KIND_SPOT;
        lit_surface u                 = surface_make(&s, &l, 32);
        for (uint32_t n = 0; n < repeats(4, 60); n++) {
            volumes_camera    c = scene_random_camera(&r);
            vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            double            in_fog[2];
            for (int which = 0; which < SURFACES; which++) {
                draw_surface(&s, &u, (surface)which, &f, pixels);
                for (uint32_t k = 0; k < PIXELS; k++) {
                    double direction[3], wanted[3];
                    camera_ray(&s, &c, k % WIDE, k / WIDE, direction);
                    vxs_air_path path = vxs_air_path_of(&air, c.eye, direction, metres[k], VXS_AIR_EVERYWHERE, in_fog);
                    vxs_air_lit(&haze, &path, 0, metres[k], wanted);
                    for (size_t i = 0; i < 3; i++) {
                        double found = (double)pixels[4 * (size_t)k + i], of = (double)l.colour[i] * wanted[i];
                        worst[spot] = fmax(worst[spot], fabs(found - of) / (of + 1e-3));
                    }
                }
            }
        }
        surface_free(&u);
    }
    print_message("relative error at most %.1e, of spot lights %.1e\n", worst[0], worst[1]);
    assert_true(worst[0] < 1e-4 && worst[1] < 2e-3);
    scene_close(&s);
}

/* Two lights are the sum of each, behind a march, too: crossings are counted for each light alone. */
static void test_lights_add(void **state)
{
    (void)state;
    volumes_scene s;
    static float  parts[3][4 * PIXELS], both[4 * PIXELS];
    static double metres[PIXELS];
    rng           r = {6};
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_volumes_light sun = scene_light(SCENE_SUN), point = scene_light(SCENE_POINT), spot = scene_light(SCENE_SPOT);
    lit_surface       a = surface_make(&s, &sun, 32), b = surface_make(&s, &point, 32);
    for (uint32_t n = 0; n < repeats(6, 100); n++) {
        volumes_camera    c = scene_random_camera(&r);
        vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
        draw_surface(&s, &a, OF_FEW, &f, parts[0]);
        draw_surface(&s, &b, OF_MAP, &f, parts[1]);
        assert_int_equal(vxs_volumes_begin(s.volumes, &f), VXS_OK);
        assert_int_equal(vxs_volumes_march(s.volumes, &spot, NULL, 16, VXS_STEPS_EVEN), VXS_OK);
        scene_read(&s, parts[2]);
        assert_int_equal(vxs_volumes_mesh(s.volumes, &a.light, a.meshes[OF_FEW]), VXS_OK);
        assert_int_equal(vxs_volumes_mesh_map(s.volumes, &b.light, b.map), VXS_OK);
        scene_read(&s, both);
        for (size_t k = 0; k < 4 * PIXELS; k++) {
            float sum = parts[0][k] + parts[1][k] + parts[2][k];
            if (k % 4 < 3 && !(fabsf(both[k] - sum) <= 1e-4F * (sum + 1))) fail_msg("%g, not %g", (double)both[k], (double)sum);
        }
    }
    surface_free(&a);
    surface_free(&b);
    scene_close(&s);
}

/* Where a light counts it is drawn as without a least, and nowhere else. */
static void test_least(void **state)
{
    (void)state;
    volumes_scene s;
    static float  all[4 * PIXELS], some[4 * PIXELS];
    static double metres[PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_volumes_light l = scene_light(SCENE_POINT);
    lit_surface       u = surface_make(&s, &l, 32);
    volumes_camera    c = camera_at((const double[3]){14, 5, 14}, (const double[3]){2, 2, 0}, 0.8);
    vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
    for (int which = 0; which < SURFACES; which++) {
        vxs_pixels seen;
        f.min_radiance = 0;
        draw_surface(&s, &u, (surface)which, &f, all);
        f.min_radiance = 0.15F;
        draw_surface(&s, &u, (surface)which, &f, some);
        assert_int_equal(vxs_volumes_cull(s.volumes, &l, &seen), VXS_NOT_CULLED);
        assert_in_range(seen.wide_px * seen.high_px, PIXELS / 20, PIXELS / 2);
        for (uint32_t k = 0; k < PIXELS; k++) {
            int within = k % WIDE - seen.x < seen.wide_px && k / WIDE - seen.y < seen.high_px;
            for (size_t i = 0; i < 4; i++) assert_true(some[4 * (size_t)k + i] == (within ? all[4 * (size_t)k + i] : 0));
        }
    }
    surface_free(&u);
    scene_close(&s);
}

/* Numbers, whatever the view, the medium and the light. */
static void test_any_numbers(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    static double metres[PIXELS];
    rng           r = {4};
    scene_open(&s, 64, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light   l   = scene_light(light);
        lit_surface         u   = surface_make(&s, &l, 16);
        const vxs_air_light air = scene_air_light(&s, &l);
        for (uint32_t n = 0; n < repeats(20, 2000); n++) {
            double     eye[3], to[3];
            vxs_medium medium = {.anisotropy = rng_below(&r, 4) ? uniform(&r, -0.9, 0.9) : 0.99 * (int)rng_below(&r, 3) - 0.99};
            for (int i = 0; i < 3; i++) {
                medium.extinction[i] = exp(uniform(&r, log(1e-8), log(1e4)));
                medium.scattering[i] = medium.extinction[i] * uniform(&r, 0, 1);
                eye[i]               = uniform(&r, -12, 12) * (rng_below(&r, 8) ? 1 : 1e6);
                to[i]                = uniform(&r, -5, 5);
            }
            if (!rng_below(&r, 4))
                memcpy(eye, air.place, sizeof eye); /* the eye at the light, or the light in the middle of the view */
            if (!rng_below(&r, 4)) memcpy(to, air.place, sizeof to);
            to[0] += 1e-3;
            u.light.radius_metres = (float)exp(uniform(&r, log(1e-6), log(10)));
            volumes_camera    c   = camera_at(eye, to, exp(uniform(&r, log(1e-3), log(5))));
            vxs_volumes_frame f   = scene_frame(&s, &c, &medium, rng_below(&r, 2) ? VXS_AIR_EVERYWHERE : uniform(&r, -1, 8),
                                                exp(uniform(&r, log(1e-3), log(1e18))), metres);
            for (int which = 0; which < SURFACES; which++) {
                draw_surface(&s, &u, (surface)which, &f, pixels);
                for (size_t k = 0; k < 4 * PIXELS; k++)
                    if (!isfinite(pixels[k]))
                        fail_msg("light %d, view %u, surface %d, pixel %zu: %g", light, n, which, k / 4, (double)pixels[k]);
            }
        }
        surface_free(&u);
    }
    scene_close(&s);
}

static void test_arguments(void **state)
{
    (void)state;
    volumes_scene       s;
    static double       metres[PIXELS];
    vxs_light_mesh     *mesh;
    const float         places[9]  = {0};
    const uint32_t      corners[3] = {0, 1, 2};
    vxs_light_mesh_size none = {0, 1}, far_too_large = {UINT32_MAX, UINT32_MAX}, good = {3, 1};
    rng                 r = {5};
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_volumes_light l = scene_light(SCENE_SPOT);
    lit_surface       u = surface_make(&s, &l, 8);
    assert_int_equal(vxs_light_mesh_create(&mesh, s.volumes, places, corners, &none), VXS_E_ARGUMENT);
    assert_null(mesh);
    assert_int_equal(vxs_light_mesh_create(&mesh, s.volumes, NULL, corners, &good), VXS_E_ARGUMENT);
    assert_int_equal(vxs_light_mesh_create(&mesh, s.volumes, places, corners, &far_too_large), VXS_E_MEMORY);
    vxs_light_mesh_destroy(NULL);
    assert_int_equal(vxs_volumes_mesh(s.volumes, &l, u.meshes[OF_MESH]), VXS_E_ARGUMENT); /* no frame */
    volumes_camera    c = scene_random_camera(&r);
    vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
    assert_int_equal(vxs_volumes_begin(s.volumes, &f), VXS_OK);
    assert_int_equal(vxs_volumes_mesh(s.volumes, &l, NULL), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_map(s.volumes, &l, NULL), VXS_E_ARGUMENT);
    for (int n = 0; n < 4; n++) f.view.point_from_depth[4 + n] = 0; /* a view without height */
    assert_int_equal(vxs_volumes_begin(s.volumes, &f), VXS_OK);
    assert_int_equal(vxs_volumes_mesh(s.volumes, &l, u.meshes[OF_MESH]), VXS_E_ARGUMENT);
    surface_free(&u);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),      cmocka_unit_test(test_airlight),   cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_clamped),     cmocka_unit_test(test_lights_add), cmocka_unit_test(test_least),
        cmocka_unit_test(test_any_numbers), cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
