/* Sampling of alpha masks: by hand, and against a texture laid out over the plane.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "baker/base/random.h"
#include "baker/scene/scene.h"

#include <cmocka.h> /* last: it makes a macro of fail */

/* Four wide, two high. */
static uint8_t           pixels[] = {0, 100, 200, 255, 40, 80, 120, 160};
static const alpha_image image    = {.width_px = 4, .height_px = 2, .alpha = pixels};

static double alpha(texture_wrap wrap, int nearest, double x_px, double y_px)
{
    const alpha_mask mask = {.threshold = 0.5f, .wrap_u = wrap, .wrap_v = wrap, .nearest = nearest};
    return alpha_mask_alpha(&mask, &image, x_px / 4, y_px / 2);
}

static void centres_are_their_own_pixels(void **state)
{
    (void)state;
    for (int nearest = 0; nearest < 2; nearest++)
        for (int j = 0; j < 2; j++)
            for (int i = 0; i < 4; i++) assert_true(alpha(WRAP_CLAMP, nearest, i + 0.5, j + 0.5) == pixels[4 * j + i]);
}

static void between_centres_it_is_bilinear_or_the_pixel(void **state)
{
    (void)state;
    assert_true(alpha(WRAP_REPEAT, 0, 1, 0.5) == 50);
    assert_true(alpha(WRAP_REPEAT, 0, 1.75, 0.5) == 125);
    assert_true(alpha(WRAP_REPEAT, 0, 2, 1) == (100 + 200 + 80 + 120) / 4.0);
    assert_true(alpha(WRAP_REPEAT, 0, 1.75, 0.75) == 0.75 * 125 + 0.25 * 90);
    assert_true(alpha(WRAP_REPEAT, 1, 1.99, 0.99) == 100);
    assert_true(alpha(WRAP_REPEAT, 1, 2, 1) == 120);
}

static void beyond_the_image_it_wraps(void **state)
{
    (void)state;
    static const uint8_t row[3][10] = {
        {100, 200, 255, 0, 100, 200, 255, 0, 100, 200}, /* repeat, pixels -3 to 6 */
        {0, 0, 0, 0, 100, 200, 255, 255, 255, 255},     /* clamp */
        {200, 100, 0, 0, 100, 200, 255, 255, 200, 100}, /* mirror */
    };
    for (int wrap = 0; wrap < 3; wrap++)
        for (int i = 0; i < 10; i++) {
            double far = wrap == WRAP_CLAMP ? 0 : 8e6; /* whole periods of both modes */
            assert_true(alpha((texture_wrap)wrap, 1, i - 2.5, 0.5) == row[wrap][i]);
            assert_true(alpha((texture_wrap)wrap, 0, i - 2.5, 0.5) == row[wrap][i]);
            assert_true(alpha((texture_wrap)wrap, 0, i - 2.5 + far, 0.5) == row[wrap][i]);
            assert_true(alpha((texture_wrap)wrap, 1, i - 2.5 - far, 0.5) == row[wrap][i]);
        }
    assert_true(alpha(WRAP_REPEAT, 0, 0, 0.5) == 127.5); /* half of the last, half of the first */
    assert_true(alpha(WRAP_CLAMP, 0, 0, 0.5) == 0);
    assert_true(alpha(WRAP_MIRROR, 0, 4, 0.5) == 255);
    assert_true(alpha(WRAP_CLAMP, 0, 1e300, -1e300) == 255);
    assert_true(alpha(WRAP_REPEAT, 0, 1.5, -0.5) == 80); /* rows wrap too */
    assert_true(alpha(WRAP_CLAMP, 0, 1.5, 17) == 80);
}

static void axes_wrap_each_by_its_own_mode(void **state)
{
    (void)state;
    const alpha_mask mask = {.threshold = 0.5f, .wrap_u = WRAP_CLAMP, .wrap_v = WRAP_MIRROR, .nearest = 1};
    assert_true(alpha_mask_alpha(&mask, &image, 1.125, 1.25) == 160);
    assert_true(alpha_mask_alpha(&mask, &image, 1.125, 1.75) == 255);
}

/* Equal pixels stay what they are, wherever they are sampled: a threshold of exactly their alpha is met. */
static void even_images_have_no_holes(void **state)
{
    (void)state;
    rng r = {3};
    for (int value = 1; value < 256; value++) {
        uint8_t           even[15];
        const alpha_image flat = {.width_px = 5, .height_px = 3, .alpha = even};
        for (int i = 0; i < 15; i++) even[i] = (uint8_t)value;
        const alpha_mask met = {.threshold = (float)(value / 255.0)}, above = {.threshold = nextafterf(met.threshold, 2)};
        for (int n = 0; n < 50; n++) {
            double u = rng_u32(&r) / 3e9, v = rng_u32(&r) / 3e9;
            assert_true(alpha_mask_alpha(&met, &flat, u, v) == value);
            assert_int_equal(alpha_mask_opaque(&met, &flat, u, v), 1);
            assert_int_equal(alpha_mask_opaque(&above, &flat, u, v), 0);
        }
    }
}

static void thresholds_include_themselves(void **state)
{
    (void)state;
    alpha_mask mask = {.threshold = (float)(100 / 255.0), .nearest = 1};
    assert_int_equal(alpha_mask_opaque(&mask, &image, 1.5 / 4, 0.25), 1);
    mask.threshold = nextafterf(mask.threshold, 1);
    assert_int_equal(alpha_mask_opaque(&mask, &image, 1.5 / 4, 0.25), 0);
    mask.threshold = 1;
    assert_int_equal(alpha_mask_opaque(&mask, &image, 3.5 / 4, 0.25), 1);
    assert_int_equal(alpha_mask_opaque(&mask, &image, 2.5 / 4, 0.25), 0);
}

static void nonsense_stays_in_the_image(void **state)
{
    (void)state;
    static const double odd[]  = {NAN, INFINITY, -INFINITY, 1e308, -1e308, 0x1p53 + 2, -0.0, 0x1p-1074, 1 - 0x1p-53};
    uint8_t             one[1] = {77};
    const alpha_image   tiny   = {.width_px = 1, .height_px = 1, .alpha = one};
    for (int wrap = 0; wrap < 3; wrap++)
        for (int nearest = 0; nearest < 2; nearest++) {
            const alpha_mask mask = {
                .threshold = 0.5f, .wrap_u = (texture_wrap)wrap, .wrap_v = (texture_wrap)wrap, .nearest = nearest};
            for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
                for (size_t j = 0; j < sizeof odd / sizeof *odd; j++) {
                    double found = alpha_mask_alpha(&mask, &image, odd[i], odd[j]);
                    assert_true(found >= 0 && found <= 255);
                    assert_true(alpha_mask_alpha(&mask, &tiny, odd[i], odd[j]) == 77);
                }
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(centres_are_their_own_pixels), cmocka_unit_test(between_centres_it_is_bilinear_or_the_pixel),
        cmocka_unit_test(beyond_the_image_it_wraps),    cmocka_unit_test(axes_wrap_each_by_its_own_mode),
        cmocka_unit_test(even_images_have_no_holes),    cmocka_unit_test(thresholds_include_themselves),
        cmocka_unit_test(nonsense_stays_in_the_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
