/* Streams: answers of lookups while pages come and go, for every source, and within every budget.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before the baker, which has a type of a name that is a parameter here */

#include <stdio.h>
#include <unistd.h>

#include "alloc_fail.h"
#include "baker/base/parallel.h"
#include "baker/coding/blocks/blocks.h" /* before cmocka, whose fail() is a macro */
#include "tests/unit/repeats.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "stream_sample.h"

enum { ENOUGH = 64 << 20 };

static stream_sample sample;

static int set_up(void **state)
{
    (void)state;
    stream_sample_init(&sample, 2);
    assert_in_range(sample.page_count, 8, 1000);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    stream_sample_free(&sample);
    return 0;
}

/* sources ------------------------------------------------------------------------------------------------------------------------ */

/* A caller that reads: at once, which threads of the stream may do side by side, or later. */
typedef struct reading {
    _Atomic uint64_t    calls, bytes;
    uint64_t            fail_every; /* each so many fail */
    int                 later, failing_short;
    vxs_stream_request *pending[VXS_STREAM_REQUESTS_MAX];
    uint64_t            offset[VXS_STREAM_REQUESTS_MAX];
    uint32_t            size[VXS_STREAM_REQUESTS_MAX];
    void               *buffer[VXS_STREAM_REQUESTS_MAX];
    int                 pending_count;
} reading;

static vxs_stream_answer read_sample(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request)
{
    reading *a = user;
    assert_true(size_bytes <= sample.file.size_bytes && offset <= sample.file.size_bytes - size_bytes);
    uint64_t call = ++a->calls;
    if (a->fail_every && call % a->fail_every == 0) {
        if (a->failing_short) memcpy(buffer, sample.file.data + offset, size_bytes / 2);
        return VXS_STREAM_FAILED;
    }
    a->bytes += size_bytes;
    if (a->later && request) {
        assert_true(a->pending_count < VXS_STREAM_REQUESTS_MAX);
        a->pending[a->pending_count] = request;
        a->offset[a->pending_count]  = offset;
        a->size[a->pending_count]    = size_bytes;
        a->buffer[a->pending_count]  = buffer;
        a->pending_count++;
        return VXS_STREAM_PENDING;
    }
    memcpy(buffer, sample.file.data + offset, size_bytes);
    return VXS_STREAM_READ;
}

/* Pending reads end, in any order; some of them fail. */
static void end_reads(reading *a, rng *r, int all)
{
    while (a->pending_count && (all || rng_below(r, 3))) {
        int n = (int)rng_below(r, (uint32_t)a->pending_count), last = --a->pending_count;
        int ok = all || rng_below(r, 4);
        if (ok) memcpy(a->buffer[n], sample.file.data + a->offset[n], a->size[n]);
        vxs_stream_request *request = a->pending[n];
        a->pending[n]               = a->pending[last];
        a->offset[n]                = a->offset[last];
        a->size[n]                  = a->size[last];
        a->buffer[n]                = a->buffer[last];
        vxs_stream_read_done(request, ok);
    }
}

static vxs_stream_desc desc_by_reading(reading *a, uint64_t budget_bytes)
{
    vxs_stream_desc desc = stream_desc_of(&sample, budget_bytes);
    desc.bytes           = NULL;
    desc.read            = read_sample;
    desc.read_user       = a;
    return desc;
}

/* All pages of a stream come, and then every lookup is full. */
static void check_all_come(const vxs_stream_desc *desc)
{
    vxs_stream  *stream;
    stream_tally before = {0}, after = {0};
    rng          r = {3};
    assert_int_equal(vxs_stream_open(&stream, desc), VXS_OK);
    assert_int_equal(vxs_stream_light_count(stream), sample.light_count);
    stream_check(&sample, stream, &r, 1000, &before);
    assert_in_range(before.other, 500, 4000);
    vxs_stream_status status = stream_fill(stream, &stream_all);
    assert_int_equal(status.pages, sample.page_count);
    assert_int_equal(status.pages_resident, sample.page_count);
    assert_int_equal(status.pages_wanted, sample.page_count);
    assert_int_equal(status.pages_missing + status.pages_coming + status.pages_failed, 0);
    assert_in_range(status.bytes_read, sample.file.size_bytes * 9 / 10, sample.file.size_bytes * 11 / 10);
    stream_check(&sample, stream, &r, 3000, &after);
    assert_int_equal(after.coarse, 0);
    vxs_stream_close(stream);
}

