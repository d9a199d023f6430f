/* Rivals for shadows in fog (tests/volumes/rival_*.h): each reaches its own limit, exact lit intervals in double, as its knobs
 * grow, and is off as it is known to be where they are small. Sun, spot and point light, from four sides, llvmpipe.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "repeats.h"
#include "tests/volumes/map_parts.h"
#include "tests/volumes/metrics.h"
#include "tests/volumes/reference.h"
#include "tests/volumes/rival_froxels.h"
#include "tests/volumes/rival_slices.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "volumes_scene.h"

enum { RESOLUTION = 256, WIDE = 40, HIGH = 32, PIXELS = WIDE * HIGH, CAMERAS = 4 };

static const vxs_medium haze = {.scattering = {0.03, 0.035, 0.04}, .extinction = {0.04, 0.045, 0.05}, .anisotropy = 0.4};

static const double eyes[CAMERAS][3]  = {{9, 3, 1}, {-4, 6, 9}, {0.4, 1.5, 0}, {-8, 0.5, -8}};
static const double looks[CAMERAS][3] = {{0, 2, 0}, {0, 1, 0}, {5, 1.6, 2}, {0.5, 2.5, -0.3}};

/* Airlight by exact traversal of a light's map, from a camera. */
typedef struct truth_seen {
    int     is_known;
    double  airlight[3 * PIXELS];
    uint8_t classes[PIXELS];
} truth_seen;

/* A light seen by a camera. */
typedef struct seen {
    vxs_volumes_light     light;
    vxs_shadow_depth_map *map;
    vxs_volumes_frame     frame;
    const truth_seen     *wanted;
} seen;

static vxs_shadow_depth_map *filled_map(const volumes_scene *s, int light)
{
    vxs_shadow_depth_map     *map;
    vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number((uint32_t)light)};
    assert_int_equal(vxs_shadow_depth_map_create(&map, s->volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(map, 100000)) continue;
    return map;
}

static float *read_map(const volumes_scene *s, const vxs_shadow_depth_map *map)
{
    size_t side = vxs_shadow_depth_map_side_px(map), size = sizeof(float) * side * side * vxs_shadow_depth_map_layers(map);
    float *data = malloc(size);
    assert_non_null(data);
    s->gl->GetTextureImage(vxs_shadow_depth_map_texture(map), 0, GL_RED, GL_FLOAT, (GLsizei)size, data);
    return data;
}

static void find_truth(const volumes_scene *s, const volumes_camera *c, int light, double top, const vxs_shadow_depth_map *map,
                       const double *metres, truth_seen *t)
{
    vxs_volumes_light l      = scene_light(light);
    float            *first  = read_map(s, map);
    shadow_depth_map  texels = {&vxs_asset_light(s->asset, (uint32_t)light)->light, vxs_shadow_depth_map_side_px(map),
                                vxs_shadow_depth_map_layers(map), first};
    reference_light   of     = {.light = scene_air_light(s, &l), .oracle = map_parts, .subject = &texels};
    for (int n = 0; n < 3; n++) of.colour[n] = (double)l.colour[n];
    for (uint32_t n = 0; n < PIXELS; n++) {
        eye_ray ray = {.end = metres[n]};
        memcpy(ray.eye, c->eye, sizeof ray.eye);
        camera_ray(s, c, n % WIDE, n / WIDE, ray.direction);
        reference_airlight(&haze, top, &of, &ray, t->airlight + 3 * (size_t)n);
        if (light != SCENE_SUN)
            t->classes[n] = (uint8_t)pixel_class_of(ray.eye, ray.direction, of.light.place, of.light.radius_metres);
    }
    free(first);
    t->is_known = 1;
}

/* What all tests see: the truth is found once. */
static void see(const volumes_scene *s, int camera, int light, seen *v)
{
    static truth_seen known[SCENE_LIGHTS][CAMERAS];
    static double     metres[PIXELS];
    truth_seen       *t   = &known[light][camera];
    volumes_camera    c   = camera_at(eyes[camera], looks[camera], 0.8);
    double            top = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE;
    v->light              = scene_light(light);
    v->map                = filled_map(s, light);
    v->frame              = scene_frame(s, &c, &haze, top, 30, metres);
    v->wanted             = t;
    if (!t->is_known) find_truth(s, &c, light, top, v->map, metres, t);
}

