/* Fog at half the width and height, beside the same fog at the whole: where depths are flat, at edges, in a scene, in views of any
 * size, and with depths of any bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <stdlib.h>

#include "random_light.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/volumes/map_parts.h"
#include "volumes_scene.h"

enum { RESOLUTION = 256, WIDE = 64, HIGH = 48, PIXELS = WIDE * HIGH, FLOATS = 4 * PIXELS };

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* A camera on the scene, and the depths of its pixels, which tests change. */
typedef struct picture {
    vxs_volumes_frame frame;
    uint32_t          wide, high;
    float             depths[PIXELS];
} picture;

/* A view of the given size, of which each ray ends at a distance along the camera's axis. */
static void look(const volumes_scene *s, picture *p, uint32_t wide, uint32_t high, double metres)
{
    static const double  eye[3] = {9, 3, 1}, to[3] = {0, 2, 0};
    const volumes_camera camera = camera_at(eye, to, 0.8);
    p->frame                    = scene_frame(s, &camera, &haze, VXS_AIR_EVERYWHERE, 60, NULL);
    p->frame.struct_size        = sizeof p->frame;
    p->wide = p->frame.view.width_px = wide;
    p->high = p->frame.view.height_px = high;
    for (uint32_t n = 0; n < wide * high; n++) p->depths[n] = (float)(NEAR_METRES / metres);
}

typedef enum technique { MARCH, INTERVALS, MESH, GRID, TECHNIQUES } technique;

/* A light of the scene, by its map; without shadow where it has other constants than those of the asset. */
typedef struct fog {
    vxs_volumes_light     light;
    technique             by;
    vxs_shadow_depth_map *map;
    vxs_shadow_grid      *grid;
} fog;

/* A light without shadow. */
static fog open_clear(const volumes_scene *s, int light)
{
    fog f                 = {.light = scene_light(light)};
    f.light.radius_metres = 3; /* no peak of light about the light itself, which lies between rays */
    f.light.constants     = &vxs_gl_constants(s->shadows)[light];
    assert_int_equal(
        vxs_shadow_depth_map_create(&f.map, s->volumes, &(vxs_shadow_depth_map_desc){.constants = f.light.constants, .side_px = 8}),
        VXS_OK);
    while (vxs_shadow_depth_map_fill(f.map, 1000)) continue;
    return f;
}

static vxs_result draw(const volumes_scene *s, const fog *f)
{
    switch (f->by) {
    case INTERVALS: return vxs_volumes_intervals(s->volumes, &f->light);
    case MESH: return vxs_volumes_mesh_map(s->volumes, &f->light, f->map);
    case GRID: return vxs_volumes_grid(s->volumes, &f->light, f->map, f->grid, 0);
    default: return vxs_volumes_march(s->volumes, &f->light, f->map, 64, VXS_STEPS_EQUIANGULAR);
    }
}

/* The airlight of a picture.   pixels  [out] [4 * wide * high] */
static void show(const volumes_scene *s, const picture *p, const fog *f, int is_half, float *pixels)
{
    static float all[FLOATS];
    s->gl->TextureSubImage2D(s->depths, 0, 0, 0, (GLsizei)p->wide, (GLsizei)p->high, GL_RED, GL_FLOAT, p->depths);
    assert_int_equal(vxs_volumes_begin(s->volumes, &p->frame), VXS_OK);
    if (is_half) assert_int_equal(vxs_volumes_begin_half(s->volumes), VXS_OK);
    assert_int_equal(draw(s, f), VXS_OK);
    if (is_half) assert_int_equal(vxs_volumes_end_half(s->volumes), VXS_OK);
    scene_read(s, all);
    for (uint32_t y = 0; y < p->high; y++)
        memcpy(pixels + (size_t)4 * y * p->wide, all + (size_t)4 * y * s->width_px, 4 * sizeof *all * p->wide);
}

