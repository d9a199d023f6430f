/* Baked smoke in a .vxs file: written data is read back and looked up as formats/vxs.md section 15 has it, by curves that are
 * kept apart; what breaks a rule is refused with its finding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "alloc_fail.h"
#include "query_lights.h"
#include "random_light.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "format_parts.h"
#include "smoke_curves.h"

enum { LEVELS = 5, SOLE_LIGHT = 1 };

static const float first_metres[LIGHTS] = {-3, 0, 0.25F, 0.125F}, step_metres = 0.0003F;

/* A file of all kinds of lights, with smoke for those that `with` has a bit for. */
static vxs_bytes smoky_file(curve_maps samples[LIGHTS], uint32_t with)
{
    rng        r = {11};
    dag_sample d;
    dag_sample_init(&d, &r, LEVELS, 20);
    vxs_write_light lights[LIGHTS] = {dag_sample_light(&d, "sun"), dag_sample_light(&d, "moon"),
                                      dag_sample_punctual(&d, "spot", VXS_LIGHT_KIND_SPOT, 0),
                                      dag_sample_punctual(&d, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE)};
    vxs_write_desc  desc           = {.lights = lights, .light_count = LIGHTS, .zstd_level = 1};
    vxs_smoke_view  views[LIGHTS]  = {0};
    vxs_bytes       file = {0}, smoky = {0};
    vxs_contents    contents;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_int_equal(vxs_read(&contents, file.data, file.size_bytes, NULL), VXS_OK);
    for (int n = 0; n < LIGHTS; n++) {
        random_curves(&samples[n], &r, n == 3 ? VXS_CUBE_FACES : 1);
        if (with >> n & 1) views[n] = curves_view(&samples[n], first_metres[n], step_metres);
    }
    assert_int_equal(vxs_write_smoke(&smoky, file.data, file.size_bytes, &contents, views, 3), VXS_OK);
    vxs_contents_free(&contents);
    dag_sample_free(&d);
    free(file.data);
    return smoky;
}

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

static double curve_at(const curve_maps *s, size_t texel, double depth)
{
    const uint32_t *nodes = s->nodes + s->first[texel];
    double          left  = 65535;
    for (uint32_t n = 0; n < s->counts[texel] && (nodes[n] & 0xffff) <= depth; n++) {
        left = nodes[n] >> 16;
        if (n + 1 == s->counts[texel] || (nodes[n + 1] & 0xffff) <= depth) continue;
        double near = nodes[n] & 0xffff, far = nodes[n + 1] & 0xffff;
        left += (depth - near) / (far - near) * ((nodes[n + 1] >> 16) - left);
    }
    return left / 65535;
}

/* Places of dag_sample.h's lights by their words there: texels of 64 and metres.   Returns the map; -1: outside */
static int place_of(int light, const double *p, double *u, double *v, double *metres)
{
    double side = 1 << LEVELS, ls[3] = {p[2] - 3, p[1] - 2, 1 - p[0]}, *at[3] = {u, v, metres};
    if (light < 2) {
        *u      = 2 * (p[0] + 1);
        *v      = 2 * (p[2] - 2);
        *metres = 10 - p[1];
        return *u >= 0 && *v >= 0 && *u < side && *v < side ? 0 : -1;
    }
    int map = light == 2 ? 4 : 0;
    for (int axis = 0; axis < 3 && light == 3; axis++)
        if (fabs(ls[axis]) > fabs(ls[map / 2])) map = 2 * axis;
    if (light == 3) map += ls[map / 2] < 0;
    for (int n = 0; n < 3; n++) *at[n] = map_axes[map][n] < 'a' ? -ls[map_axes[map][n] - 'X'] : ls[map_axes[map][n] - 'x'];
    if (light == 2 && !(*metres >= 0.75 * sqrt(dot(ls, ls)))) return -1;
    *u = side / 2 + *u / *metres * side / 2;
    *v = side / 2 + *v / *metres * side / 2;
    return light == 2 ? 0 : map;
}

static double left_at(const curve_maps *s, int light, const double *p)
{
    double u, v, metres, left = 0;
    int    map = place_of(light, p, &u, &v, &metres);
    if (map < 0) return 1;
    u                = u * CURVES_SIDE / (1 << LEVELS) - 0.5;
    v                = v * CURVES_SIDE / (1 << LEVELS) - 0.5;
    double within[2] = {u - floor(u), v - floor(v)}, depth = (metres - (double)first_metres[light]) / (double)step_metres;
    for (int n = 0; n < 4; n++) {
        size_t x = (size_t)fmin(fmax(floor(u) + (n & 1), 0), CURVES_SIDE - 1),
               y = (size_t)fmin(fmax(floor(v) + (n >> 1), 0), CURVES_SIDE - 1);
        left += (n & 1 ? within[0] : 1 - within[0]) * (n > 1 ? within[1] : 1 - within[1]) *
                curve_at(s, (size_t)map * CURVES_A_MAP + 64 * (x / 8 + CURVES_SIDE / 8 * (y / 8)) + x % 8 + 8 * (y % 8), depth);
    }
    return left;
}

