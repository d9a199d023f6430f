/* Comparing an asset with the truth: what is right, what is explained, and what is found wrong, on assets made by hand.
 *
 *        y
 *        8 +-------+  depth 0      the sun at noon; a sheet at y = 4 over all of the map and three metres
 *        4 =========  depth 4      beyond it; a voxel is a metre
 *        0 +-------+  depth 8
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <string.h>

#include "baker/truth/compare.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* A map of 8^3 voxels is one slice node: two bits a slice, 0 lit, 1 shadow. */
static const uint32_t words_exact = 0x5500, words_lit = 0, words_shadow = 0x5555, words_late = 0x5400;

/* The sheet, and a speck at each end of the height, outside the map. */
static double   positions[]    = {-3, 4, -3, 11,    4, -3, 11, 4, 11,    -3, 4, 11, //
                                  -3, 8, -3, -2.99, 8, -3, -3, 8, -2.99, -3, 0, -3, -2.99, 0, -3, -3, 0, -2.99};
static uint32_t indices[]      = {0, 1, 2, 0, 2, 3, 4, 5, 6, 7, 8, 9};
static casters  scene_of_sheet = {.vertex_count = 10, .positions_ws = positions, .triangle_count = 4, .indices = indices};

static vxs_light light_of(const uint32_t *words)
{
    return (vxs_light){.name         = "noon",
                       .kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                       .levels       = 3,
                       .ls_from_ws   = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 8},
                       .texel_metres = 1,
                       .voxel_metres = 1,
                       .direction_ws = {0, -1, 0},
                       .words        = words,
                       .word_count   = 1};
}

static compare_result compared_scene(const casters *c, vxs_light light, compare_options o)
{
    message        m = {0};
    truth         *t = NULL;
    compare_result result;
    assert_int_equal(truth_create(&t, c, 1, &m), VXS_OK);
    assert_int_equal(compare_light(&result, t, c, &light, &o, &m), VXS_OK);
    truth_destroy(t);
    for (int kind = 0; kind < COMPARE_KINDS; kind++) {
        const compare_counts *n = &result.counts[kind];
        assert_int_equal(n->points, o.points);
        assert_int_equal(n->points, n->outside + n->inside_solid + n->checked);
        assert_int_equal(compare_wrong(n), n->near_boundary + n->near_surface + n->unexplained);
    }
    return result;
}

static compare_result compared(const uint32_t *words, compare_options o)
{
    return compared_scene(&scene_of_sheet, light_of(words), o);
}

static const compare_options options = {.points = 20000, .seed = 1, .filter_px = 1, .threads = 2};

static void nothing_is_wrong_with_an_exact_asset(void **state)
{
    (void)state;
    compare_result r = compared(&words_exact, options);
    assert_int_equal(compare_wrong(&r.counts[COMPARE_RANDOM]), 0);
    assert_int_equal(compare_wrong(&r.counts[COMPARE_SURFACE]), 0);
    assert_int_equal(r.example_count, 0);
    assert_int_equal(r.counts[COMPARE_RANDOM].checked, options.points);
    assert_true(r.counts[COMPARE_SURFACE].outside > 5000 && r.counts[COMPARE_SURFACE].checked > 5000);
    assert_true(r.time.points == r.counts[COMPARE_RANDOM].checked && r.time.lookup_s > 0 && r.time.truth_s > 0 &&
                r.time.filter_s == 0);
}

/* A map of two metres in a box of fourteen, half of it beyond the box: every random point is in both. */
static void random_points_are_drawn_in_the_volume(void **state)
{
    (void)state;
    vxs_light small     = light_of(&words_lit);
    small.flags         = VXS_LIGHT_BOUNDED;
    small.ls_from_ws[0] = small.ls_from_ws[6] = 4;
    small.ls_from_ws[9]                       = -4;
    small.ls_from_ws[3]                       = -40; /* x from 10 to 12; the box ends at 11.35 */
    small.ls_from_ws[11]                      = 32;  /* y from 6 to 8 */
    small.texel_metres = small.voxel_metres = 0.25;
    compare_result r                        = compared_scene(&scene_of_sheet, small, options);
    assert_int_equal(r.counts[COMPARE_RANDOM].checked, options.points);
    assert_int_equal(compare_wrong(&r.counts[COMPARE_RANDOM]), 0);
    assert_int_equal(r.time.points, options.points);

    small.ls_from_ws[3] = -400; /* far beyond the box */
    r                   = compared_scene(&scene_of_sheet, small, options);
    for (int kind = 0; kind < COMPARE_KINDS; kind++) assert_int_equal(r.counts[kind].outside, options.points);
    assert_int_equal(r.time.points, 0);
}

/* A second sheet half a voxel above the first. The bias takes lookups on the lower one's upper side past it, into the light: the
 * map is right there, and the surface, one face of four, is in shadow. */