static void test_memory(void **state)
{
    (void)state;
    vxs_stream_desc desc = stream_desc_of(&sample, ENOUGH);
    check_all_come(&desc);
    desc.decodes_per_frame = 100;
    check_all_come(&desc);
    desc.threads = 3;
    check_all_come(&desc);
}

static void test_file(void **state)
{
    (void)state;
    char path[] = "/tmp/vxs-stream-XXXXXX";
    int  to     = mkstemp(path);
    assert_true(to >= 0 && write(to, sample.file.data, sample.file.size_bytes) == (ssize_t)sample.file.size_bytes);
    close(to);
    vxs_stream_desc desc = stream_desc_of(&sample, ENOUGH);
    desc.bytes           = NULL;
    desc.path            = path;
    for (desc.threads = 0; desc.threads < 3; desc.threads++) check_all_come(&desc);

    vxs_stream *stream;
    desc.path = "/no/such/file.vxs";
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_NO_FILE);
    desc.path = "/tmp";
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_READ);
    assert_null(stream);
    unlink(path);
}

static void test_callback(void **state)
{
    (void)state;
    reading         a    = {0};
    vxs_stream_desc desc = desc_by_reading(&a, ENOUGH);
    check_all_come(&desc);
    desc.threads = 2;
    check_all_come(&desc);
}

/* Jobs of the caller: run at once, or kept and run between frames. */
typedef struct jobs {
    void (*run[VXS_STREAM_THREADS_MAX])(void *);
    void *job[VXS_STREAM_THREADS_MAX];
    int   count, at_once;
} jobs;

static void submit(void *user, void (*run)(void *job), void *job)
{
    jobs *j = user;
    if (j->at_once) {
        run(job);
        return;
    }
    assert_true(j->count < VXS_STREAM_THREADS_MAX);
    j->run[j->count]   = run;
    j->job[j->count++] = job;
}

static void run_jobs(jobs *j)
{
    for (int n = 0; n < j->count; n++) j->run[n](j->job[n]);
    j->count = 0;
}

static void test_submit(void **state)
{
    (void)state;
    jobs            j    = {.at_once = 1};
    vxs_stream_desc desc = stream_desc_of(&sample, ENOUGH);
    desc.submit          = submit;
    desc.submit_user     = &j;
    check_all_come(&desc);

    vxs_stream       *stream;
    vxs_stream_status status = {.struct_size = sizeof status};
    stream_tally      tally  = {0};
    rng               r      = {4};
    j.at_once                = 0;
    desc.threads             = 2;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    for (int frame = 0; frame < 200 && (frame < 2 || status.pages_missing); frame++) {
        assert_int_equal(vxs_stream_frame(stream, &stream_all, 1, &status), VXS_OK);
        assert_in_range(j.count, status.pages_coming ? 1 : 0, 2);
        run_jobs(&j);
        stream_check(&sample, stream, &r, 10, &tally);
    }
    assert_int_equal(status.pages_missing, 0);
    run_jobs(&j);
    vxs_stream_close(stream);
}

/* what a frame does -------------------------------------------------------------------------------------------------------------- */

static vxs_stream_focus random_focus(rng *r)
{
    vxs_stream_focus f;
    double           point[3];
    const vxs_light *light = &vxs_asset_light(sample.full, rng_below(r, sample.light_count))->light;
    stream_random_point(light, r, point);
    f        = vxs_stream_camera(point, rng_below(r, 4) ? rng_between(r, 1, 4000) / 10.0 : 0);
    f.weight = rng_below(r, 3) ? 0 : rng_between(r, 1, 30) / 10.0;
    if (!rng_below(r, 4))
        for (int k = 0; k < 3; k++) f.max_ws[k] += rng_between(r, 0, 100);
    return f;
}

