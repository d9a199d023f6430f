/* Virtual point lights of a rectangle, and points of triangles: sums, means, how evenly they lie, and that none is where it is
 * black.
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
#include "runtime/volumes/vxs_area_light.h"

enum { WIDE = 13, HIGH = 7, PLACES = VXS_AREA_JITTERED + 1 };

static const char *const names[PLACES] = {"Halton", "importance", "regular", "jittered"};

/* 2 x 1 metres, with normal z. */
static vxs_area_rectangle rectangle_of(const float *texture)
{
    return (vxs_area_rectangle){{1, 2, 3}, {2, 0, 0}, {0, 1, 0}, {3, 2, 1}, texture, WIDE, HIGH};
}

static double luminance(const float *c)
{
    return 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
}

/* A texture with black texels, rows and columns, and a texel a hundred times as bright as others. */
static void random_texture(rng *r, float *texture)
{
    for (int n = 0; n < WIDE * HIGH; n++)
        for (int i = 0; i < 3; i++) texture[3 * n + i] = (float)uniform(r, 0.1, 1);
    for (int n = 0; n < WIDE * HIGH; n++)
        if (!rng_below(r, 4) || n / WIDE == 2 || n / WIDE == HIGH - 1 || n % WIDE == 0)
            memset(texture + 3 * n, 0, 3 * sizeof *texture);
    for (int i = 0; i < 3; i++) texture[3 * (4 * WIDE + 5) + i] = 100;
}

static void vpls_of(const vxs_area_rectangle *r, int places, uint32_t seed, vxs_vpl *vpls, uint32_t count)
{
    assert_int_equal(vxs_area_sample(r, (vxs_area_places)places, seed, vpls, count), VXS_OK);
}

/* Even light: all have an equal part of it, on the rectangle, to the side of its normal. */
static void test_sums(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 7, 64, 256};
    vxs_area_rectangle    r        = rectangle_of(NULL);
    vxs_vpl               vpls[VXS_VPLS_MAX];
    for (int places = 0; places < PLACES; places++)
        for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
            double sum[3] = {0}, discs = 0;
            vpls_of(&r, places, (uint32_t)k, vpls, counts[k]);
            for (uint32_t n = 0; n < counts[k]; n++) {
                const vxs_vpl *l = &vpls[n];
                for (int i = 0; i < 3; i++) sum[i] += (double)l->colour[i];
                assert_true(l->place[0] >= 1 && l->place[0] <= 3 && l->place[1] >= 2 && l->place[1] <= 3 && l->place[2] == 3);
                assert_true(l->normal[0] == 0 && l->normal[1] == 0 && l->normal[2] == 1);
                discs += M_PI * (double)l->radius_metres * (double)l->radius_metres;
            }
            for (int i = 0; i < 3; i++) assert_true(fabs(sum[i] / (2 * (3 - i)) - 1) < 1e-5);
            assert_true(fabs(discs / 2 - 1) < 1e-5);
        }
}

/* By importance, all VPLs have one luminance, their sum is that of the texture, each has the colour of its texel, and none is where
 * that is black. */
static void test_importance(void **state)
{
    (void)state;
    rng     r = {5};
    float   texture[3 * WIDE * HIGH];
    vxs_vpl vpls[VXS_VPLS_MAX];
    for (uint32_t seed = 0; seed < 100; seed++) {
        double all = 0;
        random_texture(&r, texture);
        vxs_area_rectangle of = rectangle_of(texture);
        for (int n = 0; n < WIDE * HIGH; n++)
            all += luminance((float[3]){3 * texture[3 * n], 2 * texture[3 * n + 1], texture[3 * n + 2]}) * 2 / (WIDE * HIGH);
        vpls_of(&of, VXS_AREA_IMPORTANCE, seed, vpls, VXS_VPLS_MAX);
        for (int n = 0; n < VXS_VPLS_MAX; n++) {
            const vxs_vpl *l = &vpls[n];
            int            x = (int)(((double)l->place[0] - 1) / 2 * WIDE), y = (int)(((double)l->place[1] - 2) * HIGH);
            const float   *texel  = texture + 3 * (WIDE * y + x);
            double         bright = luminance(texel);
            assert_true(fabs(luminance(l->colour) * VXS_VPLS_MAX / all - 1) < 1e-5);
            if (fabs(((double)l->place[0] - 1) / 2 * WIDE - x - 0.5) > 0.4999 ||
                fabs(((double)l->place[1] - 2) * HIGH - y - 0.5) > 0.4999)
                continue; /* a float does not know on which side of a border it is */
            assert_true(bright > 0);
            assert_true(fabs((double)l->colour[0] * (double)texel[1] * 2 - (double)l->colour[1] * (double)texel[0] * 3) <
                        1e-5 * all);
        }
    }
    memset(texture, 0, sizeof texture); /* a screen that is off */
    vxs_area_rectangle off = rectangle_of(texture);
    vpls_of(&off, VXS_AREA_IMPORTANCE, 0, vpls, 9);
    for (int n = 0; n < 9; n++) assert_true(luminance(vpls[n].colour) == 0 && vpls[n].place[0] >= 1 && vpls[n].place[0] <= 3);
}

