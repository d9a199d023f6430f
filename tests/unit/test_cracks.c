/* No light falls between sheets that meet: some million columns of panels (tests/columns/panels.h), from both sources.
 * tests/bench/cracks.c looks at any number of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "tests/columns/panels.h" /* before cmocka, whose fail() is a macro */
#include "tests/gl_choice.h"
#include "tests/unit/repeats.h"

#include <cmocka.h>

static gl_context *gl;

static int create_context(void **state)
{
    run_context m = {0};
    (void)state;
    return gl_context_create(&gl, gl_choice(), 2, &m) == VXS_OK ? 0 : -1;
}

static int destroy_context(void **state)
{
    (void)state;
    gl_context_destroy(gl);
    return 0;
}

enum { SCENES = 24, SIDE_PX = 1024 };

/* gaps_metres  [gap_count] in turn */
static leak_counts count(gl_context *with, casters_maker *make, uint32_t scenes, const double *gaps_metres, size_t gap_count)
{
    leak_counts  sum = {0};
    run_context  m   = {0};
    bake_context ctx = {.run = &m, .threads = 2};
    for (uint64_t n = 0; n < scenes; n++)
        assert_int_equal(
            panels_leaks(&sum, with, n, gaps_metres[n % gap_count], (light_kind)(n / gap_count % 3), make, SIDE_PX, &ctx), VXS_OK);
    assert_true(sum.columns > 200000 * (uint64_t)scenes);
    run_free(&m);
    return sum;
}

static void no_light_falls_between_panels(void **state)
{
    static const double rounding_metres[] = {0, 1e-7}, gaps_metres[] = {1e-6, 3e-6, 1e-5};
    (void)state;
    for (int rendered = 0; rendered < 2; rendered++) {
        leak_counts found = count(rendered ? gl : NULL, casters_for_maps, repeats(6, SCENES), rounding_metres,
                                  2); /* each kind of light with each of them, at least once */
        assert_int_equal(found.in_gaps + found.beside_gaps + found.unexplained, 0);
        found          = count(rendered ? gl : NULL, casters_from_scene, SCENES, rounding_metres, 2);
        uint64_t leaks = found.in_gaps + found.beside_gaps + found.unexplained;
        assert_true(leaks >
                    (rendered ? 10 : 0)); /* they are there to be found; from triangles the grid is finer, and they are few */
        found = count(rendered ? gl : NULL, casters_for_maps, repeats(9, SCENES), gaps_metres, 3);
        assert_int_equal(found.unexplained, 0);
        assert_true(found.in_gaps > 10); /* what is a gap stays one */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_light_falls_between_panels)};
    return cmocka_run_group_tests(tests, create_context, destroy_context);
}