/* One stream under a random path: what it holds, its status, and answers of lookups. */
static void check_path(uint64_t budget, uint64_t seed, stream_tally *tally, uint32_t *left)
{
    rng             r         = {seed};
    alloc_fail      memory    = {0};
    vxs_allocator   allocator = alloc_fail_allocator(&memory);
    reading         a         = {.later = rng_below(&r, 2) != 0};
    jobs            j         = {0};
    vxs_stream_desc desc      = rng_below(&r, 2) ? desc_by_reading(&a, budget) : stream_desc_of(&sample, budget);
    desc.allocator            = &allocator;
    desc.requests             = rng_below(&r, 6);
    int submits               = rng_below(&r, 2) != 0;
    if (submits) {
        desc.submit      = submit;
        desc.submit_user = &j;
    }
    vxs_stream *stream;
    vxs_result  result = vxs_stream_open(&stream, &desc);
    a.fail_every       = rng_below(&r, 3) ? 0 : 9;
    assert_in_range(memory.peak_bytes, 0, budget);
    if (result != VXS_OK) assert_int_equal(result, VXS_E_MEMORY);
    uint64_t held = memory.live_bytes, calls = memory.calls;
    for (int frame = 0; frame < 60 && result == VXS_OK; frame++) {
        vxs_stream_focus  foci[3] = {random_focus(&r), random_focus(&r), random_focus(&r)};
        vxs_stream_status status  = {.struct_size = sizeof status};
        assert_int_equal(vxs_stream_frame(stream, foci, rng_below(&r, 4), &status), VXS_OK);
        assert_int_equal(status.bytes_held, held);
        assert_in_range(status.bytes_resident, 0, held);
        assert_in_range(status.pages_missing, 0, status.pages_wanted);
        *left += status.left;
        stream_check(&sample, stream, &r, 8, tally);
        if (rng_below(&r, 2)) run_jobs(&j);
        end_reads(&a, &r, 0);
    }
    assert_true(memory.live_bytes == held && memory.calls == calls); /* nothing is allocated after open */
    while (a.pending_count || j.count) { /* a job may request another read, and a read that ends for a job */
        end_reads(&a, &r, 1);
        run_jobs(&j);
    }
    vxs_stream_close(stream);
    assert_int_equal(memory.live_bytes, 0);
    assert_int_equal(memory.wrong_sizes, 0);
}

static void test_random_paths(void **state)
{
    (void)state;
    stream_tally tally = {0};
    uint32_t     left  = 0;
    uint64_t     least = stream_least_budget(stream_desc_of(&sample, 0));
    for (uint32_t n = 0; n < repeats(30, 1000); n++)
        check_path(n % 10 ? least + (uint64_t)n % 7 * 150000 : least - 1 - n, n, &tally, &left);
    assert_in_range(tally.full, 1000, UINT32_MAX);
    assert_in_range(tally.other, 1000, UINT32_MAX);
    assert_in_range(left, 100, UINT32_MAX);
}

/* The least budget, or one byte less: a clear error, or answers that are coarse. Zero is an error. */
static void test_least_budget(void **state)
{
    (void)state;
    vxs_stream     *stream;
    vxs_stream_desc desc = stream_desc_of(&sample, 0);
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_MEMORY);
    assert_null(stream);
    desc.budget_bytes = stream_least_budget(desc);
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    stream_tally tally = {0};
    rng          r     = {5};
    for (int frame = 0; frame < 20; frame++) {
        vxs_stream_focus eye = random_focus(&r);
        vxs_stream_frame(stream, &eye, 1, NULL);
        stream_check(&sample, stream, &r, 50, &tally);
    }
    assert_in_range(tally.other, 500, UINT32_MAX);
    vxs_stream_close(stream);
}