/* The light of a texture is all there, wherever its VPLs are: each has what is nearest to it. */
static void test_shares(void **state)
{
    (void)state;
    rng     r = {6};
    float   texture[3 * WIDE * HIGH];
    vxs_vpl vpls[VXS_VPLS_MAX];
    for (uint32_t seed = 0; seed < 20; seed++) {
        uint32_t           count = 1 + rng_below(&r, VXS_VPLS_MAX);
        vxs_area_rectangle of    = rectangle_of(texture);
        random_texture(&r, texture);
        for (int places = 0; places < PLACES; places++) {
            double sum[3] = {0}, all[3] = {0};
            if (places == VXS_AREA_IMPORTANCE) continue; /* exact in luminance: see there */
            vpls_of(&of, places, seed, vpls, count);
            for (uint32_t n = 0; n < 3 * count; n++) sum[n % 3] += (double)vpls[n / 3].colour[n % 3];
            for (int n = 0; n < 3 * WIDE * HIGH; n++) all[n % 3] += (3 - n % 3) * 2 * (double)texture[n] / (WIDE * HIGH);
            for (int i = 0; i < 3; i++) assert_true(fabs(sum[i] / all[i] - 1) < 1e-5);
        }
    }
    memset(texture, 0, sizeof texture);
    for (int i = 0; i < 3; i++) texture[3 * (2 * WIDE + 10) + i] = 1;
    vxs_area_rectangle one = rectangle_of(texture);
    vpls_of(&one, VXS_AREA_REGULAR, 0, vpls, 2); /* the texel is in the right half */
    assert_true(vpls[0].colour[0] == 0 && vpls[0].place[0] < 2 && fabs((double)vpls[1].colour[0] * WIDE * HIGH / 6 - 1) < 1e-5);
}

/* The largest difference, of all boxes from the corner, of a box's area and the part of the points in it: at boxes that end at
 * points. */
static double star_discrepancy(const vxs_vpl *vpls, uint32_t count)
{
    double at[2][VXS_VPLS_MAX], ends[2][VXS_VPLS_MAX + 1], most = 0;
    for (uint32_t n = 0; n < count; n++)
        for (int i = 0; i < 2; i++) at[i][n] = ends[i][n] = i ? (double)vpls[n].place[1] - 2 : ((double)vpls[n].place[0] - 1) / 2;
    for (int i = 0; i < 2; i++) {
        ends[i][count] = 1;
        qsort(ends[i], count + 1, sizeof(double), doubles_ascending);
    }
    for (uint32_t j = 0; j <= count; j++)
        for (uint32_t k = 0; k <= count; k++) {
            uint32_t open = 0, closed = 0;
            for (uint32_t n = 0; n < count; n++) {
                open += at[0][n] < ends[0][j] && at[1][n] < ends[1][k];
                closed += at[0][n] <= ends[0][j] && at[1][n] <= ends[1][k];
            }
            double area = ends[0][j] * ends[1][k];
            most        = fmax(most, fmax(area - (double)open / count, (double)closed / count - area));
        }
    return most;
}

