/* The runtime library: opening assets, and lookups of world-space points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "alloc_fail.h"
#include "dag_sample.h"
#include "runtime/vxs.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* A file of two lights, "sun" and "moon", that share a sample; the moon's volume is bounded. */
typedef struct fixture {
    dag_sample sample;
    vxs_bytes  file;
    vxs_asset *asset;
    char       path[32];
} fixture;

enum { LEVELS = 6, SIDE = 1 << LEVELS };

static int set_up(void **state)
{
    fixture *f = dag_sample_alloc(1, sizeof *f);
    rng      r = {42};
    dag_sample_init(&f->sample, &r, LEVELS, 100);
    vxs_write_light lights[2] = {dag_sample_light(&f->sample, "sun"), dag_sample_light(&f->sample, "moon")};
    lights[1].light.flags     = VXS_LIGHT_BOUNDED;
    vxs_write_desc desc       = {.lights = lights, .light_count = 2, .metadata = "{}", .zstd_level = 1};
    if (vxs_write(&f->file, &desc) != VXS_OK) return 1;
    if (vxs_asset_open(&f->asset, f->file.data, f->file.size_bytes, NULL) != VXS_OK) return 1;

    strcpy(f->path, "/tmp/vxs-runtime-XXXXXX");
    int    to      = mkstemp(f->path);
    size_t written = 0;
    if (to >= 0) written = (size_t)write(to, f->file.data, f->file.size_bytes);
    if (to >= 0) close(to);
    *state = f;
    return written != f->file.size_bytes;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    unlink(f->path);
    vxs_asset_close(f->asset);
    dag_sample_free(&f->sample);
    free(f->file.data);
    free(f);
    return 0;
}

/* opening ---------------------------------------------------------------------------------------------------------------------- */

static void test_asset(void **state)
{
    const fixture *f = *state;
    assert_int_equal(vxs_asset_light_count(f->asset), 2);
    assert_string_equal(vxs_asset_light(f->asset, 0)->name, "sun");
    assert_string_equal(vxs_asset_light(f->asset, 1)->name, "moon");
    assert_null(vxs_asset_light(f->asset, 2));
    assert_null(vxs_asset_light(f->asset, UINT32_MAX));
    assert_ptr_equal(vxs_asset_find_light(f->asset, "moon"), vxs_asset_light(f->asset, 1));
    assert_null(vxs_asset_find_light(f->asset, "mo"));
    assert_null(vxs_asset_find_light(f->asset, ""));
    assert_string_equal(vxs_asset_contents(f->asset)->metadata, "{}");
    vxs_asset_close(NULL);
}

static void test_open_file(void **state)
{
    const fixture *f = *state;
    vxs_asset     *asset;
    assert_int_equal(vxs_asset_open_file(&asset, f->path, NULL), VXS_OK);
    assert_int_equal(vxs_asset_light_count(asset), 2);
    vxs_asset_close(asset);

    asset = f->asset;
    errno = 0;
    assert_int_equal(vxs_asset_open_file(&asset, "/no/such/file.vxs", NULL), VXS_E_READ);
    assert_int_equal(errno, ENOENT);
    assert_null(asset);
    for (int n = 0; n < 3; n++) {
        static const char *const folders[3] = {"/tmp", "/dev", "/proc"}; /* file systems differ in what size a folder has */
        errno                               = 0;
        assert_int_equal(vxs_asset_open_file(&asset, folders[n], NULL), VXS_E_READ);
        assert_int_equal(errno, EISDIR);
        assert_null(asset);
    }
    assert_int_equal(vxs_asset_open_file(&asset, "/dev/null", NULL), VXS_E_TRUNCATED);
    assert_null(asset);
}

static void test_open_refuses_bad_bytes(void **state)
{
    const fixture *f     = *state;
    vxs_asset     *asset = f->asset;
    assert_int_equal(vxs_asset_open(&asset, f->file.data, f->file.size_bytes - 1, NULL), VXS_E_TRUNCATED);
    assert_null(asset);
    assert_int_equal(vxs_asset_open(&asset, "not a .vxs file", 15, NULL), VXS_E_NOT_VXS);
    f->file.data[f->file.size_bytes - 1] ^= 1;
    assert_int_equal(vxs_asset_open(&asset, f->file.data, f->file.size_bytes, NULL), VXS_E_CORRUPT);
    f->file.data[f->file.size_bytes - 1] ^= 1;
}

