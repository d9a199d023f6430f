/* libvxs_gl and a stream: what shaders answer while pages come and leave, and are uploaded in slices.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>

#include "alloc_fail.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_taps.h"
#include "stream_sample.h"

/* Less than 0 where pages are missing. */
static const char streamed_body[] =
    TAPS_BODY("answer = vxs_is_full_at_place(light.first_word, light, place, pcf) != 0 ? float(dark + 1u) : -float(dark + 1u);");

static int is_full_in_c(const vxs_baked_light *of, const query *q)
{
    int32_t   x = (int32_t)q->position[0], y = (int32_t)q->position[1];
    vxs_place place = {(int32_t)q->normal[1], {x, y, (int32_t)q->position[2]}, (uint32_t)(7 * x) & 255, (uint32_t)(5 * y) & 255};
    return vxs_is_full_at_place(of->words, &of->light, place, filter_of_code(q->normal[2]));
}

/* Whether shaders answer as the file does, or as one without pages, as they say themselves; never in full where C does not; and
 * when all is uploaded, as C does of the same stream.   late  [in, out] counts those that are coarse for want of an upload */
static void compare_stream(const drawing *d, rng *r, const stream_sample *s, const vxs_stream *stream, uint64_t left,
                           stream_tally *tally, uint32_t *late)
{
    static query queries[QUERIES];
    static float answers[QUERIES];
    subject      full[STREAM_LIGHTS];
    uint32_t     partly = 0;
    for (uint32_t n = 0; n < s->light_count; n++)
        full[n] = (subject){&vxs_asset_light(s->full, n)->light, vxs_asset_light(s->full, n)->words};
    for (int n = 0; n < QUERIES; n++) {
        queries[n] = random_taps(r, full, s->light_count);
        if (n % 2) put_near_surface(r, &full[(int)queries[n].normal[0]], &queries[n]);
    }
    draw(d, queries, answers);
    for (int n = 0; n < QUERIES; n++) {
        const query           *q       = &queries[n];
        uint32_t               light   = (uint32_t)q->normal[0];
        const vxs_baked_light *now     = vxs_stream_light(stream, light);
        int                    is_full = answers[n] > 0, should_be = is_full_in_c(now, q);
        subject                coarse = {&s->coarse[light].light, s->coarse[light].words}, in_c = {&now->light, now->words};
        uint32_t               exact = taps_in_c(&full[light], q, &partly), rough = taps_in_c(&coarse, q, &partly), found;
        found = (uint32_t)fabsf(answers[n]) - 1;
        if (found != (is_full ? exact : rough) || is_full > should_be || (!left && is_full != should_be))
            fail_msg("query %d of light %u: %g, expected %u or %u; C is %s", n, light, (double)answers[n], exact, rough,
                     should_be ? "full" : "coarse");
        if (!left && found != taps_in_c(&in_c, q, &partly)) fail_msg("query %d of light %u: not as in C", n, light);
        tally->full += is_full != 0;
        tally->coarse += !is_full;
        tally->other += !is_full && exact != rough;
        *late += !is_full && should_be;
    }
}