static void test_evenness(void **state)
{
    (void)state;
    enum { COUNT = 64 };
    vxs_area_rectangle r = rectangle_of(NULL);
    vxs_vpl            vpls[COUNT];
    rng                random = {3};
    double             found[PLACES], at_random = 0;
    for (int places = 0; places < PLACES; places++) {
        vpls_of(&r, places, 0, vpls, COUNT);
        found[places] = star_discrepancy(vpls, COUNT);
        print_message("%s: star discrepancy of 64 VPLs %.3f\n", names[places], found[places]);
    }
    for (int n = 0; n < COUNT; n++) {
        vpls[n].place[0] = (float)uniform(&random, 1, 3);
        vpls[n].place[1] = (float)uniform(&random, 2, 3);
    }
    at_random = star_discrepancy(vpls, COUNT);
    print_message("at random: %.3f\n", at_random);
    assert_true(found[VXS_AREA_HALTON] < 0.06 && found[VXS_AREA_IMPORTANCE] < 0.9 * found[VXS_AREA_HALTON]);
    assert_true(found[VXS_AREA_HALTON] < found[VXS_AREA_JITTERED] && found[VXS_AREA_JITTERED] < at_random);
    assert_true(found[VXS_AREA_HALTON] < found[VXS_AREA_REGULAR]);
}

/* What a place before the rectangle gets of the VPLs, nothing between them. */
static double irradiance_of(const vxs_vpl *vpls, uint32_t count)
{
    const double place[3] = {2.2, 2.4, 4.5};
    double       sum      = 0;
    for (uint32_t n = 0; n < count; n++) {
        double way[3], square = 0;
        for (int i = 0; i < 3; i++) {
            way[i] = place[i] - (double)vpls[n].place[i];
            square += way[i] * way[i];
        }
        sum += luminance(vpls[n].colour) * way[2] * way[2] / (square * square);
    }
    return sum;
}

/* How far estimates by 16 VPLs are from what all texels give, over many seeds: relative RMS of one texture. */
static double error_of(const vxs_area_rectangle *r, int places, double wanted)
{
    enum { SEEDS = 400, COUNT = 16 };
    vxs_vpl vpls[COUNT];
    double  square = 0, mean = 0;
    for (uint32_t seed = 1; seed <= SEEDS; seed++) {
        vpls_of(r, places, seed, vpls, COUNT);
        double found = irradiance_of(vpls, COUNT) / wanted;
        square += (found - 1) * (found - 1) / SEEDS;
        mean += found / SEEDS;
    }
    if (places == VXS_AREA_IMPORTANCE) assert_true(fabs(mean - 1) < 4 * sqrt(square / SEEDS) + 1e-3); /* right in the mean */
    return sqrt(square);
}

/* The wanted sum, by 32 x 32 VPLs in each texel. */
static double exactly(const vxs_area_rectangle *r)
{
    enum { FINE = 32 };
    double sum = 0;
    for (int y = 0; y < HIGH * FINE; y++)
        for (int x = 0; x < WIDE * FINE; x++) {
            const float *texel = r->texture + 3 * (y / FINE * WIDE + x / FINE);
            vxs_vpl      l     = {{1 + 2 * (x + 0.5F) / (WIDE * FINE), 2 + (y + 0.5F) / (HIGH * FINE), 3}, {0, 0, 1}, {0}, 1, 0};
            for (int i = 0; i < 3; i++) l.colour[i] = texel[i] * r->radiance[i] * 2 / (WIDE * HIGH * FINE * FINE);
            sum += irradiance_of(&l, 1);
        }
    return sum;
}

static void test_variance(void **state)
{
    (void)state;
    rng    r = {5};
    float  texture[3 * WIDE * HIGH];
    double even[2], uneven[PLACES];
    for (int n = 0; n < 3 * WIDE * HIGH; n++) texture[n] = 1;
    vxs_area_rectangle of = rectangle_of(texture);
    even[0]               = error_of(&of, VXS_AREA_HALTON, exactly(&of));
    even[1]               = error_of(&of, VXS_AREA_JITTERED, exactly(&of));
    random_texture(&r, texture);
    for (int places = 0; places < PLACES; places++) uneven[places] = error_of(&of, places, exactly(&of));
    print_message("16 VPLs, even: %.4f Halton, %.4f jittered; with a bright texel:", even[0], even[1]);
    for (int places = 0; places < PLACES; places++) print_message(" %.4f %s", uneven[places], names[places]);
    print_message("\n");
    assert_true(even[0] < 0.02 && even[1] < 0.02);
    for (int places = 0; places < PLACES; places++) assert_true(uneven[places] < 0.1);
}

