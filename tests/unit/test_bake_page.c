/* The picture of a bake's page keeps within the memory that the bake was given (baker/lab/pages/page.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/memory.h" /* before cmocka, whose fail() is a macro */
#include "baker/lab/pages/page.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

static vxs_bytes golden_asset(void)
{
    static uint8_t bytes[1 << 20];
    FILE          *file = fopen("tests/golden/smallest.vxs", "rb");
    assert_non_null(file);
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    return (vxs_bytes){bytes, size, sizeof bytes};
}

/* Whether shadows are drawn where a bake may hold so much. */
static int is_drawn(const casters *c, vxs_bytes *file, uint64_t memory_bytes)
{
    bake_options o    = {.threads = 1, .memory_bytes = memory_bytes};
    bake_page    page = {0};
    assert_int_equal(bake_page_look(&page, &o, c, file, &(run_context){0}), VXS_OK);
    int drawn = page.rgb != NULL;
    bake_page_free(&page);
    assert_null(page.rgb);
    return drawn;
}

static void picture_keeps_within_memory(void **state)
{
    (void)state;
    double   positions[] = {0, 0, 0, 4, 0, 0, 0, 0, -4};
    uint32_t indices[]   = {0, 1, 2};
    uint8_t  flags[]     = {0};
    scene    one = {.vertex_count = 3, .positions_ws = positions, .triangle_count = 1, .indices = indices, .triangle_flags = flags};
    casters  c;
    vxs_bytes file = golden_asset();
    assert_int_equal(casters_from_scene(&c, &one, CLOSED_OFF, 2, &(run_context){0}), VXS_OK);
    uint64_t held = memory_held_bytes();
    assert_true(is_drawn(&c, &file, 0));
    assert_true(is_drawn(&c, &file, held + (64 << 20)));
    assert_false(is_drawn(&c, &file, held + (1 << 20)));
    c.triangle_count = 1 << 20; /* only counted: nothing is drawn of them */
    assert_false(is_drawn(&c, &file, held + (64 << 20)));
    c.triangle_count = 1;
    casters_free(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(picture_keeps_within_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
