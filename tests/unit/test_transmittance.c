/* Maps of transmittance curves (vxs_transmittance.h) on llvmpipe against what capsules leave of light along each texel's ray, in
 * double (tests/volumes/smoke_scene.h): lists, sorted or not, lists without room, streaming in tiles; a sun, a spot and a point
 * light; before opaque casters; lookups; misuse, and no number that is none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "transmittance_maps.h"

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* One capsule at a time, thick, thin, about a punctual light and beside it: what is stored is what it leaves, at any depth, on each
 * texel's ray. */
static void test_single_capsules(void **state)
{
    (void)state;
    static texel_ray  ray;
    const vxs_capsule one[] = {{{2, 4, 1}, 1.5F, {2, 4, 1}, 0.5F},
                               {{-3, 2, -2}, 0.3F, {4, 5, 3}, 2},
                               {{0.5F, 2.5F, -0.3F}, 0.8F, {0.5F, 2.5F, 1}, 0.7F},
                               {{-1, 8.5F, 0.5F}, 0.7F, {-1, 1, 0.5F}, 1},
                               {{1, 0, 1}, 1e-3F, {1, 9, 1.2F}, 100},
                               {{-9, 1, -9}, 6, {9, 1, 9}, 0.05F}};
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int how = 0; how < WAYS; how++) {
            if (!asks(light, how)) continue;
            vxs_transmittance_map *map    = map_of(light, how);
            texels                 t      = texels_of(light, NODES);
            double                 square = 0, most = 0;
            uint32_t               asked = 0, met = 0;
            for (size_t n = 0; n < sizeof one / sizeof *one; n++) {
                rng r = {n};
                build(map, &one[n], 1, NULL, &t);
                for (size_t texel = 0; texel < t.count; texel++) {
                    trace(&t, texel, &one[n], 1, &ray);
                    for (int k = 0; k < 3; k++) {
                        double depth = depth_of(&ray, &r), error = curve_at(&t, texel, depth, 1) - left_at(&ray, depth);
                        square += error * error;
                        most = fmax(most, fabs(error));
                        asked++;
                        met += ray.count > 0;
                    }
                }
            }
            print_message("light %d, %s: %u of %u depths are on rays that meet a capsule, RMS %.1e, %.1e at most\n", light,
                          way_names[how], met, asked, sqrt(square / asked), most);
            assert_true(met > 400 && sqrt(square / asked) < 1e-4 && most < 5e-3);
            free(t.curves);
        }
}

/* Behind all smoke, with hair in it: the product of all that a ray meets, however curves are built, and where lists have no room,
 * too. And what is counted. */
static void test_t_last(void **state)
{
    (void)state;
    static texel_ray   ray;
    static vxs_capsule smoke[CAPSULES];
    uint32_t           crowded = 0;
    make_smoke(smoke);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int how = 0; how < WAYS; how++) {
            if (!asks(light, how)) continue;
            vxs_transmittance_map *map    = map_of(light, how);
            texels                 t      = texels_of(light, NODES);
            double                 square = 0, most = 0;
            size_t                 met = 0;
            build(map, smoke, CAPSULES, NULL, &t);
            vxs_transmittance_counts counts = vxs_transmittance_map_counts(map);
            for (size_t texel = 0; texel < t.count; texel++) {
                trace(&t, texel, smoke, CAPSULES, &ray);
                double error = curve_end(&t, texel) - left_at(&ray, 1e3);
                square += error * error;
                most = fmax(most, fabs(error));
                met += ray.count;
            }
            print_message("light %d, %s: %u segments, %u merged; t_last RMS %.1e, %.1e at most\n", light, way_names[how],
                          counts.segments, counts.merged, sqrt(square / (double)t.count), most);
            assert_true(sqrt(square / (double)t.count) < 1e-4 && most < 5e-3 && met > 150);
            if (how == STREAMED)
                assert_true(counts.segments == 0 && counts.merged == 0);
            else {
                assert_true(fabs((double)counts.segments - (double)met) <= 1e-3 * (double)met); /* some graze a ray */
                assert_int_equal(counts.merged, how == CROWDED && counts.segments > 500 ? counts.segments - 500 : 0);
                crowded += counts.merged;
            }
            free(t.curves);
        }
    assert_true(crowded > 1000);
}

static int by_entry(const void *a, const void *b)
{
    double x = ((const smoke_part *)a)->entry, y = ((const smoke_part *)b)->entry;
    return (x > y) - (x < y);
}