/* Each triangle has its part of the points, on it, about its middle. */
static void test_scatter(void **state)
{
    (void)state;
    enum { TRIANGLES = 9, COUNT = 20000 };
    rng                   r = {9};
    float                 positions[9 * TRIANGLES];
    uint32_t              corners[3 * TRIANGLES], n = 0;
    static vxs_area_point points[COUNT];
    for (int k = 0; k < 9 * TRIANGLES; k++) positions[k] = (float)uniform(&r, -5, 5);
    for (uint32_t k = 0; k < 3 * TRIANGLES; k++) corners[k] = 3 * TRIANGLES - 1 - k;
    memcpy(positions + 27, positions + 30, 3 * sizeof(float)); /* one without area */
    double all = vxs_area_scatter(positions, corners, TRIANGLES, points, COUNT), sum = 0;
    for (int t = 0; t < TRIANGLES; t++) {
        double p[3][3], a[3], b[3], normal[3], mean[3] = {0}, area;
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 3; i++) p[k][i] = (double)positions[3 * corners[3 * t + k] + (uint32_t)i];
        for (int i = 0; i < 3; i++) {
            a[i] = p[1][i] - p[0][i];
            b[i] = p[2][i] - p[0][i];
        }
        cross(a, b, normal);
        area = sqrt(dot(normal, normal)) / 2;
        sum += area;
        uint32_t end = (uint32_t)fmin(COUNT, floor(sum / all * COUNT + 2.0 / 3)), first = n;
        for (; n < end; n++) {
            double from[3], u[3], v[3];
            for (int i = 0; i < 3; i++) from[i] = (double)points[n].place[i] - p[0][i];
            cross(from, b, u);
            cross(a, from, v);
            double square = 4 * area * area, s = dot(u, normal) / square, w = dot(v, normal) / square;
            if (s < -1e-4 || w < -1e-4 || s + w > 1 + 1e-4) { /* the first and the last may be the neighbour's */
                assert_true(n == first || n + 1 == end);
                continue;
            }
            assert_true(fabs(dot(from, normal)) < 1e-3 * area);
            for (int i = 0; i < 3; i++) mean[i] += from[i] / (end - first);
        }
        for (int i = 0; i < 3 && area > 1; i++) assert_true(fabs(mean[i] - (a[i] + b[i]) / 3) < 0.05);
    }
    assert_int_equal(n, COUNT);
    assert_true(fabs(all / sum - 1) < 1e-9 && fabs((double)points[7].square_metres * COUNT / all - 1) < 1e-5);
    assert_true(vxs_area_scatter(positions, corners, 0, points, 1) == 0);
}

/* A power of two of points on a square are all apart: none is nearer to another than half of what they are in the mean. */
static void test_points_of_a_square(void **state)
{
    (void)state;
    enum { COUNT = 1024 };
    static const float    positions[12] = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
    static const uint32_t corners[6]    = {0, 1, 2, 0, 2, 3};
    static vxs_area_point points[COUNT];
    double                nearest = 1;
    assert_true(vxs_area_scatter(positions, corners, 2, points, COUNT) > 0);
    for (int n = 0; n < COUNT; n++)
        for (int k = 0; k < n; k++)
            nearest = fmin(nearest, hypot((double)points[n].place[0] - (double)points[k].place[0],
                                          (double)points[n].place[2] - (double)points[k].place[2]));
    print_message("points of a square: %.2f of their mean distance apart\n", nearest * sqrt(COUNT));
    assert_true(nearest * sqrt(COUNT) > 0.5);
}

/* A floor below a VPL, in rings about it: each has a quarter of what it has of the area, and three of what it has of the VPL's
 * light; points stand for all of it. */
