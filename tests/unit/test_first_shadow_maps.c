/* Where light first ends, in lights that are built from depth maps: between enter and exit depth, of every texel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "runtime/vxs_query.h"

#include "baker/base/integer.h"
#include "baker/coding/blocks/blocks.h"
#include "tests/columns/analytic.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/columns/stored_maps.h"
#include "tests/unit/blocks_built.h"

/* Between the depths that light was built from: the voxel before is not dark by the contract, and the first shadow is not lit by
 * it. */
static void test_against_depth_maps(void **state)
{
    (void)state;
    for (int kind = 0; kind < MAP_KINDS; kind++) {
        depth_maps  d       = random_maps(256, 256, (map_kind)kind, 90 + (uint64_t)kind);
        column_map  columns = stored_map(&d);
        block_words w;
        assert_int_equal(build_words(&w, &columns, 1, 1), VXS_OK);
        vxs_baked_light l = {.light = {.kind = VXS_LIGHT_KIND_DIRECTIONAL, .levels = 8, .coding = VXS_CODING_BLOCKS},
                             .words = w.words};
        for (uint32_t n = 0; n < 256 * 256; n++) {
            uint32_t i = n % 256, j = n / 256;
            int32_t  depth = vxs_first_shadow(&l, 0, (int32_t)i, (int32_t)j, NULL);
            assert_in_range(depth, 0, 256);
            if (depth > 0) assert_int_not_equal(wanted(&d, i, j, (uint32_t)depth - 1), 1);
            if (depth < 256) assert_int_not_equal(wanted(&d, i, j, (uint32_t)depth), 0);
        }
        block_words_free(&w);
        depth_maps_free(&d);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_depth_maps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
