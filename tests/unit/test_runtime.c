/* The runtime library: opening assets, and lookups of world-space points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "alloc_fail.h"
#include "dag_sample.h"
#include "random_light.h"
#include "runtime/vxs.h"
#include "smooth_box.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
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
    vxs_read_desc read = {.metadata = 1};
    if (vxs_asset_open(&f->asset, f->file.data, f->file.size_bytes, &read) != VXS_OK) return 1;

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
    assert_string_equal(vxs_asset_light(f->asset, 0)->light.name, "sun");
    assert_string_equal(vxs_asset_light(f->asset, 1)->light.name, "moon");
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
    assert_int_equal(vxs_asset_open_file(&asset, "/no/such/file.vxs", NULL), VXS_E_NO_FILE);
    assert_null(asset);
    for (int n = 0; n < 3; n++) {
        static const char *const folders[3] = {"/tmp", "/dev", "/proc"}; /* file systems differ in what size a folder has */
        assert_int_equal(vxs_asset_open_file(&asset, folders[n], NULL), VXS_E_READ);
        assert_null(asset);
    }
    assert_int_equal(vxs_asset_open_file(&asset, "/dev/null", NULL), VXS_E_READ); /* no file */
    assert_null(asset);

    char empty[] = "/tmp/vxs-empty-XXXXXX";
    int  to      = mkstemp(empty);
    assert_true(to >= 0 && !close(to));
    assert_int_equal(vxs_asset_open_file(&asset, empty, NULL), VXS_E_TRUNCATED);
    assert_null(asset);
    unlink(empty);
}

/* Files of a terabyte, of which no disk has more than some blocks: what they are is said by their first bytes, and nothing is taken
 * for them. */
static void test_a_file_is_told_by_its_head(void **state)
{
    const fixture *f      = *state;
    char           name[] = "/tmp/vxs-large-XXXXXX";
    int            file   = mkstemp(name);
    assert_true(file >= 0);
    for (int with_head = 0; with_head < 2; with_head++) {
        alloc_fail    memory    = {0};
        vxs_allocator allocator = alloc_fail_allocator(&memory);
        vxs_read_desc desc      = {.allocator = &allocator};
        vxs_asset    *asset;
        if (with_head) assert_int_equal(pwrite(file, f->file.data, f->file.size_bytes, 0), f->file.size_bytes);
        if (ftruncate(file, (off_t)1 << 40)) break; /* where no file may be so large */
        assert_int_equal(vxs_asset_open_file(&asset, name, &desc), with_head ? VXS_E_CORRUPT : VXS_E_NOT_VXS);
        assert_int_equal(memory.calls, 0);
    }
    close(file);
    unlink(name);
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

/* The lit fraction of a smooth box about a place in light space, a texel at a time. */
static float smooth_fraction(const dag_sample *s, double u, double v, int32_t k, int width)
{
    int32_t  side = 1 << s->levels, i = (int32_t)floor(u), j = (int32_t)floor(v), reach = width / 2 + 1;
    uint32_t across = (uint32_t)floor(256 * (u - i)), down = (uint32_t)floor(256 * (v - j));
    uint32_t dark = 0, all = 65536 * (uint32_t)(width * width);
    if (k < 0) return 1;
    for (int32_t y = j - reach; y <= j + reach; y++)
        for (int32_t x = i - reach; x <= i + reach; x++)
            if (x >= 0 && y >= 0 && x < side && y < side &&
                dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, (uint32_t)(k < side ? k : side - 1)))
                dark += smooth_overlap(x, i, across, width) * smooth_overlap(y, j, down, width);
    return (float)((double)(all - dark) / (double)all);
}

/* World position of a place in light space; see dag_sample_light. */
static void ws_from_vx(double point_ws[3], double u, double v, double depth)
{
    point_ws[0] = (u - 2) / 2;
    point_ws[1] = 10 - depth;
    point_ws[2] = (v + 4) / 2;
}

static void check_voxel(const vxs_light *light, const double *point_ws, const double *normal_ws, int width_px, int32_t u, int32_t v,
                        int32_t depth)
{
    int32_t voxel[3];
    vxs_voxel(light, point_ws, normal_ws, vxs_box(width_px), voxel);
    assert_int_equal(voxel[0], u);
    assert_int_equal(voxel[1], v);
    assert_int_equal(voxel[2], depth);
}

