/* libvxs_volumes on llvmpipe: shadow depth maps against the asset's depths, marches against exact lit intervals in double, what
 * moves joined with what stands, the picture behind fog, the context's state as it was, and no number that is none.
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

#include "tests/volumes/map_parts.h"
#include "tests/volumes/reference.h"
#include "volumes_scene.h"

enum { RESOLUTION = 256, WIDE = 24, HIGH = 20, PIXELS = WIDE * HIGH };

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

static const double eyes[][3]  = {{9, 3, 1}, {-4, 6, 9}, {0.4, 1.5, 0}, {-8, 0.5, -8}};
static const double looks[][3] = {{0, 2, 0}, {0, 1, 0}, {5, 1.6, 2}, {0.5, 2.5, -0.3}};
enum { CAMERAS = sizeof eyes / sizeof *eyes };

/* Relative RMS of a picture.   mean  [out] how much brighter it is in the mean, relative */
static double error_of(const float *pixels, const double *wanted, double *mean)
{
    double wrong = 0, size = 0, sum = 0, brighter = 0;
    for (size_t n = 0; n < PIXELS; n++)
        for (size_t i = 0; i < 3; i++) {
            double w = wanted[3 * n + i], more = (double)pixels[4 * n + i] - w;
            assert_true(isfinite(pixels[4 * n + i]));
            wrong += more * more;
            size += w * w;
            sum += w;
            brighter += more;
        }
    *mean = brighter / sum;
    return sqrt(wrong / size);
}

/* A camera's view, and its airlight by exact lit intervals of the asset. */
typedef struct seen {
    vxs_volumes_frame frame;
    double            metres[PIXELS], wanted[3 * PIXELS];
} seen;

static void see_in(const volumes_scene *s, int camera, int light, const vxs_medium *medium, double top, seen *v)
{
    volumes_camera    c = camera_at(eyes[camera], looks[camera], 0.8);
    vxs_volumes_light l = scene_light(light);
    v->frame            = scene_frame(s, &c, medium, top, 30, v->metres);
    memset(v->wanted, 0, sizeof v->wanted);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        camera_ray(s, &c, n % WIDE, n / WIDE, direction);
        scene_airlight(s, &l, medium, top, c.eye, direction, v->metres[n], v->wanted + 3 * (size_t)n);
    }
}

static void see(const volumes_scene *s, int camera, int light, double top, seen *v)
{
    see_in(s, camera, light, &haze, top, v);
}

static vxs_shadow_depth_map *filled_map(const volumes_scene *s, int light, uint32_t side_px, int moves)
{
    vxs_shadow_depth_map     *map;
    vxs_shadow_depth_map_desc desc = {
        .baked_number = vxs_baked_number((uint32_t)light), .side_px = side_px, .moves = (uint32_t)moves};
    assert_int_equal(vxs_shadow_depth_map_create(&map, s->volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(map, 10000)) continue;
    return map;
}

static float *read_map(const volumes_scene *s, const vxs_shadow_depth_map *map)
{
    uint32_t side = vxs_shadow_depth_map_side_px(map), layers = vxs_shadow_depth_map_layers(map);
    size_t   size = sizeof(float) * side * side * layers;
    float   *data = malloc(size);
    assert_non_null(data);
    s->gl->GetTextureImage(vxs_shadow_depth_map_texture(map), 0, GL_RED, GL_FLOAT, (GLsizei)size, data);
    return data;
}

/* What a texel is where shadow begins at a voxel. */
static double depth_of(const vxs_light *l, uint32_t voxel)
{
    if (voxel >= 1U << l->levels) return 1e30;
    return l->kind == VXS_LIGHT_KIND_DIRECTIONAL ? voxel : l->near_metres * exp(voxel * l->voxel_metres);
}

static void test_shadow_depth_maps(void **state)
{
    (void)state;
    volumes_scene s;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (uint32_t shift = 0; shift < 3; shift++) {
            const vxs_baked_light *baked = vxs_asset_light(s.asset, (uint32_t)light);
            uint32_t               side = RESOLUTION >> shift, shadowed = 0;
            vxs_shadow_depth_map  *map    = filled_map(&s, light, side, 0);
            float                 *found  = read_map(&s, map);
            uint32_t              *voxels = malloc(sizeof *voxels * side * side);
            assert_int_equal(vxs_shadow_depth_map_side_px(map), side);
            assert_int_equal(vxs_shadow_depth_map_layers(map), light == SCENE_POINT ? 6 : 1);
            for (uint32_t layer = 0; layer < vxs_shadow_depth_map_layers(map); layer++) {
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
            vxs_shadow_depth_map_destroy(map);
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
        vxs_volumes_light     l   = scene_light(light);
        vxs_shadow_depth_map *map = filled_map(&s, light, 0, 0);
        for (int camera = 0; camera < CAMERAS; camera++) {
            double top = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE;
            if (!scene_asks(light, camera)) continue;
            see(&s, camera, light, top, &v);
            for (int which = VXS_STEPS_EVEN; which <= VXS_STEPS_EQUIANGULAR; which++)
                for (int asset = 0; asset < 2; asset++) {
                    double errors[3], mean;
                    for (int n = 0; n < 3; n++) {
                        assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
                        assert_int_equal(vxs_volumes_march(s.volumes, &l, asset ? NULL : map, 16U << (2 * n), (vxs_steps)which),
                                         VXS_OK);
                        scene_read(&s, pixels);
                        errors[n] = error_of(pixels, v.wanted, &mean);
                    }
                    if (getenv("VXS_VERBOSE"))
                        print_message("light %d, camera %d, %s, %s: %.4f %.4f %.5f, %.5f\n", light, camera,
                                      which ? "angle" : "even", asset ? "asset" : "map", errors[0], errors[1], errors[2], mean);
                    /* a sun's steps of what it scatters query at their middle: where they begin there is less shadow, or more */
                    assert_true(fabs(mean) < (light == SCENE_SUN && which ? 1.5e-4 : 1.2e-3));
                    assert_true(errors[2] < 0.4 * errors[0]);
                    assert_true(errors[2] < 3e-3);
                }
        }
        vxs_shadow_depth_map_destroy(map);
    }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* In fog of which a ray sees a thirtieth or less, and in fog of which one channel is thin and another thick, a march of few steps
 * loses nothing. */
static void test_marches_in_dense_fog(void **state)
{
    (void)state;
    static const vxs_medium media[] = {
        {{0.9, 0.9, 0.9}, {1, 1, 1}, 0.3}, {{9, 9, 9}, {10, 10, 10}, 0}, {{0.02, 0.5, 4}, {0.02, 1, 5}, 0.5}};
    volumes_scene s;
    static seen   v;
    float         pixels[4 * PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l = scene_light(light);
        for (size_t k = 0; k < sizeof media / sizeof *media; k++) {
            double top = k == 1 && light != SCENE_POINT ? 3 : VXS_AIR_EVERYWHERE; /* punctual lights above it, too */
            see_in(&s, light == SCENE_SUN ? 0 : 2, light, &media[k], top, &v);
            for (int which = VXS_STEPS_EVEN; which <= VXS_STEPS_EQUIANGULAR; which++) {
                double mean;
                assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
                assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 32, (vxs_steps)which), VXS_OK);
                scene_read(&s, pixels);
                double error = error_of(pixels, v.wanted, &mean);
                if (getenv("VXS_VERBOSE"))
                    print_message("light %d, medium %zu, %s: brighter by %.4f, error %.4f\n", light, k, which ? "angle" : "even",
                                  mean, error);
                assert_true(fabs(mean) < 0.03 && error < 0.03);
            }
        }
    }
    scene_close(&s);
}

/* A march of more steps than a driver's loops have rounds for is that of fewer. */
static void test_many_steps(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    static float  pixels[2][4 * PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light += 2) {
        vxs_volumes_light l = scene_light(light);
        double            some[3 * PIXELS], mean;
        see(&s, 1, light, VXS_AIR_EVERYWHERE, &v);
        for (int n = 0; n < 2; n++) {
            assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
            assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, n ? 16000 : 700, VXS_STEPS_EQUIANGULAR), VXS_OK);
            scene_read(&s, pixels[n]);
        }
        for (int n = 0; n < 3 * PIXELS; n++) some[n] = (double)pixels[0][4 * (n / 3) + n % 3];
        assert_true(error_of(pixels[1], some, &mean) < 2e-3);
        assert_true(error_of(pixels[1], v.wanted, &mean) < 1e-3);
    }
    scene_close(&s);
}

