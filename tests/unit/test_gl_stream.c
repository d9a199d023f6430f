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
#include "runtime/gl/gl_state.h"
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

/* What happened. */
typedef struct outcome {
    stream_tally tally;
    uint32_t     late, gone, warnings;
} outcome;

/* Whether shaders answer as the file does, or as one without pages, as they say themselves; never in full where C does not; and
 * when all is uploaded, as C does of the same stream.   left  not 0: some may be coarse for want of an upload */
static void compare_stream(const drawing *d, rng *r, const stream_sample *s, const vxs_stream *stream, uint64_t left, outcome *seen)
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
        seen->tally.full += is_full != 0;
        seen->tally.coarse += !is_full;
        seen->tally.other += !is_full && exact != rough;
        seen->late += !is_full && should_be;
    }
}

typedef enum table_room { WORDS_ALONE, ALL_TABLES, FEW_TABLES } table_room;

static void count_warning(vxs_severity severity, const char *text, void *user)
{
    assert_true(severity == VXS_SEVERITY_WARNING && strstr(text, "most_table_bytes") && !strchr(text, '\n'));
    ++*(uint32_t *)user;
}

/* Most bytes that an upload of none may take: names, or tops twice. */
static uint64_t most_hidden_bytes(const stream_sample *s, table_room room)
{
    uint64_t words = s->page_count;
    for (uint32_t n = 0; n < s->light_count && room != WORDS_ALONE; n++) {
        const vxs_light *l = &vxs_asset_light(s->full, n)->light;
        if (l->coding == VXS_CODING_BLOCKS) words += 2 * vxs_map_count(l) << (2 * l->levels - 16);
    }
    return words * sizeof(uint32_t);
}

/* A stream whose pages come and leave, followed in slices of all sizes, and with frames left out. */
static void follow(drawing *d, const stream_sample *s, vxs_stream_desc asked, int storage, table_room room, outcome *seen)
{
    const size_t slices[]    = {0, 4, 100, 9000, 70000, SIZE_MAX};
    rng          r           = {(uint64_t)(83 + storage)};
    uint64_t     table_bytes = room == WORDS_ALONE ? 1 : 0, hidden = most_hidden_bytes(s, room);
    vxs_stream  *stream;
    vxs_gl      *gl;
    asked.threads = (uint32_t)storage; /* one of its own, that decodes while words are uploaded */
    assert_int_equal(vxs_stream_open(&stream, &asked), VXS_OK);
    vxs_stream_status status = {.struct_size = sizeof status};
    assert_int_equal(vxs_stream_frame(stream, NULL, 0, &status), VXS_OK);
    if (room == FEW_TABLES) table_bytes = status.bytes_room + 4096;
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_choice_proc,
                        .storage          = storage ? VXS_GL_TEXTURE : VXS_GL_BUFFER,
                        .stream           = stream,
                        .log              = count_warning,
                        .user             = &seen->warnings,
                        .most_table_bytes = table_bytes};
    if (storage) stream_fill(stream, &(vxs_stream_focus){{9, 9, 9}, {9, 9, 9}, 0, 0}); /* pages are there at once */
    assert_int_equal(vxs_gl_create(&gl, &desc), VXS_OK);
    assert_int_equal(room != WORDS_ALONE, vxs_gl_table_bytes(gl) != 0);
    while (vxs_gl_upload(gl, 50000)) {}
    use_body(d, gl, storage ? "#version 330 core" : "#version 430 core", streamed_body);
    vxs_gl_bind(gl);
    compare_stream(d, &r, s, stream, room == FEW_TABLES, seen);
    for (uint32_t frame = 0; frame < repeats(12, 400); frame++) {
        double at[3];
        stream_random_point(&vxs_stream_light(stream, rng_below(&r, 2))->light, &r, at);
        vxs_stream_focus eye  = vxs_stream_camera(at, rng_below(&r, 3) ? 8 : 0);
        uint32_t         some = rng_below(&r, 12);
        for (uint32_t n = 0; n <= some; n++) {
            assert_int_equal(vxs_stream_frame(stream, &eye, 1, &status), VXS_OK);
            seen->gone += status.left;
            if (n % 2) vxs_stream_wait(stream);
        }
        size_t   slice  = slices[rng_below(&r, 6)];
        uint64_t before = vxs_gl_uploaded_bytes(gl), left = vxs_gl_upload(gl, slice);
        uint64_t uploaded = vxs_gl_uploaded_bytes(gl) - before;
        assert_true(slice == SIZE_MAX ? !left : uploaded <= slice + hidden);
        assert_true(!left || uploaded >= slice / 4 * 4);
        compare_stream(d, &r, s, stream, left || room == FEW_TABLES, seen);
    }
    assert_int_equal(vxs_gl_upload(gl, SIZE_MAX), 0);
    vxs_gl_destroy(gl);
    vxs_stream_close(stream);
}

static void check_rooms(const table_room *rooms, int count)
{
    drawing       d = drawing_make();
    stream_sample s;
    stream_sample_init(&s, 5);
    vxs_stream_desc asked = stream_desc_of(&s, 0);
    asked.budget_bytes    = stream_least_budget(asked) + 900000;
    for (int n = 0; n < count; n++) {
        outcome seen = {0};
        for (int storage = 0; storage < 2; storage++) follow(&d, &s, asked, storage, rooms[n], &seen);
        print_message("%u pages; %u answers in full, %u coarse, %u of them other, %u late; %u pages left\n", s.page_count,
                      seen.tally.full, seen.tally.coarse, seen.tally.other, seen.late, seen.gone);
        assert_true(seen.tally.full > QUERIES && seen.tally.other > QUERIES / 4);
        assert_true(seen.late > QUERIES / 4 && seen.gone > repeats(12, 400) / 4);
        assert_int_equal(seen.warnings, rooms[n] == FEW_TABLES ? 2 : 0);
    }
    stream_sample_free(&s);
    gl_context_destroy(d.gl);
}