static void test_lookups_weigh_four_curves(void **state)
{
    (void)state;
    static curve_maps samples[LIGHTS];
    rng               r    = {3};
    vxs_bytes         file = smoky_file(samples, 15);
    vxs_asset        *asset;
    uint32_t          dimmed = 0, outside = 0;
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    for (int n = 0; n < 40000; n++) {
        int    light = n % LIGHTS;
        double p[3]  = {uniform(&r, -3, 18), uniform(&r, -12, 14), uniform(&r, 0, 20)};
        if (light >= 2) p[0] = uniform(&r, -7, 8), p[1] = uniform(&r, -6, 10), p[2] = uniform(&r, -6, 12);
        const vxs_light *l      = &vxs_asset_light(asset, (uint32_t)light)->light;
        double           wanted = left_at(&samples[light], light, p);
        double           found  = (double)vxs_smoke_lookup(l, vxs_asset_smoke(asset, (uint32_t)light), p);
        assert_true(fabs(found - wanted) < 1e-6);
        if (vxs_voxel(l, p, NULL, vxs_box(1), (int32_t[3]){0}) < 0 && l->kind != VXS_LIGHT_KIND_DIRECTIONAL)
            assert_true(found == 1);
        dimmed += wanted < 0.9;
        outside += wanted == 1;
    }
    assert_in_range(dimmed, 10000, 39000);
    assert_in_range(outside, 1000, 30000);
    vxs_asset_close(asset);
    free(file.data);
}

static void test_any_number_is_answered(void **state)
{
    (void)state;
    static curve_maps   samples[LIGHTS];
    static const double far[] = {0, -1e-310, 1, -1e30, 1e154, -1e300, INFINITY, -INFINITY, NAN};
    vxs_bytes           file  = smoky_file(samples, 15);
    vxs_asset          *asset;
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    for (uint32_t light = 0; light < LIGHTS; light++)
        for (int n = 0; n < 9 * 9 * 9; n++) {
            const double p[3] = {far[n % 9], far[n / 9 % 9], far[n / 81]};
            float        left = vxs_smoke_lookup(&vxs_asset_light(asset, light)->light, vxs_asset_smoke(asset, light), p);
            assert_true(left >= 0 && left <= 1);
        }
    vxs_asset_close(asset);
    free(file.data);
}

/* Of an asset with smoke for some lights, the others have none; and the rest of the file is what it was. */
static void test_lights_without_smoke_lose_nothing(void **state)
{
    (void)state;
    static curve_maps samples[LIGHTS];
    vxs_bytes         file = smoky_file(samples, 4), plain = smoky_file(samples, 0);
    vxs_asset        *asset, *without;
    const double      p[3] = {-1, 2, 3.2};
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    assert_int_equal(vxs_asset_open(&without, plain.data, plain.size_bytes, NULL), VXS_OK);
    for (uint32_t n = 0; n < LIGHTS; n++) {
        const vxs_baked_light *a = vxs_asset_light(asset, n), *b = vxs_asset_light(without, n);
        assert_memory_equal(&a->light, &b->light, sizeof a->light);
        assert_memory_equal(a->words, b->words, a->word_count * sizeof *a->words);
        assert_null(vxs_asset_smoke(without, n));
        if (n == 2)
            assert_int_equal(vxs_asset_smoke(asset, n)->side_px, CURVES_SIDE);
        else
            assert_null(vxs_asset_smoke(asset, n));
        assert_true(vxs_smoke_lookup(&a->light, NULL, p) == 1);
    }
    assert_null(vxs_asset_smoke(asset, LIGHTS));
    vxs_asset_close(asset);
    vxs_asset_close(without);
    free(file.data);
    free(plain.data);
}

/* findings --------------------------------------------------------------------------------------------------------------------- */

/* The file with smoke of the sun alone, changed. */
static void refused_when(void (*change)(part *smoke), int number)
{
    static curve_maps samples[LIGHTS];
    vxs_bytes         file = smoky_file(samples, SOLE_LIGHT);
    refused_with(&file, VXS_KIND_SMOKE, change, number);
    free(file.data);
}

static uint8_t *head_of(part *smoke, int offset)
{
    return smoke->content.data + offset;
}

static void set_float(part *smoke, int offset, float number)
{
    memcpy(head_of(smoke, offset), &number, sizeof number);
}