/* Rays that graze the ground through thousands of texels: intervals in pieces are exact, those of a dispatch are the same where no
 * driver ended them, and rays that one ended are counted. */
static void test_intervals_in_pieces(void **state)
{
    (void)state;
    enum { FINE = 4096 };
    static const double eye[3] = {-9.5, 0.001, 0.4}, to[3] = {9, 0, 0.1};
    volumes_scene       s;
    static float        whole[4 * PIXELS], pieces[4 * PIXELS];
    static double       metres[PIXELS], wanted[3 * PIXELS];
    scene_open(&s, FINE, WIDE, HIGH);
    volumes_camera    c     = camera_at(eye, to, 0.002);
    vxs_volumes_frame frame = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l = scene_light(light);
        double            mean;
        memset(wanted, 0, sizeof wanted);
        for (uint32_t n = 0; n < PIXELS; n++) {
            double direction[3];
            camera_ray(&s, &c, n % WIDE, n / WIDE, direction);
            scene_airlight(&s, &l, &haze, VXS_AIR_EVERYWHERE, c.eye, direction, metres[n], wanted + 3 * (size_t)n);
        }
        assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_intervals(s.volumes, &l), VXS_OK);
        uint32_t cut = vxs_volumes_cut(s.volumes), short_of = 0;
        scene_read(&s, whole);
        assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_intervals_in_pieces(s.volumes, &l), VXS_OK);
        assert_int_equal(vxs_volumes_cut(s.volumes), 0);
        scene_read(&s, pieces);
        double error = error_of(pieces, wanted, &mean);
        for (int n = 0; n < PIXELS; n++) short_of += whole[4 * n] < 0.999F * pieces[4 * n];
        if (getenv("VXS_VERBOSE"))
            print_message("light %d: error %.1e, %u rays cut, %u short of light\n", light, error, cut, short_of);
        assert_true(error < 1e-4);
        assert_true(short_of <= cut);
    }
    scene_close(&s);
}

/* What moves: a disc that faces the light two metres before it (the sun: among the boxes), seen by a depth map of
 * the light's own. */
typedef struct moving_disc {
    double             depth, radius; /* of punctual lights metres, of the sun voxels and texels */
    vxs_moving_casters casters;
} moving_disc;

enum { JOINED_SIDE = 128, MOVING_PX = 512 };

static moving_disc disc_before(const volumes_scene *s, int light, GLuint depths)
{
    const vxs_light *l      = &vxs_asset_light(s->asset, (uint32_t)light)->light;
    const double    *m      = l->ls_from_ws;
    int              is_sun = l->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double           side   = ldexp(1, (int)l->levels);
    moving_disc      d      = {is_sun ? side / 6 : 2, is_sun ? side / 5 : 0.7, {depths, MOVING_PX, MOVING_PX, {0}, 1.0F}};
    /* texture coordinates and depth by light space: a plane's depth is linear in the sun's, and 1 - near / z of
     * a punctual light's */
    double           across = is_sun ? 1 / side : 0.4, rows[4][4] = {{0}};
    float           *seen_depths = malloc(sizeof(float) * MOVING_PX * MOVING_PX);
    assert_non_null(seen_depths);
    for (int n = 0; n < 4; n++) {
        double x = m[n], y = m[4 + n], z = m[8 + n], one = n == 3;
        rows[3][n] = is_sun ? one : z;
        rows[0][n] = across * x + (is_sun ? 0 : 0.5 * z);
        rows[1][n] = across * y + (is_sun ? 0 : 0.5 * z);
        rows[2][n] = is_sun ? z / side : z - 0.1 * one;
    }
    for (int n = 0; n < 16; n++) d.casters.depth_from_point[n] = (float)rows[n % 4][n / 4];
    for (int n = 0; n < MOVING_PX * MOVING_PX; n++) {
        double u = (n % MOVING_PX + 0.5) / MOVING_PX, v = (n / MOVING_PX + 0.5) / MOVING_PX;
        double x       = is_sun ? u / across - 0.5 * side : (u - 0.5) / across * d.depth,
               y       = is_sun ? v / across - 0.5 * side : (v - 0.5) / across * d.depth;
        int inside     = x * x + y * y < d.radius * d.radius;
        seen_depths[n] = !inside ? 1 : is_sun ? (float)(d.depth / side) : (float)((d.depth - 0.1) / d.depth);
    }
    s->gl->TextureSubImage2D(depths, 0, 0, 0, MOVING_PX, MOVING_PX, GL_RED, GL_FLOAT, seen_depths);
    free(seen_depths);
    return d;
}

static GLuint moving_depths(const volumes_scene *s)
{
    GLuint depths;
    s->gl->CreateTextures(GL_TEXTURE_2D, 1, &depths);
    s->gl->TextureStorage2D(depths, 1, GL_R32F, MOVING_PX, MOVING_PX);
    return depths;
}

