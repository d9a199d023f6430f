/* What programs that are built against the headers rely on: the layout of structs that they share with the library, on 64-bit
 * systems. A change here breaks programs: it wants another VXS_VERSION_MAJOR, but for fields behind the last one of a struct that
 * begins with its struct_size. test_install.py looks at the names.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "formats/vxs_desc.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/vxs_area_light.h"
#include "runtime/volumes/vxs_transmittance.h"
#include "runtime/vxs.h"
#include "runtime/vxs_query.h"
#include "runtime/vxs_stream.h"

/* last, because they need the headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define AT(type, field) offsetof(type, field)

static void structs_of_the_library_keep_their_layout(void **state)
{
    (void)state;
    if (sizeof(void *) != 8) skip();
    assert_int_equal(sizeof(vxs_light), 240);
    assert_int_equal(AT(vxs_light, ls_from_ws), 80);
    assert_int_equal(AT(vxs_light, direction_ws), 192);
    assert_int_equal(AT(vxs_light, range_metres), 232);
    assert_int_equal(sizeof(vxs_part), 32);
    assert_int_equal(AT(vxs_baked_light, words), 240);
    assert_int_equal(AT(vxs_baked_light, word_count), 248);
    assert_int_equal(AT(vxs_baked_light, parts), 264);
    assert_int_equal(sizeof(vxs_baked_light), 264 + VXS_LEVELS_MAX * sizeof(vxs_part));
    assert_int_equal(sizeof(vxs_baked_smoke), 32);
    assert_int_equal(AT(vxs_baked_smoke, section), 24);
    assert_int_equal(sizeof(vxs_baked_points), 56);
    assert_int_equal(AT(vxs_baked_points, low_ws), 24);
    assert_int_equal(sizeof(vxs_contents), 72);
    assert_int_equal(AT(vxs_contents, allocator), 48);
    assert_int_equal(sizeof(vxs_section), 48);
    assert_int_equal(sizeof(vxs_allocator), 24);
    assert_int_equal(sizeof(vxs_parallel), 32);
    assert_int_equal(sizeof(vxs_light_constants), 96);
    assert_int_equal(sizeof(vxs_ray), 64);
    assert_int_equal(sizeof(vxs_interval), 24);
    assert_int_equal(sizeof(vxs_lit_walk), 1024);
    assert_int_equal(sizeof(vxs_gl_light), 16);
    assert_int_equal(sizeof(vxs_capsule), 32);
    assert_int_equal(AT(vxs_capsule, extinction), 28);
    assert_int_equal(sizeof(vxs_filter), 8);
    assert_int_equal(AT(vxs_filter, is_smooth), 4);
    assert_int_equal(sizeof(vxs_view), 84);
    assert_int_equal(AT(vxs_view, empty_depth), 72);
    assert_int_equal(sizeof(vxs_stream_focus), 64);
    assert_int_equal(sizeof(vxs_stream_range), 8);
}

static void descriptions_grow_at_their_end(void **state)
{
    (void)state;
    if (sizeof(void *) != 8) skip();
    assert_int_equal(AT(vxs_read_desc, struct_size), 0);
    assert_int_equal(AT(vxs_read_desc, allocator), 8);
    assert_int_equal(AT(vxs_read_desc, parallel), 48);
    assert_true(sizeof(vxs_read_desc) >= 56);
    assert_int_equal(sizeof(vxs_vectors), 24);
    assert_int_equal(AT(vxs_batch, struct_size), 0);
    assert_int_equal(AT(vxs_batch, count), 56);
    assert_int_equal(AT(vxs_batch, filter), 64);
    assert_int_equal(AT(vxs_batch, light_stride_bytes), 88);
    assert_true(sizeof(vxs_batch) >= 96);
    assert_int_equal(AT(vxs_depth_map_desc, struct_size), 0);
    assert_int_equal(AT(vxs_depth_map_desc, voxels), 40);
    assert_int_equal(AT(vxs_depth_map_desc, row_stride_bytes), 56);
    assert_true(sizeof(vxs_depth_map_desc) >= 64);
    assert_int_equal(AT(vxs_gl_desc, struct_size), 0);
    assert_int_equal(AT(vxs_gl_desc, storage), 32);
    assert_int_equal(AT(vxs_gl_desc, lights), 48);
    assert_int_equal(AT(vxs_gl_desc, first_binding), 64);
    assert_int_equal(AT(vxs_gl_desc, stream), 72);
    assert_int_equal(AT(vxs_gl_desc, smoke), 80);
    assert_int_equal(AT(vxs_gl_desc, log), 88);
    assert_int_equal(AT(vxs_gl_desc, baked), 96);
    assert_int_equal(AT(vxs_gl_desc, most_table_bytes), 104);
    assert_true(sizeof(vxs_gl_desc) >= 112);
    assert_int_equal(AT(vxs_volumes_desc, struct_size), 0);
    assert_int_equal(AT(vxs_volumes_frame, struct_size), 0);
    assert_int_equal(AT(vxs_volumes_frame, view), 52);
    assert_int_equal(AT(vxs_volumes_frame, depth_texture), 156);
    assert_int_equal(AT(vxs_volumes_light, struct_size), 0);
    assert_int_equal(AT(vxs_volumes_light, smoke), 48);
    assert_int_equal(AT(vxs_volumes_light, min_radiance), 60);
    assert_int_equal(AT(vxs_shadow_depth_map_desc, struct_size), 0);
    assert_int_equal(AT(vxs_shadow_depth_map_desc, moves), 28);
    assert_int_equal(AT(vxs_shadow_grid_desc, struct_size), 0);
    assert_int_equal(AT(vxs_shadow_grid_desc, between_rows), 28);
    assert_int_equal(AT(vxs_adaptive_mesh_desc, struct_size), 0);
    assert_int_equal(AT(vxs_adaptive_mesh_desc, triangles_most), 16);
    assert_int_equal(AT(vxs_area_light_desc, struct_size), 0);
    assert_int_equal(AT(vxs_area_light_desc, smoke_nodes), 36);
    assert_int_equal(AT(vxs_area_look, struct_size), 0);
    assert_int_equal(AT(vxs_area_look, maps), 24);
    assert_int_equal(AT(vxs_stream_desc, struct_size), 0);
    assert_int_equal(AT(vxs_stream_desc, read), 32);
    assert_int_equal(AT(vxs_stream_desc, budget_bytes), 48);
    assert_int_equal(AT(vxs_stream_desc, requests), 80);
    assert_int_equal(AT(vxs_stream_desc, failed_user), 136);
    assert_int_equal(AT(vxs_stream_desc, metadata_user), 152);
    assert_int_equal(AT(vxs_stream_desc, points_user), 168);
    assert_true(sizeof(vxs_stream_desc) >= 176);
    assert_int_equal(AT(vxs_stream_status, struct_size), 0);
    assert_int_equal(AT(vxs_stream_status, pages), 40);
    assert_int_equal(AT(vxs_stream_status, left), 76);
    assert_true(sizeof(vxs_stream_status) >= 80);
}

typedef struct growing {
    size_t struct_size;
    int    first, second, third;
} growing;

/* of a program built with headers of the first version (without `third`), of this one, and of a later one */
static void fields_that_a_program_does_not_have_are_zero(void **state)
{
    (void)state;
    enum { FIRST = AT(growing, third) };
    const size_t given[] = {0, FIRST, AT(growing, third) + sizeof(int), sizeof(growing)};
    for (int n = 0; n < 4; n++) {
        growing from[2] = {{given[n], 1, 2, 3}}, to = {0};
        assert_int_equal(vxs_desc_take(&to, sizeof to, FIRST, from), VXS_OK);
        assert_int_equal(to.second, 2);
        assert_int_equal(to.third, n < 2 ? 0 : 3);
        assert_int_equal(to.struct_size, sizeof to);
    }
    growing to = {0}, none = {FIRST - 1, 1, 2, 3};
    assert_int_equal(vxs_desc_take(&to, sizeof to, FIRST, NULL), VXS_OK);
    assert_int_equal(vxs_desc_take(&to, sizeof to, FIRST, &none), VXS_E_ARGUMENT);
    assert_int_equal(to.first, 0);
}

