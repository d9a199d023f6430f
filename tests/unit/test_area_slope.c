/* How airlight of a picture comes nearer as it has more VPLs, each way to place them: nothing is in the light, so what is off is
 * where VPLs are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "baker/base/spread.h"
#include "random_light.h"
#include "repeats.h"
#include "runtime/volumes/vxs_area_grid.h"
#include "runtime/volumes/vxs_area_light.h"

enum { WIDE = 16, HIGH = 9, RAYS_WIDE = 16, RAYS_HIGH = 9, RAYS = RAYS_WIDE * RAYS_HIGH, SEEDS_MOST = 31, STEPS = 5 };

static float picture[HIGH][WIDE][3];

/* Dim, with a window in 9 of 144 texels that has 40 % of all light; 1.6 x 0.9 metres. */
static vxs_area_rectangle screen(void)
{
    for (int y = 0; y < HIGH; y++)
        for (int x = 0; x < WIDE; x++)
            for (int i = 0; i < 3; i++) picture[y][x][i] = x >= 10 && x < 13 && y >= 5 && y < 8 ? 4 : 0.35F;
    return (vxs_area_rectangle){{-0.8F, -0.45F, 0}, {1.6F, 0, 0}, {0, 0.9F, 0}, {1, 1, 1}, picture[0][0], WIDE, HIGH};
}

/* Where a ray ends: on a wall behind the screen, or before it. */
static void end_of(int ray, double to[3])
{
    to[0] = -5 + 10 * (ray % RAYS_WIDE + 0.5) / RAYS_WIDE;
    to[1] = -2.8 + 5.6 * (ray / RAYS_WIDE + 0.5) / RAYS_HIGH;
    to[2] = fabs(to[0]) < 0.8 && fabs(to[1]) < 0.45 ? 0.01 : -0.3;
}

/* Airlight of VPLs along rays, one channel, added. */
static void add_airlight(const vxs_vpl *vpls, uint32_t count, double *sums)
{
    static const vxs_medium medium = {{0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}, 0};
    static const double     eye[3] = {3, 0.6, 4};
    for (int ray = 0; ray < RAYS; ray++) {
        double direction[3], metres;
        end_of(ray, direction);
        for (int i = 0; i < 3; i++) direction[i] -= eye[i];
        metres = sqrt(dot(direction, direction));
        for (int i = 0; i < 3; i++) direction[i] /= metres;
        for (uint32_t n = 0; n < count; n++) {
            double        lit[3];
            vxs_air_light light = {.kind = VXS_LIGHT_KIND_POINT, .radius_metres = (double)vpls[n].radius_metres};
            for (int i = 0; i < 3; i++) {
                light.place[i] = (double)vpls[n].place[i];
                light.axis[i]  = (double)vpls[n].normal[i];
            }
            vxs_air_path path = vxs_area_path(&light, 1, eye, direction, metres, VXS_AIR_EVERYWHERE);
            vxs_air_lit(&medium, &path, path.begin, path.end, lit);
            sums[ray] += (double)vpls[n].colour[0] * lit[0];
        }
    }
}

/* The median error over seeds, relative RMS over rays: of all, and of those that do not end at the screen. */
static void errors_of(const vxs_area_rectangle *r, int places, uint32_t count, uint32_t seeds, const double *wanted, double *all,
                      double *far)
{
    double  errors[2][SEEDS_MOST];
    vxs_vpl vpls[VXS_VPLS_MAX];
    for (uint32_t seed = 0; seed < seeds; seed++) {
        double found[RAYS] = {0}, wrong[2] = {0}, size[2] = {0}, to[3];
        assert_int_equal(vxs_area_sample(r, (vxs_area_places)places, seed, vpls, count), VXS_OK);
        add_airlight(vpls, count, found);
        for (int n = 0; n < RAYS; n++) {
            end_of(n, to);
            for (int k = 0; k < (to[2] < 0 ? 2 : 1); k++) {
                wrong[k] += (found[n] - wanted[n]) * (found[n] - wanted[n]);
                size[k] += wanted[n] * wanted[n];
            }
        }
        for (int k = 0; k < 2; k++) errors[k][seed] = sqrt(wrong[k] / size[k]);
    }
    for (int k = 0; k < 2; k++) qsort(errors[k], seeds, sizeof **errors, doubles_ascending);
    *all = errors[0][seeds / 2];
    *far = errors[1][seeds / 2];
}

/* The power of the number of VPLs that errors of 1, 4, 16 and 64 VPLs fall with, by least squares. */
static double slope_of(const double *errors)
{
    const int count = 4;
    double    x = 0, y = 0, xx = 0, xy = 0;
    for (int n = 0; n < count; n++) {
        double at = n * log(4), error = log(errors[n]);
        x += at;
        y += error;
        xx += at * at;
        xy += at * error;
    }
    return (count * xy - x * y) / (count * xx - x * x);
}

static void test_slopes(void **state)
{
    (void)state;
    enum { MANY = 8 };
    static const char *const names[] = {"Halton", "importance", "regular", "jittered"};
    vxs_area_rectangle       r       = screen();
    vxs_vpl                  vpls[VXS_VPLS_MAX];
    double                   wanted[RAYS] = {0}, all[STEPS], far[STEPS];
    for (uint32_t seed = 1; seed <= MANY; seed++) {
        assert_int_equal(vxs_area_sample(&r, VXS_AREA_IMPORTANCE, seed, vpls, VXS_VPLS_MAX), VXS_OK);
        for (int n = 0; n < VXS_VPLS_MAX; n++) vpls[n].radius_metres /= (float)sqrt(MANY);
        add_airlight(vpls, VXS_VPLS_MAX, wanted);
    }
    for (int n = 0; n < RAYS; n++) wanted[n] /= MANY;
    for (int places = 0; places <= VXS_AREA_JITTERED; places++) {
        int steps = (int)repeats(STEPS - 1, STEPS);
        for (int n = 0; n < steps; n++) errors_of(&r, places, 1U << (2 * n), repeats(7, SEEDS_MOST), wanted, &all[n], &far[n]);
        double slope = slope_of(all), slope_far = slope_of(far);
        print_message("%s:", names[places]);
        for (int n = 0; n < steps; n++) print_message(" %.3f (%.3f)", all[n], far[n]);
        print_message(" of 1, 4, ... VPLs (rays beside the screen); slope to 64: %.2f (%.2f)\n", slope, slope_far);
        assert_true(slope < -0.5 && slope > -1 && all[3] < 0.045);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_slopes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