/* Lookups with the widest filter in a box that all pages of it have room for. */
static void check_box(const vxs_stream_focus *box, rng *r, uint32_t *wanted)
{
    vxs_stream     *stream;
    vxs_stream_desc desc = stream_desc_of(&sample, ENOUGH);
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_status status = stream_fill(stream, box);
    assert_int_equal(status.pages_resident, status.pages_wanted);
    *wanted += status.pages_wanted;
    for (int k = 0; k < 500; k++) {
        double in[3], normal[3] = {(k & 1 ? 0.6 : -0.6), (k & 2 ? 0.64 : -0.64), (k & 4 ? 0.48 : -0.48)};
        for (int axis = 0; axis < 3; axis++)
            in[axis] = box->min_ws[axis] + (box->max_ws[axis] - box->min_ws[axis]) * rng_below(r, 1025) / 1024;
        for (uint32_t l = 0; l < sample.light_count; l++)
            if (!vxs_lookup_is_full(vxs_stream_light(stream, l), in, k & 8 ? normal : NULL, vxs_box(VXS_FILTER_MAX)))
                fail_msg("light %u at %g %g %g: coarse", l, in[0], in[1], in[2]);
    }
    vxs_stream_close(stream);
}

/* A box of world space, and points beside borders of pages: once their pages are there, every lookup in them is full. */
static void test_region(void **state)
{
    (void)state;
    rng      r      = {6};
    uint32_t wanted = 0;
    for (int n = 0; n < 60; n++) {
        const vxs_light *light = &vxs_asset_light(sample.full, n % 3 ? 0 : rng_below(&r, sample.light_count))->light;
        double           side  = (double)(1u << light->levels), point[3];
        double at[3] = {side * rng_below(&r, 1000) / 1000, side * rng_below(&r, 1000) / 1000, side * rng_below(&r, 1000) / 1000};
        if (n % 3) at[n & 1] = 512 + rng_between(&r, -170, 170) / 10.0;
        vxs_point(light, 0, at, point);
        vxs_stream_focus box = vxs_stream_camera(point, 1e-9);
        for (int k = 0; k < 3 && n % 3 == 0; k++) box.max_ws[k] += rng_between(&r, 0, 20);
        check_box(&box, &r, &wanted);
    }
    assert_in_range(wanted, 60, 60 * (sample.page_count - 2)); /* far from all of them */
}

/* Fewer pages are wanted by a near focus than by all, and the nearest come first. */
static void test_nearest_first(void **state)
{
    (void)state;
    vxs_stream      *stream;
    vxs_stream_desc  desc = stream_desc_of(&sample, ENOUGH);
    double           corner[3], at[3] = {100, 100, 500};
    const vxs_light *sun = &vxs_asset_light(sample.full, 0)->light;
    vxs_point(sun, 0, at, corner);
    vxs_stream_focus eye = vxs_stream_camera(corner, 0);
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_frame(stream, &eye, 1, NULL);
    for (int n = 0; n < 3; n++) vxs_stream_frame(stream, &eye, 1, NULL);
    assert_true(vxs_lookup_is_full(vxs_stream_light(stream, 0), corner, NULL, vxs_box(9)));
    vxs_stream_status few = {.struct_size = sizeof few};
    eye.radius_metres     = 1;
    vxs_stream_frame(stream, &eye, 1, &few);
    assert_in_range(few.pages_wanted, 1, sample.page_count - 1);
    eye.max_ws[0] = (double)NAN;
    vxs_stream_frame(stream, &eye, 1, &few);
    assert_int_equal(few.pages_wanted, 0);
    vxs_stream_close(stream);
}

