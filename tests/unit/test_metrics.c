/* Metrics of pictures of airlight (tests/volumes/metrics.h): known changes of a picture have known errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "tests/volumes/metrics.h"

#include <cmocka.h>

enum { WIDE = 100, PIXELS = 100 * WIDE, VALUES = 3 * PIXELS };

static double wanted[3 * VALUES], found[3 * VALUES];

/* Brighter from left to right, by `slope` a pixel, from `first` on. */
static void ramp(double *picture, double first, double slope)
{
    for (int n = 0; n < VALUES; n++) picture[n] = first + slope * (n / 3 % WIDE);
}

static void test_same(void **state)
{
    (void)state;
    ramp(wanted, 1, 1);
    picture_error e = picture_error_of(wanted, wanted, PIXELS, NULL, PIXEL_CLASSES);
    assert_int_equal(e.count, VALUES);
    assert_true(e.relative_rms == 0 && e.signed_mean == 0 && e.percentile_99 == 0 && e.most == 0);
}

/* A ramp of 1 to 100, a pixel to the right: each value is less by 1. */
static void test_shift(void **state)
{
    (void)state;
    ramp(wanted, 1, 1);
    ramp(found, 0, 1);
    picture_error e = picture_error_of(found, wanted, PIXELS, NULL, PIXEL_CLASSES);
    assert_float_equal(e.relative_rms, 1 / sqrt(100.0 * 101 * 201 / 6 / 100), 1e-12);
    assert_float_equal(e.signed_mean, -0.01, 1e-12);
    assert_float_equal(e.percentile_99, 0.01, 1e-12);
    assert_float_equal(e.most, 0.01, 1e-12);
}

/* The same where the reference has only every third pixel. */
static void test_left_out(void **state)
{
    (void)state;
    ramp(wanted, 1, 1);
    ramp(found, 0, 1);
    for (int n = 0; n < VALUES; n++)
        if (n / 3 % 3) wanted[n] = NAN;
    picture_error e = picture_error_of(found, wanted, PIXELS, NULL, PIXEL_CLASSES);
    assert_int_equal(e.count, 3 * ((PIXELS + 2) / 3));
    assert_float_equal(e.signed_mean, -0.01, 1e-12);
    assert_float_equal(e.most, 0.01, 1e-12);
}

/* Errors of 0, 1, ... 99 hundredths of 100, in turn up and down. */
static void test_percentile(void **state)
{
    (void)state;
    for (int n = 0; n < VALUES; n++) {
        int pixel = n / 3;
        wanted[n] = 100;
        found[n]  = 100 + (pixel / 100 % 2 ? 1 : -1) * (pixel % 100);
    }
    picture_error e = picture_error_of(found, wanted, PIXELS, NULL, PIXEL_CLASSES);
    assert_float_equal(e.percentile_99, 0.98, 0.0101);
    assert_float_equal(e.most, 0.99, 1e-12);
    assert_float_equal(e.signed_mean, 0, 1e-12);
    assert_float_equal(e.relative_rms, sqrt(99.0 * 100 * 199 / 6 / 100) / 100, 1e-12);
}

static void test_classes(void **state)
{
    (void)state;
    static uint8_t classes[PIXELS];
    const double   eye[3] = {1, 2, 3}, punctual[3] = {1, 2, 13}, ahead[3] = {0, 0, 1}, back[3] = {0, 0, -1};
    const double   in[3] = {0.039, 0, sqrt(1 - 0.039 * 0.039)}, out[3] = {0.041, 0, sqrt(1 - 0.041 * 0.041)};
    assert_int_equal(pixel_class_of(eye, ahead, punctual, 0.1), PIXELS_EPIPOLE);
    assert_int_equal(pixel_class_of(eye, back, punctual, 0.1), PIXELS_ELSEWHERE);
    assert_int_equal(pixel_class_of(eye, in, punctual, 0.1), PIXELS_EPIPOLE);
    assert_int_equal(pixel_class_of(eye, out, punctual, 0.1), PIXELS_ELSEWHERE);
    for (int n = 0; n < PIXELS; n++) classes[n] = n < 10 ? PIXELS_EPIPOLE : PIXELS_ELSEWHERE;
    for (int n = 0; n < VALUES; n++) {
        wanted[n] = n < 30 ? 1000 : 1;
        found[n]  = n < 30 ? 1500 : 1.1;
    }
    picture_error near = picture_error_of(found, wanted, PIXELS, classes, PIXELS_EPIPOLE);
    picture_error rest = picture_error_of(found, wanted, PIXELS, classes, PIXELS_ELSEWHERE);
    assert_int_equal(near.count, 30);
    assert_int_equal(rest.count, VALUES - 30);
    assert_float_equal(near.relative_rms, 0.5, 1e-12);
    assert_float_equal(rest.relative_rms, 0.1, 1e-12);
    assert_float_equal(rest.most, 0.1 / 1000, 1e-12); /* of the whole picture's largest */
}

/* An error that stays does not flicker; one of +-1 that turns about from frame to frame changes by 2. */
static void test_flicker(void **state)
{
    (void)state;
    for (int f = 0; f < 3; f++) {
        ramp(wanted + f * VALUES, 5 + 0.25 * f, 0);
        ramp(found + f * VALUES, 6 + 0.25 * f, 0);
    }
    assert_float_equal(picture_flicker_of(found, wanted, 3, PIXELS), 0, 1e-12);
    for (int f = 0; f < 3; f++) ramp(wanted + f * VALUES, 5, 0);
    for (int f = 0; f < 3; f++) ramp(found + f * VALUES, f % 2 ? 4 : 6, 0);
    assert_float_equal(picture_flicker_of(found, wanted, 3, PIXELS), 2.0 / 5, 1e-12);
    assert_true(picture_flicker_of(found, wanted, 1, PIXELS) == 0);
}

static void test_dark(void **state)
{
    (void)state;
    memset(wanted, 0, sizeof wanted);
    memset(found, 0, sizeof found);
    assert_true(picture_error_of(found, wanted, PIXELS, NULL, PIXEL_CLASSES).relative_rms == 0);
    found[7]        = 2;
    picture_error e = picture_error_of(found, wanted, PIXELS, NULL, PIXEL_CLASSES);
    assert_true(isinf(e.relative_rms) && e.most == 2);
    assert_int_equal(picture_error_of(found, wanted, 0, NULL, PIXEL_CLASSES).count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same),       cmocka_unit_test(test_shift),   cmocka_unit_test(test_left_out),
        cmocka_unit_test(test_percentile), cmocka_unit_test(test_classes), cmocka_unit_test(test_flicker),
        cmocka_unit_test(test_dark),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