/* The airlight of a picture by a quarter of its pixels, the first of each 2 x 2, and plain bilinear filtering, for even sizes. */
static void show_plainly(const volumes_scene *s, const picture *p, const fog *f, float *pixels)
{
    static picture some;
    static float   quarter[FLOATS];
    const uint32_t wide = p->wide / 2, high = p->high / 2;
    look(s, &some, wide, high, 1);
    for (uint32_t n = 0; n < wide * high; n++) some.depths[n] = p->depths[2 * (n / wide) * p->wide + 2 * (n % wide)];
    show(s, &some, f, 0, quarter);
    for (uint32_t n = 0; n < p->wide * p->high; n++)
        for (uint32_t i = 0; i < 4; i++) {
            double x = fmin(fmax((n % p->wide) * 0.5 - 0.25, 0), wide - 1), y = fmin(fmax((n / p->wide) * 0.5 - 0.25, 0), high - 1);
            uint32_t left = (uint32_t)x, low = (uint32_t)y, right = left + 1 < wide ? left + 1 : left,
                     up = low + 1 < high ? low + 1 : low;
#define AT(column, row) (double)quarter[4 * ((row)*wide + (column)) + i]
            double below = AT(left, low) + (x - left) * (AT(right, low) - AT(left, low));
            double above = AT(left, up) + (x - left) * (AT(right, up) - AT(left, up));
#undef AT
            pixels[4 * n + i] = (float)(below + (y - low) * (above - below));
        }
}

/* Relative RMS of some pixels, and their largest error relative to the largest of them.
 * metres  pixels that end nearer than this along the axis; INFINITY: all */
typedef struct errors {
    double   rms, most;
    uint32_t pixels;
} errors;

static errors errors_of(const picture *p, const float *found, const float *wanted, double metres)
{
    errors e     = {0};
    double wrong = 0, size = 0, largest = 0;
    for (uint32_t n = 0; n < p->wide * p->high; n++) {
        if (NEAR_METRES / (double)p->depths[n] > metres) continue;
        e.pixels++;
        for (uint32_t i = 0; i < 3; i++) {
            double w = (double)wanted[4 * n + i], more = (double)found[4 * n + i] - w;
            assert_true(isfinite(more) && found[4 * n + i] >= 0);
            wrong += more * more;
            size += w * w;
            largest = fmax(largest, w);
            e.most  = fmax(e.most, fabs(more));
        }
    }
    e.rms = sqrt(wrong / size);
    e.most /= largest;
    if (getenv("VXS_VERBOSE")) print_message("%u pixels: error %.2g, at most %.2g\n", e.pixels, e.rms, e.most);
    return e;
}

/* What values there are in the 5 x 5 pixels about one: the width of their range. */
static double range_about(const picture *p, const float *pixels, uint32_t at, uint32_t channel)
{
    double low = INFINITY, high = -INFINITY;
    int    x = (int)(at % p->wide), y = (int)(at / p->wide);
    for (int v = y - 2; v <= y + 2; v++)
        for (int u = x - 2; u <= x + 2; u++) {
            if (u < 0 || v < 0 || u >= (int)p->wide || v >= (int)p->high) continue;
            double value = (double)pixels[4 * ((uint32_t)v * p->wide + (uint32_t)u) + channel];
            low          = fmin(low, value);
            high         = fmax(high, value);
        }
    return high - low;
}

/* Where depths are flat and light has no shadow, a pixel is off by no more than its neighbours differ, and by much less where light is
 * even; in views of any size. */
static void test_flat(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{WIDE, HIGH}, {WIDE - 1, HIGH - 1}, {31, 48}, {1, 1}, {1, HIGH}, {2, 2}, {WIDE, 1}, {3, 2}};
    static float          half[FLOATS], whole[FLOATS];
    static picture        p;
    volumes_scene         s;
    scene_open(&s, 64, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        fog f = open_clear(&s, light);
        for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++)
            for (int is_empty = 0; is_empty < 2; is_empty++) {
                look(&s, &p, sizes[n][0], sizes[n][1], is_empty ? INFINITY : 12);
                show(&s, &p, &f, 1, half);
                show(&s, &p, &f, 0, whole);
                errors e = errors_of(&p, half, whole, INFINITY);
                if (p.wide == 1 && p.high == 1) assert_true(e.most < 1e-6);
                if (p.wide < 30 || p.high < 30) continue; /* such pixels are wide */
                if (light == SCENE_SUN) assert_true(e.rms < 6e-3 && e.most < 0.02);
                for (uint32_t at = 0; at < p.wide * p.high; at++)
                    for (uint32_t i = 0; i < 3; i++) {
                        double off   = fabs((double)half[4 * at + i] - (double)whole[4 * at + i]),
                               range = range_about(&p, whole, at, i);
                        if (off > range + 1e-5) fail_msg("light %d, pixel %u: off by %g, range %g", light, at, off, range);
                    }
            }
        vxs_shadow_depth_map_destroy(f.map);
    }
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    scene_close(&s);
}

