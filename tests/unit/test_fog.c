/* Fog in the light of baked lights (baker/lab/picture/fog.h) against many single lookups along each ray.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "baker/lab/picture/fog.h"
#include "baker/light/map_space.h"
#include "query_lights.h"
#include "random_light.h"
#include "runtime/vxs.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { STEPS = 8000 };

static double phase_of(double g, double cosine)
{
    return (1 - g * g) / (4 * M_PI * pow(1 + g * g - 2 * g * cosine, 1.5));
}

/* Of one channel, what a place of the ray scatters toward the eye in a metre, were it lit. */
static double scattered_at(const fog_medium *f, const fog_light *l, const double eye[3], const double w[3], double x, double from)
{
    double p[3], way[3], dot = 0, square = 0, along = 0, strength = 1, behind = 1, sigma = f->extinction[0];
    for (int i = 0; i < 3; i++) {
        p[i]   = eye[i] + x * w[i];
        way[i] = p[i] - l->shape.position_ws[i];
        dot += way[i] * w[i];
        square += way[i] * way[i];
        along += way[i] * l->shape.direction_ws[i];
    }
    if (p[1] > f->top_ws) return 0;
    if (l->shape.kind == LIGHT_DIRECTIONAL) {
        double cosine = 0;
        for (int i = 0; i < 3; i++) cosine -= w[i] * l->shape.direction_ws[i];
        behind = f->top_ws < INFINITY ? (f->top_ws - p[1]) / -l->shape.direction_ws[1] : 0;
        return f->scattering[0] * phase_of(f->anisotropy, cosine) * exp(-sigma * (x - from + behind));
    }
    double r = sqrt(square), outer = cos(l->shape.outer_rad);
    if (l->shape.range_metres < INFINITY) behind = fmax(1 - pow(r / l->shape.range_metres, 4), 0);
    if (l->shape.kind == LIGHT_SPOT) strength = fmin(fmax((along / r - outer) / (l->cos_inner - outer), 0), 1);
    return f->scattering[0] * phase_of(f->anisotropy, -dot / r) * exp(-sigma * (x + r)) / square * strength * strength * behind;
}

/* By single lookups.   all  [out] were there no shadows */
static double march(const fog_medium *f, const fog_light *l, const double eye[3], const double w[3], double metres, double *all)
{
    double sum = 0, from = 0;
    *all = 0;
    if (f->top_ws < eye[1]) from = w[1] < 0 ? (f->top_ws - eye[1]) / w[1] : metres;
    for (int n = 0; n < STEPS; n++) {
        double x = metres * (n + 0.5) / STEPS, p[3], light = scattered_at(f, l, eye, w, x, from) * metres / STEPS;
        for (int i = 0; i < 3; i++) p[i] = eye[i] + x * w[i];
        float lit = vxs_lookup(l->light, p, NULL, vxs_box(1));
        *all += light;
        if (lit == 1 || (lit == VXS_OUTSIDE && l->shape.kind == LIGHT_DIRECTIONAL)) sum += light;
    }
    return sum;
}

static void test_against_lookups(void **state)
{
    (void)state;
    rng        r      = {1};
    uint32_t   partly = 0;
    dag_sample s;
    dag_sample_init(&s, &r, 5, 60);
    vxs_asset *asset = dag_asset(&s);
    for (int n = 0; n < 1200; n++) {
        const vxs_baked_light *light = vxs_asset_light(asset, rng_below(&r, LIGHTS));
        fog_light  l = {.light = light, .shape = baked_light_shape(&light->light), .colour = {2, 3, 4}, .radius_metres = 1e-6};
        fog_medium f = {.anisotropy = uniform(&r, -0.8, 0.8), .top_ws = rng_below(&r, 3) ? INFINITY : uniform(&r, 0, 8)};
        double     eye[3], w[3], metres = uniform(&r, 0.1, 20), found[3] = {0}, all, ls[3];
        int        is_sun = l.shape.kind == LIGHT_DIRECTIONAL;
        l.cos_inner       = cos(0.6 * l.shape.outer_rad);
        if (!is_sun) f.top_ws = INFINITY;
        for (int i = 0; i < 3; i++) {
            eye[i]          = uniform(&r, -4, 12);
            f.extinction[i] = uniform(&r, 0, 0.3);
            f.scattering[i] = f.extinction[i] * rng_unit(&r);
        }
        random_direction(&r, w);
        for (int i = 0; i < 3; i++) ls[i] = l.shape.position_ws[i] - eye[i];
        double along = ls[0] * w[0] + ls[1] * w[1] + ls[2] * w[2];
        if (!is_sun && ls[0] * ls[0] + ls[1] * ls[1] + ls[2] * ls[2] - along * along < 0.05) continue; /* too sharp for steps */
        fog_add_airlight(&f, &l, 1, eye, w, metres, found);
        double wanted = march(&f, &l, eye, w, metres, &all);
        assert_true(isfinite(found[0]) && isfinite(found[1]) && isfinite(found[2]));
        assert_true(fabs(found[0] / 2 - wanted) <= 4e-3 * all + 1e-12);
        partly += wanted > 0.1 * all && wanted < 0.9 * all;
    }
    assert_true(partly > 200);
    vxs_asset_close(asset);
    dag_sample_free(&s);
}

/* What a level top leaves, at heights above and below it. */
static void test_left(void **state)
{
    (void)state;
    fog_medium f = {.extinction = {0, 0.1, 1e3}, .top_ws = 10};
    double     left[3], eye[3] = {0, 20, 0}, down[3] = {0, -1, 0}, up[3] = {0, 1, 0}, level[3] = {1, 0, 0};
    fog_left(&f, eye, down, 15, left);
    assert_true(left[0] == 1 && fabs(left[1] - exp(-0.5)) < 1e-12 && left[2] == 0);
    fog_left(&f, eye, up, 15, left);
    assert_true(left[0] == 1 && left[1] == 1 && left[2] == 1);
    fog_left(&f, eye, level, 15, left);
    assert_true(left[2] == 1);
    eye[1] = 0;
    fog_left(&f, eye, level, 15, left);
    assert_true(fabs(left[1] - exp(-1.5)) < 1e-12);
    fog_left(&f, eye, up, 15, left);
    assert_true(fabs(left[1] - exp(-1)) < 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_lookups), cmocka_unit_test(test_left)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