/* Texels whose curves are those of C, which inserts what the ray meets by depth. Of nodes that bend a curve alike either may go, as
 * rounding has it: what is compared is what curves say at the nodes of both. */
static uint32_t texels_as_in_c(const texels *t, const vxs_capsule *smoke)
{
    static texel_ray ray;
    uint32_t         same = 0;
    for (size_t texel = 0; texel < t->count; texel++) {
        vxs_curve c   = vxs_curve_empty();
        double    off = 0;
        trace(t, texel, smoke, CAPSULES, &ray);
        qsort(ray.parts, ray.count, sizeof *ray.parts, by_entry);
        for (size_t n = 0; n < ray.count; n++) {
            const smoke_part *p = &ray.parts[n];
            vxs_curve_insert(&c, (int)t->nodes, (p->entry - ray.begin) / ray.metres, (p->exit - ray.begin) / ray.metres,
                             exp(-p->extinction * (p->exit - p->entry)));
        }
        for (int n = 0; n < c.count; n++) {
            double behind = c.depth[n] + 1e-4;
            off           = fmax(off, fabs(curve_at(t, texel, behind, 0) - vxs_curve_at(&c, behind, 0)));
        }
        for (size_t n = 0; n < t->nodes; n++) {
            double behind = (double)t->curves[2 * (texel * t->nodes + n)] + 1e-4;
            if (behind < 1e9) off = fmax(off, fabs(curve_at(t, texel, behind, 0) - vxs_curve_at(&c, behind, 0)));
        }
        same += off < 1e-3;
    }
    return same;
}

/* Sorted, curves are those of C, and the same to the bit in whatever order capsules come. */
static void test_order_of_capsules(void **state)
{
    (void)state;
    static vxs_capsule smoke[CAPSULES];
    make_smoke(smoke);
    vxs_transmittance_map *map   = map_of(SCENE_SPOT, SORTED);
    texels                 first = texels_of(SCENE_SPOT, NODES), second = texels_of(SCENE_SPOT, NODES);
    build(map, smoke, CAPSULES, NULL, &first);
    for (int n = 0; n < CAPSULES / 2; n++) {
        vxs_capsule swap        = smoke[n];
        smoke[n]                = smoke[CAPSULES - 1 - n];
        smoke[CAPSULES - 1 - n] = swap;
    }
    build(map, smoke, CAPSULES, NULL, &second);
    assert_memory_equal(first.curves, second.curves, first.count * 2 * first.nodes * sizeof *first.curves);
    uint32_t same = texels_as_in_c(&first, smoke);
    print_message("%u of %zu curves are those of C\n", same, first.count);
    assert_true(same > 0.93 * (double)first.count);
    free(first.curves);
    free(second.curves);
}

/* Balls about one texel's ray, in lists of so much room, or without (0): what is left behind them all, or it is reported that a
 * driver cut the list. */
static void check_balls(uint32_t count, uint32_t room, uint32_t unsorted, int may_cut)
{
    enum { MOST = 70000 };
    static vxs_capsule     smoke[MOST];
    static smoke_part      parts[MOST];
    shadow_depth_map       m    = {.light = vxs_asset_light(s.asset, SCENE_SUN)->light, .side = 1, .layers = 1};
    vxs_transmittance_desc desc = {
        .baked_number = vxs_baked_number(SCENE_SUN), .side_px = 1, .capsules = count, .segments = room, .unsorted = unsorted};
    vxs_capsules           list = {.list = smoke, .count = count};
    vxs_transmittance_map *map;
    double                 from[3], way[3];
    float                  curve[2 * NODES];
    uint32_t               thin = 0;
    rng                    r    = {5};
    shadow_depth_map_ray(&m, 0, 0, 0, from, way);
    for (uint32_t n = 0; n < count; n++) {
        double along = uniform(&r, 0, 20);
        smoke[n] = (vxs_capsule){.radius_metres = (float)uniform(&r, 0.3, 0.6), .extinction = (float)uniform(&r, 0, 6.0 / count)};
        for (int i = 0; i < 3; i++)
            smoke[n].begin[i] = smoke[n].end[i] = (float)(from[i] + along * way[i] + uniform(&r, -0.1, 0.1));
    }
    for (int i = 0; i < 3; i++) from[i] -= 100 * way[i];
    assert_int_equal(smoke_parts(smoke, count, from, way, parts), count);
    double left = smoke_left(parts, count, 1e3);
    assert_int_equal(vxs_transmittance_map_create(&map, s.volumes, &desc), VXS_OK);
    assert_int_equal(vxs_transmittance_map_build(map, &list, NULL), VXS_OK);
    vxs_transmittance_counts counts = vxs_transmittance_map_counts(map);
    s.gl->GetNamedBufferSubData(vxs_transmittance_map_buffer(map), 16, sizeof curve, curve);
    double error = fabs((double)curve[2 * NODES - 1] - left); /* each of so many factors is rounded to a float */
    print_message("%u segments, %u merged, %u texels cut: %.6f of %.6f is left\n", counts.segments, counts.merged,
                  counts.cut_texels, (double)curve[2 * NODES - 1], left);
    for (uint32_t n = 0; n < count; n++) thin += smoke[n].extinction * 1.2F < 0x1p-22F; /* exp may round to 1: nothing is there */
    uint32_t least = room ? count - thin : 0;
    assert_true(counts.segments >= least && counts.segments <= (room ? count : 0));
    assert_true(counts.merged == (room && counts.segments > room ? counts.segments - room : 0));
    assert_true(left > 0.05 && left < 0.5);
    assert_true(counts.cut_texels ? may_cut && counts.cut_texels == 1 : error < 2e-4);
    vxs_transmittance_map_destroy(map);
}

