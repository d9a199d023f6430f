/* Area lights that are far away: VPLs of a sky by luminance and direction, against sums over all of it; their airlight and their
 * light on surfaces against exact visibility.
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
#include "baker/base/spread.h"

enum { SKY_WIDE = 32, SKY_HIGH = 16, SKY_TEXELS = SKY_WIDE * SKY_HIGH };

static float  texture[3 * SKY_TEXELS];
static double metres[PIXELS], wanted[3 * PIXELS];

/* Blue, dark below, and a patch of the sun's size in texels. */
static vxs_area_sky make_sky(void)
{
    for (int n = 0; n < SKY_TEXELS; n++) {
        int          y = n / SKY_WIDE, is_patch = y == 4 && n % SKY_WIDE == 9;
        const double colour[3] = {0.2, 0.4, 0.8};
        for (int i = 0; i < 3; i++)
            texture[3 * n + i] = y >= SKY_HIGH / 2 ? 0 : is_patch ? 200 : (float)(colour[i] * (1 + 0.1 * y));
    }
    return (vxs_area_sky){texture, SKY_WIDE, SKY_HIGH, {1, 0.9F, 0.8F}, {0, 2, 0}, 13};
}

static double luminance(const float *c)
{
    return 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
}

/* The irradiance of a plane across `normal`, and of a sphere, that texels in parts give: each part by its solid angle. */
static double exactly(const vxs_area_sky *sky, const double normal[3], double *all)
{
    enum { FINE = 24 };
    double sum = 0;
    *all       = 0;
    for (int y = 0; y < SKY_HIGH * FINE; y++)
        for (int x = 0; x < SKY_WIDE * FINE; x++) {
            const float *texel = sky->texture + 3 * (y / FINE * SKY_WIDE + x / FINE);
            double       polar = M_PI * (y + 0.5) / (SKY_HIGH * FINE), turn = 2 * M_PI * (x + 0.5) / (SKY_WIDE * FINE), here = 0;
            double       solid =
                2 * M_PI / (SKY_WIDE * FINE) * (cos(M_PI * y / (SKY_HIGH * FINE)) - cos(M_PI * (y + 1) / (SKY_HIGH * FINE)));
            const double way[3] = {sin(polar) * cos(turn), cos(polar), sin(polar) * sin(turn)};
            float        lit[3];
            for (int i = 0; i < 3; i++) lit[i] = texel[i] * sky->radiance[i];
            for (int i = 0; i < 3; i++) here += way[i] * normal[i];
            *all += solid * luminance(lit);
            sum += solid * luminance(lit) * fmax(here, 0);
        }
    return sum;
}

static double by_vpls(const vxs_vpl *vpls, uint32_t count, const double normal[3])
{
    double sum = 0;
    for (uint32_t n = 0; n < count; n++) {
        double here = 0;
        for (int i = 0; i < 3; i++) here -= (double)vpls[n].normal[i] * normal[i];
        sum += luminance(vpls[n].colour) * fmax(here, 0);
    }
    return sum;
}

/* All light is there by importance, and none comes from where the sky is black; ways are of length 1. */
static void test_energy(void **state)
{
    (void)state;
    const double up[3] = {0, 1, 0};
    vxs_area_sky sky   = make_sky();
    vxs_vpl      vpls[VXS_VPLS_MAX];
    double       all, sum;
    exactly(&sky, up, &all);
    for (uint32_t count = 1; count <= VXS_VPLS_MAX; count = 3 * count + 1) {
        assert_int_equal(vxs_area_sample_sky(&sky, VXS_AREA_IMPORTANCE, count, vpls, count), VXS_OK);
        sum = 0;
        for (uint32_t n = 0; n < count; n++) {
            double way[3] = {(double)vpls[n].normal[0], (double)vpls[n].normal[1], (double)vpls[n].normal[2]};
            sum += luminance(vpls[n].colour);
            assert_true(fabs(dot(way, way) - 1) < 1e-5 && way[1] <= 0 && vpls[n].is_far == 1);
            assert_true(fabs(luminance(vpls[n].colour) / all * count - 1) < 1e-5);
        }
        assert_true(fabs(sum / all - 1) < 1e-6);
    }
}

