/* Streams when things go wrong: no memory, reads that fail, bytes that are not what they should be. Each costs what it has to, and
 * no more.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before the baker, which has a type of a name that is a parameter here */

#include <stdio.h>
#include <xxhash.h>

#include "alloc_fail.h"
#include "baker/base/parallel.h"
#include "baker/coding/blocks/blocks.h" /* before cmocka, whose fail() is a macro */
#include "formats/vxs_bytes.h"
#include "tests/unit/repeats.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "format_parts.h"
#include "formats/vxs_resident_layout.h"
#include "smoke_curves.h"
#include "stream_sample.h"

enum { ENOUGH = 64 << 20, ALL_ATTEMPTS = 8 << (VXS_STREAM_ATTEMPTS + 1) };

static stream_sample sample;

static int set_up(void **state)
{
    (void)state;
    stream_sample_init(&sample, 3);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    stream_sample_free(&sample);
    return 0;
}

static void test_failing_allocations(void **state)
{
    (void)state;
    for (uint64_t n = 1;; n++) {
        alloc_fail      memory    = {.fail_at = n};
        vxs_allocator   allocator = alloc_fail_allocator(&memory);
        vxs_stream_desc desc      = stream_desc_of(&sample, ENOUGH);
        vxs_stream     *stream;
        desc.allocator    = &allocator;
        vxs_result result = vxs_stream_open(&stream, &desc);
        if (result == VXS_OK) {
            stream_fill(stream, &stream_all);
            vxs_stream_close(stream);
            assert_in_range(n, 4, 100);
        } else {
            assert_int_equal(result, VXS_E_MEMORY);
            assert_null(stream);
        }
        assert_int_equal(memory.live_bytes, 0);
        assert_int_equal(memory.wrong_sizes, 0);
        if (result == VXS_OK) break;
    }
}

/* Gives no block of a GiB or more, and counts those that were requested. */
static void *take_little(size_t size_bytes, void *user)
{
    if (size_bytes >> 30) return ++*(int *)user, NULL;
    return malloc(size_bytes);
}

static void free_little(void *memory, size_t size_bytes, void *user)
{
    (void)size_bytes;
    (void)user;
    free(memory);
}

/* A light that claims that it has as many words as can be numbered, beside others: all are too many, whatever the budget. */
static void test_more_words_than_have_numbers(void **state)
{
    (void)state;
    int             asked     = 0;
    vxs_allocator   allocator = {take_little, free_little, &asked};
    parts           p;
    findings        f = {0};
    vxs_stream     *stream;
    vxs_stream_desc desc = stream_desc_of(&sample, UINT64_MAX);
    take_apart(&p, &sample.file);
    part *lights = find_part(&p, VXS_KIND_LIGHTS, 0);
    vxs_store32(lights->content.data + VXS_LIGHTS_PREFIX_BYTES + sample.dag * VXS_LIGHT_BYTES + VXS_LIGHT_WORD_COUNT, UINT32_MAX);
    store(lights);
    vxs_bytes changed = put_together(&p);
    desc.bytes        = changed.data;
    desc.size_bytes   = changed.size_bytes;
    desc.allocator    = &allocator;
    desc.finding      = collect;
    desc.finding_user = &f;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_E_MEMORY);
    assert_true(f.first == 211 && !asked);
    free(changed.data);
    parts_free(&p);
}

/* reads --------------------------------------------------------------------------------------------------------------------------- */

/* Read `fail_at` fails, or each so many; short: half of the bytes come. */
typedef struct bad_reading {
    uint64_t calls, fail_at, fail_every;
    int      all_fail;
} bad_reading;

static vxs_stream_answer read_badly(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request)
{
    bad_reading *b = user;
    (void)request;
    b->calls++;
    int fails = b->all_fail || b->calls == b->fail_at || (b->fail_every && b->calls % b->fail_every == 0);
    memcpy(buffer, sample.file.data + offset, fails ? size_bytes / 2 : size_bytes);
    return fails ? VXS_STREAM_FAILED : VXS_STREAM_READ;
}