/* All of a texel's, in lists with room and without; and more than llvmpipe can take, which ends an invocation's loops after 65535
 * rounds in all. */
static void test_10000_segments_in_a_texel(void **state)
{
    (void)state;
    check_balls(10000, 100, 0, 0);
    check_balls(30000, 30000, 0, 0);
    check_balls(10000, 10000, 1, 0);
    check_balls(50000, 50000, 0, 1);
    check_balls(10000, 0, 0, 0);
    check_balls(70000, 0, 0, 1);
}

/* Errors over depth fall with nodes; streaming in the order of capsules does not fall far behind. */
static void test_errors_by_nodes(void **state)
{
    (void)state;
    static texel_ray   ray;
    static vxs_capsule smoke[CAPSULES];
    make_smoke(smoke);
    for (int how = SORTED; how < WAYS; how += STREAMED) {
        double rms[2];
        for (uint32_t k = 0; k < 2; k++) {
            uint32_t               nodes  = k ? 16 : 4;
            vxs_transmittance_map *map    = map_make(SCENE_SPOT, (way_to_build)how, nodes);
            texels                 t      = texels_of(SCENE_SPOT, nodes);
            double                 square = 0;
            rng                    r      = {3};
            build(map, smoke, CAPSULES, NULL, &t);
            for (size_t texel = 0; texel < t.count; texel++) {
                trace(&t, texel, smoke, CAPSULES, &ray);
                for (int n = 0; n < DEPTHS; n++) {
                    double depth = depth_of(&ray, &r);
                    square += pow(curve_at(&t, texel, depth, 0) - left_at(&ray, depth), 2);
                }
            }
            rms[k] = sqrt(square / (double)t.count / DEPTHS);
            free(t.curves);
            vxs_transmittance_map_destroy(map);
        }
        print_message("%s: RMS %.4f with 4 nodes, %.4f with 16\n", way_names[how], rms[0], rms[1]);
        assert_true(rms[0] < 0.12 && rms[1] < 0.04 && rms[1] < 0.5 * rms[0]);
    }
}