enum { MASK = VXS_SMOKE_PREFIX_BYTES, COUNTS = MASK + 1 }; /* four tiles, one of them without curves */

static uint8_t *plane_of(part *smoke, uint32_t plane)
{
    return head_of(smoke, COUNTS) + 3 * 64 + (size_t)plane * vxs_load32(head_of(smoke, VXS_SMOKE_NODE_COUNT));
}

/* The first node of a curve that has another behind it. */
static size_t node_before(part *smoke)
{
    size_t at = 0;
    for (const uint8_t *count = head_of(smoke, COUNTS); *count < 2; count++) at += *count;
    return at;
}

#define CHANGE(name, ...)                                                                                                          \
    static void name(part *smoke)                                                                                                  \
    {                                                                                                                              \
        __VA_ARGS__;                                                                                                               \
    }
CHANGE(no_head, smoke->content.size_bytes = VXS_SMOKE_PREFIX_BYTES - 1)
CHANGE(no_mask, smoke->content.size_bytes = MASK)
CHANGE(short_nodes, smoke->content.size_bytes--)
CHANGE(fewer_nodes, head_of(smoke, VXS_SMOKE_NODE_COUNT)[0] ^= 1)
CHANGE(small_map, head_of(smoke, VXS_SMOKE_LEVELS)[0] = 2)
CHANGE(large_map, head_of(smoke, VXS_SMOKE_LEVELS)[0] = LEVELS + 1)
CHANGE(huge_map, head_of(smoke, VXS_SMOKE_LEVELS)[3] = 255)
CHANGE(no_first, set_float(smoke, VXS_SMOKE_FIRST_METRES, NAN))
CHANGE(no_step, set_float(smoke, VXS_SMOKE_STEP_METRES, 0))
CHANGE(long_step, set_float(smoke, VXS_SMOKE_STEP_METRES, 1e37F))
CHANGE(tile_beyond, *head_of(smoke, MASK) |= 16)
CHANGE(one_tile_less, *head_of(smoke, MASK) &= (uint8_t)~2)
CHANGE(many_nodes, *head_of(smoke, COUNTS) = VXS_SMOKE_NODES_MAX + 1)
CHANGE(empty_tile, memset(head_of(smoke, COUNTS), 0, 64))
CHANGE(other_counts, uint8_t *count = head_of(smoke, COUNTS); while (!*count) count++; --*count)
CHANGE(deep_node, size_t n = node_before(smoke); plane_of(smoke, 1)[n] = 255; plane_of(smoke, 1)[n + 1] = 255)
CHANGE(rising_light, size_t n = node_before(smoke); plane_of(smoke, 3)[n] = 255; plane_of(smoke, 3)[n + 1] = 255)
CHANGE(other_light, smoke->light = LIGHTS)
CHANGE(no_light, smoke->light = VXS_NO_LIGHT)
CHANGE(other_level, smoke->level = 1)

static void test_broken_rules_have_findings(void **state)
{
    (void)state;
    refused_when(no_head, 601);
    refused_when(no_mask, 601);
    refused_when(short_nodes, 601);
    refused_when(fewer_nodes, 601);
    refused_when(one_tile_less, 601);
    refused_when(other_counts, 601);
    refused_when(small_map, 602);
    refused_when(large_map, 602);
    refused_when(huge_map, 602);
    refused_when(no_first, 602);
    refused_when(no_step, 602);
    refused_when(long_step, 602);
    refused_when(tile_beyond, 602);
    refused_when(many_nodes, 603);
    refused_when(empty_tile, 603);
    refused_when(deep_node, 604);
    refused_when(rising_light, 604);
    refused_when(other_light, 210);
    refused_when(no_light, 210);
    refused_when(other_level, 210);
}

static void test_smoke_is_there_once(void **state)
{
    (void)state;
    static curve_maps samples[LIGHTS];
    vxs_bytes         file = smoky_file(samples, SOLE_LIGHT);
    refused_twice(&file, VXS_KIND_SMOKE);
    free(file.data);
}

