/* Baked smoke in streams: lookups are those of the file opened whole, whatever pages are there, in C and in shaders; what it takes
 * of the budget and of the file; and what becomes of smoke that is damaged, or cannot be read.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"
#include "formats/vxs_space.h" /* before format_parts.h, which has a type of a name that is a parameter here */

#include <math.h>

#include "alloc_fail.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "format_parts.h"
#include "gl_taps.h"
#include "runtime/gl/gl_state.h"
#include "smoke_curves.h"
#include "stream_sample.h"

enum { SUN, MOON, PUNCTUAL, LIGHTS, ENOUGH = 64 << 20 };

static vxs_bytes  plain, smoky; /* the same file without smoke, and with that of sun and light */
static vxs_asset *whole;        /* smoky */

/* Suns of palette blocks and of a DAG, and a point light. */
static vxs_bytes plain_file(void)
{
    block_words w = words_of_maps(10, 1, MAPS_NOISE, 3);
    rng         r = {7};
    dag_sample  dag;
    dag_sample_init(&dag, &r, 5, 20);
    vxs_write_light lights[LIGHTS] = {
        [SUN]      = stream_light_of(&w, 10, VXS_LIGHT_KIND_DIRECTIONAL, 0, VXS_PACKING_FAST, "sun"),
        [MOON]     = dag_sample_light(&dag, "moon"),
        [PUNCTUAL] = dag_sample_punctual(&dag, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE),
    };
    vxs_write_desc desc = {.lights = lights, .light_count = LIGHTS, .zstd_level = 1};
    vxs_bytes      file = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    block_words_free(&w);
    dag_sample_free(&dag);
    return file;
}

static int make_files(void **state)
{
    (void)state;
    static curve_maps curves[2];
    rng               r = {5};
    vxs_contents      contents;
    plain = plain_file();
    random_curves(&curves[0], &r, 1);
    random_curves(&curves[1], &r, VXS_CUBE_FACES);
    const vxs_smoke_view views[LIGHTS] = {[SUN]      = curves_view(&curves[0], -3, 0.016F), /* as deep as the maps are */
                                          [PUNCTUAL] = curves_view(&curves[1], 0.125F, 0.00012F)};
    assert_int_equal(vxs_read(&contents, plain.data, plain.size_bytes, NULL), VXS_OK);
    assert_int_equal(vxs_write_smoke(&smoky, plain.data, plain.size_bytes, &contents, views, 3), VXS_OK);
    vxs_contents_free(&contents);
    assert_int_equal(vxs_asset_open(&whole, smoky.data, smoky.size_bytes, NULL), VXS_OK);
    return 0;
}

static int free_files(void **state)
{
    (void)state;
    vxs_asset_close(whole);
    free(plain.data);
    free(smoky.data);
    return 0;
}

static vxs_stream_desc desc_of(const vxs_bytes *file, uint64_t budget_bytes)
{
    return stream_desc_of(&(stream_sample){.file = *file}, budget_bytes);
}

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

/* Lights of a stream, which are these of the file, give the answer of the file, to the bit.   Returns how many places smoke dims */
static uint32_t compare(const vxs_stream *stream, const uint32_t *numbers, rng *r, int count)
{
    uint32_t dimmed = 0;
    for (int n = 0; n < count; n++) {
        uint32_t               light    = rng_below(r, vxs_stream_light_count(stream));
        const vxs_baked_light *streamed = vxs_stream_light(stream, light), *in_file = vxs_asset_light(whole, numbers[light]);
        const vxs_baked_smoke *smoke = vxs_stream_smoke(stream, light), *wanted = vxs_asset_smoke(whole, numbers[light]);
        double                 point[3];
        stream_random_point(&in_file->light, r, point);
        float left = vxs_smoke_lookup(&in_file->light, wanted, point);
        assert_true((smoke != NULL) == (wanted != NULL));
        assert_true(vxs_smoke_lookup(&streamed->light, smoke, point) == left);
        dimmed += left < 0.9F;
    }
    return dimmed;
}