static void test_stream(void **state)
{
    (void)state;
    check_rooms((const table_room[]){ALL_TABLES, WORDS_ALONE}, 2);
}

/* No page waits for room that is free: a gap of as many words as it is known to need. Returns how many wait. */
static uint32_t check_waiting(const vxs_gl *gl)
{
    uint32_t waiting = 0;
    for (uint32_t n = 0; n <= gl->placed_count; n++) {
        const gl_page *before = n ? &gl->pages[gl->placed[n - 1]] : NULL;
        uint32_t       begin  = before ? before->first_word + before->word_count : gl->room_first;
        uint32_t       end    = n < gl->placed_count ? gl->pages[gl->placed[n]].first_word : gl->room_first + gl->room_count;
        assert_true(begin <= end);
        for (uint32_t page = 0; page < gl->page_count; page++)
            assert_true(!gl->names[page] || gl->pages[page].first_word || gl->pages[page].word_count > end - begin);
    }
    for (uint32_t page = 0; page < gl->page_count; page++) waiting += gl->names[page] && !gl->pages[page].first_word;
    return waiting;
}

static void test_waiting(void **state)
{
    drawing       d       = drawing_make();
    rng           r       = {7};
    uint32_t      waiting = 0;
    vxs_stream   *stream;
    vxs_gl       *gl;
    stream_sample s;
    (void)state;
    stream_sample_init(&s, 5);
    vxs_stream_desc asked = stream_desc_of(&s, 0);
    asked.budget_bytes    = stream_least_budget(asked) + 1300000;
    assert_int_equal(vxs_stream_open(&stream, &asked), VXS_OK);
    vxs_stream_status status = {.struct_size = sizeof status};
    assert_int_equal(vxs_stream_frame(stream, NULL, 0, &status), VXS_OK);
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_choice_proc,
                        .stream           = stream,
                        .most_table_bytes = status.bytes_room + 4096};
    assert_int_equal(vxs_gl_create(&gl, &desc), VXS_OK);
    for (int frame = 0; frame < 60; frame++) {
        double at[3];
        stream_random_point(&vxs_stream_light(stream, rng_below(&r, 2))->light, &r, at);
        vxs_stream_focus eye = vxs_stream_camera(at, 8);
        for (int n = 0; n < 4; n++) assert_int_equal(vxs_stream_frame(stream, &eye, 1, NULL), VXS_OK);
        vxs_gl_upload(gl, 0); /* pages leave */
        check_waiting(gl);
        assert_int_equal(vxs_gl_upload(gl, SIZE_MAX), 0);
        waiting += check_waiting(gl);
    }
    assert_true(waiting > 10);
    vxs_gl_destroy(gl);
    vxs_stream_close(stream);
    stream_sample_free(&s);
    gl_context_destroy(d.gl);
}

/* Pages whose tables have no room stay coarse, which is reported once; others are full. */
static void test_few_tables(void **state)
{
    (void)state;
    check_rooms((const table_room[]){FEW_TABLES}, 1);
}

/* Every allocation fails once; descriptions that make no sense. */
static void test_refused(void **state)
{
    drawing       d = drawing_make();
    stream_sample s;
    vxs_stream   *stream;
    vxs_gl       *gl;
    uint32_t      failed_uploads = 0;
    (void)state;
    stream_sample_init(&s, 5);
    vxs_stream_desc asked = stream_desc_of(&s, 0);
    asked.budget_bytes    = stream_least_budget(asked) + 450000;
    assert_int_equal(vxs_stream_open(&stream, &asked), VXS_OK);
    for (int n = 0; n < 4; n++) assert_int_equal(vxs_stream_frame(stream, &stream_all, 1, NULL), VXS_OK); /* a page */
    vxs_gl_desc desc = {
        .struct_size = sizeof desc, .get_proc_address = gl_choice_proc, .stream = stream, .most_table_bytes = 4 << 20};
    for (uint64_t fail_at = 1, good = 0; !good; fail_at++) {
        alloc_fail    a      = {.fail_at = fail_at};
        vxs_allocator memory = alloc_fail_allocator(&a);
        desc.allocator       = &memory;
        assert_true(vxs_gl_create(&gl, &desc) == (a.calls >= fail_at ? VXS_E_MEMORY : VXS_OK));
        if (gl) {
            uint64_t left = vxs_gl_upload(gl, SIZE_MAX);
            assert_true((left != 0) == (a.calls >= fail_at));
            failed_uploads += left != 0;
            assert_int_equal(vxs_gl_upload(gl, SIZE_MAX), 0);
        }
        good = a.calls < fail_at;
        vxs_gl_destroy(gl);
        assert_true(a.live_bytes == 0 && a.wrong_sizes == 0 && fail_at < 40);
    }
    assert_true(failed_uploads > 3);
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
        cmocka_unit_test(test_few_tables),
        cmocka_unit_test(test_waiting),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