/* Put something near before the fog: a ragged hill, a tower of two pixels, wires of one, and points. */
static void put_near(picture *p, double metres)
{
    for (uint32_t n = 0; n < p->wide * p->high; n++) {
        uint32_t x = n % p->wide, y = n / p->wide;
        int      is_hill = y < 12 + x * 7 % 5, is_tower = x == 20 || x == 21, is_wire = y == 30 || x == 41,
            is_point = !(x % 7) && !(y % 5);
        if (is_hill || is_tower || is_wire || is_point) p->depths[n] = (float)(NEAR_METRES / metres);
    }
}

/* Light of far fog does not cross the edges of near things, nor their shade the fog. */
static void test_edges(void **state)
{
    (void)state;
    static float   half[FLOATS], whole[FLOATS], plain[FLOATS];
    static picture p;
    volumes_scene  s;
    scene_open(&s, 64, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light += SCENE_POINT) {
        fog f = open_clear(&s, light);
        for (int is_wall = 0; is_wall < 2; is_wall++) {
            look(&s, &p, WIDE, HIGH, is_wall ? 30 : INFINITY);
            put_near(&p, 1);
            show(&s, &p, &f, 1, half);
            show(&s, &p, &f, 0, whole);
            show_plainly(&s, &p, &f, plain);
            errors e = errors_of(&p, half, whole, INFINITY), near = errors_of(&p, half, whole, 2);
            errors other = errors_of(&p, plain, whole, INFINITY), near_other = errors_of(&p, plain, whole, 2);
            assert_true(e.rms < 0.03 && 10 * e.rms < other.rms);
            assert_true(near.rms < 0.1 && 20 * near.rms < near_other.rms);
        }
        vxs_shadow_depth_map_destroy(f.map);
    }
    scene_close(&s);
}

/* Boxes and their shadows, by each technique, in fog everywhere and below a top. */
static void test_scene(void **state)
{
    (void)state;
    static const double eyes[2][3] = {{9, 3, 1}, {-4, 6, 9}}, looks[2][3] = {{0, 2, 0}, {0, 1, 0}};
    static float        half[FLOATS], whole[FLOATS];
    static double       metres[PIXELS];
    static picture      p;
    volumes_scene       s;
    vxs_shadow_grid    *grid;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    assert_int_equal(vxs_shadow_grid_create(&grid, s.volumes, &(vxs_shadow_grid_desc){.columns = 128, .rows = 256, .bits = 128}),
                     VXS_OK);
    for (int n = 0; n < 4; n++) {
        const int            light = n < 2 ? SCENE_SUN : SCENE_SPOT;
        const volumes_camera c     = camera_at(eyes[n % 2], looks[n % 2], 0.5);
        fog                  f     = {.light = scene_light(light), .grid = grid};
        f.light.radius_metres      = 1;
        assert_int_equal(vxs_shadow_depth_map_create(
                             &f.map, s.volumes, &(vxs_shadow_depth_map_desc){.baked_number = f.light.baked_number, .side_px = 64}),
                         VXS_OK);
        while (vxs_shadow_depth_map_fill(f.map, 100000)) continue;
        look(&s, &p, WIDE, HIGH, 1);
        p.frame             = scene_frame(&s, &c, &haze, n % 2 ? 2.5 : VXS_AIR_EVERYWHERE, 30, metres);
        p.frame.struct_size = sizeof p.frame;
        s.gl->GetTextureImage(s.depths, 0, GL_RED, GL_FLOAT, sizeof p.depths, p.depths);
        for (f.by = MARCH; f.by < TECHNIQUES; f.by++) {
            show(&s, &p, &f, 1, half);
            show(&s, &p, &f, 0, whole);
            assert_true(errors_of(&p, half, whole, INFINITY).rms < 0.1);
        }
        vxs_shadow_depth_map_destroy(f.map);
    }
    vxs_shadow_grid_destroy(grid);
    scene_close(&s);
}