/* On each light ray the nearer of what moves and what stands, and nothing elsewhere. */
static void test_joined(void **state)
{
    (void)state;
    enum { SIDE = JOINED_SIDE };
    volumes_scene s;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    GLuint depths = moving_depths(&s);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        const vxs_light      *l      = &vxs_asset_light(s.asset, (uint32_t)light)->light;
        int                   is_sun = l->kind == VXS_LIGHT_KIND_DIRECTIONAL;
        moving_disc           moving = disc_before(&s, light, depths);
        double                side = ldexp(1, (int)l->levels), disc = moving.depth, radius = moving.radius;
        vxs_shadow_depth_map *map = filled_map(&s, light, SIDE, 1);
        assert_int_equal(vxs_shadow_depth_map_join(map, NULL, 0), VXS_OK);
        float *alone = read_map(&s, map);
        assert_int_equal(vxs_shadow_depth_map_join(map, &moving.casters, 1), VXS_OK);
        float   *joined = read_map(&s, map);
        uint32_t nearer = 0, kept = 0;
        for (uint32_t n = 0; n < SIDE * SIDE * vxs_shadow_depth_map_layers(map); n++) {
            uint32_t layer = n / (SIDE * SIDE);
            double scale = side / SIDE, u = (n % SIDE + 0.5) * scale - 0.5 * side, v = (n / SIDE % SIDE + 0.5) * scale - 0.5 * side;
            double x = is_sun ? u : u * l->texel_metres * disc, y = is_sun ? v : v * l->texel_metres * disc;
            double from = sqrt(x * x + y * y), rim = is_sun ? scale : 0.03;
            int    faces = layer == (light == SCENE_POINT ? 4 : 0), hit = faces && from < radius;
            if (faces && fabs(from - radius) < rim) continue; /* either way: pixels of the depth map are not texels */
            double wanted = hit && disc < (double)alone[n] ? disc : (double)alone[n];
            if (fabs((double)joined[n] - wanted) > 1e-4 * wanted)
                fail_msg("light %d, texel %u: %g, not %g", light, n, (double)joined[n], wanted);
            nearer += hit && disc < (double)alone[n];
            kept += hit && disc >= (double)alone[n];
        }
        assert_true(nearer > 100);
        if (light == SCENE_SUN) assert_true(kept > 0);
        /* and what does not move any more is as it was */
        assert_int_equal(vxs_shadow_depth_map_join(map, NULL, 0), VXS_OK);
        float *again = read_map(&s, map);
        assert_memory_equal(again, alone, sizeof *again * SIDE * SIDE * vxs_shadow_depth_map_layers(map));
        free(again);
        free(joined);
        free(alone);
        vxs_shadow_depth_map_destroy(map);
    }
    scene_close(&s);
}

/* Airlight of a shadow depth map by exact traversal of its texels, adaptively, in double, of every so many pixels; what differs
 * from it, by RMS. */
enum { ASKED_EACH = 2, ASKED_PIXELS = (PIXELS + ASKED_EACH - 1) / ASKED_EACH };

static void traverse(const volumes_scene *s, const volumes_camera *c, int light, const seen *v, const float *first,
                     double wanted[ASKED_PIXELS][3])
{
    vxs_volumes_light l   = scene_light(light);
    shadow_depth_map  map = {&vxs_asset_light(s->asset, (uint32_t)light)->light, JOINED_SIDE, light == SCENE_POINT ? 6 : 1, first};
    reference_light   of  = {.light = scene_air_light(s, &l), .oracle = map_parts, .subject = &map};
    for (int i = 0; i < 3; i++) of.colour[i] = (double)l.colour[i];
    for (uint32_t n = 0; n < ASKED_PIXELS; n++) {
        uint32_t pixel = n * ASKED_EACH;
        eye_ray  ray   = {.end = v->metres[pixel]};
        camera_ray(s, c, pixel % WIDE, pixel / WIDE, ray.direction);
        memcpy(ray.eye, c->eye, sizeof ray.eye);
        reference_airlight(&haze, VXS_AIR_EVERYWHERE, &of, &ray, wanted[n]);
    }
}

static double rms_from(const double found[ASKED_PIXELS][3], const double wanted[ASKED_PIXELS][3])
{
    double wrong = 0, size = 0;
    for (int n = 0; n < ASKED_PIXELS; n++)
        for (int i = 0; i < 3; i++) {
            wrong += (found[n][i] - wanted[n][i]) * (found[n][i] - wanted[n][i]);
            size += wanted[n][i] * wanted[n][i];
        }
    return sqrt(wrong / size);
}

/* All techniques that read a shadow depth map know what moves: their airlight is that of the map as it was joined, which is not
 * that of what stands. */
static void test_joined_airlight(void **state)
{
    (void)state;
    static const char *const names[]     = {"march", "mesh", "grid", "adaptive mesh"};
    static const double      tolerance[] = {2e-3, 1.2e-2, 4e-3, 1.2e-2};
    static seen              v;
    volumes_scene            s;
    vxs_shadow_grid         *grid;
    vxs_adaptive_mesh       *mesh;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    GLuint                 depths = moving_depths(&s);
    vxs_shadow_grid_desc   desc   = {.columns = 256, .rows = 512, .bits = 256};
    vxs_adaptive_mesh_desc room   = {.side_px = JOINED_SIDE, .layers = 6};
    assert_int_equal(vxs_shadow_grid_create(&grid, s.volumes, &desc), VXS_OK);
    assert_int_equal(vxs_adaptive_mesh_create(&mesh, s.volumes, &room), VXS_OK);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        double                wanted[ASKED_PIXELS][3], standing[ASKED_PIXELS][3], found[ASKED_PIXELS][3];
        float                 pixels[4 * PIXELS];
        volumes_camera        c      = camera_at(eyes[light == SCENE_POINT], looks[light == SCENE_POINT], 0.8);
        vxs_volumes_light     l      = scene_light(light);
        vxs_shadow_depth_map *map    = filled_map(&s, light, JOINED_SIDE, 1);
        moving_disc           moving = disc_before(&s, light, depths);
        v.frame                      = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, v.metres);
        for (int joined = 0; joined < 2; joined++) {
            assert_int_equal(vxs_shadow_depth_map_join(map, &moving.casters, (uint32_t)joined), VXS_OK);
            float *first = read_map(&s, map);
            traverse(&s, &c, light, &v, first, joined ? wanted : standing);
            free(first);
        }
        for (int n = 0; n < 4; n++) {
            assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
            vxs_result result = n == 0   ? vxs_volumes_march(s.volumes, &l, map, 512, VXS_STEPS_EQUIANGULAR)
                                : n == 1 ? vxs_volumes_mesh_map(s.volumes, &l, map)
                                : n == 2 ? vxs_volumes_grid(s.volumes, &l, map, grid, 64)
                                         : vxs_volumes_mesh_adaptive(s.volumes, &l, map, mesh, 1);
            assert_int_equal(result, VXS_OK);
            scene_read(&s, pixels);
            for (size_t k = 0; k < ASKED_PIXELS; k++)
                for (size_t i = 0; i < 3; i++) found[k][i] = (double)pixels[4 * ASKED_EACH * k + i];
            double error = rms_from(found, wanted), without = rms_from(found, standing);
            if (getenv("VXS_VERBOSE")) print_message("light %d, %s: %.5f, of what stands %.5f\n", light, names[n], error, without);
            if (!(error < tolerance[n] && without > 4 * error)) fail_msg("light %d, %s: %g, %g", light, names[n], error, without);
        }
        vxs_shadow_depth_map_destroy(map);
    }
    vxs_shadow_grid_destroy(grid);
    vxs_adaptive_mesh_destroy(mesh);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* A picture behind fog: its colour times what is left, and airlight; its alpha as it was. */