static void test_voxel(void **state)
{
    const fixture   *f     = *state;
    const vxs_light *light = &vxs_asset_light(f->asset, 0)->light;
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

/* The lit fraction, a voxel at a time. */
static float lit_fraction(const dag_sample *s, int32_t i, int32_t j, int32_t k, int width_px)
{
    if (i < 0 || j < 0 || i >= SIDE || j >= SIDE) return VXS_OUTSIDE;
    if (k < 0) return 1;
    int lit = 0, half_px = width_px / 2;
    for (int32_t y = j - half_px; y <= j + half_px; y++)
        for (int32_t x = i - half_px; x <= i + half_px; x++) {
            int inside = x >= 0 && y >= 0 && x < SIDE && y < SIDE;
            lit += !inside || !dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, (uint32_t)(k < SIDE ? k : SIDE - 1));
        }
    return (float)lit / (float)(width_px * width_px);
}

static void test_lookup(void **state)
{
    const fixture         *f   = *state;
    const vxs_baked_light *sun = vxs_asset_light(f->asset, 0), *moon = vxs_asset_light(f->asset, 1);
    rng                    r      = {7};
    int                    partly = 0;
    for (int n = 0; n < 30000; n++) {
        int32_t i = rng_between(&r, -10, SIDE + 9), j = rng_between(&r, -10, SIDE + 9), k = rng_between(&r, -10, SIDE + 9);
        int     width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
        double  p[3];
        ws_from_vx(p, i + rng_below(&r, 16) / 16.0, j + rng_below(&r, 16) / 16.0, k + rng_below(&r, 16) / 16.0);
        float wanted = lit_fraction(&f->sample, i, j, k, width_px);
        assert_true(vxs_lookup(sun, p, NULL, vxs_box(width_px)) == wanted);
        partly += wanted > 0 && wanted < 1;
        /* the moon's volume ends at the map */
        assert_true(vxs_lookup(moon, p, NULL, vxs_box(width_px)) == (k < 0 || k >= SIDE ? VXS_OUTSIDE : wanted));
    }
    assert_in_range(partly, 3000, 30000);
}

static void test_smooth_lookup(void **state)
{
    const fixture         *f   = *state;
    const vxs_baked_light *sun = vxs_asset_light(f->asset, 0), *moon = vxs_asset_light(f->asset, 1);
    rng                    r      = {17};
    int                    partly = 0;
    for (int n = 0; n < 30000; n++) {
        double  u = rng_between(&r, -1000, 16 * SIDE + 1000) / 1024.0 * 64, v = uniform(&r, -3, SIDE + 3);
        int32_t k     = rng_between(&r, -10, SIDE + 9);
        int     width = rng_between(&r, 1, VXS_FILTER_MAX), outside = u < 0 || v < 0 || u >= SIDE || v >= SIDE;
        double  p[3];
        ws_from_vx(p, u, v, k + 0.5);
        if (fabs(256 * v - rint(256 * v)) < 1e-6) continue;
        float wanted = outside ? VXS_OUTSIDE : smooth_fraction(&f->sample, u, v, k, width);
        assert_true(vxs_lookup(sun, p, NULL, vxs_smooth(width)) == wanted);
        assert_true(vxs_lookup(moon, p, NULL, vxs_smooth(width)) == (k < 0 || k >= SIDE ? VXS_OUTSIDE : wanted));
        partly += wanted > 0 && wanted < 1;
    }
    assert_in_range(partly, 3000, 30000);
}

/* A step of 1/1024 texel changes a smooth box by no more than two steps of its border; a plain one jumps. */
static void test_smooth_lookup_is_smooth(void **state)
{
    const fixture         *f        = *state;
    const vxs_baked_light *sun      = vxs_asset_light(f->asset, 0);
    rng                    r        = {18};
    float                  box_jump = 0;
    for (int n = 0; n < 300; n++) {
        double v = uniform(&r, 10, SIDE - 10), u = uniform(&r, 10, SIDE - 12), depth = uniform(&r, 0, SIDE), p[3];
        int    width     = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
        float  before[2] = {-2, -2};
        for (int step = 0; step < 2048; step++) {
            ws_from_vx(p, u + step / 1024.0, v, depth);
            float box = vxs_lookup(sun, p, NULL, vxs_box(width)), smooth = vxs_lookup(sun, p, NULL, vxs_smooth(width));
            if (before[0] >= 0) box_jump = fmaxf(box_jump, fabsf(box - before[0]));
            if (before[1] >= 0) assert_true(fabsf(smooth - before[1]) <= 1.0f / 256 / (float)width + 1e-6f);
            before[0] = box;
            before[1] = smooth;
        }
    }
    assert_true(box_jump > 0.3f);
}

