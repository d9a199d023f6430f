/* Grids of smoke: the optical depth of rays against quadrature, curves of few nodes against the paths that they are made of, and
 * NRRD.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>

#include "baker/smoke/smoke_grid.h"
#include "baker/smoke/smoke_map.h"
#include "formats/vxs_format.h"
#include "random_light.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "repeats.h"
#include "smoke_sample.h"

static const smoke_balls balls      = {{{0, 2, 0}, {1, 3, 0.5}, {-1, 1, -0.5}}, {1.5, 1, 0.8}, {2, 5, 0.4}, 3};
static const uint32_t    sizes[3]   = {23, 31, 17};
static const double      axes[3][3] = {{0.2, 0.02, 0}, {-0.03, 0.15, 0.01}, {0, 0.04, 0.25}}, origin[3] = {-2, -0.4, -2.2};

/* A ray between two places about the grid; some lie along an axis, or begin within. */
static void random_ray(rng *r, int n, double from[3], double way[3])
{
    for (int i = 0; i < 3; i++) {
        from[i] = uniform(r, -4, 4) + (i == 1 ? 2 : 0);
        way[i]  = uniform(r, -1.5, 1.5) + (i == 1 ? 2 : 0) - from[i];
    }
    if (n % 4 == 0) memcpy(way, axes[n / 4 % 3], sizeof axes[0]);
    if (n % 8 == 0)
        for (int i = 0; i < 3; i++) from[i] = origin[i] + 3 * axes[0][i] + 4 * axes[1][i] + 5 * axes[2][i];
}

/* By the rule of midpoints. */
static double thick_by_steps(const smoke_grid *g, const double from[3], const double way[3], double begin, double end)
{
    enum { STEPS = 3000 };
    double sum = 0, ws[3];
    for (int n = 0; n < STEPS; n++) {
        for (int i = 0; i < 3; i++) ws[i] = from[i] + (begin + (end - begin) * (n + 0.5) / STEPS) * way[i];
        sum += sampled(g, axes, origin, ws);
    }
    return sum * (end - begin) / STEPS * sqrt(dot(way, way));
}

static void test_rays_have_the_integral(void **state)
{
    (void)state;
    smoke_grid g    = sample_grid(&balls, sizes, axes, origin);
    smoke_path path = {0};
    rng        r    = {2};
    int        met  = 0;
    for (int n = 0; n < (int)repeats(120, 2000); n++) {
        double from[3], way[3];
        random_ray(&r, n, from, way);
        path.count = 0;
        assert_int_equal(smoke_grid_march(&g, from, way, -3, 5, &path), 1);
        double end = uniform(&r, -1, 3), whole = path.count ? path.thick[path.count - 1] : 0;
        for (size_t k = 1; k < path.count; k++)
            assert_true(path.depth[k] > path.depth[k - 1] && path.thick[k] >= path.thick[k - 1] && path.depth[k] <= 5);
        met += whole > 0.1;
        if (whole > SMOKE_OPAQUE) continue;
        assert_true(fabs(whole - thick_by_steps(&g, from, way, -3, 5)) < 2e-3 * whole + 1e-6);
        assert_true(fabs(smoke_path_thick(&path, end) - thick_by_steps(&g, from, way, -3, end)) <
                    2e-3 * whole + 0.012); /* a line in a piece */
        smoke_path_cut(&path, end);
        if (path.count) assert_true(path.depth[path.count - 1] <= end);
    }
    assert_in_range(met, 40, 2000);
    smoke_path_free(&path);
    smoke_grid_free(&g);
}

static void test_corners(void **state)
{
    (void)state;
    smoke_grid g = sample_grid(&balls, sizes, axes, origin);
    for (int corner = 0; corner < 8; corner++) {
        double ws[3], wanted;
        smoke_grid_corner(&g, corner, ws);
        for (int i = 0; i < 3; i++) {
            wanted = origin[i];
            for (int n = 0; n < 3; n++) wanted += (corner >> n & 1 ? sizes[n] - 0.5 : -0.5) * axes[n][i];
            assert_true(fabs(ws[i] - wanted) < 1e-9);
        }
    }
    smoke_grid_free(&g);
}

/* nodes ------------------------------------------------------------------------------------------------------------------------ */

static void random_path(rng *r, smoke_path *path)
{
    double at   = uniform(r, 0, 5);
    path->count = 0;
    for (uint32_t n = rng_between(r, 1, 150); n > 0; n--) {
        double next = at + uniform(r, 0.05, 0.15);
        if (rng_below(r, 3)) assert_int_equal(smoke_path_add(path, at, next, uniform(r, 0.001, rng_below(r, 20) ? 0.05 : 0.6)), 1);
        at = next;
    }
}

/* What a curve says of a depth in units: formats/vxs.md section 15 by a scan. */
static double nodes_left(const uint32_t *nodes, uint32_t count, double unit)
{
    double left = 65535;
    for (uint32_t n = 0; n < count && (nodes[n] & 0xffff) <= unit; n++) {
        left = nodes[n] >> 16;
        if (n + 1 == count) break;
        double near = nodes[n] & 0xffff, far = nodes[n + 1] & 0xffff;
        if (far > unit) left += (unit - near) / (far - near) * ((nodes[n + 1] >> 16) - left);
    }
    return left / 65535;
}

