/* Points of what casts in a .vxs file: written data is read back within its rounding, in the order of formats/vxs.md section 16;
 * what breaks a rule is refused with its finding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "alloc_fail.h"
#include "dag_sample.h"
#include "random_light.h"
#include "runtime/vxs_stream.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "format_parts.h"

enum { COUNT = 500 };

static const double low[3] = {1e5, -3, 0.25}, size[3] = {40, 3, 0.5}, step = 1.0 / 64;

static void places_of(double *places_ws)
{
    rng r = {8};
    for (int n = 0; n < 3 * COUNT; n++) places_ws[n] = low[n % 3] + size[n % 3] * uniform(&r, 0, 1);
    for (int n = 0; n < 3; n++) places_ws[n] = low[n];
    memcpy(places_ws + 3, places_ws + 6, 3 * sizeof *places_ws); /* two are one */
}

static vxs_result write_points(vxs_bytes *file, const vxs_points_view *view)
{
    rng        r = {11};
    dag_sample d;
    dag_sample_init(&d, &r, 4, 20);
    vxs_write_light light = dag_sample_light(&d, "sun");
    vxs_result      found = vxs_write(file, &(vxs_write_desc){.lights = &light, .light_count = 1, .zstd_level = 3, .points = view});
    dag_sample_free(&d);
    return found;
}

static vxs_bytes file_of_points(void)
{
    static double   places_ws[3 * COUNT];
    vxs_points_view view = {places_ws, COUNT, 0.125, step};
    vxs_bytes       file = {0};
    places_of(places_ws);
    assert_int_equal(write_points(&file, &view), VXS_OK);
    return file;
}

/* Where a place is among those that are left; found ones are taken out. */
static int take_place(double *places_ws, int *taken, const double at[3], double within)
{
    for (int n = 0; n < COUNT; n++) {
        int is_it = !taken[n];
        for (int i = 0; i < 3; i++) is_it &= fabs(places_ws[3 * n + i] - at[i]) <= within;
        if (is_it) return taken[n] = 1;
    }
    return 0;
}

/* Each place comes back, half a unit off at most, from any origin; neighbours along the curve of codes are near. */
static void test_places_come_back(void **state)
{
    (void)state;
    static double           places_ws[3 * COUNT];
    static float            found[4 * COUNT];
    static int              taken[COUNT];
    const double            origin_ws[3] = {1e5 + 3, 7, -2};
    vxs_asset              *asset;
    vxs_bytes               file = file_of_points();
    const vxs_baked_points *points;
    places_of(places_ws);
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    assert_non_null(points = vxs_asset_points(asset));
    assert_int_equal(points->count, COUNT);
    assert_true(points->square_metres == 0.125 && points->step_metres == step);
    vxs_points_unpack(points, origin_ws, found);
    double jump = 0;
    for (int n = 0; n < COUNT; n++) {
        double at[3], off = 0;
        for (int i = 0; i < 3; i++) {
            at[i] = (double)found[4 * n + i] + origin_ws[i];
            if (n) off += fabs((double)found[4 * n + i] - (double)found[4 * (n - 1) + i]);
        }
        jump += off / COUNT;
        assert_true(take_place(places_ws, taken, at, 0.5001 * step + 1e-5));
        assert_true(found[4 * n + 3] == 0.125F);
    }
    assert_true(jump < 4); /* of places at random in that box 15 */
    vxs_points_unpack(points, NULL, found);
    assert_true(found[0] == 1e5F);
    vxs_asset_close(asset);
    free(file.data);
}

/* A box of more units than there are has larger ones; a file without points has none. */
static void test_large_boxes_and_none(void **state)
{
    (void)state;
    const double            far[6]  = {-4e6, 0, 0, 4e6, 1, 1};
    const vxs_points_view   view[2] = {{far, 2, 1, 1e-3}, {far, 1, 1, 1e-3}};
    const vxs_points_view  *given[] = {&view[0], &view[1], NULL};
    const vxs_baked_points *points;
    for (int n = 0; n < 3; n++) {
        vxs_bytes  file = {0};
        vxs_asset *asset;
        float      found[8];
        assert_int_equal(write_points(&file, given[n]), VXS_OK);
        assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
        points = vxs_asset_points(asset);
        assert_int_equal(points != NULL, n < 2);
        if (n < 2) vxs_points_unpack(points, NULL, found);
        if (n < 2) assert_true(fabs((double)found[0] + 4e6) < 1);
        if (n == 0) assert_true(fabs((double)found[4] - 4e6) < 1 && fabs(points->step_metres - 8e6 / 65535) < 1e-9);
        vxs_asset_close(asset);
        free(file.data);
    }
}