/* While pages come and leave, all of them are there, and none has room. */
static void test_lookups_are_those_of_the_file(void **state)
{
    (void)state;
    static const uint32_t all[LIGHTS] = {SUN, MOON, PUNCTUAL};
    vxs_stream_desc       desc        = desc_of(&smoky, 0);
    const uint64_t        least = stream_least_budget(desc), budgets[] = {least, least + 400000, ENOUGH};
    rng                   r = {1};
    for (int n = 0; n < 3; n++) {
        vxs_stream       *stream;
        vxs_stream_status status = {.struct_size = sizeof status};
        uint32_t          left   = 0;
        desc.budget_bytes        = budgets[n];
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        for (int frame = 0; frame < 40; frame++) {
            double at[3];
            stream_random_point(&vxs_stream_light(stream, SUN)->light, &r, at);
            vxs_stream_focus eye = vxs_stream_camera(at, 100);
            assert_int_equal(vxs_stream_frame(stream, &eye, 1, &status), VXS_OK);
            left += status.left;
            assert_in_range(compare(stream, all, &r, 400), 50, 350);
        }
        assert_true(n ? status.pages_resident : !status.pages_resident);
        assert_true(n == 1 ? left > 0 : !left);
        vxs_stream_close(stream);
    }
}

/* Lights by name, in any order: each has its own smoke, and what is not wanted is not read. */
static void test_some_lights(void **state)
{
    (void)state;
    static const char *const names[] = {"lamp", "sun", "lamp"}, *const moon[] = {"moon"};
    static const uint32_t numbers[] = {PUNCTUAL, SUN, PUNCTUAL};
    vxs_stream_desc       desc      = desc_of(&smoky, ENOUGH);
    vxs_stream_status     status    = {.struct_size = sizeof status};
    vxs_stream           *stream;
    rng                   r = {2};
    desc.light_names        = names;
    desc.light_name_count   = 3;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    assert_in_range(compare(stream, numbers, &r, 4000), 500, 3500);
    assert_null(vxs_stream_smoke(stream, 3));
    vxs_stream_close(stream);

    uint64_t read[2];
    desc.light_names      = moon;
    desc.light_name_count = 1;
    for (int n = 0; n < 2; n++) {
        const vxs_bytes *file = n ? &smoky : &plain;
        desc.bytes            = file->data;
        desc.size_bytes       = file->size_bytes;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        assert_null(vxs_stream_smoke(stream, 0));
        vxs_stream_frame(stream, NULL, 0, &status);
        read[n] = status.bytes_read;
        vxs_stream_close(stream);
    }
    assert_int_equal(read[1] - read[0], 2 * VXS_ENTRY_BYTES);
}

/* shaders ---------------------------------------------------------------------------------------------------------------------- */

/* Whose smoke shaders are given: that of an asset alone, a stream's own, the same reported, that of an asset beside it, or none in
 * its place. */
typedef enum given { ASSET, OWN, SAME, BESIDE, NONE, GIVEN } given;

static query asked[QUERIES];