static vxs_stream_desc bad_desc(bad_reading *b)
{
    vxs_stream_desc desc = stream_desc_of(&sample, ENOUGH);
    desc.bytes           = NULL;
    desc.read            = read_badly;
    desc.read_user       = b;
    return desc;
}

typedef struct failures {
    uint32_t   count, light, page;
    vxs_result result;
    int        finding;
} failures;

static void count_failure(void *user, uint32_t light, uint32_t page, vxs_result result, int finding)
{
    failures *f = user;
    *f          = (failures){f->count + 1, light, page, result, finding};
}

/* Any read of open that fails is a clear error, and the next one opens. */
static void test_failing_reads_of_open(void **state)
{
    (void)state;
    uint64_t reads = 0;
    for (uint64_t n = 1; n <= reads + 1; n++) {
        bad_reading     b    = {.fail_at = n};
        vxs_stream_desc desc = bad_desc(&b);
        vxs_stream     *stream;
        vxs_result      result = vxs_stream_open(&stream, &desc);
        assert_int_equal(result, n <= b.calls && b.calls >= n && result != VXS_OK ? VXS_E_READ : VXS_OK);
        if (result == VXS_OK) {
            assert_int_equal(b.calls, n - 1); /* the first that is not one of open's */
            assert_in_range(n, 8, 100);
            vxs_stream_close(stream);
            return;
        }
        reads = n;
        assert_null(stream);
    }
    fail_msg("%u reads of open", (unsigned)reads);
}

/* Every n-th read of a page fails, or is short: what it was for is queried again later, and all pages come. */
static void test_failing_reads(void **state)
{
    (void)state;
    for (uint64_t every = 2; every < 8; every++) {
        bad_reading       b      = {0};
        failures          f      = {0};
        vxs_stream_desc   desc   = bad_desc(&b);
        vxs_stream_status status = {.struct_size = sizeof status};
        vxs_stream       *stream;
        stream_tally      tally = {0};
        rng               r     = {every};
        desc.failed             = count_failure;
        desc.failed_user        = &f;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        b.fail_every = every;
        for (int frame = 0; frame < ALL_ATTEMPTS; frame++) {
            vxs_stream_frame(stream, &stream_all, 1, &status);
            if (frame % 16 == 0) stream_check(&sample, stream, &r, 10, &tally);
        }
        assert_int_equal(status.pages_missing + status.pages_failed, 0);
        assert_in_range(f.count, 1, 100);
        assert_int_equal(f.result, VXS_E_READ);
        vxs_stream_close(stream);
    }
}

/* Nothing can be read any more: after some attempts, farther and farther apart, nothing is queried until the caller retries. */
static void test_no_reads(void **state)
{
    (void)state;
    bad_reading       b      = {0};
    vxs_stream_desc   desc   = bad_desc(&b);
    vxs_stream_status status = {.struct_size = sizeof status};
    vxs_stream       *stream;
    assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
    uint64_t opened = b.calls;
    b.all_fail      = 1;
    for (int frame = 0; frame < 2 * ALL_ATTEMPTS; frame++) vxs_stream_frame(stream, &stream_all, 1, &status);
    assert_int_equal(b.calls - opened, VXS_STREAM_ATTEMPTS * sample.page_count);
    assert_int_equal(status.pages_failed, sample.page_count);
    assert_int_equal(status.pages_resident, 0);
    b.all_fail = 0;
    vxs_stream_frame(stream, &stream_all, 1, &status);
    assert_int_equal(status.reads, 0);
    vxs_stream_retry(stream);
    status = stream_fill(stream, &stream_all);
    assert_int_equal(status.pages_resident, sample.page_count);
    vxs_stream_close(stream);
}

/* A file that is written over while it is opened, or a source that lies: one read of open gives other bytes than the file has, or
 * all from that one on do. */