static void test_composite(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    float         air[4 * PIXELS], picture[4 * PIXELS];
    GLuint        texture, frame;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    s.gl->TextureStorage2D(texture, 1, GL_RGBA32F, WIDE, HIGH);
    s.gl->GenFramebuffers(1, &frame);
    s.gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    s.gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0);
    for (int camera = 0; camera < CAMERAS; camera++) {
        double            top = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE;
        vxs_volumes_light l   = scene_light(SCENE_SUN);
        volumes_camera    c   = camera_at(eyes[camera], looks[camera], 0.8);
        see(&s, camera, SCENE_SUN, top, &v);
        v.frame.ambient[0] = 0.3F;
        s.gl->ClearBufferfv(GL_COLOR, 0, (float[4]){0.5F, 2, 7, 0.25F});
        assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
        assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 64, VXS_STEPS_EQUIANGULAR), VXS_OK);
        vxs_volumes_composite(s.volumes);
        scene_read(&s, air);
        s.gl->ReadPixels(0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, picture);
        for (size_t n = 0; n < PIXELS; n++) {
            double direction[3], in_fog[2] = {0, v.metres[n]};
            camera_ray(&s, &c, (uint32_t)n % WIDE, (uint32_t)n / WIDE, direction);
            if (top < VXS_AIR_EVERYWHERE) vxs_air_in_fog(c.eye[1], direction[1], top, in_fog);
            for (int i = 0; i < 3; i++) {
                double left = exp(-haze.extinction[i] * fmax(0, in_fog[1] - in_fog[0])), behind = (double[]){0.5, 2, 7}[i];
                double turned = i == 0 ? 0.3 * haze.scattering[0] / haze.extinction[0] * (1 - left) : 0;
                assert_float_equal(picture[4 * n + (size_t)i], behind * left + turned + (double)air[4 * n + (size_t)i], 1e-4);
            }
            assert_float_equal(picture[4 * n + 3], 0.25F, 0);
        }
    }
    scene_close(&s);
}

/* All that is queried of a context and may have changed. */
static const GLenum asked_numbers[] = {GL_CURRENT_PROGRAM,
                                       GL_ACTIVE_TEXTURE,
                                       GL_VERTEX_ARRAY_BINDING,
                                       GL_DRAW_FRAMEBUFFER_BINDING,
                                       GL_BLEND,
                                       GL_DEPTH_TEST,
                                       GL_STENCIL_TEST,
                                       GL_SCISSOR_TEST,
                                       GL_CULL_FACE,
                                       GL_DEPTH_CLAMP,
                                       GL_RASTERIZER_DISCARD,
                                       GL_UNIFORM_BUFFER_BINDING,
                                       GL_BLEND_SRC_RGB,
                                       GL_BLEND_DST_RGB,
                                       GL_BLEND_SRC_ALPHA,
                                       GL_BLEND_DST_ALPHA,
                                       GL_BLEND_EQUATION_RGB,
                                       GL_BLEND_EQUATION_ALPHA,
                                       GL_COPY_READ_BUFFER_BINDING,
                                       GL_DRAW_INDIRECT_BUFFER_BINDING,
                                       GL_FRONT_FACE,
                                       GL_CLIP_ORIGIN,
                                       GL_CLIP_DEPTH_MODE,
                                       GL_PRIMITIVE_RESTART};
enum {
    ASKED_NUMBERS  = sizeof asked_numbers / sizeof *asked_numbers,
    UNITS_ASKED    = 12,
    STORAGES       = 2, /* from the sixth on, of a technique */
    UNIFORM_BLOCKS = 3,
    STATE          = ASKED_NUMBERS + 4 * UNITS_ASKED + 4 + 4 + 4 + 2 + 6 + 3 * UNIFORM_BLOCKS + 3 * STORAGES
};

static void read_state(const volumes_scene *s, GLint state[STATE])
{
    PFNGLGETINTEGERVPROC   get     = (PFNGLGETINTEGERVPROC)gl_choice_function("glGetIntegerv");
    PFNGLGETINTEGERI_VPROC get_i   = (PFNGLGETINTEGERI_VPROC)gl_choice_function("glGetIntegeri_v");
    PFNGLACTIVETEXTUREPROC active  = (PFNGLACTIVETEXTUREPROC)gl_choice_function("glActiveTexture");
    GLint                 *to      = state, unit;
    const GLenum           image[] = {GL_IMAGE_BINDING_NAME,  GL_IMAGE_BINDING_LEVEL,  GL_IMAGE_BINDING_LAYERED,
                                      GL_IMAGE_BINDING_LAYER, GL_IMAGE_BINDING_ACCESS, GL_IMAGE_BINDING_FORMAT};
    memset(state, 0, STATE * sizeof *state);
    for (int n = 0; n < ASKED_NUMBERS; n++) get(asked_numbers[n], to++);
    get(GL_ACTIVE_TEXTURE, &unit);
    for (GLenum n = 0; n < UNITS_ASKED; n++) {
        active(GL_TEXTURE0 + n);
        get(GL_TEXTURE_BINDING_2D, to++);
        get(GL_TEXTURE_BINDING_2D_ARRAY, to++);
        get(GL_TEXTURE_BINDING_BUFFER, to++);
        get(GL_SAMPLER_BINDING, to++);
    }
    active((GLenum)unit);
    get(GL_VIEWPORT, to);
    get(GL_COLOR_WRITEMASK, to + 4);
    get(GL_POLYGON_MODE, to + 8);
    get(GL_SCISSOR_BOX, to + 10);
    to += 14;
    for (int n = 0; n < 6; n++) get_i(image[n], 0, to++);
    for (GLuint n = 0; n < UNIFORM_BLOCKS; n++) {
        get_i(GL_UNIFORM_BUFFER_BINDING, n, to++);
        get_i(GL_UNIFORM_BUFFER_START, n, to++);
        get_i(GL_UNIFORM_BUFFER_SIZE, n, to++);
    }
    for (GLuint n = 0; n < STORAGES; n++) {
        get_i(GL_SHADER_STORAGE_BUFFER_BINDING, 6 + n, to++);
        get_i(GL_SHADER_STORAGE_BUFFER_START, 6 + n, to++);
        get_i(GL_SHADER_STORAGE_BUFFER_SIZE, 6 + n, to++);
    }
    assert_int_equal(s->gl->GetError(), GL_NO_ERROR);
}