/* A copy of the words that follows changes agrees, without looking at any other word. */
static void test_changes(void **state)
{
    (void)state;
    vxs_stream     *stream;
    vxs_stream_desc desc = stream_desc_of(&sample, stream_least_budget(stream_desc_of(&sample, 0)) + 400000);
    uint32_t        count, ranges, changed = 0;
    rng             r = {7};
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    const uint32_t *words = vxs_stream_words(stream, &count);
    uint32_t       *copy  = malloc((count + (size_t)4) * sizeof *copy);
    memcpy(copy, words, count * sizeof *copy);
    for (int frame = 0; frame < 100; frame++) {
        vxs_stream_focus eye = random_focus(&r);
        vxs_stream_frame(stream, &eye, 1, NULL);
        const vxs_stream_range *range = vxs_stream_changes(stream, &ranges);
        for (uint32_t n = 0; n < ranges; n++) {
            assert_true(range[n].first_word < count && range[n].word_count <= count - range[n].first_word);
            memcpy(copy + range[n].first_word, words + range[n].first_word, range[n].word_count * sizeof *copy);
            changed++;
        }
        for (uint32_t n = 0; n < sample.light_count; n++) {
            vxs_baked_light mirror = *vxs_stream_light(stream, n);
            stream_tally    tally  = {0};
            mirror.words           = copy + vxs_stream_first_word(stream, n);
            stream_check_light(&sample, &mirror, n, &r, 20, &tally);
        }
    }
    assert_in_range(changed, 50, UINT32_MAX);
    free(copy);
    vxs_stream_close(stream);
}

/* An eye that sways: when what fits has come, nothing comes and goes. */
static void check_sway(uint64_t least, uint64_t seed, uint32_t *late, uint32_t *full)
{
    vxs_stream       *stream;
    vxs_stream_desc   desc   = stream_desc_of(&sample, 0);
    vxs_stream_status status = {.struct_size = sizeof status};
    rng               r      = {seed};
    double            middle[3];
    desc.budget_bytes = least + 30000 * rng_below(&r, 30);
    stream_random_point(&vxs_asset_light(sample.full, 0)->light, &r, middle);
    if (seed % 4) /* beside the border of four pages of the sun */
        vxs_point(&vxs_asset_light(sample.full, 0)->light, 0, (double[3]){512, 512, -30.0 * rng_below(&r, 30)}, middle);
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    for (int frame = 0; frame < 100; frame++) {
        vxs_stream_focus eye = vxs_stream_camera(middle, 0);
        for (int k = 0; k < 3; k++) eye.min_ws[k] = eye.max_ws[k] = middle[k] + (frame & 1 ? 0.25 : -0.25);
        vxs_stream_frame(stream, &eye, 1, &status);
        if (frame > 30) *late += status.appeared + status.left;
    }
    *full += status.pages_missing && status.pages_resident;
    vxs_stream_close(stream);
}

static void test_no_thrash(void **state)
{
    (void)state;
    uint32_t late = 0, full = 0;
    uint64_t least = stream_least_budget(stream_desc_of(&sample, 0));
    for (uint64_t seed = 0; seed < repeats(40, 100); seed++) check_sway(least, seed, &late, &full);
    assert_int_equal(late, 0);
    assert_in_range(full, repeats(12, 30), 100);
}

/* lights -------------------------------------------------------------------------------------------------------------------------- */

/* One light of several, and two in another order. */
static void test_some_lights(void **state)
{
    (void)state;
    static const char *const names[] = {"spot", "sun"};
    reading                  a       = {0};
    vxs_stream_desc          desc    = desc_by_reading(&a, ENOUGH);
    vxs_stream              *stream;
    rng                      r = {8};
    desc.light_names           = names;
    for (desc.light_name_count = 1; desc.light_name_count <= 2; desc.light_name_count++) {
        stream_tally tally = {0};
        a.bytes            = 0;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        assert_int_equal(vxs_stream_light_count(stream), desc.light_name_count);
        vxs_stream_status status = stream_fill(stream, &stream_all);
        assert_int_equal(a.bytes, status.bytes_read);
        if (desc.light_name_count == 1) assert_in_range(a.bytes, 0, sample.file.size_bytes / 4);
        stream_check_light(&sample, vxs_stream_find_light(stream, "spot"), 2, &r, 1000, &tally);
        if (desc.light_name_count == 2) stream_check_light(&sample, vxs_stream_light(stream, 1), 0, &r, 1000, &tally);
        assert_int_equal(tally.coarse, 0);
        assert_null(vxs_stream_find_light(stream, "moon"));
        assert_null(vxs_stream_light(stream, desc.light_name_count));
        vxs_stream_close(stream);
    }
    static const char *const unknown[] = {"sun", "none"};
    desc.light_names                   = unknown;
    desc.light_name_count              = 2;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_ARGUMENT);
    desc.light_name_count = 0;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_ARGUMENT);
}