/* Open the fixture's file, or its bytes. */
static vxs_result open_with(const fixture *f, int by_path, vxs_asset **asset, const vxs_read_desc *desc)
{
    if (by_path) return vxs_asset_open_file(asset, f->path, desc);
    return vxs_asset_open(asset, f->file.data, f->file.size_bytes, desc);
}

static void test_failing_allocations(void **state)
{
    const fixture *f = *state;
    for (int by_path = 0; by_path < 2; by_path++) {
        alloc_fail    a         = {0};
        vxs_allocator allocator = alloc_fail_allocator(&a);
        vxs_read_desc desc      = {.allocator = &allocator};
        vxs_asset    *asset     = NULL;
        vxs_result    r         = VXS_E_MEMORY;
        uint64_t      n         = 0;
        while (r != VXS_OK) {
            a = (alloc_fail){.fail_at = ++n};
            r = open_with(f, by_path, &asset, &desc);
            assert_in_range(n, 1, 100);
            if (r == VXS_OK) break;
            assert_int_equal(r, VXS_E_MEMORY);
            assert_null(asset);
            assert_int_equal(a.live_bytes, 0);
            assert_int_equal(a.wrong_sizes, 0);
        }
        assert_in_range(n, 10, 100);
        vxs_asset_close(asset);
        assert_int_equal(a.live_bytes, 0);
        assert_int_equal(a.wrong_sizes, 0);
    }
}

static void test_memory_limit_counts_the_file(void **state)
{
    const fixture *f         = *state;
    alloc_fail     a         = {0};
    vxs_allocator  allocator = alloc_fail_allocator(&a);
    for (uint64_t limit = 1; limit < (uint64_t)1 << 24; limit += limit / 8 + 1) {
        vxs_asset    *asset;
        vxs_read_desc desc = {.allocator = &allocator, .memory_limit_bytes = limit};
        a                  = (alloc_fail){0};
        vxs_result r       = vxs_asset_open_file(&asset, f->path, &desc);
        assert_in_range(a.peak_bytes, 0, limit + 1024); /* the asset itself is small, and not counted */
        assert_true(r == VXS_E_MEMORY || limit > f->file.size_bytes);
        assert_true(r == VXS_E_MEMORY || r == VXS_OK);
        if (limit > 1 << 22) assert_int_equal(r, VXS_OK);
        vxs_asset_close(asset);
        assert_int_equal(a.live_bytes, 0);
    }
}

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

/* World position of a place in light space; see dag_sample_light. */
static void ws_from_vx(double point_ws[3], double u, double v, double depth)
{
    point_ws[0] = (u - 2) / 2;
    point_ws[1] = 10 - depth;
    point_ws[2] = (v + 4) / 2;
}

static void check_voxel(const vxs_light *light, const double *point_ws, const double *normal_ws, int filter_px, int32_t u,
                        int32_t v, int32_t depth)
{
    int32_t voxel[3];
    vxs_voxel(light, point_ws, normal_ws, filter_px, voxel);
    assert_int_equal(voxel[0], u);
    assert_int_equal(voxel[1], v);
    assert_int_equal(voxel[2], depth);
}

static void test_voxel(void **state)
{
    const fixture   *f     = *state;
    const vxs_light *light = vxs_asset_light(f->asset, 0);
    double           p[3];
    ws_from_vx(p, 3.5, 4.5, 5.5);
    check_voxel(light, p, NULL, 9, 3, 4, 5);
    ws_from_vx(p, -0.25, 64.75, -3.5);
    check_voxel(light, p, NULL, 1, -1, 64, -4);
    ws_from_vx(p, 8, 16, 24); /* a voxel holds its near side */
    check_voxel(light, p, NULL, 1, 8, 16, 24);
    check_voxel(light, (double[3]){-1, 10, 2}, NULL, 1, 0, 0, 0);

    const int32_t limit = 1 << 30;
    check_voxel(light, (double[3]){1e12, -1e12, -1e12}, NULL, 1, limit, -limit, limit);
    check_voxel(light, (double[3]){-1e300, 1e300, 1e300}, NULL, 1, -limit, limit, -limit);
}