/* A context in which nothing is as it was made. */
static void disturb(const volumes_scene *s)
{
    gl_context *gl = s->gl;
    GLuint      textures[3], samplers, buffer, array, frame, colour, program = gl->CreateProgram(),
                                                                shader = gl->CreateShader(GL_COMPUTE_SHADER);
    gl->ShaderSource(shader, 1, (const char *[]){"#version 430\nlayout(local_size_x = 1) in;\nvoid main() {}"}, NULL);
    gl->CompileShader(shader);
    gl->AttachShader(program, shader);
    gl->LinkProgram(program);
    gl->UseProgram(program);
    gl->CreateTextures(GL_TEXTURE_2D, 1, textures);
    gl->TextureStorage2D(textures[0], 1, GL_RGBA8, 4, 4);
    gl->CreateTextures(GL_TEXTURE_2D_ARRAY, 1, textures + 1);
    ((PFNGLTEXTURESTORAGE3DPROC)gl_choice_function("glTextureStorage3D"))(textures[1], 2, GL_RGBA8, 4, 4, 3);
    gl->CreateTextures(GL_TEXTURE_BUFFER, 1, textures + 2);
    gl->CreateTextures(GL_TEXTURE_2D, 1, &colour);
    gl->TextureStorage2D(colour, 1, GL_RGBA8, 64, 64);
    ((PFNGLGENSAMPLERSPROC)gl_choice_function("glGenSamplers"))(1, &samplers);
    for (GLuint n = 0; n < UNITS_ASKED; n++) {
        ((PFNGLACTIVETEXTUREPROC)gl_choice_function("glActiveTexture"))(GL_TEXTURE0 + n);
        ((void(APIENTRY *)(GLenum, GLuint))gl_choice_function("glBindTexture"))(GL_TEXTURE_2D, textures[0]);
        ((void(APIENTRY *)(GLenum, GLuint))gl_choice_function("glBindTexture"))(GL_TEXTURE_2D_ARRAY, textures[1]);
        ((void(APIENTRY *)(GLenum, GLuint))gl_choice_function("glBindTexture"))(GL_TEXTURE_BUFFER, textures[2]);
        ((PFNGLBINDSAMPLERPROC)gl_choice_function("glBindSampler"))(n, samplers);
    }
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_UNIFORM_BUFFER, buffer);
    gl->BufferData(GL_UNIFORM_BUFFER, 1024, NULL, GL_STATIC_DRAW);
    PFNGLBINDBUFFERRANGEPROC bind = (PFNGLBINDBUFFERRANGEPROC)gl_choice_function("glBindBufferRange");
    for (GLuint n = 0; n < UNIFORM_BLOCKS; n++) bind(GL_UNIFORM_BUFFER, n, buffer, 256, 512);
    for (GLuint n = 0; n < STORAGES; n++) bind(GL_SHADER_STORAGE_BUFFER, 6 + n, buffer, 256, 512);
    gl->BindBuffer(GL_DRAW_INDIRECT_BUFFER, buffer);
    ((PFNGLBINDIMAGETEXTUREPROC)gl_choice_function("glBindImageTexture"))(0, textures[1], 1, GL_FALSE, 2, GL_READ_ONLY, GL_RGBA8);
    gl->GenVertexArrays(1, &array);
    gl->BindVertexArray(array);
    gl->GenFramebuffers(1, &frame);
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, colour, 0);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_STENCIL_TEST);
    gl->Enable(GL_SCISSOR_TEST);
    gl->Enable(GL_CULL_FACE);
    gl->Enable(GL_RASTERIZER_DISCARD);
    gl->Enable(GL_PRIMITIVE_RESTART);
    gl->FrontFace(GL_CW);
    gl->ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    gl->Scissor(1, 2, 3, 4);
    gl->Viewport(5, 6, 7, 8);
    gl->BlendFunc(GL_DST_COLOR, GL_ONE_MINUS_SRC_ALPHA);
    gl->BlendEquation(GL_FUNC_SUBTRACT);
    ((PFNGLCOLORMASKPROC)gl_choice_function("glColorMask"))(1, 0, 1, 0);
    ((PFNGLPOLYGONMODEPROC)gl_choice_function("glPolygonMode"))(GL_FRONT_AND_BACK, GL_LINE);
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

static void test_state(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    GLint         before[STATE], after[STATE];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    see(&s, 0, SCENE_SPOT, 2.5, &v);
    vxs_volumes_light     l       = scene_light(SCENE_SPOT);
    vxs_moving_casters    casters = {s.depths, WIDE, HIGH, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1}, 0};
    vxs_shadow_depth_map *map     = filled_map(&s, SCENE_SPOT, 64, 1);
    disturb(&s);
    read_state(&s, before);
    for (int n = 0; n < STATE; n++) after[n] = -1;
    vxs_shadow_depth_map_refill(map);
    vxs_shadow_depth_map_fill(map, UINT64_MAX);
    vxs_shadow_depth_map_join(map, &casters, 1);
    vxs_volumes_begin(s.volumes, &v.frame);
    vxs_volumes_march(s.volumes, &l, map, 4, VXS_STEPS_EVEN);
    vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EQUIANGULAR);
    assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_OK);
    vxs_volumes_mesh_map(s.volumes, &l, map);
    assert_int_equal(vxs_volumes_end_half(s.volumes), VXS_OK);
    vxs_light_mesh *mesh;
    assert_int_equal(vxs_light_mesh_create(&mesh, s.volumes, (const float[9]){0, 0, 1, 1, 0, 1, 0, 1, 1},
                                           (const uint32_t[3]){0, 1, 2}, &(vxs_light_mesh_size){3, 1}),
                     VXS_OK);
    vxs_volumes_mesh(s.volumes, &l, mesh);
    vxs_light_mesh_destroy(mesh);
    vxs_adaptive_mesh *adaptive;
    assert_int_equal(vxs_adaptive_mesh_create(&adaptive, s.volumes, &(vxs_adaptive_mesh_desc){.side_px = 64, .layers = 1}), VXS_OK);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &l, map, adaptive, 1), VXS_OK);
    vxs_adaptive_mesh_destroy(adaptive);
    scene_smoke_map(&s, SCENE_SPOT);
    vxs_volumes_composite(s.volumes);
    read_state(&s, after);
    for (int n = 0; n < STATE; n++)
        if (before[n] != after[n]) fail_msg("state %d was %d and is %d", n, before[n], after[n]);
    vxs_shadow_depth_map_destroy(map);
    scene_close(&s);
}

