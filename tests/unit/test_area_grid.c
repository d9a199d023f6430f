/* runtime/volumes/vxs_area_grid.h: lookups between bits and rows, and places in imperfect shadow maps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "random_lamp.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/vxs_area_grid.h"

/* What lies between two bits and two rows, against the four taps of it, at all places between all bits. */
static void test_lit_between_bits(void **state)
{
    (void)state;
    enum { BITS = 128, C = 3, R = 4 };
    uint32_t      words[4 * C * R];
    vxs_grid_size size = {C, R, BITS};
    rng           r    = {4};
    for (int n = 0; n < 4 * C * R; n++) words[n] = rng_u32(&r);
    for (int bit = 0; bit < BITS; bit++)
        for (int row = 0; row < R; row++)
            for (int k = 0; k < 8; k++) {
                double of_row = k < 4 ? 0 : uniform(&r, 0, 1), of_bit = k % 2 ? uniform(&r, 0, 1) : 0.5 * (k / 2 % 2), taps[2][2];
                vxs_grid_rows rows   = {row, (row + 1) % R, of_row};
                int           column = k % C;
                for (int a = 0; a < 2; a++)
                    for (int b = 0; b < 2; b++) {
                        int      at = bit + b < BITS ? bit + b : BITS - 1, texel = ((row + a) % R * C + column) * 4;
                        uint32_t word = words[texel + at / 32];
                        taps[a][b]    = word >> at % 32 & 1 ? 0 : 1;
                    }
                double wanted = (1 - of_row) * ((1 - of_bit) * taps[0][0] + of_bit * taps[0][1]) +
                                of_row * ((1 - of_bit) * taps[1][0] + of_bit * taps[1][1]);
                assert_true(fabs(vxs_grid_lit(words, &size, column, &rows, bit + 0.5 + of_bit) - wanted) < 1e-12);
            }
    vxs_grid_rows first = {1, 1, 0}; /* before the first bit, and before all */
    double        lit   = words[4 * C] & 1 ? 0 : 1;
    assert_true(vxs_grid_lit(words, &size, 0, &first, 0.1) == lit && vxs_grid_lit(words, &size, 0, &first, -7) == lit);
}

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

/* Directions to all of the disc: each in the place that a paraboloid shows it at, a texel as wide as the directions that are in it. */
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
        cmocka_unit_test(test_lit_between_bits),
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_texels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
