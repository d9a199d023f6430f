/* Voxelized shadow volumes of libvxs_volumes on llvmpipe: their scans against a serial one, bit for bit; their words and airlight
 * against those of shadow_grid.h in double; the asset against its map; all of it against exact lit intervals; the context's state,
 * misuse, and no number that is none.
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

#include "grid_read.h"
#include "runtime/volumes/grid/or_scan.h"

enum { RESOLUTION = 256, WIDE = 48, HIGH = 40, PIXELS = WIDE * HIGH };

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* Both scans are the serial one, bit for bit, of any number of texels in a segment, and touch nothing beside them. */
static void test_scans(void **state)
{
    (void)state;
    static const uint32_t lengths[] = {1, 2, 3, 127, 128, 129, 300, 512, 1000, 2048};
    volumes_scene         s;
    rng                   r = {3};
    scene_open(&s, 64, WIDE, HIGH);
    volumes_api *api = &s.volumes->api;
    or_scan      scans[2];
    assert_int_equal(vxs_or_scan_create(&scans[0], s.volumes, 0), VXS_OK);
    assert_int_equal(vxs_or_scan_create(&scans[1], s.volumes, 2 << 20), VXS_OK);
    for (size_t n = 0; n < sizeof lengths / sizeof *lengths; n++)
        for (uint32_t segments = 1; segments < 40; segments += 12)
            for (int passes = 0; passes < 2; passes++) {
                vxs_grid_size size  = {(int)lengths[n], (int)segments, 128};
                uint32_t      words = (uint32_t)vxs_grid_words(&size), first = n & 1 ? 8 : 3, all = words + 4 * first + 8;
                uint32_t     *before = malloc(all * sizeof *before), *after = malloc(all * sizeof *after);
                GLuint        buffer;
                assert_true(before && after);
                for (uint32_t k = 0; k < all; k++) before[k] = rng_below(&r, 16) ? 0 : 1U << rng_below(&r, 32);
                api->CreateBuffers(1, &buffer);
                api->NamedBufferStorage(buffer, (gl_bytes)(all * sizeof *before), before, GL_STORAGE_DYNAMIC);
                vxs_or_scan_run(&scans[passes], buffer, first, lengths[n], segments);
                read_buffer(buffer, 0, all * sizeof *after, after);
                grid_scan(before + (size_t)4 * first, &size);
                assert_memory_equal(after, before, all * sizeof *after);
                api->DeleteBuffers(1, &buffer);
                free(before);
                free(after);
            }
    for (int n = 0; n < 2; n++) vxs_or_scan_destroy(&scans[n]);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* Where shadow begins on each light ray, against the same in double: the next column or the one before only where rounding decides,
 * but for rays between two texels of the map. */
static void check_columns(const shadow_grid *g, const shadow_depth_map *m, uint32_t *dark)
{
    uint32_t elsewhere = 0;
    for (int row = 0; row < g->size.rows; row++)
        for (int bit = 0; bit < g->size.bits; bit++) {
            double across[3], begin[3], direction[3], turned[2], metres, wanted;
            int    found = first_column(g, row, bit);
            vxs_epipolar_turn_of(&g->space, vxs_grid_middle(g->space.phi, bit, g->size.bits), turned);
            vxs_epipolar_across(&g->space, vxs_grid_middle(g->space.theta, row, g->size.rows), across);
            vxs_epipolar_light_ray(&g->space, across, turned, begin, direction);
            metres = ray_shadow(m, g->eye, begin, direction);
            wanted = metres < INFINITY
                         ? vxs_grid_before(g->space.alpha, vxs_epipolar_alpha_at(&g->space, turned, metres), g->size.columns) - 0.5
                         : g->size.columns;
            wanted = fmin(fmax(wanted, 0), g->size.columns);
            elsewhere += !(found > wanted - 1e-2 && found < wanted + 1 + 1e-2);
            *dark += found < g->size.columns;
        }
    assert_true(elsewhere < (uint32_t)(g->size.rows * g->size.bits) / 300);
}

/* Words and airlight, of maps and of the asset, scanned in both ways. */
static void test_words(void **state)
{
    (void)state;
    enum { GRIDS = 2, WAYS = 2 * GRIDS };
    volumes_scene s;
    static double metres[PIXELS], wanted[3 * PIXELS];
    static float  pixels[2][4 * PIXELS]; /* by the row of a ray, and by two */
    uint32_t      dark = 0;
    double        most = 0;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_shadow_grid *grids[GRIDS];
    for (int n = 0; n < GRIDS; n++) grids[n] = make_grid(&s, 150, 90, 300, n);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light     l   = scene_light(light);
        vxs_air_light         air = scene_air_light(&s, &l);
        vxs_shadow_depth_map *map = filled_map(&s, light);
        shadow_depth_map      m   = read_map(&s, map, light);
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            volumes_camera    c     = camera_at(eyes[camera], looks[camera], 0.8);
            double            top   = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE;
            vxs_volumes_frame frame = scene_frame(&s, &c, &haze, top, 30, metres);
            shadow_grid       found[WAYS];
            int               eye_lit;
            for (int n = 0; n < WAYS; n++) {
                assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
                assert_int_equal(vxs_volumes_grid(s.volumes, &l, n < GRIDS ? map : NULL, grids[n % GRIDS], 12), VXS_OK);
                found[n] = read_grid(grids[n % GRIDS], c.eye, &eye_lit);
                assert_int_equal(eye_lit, shadow_depth_map_lit(&m, c.eye));
                assert_memory_equal(found[n].words, found[0].words, (size_t)vxs_grid_words(&found[0].size) * sizeof(uint32_t));
                scene_read(&s, pixels[n % GRIDS]);
            }
            check_columns(&found[0], &m, &dark);
            for (int way = 0; way < GRIDS; way++) {
                const vxs_epipolar  *space = &found[0].space;
                const vxs_grid_size *size  = &found[0].size;
                for (uint32_t n = 0; n < PIXELS; n++) {
                    double direction[3], in_fog[2], *to = wanted + 3 * (size_t)n;
                    camera_ray(&s, &c, n % WIDE, n / WIDE, direction);
                    vxs_air_path     path = vxs_air_path_of(&air, c.eye, direction, metres[n], top, in_fog);
                    vxs_epipolar_ray ray  = vxs_epipolar_eye(space, direction);
                    vxs_grid_rows    rows =
                        way ? vxs_grid_rows_about(space, size, ray.theta) : vxs_grid_row_of(space, size, ray.theta);
                    vxs_grid_airlight_of(found[0].words, space, size, &haze, &path, &ray, &rows, metres[n], 12, eye_lit, to);
                    for (int i = 0; i < 3; i++) to[i] *= (double)l.colour[i];
                }
                double error = error_of(pixels[way], wanted, PIXELS);
                most         = fmax(most, error);
                if (getenv("VXS_VERBOSE")) print_message("light %d, camera %d, way %d: %.1e\n", light, camera, way, error);
            }
            for (int n = 0; n < WAYS; n++) free(found[n].words);
        }
        free(m.first);
        vxs_shadow_depth_map_destroy(map);
    }
    print_message("%u light rays in shadow; airlight of shaders against double: RMS %.1e at most\n", dark, most);
    assert_true(dark > 20000);
    assert_true(most < 1e-3); /* a ray between two rows, or columns, takes either */
    for (int n = 0; n < GRIDS; n++) vxs_shadow_grid_destroy(grids[n]);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* A sun whose map has an end, seen from where the map has none: its light rays are queried all the same. */