typedef struct fickle_reading {
    const vxs_bytes *file, *other;
    uint32_t         calls, at;
    int              to_end; /* 1: every read from number `at` on, 0: that one alone */
    uint32_t         word, value;
    int              lied; /* 1: a read of no section, whose hash would tell, gave other bytes */
    enum { FROM_OTHER_FILE, OTHER_WORD, ALL_ONES, FLIPPED } change;
} fickle_reading;

static vxs_stream_answer read_fickly(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request)
{
    fickle_reading *f = user;
    (void)request;
    memcpy(buffer, f->file->data + offset, size_bytes);
    f->calls++;
    if (f->calls != f->at && !(f->to_end && f->calls > f->at)) return VXS_STREAM_READ;
    if (f->change == FROM_OTHER_FILE && offset < f->other->size_bytes)
        memcpy(buffer, f->other->data + offset,
               size_bytes < f->other->size_bytes - offset ? size_bytes : f->other->size_bytes - offset);
    if (f->change == OTHER_WORD && 4 * (uint64_t)f->word + 4 <= size_bytes) memcpy((char *)buffer + 4 * f->word, &f->value, 4);
    if (f->change == ALL_ONES) memset(buffer, 0xff, size_bytes);
    if (f->change == FLIPPED && size_bytes) ((uint8_t *)buffer)[f->value % size_bytes] ^= (uint8_t)(1u << f->word % 8);
    f->lied |= size_bytes == RESIDENT_HEAD_BYTES && memcmp(buffer, f->file->data + offset, size_bytes) != 0;
    return VXS_STREAM_READ;
}

/* Open it within a budget: a clear error, or lookups that are the answer of the file where they are full. Returns whether it was
 * opened. */
static int open_fickly(const stream_sample *s, fickle_reading *f, uint64_t budget_bytes)
{
    vxs_stream_desc desc = stream_desc_of(s, budget_bytes);
    vxs_stream     *stream;
    stream_tally    tally = {0};
    rng             r     = {f->at};
    desc.bytes            = NULL;
    desc.read             = read_fickly;
    desc.read_user        = f;
    f->calls              = 0;
    vxs_result result     = vxs_stream_open(&stream, &desc);
    if (result != VXS_OK) {
        assert_true(result >= VXS_E_NOT_VXS && result <= VXS_E_CORRUPT ? 1 : result == VXS_E_MEMORY);
        assert_null(stream);
        return 0;
    }
    for (int frame = 0; frame < 4; frame++) vxs_stream_frame(stream, &stream_all, 1, NULL);
    for (uint32_t n = 0; n < vxs_stream_light_count(stream); n++) {
        const vxs_baked_light *light = vxs_stream_light(stream, n), *full = vxs_asset_light(s->full, n);
        const vxs_baked_smoke *smoke = vxs_stream_smoke(stream, n), *smoke_full = vxs_asset_smoke(s->full, n);
        assert_int_equal(smoke ? smoke->side_px : 0, smoke_full ? smoke_full->side_px : 0);
        for (int k = 0; k < 4; k++) {
            double point[3];
            stream_random_point(&full->light, &r, point);
            assert_true(vxs_smoke_lookup(&light->light, smoke, point) == vxs_smoke_lookup(&full->light, smoke_full, point));
        }
        stream_check_light(s, light, n, &r, 4, &tally);
    }
    vxs_stream_close(stream);
    return 1;
}

