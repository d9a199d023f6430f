/* Lookups of many points at once: each is what vxs_lookup says of it, bit for bit, whatever the layout of points and of answers,
 * and whoever their neighbours are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "lookup_many_scalar.h"
#include "query_lights.h"
#include "tests/unit/repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { POINTS = 700 };

/* Points as a caller may have them, with something in front of them that moves them off their alignment. */
typedef struct points {
    char        bytes[POINTS * 64 + 64];
    vxs_vectors vectors;
} points;

static void put_point(points *p, size_t n, const double *at)
{
    float single[3] = {(float)at[0], (float)at[1], (float)at[2]};
    char *to        = (char *)p->vectors.data + n * p->vectors.stride_bytes;
    memcpy(to, p->vectors.type == VXS_F32 ? (const void *)single : at, p->vectors.type == VXS_F32 ? sizeof single : 3 * sizeof *at);
}

static void get_point(const points *p, size_t n, double *at)
{
    float       single[3];
    const char *from = (const char *)p->vectors.data + n * p->vectors.stride_bytes;
    memcpy(at, from, p->vectors.type == VXS_F32 ? 0 : 3 * sizeof *at);
    memcpy(single, from, p->vectors.type == VXS_F32 ? sizeof single : 0);
    for (int axis = 0; axis < 3 && p->vectors.type == VXS_F32; axis++) at[axis] = single[axis];
}

static void random_layout(rng *r, points *p)
{
    p->vectors.type         = rng_below(r, 2) ? VXS_F32 : VXS_F64;
    p->vectors.stride_bytes = (p->vectors.type == VXS_F32 ? 12 : 24) + rng_below(r, 30);
    p->vectors.data         = p->bytes + rng_below(r, 9);
}

/* Coordinates of a light's map that may go wrong: anywhere near it, about borders of texels, far away, and no numbers at all. */
static void wild_point(rng *r, const vxs_light *light, double *at)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e30, -1e30, 1e300, 1e-300, 0};
    double              side  = ldexp(1, (int)light->levels), c[3];
    for (int axis = 0; axis < 3; axis++) {
        c[axis] = (rng_u32(r) / 4294967296.0 * 1.4 - 0.2) * side;
        if (!rng_below(r, 4)) c[axis] = rng_between(r, -1, (int32_t)side + 1);
    }
    vxs_point(light, (int)rng_below(r, vxs_map_count(light)), c, at);
    if (!rng_below(r, 12)) at[rng_below(r, 3)] = bad[rng_below(r, sizeof bad / sizeof *bad)];
    if (!rng_below(r, 12)) at[rng_below(r, 3)] *= 1e10;
}

/* The next of points that lie near one another, in texels and voxels of a map. */
static void next_point(rng *r, const vxs_light *light, int map, double *c, double *at)
{
    double side = ldexp(1, (int)light->levels), step = rng_below(r, 40) ? 3 : side;
    for (int axis = 0; axis < 3; axis++) {
        c[axis] += (rng_u32(r) / 4294967296.0 - 0.5) * step;
        if (!(c[axis] > -2 && c[axis] < side + 2)) c[axis] = side / 2;
    }
    vxs_point(light, map, c, at);
}

static void random_normal(rng *r, double *n)
{
    double length = 0;
    for (int axis = 0; axis < 3; axis++) n[axis] = rng_below(r, 3) ? rng_between(r, -100, 100) : 0;
    for (int axis = 0; axis < 3; axis++) length += n[axis] * n[axis];
    for (int axis = 0; axis < 3; axis++) n[axis] = length > 0 ? n[axis] / sqrt(length) : 0;
    if (!rng_below(r, 100)) n[rng_below(r, 3)] = rng_below(r, 2) ? NAN : 1e20;
}

static void fill_points(rng *r, const vxs_light *light, points *p, points *normals, size_t count)
{
    int    near = rng_below(r, 4) != 0, map = (int)rng_below(r, vxs_map_count(light));
    double c[3] = {-9, -9, -9}, at[3], normal[3];
    for (size_t n = 0; n < count; n++) {
        if (near)
            next_point(r, light, map, c, at);
        else
            wild_point(r, light, at);
        random_normal(r, normal);
        put_point(p, n, at);
        put_point(normals, n, normal);
    }
}