/* Relative RMS of irradiance of a tilted plane over seeds, right in the mean; its slope by the number of VPLs. */
static void test_convergence(void **state)
{
    (void)state;
    enum { SEEDS = 60 };
    static const char *const names[]   = {"Halton", "importance", "regular", "jittered"};
    const double             normal[3] = {0.6, 0.8, 0};
    vxs_area_sky             sky       = make_sky();
    vxs_vpl                  vpls[VXS_VPLS_MAX];
    double                   all, is = exactly(&sky, normal, &all), last[4], slope[4];
    for (int places = 0; places <= VXS_AREA_JITTERED; places++) {
        double first = 0, mean = 0;
        for (uint32_t count = 4; count <= 256; count *= 8) {
            double square = 0;
            mean          = 0;
            for (uint32_t seed = 1; seed <= SEEDS; seed++) {
                assert_int_equal(vxs_area_sample_sky(&sky, (vxs_area_places)places, seed, vpls, count), VXS_OK);
                double off = by_vpls(vpls, count, normal) / is - 1;
                square += off * off / SEEDS;
                mean += off / SEEDS;
            }
            last[places] = sqrt(square);
            if (count == 4) first = last[places];
        }
        slope[places] = log(last[places] / first) / log(64);
        print_message("%s: error of 256 VPLs %.4f, slope %.2f\n", names[places], last[places], slope[places]);
        if (places != VXS_AREA_REGULAR) assert_true(fabs(mean) < 4 * last[places] / sqrt(SEEDS) + 1e-3);
    }
    assert_true(last[VXS_AREA_IMPORTANCE] < 0.02 && slope[VXS_AREA_IMPORTANCE] < -0.6);
    assert_true(last[VXS_AREA_REGULAR] > 5 * last[VXS_AREA_IMPORTANCE] && last[VXS_AREA_JITTERED] > 5 * last[VXS_AREA_IMPORTANCE]);
}

/* One that shines along the baked sun: airlight of the exact lit parts of each ray; surfaces by rays to it. */
static void test_a_sun(void **state)
{
    (void)state;
    static float        pixels[4 * PIXELS], normal[4 * PIXELS];
    vxs_volumes_light   l   = scene_light(SCENE_SUN);
    const vxs_air_light sun = scene_air_light(&scene, &l);
    vxs_vpl of = {.colour = {l.colour[0], l.colour[1], l.colour[2]}, .place = {0, 2, 0}, .radius_metres = 13, .is_far = 1};
    for (int i = 0; i < 3; i++) of.normal[i] = (float)-sun.place[i];
    vxs_area_light *coarse = light;
    assert_int_equal(vxs_area_light_create(&light, scene.volumes, &(vxs_area_light_desc){.vpls = 1, .side_px = 256}), VXS_OK);
    assert_int_equal(vxs_area_light_set(light, &of, 1), VXS_OK);
    cast(POINTS, 0);
    for (int camera = 0; camera < CAMERAS; camera++) {
        volumes_camera    c     = camera_at(eyes[camera], look, 0.7);
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
        double            off = 0, size = 0, found = 0, there = 0;
        memset(wanted, 0, sizeof wanted);
        for (uint32_t n = 0; n < PIXELS; n++) {
            double direction[3], place[3], above[3], far[3];
            camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
            scene_airlight(&scene, &l, &haze, 1e30, c.eye, direction, metres[n], wanted + 3 * (size_t)n);
            for (int i = 0; i < 3; i++) place[i] = c.eye[i] + metres[n] * direction[i];
            area_normal(&scene, place, normal + 4 * (size_t)n);
            double here = 0;
            for (int i = 0; i < 3; i++) {
                here += (double)normal[4 * n + (uint32_t)i] * sun.place[i];
                above[i] = place[i] + 1e-4 * (double)normal[4 * n + (uint32_t)i];
                far[i]   = above[i] + 100 * sun.place[i];
            }
            normal[4 * n + 3] = here > 0 && area_is_free(&scene, far, above) ? (float)here : 0;
        }
        scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
        draw(&frame, &(vxs_area_look){.normal_texture = normals}, pixels);
        double air = relative_rms(pixels, wanted, 1);
        scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof pixels, pixels);
        for (size_t n = 0; n < PIXELS; n++) {
            double lit = (double)normal[4 * n + 3] * (double)of.colour[0], more = (double)pixels[4 * n] - lit;
            off += more * more;
            found += (double)pixels[4 * n];
            there += lit;
            size += lit * lit;
        }
        print_message("a sun: airlight RMS %.3f, surfaces %.3f, %.3f of the light\n", air, sqrt(off / size), found / there);
        assert_true(air < 0.015 && sqrt(off / size) < 0.2 && fabs(found / there - 1) < 0.02);
    }
    vxs_area_light_destroy(light);
    light = coarse;
}

/* a floor in a corner ---------------------------------------------------------------------------------------------------------- */

enum { CORNER_POINTS = 1 << 18, CORNER_SEEDS_MOST = 9 };

/* Two walls of 40 metres, and a floor of 20 between them, where x and z are positive. */
static const float    corner_places[]    = {0, 0, 0, 20, 0, 0,  20, 0,  20, 0, 0,  20, /* the floor */
                                            0, 0, 0, 0,  0, 20, 0,  40, 20, 0, 40, 0,  0, 0, 0, 20, 0, 0, 20, 40, 0, 0, 40, 0};