/* 10 000 lights: ten streams of a thousand each, which is as many as a file has, or nearly. */
static void test_many_lights(void **state)
{
    (void)state;
    enum { FILES = 10, LIGHTS = 1000 };
    block_words      w      = words_of_maps(4, 1, MAPS_NOISE, 5);
    vxs_write_light *lights = calloc(LIGHTS, sizeof *lights);
    vxs_stream      *streams[FILES];
    vxs_bytes        file = {0};
    vxs_asset       *asset;
    rng              r = {9};
    for (int n = 0; n < LIGHTS; n++) {
        char name[16];
        snprintf(name, sizeof name, "sun %d", n);
        lights[n] = stream_light_of(&w, 4, VXS_LIGHT_KIND_DIRECTIONAL, 0, VXS_PACKING_FAST, name);
    }
    vxs_write_desc write = {.lights = lights, .light_count = LIGHTS, .zstd_level = 1};
    assert_int_equal(vxs_write(&file, &write), VXS_OK);
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    vxs_stream_desc desc = {.struct_size = sizeof desc, .bytes = file.data, .size_bytes = file.size_bytes, .budget_bytes = ENOUGH};
    desc.decodes_per_frame = LIGHTS;
    desc.requests          = VXS_STREAM_REQUESTS_MAX;
    for (int n = 0; n < FILES; n++) assert_int_equal(vxs_stream_open(&streams[n], &desc), VXS_OK);
    for (int n = 0; n < FILES; n++) {
        vxs_stream_status status = stream_fill(streams[n], &stream_all);
        assert_int_equal(status.pages_resident, LIGHTS);
        for (int k = 0; k < (int)repeats(400, 2000); k++) {
            const vxs_baked_light *light = vxs_stream_light(streams[n], rng_below(&r, LIGHTS)), *full = vxs_asset_light(asset, 0);
            double                 point[3];
            stream_random_point(&full->light, &r, point);
            assert_true(vxs_lookup(light, point, NULL, vxs_box(5)) == vxs_lookup(full, point, NULL, vxs_box(5)));
        }
    }
    for (int n = 0; n < FILES; n++) vxs_stream_close(streams[n]);
    vxs_asset_close(asset);
    block_words_free(&w);
    free(lights);
    free(file.data);
}