/* One call for all lights; every answer where it belongs, and nothing else written. */
static uint32_t check_batch(rng *r, const vxs_baked_light *lights, uint32_t light_count,
                            vxs_result (*look_up)(const vxs_baked_light *, uint32_t, const vxs_batch *))
{
    static points p, normals;
    static float  lit[LIGHTS * POINTS * 3 + 8];
    uint32_t      partly = 0;
    size_t        count  = rng_below(r, 3) ? rng_below(r, POINTS + 1) : rng_below(r, 70);
    random_layout(r, &p);
    random_layout(r, &normals);
    fill_points(r, &lights[rng_below(r, light_count)].light, &p, &normals, count);
    vxs_batch b = {
        .points_ws = p.vectors, .count = count, .filter = vxs_box(1 + 2 * rng_between(r, 0, VXS_FILTER_MAX / 2)), .lit = lit};
    if (rng_below(r, 2)) b.normals_ws = normals.vectors;
    if (rng_below(r, 3) == 0) b.filter = vxs_box(9);
    if (rng_below(r, 3) == 0) b.filter = vxs_box(1);
    if (rng_below(r, 6) == 0) b.filter = vxs_box(rng_between(r, -2, VXS_FILTER_MAX + 3));
    if (rng_below(r, 6) == 0) b.filter = vxs_smooth(rng_between(r, -2, VXS_FILTER_MAX + 3));
    size_t apart = 1 + rng_below(r, 3), from_light = count * apart;
    int    interleaved = (int)rng_below(r, 2); /* the lights of a point side by side */
    if (apart > 1 || rng_below(r, 2)) b.lit_stride_bytes = apart * sizeof *lit;
    if (interleaved) {
        apart                = light_count;
        from_light           = 1;
        b.lit_stride_bytes   = apart * sizeof *lit;
        b.light_stride_bytes = sizeof *lit;
    }

    for (size_t n = 0; n < sizeof lit / sizeof *lit; n++) lit[n] = 77;
    assert_int_equal(look_up(lights, light_count, &b), VXS_OK);
    for (uint32_t l = 0; l < light_count; l++)
        for (size_t n = 0; n < count; n++) {
            double at[3], normal[3];
            get_point(&p, n, at);
            get_point(&normals, n, normal);
            float  wanted = vxs_lookup(&lights[l], at, b.normals_ws.data ? normal : NULL, b.filter);
            float *found  = &lit[n * apart + l * from_light];
            if (memcmp(found, &wanted, sizeof wanted))
                fail_msg("light %u, point %zu of %zu, filter %d, smooth %d: %g, expected %g", l, n, count, b.filter.width_px,
                         b.filter.is_smooth, (double)*found, (double)wanted);
            partly += wanted > 0 && wanted < 1;
            *found = 77;
        }
    for (size_t n = 0; n < sizeof lit / sizeof *lit; n++) assert_true(lit[n] == 77);
    return partly;
}

static void test_blocks(void **state)
{
    (void)state;
    static const uint32_t levels[] = {3, 5, 8, 9, 11, 15, 16};
    for (size_t n = 0; n < sizeof levels / sizeof *levels; n++) {
        blocks_sample   s;
        rng             r = {n};
        vxs_baked_light lights[LIGHTS];
        uint32_t        partly = 0;
        blocks_sample_init(&s, &r, levels[n], levels[n] < 11 ? 6 : 1, 8);
        uint32_t light_count = s.map_count == 6 ? LIGHTS : 3;
        for (uint32_t l = 0; l < light_count; l++) lights[l] = blocks_light(s.words, levels[n], (int)l);
        for (uint32_t round = 0; round < repeats(60, 1000); round++) {
            partly += check_batch(&r, lights, light_count, vxs_lookup_batch);
            partly += check_batch(&r, lights, light_count, scalar_lookup_batch);
        }
        assert_in_range(partly, 1000, UINT32_MAX);
        for (uint32_t page = 0; page < s.page_count; page += 2) s.words[8 + page] = 0;
        for (uint32_t round = 0; round < repeats(20, 200); round++) check_batch(&r, lights, light_count, vxs_lookup_batch);
        blocks_sample_free(&s);
    }
}

static void test_dags(void **state)
{
    (void)state;
    for (uint32_t levels = 3; levels <= 8; levels++) {
        dag_sample s;
        rng        r = {levels};
        vxs_asset *asset;
        uint32_t   partly = 0;
        dag_sample_init(&s, &r, levels, levels < 5 ? 20 : 200);
        asset = dag_asset(&s);
        for (uint32_t round = 0; round < repeats(60, 1000); round++)
            partly += check_batch(&r, vxs_asset_light(asset, 0), vxs_asset_light_count(asset), vxs_lookup_batch);
        assert_in_range(partly, 1000, UINT32_MAX);
        vxs_asset_close(asset);
        dag_sample_free(&s);
    }
}

static void test_arguments(void **state)
{
    (void)state;
    blocks_sample s;
    rng           r = {1};
    blocks_sample_init(&s, &r, 5, 1, 1);
    vxs_baked_light light    = blocks_light(s.words, 5, 0);
    double          point[3] = {0, 5, 3};
    float           lit      = 77;
    vxs_batch       good     = {.points_ws = {.data = point}, .count = 1, .filter = vxs_box(3), .lit = &lit}, b;
    b                        = good;
    b.lit                    = NULL;
    assert_int_equal(vxs_lookup_batch(&light, 1, &b), VXS_E_ARGUMENT);
    b                = good;
    b.points_ws.data = NULL;
    assert_int_equal(vxs_lookup_batch(&light, 1, &b), VXS_E_ARGUMENT);
    b                = good;
    b.points_ws.type = 2;
    assert_int_equal(vxs_lookup_batch(&light, 1, &b), VXS_E_ARGUMENT);
    b                 = good;
    b.normals_ws.type = 7;
    assert_int_equal(vxs_lookup_batch(&light, 1, &b), VXS_E_ARGUMENT);
    assert_int_equal(vxs_lookup_batch(NULL, 1, &good), VXS_E_ARGUMENT);
    assert_int_equal(vxs_lookup_batch(NULL, 0, &good), VXS_OK);
    b             = good;
    b.struct_size = 8;
    assert_int_equal(vxs_lookup_batch(&light, 1, &b), VXS_E_ARGUMENT);
    b       = good;
    b.count = 0;
    assert_int_equal(vxs_lookup_batch(&light, 1, &b), VXS_OK);
    assert_true(lit == 77);
    assert_int_equal(vxs_lookup_batch(&light, 1, &good), VXS_OK);
    assert_true(lit == vxs_lookup(&light, point, NULL, vxs_box(3)));
    blocks_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks),
        cmocka_unit_test(test_dags),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