/* Light ends where what is opaque begins, and before that it is as without. */
static void test_opaque(void **state)
{
    (void)state;
    static texel_ray   ray;
    static vxs_capsule smoke[CAPSULES];
    smoke_make(SMOKE_COLUMNS, smoke, CAPSULES, 1);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int how = 0; how < WAYS; how++) {
            if (how == CROWDED || !asks(light, how)) continue;
            static float           first[6 * 32 * 32];
            vxs_shadow_depth_map  *opaque = opaque_map(light);
            vxs_transmittance_map *map    = map_of(light, how);
            texels                 t      = texels_of(light, NODES);
            uint32_t               dark = 0, met = 0;
            rng                    r     = {4};
            double                 scale = light == SCENE_SUN ? t.map.light.voxel_metres : 1, square = 0;
            s.gl->GetTextureImage(vxs_shadow_depth_map_texture(opaque), 0, GL_RED, GL_FLOAT, sizeof first, first);
            build(map, smoke, CAPSULES, opaque, &t);
            for (size_t texel = 0; texel < t.count; texel++) {
                size_t x = (texel % SIDE * 2 + 1) * 32 / (2 * SIDE), y = (texel / SIDE % SIDE * 2 + 1) * 32 / (2 * SIDE),
                       face = texel / (SIDE * SIDE);
                float  at   = first[(face * 32 + y) * 32 + x];
                double end  = at < 1e30F ? scale * (double)at : 1e29;
                trace(&t, texel, smoke, CAPSULES, &ray);
                for (size_t n = 0; n < ray.count; n++) met += (ray.parts[n].entry - ray.begin) / ray.metres < end;
                for (int k = 0; k < 4; k++) {
                    double depth = k ? depth_of(&ray, &r) : end + uniform(&r, -1, 1), found = curve_at(&t, texel, depth, 0);
                    if (fabs(depth - end) < 1e-3) continue;
                    square += pow(found - (depth < end ? left_at(&ray, depth) : 0), 2);
                    if (depth > end) assert_true(found == 0);
                    dark += depth > end;
                }
                if (end < 1e29) assert_true(curve_end(&t, texel) == 0);
            }
            print_message("light %d, %s: RMS %.4f, %u of them dark\n", light, way_names[how], sqrt(square / (double)t.count / 4),
                          dark);
            assert_true(sqrt(square / (double)t.count / 4) < 0.03 && dark > 100);
            vxs_transmittance_counts counts = vxs_transmittance_map_counts(map);
            if (how != STREAMED)
                assert_true(fabs((double)counts.segments - (double)met) <= 1e-3 * (double)met); /* no more is captured */
            free(t.curves);
            vxs_shadow_depth_map_destroy(opaque);
        }
}

/* Each pixel, by lines and exponentials, equals the result in C for the same curves. */
static void test_lookups(void **state)
{
    (void)state;
    static vxs_capsule smoke[CAPSULES];
    static double      metres[PIXELS];
    static float       left[PIXELS];
    const vxs_medium   haze   = {{0.01, 0.01, 0.01}, {0.01, 0.01, 0.01}, 0};
    const double       eye[3] = {9, 6, 7}, to[3] = {0, 2, 0};
    volumes_camera     c = camera_at(eye, to, 0.9);
    GLuint             texture;
    smoke_make(SMOKE_COLUMNS, smoke, CAPSULES, 1);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    s.gl->TextureStorage2D(texture, 1, GL_R32F, WIDE, HIGH);
    vxs_volumes_frame frame = scene_frame(&s, &c, &haze, 1e30, 60, metres);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_transmittance_map *map = map_of(light, light == SCENE_SPOT ? SORTED : STREAMED);
        texels                 t   = texels_of(light, NODES);
        build(map, smoke, CAPSULES, NULL, &t);
        for (int how = 0; how < 2; how++) {
            double   square = 0;
            uint32_t partly = 0, nothing = 0;
            assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
            assert_int_equal(vxs_volumes_transmittance(s.volumes, map, texture, (vxs_curve_lookup)how), VXS_OK);
            s.gl->GetTextureImage(texture, 0, GL_RED, GL_FLOAT, sizeof left, left);
            for (uint32_t n = 0; n < PIXELS; n++) {
                double direction[3], ws[3];
                camera_ray(&s, &c, n % WIDE, n / WIDE, direction);
                for (int i = 0; i < 3; i++) ws[i] = eye[i] + metres[n] * direction[i];
                double wanted = metres[n] < 60 ? look_up(&t, ws, how) : 1;
                square += pow((double)left[n] - wanted, 2);
                partly += wanted > 0.05 && wanted < 0.95;
                nothing += metres[n] >= 60;
            }
            print_message("light %d, %s: RMS %.1e; %u pixels in half a shadow, %u see nothing\n", light,
                          how ? "exponentials" : "lines", sqrt(square / PIXELS), partly, nothing);
            assert_true(sqrt(square / PIXELS) < 1e-4 && partly > 100 && nothing > 20);
        }
        free(t.curves);
    }
}