/* What shaders answer, pages having come and gone.   n  of storages */
static void answers_of(drawing *d, given from, int n, float answers[QUERIES])
{
    static const char *const versions[]    = {"#version 430 core", "#version 330 core"};
    const vxs_baked_smoke   *smoke[LIGHTS] = {NULL};
    vxs_stream_desc          streamed      = desc_of(&smoky, 0);
    vxs_stream              *stream;
    vxs_gl                  *gl;
    uint32_t                 words;
    rng                      r = {4};
    streamed.budget_bytes      = stream_least_budget(streamed) + 400000;
    assert_int_equal(vxs_stream_open(&stream, &streamed), VXS_OK);
    vxs_stream_words(stream, &words);
    for (uint32_t light = 0; light < LIGHTS && from != NONE; light++)
        smoke[light] = from == SAME ? vxs_stream_smoke(stream, light) : vxs_asset_smoke(whole, light);
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_choice_proc,
                        .storage          = n ? VXS_GL_TEXTURE : VXS_GL_BUFFER,
                        .asset            = from == ASSET ? whole : NULL,
                        .stream           = from == ASSET ? NULL : stream,
                        .smoke            = from == ASSET || from == OWN ? NULL : smoke,
                        .most_table_bytes = from == OWN}; /* by words alone; the others by tables */
    assert_int_equal(vxs_gl_create(&gl, &desc), VXS_OK);
    while (vxs_gl_upload(gl, 5000)) continue;
    if (from == OWN) assert_int_equal(gl->words.count, words + LIGHTS + VXS_BLOCKS_SPARE_WORDS); /* no second copy */
    if (from == SAME) assert_true(gl->table_count && gl->words.count - gl->table_count < words); /* no words of blocks */
    use_body(d, gl, versions[n], SMOKE_LEFT_BODY);
    for (int frame = 0; frame < 4 && from != ASSET; frame++) {
        double at[3];
        stream_random_point(&vxs_stream_light(stream, SUN)->light, &r, at);
        vxs_stream_focus eye = vxs_stream_camera(at, 0);
        vxs_stream_frame(stream, &eye, 1, NULL);
        vxs_gl_upload(gl, SIZE_MAX);
    }
    vxs_gl_bind(gl);
    draw(d, asked, answers);
    vxs_gl_destroy(gl);
    vxs_stream_close(stream);
}

/* To the bit those of the file opened whole. They are C's but beside steps of curves, where a float's place may be on the other
 * side. */
static void test_shaders_answer_as_those_of_the_file(void **state)
{
    (void)state;
    static float wanted[QUERIES], answers[QUERIES];
    drawing      d      = drawing_make();
    rng          r      = {3};
    uint32_t     dimmed = 0, other = 0;
    for (query *q = asked; q < asked + QUERIES; q++) {
        uint32_t light = rng_below(&r, LIGHTS);
        double   point[3];
        stream_random_point(&vxs_asset_light(whole, light)->light, &r, point);
        *q = (query){{(float)point[0], (float)point[1], (float)point[2]}, {(float)light}};
    }
    for (int n = 0; n < 2; n++)
        for (given from = ASSET; from < GIVEN; from++) {
            answers_of(&d, from, n, answers);
            if (from == ASSET && !n) memcpy(wanted, answers, sizeof wanted);
            if (from == NONE)
                for (int k = 0; k < QUERIES; k++) assert_true(answers[k] == 1);
            else
                assert_memory_equal(answers, wanted, sizeof wanted);
        }
    for (const query *q = asked; q < asked + QUERIES; q++) {
        uint32_t     light = (uint32_t)q->normal[0];
        const double ws[3] = {(double)q->position[0], (double)q->position[1], (double)q->position[2]};
        float        in_c  = vxs_smoke_lookup(&vxs_asset_light(whole, light)->light, vxs_asset_smoke(whole, light), ws);
        dimmed += in_c < 0.9F;
        other += fabsf(in_c - wanted[q - asked]) > 1e-4F;
    }
    print_message("%u of %u places in shadow of smoke, %u other than in C by more than 1e-4\n", dimmed, (unsigned)QUERIES, other);
    assert_true(dimmed > QUERIES / 8 && other < QUERIES / 1000);
    gl_context_destroy(d.gl);
}

/* memory ----------------------------------------------------------------------------------------------------------------------- */

static const vxs_section *section_of(const vxs_asset *asset, uint32_t light)
{
    const vxs_section *s = vxs_asset_contents(asset)->sections;
    while (s->kind != VXS_KIND_SMOKE || s->light != light) s++;
    return s;
}

/* Of the budget its words, and room to read the larger one, where pages go later; no more is held or read. One byte less than the
 * least is an error with a message. */