/* Every byte: refused with a finding, or harmless. */
static void test_any_change_is_found_or_harmless(void **state)
{
    (void)state;
    static curve_maps samples[LIGHTS];
    vxs_bytes         file = smoky_file(samples, SOLE_LIGHT);
    parts             p;
    rng               r = {5};
    take_apart(&p, &file);
    part *smoke = find_part(&p, VXS_KIND_SMOKE, 0);
    for (int n = 0; n < 400; n++) {
        uint8_t *at = smoke->content.data + rng_below(&r, n < 200 ? COUNTS + 192 : (uint32_t)smoke->content.size_bytes), was = *at;
        *at = (uint8_t)rng_u32(&r);
        store(smoke);
        vxs_bytes    changed = put_together(&p);
        vxs_contents contents;
        findings     f;
        if (read_bytes(&contents, &changed, &f, n & 1) == VXS_OK) vxs_contents_free(&contents);
        vxs_asset *asset = NULL;
        if (vxs_asset_open(&asset, changed.data, changed.size_bytes, NULL) == VXS_OK)
            for (int k = 0; k < 200; k++) {
                double p_ws[3] = {uniform(&r, -1, 15), uniform(&r, -6, 14), uniform(&r, 2, 18)};
                float  left    = vxs_smoke_lookup(&vxs_asset_light(asset, 0)->light, vxs_asset_smoke(asset, 0), p_ws);
                assert_true(left >= 0 && left <= 1);
            }
        vxs_asset_close(asset);
        free(changed.data);
        *at = was;
    }
    parts_free(&p);
    free(file.data);
}

static void test_memory_is_bounded_and_given_back(void **state)
{
    (void)state;
    static curve_maps samples[LIGHTS];
    vxs_bytes         file   = smoky_file(samples, 15);
    alloc_fail        needed = opened_without_memory(&file);
    vxs_asset        *asset;
    for (uint64_t limit = 1; limit < needed.peak_bytes; limit += needed.peak_bytes / 16) {
        alloc_fail    memory    = {0};
        vxs_allocator allocator = alloc_fail_allocator(&memory);
        vxs_read_desc desc      = {.allocator = &allocator, .memory_limit_bytes = limit};
        vxs_result    r         = vxs_asset_open(&asset, file.data, file.size_bytes, &desc);
        assert_true(r == VXS_E_MEMORY || limit + 4096 > needed.peak_bytes);
        vxs_asset_close(asset);
        assert_int_equal(memory.live_bytes, 0);
    }
    free(file.data);
}

static void test_what_has_no_room_is_not_written(void **state)
{
    (void)state;
    static curve_maps samples[LIGHTS];
    vxs_bytes         file = smoky_file(samples, SOLE_LIGHT), plain = smoky_file(samples, 0), out = {0};
    vxs_contents      contents, smoky;
    assert_int_equal(vxs_read(&contents, plain.data, plain.size_bytes, NULL), VXS_OK);
    assert_int_equal(vxs_read(&smoky, file.data, file.size_bytes, NULL), VXS_OK);
    uint8_t        counts[CURVES_A_MAP] = {2};
    uint32_t       nodes[20]            = {5 | 9u << 16, 4 | 9u << 16};
    vxs_smoke_view views[LIGHTS]        = {{CURVES_LOG2, 0, 1, counts, nodes}};
    const size_t   size                 = plain.size_bytes;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 3), VXS_E_ARGUMENT); /* back in depth */
    nodes[1] = 5 | 10u << 16;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 3), VXS_E_ARGUMENT); /* light comes back */
    nodes[1] = 5 | 9u << 16;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 0), VXS_E_ARGUMENT);
    assert_int_equal(vxs_write_smoke(&out, file.data, file.size_bytes, &smoky, views, 3), VXS_E_ARGUMENT); /* is there */
    counts[0] = VXS_SMOKE_NODES_MAX + 1;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 3), VXS_E_ARGUMENT);
    counts[0]            = 2;
    views[0].step_metres = 0;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 3), VXS_E_ARGUMENT);
    views[0].step_metres = 1;
    views[0].levels      = LEVELS + 1;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 3), VXS_E_ARGUMENT);
    views[0].levels = CURVES_LOG2;
    assert_int_equal(vxs_write_smoke(&out, plain.data, size, &contents, views, 3), VXS_OK);
    vxs_contents_free(&contents);
    vxs_contents_free(&smoky);
    free(out.data);
    free(plain.data);
    free(file.data);
}

static void test_every_finding_was_produced(void **state)
{
    (void)state;
#define PRODUCED(number, result, text)                                                                                             \
    if (!produced[number] && is_of_smoke(number)) fail_msg("no test produced finding %d", number);
    VXS_FINDINGS(PRODUCED)
#undef PRODUCED
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lookups_weigh_four_curves),
        cmocka_unit_test(test_any_number_is_answered),
        cmocka_unit_test(test_lights_without_smoke_lose_nothing),
        cmocka_unit_test(test_broken_rules_have_findings),
        cmocka_unit_test(test_smoke_is_there_once),
        cmocka_unit_test(test_any_change_is_found_or_harmless),
        cmocka_unit_test(test_memory_is_bounded_and_given_back),
        cmocka_unit_test(test_what_has_no_room_is_not_written),
        cmocka_unit_test(test_every_finding_was_produced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
