/* libvxs_volumes on llvmpipe: light maps against the asset's depths, marches against exact lit intervals in double, what moves joined with what
 * stands, the picture behind fog, the context's state as it was, and no number that is none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_lamp.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "volumes_scene.h"

enum { RESOLUTION = 256, WIDE = 48, HIGH = 40, PIXELS = WIDE * HIGH };

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

static const double eyes[][3]  = {{9, 3, 1}, {-4, 6, 9}, {0.4, 1.5, 0}, {-8, 0.5, -8}};
static const double looks[][3] = {{0, 2, 0}, {0, 1, 0}, {5, 1.6, 2}, {0.5, 2.5, -0.3}};
enum { CAMERAS = sizeof eyes / sizeof *eyes };

/* Relative RMS of a picture. */
static double error_of(const float *pixels, const double *wanted)
{
    double wrong = 0, size = 0;
    for (size_t n = 0; n < PIXELS; n++)
        for (size_t i = 0; i < 3; i++) {
            double w = wanted[3 * n + i], more = (double)pixels[4 * n + i] - w;
            assert_true(isfinite(pixels[4 * n + i]));
            wrong += more * more;
            size += w * w;
        }
    return sqrt(wrong / size);
}

/* A camera's view, and its airlight by exact lit intervals of the asset. */
typedef struct seen {
    vxs_volumes_frame frame;
    double            metres[PIXELS], wanted[3 * PIXELS];
} seen;

static void see(const volumes_scene *s, int camera, int light, double top, seen *v)
{
    volumes_camera    c = camera_at(eyes[camera], looks[camera], 0.8);
    vxs_volumes_light l = scene_light(light);
    v->frame            = scene_frame(s, &c, &haze, top, 30, v->metres);
    memset(v->wanted, 0, sizeof v->wanted);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        camera_ray(s, &c, n % WIDE, n / WIDE, direction);
        scene_airlight(s, &l, &haze, top, c.eye, direction, v->metres[n], v->wanted + 3 * (size_t)n);
    }
}

static vxs_light_map *filled_map(const volumes_scene *s, int light, uint32_t side_px, int moves)
{
    vxs_light_map     *map;
    vxs_light_map_desc desc = {.baked = (uint32_t)light, .side_px = side_px, .moves = (uint32_t)moves};
    assert_int_equal(vxs_light_map_create(&map, s->volumes, &desc), VXS_OK);
    while (vxs_light_map_fill(map, 10000)) continue;
    return map;
}

static float *read_map(const volumes_scene *s, const vxs_light_map *map)
{
    uint32_t side = vxs_light_map_side_px(map), layers = vxs_light_map_layers(map);
    size_t   size = sizeof(float) * side * side * layers;
    float   *data = malloc(size);
    assert_non_null(data);
    s->gl->GetTextureImage(vxs_light_map_texture(map), 0, GL_RED, GL_FLOAT, (GLsizei)size, data);
    return data;
}

/* What a texel is where shadow begins at a voxel. */
static double depth_of(const vxs_light *l, uint32_t voxel)
{
    if (voxel >= 1U << l->levels) return 1e30;
    return l->kind == VXS_LIGHT_KIND_DIRECTIONAL ? voxel : l->near_metres * exp(voxel * l->voxel_metres);
}

static void test_light_maps(void **state)
{
    (void)state;
    volumes_scene s;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (uint32_t shift = 0; shift < 3; shift++) {
            const vxs_baked_light *baked = vxs_asset_light(s.asset, (uint32_t)light);
            uint32_t               side = RESOLUTION >> shift, shadowed = 0;
            vxs_light_map         *map    = filled_map(&s, light, side, 0);
            float                 *found  = read_map(&s, map);
            uint32_t              *voxels = malloc(sizeof *voxels * side * side);
            assert_int_equal(vxs_light_map_side_px(map), side);
            assert_int_equal(vxs_light_map_layers(map), light == SCENE_POINT ? 6 : 1);
            for (uint32_t layer = 0; layer < vxs_light_map_layers(map); layer++) {
                vxs_depth_map_desc desc = {
                    .map = (int32_t)layer, .wide_px = side, .high_px = side, .shift = shift, .voxels = voxels};
                assert_int_equal(vxs_depth_map(baked, &desc, NULL), VXS_OK);
                for (size_t n = 0; n < (size_t)side * side; n++) {
                    double wanted = depth_of(&baked->light, voxels[n]), is = (double)found[layer * side * side + n];
                    if (!(fabs(is - wanted) <= 1e-5 * wanted)) fail_msg("light %d, texel %zu: %g, not %g", light, n, is, wanted);
                    shadowed += voxels[n] < RESOLUTION;
                }
            }
            assert_true(shadowed > side);
            free(voxels);
            free(found);
            vxs_light_map_destroy(map);
        }
    scene_close(&s);
}

/* More steps, less error, by the asset and by its map, to the same limit: the exact intervals. */
static void test_marches(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    float         pixels[4 * PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l   = scene_light(light);
        vxs_light_map    *map = filled_map(&s, light, 0, 0);
        for (int camera = 0; camera < CAMERAS; camera++) {
            double top = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE;
            see(&s, camera, light, top, &v);
            for (int which = VXS_STEPS_EVEN; which <= VXS_STEPS_ANGLE; which++)
                for (int asset = 0; asset < 2; asset++) {
                    double errors[3];
                    for (int n = 0; n < 3; n++) {
                        assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
                        assert_int_equal(vxs_volumes_march(s.volumes, &l, asset ? NULL : map, 16U << (3 * n), (vxs_steps)which),
                                         VXS_OK);
                        scene_read(&s, pixels);
                        errors[n] = error_of(pixels, v.wanted);
                    }
                    if (getenv("VXS_VERBOSE"))
                        print_message("light %d, camera %d, %s, %s: %.4f %.4f %.5f\n", light, camera, which ? "angle" : "even",
                                      asset ? "asset" : "map", errors[0], errors[1], errors[2]);
                    assert_true(errors[2] < 0.2 * errors[0]);
                    assert_true(errors[2] < 3e-3);
                }
        }
        vxs_light_map_destroy(map);
    }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_light_maps),
        cmocka_unit_test(test_marches),
    };
    return cmocka_run_group_tests_name("volumes", tests, NULL, NULL);
}