static void test_bounded_sun(void **state)
{
    (void)state;
    volumes_scene s;
    static double metres[PIXELS];
    shadow_grid   found[2];
    uint32_t      dark = 0;
    int           eye_lit;
    scene_open(&s, 64, WIDE, HIGH);
    vxs_shadow_grid      *grid      = make_grid(&s, 64, 64, 128, 0);
    vxs_shadow_depth_map *map       = filled_map(&s, SCENE_SUN);
    vxs_volumes_light     l         = scene_light(SCENE_SUN);
    vxs_light_constants   constants = vxs_gl_constants(s.shadows)[SCENE_SUN];
    const double          eye[3] = {-20, 40, -15}, look[3] = {0, 0, 0};
    volumes_camera        c     = camera_at(eye, look, 0.4);
    vxs_volumes_frame     frame = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 90, metres);
    constants.flags |= VXS_LIGHT_BOUNDED;
    for (int n = 0; n < 2; n++) {
        l.constants = n ? &constants : NULL;
        assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid(s.volumes, &l, map, grid, 0), VXS_OK);
        found[n] = read_grid(grid, c.eye, &eye_lit);
    }
    for (int n = 0; n < vxs_grid_words(&found[0].size); n++) dark += found[0].words[n] != 0;
    assert_true(dark > 100);
    assert_memory_equal(found[1].words, found[0].words, (size_t)vxs_grid_words(&found[0].size) * sizeof(uint32_t));
    for (int n = 0; n < 2; n++) free(found[n].words);
    vxs_shadow_depth_map_destroy(map);
    vxs_shadow_grid_destroy(grid);
    scene_close(&s);
}

