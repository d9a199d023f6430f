/* Alpha-tested triangles in depth maps against the definition of masks (baker/scene/scene.h), texel by texel: rays through
 * texel centres in double, the mask queried where they meet the triangle. Texels whose answer changes within a small step of the
 * image are not queried: there the shader's float may differ.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/scene/scene.h"
#include "runtime/vxs.h"
#include "tests/columns/stored_maps.h"
#include "tests/gl_choice.h"

#include <cmocka.h>

enum { SIDE = 256, IMAGE = 16, CARDS = 3, CARD_TRIANGLES = 2 * CARDS };

static gl_context *gl;

static int open_gl(void **state)
{
    run_context m = {0};
    (void)state;
    return gl_context_create(&gl, gl_choice(), 2, &m) == VXS_OK ? 0 : -1;
}

static int close_gl(void **state)
{
    (void)state;
    gl_context_destroy(gl);
    return 0;
}

/* Cards one behind the other, each turned a little, with masks of its own, and an opaque floor behind them all. */
typedef struct cards {
    double      positions[4 * (CARDS + 1)][3];
    uint32_t    indices[3 * (CARD_TRIANGLES + 2)];
    float       uvs[6 * CARD_TRIANGLES];
    uint8_t     pixels[CARDS][IMAGE * IMAGE / 2];
    alpha_image images[CARDS];
    alpha_mask  alpha_masks[CARDS];
    size_t      first[CARDS + 1];
    casters     c;
} cards;

static double unit(rng *r)
{
    return rng_u32(r) / 4294967296.0;
}

/* Corners in the order of a strip; z from near to far, wide enough to fill the map however it is seen. */
static void add_quad(cards *k, size_t quad, double z, double width, rng *r)
{
    for (size_t n = 0; n < 4; n++) {
        double *p = k->positions[4 * quad + n];
        p[0]      = (n & 1 ? width : -width) + unit(r);
        p[1]      = (n & 2 ? width : -width) + unit(r);
        p[2]      = z + (quad < CARDS ? 0.8 * unit(r) : 0);
    }
}

static void make_cards(cards *k, uint64_t seed)
{
    static const uint32_t corners[6] = {0, 1, 2, 2, 1, 3};
    rng                   r          = rng_split(seed, 3);
    memset(k, 0, sizeof *k);
    for (size_t quad = 0; quad <= CARDS; quad++) add_quad(k, quad, 2 + (double)quad, quad < CARDS ? 2.5 : 8, &r);

    /* sheets: the floor first, then the cards, a mask each */
    for (size_t n = 0; n < 6; n++) k->indices[n] = 4 * CARDS + corners[n];
    for (size_t card = 0; card < CARDS; card++) {
        double scale = 0.5 + 3 * unit(&r), shift = 4 * unit(&r) - 2;
        for (size_t n = 0; n < 6; n++) {
            k->indices[6 + 6 * card + n]   = (uint32_t)(4 * card) + corners[n];
            k->uvs[2 * (6 * card + n)]     = (float)(shift + scale * (corners[n] & 1));
            k->uvs[2 * (6 * card + n) + 1] = (float)(shift + scale * (corners[n] >> 1));
        }
        for (size_t n = 0; n < IMAGE * IMAGE / 2; n++) k->pixels[card][n] = (uint8_t)rng_below(&r, 256);
        k->images[card]      = (alpha_image){IMAGE, IMAGE / 2, k->pixels[card]};
        k->alpha_masks[card] = (alpha_mask){(uint32_t)card, (float)(0.3 + 0.4 * unit(&r)), (texture_wrap)((seed + card) % 3),
                                            (texture_wrap)((seed + card) / 3 % 3), rng_below(&r, 3) == 0};
        k->first[card]       = 2 + 2 * card;
    }
    k->first[CARDS] = 2 + CARD_TRIANGLES;
    k->c            = (casters){.vertex_count     = 4 * (CARDS + 1),
                                .positions_ws     = k->positions[0],
                                .triangle_count   = 2 + CARD_TRIANGLES,
                                .holed_first      = 2,
                                .indices          = k->indices,
                                .alpha_mask_count = CARDS,
                                .alpha_masks      = k->alpha_masks,
                                .alpha_mask_first = k->first,
                                .hole_uvs         = k->uvs,
                                .images           = k->images};
}

static vxs_light sun(void)
{
    return (vxs_light){.kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                       .levels       = 8,
                       .ls_from_ws   = {40, 0, 0, 128, 0, 40, 0, 128, 0, 0, 40, 0},
                       .texel_metres = 1.0 / 40,
                       .voxel_metres = 1.0 / 40,
                       .direction_ws = {0, 0, 1}};
}

/* Down the same way, from where the cards lie 2 to 5 m away. */
static vxs_light punctual(void)
{
    return (vxs_light){.kind         = VXS_LIGHT_KIND_SPOT,
                       .levels       = 8,
                       .ls_from_ws   = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                       .texel_metres = 1.0 / 150,
                       .voxel_metres = log(5.5) / 256,
                       .direction_ws = {0, 0, 1},
                       .near_metres  = 1,
                       .cos_outer    = 0.5};
}