static void test_nodes_keep_near_the_path(void **state)
{
    (void)state;
    const smoke_units units = {-1.5, 0.0005};
    smoke_path        path  = {0};
    rng               r     = {9};
    uint32_t          full = 0, few = 0;
    for (int n = 0; n < 1000; n++) {
        uint32_t nodes[VXS_SMOKE_NODES_MAX], most = rng_between(&r, 4, VXS_SMOKE_NODES_MAX);
        double   error = rng_below(&r, 4) ? uniform(&r, 0.001, 0.05) : 0, farthest = 0;
        random_path(&r, &path);
        uint32_t count = smoke_path_nodes(&path, &units, error, most, nodes);
        assert_in_range(count, 0, most);
        for (uint32_t k = 1; k < count; k++)
            assert_true((nodes[k] & 0xffff) > (nodes[k - 1] & 0xffff) && nodes[k] >> 16 <= nodes[k - 1] >> 16);
        if (count) { /* all light before it, and behind it what is left of the whole */
            assert_int_equal(nodes[0] >> 16, 65535);
            assert_true(fabs((nodes[count - 1] >> 16) / 65535.0 - exp(-path.thick[path.count - 1])) <= 0.5 / 65535 + 1e-12);
        }
        for (size_t k = 0; k < path.count; k++) {
            double unit = (path.depth[k] - units.first_metres) / units.step_metres;
            farthest    = fmax(farthest, fabs(nodes_left(nodes, count, unit) - exp(-path.thick[k])));
        }
        assert_true(fabs(farthest - smoke_path_error(&path, &units, nodes, count)) < 1e-12);
        if (count < most) assert_true(farthest <= error + 0.004); /* a step of a unit in the steepest of these paths */
        full += count == most;
        few += count && count < most;
    }
    assert_in_range(full, 100, 900);
    assert_in_range(few, 100, 900);
    smoke_path_free(&path);
}

static void test_more_nodes_are_nearer(void **state)
{
    (void)state;
    const smoke_units units  = {-1.5, 0.0005};
    smoke_path        path   = {0};
    rng               r      = {12};
    double            sum[3] = {0, 0, 0};
    for (int n = 0; n < 300; n++) {
        uint32_t nodes[VXS_SMOKE_NODES_MAX];
        random_path(&r, &path);
        for (int k = 0; k < 3; k++) {
            uint32_t count = smoke_path_nodes(&path, &units, 0, 4u << k, nodes);
            sum[k] += smoke_path_error(&path, &units, nodes, count);
        }
    }
    assert_true(sum[0] > 1.5 * sum[1] && sum[1] > 1.5 * sum[2]);
    smoke_path_free(&path);
}

/* Extinction from 1 to 1e8 per metre, in one voxel and in one capsule: what is left is what the integral in closed form says,
 * however steep, and a curve uses its nodes. */
static void test_dense_smoke_uses_its_nodes(void **state)
{
    (void)state;
    enum { SIZE = 5, MIDDLE = SIZE * SIZE * SIZE / 2, ASKED = 400 };
    const double unit[3][3] = {{0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.3}}, corner[3] = {-0.6, -0.6, -0.6}, from[3] = {0, 0, -2},
                 way[3]                       = {0, 0, 1};
    float         numbers[SIZE * SIZE * SIZE] = {0};
    smoke_grid    g                           = {.size = {SIZE, SIZE, SIZE}, .extinction = numbers};
    smoke_changes scratch                     = {0};
    smoke_path    path                        = {0};
    assert_int_equal(smoke_grid_place(&g, unit, corner), 1);
    for (int n = 0; n < 18; n++) {
        int    is_grid    = n % 2;
        double extinction = pow(10, n / 2), half = is_grid ? 0.3 : 0.5, all = extinction * half * (is_grid ? 1 : 2), most = 0;
        const vxs_capsule ball = {.radius_metres = 0.5F, .extinction = (float)extinction};
        const scene_smoke one  = {.count = 1, .list = (vxs_capsule *)&ball};
        uint32_t          nodes[VXS_SMOKE_NODES_MAX];
        numbers[MIDDLE] = (float)extinction;
        path.count      = 0;
        if (is_grid)
            assert_int_equal(smoke_grid_march(&g, from, way, 0, 5, &path), 1);
        else
            assert_int_equal(smoke_capsules_march(&one, &(uint32_t){0}, 1, from, way, 0, 5, &scratch, &path), 1);
        for (int k = 1; k <= ASKED;
             k++) { /* extinction is a tent in the voxel, of which the first half is queried, and even in the capsule */
            double thick = fmin(is_grid ? all / 2 : all, SMOKE_OPAQUE) * k / ASKED;
            double depth = 2 - half + (is_grid ? half * sqrt(2 * thick / all) : 2 * half * thick / all);
            most         = fmax(most, fabs(exp(-smoke_path_thick(&path, depth)) - exp(-thick)));
        }
        assert_true(path.thick[path.count - 1] > fmin(0.999 * all, SMOKE_OPAQUE) && path.count < 1000);
        const smoke_units units = {path.depth[0], (path.depth[path.count - 1] - path.depth[0]) / 65000};
        uint32_t          count = smoke_path_nodes(&path, &units, 0.001, VXS_SMOKE_NODES_MAX, nodes);
        double            error = smoke_path_error(&path, &units, nodes, count);
        print_message("%s of %.0e / m: %zu points, off by %.5f at most; %u nodes, within %.4f\n", is_grid ? "a voxel" : "a capsule",
                      extinction, path.count, most, count, error);
        assert_true(most < 0.0015);
        if (extinction * units.step_metres < 0.05)
            assert_true(error < 0.007 && (all < 1 || count >= 11)); /* a file's depths are fine enough */
    }
    smoke_path_free(&path);
    free(scratch.list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_corners),
        cmocka_unit_test(test_rays_have_the_integral),
        cmocka_unit_test(test_nodes_keep_near_the_path),
        cmocka_unit_test(test_more_nodes_are_nearer),
        cmocka_unit_test(test_dense_smoke_uses_its_nodes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