/* A solid that ends in a wall along the light: texels whose centre is in it are shadowed. On the wall, whatever part of a texel it
 * cuts off, a filter that is moved along its normal sees none of it. */
static void test_wall_along_the_light(void **state)
{
    (void)state;
    static const uint32_t root[] = {0x1111}; /* children of x = 0 are shadowed, the others lit */
    vxs_baked_light       baked  = {.words = root, .word_count = 1};
    baked.light                  = (vxs_light){.kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                                               .levels       = 8,
                                               .coding       = VXS_CODING_DAG,
                                               .texel_metres = 1,
                                               .voxel_metres = 1,
                                               .ls_from_ws   = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    assert_true(vxs_lookup(&baked, (double[3]){127.5, 50, 9}, NULL, vxs_box(1)) == 0);
    assert_true(vxs_lookup(&baked, (double[3]){128.5, 50, 9}, NULL, vxs_box(1)) == 1);
    for (int width = 1; width <= VXS_FILTER_MAX; width++)
        for (double wall = 127.505; wall < 128.5; wall += 0.01) {
            double point[3] = {wall, 50.25, 9.5};
            assert_true(vxs_lookup(&baked, point, (double[3]){1, 0, 0}, vxs_box(width)) == 1);
            assert_true(vxs_lookup(&baked, point, (double[3]){1, 0, 0}, vxs_smooth(width)) == 1);
            assert_true(vxs_lookup(&baked, point, NULL, vxs_smooth(width)) < 1);
        }
}

static void test_lookup_with_normal(void **state)
{
    const fixture         *f     = *state;
    const vxs_baked_light *light = vxs_asset_light(f->asset, 0);
    rng                    r     = {8};
    for (int n = 0; n < 10000; n++) {
        double  p[3], normal[3], length = 0;
        int     width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
        int32_t voxel[3];
        ws_from_vx(p, rng_between(&r, -100, 700) / 10.0, rng_between(&r, -100, 700) / 10.0, rng_between(&r, -100, 700) / 10.0);
        for (int k = 0; k < 3; k++) normal[k] = rng_between(&r, -100, 100);
        for (int k = 0; k < 3; k++) length += normal[k] * normal[k];
        for (int k = 0; k < 3; k++) normal[k] = length > 0 ? normal[k] / sqrt(length) : 0;
        vxs_voxel(&light->light, p, normal, vxs_box(width_px), voxel);
        assert_true(vxs_lookup(light, p, normal, vxs_box(width_px)) ==
                    lit_fraction(&f->sample, voxel[0], voxel[1], voxel[2], width_px));
    }
}

static void test_lookup_far_away(void **state)
{
    const fixture         *f     = *state;
    const vxs_baked_light *light = vxs_asset_light(f->asset, 0);
    double                 p[3];
    ws_from_vx(p, 20.5, 20.5, -1e12);
    assert_true(vxs_lookup(light, p, NULL, vxs_box(9)) == 1);
    ws_from_vx(p, 20.5, 20.5, 1e12);
    assert_true(vxs_lookup(light, p, NULL, vxs_box(9)) == lit_fraction(&f->sample, 20, 20, SIDE - 1, 9));
    assert_true(vxs_lookup(light, (double[3]){1e300, 0, 5}, NULL, vxs_box(17)) == VXS_OUTSIDE);
    assert_true(vxs_lookup(light, (double[3]){5, 0, -1e300}, NULL, vxs_box(17)) == VXS_OUTSIDE);
    assert_true(vxs_lookup(light, (double[3]){(double)NAN, 0, 5}, NULL, vxs_box(1)) == VXS_OUTSIDE);
}

static void test_lookup_many(void **state)
{
    enum { COUNT = 500 };
    const fixture         *f     = *state;
    const vxs_baked_light *light = vxs_asset_light(f->asset, 0);
    rng                    r     = {9};
    static double          points[3 * COUNT], normals[3 * COUNT];
    static float           lit[COUNT + 1];
    for (int n = 0; n < COUNT; n++) {
        ws_from_vx(points + 3 * n, rng_between(&r, -40, 680) / 10.0, rng_between(&r, -40, 680) / 10.0,
                   rng_between(&r, 0, 640) / 10.0);
        normals[3 * n + rng_below(&r, 3)] = rng_below(&r, 2) ? 1 : -1;
    }
    for (int with_normals = 0; with_normals < 2; with_normals++) {
        lit[COUNT] = 77;
        vxs_lookup_many(light, points, with_normals ? normals : NULL, COUNT, vxs_box(5), lit);
        for (int n = 0; n < COUNT; n++)
            assert_true(lit[n] == vxs_lookup(light, points + 3 * n, with_normals ? normals + 3 * n : NULL, vxs_box(5)));
        assert_true(lit[COUNT] == 77);
    }
    vxs_lookup_many(light, NULL, NULL, 0, vxs_box(5), NULL);
}

/* spot and point lights -------------------------------------------------------------------------------------------------------- */

/* 0 when a coordinate is so near a whole number that rounding may decide. */
static int clear_of_boundaries(const double *coordinates)
{
    for (int n = 0; n < 3; n++)
        if (fabs(coordinates[n] - rint(coordinates[n])) < 1e-6 * fmax(1, fabs(coordinates[n]) * 1e-3)) return 0;
    return 1;
}

/* From light space to the world and back, for all maps of all kinds, and that the place is the one of the format's text. */
static void test_punctual_voxel_and_point(void **state)
{
    (void)state;
    rng r                         = {21};
    int asked[PUNCTUAL_SHAPES][6] = {{0}};
    for (int n = 0; n < 60000; n++) {
        punctual_shape shape = (punctual_shape)(n % PUNCTUAL_SHAPES);
        punctual       l     = random_punctual(&r, shape);
        int            map   = rng_between(&r, 0, map_count(&l.light) - 1);
        double         side = ldexp(1, (int)l.light.levels), width = shape == SPOT ? tan(l.cone_rad) * 0.7 : 0.999;
        double         at[3], point[3], found[3];
        for (int c = 0; c < 2; c++) at[c] = side / 2 + uniform(&r, -width, width) / l.light.texel_metres;
        at[2] = uniform(&r, -2, side + 2);
        vxs_point(&l.light, map, at, point);
        place(&l, map, point, found);
        for (int c = 0; c < 3; c++) assert_true(fabs(found[c] - at[c]) < 1e-6 * side);
        if (!clear_of_boundaries(at)) continue;
        int32_t voxel[3];
        l.light.cos_outer = 0; /* the cone has a test of its own; one map is queried within it */
        int answer        = vxs_voxel(&l.light, point, NULL, vxs_box(1), voxel);
        if (shape == WIDE_SPOT && answer < 0) continue; /* behind the light */
        assert_int_equal(answer, map);
        for (int c = 0; c < 3; c++) assert_true(fabs(floor(at[c]) - voxel[c]) == 0);
        asked[shape][map]++;
    }
    for (int shape = 0; shape < PUNCTUAL_SHAPES; shape++)
        for (int map = 0; map < 6; map++)
            if (shape != SPOT || map == 0) assert_true(asked[shape][map] > 1000 || (shape == WIDE_SPOT && map == 5));
}

/* The sun's, too. */
static void test_sun_voxel_and_point(void **state)
{
    const fixture   *f     = *state;
    const vxs_light *light = &vxs_asset_light(f->asset, 0)->light;
    rng              r     = {22};
    for (int n = 0; n < 10000; n++) {
        double  at[3], point[3], wanted[3];
        int32_t voxel[3];
        for (int c = 0; c < 3; c++) at[c] = rng_between(&r, 0, SIDE - 1) + uniform(&r, 0.001, 0.999);
        vxs_point(light, 0, at, point);
        ws_from_vx(wanted, at[0], at[1], at[2]);
        for (int c = 0; c < 3; c++) assert_true(fabs(point[c] - wanted[c]) < 1e-9);
        assert_int_equal(vxs_voxel(light, point, NULL, vxs_box(1), voxel), 0);
        for (int c = 0; c < 3; c++) assert_int_equal(voxel[c], (int32_t)at[c]);
    }
}

/* The six maps as things in the world: each looks along an axis of light space, is right-handed, and has no direction nearer
 * another map's. */
static void test_cube_maps(void **state)
{
    (void)state;
    rng r = {23};
    for (int n = 0; n < 300; n++) {
        punctual l    = random_punctual(&r, POINT);
        double   side = ldexp(1, (int)l.light.levels), ahead[6][3];
        for (int map = 0; map < 6; map++) {
            double middle[3], across[3], down[3], handed[3];
            vxs_point(&l.light, map, (double[3]){side / 2, side / 2, 10.5}, middle);
            vxs_point(&l.light, map, (double[3]){side / 2 + 1, side / 2, 10.5}, across);
            vxs_point(&l.light, map, (double[3]){side / 2, side / 2 + 1, 10.5}, down);
            for (int c = 0; c < 3; c++) {
                ahead[map][c] = middle[c] - l.at[c];
                across[c] -= middle[c];
                down[c] -= middle[c];
            }
            make_unit(ahead[map]), make_unit(across), make_unit(down);
            cross(across, down, handed);
            assert_true(dot(handed, ahead[map]) > 1 - 1e-9);
            double along = dot(ahead[map], l.axis[map / 2]);
            assert_true(fabs(along - (map % 2 ? -1 : 1)) < 1e-9);
        }
        for (int k = 0; k < 100; k++) {
            double  direction[3], point[3], best = -2, next = -2;
            int     nearest = 0;
            int32_t voxel[3];
            random_direction(&r, direction);
            for (int c = 0; c < 3; c++) point[c] = l.at[c] + 3 * direction[c];
            for (int map = 0; map < 6; map++) {
                double d = dot(ahead[map], direction);
                next     = fmax(next, fmin(d, best));
                nearest  = d > best ? map : nearest;
                best     = fmax(best, d);
            }
            if (best - next < 1e-9) continue;
            assert_int_equal(vxs_voxel(&l.light, point, NULL, vxs_box(1), voxel), nearest);
            /* inside the border that is kept for filters */
            double border = side / 2 - 1 / l.light.texel_metres;
            for (int c = 0; c < 2; c++) assert_true(voxel[c] >= floor(border - 1e-6) && voxel[c] < ceil(side - border + 1e-6));
        }
    }
}

/* On both sides of an edge of the cube a point is as deep, and beside it is the same border. */
static void test_cube_edges(void **state)
{
    (void)state;
    rng r = {24};
    for (int n = 0; n < 3000; n++) {
        punctual l = random_punctual(&r, POINT);
        int      a = rng_between(&r, 0, 2), b = (a + rng_between(&r, 1, 2)) % 3, c = 3 - a - b;
        double   sign_a = rng_below(&r, 2) ? 1 : -1, sign_b = rng_below(&r, 2) ? 1 : -1, depth = uniform(&r, 0.1, 50);
        double   ls[2][3], point[2][3], found[2][3];
        ls[0][a] = ls[1][b] = depth * (1 + 1e-9);
        ls[0][b] = ls[1][a] = depth;
        for (int k = 0; k < 2; k++) {
            int32_t voxel[3];
            ls[k][a] *= sign_a, ls[k][b] *= sign_b;
            ls[k][c] = depth * 0.99 * uniform(&(rng){(uint64_t)n}, -1, 1);
            for (int w = 0; w < 3; w++)
                point[k][w] = l.at[w] + ls[k][0] * l.axis[0][w] + ls[k][1] * l.axis[1][w] + ls[k][2] * l.axis[2][w];
            int map = vxs_voxel(&l.light, point[k], NULL, vxs_box(1), voxel);
            place(&l, map, point[k], found[k]);
            assert_true(fabs(voxel[2] - floor(found[k][2])) <= (clear_of_boundaries(found[k]) ? 0 : 1));
            if (depth < 1) continue;
            int wanted = k ? 2 * b + (sign_b < 0) : 2 * a + (sign_a < 0);
            assert_int_equal(map, wanted);
        }
        assert_true(fabs(found[0][2] - found[1][2]) < 1e-4);
    }
}

/* Exactly as large: the first axis wins. */
static void test_cube_ties(void **state)
{
    (void)state;
    dag_sample none = {.levels = 6};
    vxs_light  l    = dag_sample_punctual(&none, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE).light;
    memcpy(l.ls_from_ws, (double[12]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, sizeof l.ls_from_ws);
    static const struct {
        double point[3];
        int    map;
    } cases[] = {{{1, 1, 1}, 0},  {{-1, 1, 1}, 1}, {{-1, -1, -1}, 1}, {{0, 1, 1}, 2},    {{0.5, -1, 1}, 3},     {{0.5, -1, -1}, 3},
                 {{1, 0, -1}, 0}, {{0, 0, 1}, 4},  {{0, 0, -1}, 5},   {{-0.0, 0, 0}, 0}, {{1, 1, 1.0000001}, 4}};
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        int32_t voxel[3];
        assert_int_equal(vxs_voxel(&l, cases[n].point, NULL, vxs_box(1), voxel), cases[n].map);
    }
}

/* Cone and range, by angles and distances of the world. */
static void test_punctual_volume(void **state)
{
    (void)state;
    rng r     = {25};
    int in[2] = {0};
    for (int n = 0; n < 60000; n++) {
        punctual l = random_punctual(&r, (punctual_shape)(n % PUNCTUAL_SHAPES));
        double   way[3], point[3], distance = pow(10, uniform(&r, -3, 3)), handed[3];
        int32_t  voxel[3];
        if (n % 2) l.light.range_metres = pow(10, uniform(&r, -3, 3));
        if (n % 7 == 0) l.light.range_metres = distance * uniform(&r, 0.9, 1.1);
        random_direction(&r, way);
        if (n % 5) /* mostly near the edge of the cone */
            for (int c = 0; c < 3; c++) way[c] = l.axis[2][c] * cos(l.cone_rad) + l.axis[0][c] * sin(l.cone_rad) + 0.2 * way[c];
        make_unit(way);
        for (int c = 0; c < 3; c++) point[c] = l.at[c] + distance * way[c];
        cross(l.axis[2], way, handed);
        double angle = atan2(sqrt(dot(handed, handed)), dot(l.axis[2], way));
        if (fabs(angle - l.cone_rad) < 1e-6 || fabs(distance / l.light.range_metres - 1) < 1e-6) continue;
        if (distance < 1e-2 && fabs(angle - l.cone_rad) < 1e-3) continue; /* far from the origin a light's place is rounded */
        int inside = angle <= l.cone_rad && (l.light.range_metres == 0 || distance <= l.light.range_metres);
        assert_int_equal(vxs_voxel(&l.light, point, NULL, vxs_box(1), voxel) >= 0, inside);
        assert_int_equal(vxs_voxel(&l.light, point, l.axis[1], vxs_box(9), voxel) >= 0,
                         inside); /* a bias does not leave the volume */
        in[inside]++;
    }
    assert_true(in[0] > 5000 && in[1] > 5000);
}

/* Where the format has six roots: lookups of a sample whose maps are known. */
typedef struct punctual_asset {
    dag_sample      sample;
    vxs_asset      *asset;
    vxs_baked_light baked; /* a copy, to be changed */
} punctual_asset;

static punctual_asset punctual_asset_make(uint32_t levels, uint32_t kind, uint32_t flags, uint64_t seed)
{
    punctual_asset a = {0};
    rng            r = {seed};
    dag_sample_init(&a.sample, &r, levels, 100);
    vxs_write_light light = dag_sample_punctual(&a.sample, "lamp", kind, flags);
    vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes       file  = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_int_equal(vxs_asset_open(&a.asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    a.baked = *vxs_asset_light(a.asset, 0);
    return a;
}

static void punctual_asset_free(punctual_asset *a)
{
    vxs_asset_close(a->asset);
    dag_sample_free(&a->sample);
}

static float punctual_fraction(const dag_sample *s, const int32_t voxel[3], int width_px)
{
    int32_t side = 1 << s->levels, k = voxel[2] < side ? voxel[2] : side - 1;
    if (k < 0) return 1;
    int lit = 0, half_px = width_px / 2;
    for (int32_t y = voxel[1] - half_px; y <= voxel[1] + half_px; y++)
        for (int32_t x = voxel[0] - half_px; x <= voxel[0] + half_px; x++) {
            int inside = x >= 0 && y >= 0 && x < side && y < side;
            lit += !inside || !dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, (uint32_t)k);
        }
    return (float)lit / (float)(width_px * width_px);
}

/* A filter takes all its texels from the point's own map, however near the next one is; tiny maps are all border. */
static void test_punctual_lookup(void **state)
{
    static const struct {
        uint32_t kind, flags;
    } shapes[] = {{VXS_LIGHT_KIND_SPOT, 0}, {VXS_LIGHT_KIND_SPOT, VXS_LIGHT_CUBE}, {VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE}};
    (void)state;
    int partly = 0, asked = 0;
    for (uint32_t levels = 3; levels <= 6; levels++)
        for (size_t shape = 0; shape < 3; shape++) {
            punctual_asset a        = punctual_asset_make(levels, shapes[shape].kind, shapes[shape].flags, 40 + levels);
            double         side     = (double)(1 << levels);
            rng            r        = {levels};
            a.baked.light.cos_outer = 0;
            for (int map = 0; map < map_count(&a.baked.light); map++) {
                dag_sample_show(&a.sample, (uint32_t)map);
                for (int n = 0; n < 3000; n++) {
                    int     width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2), edge = n % 2;
                    double  at[3], point[3], normal[3];
                    int32_t voxel[3];
                    for (int c = 0; c < 2; c++) at[c] = edge && rng_below(&r, 2) ? uniform(&r, 0, 2) : uniform(&r, 0, side);
                    for (int c = 0; c < 2; c++) at[c] = edge && rng_below(&r, 2) ? side - at[c] : at[c];
                    at[2] = uniform(&r, -3, side + 10);
                    vxs_point(&a.baked.light, map, at, point);
                    if (!clear_of_boundaries(at) || vxs_voxel(&a.baked.light, point, NULL, vxs_box(width_px), voxel) != map)
                        continue;
                    for (int c = 0; c < 3; c++) assert_int_equal(voxel[c], (int32_t)floor(at[c]));
                    float wanted = punctual_fraction(&a.sample, voxel, width_px);
                    assert_true(vxs_lookup(&a.baked, point, NULL, vxs_box(width_px)) == wanted);
                    partly += wanted > 0 && wanted < 1;
                    asked++;
                    int width = width_px - (width_px > 1 && n % 4 < 2); /* odd and even */
                    if (clear_of_boundaries((double[3]){256 * at[0], 256 * at[1], 0.5}))
                        assert_true(vxs_lookup(&a.baked, point, NULL, vxs_smooth(width)) ==
                                    smooth_fraction(&a.sample, at[0], at[1], voxel[2], width));
                    random_direction(&r, normal);
                    vxs_voxel(&a.baked.light, point, normal, vxs_box(width_px), voxel);
                    assert_true(voxel[0] >= 0 && voxel[0] < (int32_t)side && voxel[1] >= 0 && voxel[1] < (int32_t)side);
                    assert_true(vxs_lookup(&a.baked, point, normal, vxs_box(width_px)) ==
                                punctual_fraction(&a.sample, voxel, width_px));
                }
            }
            punctual_asset_free(&a);
        }
    assert_true(asked > 50000 && partly > 10000);
}

/* The light itself, and what is all but there. */
static void test_punctual_own_place(void **state)
{
    (void)state;
    punctual_asset a = punctual_asset_make(6, VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE, 50),
                   b = punctual_asset_make(6, VXS_LIGHT_KIND_SPOT, 0, 51);
    for (int width_px = 1; width_px <= VXS_FILTER_MAX; width_px += 2)
        for (int n = 0; n < 7; n++) {
            double normal[3] = {n == 0, n == 1, n == 2}, point[3] = {1, 2, 3};
            if (n > 2) normal[n % 3] = -1;
            assert_true(vxs_lookup(&a.baked, point, n == 6 ? NULL : normal, vxs_box(width_px)) == 1);
            assert_true(vxs_lookup(&b.baked, point, n == 6 ? NULL : normal, vxs_box(width_px)) == 1);
            point[0] -= 1e-15; /* ahead, nearer than anything */
            assert_true(vxs_lookup(&a.baked, point, n == 6 ? NULL : normal, vxs_box(width_px)) == 1);
            assert_true(vxs_lookup(&b.baked, point, n == 6 ? NULL : normal, vxs_box(width_px)) == 1);
        }
    punctual_asset_free(&a);
    punctual_asset_free(&b);
}

static int is_fraction(float lit)
{
    return lit == VXS_OUTSIDE || (lit >= 0 && lit <= 1);
}

/* Every number that a file or a caller may bring: no answer that is none, and (under a sanitizer) no byte that is
 * not the asset's. */
static void test_punctual_extremes(void **state)
{
    static const double numbers[] = {0, -0.0, 5e-324, -5e-324, 1e-300, -1e-160, 1, -1, 1e8, -1e155, 1e300, -1.7e308, 1.7e308};
    enum { NUMBERS = sizeof numbers / sizeof *numbers };
    (void)state;
    rng r = {52};
    for (int shape = 0; shape < 3; shape++) {
        punctual_asset a =
            punctual_asset_make(4, shape < 2 ? VXS_LIGHT_KIND_SPOT : VXS_LIGHT_KIND_POINT, shape ? VXS_LIGHT_CUBE : 0, 53);
        for (int n = 0; n < 100000; n++) {
            vxs_baked_light baked = a.baked;
            vxs_light      *l     = &baked.light;
            double          point[3], normal[3];
            int32_t         voxel[3];
            for (int c = 0; c < 3; c++) point[c] = rng_below(&r, 2) ? numbers[rng_below(&r, NUMBERS)] : uniform(&r, -9, 9);
            for (int c = 0; c < 3; c++) normal[c] = numbers[rng_below(&r, NUMBERS)];
            if (n % 3 == 0) l->ls_from_ws[rng_below(&r, 12)] = numbers[rng_below(&r, NUMBERS)];
            if (n % 5 == 0) l->texel_metres = fabs(numbers[2 + rng_below(&r, NUMBERS - 2)]);
            if (n % 7 == 0) l->voxel_metres = fabs(numbers[2 + rng_below(&r, NUMBERS - 2)]);
            if (n % 11 == 0) l->near_metres = fabs(numbers[2 + rng_below(&r, NUMBERS - 2)]);
            if (n % 13 == 0) l->range_metres = fabs(numbers[rng_below(&r, NUMBERS)]);
            if (n % 17 == 0 && shape < 2) l->cos_outer = rng_below(&r, 2) ? 0 : 0.99999999999;
            int width_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
            int map      = vxs_voxel(l, point, n % 2 ? normal : NULL, vxs_box(width_px), voxel);
            assert_true(map >= -1 && map < map_count(l));
            assert_true(voxel[0] >= 0 && voxel[0] < 16 && voxel[1] >= 0 && voxel[1] < 16);
            assert_true(is_fraction(vxs_lookup(&baked, point, n % 2 ? normal : NULL, vxs_box(width_px))));
        }
        for (int c = 0; c < 3; c++) {
            double point[3] = {0, 2, 3};
            point[c]        = (double)NAN;
            assert_true(vxs_lookup(&a.baked, point, NULL, vxs_box(9)) == VXS_OUTSIDE);
            assert_true(vxs_lookup(&a.baked, (double[3]){0, 2, 3}, point, vxs_box(9)) >= 0); /* a normal that is none */
        }
        punctual_asset_free(&a);
    }
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
        cmocka_unit_test(test_a_file_is_told_by_its_head),
        cmocka_unit_test(test_open_refuses_bad_bytes),
        cmocka_unit_test(test_failing_allocations),
        cmocka_unit_test(test_memory_limit_counts_the_file),
        cmocka_unit_test(test_voxel),
        cmocka_unit_test(test_lookup),
        cmocka_unit_test(test_smooth_lookup),
        cmocka_unit_test(test_smooth_lookup_is_smooth),
        cmocka_unit_test(test_wall_along_the_light),
        cmocka_unit_test(test_lookup_with_normal),
        cmocka_unit_test(test_lookup_far_away),
        cmocka_unit_test(test_lookup_many),
        cmocka_unit_test(test_punctual_voxel_and_point),
        cmocka_unit_test(test_sun_voxel_and_point),
        cmocka_unit_test(test_cube_maps),
        cmocka_unit_test(test_cube_edges),
        cmocka_unit_test(test_cube_ties),
        cmocka_unit_test(test_punctual_volume),
        cmocka_unit_test(test_punctual_lookup),
        cmocka_unit_test(test_punctual_own_place),
        cmocka_unit_test(test_punctual_extremes),
        cmocka_unit_test(test_result_text),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