/* Larger grids, less error, to exact lit intervals of the asset. */
static void test_converges(void **state)
{
    (void)state;
    volumes_scene s;
    static double metres[PIXELS], wanted[3 * PIXELS];
    float         pixels[4 * PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    const uint32_t   sides[2] = {repeats(64, 128), repeats(256, 512)};
    vxs_shadow_grid *grids[2] = {make_grid(&s, sides[0], sides[0], sides[0], 0), make_grid(&s, sides[1], sides[1], sides[1], 0)};
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light l     = scene_light(light);
            volumes_camera    c     = camera_at(eyes[camera], looks[camera], 0.8);
            double            top   = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE, errors[2];
            vxs_volumes_frame frame = scene_frame(&s, &c, &haze, top, 30, metres);
            memset(wanted, 0, sizeof wanted);
            for (uint32_t n = 0; n < PIXELS; n++) {
                double direction[3];
                camera_ray(&s, &c, n % WIDE, n / WIDE, direction);
                scene_airlight(&s, &l, &haze, top, c.eye, direction, metres[n], wanted + 3 * (size_t)n);
            }
            for (int n = 0; n < 2; n++) {
                assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
                assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grids[n], 0), VXS_OK);
                scene_read(&s, pixels);
                errors[n] = error_of(pixels, wanted, PIXELS);
            }
            print_message("light %d, camera %d: RMS %.4f at %u^3, %.4f at %u^3\n", light, camera, errors[0], sides[0], errors[1],
                          sides[1]);
            assert_true(errors[1] < 1e-3 * repeats(10, 5)); /* of half the side: twice */
            assert_true(errors[1] < errors[0] / 2.56 || errors[1] < 1e-3);
        }
    for (int n = 0; n < 2; n++) vxs_shadow_grid_destroy(grids[n]);
    scene_close(&s);
}

/* Storage buffers, which are bound nowhere else in this library, are as they were. */
static void test_state(void **state)
{
    (void)state;
    volumes_scene            s;
    static double            metres[PIXELS];
    PFNGLGETINTEGERI_VPROC   get_i      = (PFNGLGETINTEGERI_VPROC)gl_choice_function("glGetIntegeri_v");
    PFNGLGETINTEGERVPROC     get        = (PFNGLGETINTEGERVPROC)gl_choice_function("glGetIntegerv");
    PFNGLBINDBUFFERRANGEPROC bind_range = (PFNGLBINDBUFFERRANGEPROC)gl_choice_function("glBindBufferRange");
    const GLenum names[] = {GL_SHADER_STORAGE_BUFFER_BINDING, GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE};
    GLint        before[10], after[10];
    GLuint       buffer;
    scene_open(&s, 64, WIDE, HIGH);
    vxs_shadow_grid     *grid;
    vxs_shadow_grid_desc desc = {.columns = 16, .rows = 16, .bits = 128, .scan_in_passes = 1, .casts = 1};
    assert_int_equal(vxs_shadow_grid_create(&grid, s.volumes, &desc), VXS_OK);
    vxs_volumes_light l     = scene_light(SCENE_SPOT);
    volumes_camera    c     = camera_at(eyes[0], looks[0], 0.8);
    vxs_volumes_frame frame = scene_frame(&s, &c, &haze, 2.5, 30, metres);
    s.gl->GenBuffers(1, &buffer);
    s.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    s.gl->BufferData(GL_SHADER_STORAGE_BUFFER, 1024, NULL, GL_STATIC_DRAW);
    bind_range(GL_SHADER_STORAGE_BUFFER, 5, buffer, 256, 512);
    for (GLuint n = 6; n < 8; n++) s.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, n, buffer);
    for (int n = 0; n < 9; n++) get_i(names[n / 3], (GLuint)(5 + n % 3), before + n);
    get(GL_SHADER_STORAGE_BUFFER_BINDING, before + 9);
    assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
    const vxs_casters casters = {.places = buffer, .corners = buffer, .triangle_count = 4};
    assert_int_equal(vxs_volumes_grid_cast(s.volumes, &l, NULL, grid, 0, &casters, 1), VXS_OK);
    scene_smoke_map(&s, SCENE_SUN);
    for (int n = 0; n < 9; n++) get_i(names[n / 3], (GLuint)(5 + n % 3), after + n);
    get(GL_SHADER_STORAGE_BUFFER_BINDING, after + 9);
    for (int n = 0; n < 10; n++)
        if (before[n] != after[n]) fail_msg("state %d was %d and is %d", n, before[n], after[n]);
    assert_int_equal(before[3], 256);
    vxs_shadow_grid_destroy(grid);
    scene_close(&s);
}