/* Relative RMS of the frame outside the epipole. */
static double frame_error(const volumes_scene *s, const seen *v)
{
    static float  pixels[4 * PIXELS];
    static double found[3 * PIXELS];
    scene_read(s, pixels);
    for (size_t n = 0; n < 3 * PIXELS; n++) {
        found[n] = (double)pixels[n / 3 * 4 + n % 3];
        assert_true(isfinite(found[n]) && found[n] >= 0);
    }
    return picture_error_of(found, v->wanted->airlight, PIXELS, v->wanted->classes, PIXELS_ELSEWHERE).relative_rms;
}

/* As many columns as pixels, and more and more slices; then few columns. */
static void test_froxels(void **state)
{
    (void)state;
    volumes_scene s;
    seen          v;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            const uint32_t most        = repeats(512, 1024);
            const uint32_t sizes[4][3] = {{WIDE, HIGH, 16}, {WIDE, HIGH, 128}, {WIDE, HIGH, most}, {WIDE / 8, HIGH / 8, most}};
            double         errors[4];
            see(&s, camera, light, &v);
            for (int n = 0; n < 4; n++) {
                rival_froxels *froxels;
                assert_int_equal(rival_froxels_create(&froxels, s.volumes, sizes[n][0], sizes[n][1], sizes[n][2]), VXS_OK);
                assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
                assert_int_equal(rival_froxels_add(froxels, &v.light, v.map), VXS_OK);
                errors[n] = frame_error(&s, &v);
                rival_froxels_destroy(froxels);
            }
            if (getenv("VXS_VERBOSE"))
                print_message("light %d, camera %d: %.4f %.4f %.5f; few columns %.3f\n", light, camera, errors[0], errors[1],
                              errors[2], errors[3]);
            assert_true(errors[2] < 2e-2 && errors[2] < 0.06 * errors[0]); /* first order */
            assert_true(errors[3] > 3 * errors[2]);
            if (light == SCENE_SUN && camera != 1) assert_true(errors[0] < 0.016); /* pixels read between slices */
            vxs_shadow_depth_map_destroy(v.map);
        }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

static void draw_slices(const volumes_scene *s, const seen *v, rival_slices *slices)
{
    assert_int_equal(vxs_volumes_begin(s->volumes, &v->frame), VXS_OK);
    assert_int_equal(rival_slices_add(slices, &v->light, v->map), VXS_OK);
}

static double slices_error(const volumes_scene *s, const seen *v, rival_slices *slices)
{
    draw_slices(s, v, slices);
    return frame_error(s, v);
}

/* Each pixel by itself, in more and more slices of more bins; then between samples, many and few. */
static void test_slices(void **state)
{
    (void)state;
    volumes_scene s;
    seen          v;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            static const uint32_t sizes[5][3] = {{64, 128, 0}, {256, 512, 0}, {1024, 2048, 0}, {512, 512, 128}, {32, 512, 16}};
            double                errors[5];
            see(&s, camera, light, &v);
            for (int n = 0; n < 5; n++) {
                rival_slices *slices;
                assert_int_equal(rival_slices_create(&slices, s.volumes, sizes[n][0], sizes[n][1], sizes[n][2]), VXS_OK);
                errors[n] = slices_error(&s, &v, slices);
                rival_slices_destroy(slices);
            }
            if (getenv("VXS_VERBOSE"))
                print_message("light %d, camera %d: %.4f %.4f %.5f; samples: many %.4f, few %.3f\n", light, camera, errors[0],
                              errors[1], errors[2], errors[3], errors[4]);
            assert_true(errors[2] < 2e-3 && errors[2] < 0.12 * errors[0]);
            assert_true(errors[3] < 1e-2 && errors[4] > 10 * errors[2]);
            if (light == SCENE_SUN && camera != 1)
                assert_true(errors[4] < 0.03); /* pixels before what samples see walk themselves */
            vxs_shadow_depth_map_destroy(v.map);
        }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* A tree has no more than its leaves: the same picture bin by bin, wherever a punctual light is nearest to a ray. */