/* A file with all that open reads: both packings, a DAG, smoke, in which the same things lie at the same places for every seed. */
static void fickle_sample_init(stream_sample *s, uint64_t seed, uint32_t levels)
{
    static curve_maps curves;
    vxs_smoke_view    smoke[3] = {{0}};
    vxs_contents      contents;
    vxs_bytes         plain = {0};
    block_words       w     = words_of_maps(levels, 1, MAPS_NOISE, seed);
    rng               r     = {seed};
    dag_sample        dag;
    dag_sample_init(&dag, &r, 4, 10);
    vxs_write_light lights[3] = {stream_light_of(&w, levels, VXS_LIGHT_KIND_DIRECTIONAL, 0, VXS_PACKING_SMALL, "sun"),
                                 stream_light_of(&w, levels, VXS_LIGHT_KIND_DIRECTIONAL, 0, VXS_PACKING_FAST, "fast"),
                                 dag_sample_light(&dag, "moon")};
    vxs_write_desc  desc      = {.lights = lights, .light_count = 3, .zstd_level = 1, .metadata = "{}"};
    assert_int_equal(vxs_write(&plain, &desc), VXS_OK);
    random_curves(&curves, &r, 1);
    smoke[0]        = curves_view(&curves, -3, 0.016F);
    smoke[2]        = curves_view(&curves, -1, 0.016F);
    smoke[2].levels = 3; /* of the first tiles */
    *s              = (stream_sample){0};
    assert_int_equal(vxs_read(&contents, plain.data, plain.size_bytes, NULL), VXS_OK);
    assert_int_equal(vxs_write_smoke(&s->file, plain.data, plain.size_bytes, &contents, smoke, 1), VXS_OK);
    vxs_contents_free(&contents);
    free(plain.data);
    block_words_free(&w);
    dag_sample_free(&dag);
    stream_sample_open(s);
}

enum { FICKLE_WORDS = 8, FICKLE_VALUES = 11, FICKLE_CHANGES = FICKLE_WORDS * FICKLE_VALUES + 12 };

/* Kind `n` of change of a read. */
static fickle_reading fickle_change(const stream_sample *file, const stream_sample *other, uint32_t read, uint32_t n)
{
    static const uint32_t values[FICKLE_VALUES] = {0, 1, 5, 100, 1000, 20000, 1 << 16, 1 << 20, 0x3ffffff, 0x7fffffff, UINT32_MAX};
    fickle_reading        f                     = {.file = &file->file, .other = &other->file, .at = read};
    if (n < FICKLE_WORDS * FICKLE_VALUES) {
        f.change = OTHER_WORD;
        f.word   = n / FICKLE_VALUES;
        f.value  = values[n % FICKLE_VALUES];
        return f;
    }
    n -= FICKLE_WORDS * FICKLE_VALUES;
    f.change = n < 2 ? FROM_OTHER_FILE : n < 4 ? ALL_ONES : FLIPPED;
    f.to_end = n < 4 && n % 2;
    f.word   = n;
    f.value  = read * 7919 + n * 104729;
    return f;
}

/* Nothing that was made for what one read said is filled by what another says, whichever of open's reads it is. The budget is the
 * least one at times, so that what goes beyond its room goes beyond the block, which a sanitizer sees. */
static void test_two_reads_that_differ(void **state)
{
    (void)state;
    stream_sample file, other;
    uint32_t      opened = 0, refused = 0;
    fickle_sample_init(&file, 1, 9);
    fickle_sample_init(&other, 2, 9);
    const uint64_t budgets[] = {stream_least_budget(stream_desc_of(&file, 0)), ENOUGH};
    fickle_reading none      = {.file = &file.file, .other = &other.file};
    assert_true(open_fickly(&file, &none, ENOUGH));
    uint32_t reads = none.calls;
    assert_in_range(reads, 12, 60);
    for (uint32_t read = 1; read <= reads; read++)
        for (uint32_t n = 0; n < FICKLE_CHANGES; n++) {
            fickle_reading f       = fickle_change(&file, &other, read, n);
            int            is_open = open_fickly(&file, &f, budgets[(n + read) % 2]);
            if (is_open && f.lied) fail_msg("read %u, change %u: sizes of a first read are those of another", read, n);
            is_open ? opened++ : refused++;
        }
    assert_in_range(opened, 50, UINT32_MAX);
    assert_in_range(refused, 500, UINT32_MAX);
    stream_sample_free(&file);
    stream_sample_free(&other);
}

/* corrupt bytes --------------------------------------------------------------------------------------------------------------------- */