static const uint32_t corner_triangles[] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 8, 9, 10, 8, 10, 11};

/* What the floor gets of a sky of radiance 1, by directions of equal parts of it. */
static double in_corner(double x, double z)
{
    enum { STEPS = 120 };
    double sum = 0;
    for (int n = 0; n < STEPS * STEPS; n++) {
        double cosine = sqrt((n / STEPS + 0.5) / STEPS), sine = sqrt(1 - cosine * cosine),
               turn      = 2 * M_PI * (n % STEPS + 0.5) / STEPS;
        double way[3]    = {sine * cos(turn), cosine, sine * sin(turn)};
        int    is_hidden = 0;
        for (int axis = 0; axis < 3; axis += 2) {
            double from[3] = {x, 0, z}, at = -from[axis] / way[axis], across = from[2 - axis] + at * way[2 - axis];
            is_hidden |= way[axis] < 0 && at * way[1] <= 40 && across >= 0 && across <= 20;
        }
        sum += !is_hidden;
    }
    return M_PI * sum / (STEPS * STEPS);
}

/* What a view from above sees of the floor: depths and normals go up.   right  [out] [PIXELS] what each pixel gets; 0: it does not
 * count */
static vxs_volumes_frame look_down(double *right)
{
    static const vxs_medium clear  = {.anisotropy = 0};
    static const double     eye[3] = {4, 8, 4.01}, to[3] = {4, 0, 4};
    static float            depths[PIXELS], normal[4 * PIXELS];
    volumes_camera          c     = camera_at(eye, to, 0.4);
    vxs_volumes_frame       frame = scene_frame(&scene, &c, &clear, 1e30, 30, NULL);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
        double away = -eye[1] / direction[1], x = eye[0] + away * direction[0], z = eye[2] + away * direction[2];
        depths[n]         = (float)(NEAR_METRES / (away * dot(direction, c.forward)));
        normal[4 * n + 1] = 1;
        right[n]          = n % 5 == 2 && x > 1 && z > 1 ? in_corner(x, z) : 0;
    }
    scene.gl->TextureSubImage2D(scene.depths, 0, 0, 0, WIDE, HIGH, GL_RED, GL_FLOAT, depths);
    scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
    return frame;
}

/* Under an even sky, RMS of parts of what the floor gets.   bright  [out] how bright it is, of how bright it is to be */
static double error_in_corner(const vxs_volumes_frame *frame, const double *right, uint32_t seed, uint32_t vpl_count,
                              uint32_t point_count, double *bright)
{
    static float       pixels[4 * PIXELS];
    float              white[3 * 16] = {0};
    const vxs_area_sky sky           = {white, 4, 4, {1, 1, 1}, {10, 20, 10}, 25};
    vxs_area_point    *of_corner     = malloc(point_count * sizeof *of_corner);
    vxs_vpl            vpls[VXS_VPLS_MAX];
    GLuint             buffer;
    double             off = 0, size = 0, found = 0, there = 0;
    for (int n = 0; n < 48; n++) white[n] = n < 24; /* there is none from below */
    assert_non_null(of_corner);
    assert_true(vxs_area_scatter(corner_places, corner_triangles, 6, of_corner, point_count) > 0);
    scene.gl->GenBuffers(1, &buffer);
    scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(point_count * sizeof *of_corner), of_corner, GL_STATIC_DRAW);
    free(of_corner);
    assert_int_equal(vxs_area_sample_sky(&sky, VXS_AREA_IMPORTANCE, seed, vpls, vpl_count), VXS_OK);
    assert_int_equal(vxs_area_light_set(light, vpls, vpl_count), VXS_OK);
    assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, point_count, 0}), VXS_OK);
    draw(frame, &(vxs_area_look){.normal_texture = normals}, pixels);
    scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof pixels, pixels);
    scene.gl->DeleteBuffers(1, &buffer);
    for (uint32_t n = 0; n < PIXELS; n++) {
        if (right[n] == 0) continue;
        off += pow((double)pixels[4 * n] - right[n], 2);
        size += right[n] * right[n];
        found += (double)pixels[4 * n];
        there += right[n];
    }
    *bright = found / there;
    return sqrt(off / size);
}

/* In a corner a floor has half of an even sky. More VPLs, and more points, never make it worse: medians over seeds; so at the 65th
 * VPL of 2^18 points. */