static void what_a_newer_program_asks_for_is_refused(void **state)
{
    (void)state;
    struct {
        growing known;
        int     unknown[2];
    } from     = {{sizeof from, 1, 2, 3}, {0, 0}};
    growing to = {0};
    assert_int_equal(vxs_desc_take(&to, sizeof to, sizeof to, &from), VXS_OK);
    assert_int_equal(to.third, 3);
    from.unknown[1] = 1;
    assert_int_equal(vxs_desc_take(&to, sizeof to, sizeof to, &from), VXS_E_ARGUMENT);
}

/* A finding, whose number is kept. */
static void count_finding(void *user, int number, const char *text, int section, uint64_t offset)
{
    (void)number, (void)text, (void)section, (void)offset;
    ++*(int *)user;
}

static void readers_look_at_the_size(void **state)
{
    (void)state;
    int           found   = 0;
    vxs_contents  nothing = {0};
    vxs_asset    *asset;
    vxs_read_desc desc = {.struct_size = sizeof desc, .finding = count_finding, .finding_user = &found};
    assert_int_equal(vxs_read(&nothing, "", 0, &desc), VXS_E_TRUNCATED);
    assert_int_equal(vxs_asset_open(&asset, "", 0, &desc), VXS_E_TRUNCATED);
    assert_int_equal(found, 2);
    desc.struct_size = AT(vxs_read_desc, find_all);
    assert_int_equal(vxs_read(&nothing, "", 0, &desc), VXS_E_ARGUMENT);
    assert_int_equal(vxs_asset_open(&asset, "", 0, &desc), VXS_E_ARGUMENT);
    assert_int_equal(vxs_asset_open_file(&asset, "/dev/null", &desc), VXS_E_ARGUMENT);
    assert_null(asset);
    assert_int_equal(found, 2);
}