/* The section of a light's pages, and the place of a page's bytes in the file. */
static uint64_t pages_section(const stream_sample *s, uint32_t light)
{
    const vxs_contents *c = vxs_asset_contents(s->full);
    for (uint32_t n = 0; n < c->section_count; n++)
        if (c->sections[n].kind == VXS_KIND_PAGES && c->sections[n].light == light) return c->sections[n].offset_bytes;
    return 0;
}

/* A page's hash does not hold, or its bytes do not; then that page is coarse for good, others come, and once it is mended and
 * requested again all is full. */
static void test_corrupt_pages(void **state)
{
    (void)state;
    for (uint32_t light = 0; light < sample.light_count; light++) {
        if (light == sample.dag) continue;
        uint8_t *table = sample.file.data + pages_section(&sample, light), *at = table + 8 + 16 * (size_t)vxs_load32(table);
        for (uint32_t page = 0; page < vxs_load32(table); at += vxs_load32(table + 8 + 16 * page++))
            for (int where = 0; where < 2; where++) {
                uint8_t          *damaged = where ? at + vxs_load32(table + 8 + 16 * page) / 2 : table + 8 + 16 * page + 8;
                vxs_stream       *stream;
                vxs_stream_desc   desc = stream_desc_of(&sample, ENOUGH);
                vxs_stream_status status;
                failures          f     = {0};
                stream_tally      tally = {0};
                rng               r     = {page};
                desc.failed             = count_failure;
                desc.failed_user        = &f;
                desc.decodes_per_frame  = 64;
                desc.requests           = 64;
                *damaged ^= 0x10;
                assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
                status = (vxs_stream_status){.struct_size = sizeof status};
                for (int frame = 0; frame < 40; frame++) vxs_stream_frame(stream, &stream_all, 1, &status);
                assert_int_equal(status.pages_resident, sample.page_count - 1);
                assert_int_equal(status.pages_failed, 1);
                assert_true(f.count == 1 && f.light == light && f.page == page && f.result == VXS_E_CORRUPT && f.finding == 503);
                stream_check(&sample, stream, &r, 200, &tally);
                assert_in_range(tally.coarse, 1, 700);
                *damaged ^= 0x10;
                if (!where) { /* the table was read by open, and is not read again */
                    vxs_stream_close(stream);
                    continue;
                }
                vxs_stream_retry(stream);
                status = stream_fill(stream, &stream_all);
                assert_int_equal(status.pages_resident, sample.page_count);
                vxs_stream_close(stream);
            }
    }
}

/* A page whose bytes, hash and table agree, but whose words break a rule; or of which the table says too much. */
static void test_pages_of_strangers(void **state)
{
    (void)state;
    rng r = {11};
    for (uint32_t n = 0; n < repeats(60, 2000); n++) {
        uint32_t light = rng_below(&r, sample.light_count - 1);
        if (light == sample.dag) continue;
        uint8_t    *table = sample.file.data + pages_section(&sample, light), *bytes = table + 8 + 16 * (size_t)vxs_load32(table);
        uint32_t    size = vxs_load32(table + 8);
        uint8_t    *kept = malloc(size);
        uint64_t    hash = vxs_load64(table + 16);
        vxs_stream *stream;
        vxs_stream_desc   desc   = stream_desc_of(&sample, ENOUGH);
        vxs_stream_status status = {.struct_size = sizeof status};
        desc.decodes_per_frame   = 64;
        memcpy(kept, bytes, size);
        for (uint32_t k = 0; k <= rng_below(&r, 8); k++) bytes[rng_below(&r, size)] ^= (uint8_t)(1u << rng_below(&r, 8));
        vxs_store64(table + 16, XXH64(bytes, size, 0));
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        for (int frame = 0; frame < 10; frame++) vxs_stream_frame(stream, &stream_all, 1, &status);
        for (int k = 0; k < 100; k++) {
            double                 point[3];
            const vxs_baked_light *l = vxs_stream_light(stream, light);
            stream_random_point(&l->light, &r, point);
            float lit = vxs_lookup(l, point, NULL, vxs_box(9));
            assert_true((lit >= 0 && lit <= 1) || lit == VXS_OUTSIDE);
        }
        vxs_stream_close(stream);
        memcpy(bytes, kept, size);
        vxs_store64(table + 16, hash);
        free(kept);
    }
}