static void test_misuse(void **state)
{
    (void)state;
    vxs_transmittance_map *map   = NULL;
    const vxs_capsule      one   = {{0, 1, 0}, 1, {0, 1, 0}, 1};
    vxs_capsules           smoke = {.list = &one, .count = 1}, none = {.count = 0}, lost = {.count = 1},
                 many       = {.list = &one, .count = CAPSULES + 1};
    const vxs_medium haze   = {{0.01, 0.01, 0.01}, {0.01, 0.01, 0.01}, 0};
    const double     eye[3] = {9, 6, 7}, to[3] = {0, 2, 0};
    volumes_camera   c = camera_at(eye, to, 0.9);
    for (int n = 0; n < 7; n++) {
        vxs_transmittance_desc bad = desc_of(n == 0 ? SCENE_LIGHTS : 0, SORTED, n == 1 ? 5 : 8);
        if (n == 2) bad.side_px = 8193;
        if (n == 3) bad.capsules = 0;
        if (n == 4) bad.capsules = (1 << 24) + 1;
        if (n == 5) bad.struct_size = 1;
        if (n == 6) bad.baked_number = 0;
        assert_int_equal(vxs_transmittance_map_create(&map, s.volumes, &bad), VXS_E_ARGUMENT);
        assert_null(map);
    }
    vxs_transmittance_desc large = desc_of(0, SORTED, 16);
    large.side_px                = 8192;
    assert_int_equal(vxs_transmittance_map_create(&map, s.volumes, &large), VXS_E_GL);
    assert_null(map);
    vxs_transmittance_map_destroy(NULL);
    map                         = map_make(SCENE_SUN, STREAMED, 0);
    vxs_shadow_depth_map *other = opaque_map(SCENE_SPOT);
    assert_int_equal(vxs_transmittance_map_build(map, &many, NULL), VXS_E_ARGUMENT);
    assert_int_equal(vxs_transmittance_map_build(map, &lost, NULL), VXS_E_ARGUMENT);
    assert_int_equal(vxs_transmittance_map_build(map, &smoke, other), VXS_E_ARGUMENT);
    assert_int_equal(vxs_transmittance_map_build(map, &none, NULL), VXS_OK);
    vxs_volumes_frame frame = scene_frame(&s, &c, &haze, 1e30, 60, NULL);
    assert_int_equal(vxs_volumes_begin(s.volumes, &(vxs_volumes_frame){0}), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_transmittance(s.volumes, map, s.depths, VXS_CURVE_LINES), VXS_E_ARGUMENT); /* no frame */
    assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
    assert_int_equal(vxs_volumes_transmittance(s.volumes, map, 0, VXS_CURVE_LINES), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_transmittance(s.volumes, map, s.depths, (vxs_curve_lookup)2), VXS_E_ARGUMENT);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
    vxs_shadow_depth_map_destroy(other);
    vxs_transmittance_map_destroy(map);
}

/* Capsules of any numbers: read_curves sees that all nodes are numbers, in order. What is no capsule changes nothing. */
static void test_any_numbers(void **state)
{
    (void)state;
    static vxs_capsule smoke[CAPSULES];
    rng                r     = {9};
    const float        odd[] = {0, -1, NAN, INFINITY, -INFINITY, 1e30F, 1e-30F, 1e13F};
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int how = CROWDED; how < WAYS; how++) {
            if (!asks(light, how)) continue;
            vxs_transmittance_map *map = map_of(light, how);
            texels                 t   = texels_of(light, NODES);
            for (uint32_t k = 0; k < repeats(1, 100); k++) {
                for (int n = 0; n < CAPSULES; n++) {
                    float numbers[8];
                    for (int i = 0; i < 8; i++) {
                        double size = exp(uniform(&r, -12, 12));
                        numbers[i]  = (float)(i % 4 == 3 ? size : size * uniform(&r, -1, 1));
                        if (!rng_below(&r, 40)) numbers[i] = odd[rng_below(&r, 8)];
                    }
                    memcpy(&smoke[n], numbers, sizeof numbers);
                }
                build(map, smoke, CAPSULES, NULL, &t);
            }
            for (int n = 0; n < CAPSULES; n++) {
                smoke[n] = (vxs_capsule){{0, 1, 0}, 1, {0, 1, 0}, 1};
                if (n % 2)
                    smoke[n].radius_metres = odd[n / 2 % 5];
                else
                    smoke[n].begin[n / 2 % 3] = odd[2 + n / 6 % 4];
                if (n % 3 == 0) smoke[n].extinction = odd[n / 3 % 5];
            }
            build(map, smoke, CAPSULES, NULL, &t);
            for (size_t n = 0; n < t.count; n++) assert_true(curve_end(&t, n) == 1);
            free(t.curves);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_single_capsules),   cmocka_unit_test(test_t_last),
        cmocka_unit_test(test_order_of_capsules), cmocka_unit_test(test_10000_segments_in_a_texel),
        cmocka_unit_test(test_errors_by_nodes),   cmocka_unit_test(test_opaque),
        cmocka_unit_test(test_lookups),           cmocka_unit_test(test_misuse),
        cmocka_unit_test(test_any_numbers),
    };
    return cmocka_run_group_tests(tests, open_scene, close_scene);
}