static void test_slices_tree(void **state)
{
    (void)state;
    volumes_scene s;
    seen          v;
    static float  pixels[2][4 * PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            rival_slices *slices;
            double        most = 0, largest = 0;
            see(&s, camera, light, &v);
            assert_int_equal(rival_slices_create(&slices, s.volumes, 64, 1024, 0), VXS_OK);
            for (int flat = 0; flat < 2; flat++) {
                rival_slices_set_flat(slices, flat);
                draw_slices(&s, &v, slices);
                scene_read(&s, pixels[flat]);
            }
            for (size_t n = 0; n < 4 * PIXELS; n++) {
                most    = fmax(most, fabs((double)pixels[0][n] - (double)pixels[1][n]));
                largest = fmax(largest, (double)pixels[1][n]);
            }
            if (getenv("VXS_VERBOSE")) print_message("light %d, camera %d: %.1e\n", light, camera, most / largest);
            assert_true(most < 1e-6 * largest);
            rival_slices_destroy(slices);
            vxs_shadow_depth_map_destroy(v.map);
        }
    scene_close(&s);
}

/* More and more questions along a ray: of one bin four moments know all. */
static void test_moments(void **state)
{
    (void)state;
    volumes_scene s;
    seen          v;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            static const uint32_t parts[5] = {1, 4, 16, 64, 1024};
            double                errors[5];
            rival_slices         *slices;
            see(&s, camera, light, &v);
            assert_int_equal(rival_slices_create(&slices, s.volumes, repeats(512, 1024), repeats(512, 1024), 0), VXS_OK);
            for (int n = 0; n < 5; n++) {
                assert_int_equal(rival_slices_set_moments(slices, parts[n]), VXS_OK);
                errors[n] = slices_error(&s, &v, slices);
            }
            if (getenv("VXS_VERBOSE"))
                print_message("light %d, camera %d: %.4f %.4f %.4f %.4f %.4f\n", light, camera, errors[0], errors[1], errors[2],
                              errors[3], errors[4]);
            assert_true(errors[0] < 0.15 && errors[1] < 0.035 && errors[2] < 0.01);
            assert_true(errors[4] < 5e-3 && errors[4] < 0.1 * errors[0]);
            rival_slices_destroy(slices);
            vxs_shadow_depth_map_destroy(v.map);
        }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* Any camera, among them the eye at the light, beside it, and looking at it or away: nothing but numbers. */
static void test_finite(void **state)
{
    (void)state;
    static double metres[PIXELS];
    static float  pixels[4 * PIXELS];
    volumes_scene s;
    rng           r = {9};
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    rival_froxels *froxels;
    rival_slices  *slices;
    assert_int_equal(rival_froxels_create(&froxels, s.volumes, 10, 8, 32), VXS_OK);
    assert_int_equal(rival_slices_create(&slices, s.volumes, 64, 256, 64), VXS_OK);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light     l     = scene_light(light);
        vxs_shadow_depth_map *map   = filled_map(&s, light);
        vxs_air_light         place = scene_air_light(&s, &l);
        for (uint32_t n = 0; n < repeats(12, 200); n++) {
            double eye[3], to[3], away = n % 4 == 0 ? 0 : n % 4 == 1 ? 1e-3 : 5;
            for (int k = 0; k < 3; k++) {
                eye[k] = (light == SCENE_SUN ? 0 : place.place[k]) + away * uniform(&r, -1, 1);
                to[k]  = n % 3 && away > 0 && light != SCENE_SUN ? place.place[k] : eye[k] + uniform(&r, -1, 1);
            }
            if (light == SCENE_SUN && n % 3)
                for (int k = 0; k < 3; k++) to[k] = eye[k] + (n % 2 ? 1 : -1) * place.place[k];
            volumes_camera    c     = camera_at(eye, to, 0.8);
            vxs_volumes_frame frame = scene_frame(&s, &c, &haze, n % 5 ? VXS_AIR_EVERYWHERE : 2, 30, metres);
            for (int which = 0; which < 3; which++) {
                assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
                assert_int_equal(rival_slices_set_moments(slices, which == 2 ? 8 : 0), VXS_OK);
                if (which == 0)
                    assert_int_equal(rival_froxels_add(froxels, &l, map), VXS_OK);
                else
                    assert_int_equal(rival_slices_add(slices, &l, map), VXS_OK);
                scene_read(&s, pixels);
                for (size_t k = 0; k < 4 * PIXELS; k++)
                    if (!(isfinite(pixels[k]) && pixels[k] >= 0))
                        fail_msg("rival %d, light %d, view %u: %g", which, light, n, (double)pixels[k]);
            }
        }
        vxs_shadow_depth_map_destroy(map);
    }
    rival_froxels_destroy(froxels);
    rival_slices_destroy(slices);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_froxels), cmocka_unit_test(test_slices), cmocka_unit_test(test_slices_tree),
        cmocka_unit_test(test_moments), cmocka_unit_test(test_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