static void test_in_a_corner(void **state)
{
    (void)state;
    static const uint32_t vpls[]   = {16, 64, 65, 256, 4, 4, 4},
                          counts[] = {1 << 18, 1 << 18, 1 << 18, 1 << 18, 1 << 12, 1 << 15, 1 << 18};
    static double     right[PIXELS];
    uint32_t          seeds  = repeats(3, CORNER_SEEDS_MOST);
    vxs_area_light   *coarse = light;
    vxs_volumes_frame frame  = look_down(right);
    double            before = INFINITY, found[CORNER_SEEDS_MOST], bright[CORNER_SEEDS_MOST];
    assert_int_equal(vxs_area_light_create(&light, scene.volumes, &(vxs_area_light_desc){.columns = 1, .rows = 1}), VXS_OK);
    for (int n = 0; n < 7; n++) {
        if (vpls[n] == 256 && seeds < CORNER_SEEDS_MOST) continue;
        for (uint32_t seed = 0; seed < seeds; seed++)
            found[seed] = error_in_corner(&frame, right, seed, vpls[n], counts[n], &bright[seed]);
        qsort(found, seeds, sizeof *found, doubles_ascending);
        qsort(bright, seeds, sizeof *bright, doubles_ascending);
        print_message("in a corner: %u VPLs, %u points: RMS %.3f, %.3f of the light\n", vpls[n], counts[n], found[seeds / 2],
                      bright[seeds / 2]);
        if (vpls[n] == 4 && counts[n] == 1 << 12) before = INFINITY;
        assert_true(found[seeds / 2] < (vpls[n] == 65 ? 1.4 : 1.1) * before); /* 64 of Hammersley's points are more even than 65 */
        assert_true(vpls[n] < 64 || fabs(bright[seeds / 2] - 1) < 0.05);
        before = found[seeds / 2];
    }
    vxs_area_light_destroy(light);
    light = coarse;
}

/* A sky together with a screen, of any number of VPLs: nothing is no number; what is refused. */
static void test_any_sky(void **state)
{
    (void)state;
    enum { COUNT = 5 };
    static float pixels[2][4 * PIXELS];
    rng          r   = {4};
    vxs_area_sky sky = make_sky();
    vxs_vpl      vpls[COUNT + 2];
    for (uint32_t n = 0; n < repeats(8, 400); n++) {
        double eye[3]     = {uniform(&r, -9, 9), uniform(&r, -2, 9), uniform(&r, -9, 9)},
               to[3]      = {uniform(&r, -5, 5), 2, uniform(&r, -5, 5)};
        vxs_medium medium = haze;
        for (int i = 0; i < 3; i++) medium.extinction[i] = medium.scattering[i] = pow(10, uniform(&r, -8, 4));
        sky.radius_metres = (float)pow(10, uniform(&r, -3, 6));
        assert_int_equal(vxs_area_sample_sky(&sky, (vxs_area_places)(n % 4), n, vpls, COUNT), VXS_OK);
        screen_vpls(n, vpls + COUNT, 2);
        if (n % 3 == 0) /* the eye looks along the light, or against it */
            for (int i = 0; i < 3; i++) to[i] = eye[i] + (n % 2 ? 1 : -1) * (double)vpls[0].normal[i];
        volumes_camera    c = camera_at(eye, to, 0.7);
        vxs_volumes_frame frame =
            scene_frame(&scene, &c, &medium, n % 4 ? 1e30 : uniform(&r, -1, 5), pow(10, uniform(&r, -2, 5)), metres);
        assert_int_equal(vxs_area_light_set(light, vpls, COUNT + 2), VXS_OK);
        cast(3000, n % 2);
        draw(&frame, &(vxs_area_look){.normal_texture = normals}, pixels[0]);
        scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof *pixels, pixels[1]);
        for (size_t k = 0; k < 8 * PIXELS; k++) {
            float value = pixels[k / (4 * PIXELS)][k % (4 * PIXELS)];
            if (!(isfinite(value) && value >= 0)) fail_msg("frame %u, value %zu: %g", n, k, (double)value);
        }
    }
    sky.radius_metres = 0;
    assert_int_equal(vxs_area_sample_sky(&sky, VXS_AREA_HALTON, 0, vpls, 1), VXS_E_ARGUMENT);
    sky.radius_metres = 1;
    sky.texture       = NULL;
    assert_int_equal(vxs_area_sample_sky(&sky, VXS_AREA_HALTON, 0, vpls, 1), VXS_E_ARGUMENT);
    memset(vpls[0].normal, 0, sizeof vpls->normal);
    vpls[0].is_far = 1;
    assert_int_equal(vxs_area_light_set(light, vpls, 1), VXS_E_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_energy),      cmocka_unit_test(test_convergence), cmocka_unit_test(test_a_sun),
        cmocka_unit_test(test_in_a_corner), cmocka_unit_test(test_any_sky),
    };
    return cmocka_run_group_tests(tests, area_set_up, area_tear_down);
}