/* A stream whose pages come and leave, followed in slices of all sizes, and with frames left out. */
static void test_stream(void **state)
{
    const size_t  slices[] = {0, 4, 100, 9000, 70000, SIZE_MAX};
    drawing       d        = drawing_make();
    stream_tally  tally    = {0};
    uint32_t      late = 0, gone = 0, frames = repeats(12, 400);
    stream_sample s;
    (void)state;
    stream_sample_init(&s, 5);
    vxs_stream_desc asked = stream_desc_of(&s, 0);
    asked.budget_bytes    = stream_least_budget(asked) + 900000;
    for (int storage = 0; storage < 2; storage++) {
        rng         r = {(uint64_t)(83 + storage)};
        vxs_stream *stream;
        vxs_gl     *gl;
        asked.threads = (uint32_t)storage; /* one of its own, that decodes while words are uploaded */
        assert_int_equal(vxs_stream_open(&stream, &asked), VXS_OK);
        vxs_gl_desc desc = {.struct_size      = sizeof desc,
                            .get_proc_address = gl_choice_proc,
                            .storage          = storage ? VXS_GL_TEXTURE : VXS_GL_BUFFER,
                            .stream           = stream};
        if (storage) stream_fill(stream, &(vxs_stream_focus){{9, 9, 9}, {9, 9, 9}, 0, 0}); /* pages are there at once */
        assert_int_equal(vxs_gl_create(&gl, &desc), VXS_OK);
        while (vxs_gl_upload(gl, 50000)) {}
        use_body(&d, gl, storage ? "#version 330 core" : "#version 430 core", streamed_body);
        vxs_gl_bind(gl);
        compare_stream(&d, &r, &s, stream, 0, &tally, &late);
        for (uint32_t frame = 0; frame < frames; frame++) {
            double at[3];
            stream_random_point(&vxs_stream_light(stream, rng_below(&r, 2))->light, &r, at);
            vxs_stream_focus  eye    = vxs_stream_camera(at, rng_below(&r, 3) ? 8 : 0);
            vxs_stream_status status = {.struct_size = sizeof status};
            uint32_t          some = rng_below(&r, 12), taken_away = 0;
            for (uint32_t n = 0; n <= some; n++) {
                assert_int_equal(vxs_stream_frame(stream, &eye, 1, &status), VXS_OK);
                taken_away += status.left;
                if (n % 2) vxs_stream_wait(stream);
            }
            size_t   slice  = slices[rng_below(&r, 6)];
            uint64_t before = vxs_gl_uploaded_bytes(gl), left = vxs_gl_upload(gl, slice);
            uint64_t uploaded = vxs_gl_uploaded_bytes(gl) - before;
            assert_true(slice == SIZE_MAX ? !left : uploaded <= slice + 4 * (uint64_t)s.page_count);
            assert_true(!left || uploaded >= slice / 4 * 4);
            compare_stream(&d, &r, &s, stream, left, &tally, &late);
            gone += taken_away;
        }
        assert_int_equal(vxs_gl_upload(gl, SIZE_MAX), 0);
        vxs_gl_destroy(gl);
        vxs_stream_close(stream);
    }
    print_message("%u pages; %u answers in full, %u coarse, %u of them other, %u late; %u pages left\n", s.page_count, tally.full,
                  tally.coarse, tally.other, late, gone);
    assert_true(tally.full > QUERIES && tally.other > QUERIES / 4 && late > QUERIES / 4 && gone > frames / 4);
    stream_sample_free(&s);
    gl_context_destroy(d.gl);
}

/* Every allocation fails once; descriptions that make no sense. */
static void test_refused(void **state)
{
    drawing       d = drawing_make();
    stream_sample s;
    vxs_stream   *stream;
    vxs_gl       *gl;
    (void)state;
    stream_sample_init(&s, 5);
    vxs_stream_desc asked = stream_desc_of(&s, 8 << 20);
    assert_int_equal(vxs_stream_open(&stream, &asked), VXS_OK);
    vxs_gl_desc desc = {.struct_size = sizeof desc, .get_proc_address = gl_choice_proc, .stream = stream};
    for (uint64_t fail_at = 1, good = 0; !good; fail_at++) {
        alloc_fail    a      = {.fail_at = fail_at};
        vxs_allocator memory = alloc_fail_allocator(&a);
        desc.allocator       = &memory;
        assert_true(vxs_gl_create(&gl, &desc) == (a.calls >= fail_at ? VXS_E_MEMORY : VXS_OK));
        good = a.calls < fail_at;
        vxs_gl_destroy(gl);
        assert_true(a.live_bytes == 0 && a.wrong_sizes == 0 && fail_at < 10);
    }
    desc.allocator = NULL;
    desc.asset     = s.full;
    assert_int_equal(vxs_gl_create(&gl, &desc), VXS_E_ARGUMENT);
    desc.asset       = NULL;
    desc.struct_size = 0; /* a program that knows of no streams */
    assert_int_equal(vxs_gl_create(&gl, &desc), VXS_E_ARGUMENT);
    vxs_stream_close(stream);
    stream_sample_free(&s);
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stream),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