/* Names say where pages are, and pages that are not there have none. */
static void test_pages(void **state)
{
    (void)state;
    vxs_stream     *stream;
    vxs_stream_desc desc = stream_desc_of(&sample, stream_least_budget(stream_desc_of(&sample, 0)) + 900000);
    uint32_t        count, here = 0, away = 0;
    rng             r = {9};
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    const uint32_t *words = vxs_stream_words(stream, &count);
    for (int frame = 0; frame < 50; frame++) {
        vxs_stream_focus  eye    = random_focus(&r);
        vxs_stream_status status = {.struct_size = sizeof status};
        uint64_t          bytes  = 0;
        vxs_stream_frame(stream, &eye, 1, &status);
        for (uint32_t n = 0; n < sample.light_count; n++) {
            vxs_stream_range names = vxs_stream_names(stream, n);
            assert_int_equal(names.word_count, n == sample.dag ? 0 : words[vxs_stream_first_word(stream, n)]);
            for (uint32_t page = 0; page < names.word_count; page++) {
                vxs_stream_range at   = vxs_stream_page(stream, n, page);
                uint32_t         name = words[names.first_word + page];
                assert_int_equal(at.word_count != 0, name != 0);
                assert_int_equal(at.first_word, name ? vxs_stream_first_word(stream, n) + name : 0);
                assert_true(at.first_word <= count && at.word_count <= count - at.first_word);
                bytes += 4 * (uint64_t)at.word_count;
                here += name != 0;
                away += name == 0;
            }
            assert_int_equal(vxs_stream_page(stream, n, names.word_count).word_count, 0);
        }
        assert_true(bytes < status.bytes_resident && status.bytes_resident - bytes < desc.budget_bytes);
    }
    assert_int_equal(vxs_stream_names(stream, sample.light_count).word_count, 0);
    assert_int_equal(vxs_stream_page(stream, sample.light_count, 0).word_count, 0);
    assert_true(here > 50 && away > 50);
    vxs_stream_close(stream);
}

static void keep_text(void *user, const char *text, size_t size_bytes)
{
    snprintf(user, 16, "%.*s", (int)size_bytes, text);
}

/* The text is what was written; who does not know of the field is not called, and none of it is held. */
static void test_metadata(void **state)
{
    (void)state;
    vxs_stream       *stream;
    char              text[16] = "";
    vxs_stream_desc   desc     = stream_desc_of(&sample, ENOUGH);
    vxs_stream_status with = {.struct_size = sizeof with}, without = with;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_frame(stream, NULL, 0, &without);
    vxs_stream_close(stream);
    desc.metadata      = keep_text;
    desc.metadata_user = text;
    desc.struct_size   = offsetof(vxs_stream_desc, metadata);
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_close(stream);
    assert_string_equal(text, "");
    desc.struct_size = sizeof desc;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    vxs_stream_frame(stream, NULL, 0, &with);
    vxs_stream_close(stream);
    assert_string_equal(text, "{}");
    assert_int_equal(with.bytes_held, without.bytes_held);
    assert_true(with.bytes_read > without.bytes_read);
}

static void test_arguments(void **state)
{
    (void)state;
    vxs_stream       *stream;
    vxs_stream_status status = {.struct_size = sizeof status - 8};
    vxs_stream_desc   desc   = stream_desc_of(&sample, ENOUGH), bad[5];
    for (int n = 0; n < 5; n++) bad[n] = desc;
    bad[0].struct_size = offsetof(vxs_stream_desc, metadata) - 1;
    bad[1].path        = "/tmp/both";
    bad[2].bytes       = NULL;
    bad[3].threads     = VXS_STREAM_THREADS_MAX + 1;
    bad[4].requests    = VXS_STREAM_REQUESTS_MAX + 1;
    for (int n = 0; n < 5; n++) {
        assert_int_equal(vxs_stream_open(&stream, &bad[n]), VXS_E_ARGUMENT);
        assert_null(stream);
    }
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    assert_int_equal(vxs_stream_frame(stream, NULL, 0, &status), VXS_E_ARGUMENT);
    assert_int_equal(vxs_stream_frame(stream, NULL, 0, NULL), VXS_OK);
    vxs_stream_retry(stream);
    vxs_stream_wait(stream);
    vxs_stream_close(stream);
    vxs_stream_close(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_memory),    cmocka_unit_test(test_file),          cmocka_unit_test(test_callback),
        cmocka_unit_test(test_submit),    cmocka_unit_test(test_random_paths),  cmocka_unit_test(test_least_budget),
        cmocka_unit_test(test_region),    cmocka_unit_test(test_nearest_first), cmocka_unit_test(test_changes),
        cmocka_unit_test(test_no_thrash), cmocka_unit_test(test_some_lights),   cmocka_unit_test(test_many_lights),
        cmocka_unit_test(test_pages),     cmocka_unit_test(test_metadata),      cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