static void test_scatter_for(void **state)
{
    (void)state;
    enum { COUNT = 40000, RINGS = 5 };
    static const float    positions[12] = {-50, 0, -50, 50, 0, -50, 50, 0, 50, -50, 0, 50};
    static const uint32_t corners[6]    = {0, 1, 2, 0, 2, 3};
    static const double   ends[]        = {0, 1, 2, 5, 12, 40};
    static vxs_area_point points[COUNT];
    const vxs_vpl         bulb = {{5, 2, -3}, {0, -1, 0}, {1, 1, 1}, 0.1F, 0};
    double                sum = 0, in_rings[RINGS] = {0}, area[RINGS] = {0}, all = 0;
    assert_true(fabs(vxs_area_scatter_for(positions, corners, 2, &bulb, 1, points, COUNT) / 1e4 - 1) < 1e-6);
    for (int n = 0; n < COUNT; n++) {
        double from = hypot((double)points[n].place[0] - 5, (double)points[n].place[2] + 3);
        sum += (double)points[n].square_metres;
        for (int k = 0; k < RINGS; k++) {
            if (from < ends[k] || from >= ends[k + 1]) continue;
            in_rings[k]++;
            area[k] += (double)points[n].square_metres;
        }
    }
    for (int n = 0; n < 1000 * 1000; n++) /* the floor's part of the light, by pieces of 0.1 x 0.1 m */
        all += 0.01 * 2 / pow(4 + pow(n % 1000 * 0.1 - 49.95 - 5, 2) + pow(n / 1000 * 0.1 - 49.95 + 3, 2), 1.5);
    assert_true(fabs(sum / 1e4 - 1) < 0.01);
    for (int k = 0; k < RINGS; k++) { /* of a disc the integral of height / metres^3 has a closed form */
        double square[2] = {ends[k] * ends[k], ends[k + 1] * ends[k + 1]}, here = M_PI * (square[1] - square[0]),
               seen   = 2 * M_PI * 2 * (1 / sqrt(4 + square[0]) - 1 / sqrt(4 + square[1])),
               wanted = COUNT * (0.25 * here / 1e4 + 0.75 * seen / all);
        print_message("to %g m: %.0f points of %.0f, %.3f of the area\n", ends[k + 1], in_rings[k], wanted, area[k] / here);
        assert_true(fabs(in_rings[k] / wanted - 1) < 0.05 && fabs(area[k] / here - 1) < 0.05);
    }
    vxs_vpl dark = bulb; /* without light points are by area alone */
    memset(dark.colour, 0, sizeof dark.colour);
    static vxs_area_point alike[COUNT];
    vxs_area_scatter_for(positions, corners, 2, &dark, 1, points, COUNT);
    vxs_area_scatter(positions, corners, 2, alike, COUNT);
    assert_memory_equal(points, alike, sizeof alike);
    assert_true(vxs_area_scatter_for(positions, corners, 0, &bulb, 1, points, 1) == 0);
}

static void test_misuse(void **state)
{
    (void)state;
    vxs_vpl            vpls[1];
    float              texture[3] = {1, 1, 1};
    vxs_area_rectangle good       = rectangle_of(NULL), bad[5];
    for (int n = 0; n < 5; n++) bad[n] = good;
    bad[0].up[1]       = 0;
    bad[1].corner[2]   = NAN;
    bad[2].radiance[0] = -1;
    bad[3].texture     = texture;
    bad[3].wide_px     = 0;
    bad[4].across[0]   = INFINITY;
    for (int n = 0; n < 5; n++) assert_int_equal(vxs_area_sample(&bad[n], VXS_AREA_HALTON, 0, vpls, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_sample(&good, VXS_AREA_HALTON, 0, vpls, 0), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_sample(&good, VXS_AREA_HALTON, 0, vpls, VXS_VPLS_MAX + 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_sample(&good, (vxs_area_places)PLACES, 0, vpls, 1), VXS_E_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums),
        cmocka_unit_test(test_importance),
        cmocka_unit_test(test_shares),
        cmocka_unit_test(test_evenness),
        cmocka_unit_test(test_variance),
        cmocka_unit_test(test_scatter),
        cmocka_unit_test(test_points_of_a_square),
        cmocka_unit_test(test_scatter_for),
        cmocka_unit_test(test_misuse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