/* A bias of half the filter along the normal, a texel being half a metre, a voxel of depth one; whole, and away from the surface. */
static void test_voxel_bias(void **state)
{
    const fixture   *f     = *state;
    const vxs_light *light = vxs_asset_light(f->asset, 0);
    double           p[3];
    ws_from_vx(p, 30.5, 30.5, 30.5);
    check_voxel(light, p, (double[3]){1, 0, 0}, 1, 31, 30, 30); /* 0.5 -> 1 */
    check_voxel(light, p, (double[3]){-1, 0, 0}, 1, 29, 30, 30);
    check_voxel(light, p, (double[3]){1, 0, 0}, 9, 35, 30, 30);   /* 4.5 -> 5 */
    check_voxel(light, p, (double[3]){0, 0, -1}, 17, 30, 21, 30); /* 8.5 -> 9 */
    check_voxel(light, p, (double[3]){0, 1, 0}, 9, 30, 30, 27);   /* up is to the light: 2.25 -> 3 */
    check_voxel(light, p, (double[3]){0, -1, 0}, 9, 30, 30, 33);
    check_voxel(light, p, (double[3]){0.8, 0.6, 0}, 9, 34, 30, 28);        /* 3.6 -> 4, 1.35 -> 2 */
    check_voxel(light, p, (double[3]){1 / 1.5, 0.0, 1e-9}, 9, 33, 30, 30); /* 3 and a rounding error is 3, an error alone is 0 */
    check_voxel(light, p, (double[3]){0, 0, 0}, 9, 30, 30, 30);

    /* sizes of a hostile file, and normals that are none */
    vxs_light huge    = *light;
    huge.texel_metres = 1e300;
    check_voxel(&huge, p, (double[3]){1, 1, 0}, 17, 1 << 30, 30, -(1 << 30));
    check_voxel(&huge, (double[3]){1e300, -1e300, 0}, (double[3]){1e300, -1e300, 0}, 17, 1 << 30, -4, 1 << 30);
}

/* The lit fraction, a voxel at a time. */
static float lit_fraction(const dag_sample *s, int32_t i, int32_t j, int32_t k, int filter_px)
{
    if (i < 0 || j < 0 || i >= SIDE || j >= SIDE) return VXS_OUTSIDE;
    if (k < 0) return 1;
    int lit = 0, half_px = filter_px / 2;
    for (int32_t y = j - half_px; y <= j + half_px; y++)
        for (int32_t x = i - half_px; x <= i + half_px; x++) {
            int inside = x >= 0 && y >= 0 && x < SIDE && y < SIDE;
            lit += !inside || !dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, (uint32_t)(k < SIDE ? k : SIDE - 1));
        }
    return (float)lit / (float)(filter_px * filter_px);
}

static void test_lookup(void **state)
{
    const fixture   *f   = *state;
    const vxs_light *sun = vxs_asset_light(f->asset, 0), *moon = vxs_asset_light(f->asset, 1);
    rng              r      = {7};
    int              partly = 0;
    for (int n = 0; n < 30000; n++) {
        int32_t i = rng_between(&r, -10, SIDE + 9), j = rng_between(&r, -10, SIDE + 9), k = rng_between(&r, -10, SIDE + 9);
        int     filter_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
        double  p[3];
        ws_from_vx(p, i + rng_below(&r, 16) / 16.0, j + rng_below(&r, 16) / 16.0, k + rng_below(&r, 16) / 16.0);
        float wanted = lit_fraction(&f->sample, i, j, k, filter_px);
        assert_true(vxs_lookup(sun, p, NULL, filter_px) == wanted);
        partly += wanted > 0 && wanted < 1;
        /* the moon's volume ends at the map */
        assert_true(vxs_lookup(moon, p, NULL, filter_px) == (k < 0 || k >= SIDE ? VXS_OUTSIDE : wanted));
    }
    assert_in_range(partly, 3000, 30000);
}