/* Cameras, lights and media at random, extremes among them: nothing that is drawn is no number, or negative. */
static void test_any_numbers(void **state)
{
    (void)state;
    volumes_scene s;
    static double metres[PIXELS];
    float         pixels[4 * PIXELS], most = 0;
    rng           r = {11};
    scene_open(&s, 64, WIDE, HIGH);
    vxs_shadow_depth_map *maps[SCENE_LIGHTS];
    for (int light = 0; light < SCENE_LIGHTS; light++) maps[light] = filled_map(&s, light, 64, 0);
    for (uint32_t n = 0; n < repeats(60, 2000); n++) {
        int               light = (int)rng_below(&r, SCENE_LIGHTS);
        double            eye[3], to[3], g = rng_below(&r, 4) ? uniform(&r, -0.9, 0.9) : 0.99 * (int)(rng_below(&r, 3)) - 0.99;
        vxs_medium        medium = {.anisotropy = g};
        vxs_volumes_light l      = scene_light(light);
        for (int i = 0; i < 3; i++) {
            medium.extinction[i] = exp(uniform(&r, log(1e-8), log(1e4)));
            medium.scattering[i] = medium.extinction[i] * uniform(&r, 0, 1);
            eye[i]               = uniform(&r, -12, 12);
            to[i]                = uniform(&r, -5, 5);
        }
        const vxs_air_light air = scene_air_light(&s, &l);
        if (!rng_below(&r, 4))
            memcpy(eye, air.place, sizeof eye); /* the eye at the light, or the light in the middle of the view */
        if (!rng_below(&r, 4)) memcpy(to, air.place, sizeof to);
        for (int i = 0; i < 3; i++) to[i] += eye[i] == to[i] || i == 0 ? 1e-3 : 0;
        l.radius_metres     = (float)exp(uniform(&r, log(1e-6), log(10)));
        volumes_camera    c = camera_at(eye, to, exp(uniform(&r, log(1e-3), log(5))));
        vxs_volumes_frame f = scene_frame(&s, &c, &medium, rng_below(&r, 2) ? VXS_AIR_EVERYWHERE : uniform(&r, -1, 8),
                                          exp(uniform(&r, log(1e-3), log(1e7))), metres);
        for (int way = 0; way < 4; way++) {
            assert_int_equal(vxs_volumes_begin(s.volumes, &f), VXS_OK);
            if (n % 2) assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_OK);
            assert_int_equal(
                vxs_volumes_march(s.volumes, &l, way & 1 ? maps[light] : NULL, 1 + rng_below(&r, 40), (vxs_steps)(way / 2)),
                VXS_OK);
            if (n % 2) assert_int_equal(vxs_volumes_end_half(s.volumes), VXS_OK);
            scene_read(&s, pixels);
            for (int i = 0; i < 4 * PIXELS; i++) {
                if (!(pixels[i] >= 0 && pixels[i] < 1e30F)) fail_msg("case %u, way %d: %g", n, way, (double)pixels[i]);
                if (pixels[i] > most) most = pixels[i];
            }
        }
    }
    for (int light = 0; light < SCENE_LIGHTS; light++) vxs_shadow_depth_map_destroy(maps[light]);
    assert_true(most > 1);
    scene_close(&s);
}

/* What is left out has no more airlight than was said, whatever the camera, the light, the medium and what is in shadow; and much
 * is left out. */
static void test_reach(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    uint64_t      left_out = 0, dark = 0;
    uint32_t      counts[4] = {0};
    rng           r         = {17};
    scene_open(&s, 64, WIDE, HIGH);
    for (uint32_t n = 0; n < repeats(330, 3000); n++) {
        int               light = (int)rng_below(&r, SCENE_LIGHTS);
        double            top   = rng_below(&r, 3) ? VXS_AIR_EVERYWHERE : uniform(&r, -10, 20);
        double            eye[3], to[3], dense = exp(uniform(&r, log(1e-4), log(top < VXS_AIR_EVERYWHERE ? 1 : 0.1)));
        vxs_medium        medium = {{dense, 0.5 * dense, 0}, {dense, dense, dense}, rng_below(&r, 3) ? 0 : uniform(&r, -0.9, 0.9)};
        vxs_volumes_light l      = scene_light(light);
        const vxs_light_constants *baked = &vxs_gl_constants(s.shadows)[light];
        vxs_light_constants        moved = *baked;
        for (int i = 0; i < 3; i++) {
            eye[i] = uniform(&r, -30, 30);
            to[i]  = uniform(&r, -30, 30);
        }
        vxs_air_light air = scene_air_light(&s, &l);
        for (int i = 0; i < 3 && !rng_below(&r, 3); i++) eye[i] = air.place[i] + uniform(&r, -3, 3);
        /* a light without shadows, of any range and cone: what stands in its light can only take of it */
        if (light != SCENE_SUN) moved.range_metres = rng_below(&r, 2) ? (float)uniform(&r, 1, 20) : 0;
        if (light == SCENE_SPOT) moved.cos_outer = (float)cos(uniform(&r, 0.05, 1.5));
        l.constants             = &moved;
        volumes_camera        c = camera_at(eye, to, exp(uniform(&r, log(0.05), log(3))));
        vxs_volumes_frame     f = scene_frame(&s, &c, &medium, top, 100, NULL);
        vxs_shadow_depth_map *map;
        vxs_pixels            drawn;
        assert_int_equal(
            vxs_shadow_depth_map_create(&map, s.volumes, &(vxs_shadow_depth_map_desc){.constants = &moved, .side_px = 8}), VXS_OK);
        float least    = rng_below(&r, 3) ? (float)exp(uniform(&r, log(1e-5), log(1))) : 0;
        f.min_radiance = least;
        assert_int_equal(vxs_volumes_begin(s.volumes, &f), VXS_OK);
        assert_int_equal(vxs_volumes_march(s.volumes, &l, map, 64, VXS_STEPS_EQUIANGULAR), VXS_OK);
        scene_read(&s, pixels);
        vxs_cull_result reach = vxs_volumes_cull(s.volumes, &l, &drawn);
        counts[reach]++;
        air.cos_outer    = (double)moved.cos_outer;
        air.cos_inner    = fmax((double)l.cos_inner, air.cos_outer);
        air.range_metres = (double)moved.range_metres;
        for (uint32_t p = 0; p < PIXELS; p++) {
            double direction[3], in_fog[2], lit[3], most = 0;
            int    inside = reach == VXS_NOT_CULLED && p % WIDE - drawn.x < drawn.wide_px && p / WIDE - drawn.y < drawn.high_px;
            camera_ray(&s, &c, p % WIDE, p / WIDE, direction);
            vxs_air_path path = vxs_air_path_of(&air, c.eye, direction, 100, top, in_fog);
            vxs_air_lit(&medium, &path, 0, 100, lit);
            for (int i = 0; i < 3; i++) most = fmax(most, lit[i] * (double)l.colour[i]);
            if (!inside && most > 1.001 * (double)least + 1e-7)
                fail_msg("case %u, pixel %u: %g is left out, least %g", n, p, most, (double)least);
            if (!inside) assert_memory_equal(pixels + 4 * p, ((float[4]){0}), 4 * sizeof *pixels);
            left_out += !inside;
            dark += most <= (double)least;
        }
        vxs_shadow_depth_map_destroy(map);
    }
    assert_true(counts[VXS_NOT_CULLED] > 60 && counts[VXS_CULLED_FAINT] > 3 && counts[VXS_CULLED_OFFSCREEN] > 10 &&
                counts[VXS_CULLED_CLEAR] > 3);
    assert_true(left_out > dark / 2);
    scene_close(&s);
}

static vxs_gl_function without(const char *name, void *user)
{
    return strcmp(name, user) ? gl_choice_proc(name, NULL) : NULL;
}

/* Links that were made, and whether they fail; uploads to buffers. */
static struct {
    uint32_t count, uploads;
    int      fails;
} links;