static void test_what_it_takes(void **state)
{
    (void)state;
    uint64_t          least[2], held[2], read[2], words = 0, stored = 0, work = 0;
    vxs_stream_status status = {.struct_size = sizeof status};
    for (uint32_t n = SUN; n <= PUNCTUAL; n += PUNCTUAL) {
        words += vxs_asset_smoke(whole, n)->word_count;
        stored += section_of(whole, n)->stored_bytes;
        work = section_of(whole, n)->stored_bytes + section_of(whole, n)->inflated_bytes;
    }
    for (int n = 0; n < 2; n++) {
        alloc_fail      memory    = {0};
        vxs_allocator   allocator = alloc_fail_allocator(&memory);
        vxs_stream_desc desc      = desc_of(n ? &smoky : &plain, 0);
        vxs_stream     *stream;
        findings        f = {0};
        least[n]          = stream_least_budget(desc);
        desc.allocator    = &allocator;
        desc.finding      = collect;
        desc.finding_user = &f;
        desc.budget_bytes = least[n] - 1;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_MEMORY);
        assert_int_equal(f.first, 211);
        desc.budget_bytes = least[n];
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        vxs_stream_frame(stream, &stream_all, 1, &status);
        assert_true(memory.peak_bytes <= least[n] && status.bytes_held <= least[n]);
        read[n] = status.bytes_read;
        vxs_stream_close(stream);

        desc.budget_bytes = ENOUGH;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        uint64_t calls = memory.calls;
        vxs_stream_frame(stream, &stream_all, 1, &status);
        held[n] = status.bytes_held;
        assert_true(memory.live_bytes == held[n] && memory.calls == calls); /* one block */
        vxs_stream_close(stream);
        assert_int_equal(memory.live_bytes + memory.wrong_sizes, 0);
    }
    print_message("smoke of %u words: the least budget is %u bytes more, and %u are held\n", (unsigned)words,
                  (unsigned)(least[1] - least[0]), (unsigned)(held[1] - held[0]));
    assert_in_range(least[1] - least[0], 4 * words, 4 * words + work + 1024);
    assert_in_range(held[1] - held[0], 4 * words, 4 * words + 1024);
    assert_int_equal(read[1] - read[0], 2 * stored + 2 * VXS_ENTRY_BYTES);
}

/* what goes wrong -------------------------------------------------------------------------------------------------------------- */

/* Open fails with a finding, of a stream of all lights; one without the light whose smoke it is opens. */
static void refused_by_stream(const vxs_bytes *file, int number)
{
    static const char *const others[] = {"moon", "lamp"};
    vxs_stream_desc          desc     = desc_of(file, ENOUGH);
    vxs_stream              *stream;
    findings                 f = {0};
    desc.finding               = collect;
    desc.finding_user          = &f;
    assert_int_equal(vxs_stream_open(&stream, &desc), result_of(number));
    assert_null(stream);
    assert_int_equal(f.first, number);
    desc.light_names      = others;
    desc.light_name_count = 2;
    assert_int_equal(vxs_stream_open(&stream, &desc), number / 100 == 6 || number / 10 == 20 ? VXS_OK : result_of(number));
    vxs_stream_close(stream);
}

/* The sun's smoke, changed inside; `stores`: and compressed again. */
static void refused_when(void (*change)(part *smoke), int stores, int number)
{
    parts p;
    take_apart(&p, &smoky);
    part *smoke = find_part(&p, VXS_KIND_SMOKE, 0);
    assert_int_equal(smoke->light, SUN);
    change(smoke);
    if (stores) store(smoke);
    vxs_bytes changed = put_together(&p);
    refused_by_stream(&changed, number);
    parts_free(&p);
    free(changed.data);
}

static uint8_t *last_of(vxs_bytes *b)
{
    return b->data + b->size_bytes - 1;
}

static void longer(part *smoke)
{
    smoke->content.data       = realloc(smoke->content.data, ++smoke->content.size_bytes);
    *last_of(&smoke->content) = 0;
}

static void says_less(part *smoke)
{
    smoke->inflated_bytes--;
}

static void small_map(part *smoke)
{
    smoke->content.data[VXS_SMOKE_LEVELS] = 2;
}

static void many_nodes(part *smoke)
{
    smoke->content.data[VXS_SMOKE_PREFIX_BYTES + 1] = VXS_SMOKE_NODES_MAX + 1;
}

