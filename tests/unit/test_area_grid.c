/* runtime/volumes/vxs_area_grid.h: lookups between rows, and places in imperfect shadow maps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "random_light.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/vxs_area_grid.h"

/* Rows on both sides of a place: across the seam where theta is all the way round, and not where it ends. */
static void test_rows(void **state)
{
    (void)state;
    vxs_grid_size size  = {1, 8, 128};
    vxs_epipolar  round = {.theta = {-M_PI, M_PI}}, part = {.theta = {-1, 1}};
    for (int n = 0; n < 800; n++) {
        double        at = (n + 0.25) / 100, of[2] = {-M_PI + 2 * M_PI * at / 8, -1 + 2 * at / 8};
        vxs_grid_rows a = vxs_grid_rows_about(&round, &size, of[0]), b = vxs_grid_rows_about(&part, &size, of[1]);
        int           below = (int)floor(at - 0.5);
        assert_true(fabs(a.part - (at - 0.5 - below)) < 1e-9 && fabs(b.part - a.part) < 1e-9);
        assert_int_equal(a.row, (below + 8) % 8);
        assert_int_equal(a.next, (below + 1) % 8);
        assert_int_equal(b.row, below < 0 ? 0 : below);
        assert_int_equal(b.next, below < 7 ? below + 1 : 7);
    }
}

/* Directions to all of the disc: each in the place that a paraboloid shows it at, a texel as wide as the directions that
 * are in it. */
static void test_texels(void **state)
{
    (void)state;
    rng r = {7};
    for (int n = 0; n < 10000; n++) {
        double way[3], at[2], next[2], moved[3], size = uniform(&r, 0.1, 10);
        random_direction(&r, way);
        way[2] = fabs(way[2]);
        for (int i = 0; i < 3; i++) moved[i] = size * way[i];
        double wide = vxs_area_texel(moved, 64, at), x = at[0] / 32 - 1, y = at[1] / 32 - 1, square = x * x + y * y;
        assert_true(square <= 1 + 1e-12);
        assert_true(fabs(2 * x / (1 + square) - way[0]) < 1e-12 &&
                    fabs(2 * y / (1 + square) - way[1]) < 1e-12); /* back on the sphere */
        assert_true(fabs((1 - square) / (1 + square) - way[2]) < 1e-12);
        random_direction(&r, moved);
        double along = dot(moved, way), step = 1e-6;
        for (int i = 0; i < 3; i++) moved[i] = way[i] + step * (moved[i] - along * way[i]);
        double across = 0;
        for (int i = 0; i < 3; i++) across += (moved[i] - way[i]) * (moved[i] - way[i]);
        vxs_area_texel(moved, 64, next);
        assert_true(fabs(hypot(next[0] - at[0], next[1] - at[1]) * wide / sqrt(across) - 1) < 1e-4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_texels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