static void test_misuse(void **state)
{
    (void)state;
    volumes_scene s;
    static double metres[PIXELS];
    scene_open(&s, 64, WIDE, HIGH);
    vxs_shadow_grid           *grid      = NULL;
    const vxs_shadow_grid_desc bad[]     = {{.columns = 16385}, {.rows = 16385}, {.bits = 16385}, {.columns = UINT32_MAX}};
    const vxs_shadow_grid_desc large     = {.columns = 16384, .rows = 16384, .bits = 16384};
    vxs_volumes_light          l         = scene_light(SCENE_SUN);
    vxs_light_constants        constants = vxs_gl_constants(s.shadows)[0];
    volumes_camera             c         = camera_at(eyes[0], looks[0], 0.8);
    vxs_volumes_frame          frame     = scene_frame(&s, &c, &haze, 1e30, 30, metres);
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
        assert_int_equal(vxs_shadow_grid_create(&grid, s.volumes, &bad[n]), VXS_E_ARGUMENT);
        assert_null(grid);
    }
    assert_int_equal(vxs_shadow_grid_create(&grid, s.volumes, &large), VXS_E_GL);
    assert_said("fewer columns, rows or bits");
    assert_null(grid);
    vxs_shadow_grid_destroy(NULL);
    grid = make_grid(&s, 1, 1, 1, 0);
    assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grid, 0), VXS_E_ARGUMENT); /* no frame */
    assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
    assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grid, 16385), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grid, 0), VXS_OK); /* one voxel is a grid */
    l.constants = &constants;
    assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grid, 0), VXS_E_ARGUMENT); /* no map, and none is baked */
    l.constants    = NULL;
    l.baked_number = vxs_baked_number(SCENE_LIGHTS);
    assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grid, 0), VXS_E_ARGUMENT);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    vxs_shadow_grid_destroy(grid);
    scene_close(&s);
}

/* Cameras, lights and media at random: nothing that is drawn is no number, or negative, or more than all the
 * light without shadow. */