/* The first byte of the last plane: more is taken from the light than there is, unless all was there. */
static void rising_light(part *smoke)
{
    uint32_t nodes = vxs_load32(smoke->content.data + VXS_SMOKE_NODE_COUNT);
    memset(last_of(&smoke->content) - nodes + 1, 255, nodes);
}

static void test_damaged_smoke(void **state)
{
    (void)state;
    refused_when(longer, 1, 601);
    refused_when(small_map, 1, 602);
    refused_when(many_nodes, 1, 603);
    refused_when(rising_light, 1, 604);
    refused_when(says_less, 0, 207);

    vxs_bytes   file = {parts_alloc(smoky.size_bytes), smoky.size_bytes, smoky.size_bytes};
    vxs_stream *stream;
    memcpy(file.data, smoky.data, smoky.size_bytes);
    file.data[section_of(whole, SUN)->offset_bytes + 9] ^= 1;
    refused_by_stream(&file, 206);
    file.data[section_of(whole, SUN)->offset_bytes + 9] ^= 1;
    for (size_t cut = 1; cut < 400; cut += 7) { /* the last section ends beyond the file */
        vxs_stream_desc desc = desc_of(&file, ENOUGH);
        desc.size_bytes -= cut;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_TRUNCATED);
    }
    free(file.data);
}

/* A caller that reads. Read `fail_at`, from 1, fails; the second one of a section has a byte that differs. */
typedef struct reading {
    uint64_t calls, fail_at, section_bytes, of_section;
} reading;

static vxs_stream_answer read_badly(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request)
{
    reading *a = user;
    (void)request;
    memcpy(buffer, smoky.data + offset, size_bytes);
    if (++a->calls == a->fail_at) return VXS_STREAM_FAILED;
    if (size_bytes == a->section_bytes && a->of_section++) ((uint8_t *)buffer)[20] ^= 1;
    return VXS_STREAM_READ;
}

static void test_reads_that_fail(void **state)
{
    (void)state;
    vxs_stream_desc desc = desc_of(&smoky, ENOUGH);
    vxs_stream     *stream;
    reading         all = {0}, other = {.section_bytes = section_of(whole, PUNCTUAL)->stored_bytes};
    findings        f = {0};
    desc.bytes        = NULL;
    desc.read         = read_badly;
    desc.read_user    = &all;
    desc.finding      = collect;
    desc.finding_user = &f;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_close(stream);
    for (uint64_t n = 1; n <= all.calls; n++) {
        reading one    = {.fail_at = n};
        desc.read_user = &one;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_READ);
        assert_null(stream);
        assert_int_equal(one.calls, n);
    }
    assert_int_equal(f.count, 0);
    desc.read_user = &other;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_CORRUPT);
    assert_true(other.of_section == 2 && f.first == 206);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    vxs_result result = VXS_E_MEMORY;
    for (uint64_t n = 1; result != VXS_OK; n++) {
        alloc_fail      memory    = {.fail_at = n};
        vxs_allocator   allocator = alloc_fail_allocator(&memory);
        vxs_stream_desc desc      = desc_of(&smoky, ENOUGH);
        vxs_stream     *stream;
        desc.allocator = &allocator;
        result         = vxs_stream_open(&stream, &desc);
        assert_true(result == VXS_OK || (result == VXS_E_MEMORY && !stream));
        assert_in_range(n, 1, 20);
        vxs_stream_close(stream);
        assert_int_equal(memory.live_bytes + memory.wrong_sizes, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lookups_are_those_of_the_file),
        cmocka_unit_test(test_some_lights),
        cmocka_unit_test(test_shaders_answer_as_those_of_the_file),
        cmocka_unit_test(test_what_it_takes),
        cmocka_unit_test(test_damaged_smoke),
        cmocka_unit_test(test_reads_that_fail),
        cmocka_unit_test(test_failing_allocations),
    };
    return cmocka_run_group_tests(tests, make_files, free_files);
}