/* Depths of any bits give numbers. */
static void test_any_depths(void **state)
{
    (void)state;
    static const float odd[] = {NAN, INFINITY, -INFINITY, EMPTY_DEPTH, 1, -1, 1e-30F, 1e8F, 1e30F, 0.01F};
    static float       half[FLOATS];
    static picture     p;
    volumes_scene      s;
    rng                r = {5};
    scene_open(&s, 64, WIDE, HIGH);
    fog f = open_clear(&s, SCENE_SUN);
    for (uint32_t n = 0; n < 20; n++) {
        look(&s, &p, 1 + rng_below(&r, WIDE), 1 + rng_below(&r, HIGH), 10);
        for (int i = 0; i < 3; i++) p.frame.extinction[i] = n % 3 ? haze.extinction[i] : n % 2 ? 0 : 1e20F;
        if (n % 4) p.frame.far_metres = 1e12F;
        for (int i = 0; i < 3; i++) p.frame.scattering[i] = n % 3 ? 0.01F : 0;
        for (uint32_t at = 0; at < p.wide * p.high; at++)
            if (rng_below(&r, 2)) p.depths[at] = odd[rng_below(&r, sizeof odd / sizeof *odd)];
        show(&s, &p, &f, 1, half);
        for (uint32_t at = 0; at < 4 * p.wide * p.high; at++)
            if (!(half[at] >= 0 && half[at] < 1e30F))
                fail_msg("view %u, value %u: %g, depth %g", n, at, (double)half[at], (double)p.depths[at / 4]);
    }
    vxs_shadow_depth_map_destroy(f.map);
    scene_close(&s);
}

/* What may be called when; a picture is composed with it by vxs_volumes_composite alone. */
static void test_calls(void **state)
{
    (void)state;
    static float   half[FLOATS], again[FLOATS];
    static picture p;
    volumes_scene  s;
    vxs_volumes   *none;
    GLuint         texture, frame;
    scene_open(&s, 64, WIDE, HIGH);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    s.gl->TextureStorage2D(texture, 1, GL_RGBA32F, WIDE, HIGH);
    s.gl->GenFramebuffers(1, &frame);
    s.gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    s.gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0);
    fog f = open_clear(&s, SCENE_SUN);
    assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_E_ARGUMENT); /* no frame */
    look(&s, &p, WIDE, HIGH, 12);
    show(&s, &p, &f, 1, half);
    assert_int_equal(vxs_volumes_end_half(s.volumes), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_begin(s.volumes, &p.frame), VXS_OK);
    assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_OK);
    assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_E_ARGUMENT);
    assert_int_equal(draw(&s, &f), VXS_OK);
    vxs_volumes_composite(s.volumes);
    scene_read(&s, again);
    assert_memory_equal(again, half, sizeof half);
    assert_int_equal(vxs_volumes_end_half(s.volumes), VXS_E_ARGUMENT);

    /* lights before, between and after */
    assert_int_equal(vxs_volumes_begin(s.volumes, &p.frame), VXS_OK);
    assert_int_equal(draw(&s, &f), VXS_OK);
    scene_read(&s, again);
    for (int n = 0; n < FLOATS; n++) half[n] = 2 * half[n] + 2 * again[n];
    for (int n = 0; n < 2; n++) {
        assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_OK);
        assert_int_equal(draw(&s, &f), VXS_OK);
        assert_int_equal(vxs_volumes_end_half(s.volumes), VXS_OK);
    }
    assert_int_equal(draw(&s, &f), VXS_OK);
    scene_read(&s, again);
    for (int n = 0; n < FLOATS; n++) assert_float_equal(again[n], half[n], 1e-5F * half[n]);

    assert_int_equal(vxs_volumes_begin_half(s.volumes), VXS_OK);
    assert_int_equal(vxs_volumes_begin(s.volumes, &p.frame), VXS_OK); /* a frame ends it, and loses its light */
    scene_read(&s, again);
    for (int n = 0; n < FLOATS; n++) assert_float_equal(again[n], 0, 0);
    const vxs_volumes_desc desc = {.get_proc_address = gl_choice_proc, .shadows = s.shadows, .width_px = WIDE, .height_px = HIGH};
    assert_int_equal(vxs_volumes_create(&none, &desc), VXS_OK);
    assert_int_equal(vxs_volumes_begin(none, &p.frame), VXS_OK);
    assert_int_equal(vxs_volumes_begin_half(none), VXS_E_ARGUMENT); /* has_half is 0 */
    vxs_volumes_destroy(none);
    vxs_shadow_depth_map_destroy(f.map);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat),       cmocka_unit_test(test_edges), cmocka_unit_test(test_scene),
        cmocka_unit_test(test_any_depths), cmocka_unit_test(test_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