static void test_any_numbers(void **state)
{
    (void)state;
    volumes_scene s;
    static double metres[PIXELS];
    float         pixels[4 * PIXELS];
    rng           r = {11};
    scene_open(&s, 64, WIDE, HIGH);
    vxs_shadow_grid *grids[2] = {make_grid(&s, 33, 20, 130, 0), make_grid(&s, 1, 1, 1, 0)};
    for (uint32_t n = 0; n < repeats(60, 2000); n++) {
        int    light = (int)rng_below(&r, SCENE_LIGHTS);
        double eye[3], to[3], g = rng_below(&r, 4) ? uniform(&r, -0.9, 0.9) : 0.99 * (int)(rng_below(&r, 3)) - 0.99,
                              tangent = exp(uniform(&r, -7, 1.5));
        vxs_medium        medium      = {.anisotropy = g};
        vxs_volumes_light l           = scene_light(light);
        for (int i = 0; i < 3; i++) {
            medium.extinction[i] = exp(uniform(&r, log(1e-8), log(1e4)));
            medium.scattering[i] = medium.extinction[i] * uniform(&r, 0, 1);
            eye[i]               = uniform(&r, -12, 12);
            to[i]                = uniform(&r, -5, 5);
        }
        const vxs_air_light air = scene_air_light(&s, &l);
        if (!rng_below(&r, 3)) memcpy(to, air.place, sizeof to); /* toward a punctual light */
        if (!rng_below(&r, 4))
            for (int i = 0; i < 3; i++) to[i] = 2 * eye[i] - air.place[i]; /* or away from it */
        if (!rng_below(&r, 6))
            for (int i = 0; i < 3; i++) eye[i] = air.place[i] + 1e-3 * uniform(&r, -1, 1); /* or in it */
        if (light == SCENE_SUN && rng_below(&r, 2))
            for (int i = 0; i < 3; i++) to[i] = eye[i] + (n & 1 ? air.place[i] : -air.place[i]);
        l.radius_metres     = (float)exp(uniform(&r, log(1e-4), 0));
        volumes_camera    c = camera_at(eye, to, tangent);
        vxs_volumes_frame frame =
            scene_frame(&s, &c, &medium, rng_below(&r, 3) ? 1e30 : uniform(&r, -1, 5), exp(uniform(&r, -5, 12)), metres);
        assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grids[rng_below(&r, 4) == 0], rng_below(&r, 40)), VXS_OK);
        scene_read(&s, pixels);
        for (size_t k = 0; k < 4 * PIXELS; k++)
            if (!(isfinite(pixels[k]) && pixels[k] >= 0)) fail_msg("repeat %u, number %zu is %g", n, k, (double)pixels[k]);
    }
    for (int n = 0; n < 2; n++) vxs_shadow_grid_destroy(grids[n]);
    scene_close(&s);
}

/* An eye in a punctual light, or nearly, sees the shadows of its light: by the radius of a punctual light that is carried, and of a
 * large one. */
static void test_eye_in_punctual(void **state)
{
    (void)state;
    static const double offsets[][3] = {{0, 0, 0}, {1e-6, 0, 0}, {0.03, -0.05, 0.02}, {0.095, 0, 0}, {0.2, 0, 0.2}},
                        to[3]        = {9, 1.5, 3};
    volumes_scene s;
    static double metres[PIXELS], wanted[3 * PIXELS];
    static float  pixels[4 * PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_shadow_grid *grid = make_grid(&s, 256, 512, 256, 0);
    for (int light = SCENE_SPOT; light < SCENE_LIGHTS; light++)
        for (size_t n = 0; n < sizeof offsets / sizeof *offsets; n++)
            for (int large = 0; large < 2; large++) {
                vxs_volumes_light l = scene_light(light);
                double            eye[3], look[3];
                vxs_air_light     air;
                l.radius_metres = large ? 0.5F : 0.1F;
                air             = scene_air_light(&s, &l);
                for (int i = 0; i < 3; i++) {
                    eye[i]  = air.place[i] + offsets[n][i];
                    look[i] = light == SCENE_SPOT ? eye[i] + air.axis[i] + 0.01 * to[i] : to[i];
                }
                volumes_camera    c     = camera_at(eye, look, 0.8);
                vxs_volumes_frame frame = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 30, metres);
                memset(wanted, 0, sizeof wanted);
                for (uint32_t k = 0; k < PIXELS; k++) {
                    double direction[3];
                    camera_ray(&s, &c, k % WIDE, k / WIDE, direction);
                    scene_airlight(&s, &l, &haze, VXS_AIR_EVERYWHERE, eye, direction, metres[k], wanted + 3 * (size_t)k);
                }
                assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
                assert_int_equal(vxs_volumes_grid(s.volumes, &l, NULL, grid, 0), VXS_OK);
                scene_read(&s, pixels);
                double error = error_of(pixels, wanted, PIXELS);
                if (getenv("VXS_VERBOSE"))
                    print_message("light %d, %g m beside it, radius %g: RMS %.5f\n", light, sqrt(dot(offsets[n], offsets[n])),
                                  (double)l.radius_metres, error);
                assert_true(error < 8e-3);
            }
    vxs_shadow_grid_destroy(grid);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scans),     cmocka_unit_test(test_words),       cmocka_unit_test(test_bounded_sun),
        cmocka_unit_test(test_converges), cmocka_unit_test(test_state),       cmocka_unit_test(test_eye_in_punctual),
        cmocka_unit_test(test_misuse),    cmocka_unit_test(test_any_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