static void the_bias_is_judged_at_the_surface(void **state)
{
    (void)state;
    static double        two[]   = {-3, 4, -3, 11, 4, -3, 11, 4, 11, -3, 4, 11, -3, 4.5, -3, 11, 4.5, -3, 11, 4.5, 11, -3, 4.5, 11};
    static uint32_t      faces[] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    const casters        sheets  = {.vertex_count = 8, .positions_ws = two, .triangle_count = 4, .indices = faces};
    const compare_counts n       = compared_scene(&sheets, light_of(&words_exact), options).counts[COMPARE_SURFACE];
    double               share   = (double)n.wrong_at_surface / (double)n.checked_at_surface;
    assert_int_equal(compare_wrong(&n), 0);
    assert_int_equal(n.checked_at_surface, n.checked);
    assert_true(share > 0.23 && share < 0.27);

    const compare_result one = compared(&words_exact, options);
    assert_int_equal(one.counts[COMPARE_SURFACE].wrong_at_surface, 0);
    assert_int_equal(one.counts[COMPARE_RANDOM].checked_at_surface, 0);
}

/* The shadow begins a voxel late: leaks just below the sheet, all of them near it. */
static void a_voxel_late_is_explained(void **state)
{
    (void)state;
    compare_result        r = compared(&words_late, options);
    const compare_counts *n = &r.counts[COMPARE_RANDOM];
    assert_int_equal(n->false_shadows, 0);
    assert_int_equal(n->near_boundary, n->leaks);
    double share = (double)n->leaks / (double)n->checked;
    assert_true(share > 0.10 && share < 0.14); /* one of eight voxels, in a box that is 5 % higher */
}

/* Below the sheet all is wrong; what is more than two voxels below has no excuse. */
static void an_asset_without_shadow_leaks(void **state)
{
    (void)state;
    compare_result        r = compared(&words_lit, options);
    const compare_counts *n = &r.counts[COMPARE_RANDOM];
    assert_int_equal(n->false_shadows, 0);
    assert_true(n->near_boundary > 0.4 * (double)n->leaks && n->unexplained > 0.4 * (double)n->leaks);
    assert_int_equal(r.example_count, COMPARE_EXAMPLES_MAX);
    for (uint32_t i = 0; i < r.example_count; i++) {
        const compare_example *e = &r.examples[i];
        assert_true(e->kind == COMPARE_RANDOM && e->asset_lit == 1 && e->truth_lit == 0);
        assert_true(e->point_ws[1] < 2 && e->voxel[2] == (int32_t)floor(8 - e->point_ws[1]));
        assert_true(e->normal_ws[0] == 0 && e->normal_ws[1] == 0 && e->normal_ws[2] == 0);
    }
}

/* The other way round; but from above, where the sheet is two texels away, only the sheet excuses it. */
static void an_asset_without_light_is_found_too(void **state)
{
    (void)state;
    compare_result        r = compared(&words_shadow, options);
    const compare_counts *n = &r.counts[COMPARE_RANDOM];
    assert_int_equal(n->leaks, 0);
    assert_true(n->near_boundary > 0.4 * (double)n->false_shadows && n->unexplained > 0.4 * (double)n->false_shadows);
    assert_true(r.counts[COMPARE_SURFACE].false_shadows > 0.4 * (double)r.counts[COMPARE_SURFACE].checked);
    assert_int_equal(r.counts[COMPARE_SURFACE].unexplained, 0);
}

static void filters_are_compared(void **state)
{
    (void)state;
    compare_options o    = options;
    o.filter_px          = 3;
    compare_result exact = compared(&words_exact, o), lit = compared(&words_lit, o);
    for (int kind = 0; kind < COMPARE_KINDS; kind++) {
        assert_int_equal(exact.filter[kind].points, exact.counts[kind].checked);
        assert_true(exact.filter[kind].rmse < 0.3 * lit.filter[kind].rmse); /* not 0: taps beyond the map are lit, rays are not */
        assert_true(lit.filter[kind].max_error == 1 && lit.filter[kind].rmse > 0.6 && lit.filter[kind].rmse < 0.8);
    }
    assert_true(exact.time.filter_s > 0);
}

static void threads_change_nothing_and_seeds_do(void **state)
{
    (void)state;
    compare_options one = options, other = options;
    one.threads      = 1;
    other.seed       = 2;
    compare_result a = compared(&words_lit, options), b = compared(&words_lit, one), c = compared(&words_lit, other);
    assert_memory_equal(a.counts, b.counts, sizeof a.counts);
    assert_memory_equal(a.examples, b.examples, sizeof a.examples);
    assert_memory_not_equal(a.counts, c.counts, sizeof a.counts);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_wrong_with_an_exact_asset),
        cmocka_unit_test(random_points_are_drawn_in_the_volume),
        cmocka_unit_test(the_bias_is_judged_at_the_surface),
        cmocka_unit_test(a_voxel_late_is_explained),
        cmocka_unit_test(an_asset_without_shadow_leaks),
        cmocka_unit_test(an_asset_without_light_is_found_too),
        cmocka_unit_test(filters_are_compared),
        cmocka_unit_test(threads_change_nothing_and_seeds_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