static void APIENTRY upload_counted(GLuint buffer, GLintptr start, GLsizeiptr size, const void *data)
{
    links.uploads++;
    ((PFNGLNAMEDBUFFERSUBDATAPROC)gl_choice_function("glNamedBufferSubData"))(buffer, start, size, data);
}

static void APIENTRY link_counted(GLuint program)
{
    links.count++;
    ((PFNGLLINKPROGRAMPROC)gl_choice_function("glLinkProgram"))(program);
}

static void APIENTRY link_status(GLuint program, GLenum name, GLint *value)
{
    ((PFNGLGETPROGRAMIVPROC)gl_choice_function("glGetProgramiv"))(program, name, value);
    if (name == GL_LINK_STATUS && links.fails) *value = 0;
}

static vxs_gl_function with_links(const char *name, void *user)
{
    if (!strcmp(name, "glLinkProgram")) return (vxs_gl_function)link_counted;
    if (!strcmp(name, "glGetProgramiv")) return (vxs_gl_function)link_status;
    if (!strcmp(name, "glNamedBufferSubData")) return (vxs_gl_function)upload_counted;
    return gl_choice_proc(name, user);
}

/* A pass uploads the frame's uniform block, and those that differ from those of the pass before. */
static void test_uploads(void **state)
{
    (void)state;
    static const struct {
        int      light;
        uint32_t steps, uploads;
    } passes[] = {{SCENE_SPOT, 4, 3}, {SCENE_SPOT, 4, 1}, {SCENE_SUN, 4, 2},
                  {SCENE_SUN, 8, 2},  {SCENE_SPOT, 4, 2}, {SCENE_SPOT, 4, 1}};
    enum { PASSES = sizeof passes / sizeof *passes };
    static seen   v;
    static float  pixels[PASSES][4 * PIXELS];
    volumes_scene s;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_volumes_destroy(s.volumes);
    const vxs_volumes_desc desc = {.get_proc_address = with_links, .shadows = s.shadows, .width_px = WIDE, .height_px = HIGH};
    assert_int_equal(vxs_volumes_create(&s.volumes, &desc), VXS_OK);
    see(&s, 0, SCENE_SPOT, 2.5, &v);
    for (int n = 0; n < PASSES; n++) {
        vxs_volumes_light l = scene_light(passes[n].light);
        links.uploads       = 0;
        assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
        assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, passes[n].steps, VXS_STEPS_EVEN), VXS_OK);
        assert_int_equal(links.uploads, passes[n].uploads);
        scene_read(&s, pixels[n]);
    }
    for (int n = 1; n < PASSES; n++) {
        int is_spot = passes[n].light == SCENE_SPOT;
        assert_true(is_spot == !memcmp(pixels[n], pixels[0], sizeof *pixels));
    }
    assert_memory_not_equal(pixels[2], pixels[3], sizeof *pixels);
    scene_close(&s);
}

/* Programs are made when a call first uses them, once; a call whose program cannot be made reports it, and the next one, too. */
static void test_programs_at_first_use(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_volumes_destroy(s.volumes);
    const vxs_volumes_desc desc = {.get_proc_address = with_links, .shadows = s.shadows, .width_px = WIDE, .height_px = HIGH};
    assert_int_equal(vxs_volumes_create(&s.volumes, &desc), VXS_OK);
    see(&s, 0, SCENE_SPOT, 2.5, &v);
    vxs_volumes_light l = scene_light(SCENE_SPOT);
    assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
    assert_int_equal(links.count, 0);
    for (int n = 0; n < 2; n++) {
        assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_OK);
        assert_int_equal(links.count, 1);
    }
    links.fails = 1;
    for (int n = 0; n < 2; n++) {
        assert_int_equal(vxs_volumes_intervals(s.volumes, &l), VXS_E_GL);
        assert_int_equal(links.count, 2);
    }
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_OK);
    links.fails = 0;
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* A warming frame links the programs of the next frame. It draws nothing. */
static void test_warming(void **state)
{
    (void)state;
    volumes_scene         s;
    static seen           v;
    static float          pixels[2][4 * WIDE * HIGH], none[4 * WIDE * HIGH];
    vxs_shadow_depth_map *map;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_volumes_destroy(s.volumes);
    const vxs_volumes_desc desc = {.get_proc_address = with_links, .shadows = s.shadows, .width_px = WIDE, .height_px = HIGH};
    see(&s, 0, SCENE_SPOT, 2.5, &v);
    vxs_volumes_light               l    = scene_light(SCENE_SPOT);
    const vxs_shadow_depth_map_desc side = {.baked_number = l.baked_number, .side_px = 64};
    for (int warms = 0; warms < 2; warms++) {
        assert_int_equal(vxs_volumes_create(&s.volumes, &desc), VXS_OK);
        assert_int_equal(vxs_shadow_depth_map_create(&map, s.volumes, &side), VXS_OK);
        links.count = 0;
        for (int frame = !warms; frame < 2; frame++) {
            v.frame.struct_size = sizeof v.frame;
            v.frame.is_warming  = !frame;
            assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
            while (vxs_shadow_depth_map_fill(map, 1000)) continue; /* which ends in a warming frame, too */
            assert_int_equal(vxs_volumes_march(s.volumes, &l, map, 4, VXS_STEPS_EVEN), VXS_OK);
            assert_int_equal(vxs_volumes_intervals(s.volumes, &l), VXS_OK);
            assert_int_equal(vxs_volumes_mesh_map(s.volumes, &l, map), VXS_OK);
            scene_read(&s, pixels[warms]);
            if (!frame) assert_memory_equal(pixels[1], none, sizeof none);
            assert_int_equal(links.count, 5); /* the mesh has two */
        }
        vxs_shadow_depth_map_destroy(map);
        if (!warms) vxs_volumes_destroy(s.volumes);
    }
    assert_memory_equal(pixels[0], pixels[1], sizeof *pixels);
    assert_memory_not_equal(pixels[0], none, sizeof none);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

static void test_misuse(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    vxs_volumes  *none = (vxs_volumes *)&v;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    const vxs_volumes_desc good = {
        .get_proc_address = gl_choice_proc, .shadows = s.shadows, .width_px = WIDE, .height_px = HIGH, .log = scene_log};
#define REFUSED(result, change)                                                                                                    \
    do {                                                                                                                           \
        vxs_volumes_desc desc = good;                                                                                              \
        change;                                                                                                                    \
        assert_int_equal(vxs_volumes_create(&none, &desc), result);                                                                \
        assert_null(none);                                                                                                         \
        none = (vxs_volumes *)&v;                                                                                                  \
    } while (0)
    REFUSED(VXS_E_ARGUMENT, desc.get_proc_address = NULL);
    REFUSED(VXS_E_ARGUMENT, desc.shadows = NULL);
    REFUSED(VXS_E_ARGUMENT, desc.width_px = 0);
    REFUSED(VXS_E_ARGUMENT, desc.struct_size = 3);
    REFUSED(VXS_E_GL, desc.height_px = 1 << 30);
    assert_said("larger than a texture");
    REFUSED(VXS_E_GL, (desc.get_proc_address = without, desc.user = "glDispatchCompute"));
    assert_said("no function glDispatchCompute");
    REFUSED(VXS_E_GL, (desc.get_proc_address = without, desc.user = "glClearTexImage"));
    assert_said("no function glClearTexImage");
#undef REFUSED

    vxs_volumes_light l = scene_light(SCENE_SPOT);
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT); /* no frame */
    see(&s, 0, SCENE_SPOT, 2.5, &v);
    const struct {
        float *number, bad;
    } changes[] = {{&v.frame.scattering[1], -1},
                   {&v.frame.scattering[1], 1},
                   {&v.frame.extinction[2], INFINITY},
                   {&v.frame.extinction[2], NAN},
                   {&v.frame.anisotropy, 1},
                   {&v.frame.top_metres, NAN},
                   {&v.frame.far_metres, INFINITY},
                   {&v.frame.far_metres, 0},
                   {&v.frame.eye[0], NAN},
                   {&v.frame.view.point_from_depth[3], NAN}};
    for (size_t n = 0; n < sizeof changes / sizeof *changes; n++) {
        float was          = *changes[n].number;
        *changes[n].number = changes[n].bad;
        assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_E_ARGUMENT);
        *changes[n].number = was;
        assert_said(n < 6 ? "0 <= scattering <= extinction" : "far_metres > 0");
    }
    v.frame.view.width_px++;
    assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_E_ARGUMENT);
    v.frame.view.width_px--;
    assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 0, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 65537, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    l.baked_number = vxs_baked_number(SCENE_LIGHTS);
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    l.baked_number = 0; /* a field that was forgotten is not the first light */
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    l               = scene_light(SCENE_SPOT);
    l.radius_metres = 0;
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    l           = scene_light(SCENE_SUN);
    l.colour[0] = NAN;
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT);

    vxs_shadow_depth_map *map = (vxs_shadow_depth_map *)&v;
    assert_int_equal(vxs_shadow_depth_map_create(&map, s.volumes, &(vxs_shadow_depth_map_desc){.baked_number = 1, .side_px = 100}),
                     VXS_E_ARGUMENT);
    assert_null(map);
    assert_int_equal(vxs_shadow_depth_map_create(&map, s.volumes, &(vxs_shadow_depth_map_desc){.side_px = 64}), VXS_E_ARGUMENT);
    assert_int_equal(
        vxs_shadow_depth_map_create(&map, s.volumes, &(vxs_shadow_depth_map_desc){.baked_number = vxs_baked_number(SCENE_LIGHTS)}),
        VXS_E_ARGUMENT);
    map = filled_map(&s, SCENE_SUN, 1U << 31, 0); /* no more than is baked */
    assert_int_equal(vxs_shadow_depth_map_side_px(map), RESOLUTION);
    assert_int_equal(vxs_shadow_depth_map_join(map, NULL, 0), VXS_E_ARGUMENT); /* nothing was said to move */
    assert_said("moves 1");
    l           = scene_light(SCENE_SUN);
    l.constants = vxs_gl_constants(s.shadows);
    assert_int_equal(vxs_volumes_march(s.volumes, &l, NULL, 4, VXS_STEPS_EVEN), VXS_E_ARGUMENT);
    assert_said("pass its shadow depth map");
    vxs_shadow_depth_map_destroy(map);
    vxs_shadow_depth_map_destroy(NULL);
    vxs_volumes_destroy(NULL);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

