/* Quads that smoke is drawn by (baker/lab/render/smoke_pass.h): whatever ray meets a capsule, in double, passes its quad; from back
 * to front; and scenes far from the world's origin are as fine as others.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/smoke_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "tests/volumes/smoke_scene.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { CAPSULES = 200, EYES = 6, RAYS = 1000 };

static vxs_capsule list[CAPSULES];
static float       albedos[CAPSULES][3];
static scene_smoke smoke = {.origin_ws = {100000, -20, 3e6}, .count = CAPSULES, .list = list, .albedos = albedos};

static double between(rng *r, double low, double high)
{
    return low + (high - low) * rng_unit(r);
}

static int make_smoke(void **state)
{
    (void)state;
    rng r = {5};
    for (int n = 0; n < CAPSULES; n++) {
        list[n] = (vxs_capsule){.radius_metres = (float)exp(between(&r, -4, 1)), .extinction = 1};
        for (int k = 0; k < 3; k++) {
            list[n].begin[k] = (float)between(&r, -10, 10);
            list[n].end[k]   = list[n].begin[k] + (n % 3 ? (float)between(&r, -4, 4) : 0);
        }
        albedos[n][0] = (float)n;
    }
    return 0;
}

/* Whether a ray from the eye passes a quad: where it meets its plane, measured along its sides. */
static int passes(const float (*corners)[4], const double way[3])
{
    double at[3][3], u[3], v[3], normal[3], place[3];
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++) at[c][k] = (double)corners[c][k];
    vec3_sub(at[1], at[0], u);
    vec3_sub(at[2], at[0], v);
    vec3_cross(u, v, normal);
    double metres = vec3_dot(at[0], normal) / vec3_dot(way, normal);
    for (int k = 0; k < 3; k++) place[k] = metres * way[k] - at[0][k];
    double across = vec3_dot(place, u) / vec3_dot(u, u), up = vec3_dot(place, v) / vec3_dot(v, v);
    return metres > 0 && across > -1e-6 && across < 1 + 1e-6 && up > -1e-6 && up < 1 + 1e-6;
}

/* A direction of the view. */
static void random_way(const smoke_eye *eye, rng *r, double way[3])
{
    double across = between(r, -1, 1), up = between(r, -1, 1);
    for (int k = 0; k < 3; k++) way[k] = eye->seen.forward[k] + across * eye->seen.right[k] + up * eye->seen.up[k];
    vec3_unit(way, way);
}

/* Rays of a view.   Returns how many capsules they met */
static uint32_t check_rays(const smoke_quads *q, const smoke_eye *eye, rng *r)
{
    static const double here[3] = {0, 0, 0};
    uint32_t            met     = 0;
    for (int n = 0; n < RAYS; n++) {
        double way[3];
        random_way(eye, r, way);
        for (uint32_t k = 0; k < q->count; k++) {
            smoke_part part;
            if (!smoke_parts(&q->capsules[k].capsule, 1, here, way, &part)) continue;
            if (!passes((const float(*)[4])q->corners + SMOKE_CORNERS * k, way))
                fail_msg("a ray meets capsule %u beside its quad", k);
            met++;
        }
    }
    return met;
}

static void test_rays_pass_quads(void **state)
{
    (void)state;
    smoke_quads q;
    run_context m = {0};
    rng         r = {6};
    assert_int_equal(smoke_quads_reserve(&q, &smoke, &m), VXS_OK);
    for (int n = 0; n < EYES; n++) {
        camera_pose pose = {.fov_degrees = 70};
        for (int k = 0; k < 3; k++) {
            pose.eye_ws[k]    = smoke.origin_ws[k] + between(&r, -8, 8) * (n ? 1 : 4); /* most are among them */
            pose.target_ws[k] = smoke.origin_ws[k] + between(&r, -3, 3);
        }
        smoke_eye eye = {.seen = camera_view_of(&pose, 1.5), .pixel_metres = 0.01};
        memcpy(eye.at_ws, pose.eye_ws, sizeof eye.at_ws);
        smoke_quads_make(&q, &smoke, &eye);
        uint32_t met    = check_rays(&q, &eye, &r);
        double   before = INFINITY;
        for (uint32_t k = 0; k < q.count; k++) {
            const vxs_capsule *c = &q.capsules[k].capsule;
            double             middle[3];
            for (int i = 0; i < 3; i++) middle[i] = 0.5 * ((double)c->begin[i] + (double)c->end[i]);
            double metres = sqrt(vec3_dot(middle, middle));
            assert_true(metres <= before + 1e-4 && (double)c->radius_metres >= 0.0049 * metres);
            before = metres;
        }
        print_message("eye %d: %u capsules are met by %d rays\n", n, met, RAYS);
        assert_true(met > 200);
    }
    smoke_quads_free(&q);
}

/* What it takes of a beam that is wider than it is, while that is little: extinction times volume. */
static double taken(const vxs_capsule *c)
{
    double length = (double)c->end[1] - (double)c->begin[1], radius = (double)c->radius_metres;
    return (double)c->extinction * M_PI * radius * radius * (length + 4.0 / 3 * radius);
}

/* As wide as a sample, and as much of it: a hair, a short piece, a grain. */
static void test_thin_ones_are_widened(void **state)
{
    (void)state;
    const float lengths[] = {1, 0.01F, 0};
    for (int n = 0; n < 3; n++) {
        const vxs_capsule hair = {{0, 2, 0}, 0.001F, {0, 2 + lengths[n], 0}, 400};
        vxs_capsule       wide = smoke_widened(hair, 0.01), same = smoke_widened(hair, 0.0005);
        assert_true(fabs((double)wide.radius_metres - 0.01) < 1e-9 && fabs(taken(&wide) / taken(&hair) - 1) < 1e-5);
        assert_memory_equal(&hair, &same, sizeof hair);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rays_pass_quads),
        cmocka_unit_test(test_thin_ones_are_widened),
    };
    return cmocka_run_group_tests(tests, make_smoke, NULL);
}