static void test_lookup_with_normal(void **state)
{
    const fixture   *f     = *state;
    const vxs_light *light = vxs_asset_light(f->asset, 0);
    rng              r     = {8};
    for (int n = 0; n < 10000; n++) {
        double  p[3], normal[3], length = 0;
        int     filter_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
        int32_t voxel[3];
        ws_from_vx(p, rng_between(&r, -100, 700) / 10.0, rng_between(&r, -100, 700) / 10.0, rng_between(&r, -100, 700) / 10.0);
        for (int k = 0; k < 3; k++) normal[k] = rng_between(&r, -100, 100);
        for (int k = 0; k < 3; k++) length += normal[k] * normal[k];
        for (int k = 0; k < 3; k++) normal[k] = length > 0 ? normal[k] / sqrt(length) : 0;
        vxs_voxel(light, p, normal, filter_px, voxel);
        assert_true(vxs_lookup(light, p, normal, filter_px) == lit_fraction(&f->sample, voxel[0], voxel[1], voxel[2], filter_px));
    }
}

static void test_lookup_far_away(void **state)
{
    const fixture   *f     = *state;
    const vxs_light *light = vxs_asset_light(f->asset, 0);
    double           p[3];
    ws_from_vx(p, 20.5, 20.5, -1e12);
    assert_true(vxs_lookup(light, p, NULL, 9) == 1);
    ws_from_vx(p, 20.5, 20.5, 1e12);
    assert_true(vxs_lookup(light, p, NULL, 9) == lit_fraction(&f->sample, 20, 20, SIDE - 1, 9));
    assert_true(vxs_lookup(light, (double[3]){1e300, 0, 5}, NULL, 17) == VXS_OUTSIDE);
    assert_true(vxs_lookup(light, (double[3]){5, 0, -1e300}, NULL, 17) == VXS_OUTSIDE);
    assert_true(vxs_lookup(light, (double[3]){(double)NAN, 0, 5}, NULL, 1) == VXS_OUTSIDE);
}

static void test_lookup_many(void **state)
{
    enum { COUNT = 500 };
    const fixture   *f     = *state;
    const vxs_light *light = vxs_asset_light(f->asset, 0);
    rng              r     = {9};
    static double    points[3 * COUNT], normals[3 * COUNT];
    static float     lit[COUNT + 1];
    for (int n = 0; n < COUNT; n++) {
        ws_from_vx(points + 3 * n, rng_between(&r, -40, 680) / 10.0, rng_between(&r, -40, 680) / 10.0,
                   rng_between(&r, 0, 640) / 10.0);
        normals[3 * n + rng_below(&r, 3)] = rng_below(&r, 2) ? 1 : -1;
    }
    for (int with_normals = 0; with_normals < 2; with_normals++) {
        lit[COUNT] = 77;
        vxs_lookup_many(light, points, with_normals ? normals : NULL, COUNT, 5, lit);
        for (int n = 0; n < COUNT; n++)
            assert_true(lit[n] == vxs_lookup(light, points + 3 * n, with_normals ? normals + 3 * n : NULL, 5));
        assert_true(lit[COUNT] == 77);
    }
    vxs_lookup_many(light, NULL, NULL, 0, 5, NULL);
}

static void test_result_text(void **state)
{
    (void)state;
    assert_string_equal(vxs_result_text(VXS_OK), "success");
    assert_string_equal(vxs_result_text(VXS_E_CORRUPT), "the file breaks a rule of its format");
    assert_string_equal(vxs_result_text((vxs_result)9), "unknown result");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_asset),
        cmocka_unit_test(test_open_file),
        cmocka_unit_test(test_open_refuses_bad_bytes),
        cmocka_unit_test(test_failing_allocations),
        cmocka_unit_test(test_memory_limit_counts_the_file),
        cmocka_unit_test(test_voxel),
        cmocka_unit_test(test_voxel_bias),
        cmocka_unit_test(test_lookup),
        cmocka_unit_test(test_lookup_with_normal),
        cmocka_unit_test(test_lookup_far_away),
        cmocka_unit_test(test_lookup_many),
        cmocka_unit_test(test_result_text),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