static void test_what_has_no_room_is_not_written(void **state)
{
    (void)state;
    static double         places_ws[6] = {0, 0, 0, 1, 1, 1};
    static const double   none[3] = {0, NAN, 0}, huge[6] = {-1e308, 0, 0, 1e308, 0, 0};
    const vxs_points_view bad[] = {{places_ws, 0, 1, 1}, {places_ws, VXS_POINTS_MAX + 1, 1, 1},
                                   {places_ws, 2, 0, 1}, {places_ws, 2, INFINITY, 1},
                                   {places_ws, 2, 1, 0}, {places_ws, 2, 1, NAN},
                                   {none, 1, 1, 1},      {huge, 2, 1, 1}};
    vxs_bytes             file  = {0};
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) assert_int_equal(write_points(&file, &bad[n]), VXS_E_ARGUMENT);
    free(file.data);
}

/* findings --------------------------------------------------------------------------------------------------------------------- */

static void refused_when(void (*change)(part *points), int number)
{
    vxs_bytes file = file_of_points();
    refused_with(&file, VXS_KIND_POINTS, change, number);
    free(file.data);
}

static void set_number(part *points, int offset, double number)
{
    vxs_store_f64(points->content.data + offset, number);
}

#define CHANGE(name, ...)                                                                                                          \
    static void name(part *points)                                                                                                 \
    {                                                                                                                              \
        __VA_ARGS__;                                                                                                               \
    }
CHANGE(no_head, points->content.size_bytes = VXS_POINTS_PREFIX_BYTES - 1)
CHANGE(short_planes, points->content.size_bytes--)
CHANGE(fewer_points, points->content.data[VXS_POINTS_POINT_COUNT] ^= 1)
CHANGE(no_points, memset(points->content.data + VXS_POINTS_POINT_COUNT, 0, 4))
CHANGE(many_points, points->content.data[VXS_POINTS_POINT_COUNT + 3] = 255)
CHANGE(no_area, set_number(points, VXS_POINTS_SQUARE_METRES, 0))
CHANGE(huge_area, set_number(points, VXS_POINTS_SQUARE_METRES, 1e300))
CHANGE(no_low, set_number(points, VXS_POINTS_LOW + 16, NAN))
CHANGE(no_step, set_number(points, VXS_POINTS_STEP_METRES, 0))
CHANGE(long_step, set_number(points, VXS_POINTS_STEP_METRES, 1e305))
CHANGE(far_point, memset(points->content.data + VXS_POINTS_PREFIX_BYTES + 5 * COUNT, 255, 2))
CHANGE(of_a_light, points->light = 0)
CHANGE(of_a_level, points->level = 1)

static void test_broken_rules_have_findings(void **state)
{
    (void)state;
    refused_when(no_head, 701);
    refused_when(short_planes, 701);
    refused_when(fewer_points, 701);
    refused_when(no_points, 702);
    refused_when(many_points, 702);
    refused_when(no_area, 702);
    refused_when(huge_area, 702);
    refused_when(no_low, 702);
    refused_when(no_step, 702);
    refused_when(long_step, 702);
    refused_when(far_point, 703);
    refused_when(of_a_light, 210);
    refused_when(of_a_level, 210);
#define PRODUCED(number, result, text)                                                                                             \
    if (!produced[number] && is_of_points(number)) fail_msg("no test produced finding %d", number);
    VXS_FINDINGS(PRODUCED)
#undef PRODUCED
}

static void test_points_are_there_once(void **state)
{
    (void)state;
    vxs_bytes file = file_of_points();
    refused_twice(&file, VXS_KIND_POINTS);
    free(file.data);
}

static void test_memory_is_bounded_and_given_back(void **state)
{
    (void)state;
    vxs_bytes  file = file_of_points();
    vxs_asset *asset;
    opened_without_memory(&file);
    vxs_read_desc desc = {.memory_limit_bytes = 3000};
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, &desc), VXS_E_MEMORY);
    free(file.data);
}

static void keep_points(void *user, const vxs_baked_points *points)
{
    vxs_baked_points *kept   = user;
    uint16_t         *copied = malloc(points->count * 3 * sizeof *copied);
    assert_non_null(copied);
    memcpy(copied, points->coordinates, points->count * 3 * sizeof *copied);
    *kept             = *points;
    kept->coordinates = copied;
}