/* Where a ray meets a triangle: metres along it, or 0; share [out] of its corners. */
static double meet(const double origin[3], const double way[3], const double *a, const double *b, const double *c, double share[3])
{
    double ab[3], ac[3], from_a[3], p[3], q[3];
    vec3_sub(b, a, ab);
    vec3_sub(c, a, ac);
    vec3_sub(origin, a, from_a);
    vec3_cross(way, ac, p);
    vec3_cross(from_a, ab, q);
    double det = vec3_dot(ab, p);
    share[1]   = vec3_dot(from_a, p) / det;
    share[2]   = vec3_dot(way, q) / det;
    share[0]   = 1 - share[1] - share[2];
    return share[0] >= 0 && share[1] >= 0 && share[2] >= 0 ? vec3_dot(ac, q) / det : 0;
}

/* 1 or 0: there is a surface or a hole; -1: the shader may see either. */
static int surface_at(const cards *k, size_t card, double u, double v)
{
    enum { STEPS = 1 };
    const double step  = 2e-4;
    int          found = alpha_mask_opaque(&k->alpha_masks[card], &k->images[card], u, v);
    for (int i = -STEPS; i <= STEPS; i++)
        for (int j = -STEPS; j <= STEPS; j++)
            if (alpha_mask_opaque(&k->alpha_masks[card], &k->images[card], u + i * step, v + j * step) != found) return -1;
    return found;
}

/* The nearest surface along a texel's ray, as a point; returns 0 when rounding may decide otherwise. */
static int nearest(const cards *k, const double origin[3], const double way[3], double *distance)
{
    *distance = INFINITY;
    for (size_t t = 0; t < k->c.triangle_count; t++) {
        const uint32_t *at = k->indices + 3 * t;
        double          share[3];
        double          d = meet(origin, way, k->positions[at[0]], k->positions[at[1]], k->positions[at[2]], share);
        if (fabs(share[0]) < 5e-3 || fabs(share[1]) < 5e-3 || fabs(share[2]) < 5e-3) return 0; /* an edge, or its line */
        if (d <= 0) continue;
        if (t >= 2) {
            const float *uv = k->uvs + 6 * (t - 2);
            double       u = 0, v = 0;
            for (size_t n = 0; n < 3; n++) {
                u += share[n] * (double)uv[2 * n];
                v += share[n] * (double)uv[2 * n + 1];
            }
            int surface = surface_at(k, (t - 2) / 2, u, v);
            if (surface < 0) return 0;
            if (!surface) continue;
        }
        *distance = fmin(*distance, d);
    }
    return 1;
}

static void compare_cards(vxs_light light, uint64_t seed, size_t *asked, size_t *through)
{
    cards           k;
    depth_renderer *r        = NULL;
    depth_maps      maps     = {0};
    run_context     m        = {0};
    int             punctual = light.kind != VXS_LIGHT_KIND_DIRECTIONAL;
    make_cards(&k, seed);
    assert_int_equal(depth_renderer_create(&r, gl, &k.c, &light, 0, EXIT_AUTO, 1, &m), VXS_OK);
    assert_int_equal(depth_maps_init(&maps, SIDE, SIDE, punctual ? light.voxel_metres : 0, 0, &m), VXS_OK);
    assert_int_equal(depth_renderer_tile(r, &maps, 0, 0, &m), VXS_OK);
    for (size_t n = 0; n < SIDE * SIDE; n++) {
        double near[3], far[3], way[3], distance;
        vxs_point(&light, 0, (const double[]){(double)(n % SIDE) + 0.5, (double)(n / SIDE) + 0.5, 0}, near);
        vxs_point(&light, 0, (const double[]){(double)(n % SIDE) + 0.5, (double)(n / SIDE) + 0.5, SIDE}, far);
        vec3_sub(far, near, way);
        double length = sqrt(vec3_dot(way, way));
        vec3_unit(way, way);
        if (!nearest(&k, near, way, &distance)) continue;
        double z        = near[2] + distance * way[2];
        double expected = punctual ? log(z / light.near_metres) / light.voxel_metres : distance / length * SIDE;
        double found    = stored_voxels(&maps, maps.enter[n]);
        if (!(fabs(found - expected) < 0.05))
            print_error("seed %d texel %zu: depth %g voxels, expected %g\n", (int)seed, n, found, expected);
        assert_true(fabs(found - expected) < 0.05);
        *asked += 1;
        *through += z > 4.9; /* the floor, through every hole in the way */
    }
    depth_maps_free(&maps);
    depth_renderer_destroy(r);
}

static void compare_many(vxs_light light)
{
    size_t asked = 0, through = 0;
    for (uint64_t seed = 0; seed < 9; seed++) compare_cards(light, seed, &asked, &through);
    assert_true(asked > 9 * SIDE * SIDE / 2);
    assert_true(through > asked / 50 && through < asked / 2);
}

static void masks_in_a_flat_map(void **state)
{
    (void)state;
    compare_many(sun());
}

static void masks_in_a_perspective_map(void **state)
{
    (void)state;
    compare_many(punctual());
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masks_in_a_flat_map),
        cmocka_unit_test(masks_in_a_perspective_map),
    };
    return cmocka_run_group_tests_name("holes_pass", tests, open_gl, close_gl);
}