/* Each byte of a small file, one after the other, is another: a clear error, or lookups that are the answer of the file, full or
 * coarse. */
static void test_every_byte(void **state)
{
    (void)state;
    stream_sample         small  = {0};
    block_words           w      = words_of_maps(4, 1, MAPS_NOISE, 1);
    dag_sample            none   = {.levels = 3};
    uint32_t              opened = 0, refused = 0;
    static const uint32_t slices[8] = {0, 0, 0, 2, 2, 1, 1, 1};
    static const uint64_t mask      = 0x000000003c3c0000u;
    vxs_write_light       lights[3] = {stream_light_of(&w, 4, VXS_LIGHT_KIND_DIRECTIONAL, 0, VXS_PACKING_SMALL, "sun"),
                                       stream_light_of(&w, 4, VXS_LIGHT_KIND_DIRECTIONAL, 0, VXS_PACKING_FAST, "fast"),
                                       dag_sample_light(&none, "moon")};
    lights[2].dag        = (vxs_dag_view){.nodes = {slices}, .count = {1}, .level_count = 1, .masks = &mask, .mask_count = 1};
    vxs_write_desc write = {.lights = lights, .light_count = 3, .zstd_level = 1, .metadata = "{}"};
    assert_int_equal(vxs_write(&small.file, &write), VXS_OK);
    stream_sample_open(&small);
    for (size_t n = 0; n < small.file.size_bytes; n++)
        for (int bit = 0; bit < 8; bit += 3) {
            vxs_stream     *stream;
            vxs_stream_desc desc  = stream_desc_of(&small, ENOUGH);
            stream_tally    tally = {0};
            rng             r     = {n};
            small.file.data[n] ^= (uint8_t)(1 << bit);
            vxs_result result = vxs_stream_open(&stream, &desc);
            if (result == VXS_OK) {
                for (int frame = 0; frame < 4; frame++) vxs_stream_frame(stream, &stream_all, 1, NULL);
                stream_check(&small, stream, &r, 3, &tally);
                opened++;
            } else {
                assert_true(result >= VXS_E_NOT_VXS && result <= VXS_E_CORRUPT);
                refused++;
            }
            vxs_stream_close(stream);
            small.file.data[n] ^= (uint8_t)(1 << bit);
        }
    assert_in_range(opened, 100, UINT32_MAX);
    assert_in_range(refused, 1000, UINT32_MAX);
    block_words_free(&w);
    stream_sample_free(&small);
}

/* A file that ends early. */
static void test_every_length(void **state)
{
    (void)state;
    for (size_t size = 0; size < sample.file.size_bytes; size += size < 500 ? 1 : 997) {
        vxs_stream     *stream;
        vxs_stream_desc desc = stream_desc_of(&sample, ENOUGH);
        desc.size_bytes      = size;
        vxs_result result    = vxs_stream_open(&stream, &desc);
        assert_int_equal(result, size > 0 && size < 8 ? VXS_E_NOT_VXS : VXS_E_TRUNCATED);
        assert_null(stream);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_more_words_than_have_numbers),
        cmocka_unit_test(test_failing_allocations),
        cmocka_unit_test(test_failing_reads_of_open),
        cmocka_unit_test(test_failing_reads),
        cmocka_unit_test(test_no_reads),
        cmocka_unit_test(test_two_reads_that_differ),
        cmocka_unit_test(test_corrupt_pages),
        cmocka_unit_test(test_pages_of_strangers),
        cmocka_unit_test(test_every_byte),
        cmocka_unit_test(test_every_length),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
