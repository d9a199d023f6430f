/* Lit intervals in shaders, from a stream some of whose pages are there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "intervals_rays.h"
#include "stream_sample.h"

/* Some pages of a stream are there: by tables, and by words. */
static void test_stream(void **state)
{
    (void)state;
    gl_context   *gl = open_context();
    stream_sample s;
    vxs_stream   *stream;
    rng           r = {210};
    stream_sample_init(&s, 5);
    vxs_stream_desc desc = stream_desc_of(&s, 0);
    desc.budget_bytes    = stream_least_budget(desc) + 900000;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    for (int n = 0; n < 20; n++) assert_int_equal(vxs_stream_frame(stream, &stream_all, 1, NULL), VXS_OK);
    for (int words_alone = 0; words_alone < 2; words_alone++) {
        vxs_baked_light lights[STREAM_LIGHTS];
        asker           a       = {.gl = gl, .answers = calloc(RAYS, sizeof(answer))};
        vxs_gl_desc     streams = {.struct_size      = sizeof streams,
                                   .get_proc_address = gl_choice_proc,
                                   .stream           = stream,
                                   .storage          = VXS_GL_BUFFER,
                                   .most_table_bytes = (uint64_t)words_alone};
        assert_int_equal(vxs_gl_create(&a.shadows, &streams), VXS_OK);
        assert_int_equal(vxs_gl_table_bytes(a.shadows) > 0, !words_alone);
        assert_int_equal(vxs_gl_upload(a.shadows, SIZE_MAX), 0);
        asker_compile(&a);
        for (uint32_t n = 0; n < STREAM_LIGHTS; n++) lights[n] = *vxs_stream_light(stream, n);
        uint32_t coarse = check_rays(&r, &a, lights, STREAM_LIGHTS, words_alone ? "stream, words" : "stream, tables");
        assert_in_range(coarse, 50, UINT32_MAX);
        asker_close(&a);
    }
    vxs_stream_close(stream);
    stream_sample_free(&s);
    gl_context_destroy(gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_stream)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
