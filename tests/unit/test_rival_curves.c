/* Rivals of transmittance curves (tests/volumes/rival_curves.h) on llvmpipe: each reaches its own limit, what capsules leave of
 * light in double, as its knob grows, and is off as it is known to be where that is small.
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

#include "tests/volumes/rival_curves.h"
#include "tests/volumes/smoke_view.h"
#include "volumes_scene.h"

enum { WIDE = 64, HIGH = 48, PLACES = WIDE * HIGH, SIDE = 64, CAPSULES = 600 };

/* Smoke, a map of it with lists that are built, and places in it with what reaches them. */
static volumes_scene          s;
static smoke_sun              sun;
static vxs_transmittance_map *map;
static GLuint                 texture;
static double                 wanted[PLACES];

static int open_smoke(void **state)
{
    (void)state;
    static vxs_capsule smoke[CAPSULES];
    static float       depths[PLACES];
    static double      places[PLACES][3];
    scene_open(&s, 64, WIDE, HIGH);
    smoke_make(SMOKE_COLUMNS, smoke, CAPSULES, 3);
    sun                          = smoke_sun_over(smoke, CAPSULES);
    vxs_transmittance_desc desc  = {.constants = &sun.constants, .side_px = SIDE, .capsules = CAPSULES, .segments = 1 << 17};
    vxs_capsules           list  = {.list = smoke, .count = CAPSULES};
    vxs_volumes_frame      frame = smoke_frame(WIDE, HIGH, depths, places);
    assert_int_equal(vxs_transmittance_map_create(&map, s.volumes, &desc), VXS_OK);
    assert_int_equal(vxs_transmittance_map_build(map, &list, NULL), VXS_OK);
    vxs_transmittance_counts lists = vxs_transmittance_map_counts(map);
    print_message("%u segments, %u merged\n", lists.segments, lists.merged);
    assert_true(lists.segments > 3000 && lists.merged == 0);
    smoke_truth(&sun, SIDE, smoke, CAPSULES, (const double(*)[3])places, PLACES, wanted);
    s.gl->TextureSubImage2D(s.depths, 0, 0, 0, WIDE, HIGH, GL_RED, GL_FLOAT, depths);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    s.gl->TextureStorage2D(texture, 1, GL_R32F, WIDE, HIGH);
    frame.depth_texture = s.depths;
    assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
    return 0;
}

static int close_smoke(void **state)
{
    (void)state;
    vxs_transmittance_map_destroy(map);
    scene_close(&s);
    return 0;
}

/* The RMS is of places in shadow. */
typedef struct error {
    double rms, most;
} error;

static error error_now(void)
{
    static float left[PLACES];
    error        e         = {0, 0};
    uint32_t     in_shadow = 0;
    s.gl->GetTextureImage(texture, 0, GL_RED, GL_FLOAT, sizeof left, left);
    for (int n = 0; n < PLACES; n++) {
        double off = fabs((double)left[n] - wanted[n]);
        assert_true(left[n] >= 0 && left[n] <= 1);
        e.most = fmax(e.most, off);
        if (wanted[n] > 0.99) continue;
        e.rms += off * off;
        in_shadow++;
    }
    assert_true(in_shadow > PLACES / 5);
    e.rms = sqrt(e.rms / in_shadow);
    return e;
}

static error error_of(rival_curve which, uint32_t knob, uint64_t *bytes)
{
    rival_curves *r;
    assert_int_equal(rival_curves_create(&r, s.volumes, map, which, knob), VXS_OK);
    rival_curves_build(r, sun.nearest, sun.farthest);
    rival_curves_look_up(r, texture);
    error e = error_now();
    *bytes  = rival_curves_bytes(r);
    rival_curves_destroy(r);
    print_message("knob %u: %.1f bytes a texel, RMS %.5f, %.4f at most\n", knob, (double)*bytes / (SIDE * SIDE), e.rms, e.most);
    return e;
}

/* The limit of all. */
static void test_uncompressed(void **state)
{
    (void)state;
    uint64_t bytes;
    error    e = error_of(RIVAL_UNCOMPRESSED, 0, &bytes);
    assert_true(e.rms < 1e-5 && e.most < 1e-3);
}

/* The library's, for comparison: 64 bytes a texel. */
static void test_adaptive(void **state)
{
    (void)state;
    assert_int_equal(vxs_volumes_transmittance(s.volumes, map, texture, VXS_CURVE_LINES), VXS_OK);
    error e = error_now();
    print_message("8 nodes: RMS %.5f, %.4f at most\n", e.rms, e.most);
    assert_true(e.rms < 0.02);
}

static void test_opacity_slices(void **state)
{
    (void)state;
    uint64_t bytes;
    error    few = error_of(RIVAL_OPACITY, 8, &bytes), many = error_of(RIVAL_OPACITY, 64, &bytes);
    assert_int_equal(bytes, SIDE * SIDE * 64 * 4);
    assert_true(few.rms > 8 * many.rms && many.rms < 5e-3);
}

static void test_fourier_terms(void **state)
{
    (void)state;
    uint64_t bytes;
    error    few = error_of(RIVAL_FOURIER, 4, &bytes), many = error_of(RIVAL_FOURIER, 32, &bytes);
    assert_int_equal(bytes, SIDE * SIDE * 32 * 8);
    assert_true(few.rms > 8 * many.rms && many.rms < 5e-3);
}

static void test_moments(void **state)
{
    (void)state;
    uint64_t bytes;
    error    e = error_of(RIVAL_MOMENTS, 0, &bytes);
    assert_true(e.rms < 0.1 && e.most < 0.6);
}

/* No farther off than the tolerance where the curve bends; between two bends it is a line here, and an exponential in truth. */
static void test_deep_tolerance(void **state)
{
    (void)state;
    for (uint32_t tolerance = 20; tolerance <= 500; tolerance *= 5) {
        uint64_t bytes;
        error    e = error_of(RIVAL_DEEP, tolerance, &bytes);
        assert_true(e.rms < tolerance / 1e4 && e.most < tolerance / 1e4 + 0.02);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_uncompressed),  cmocka_unit_test(test_adaptive), cmocka_unit_test(test_opacity_slices),
        cmocka_unit_test(test_fourier_terms), cmocka_unit_test(test_moments),  cmocka_unit_test(test_deep_tolerance),
    };
    return cmocka_run_group_tests(tests, open_smoke, close_smoke);
}