/* A program that was built with newer headers, of which it uses nothing new: it works, whatever lies in memory behind the library's
 * copies. */
static void newer_descriptions_open_assets(void **state)
{
    (void)state;
    static const char path[] = "tests/golden/smallest.vxs";
    static uint8_t    bytes[4096];
    FILE             *file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    union {
        vxs_read_desc   read;
        vxs_stream_desc stream;
        uint8_t         newer[VXS_DESC_BYTES_MAX];
    } u;
    for (size_t given = sizeof u.read; given <= sizeof u; given += 8) {
        vxs_asset   *asset;
        vxs_contents contents;
        memset(&u, 0, sizeof u);
        u.read.struct_size = given;
        assert_int_equal(vxs_asset_open(&asset, bytes, size, &u.read), VXS_OK);
        vxs_asset_close(asset);
        assert_int_equal(vxs_asset_open_file(&asset, path, &u.read), VXS_OK);
        vxs_asset_close(asset);
        assert_int_equal(vxs_read(&contents, bytes, size, &u.read), VXS_OK);
        vxs_contents_free(&contents);
    }
    for (size_t given = sizeof u.stream; given <= sizeof u; given += 8) {
        vxs_stream *stream;
        memset(&u, 0, sizeof u);
        u.stream = (vxs_stream_desc){.struct_size = given, .path = path, .budget_bytes = 1 << 20};
        assert_int_equal(vxs_stream_open(&stream, &u.stream), VXS_OK);
        vxs_stream_close(stream);
    }
}

static void the_library_says_its_version(void **state)
{
    (void)state;
    assert_int_equal(vxs_version(), VXS_VERSION_NUMBER);
    assert_int_equal(vxs_version() / 10000, VXS_VERSION_MAJOR);
    assert_int_equal(vxs_version() / 100 % 100, VXS_VERSION_MINOR);
    assert_int_equal(vxs_version() % 100, VXS_VERSION_PATCH);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(structs_of_the_library_keep_their_layout),
        cmocka_unit_test(descriptions_grow_at_their_end),
        cmocka_unit_test(fields_that_a_program_does_not_have_are_zero),
        cmocka_unit_test(what_a_newer_program_asks_for_is_refused),
        cmocka_unit_test(readers_look_at_the_size),
        cmocka_unit_test(newer_descriptions_open_assets),
        cmocka_unit_test(the_library_says_its_version),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