/* Opening a stream reports the points of an asset on request. It keeps none of them, and reads none without a request. */
static void test_streams_tell_of_them(void **state)
{
    (void)state;
    vxs_bytes         file = file_of_points();
    vxs_baked_points  kept = {0};
    vxs_stream_status with = {.struct_size = sizeof with}, without = with;
    alloc_fail        memory    = {0};
    vxs_allocator     allocator = alloc_fail_allocator(&memory);
    vxs_stream_desc   desc      = {.struct_size  = sizeof desc,
                                   .bytes        = file.data,
                                   .size_bytes   = file.size_bytes,
                                   .budget_bytes = 4 << 20,
                                   .allocator    = &allocator,
                                   .points_user  = &kept};
    vxs_asset        *asset;
    vxs_stream       *stream;
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    const vxs_baked_points *points = vxs_asset_points(asset);
    uint64_t                stored = vxs_asset_contents(asset)->sections[points->section].stored_bytes;
    for (int asks = 0; asks < 2; asks++) {
        desc.points = asks ? keep_points : NULL;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        vxs_stream_frame(stream, NULL, 0, asks ? &with : &without);
        vxs_stream_close(stream);
        assert_int_equal(memory.live_bytes + memory.wrong_sizes, 0);
        assert_true((kept.coordinates != NULL) == asks);
    }
    assert_memory_equal(kept.coordinates, points->coordinates, 3 * COUNT * sizeof *kept.coordinates);
    assert_true(kept.count == COUNT && kept.square_metres == points->square_metres && kept.step_metres == points->step_metres);
    assert_memory_equal(kept.low_ws, points->low_ws, sizeof kept.low_ws);
    assert_true(with.bytes_held == without.bytes_held && with.bytes_read == without.bytes_read + stored);

    file.data[vxs_asset_contents(asset)->sections[points->section].offset_bytes + 30] ^= 1;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_CORRUPT);
    assert_null(stream);
    desc.points = NULL;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_close(stream);
    assert_int_equal(memory.live_bytes + memory.wrong_sizes, 0);
    free((void *)kept.coordinates);
    vxs_asset_close(asset);
    free(file.data);
}

/* What it needs to tell of them is within the budget; without it, or memory, nothing is left behind. */
static void test_streams_without_memory(void **state)
{
    (void)state;
    vxs_bytes       file = file_of_points();
    vxs_result      result;
    vxs_stream     *stream;
    uint64_t        calls = UINT64_MAX;
    vxs_stream_desc desc  = {.struct_size = sizeof desc, .bytes = file.data, .size_bytes = file.size_bytes, .points = keep_points};
    for (uint64_t n = 0; n <= calls; n++) {
        vxs_baked_points kept      = {0};
        alloc_fail       memory    = {.fail_at = n};
        vxs_allocator    allocator = alloc_fail_allocator(&memory);
        desc.allocator             = &allocator;
        desc.points_user           = &kept;
        desc.budget_bytes          = 4 << 20;
        result                     = vxs_stream_open(&stream, &desc);
        assert_int_equal(result, n ? VXS_E_MEMORY : VXS_OK);
        if (!n) calls = memory.calls;
        vxs_stream_close(stream);
        assert_int_equal(memory.live_bytes + memory.wrong_sizes, 0);
        free((void *)kept.coordinates);
    }
    for (desc.budget_bytes = 1; desc.budget_bytes < 8000; desc.budget_bytes += 61) {
        vxs_baked_points kept      = {0};
        alloc_fail       memory    = {0};
        vxs_allocator    allocator = alloc_fail_allocator(&memory);
        desc.allocator             = &allocator;
        desc.points_user           = &kept;
        result                     = vxs_stream_open(&stream, &desc);
        assert_true((result == VXS_OK || result == VXS_E_MEMORY) && memory.peak_bytes <= desc.budget_bytes);
        vxs_stream_close(stream);
        assert_int_equal(memory.live_bytes, 0);
        free((void *)kept.coordinates);
    }
    free(file.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places_come_back),
        cmocka_unit_test(test_large_boxes_and_none),
        cmocka_unit_test(test_what_has_no_room_is_not_written),
        cmocka_unit_test(test_points_are_there_once),
        cmocka_unit_test(test_broken_rules_have_findings),
        cmocka_unit_test(test_memory_is_bounded_and_given_back),
        cmocka_unit_test(test_streams_tell_of_them),
        cmocka_unit_test(test_streams_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