static vxs_result make_map(const volumes_scene *s, const vxs_shadow_depth_map_desc *desc)
{
    vxs_shadow_depth_map *map;
    vxs_result            result = vxs_shadow_depth_map_create(&map, s->volumes, desc);
    vxs_shadow_depth_map_destroy(map);
    return result;
}

static vxs_result make_grid(const volumes_scene *s, const vxs_shadow_grid_desc *desc)
{
    vxs_shadow_grid *grid;
    vxs_result       result = vxs_shadow_grid_create(&grid, s->volumes, desc);
    vxs_shadow_grid_destroy(grid);
    return result;
}

static vxs_result make_mesh(const volumes_scene *s, const vxs_adaptive_mesh_desc *desc)
{
    vxs_adaptive_mesh *mesh;
    vxs_result         result = vxs_adaptive_mesh_create(&mesh, s->volumes, desc);
    vxs_adaptive_mesh_destroy(mesh);
    return result;
}

/* Structs of programs that were built with older and newer headers. */
static void test_struct_sizes(void **state)
{
    (void)state;
    volumes_scene s;
    static seen   v;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    see(&s, 0, SCENE_SPOT, 2.5, &v);
    const vxs_shadow_depth_map_desc map  = {.baked_number = 1, .side_px = 8};
    const vxs_shadow_grid_desc      grid = {.columns = 8, .rows = 8, .bits = 8};
    const vxs_adaptive_mesh_desc    mesh = {.side_px = 8, .layers = 1};
    const vxs_volumes_light         spot = scene_light(SCENE_SPOT);
    HOLD_SIZES(vxs_shadow_depth_map_desc, moves, map, make_map(&s, given));
    HOLD_SIZES(vxs_shadow_grid_desc, between_rows, grid, make_grid(&s, given));
    HOLD_SIZES(vxs_adaptive_mesh_desc, triangles_most, mesh, make_mesh(&s, given));
    HOLD_SIZES(vxs_volumes_frame, depth_texture, v.frame, vxs_volumes_begin(s.volumes, given));
    assert_int_equal(vxs_volumes_begin(s.volumes, &v.frame), VXS_OK);
    HOLD_SIZES(vxs_volumes_light, min_radiance, spot, vxs_volumes_march(s.volumes, given, NULL, 4, VXS_STEPS_EVEN));
    HOLD_SIZES(vxs_volumes_light, min_radiance, spot, vxs_volumes_intervals(s.volumes, given));
    vxs_volumes_light wrong = spot;
    vxs_pixels        pixels;
    wrong.struct_size = 3;
    assert_true(vxs_volumes_most(s.volumes, &spot) > 0 && vxs_volumes_most(s.volumes, &wrong) == 0);
    assert_int_equal(vxs_volumes_cull(s.volumes, &wrong, &pixels), VXS_CULLED_OFFSCREEN);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shadow_depth_maps),
        cmocka_unit_test(test_struct_sizes),
        cmocka_unit_test(test_marches),
        cmocka_unit_test(test_marches_in_dense_fog),
        cmocka_unit_test(test_many_steps),
        cmocka_unit_test(test_intervals_in_pieces),
        cmocka_unit_test(test_joined),
        cmocka_unit_test(test_joined_airlight),
        cmocka_unit_test(test_composite),
        cmocka_unit_test(test_state),
        cmocka_unit_test(test_any_numbers),
        cmocka_unit_test(test_reach),
        cmocka_unit_test(test_misuse),
        cmocka_unit_test(test_programs_at_first_use),
        cmocka_unit_test(test_warming),
        cmocka_unit_test(test_uploads),
    };
    return cmocka_run_group_tests_name("volumes", tests, NULL, NULL);
}
