/* Streams as a program opens them that was written in a hurry: pointers that lead nowhere, unset sizes, one file several times,
 * reads that come short, fail, or end after the stream is closed. Each has an answer or an error.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before the baker, which has a type of a name that is a parameter here */

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "baker/base/parallel.h"
#include "baker/coding/blocks/blocks.h" /* before cmocka, whose fail() is a macro */
#include "repeats.h"
#include "runtime/vxs_query.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "stream_sample.h"

enum { ENOUGH = 64 << 20 };

/* reads by path that go wrong --------------------------------------------------------------------------------------------------------- */

/* What becomes of reads of this program: read `at`, counted from 1, and each so many. */
static struct {
    _Atomic uint64_t calls;
    uint64_t         at, every;
    enum { READ_WHOLE, READ_SHORT, READ_INTERRUPTED, READ_ENDED, READ_BROKEN } becomes;
} reads;

/* In place of the system's. */
ssize_t pread(int descriptor, void *to, size_t size, off_t offset)
{
    uint64_t number = ++reads.calls;
    if (number == reads.at || (reads.every && number % reads.every == 0)) switch (reads.becomes) {
        case READ_WHOLE: break;
        case READ_SHORT: size = (size + 1) / 2; break;
        case READ_ENDED: return 0;
        case READ_INTERRUPTED: errno = EINTR; return -1;
        case READ_BROKEN: errno = EIO; return -1;
        }
    return syscall(SYS_pread64, descriptor, to, size, offset);
}

/* A file of the sample, and what opens it. */
typedef struct on_disk {
    stream_sample   sample;
    char            path[32];
    vxs_stream_desc desc;
} on_disk;

static void on_disk_make(on_disk *d)
{
    stream_sample_init(&d->sample, 3);
    strcpy(d->path, "/tmp/vxs-misuse-XXXXXX");
    int to = mkstemp(d->path);
    assert_true(to >= 0 && write(to, d->sample.file.data, d->sample.file.size_bytes) == (ssize_t)d->sample.file.size_bytes);
    close(to);
    d->desc = (vxs_stream_desc){.struct_size = sizeof d->desc, .path = d->path, .budget_bytes = ENOUGH, .decodes_per_frame = 64};
}

static void on_disk_free(on_disk *d)
{
    unlink(d->path);
    stream_sample_free(&d->sample);
}

/* All pages come within so many frames, and lookups report it. */
static void check_comes(const on_disk *d, vxs_stream *stream, int frames)
{
    vxs_stream_status status = {.struct_size = sizeof status};
    stream_tally      tally  = {0};
    rng               r      = {5};
    for (int n = 0; n < frames && (!n || status.pages_missing); n++)
        assert_int_equal(vxs_stream_frame(stream, &stream_all, 1, &status), VXS_OK);
    assert_int_equal(status.pages_missing + status.pages_failed, 0);
    stream_check(&d->sample, stream, &r, 300, &tally);
    assert_int_equal(tally.coarse, 0);
}

/* Reads that come short or are interrupted are gone on with, whichever they are. One that breaks, or finds that the file has ended,
 * is an error of open, and a page that is requested again. */
static void test_reads_by_path(void **state)
{
    (void)state;
    on_disk d;
    on_disk_make(&d);
    for (int becomes = READ_SHORT; becomes <= READ_BROKEN; becomes++) {
        uint64_t whole_reads = 1, stream_reads = 0;
        int      bad = becomes >= READ_ENDED;
        for (uint64_t at = 1; at <= whole_reads; at++) {
            vxs_asset *asset;
            memset((void *)&reads, 0, sizeof reads);
            reads.at          = at;
            reads.becomes     = becomes;
            vxs_result result = vxs_asset_open_file(&asset, d.path, NULL);
            assert_int_equal(result, bad ? VXS_E_READ : VXS_OK);
            assert_true((asset == NULL) == bad);
            whole_reads = bad ? 1 : reads.calls;
            vxs_asset_close(asset);
        }
        for (uint64_t at = 1; !stream_reads || at <= stream_reads; at++) {
            vxs_stream *stream;
            memset((void *)&reads, 0, sizeof reads);
            reads.at          = at;
            reads.becomes     = becomes;
            vxs_result result = vxs_stream_open(&stream, &d.desc);
            if (result != VXS_OK) {
                assert_true(bad && result == VXS_E_READ && !stream);
                continue;
            }
            assert_true(!bad || reads.calls < at);
            check_comes(&d, stream, 20); /* a page that failed comes 8 frames later */
            stream_reads = reads.calls;
            vxs_stream_close(stream);
        }
        assert_in_range(stream_reads, 20, 200);
        for (uint64_t every = 2; every < 6; every++) {
            vxs_stream *stream;
            memset((void *)&reads, 0, sizeof reads);
            assert_int_equal(vxs_stream_open(&stream, &d.desc), VXS_OK);
            reads.every   = every;
            reads.becomes = becomes;
            check_comes(&d, stream, 8 << (VXS_STREAM_ATTEMPTS + 1));
            vxs_stream_close(stream);
        }
    }
    memset((void *)&reads, 0, sizeof reads);
    on_disk_free(&d);
}

/* Streams with and without threads and a whole asset, all of one file at once. */
static void test_one_file_twice(void **state)
{
    (void)state;
    on_disk     d;
    vxs_stream *streams[3];
    vxs_asset  *asset;
    on_disk_make(&d);
    for (uint32_t n = 0; n < 3; n++) {
        d.desc.threads = n;
        assert_int_equal(vxs_stream_open(&streams[n], &d.desc), VXS_OK);
        vxs_stream_frame(streams[n], &stream_all, 1, NULL);
    }
    assert_int_equal(vxs_asset_open_file(&asset, d.path, NULL), VXS_OK);
    vxs_asset_close(asset);
    unlink(d.path); /* is open */
    for (int n = 0; n < 3; n++) {
        stream_fill(streams[n], &stream_all);
        check_comes(&d, streams[n], 1);
    }
    for (int n = 0; n < 3; n++) vxs_stream_close(streams[n]);
    on_disk_free(&d);
}

/* reads that end late ------------------------------------------------------------------------------------------------------------------ */

/* Reads of a caller that are ended by a thread of its own, some time. */
typedef struct late_read {
    vxs_stream_request *request;
    const uint8_t      *from;
    void               *to;
    uint32_t            size_bytes;
    int                 ok;
} late_read;

static void *end_late(void *work)
{
    late_read l = *(late_read *)work;
    free(work);
    usleep(l.size_bytes % 700);
    if (l.ok) memcpy(l.to, l.from, l.size_bytes);
    vxs_stream_read_done(l.request, l.ok);
    return NULL;
}

static vxs_stream_answer read_late(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request)
{
    const stream_sample *s = user;
    pthread_t            thread;
    if (!request) {
        memcpy(buffer, s->file.data + offset, size_bytes);
        return VXS_STREAM_READ;
    }
    late_read *l = malloc(sizeof *l);
    *l           = (late_read){request, s->file.data + offset, buffer, size_bytes, offset % 5 != 0};
    if (pthread_create(&thread, NULL, end_late, l)) abort();
    pthread_detach(thread);
    return VXS_STREAM_PENDING;
}

/* Streams that are closed while reads are pending, which end meanwhile or after it began. */
static void test_close_before_reads_end(void **state)
{
    (void)state;
    stream_sample s;
    stream_sample_init(&s, 2);
    for (uint32_t n = 0; n < repeats(40, 400); n++) {
        vxs_stream     *stream;
        vxs_stream_desc desc = stream_desc_of(&s, ENOUGH);
        desc.bytes           = NULL;
        desc.read            = read_late;
        desc.read_user       = &s;
        desc.threads         = n % 3;
        desc.requests        = 8;
        assert_int_equal(vxs_stream_open(&stream, &desc), VXS_OK);
        for (uint32_t frame = 0; frame < 1 + n % 5; frame++) vxs_stream_frame(stream, &stream_all, 1, NULL);
        vxs_stream_close(stream);
    }
    stream_sample_free(&s);
}

/* pointers and sizes ------------------------------------------------------------------------------------------------------------------- */

/* What a program does not have: a name, bytes, a path, foci. */
static void test_nothing_given(void **state)
{
    (void)state;
    static const char *const no_name[] = {NULL}, *const twice[] = {"sun", "sun"};
    on_disk     d;
    vxs_asset  *asset;
    vxs_stream *stream;
    on_disk_make(&d);
    assert_int_equal(vxs_asset_open(&asset, NULL, 0, NULL), VXS_E_TRUNCATED);
    assert_int_equal(vxs_asset_open_file(&asset, NULL, NULL), VXS_E_ARGUMENT);
    assert_null(asset);
    assert_null(vxs_asset_find_light(d.sample.full, NULL));
    assert_null(vxs_asset_light(d.sample.full, UINT32_MAX));
    assert_int_equal(vxs_stream_open(&stream, NULL), VXS_E_ARGUMENT);
    d.desc.light_names      = no_name;
    d.desc.light_name_count = 1;
    assert_int_equal(vxs_stream_open(&stream, &d.desc), VXS_E_ARGUMENT);
    d.desc.light_name_count = UINT32_MAX;
    assert_int_equal(vxs_stream_open(&stream, &d.desc), VXS_E_ARGUMENT);
    d.desc.light_names      = twice;
    d.desc.light_name_count = 2;
    assert_int_equal(vxs_stream_open(&stream, &d.desc), VXS_OK);
    assert_null(vxs_stream_find_light(stream, NULL));
    assert_null(vxs_stream_light(stream, UINT32_MAX));
    assert_int_equal(vxs_stream_first_word(stream, UINT32_MAX), 0);
    assert_int_equal(vxs_stream_frame(stream, NULL, 1, NULL), VXS_E_ARGUMENT);
    vxs_stream_status status = stream_fill(stream, &stream_all);
    assert_int_equal(status.pages_resident, 2 * vxs_stream_light(stream, 0)->words[0]);
    vxs_stream_close(stream);
    on_disk_free(&d);
}

/* Foci of any numbers request pages or for none, and nothing goes wrong. */
static void test_wild_foci(void **state)
{
    (void)state;
    static const double numbers[] = {NAN, INFINITY, -INFINITY, 1e30, -1e30, 1e300, -1e300, 0, -0.0, 1, -1, 1e-300};
    on_disk             d;
    vxs_stream         *stream;
    rng                 r    = {10};
    uint32_t            some = 0, none = 0;
    on_disk_make(&d);
    assert_int_equal(vxs_stream_open(&stream, &d.desc), VXS_OK);
    for (int n = 0; n < (int)repeats(1000, 3000); n++) {
        vxs_stream_focus  foci[2]   = {stream_all, stream_all};
        vxs_stream_status status    = {.struct_size = sizeof status};
        double           *fields[8] = {&foci[1].min_ws[0], &foci[1].min_ws[1], &foci[1].min_ws[2],     &foci[1].max_ws[0],
                                       &foci[1].max_ws[1], &foci[1].max_ws[2], &foci[1].radius_metres, &foci[1].weight};
        for (int k = 0; k < 8; k++)
            if (!rng_below(&r, 3)) *fields[k] = numbers[rng_below(&r, sizeof numbers / sizeof *numbers)];
        if (n % 2) foci[1].radius_metres = rng_below(&r, 2) ? 1e-3 : 1e30;
        assert_int_equal(vxs_stream_frame(stream, foci + 1, 1, &status), VXS_OK);
        some += status.pages_wanted != 0;
        none += !status.pages_wanted;
        if (isnan(foci[1].weight) || foci[1].radius_metres < 0 || foci[1].min_ws[0] > foci[1].max_ws[0])
            assert_int_equal(status.pages_wanted, 0);
        assert_int_equal(vxs_stream_frame(stream, foci, 2, &status), VXS_OK);
        assert_int_equal(status.pages_wanted, status.pages);
    }
    assert_true(some > 100 && none > 100);
    check_comes(&d, stream, 200);
    vxs_stream_close(stream);
    on_disk_free(&d);
}

/* Unset sizes of descriptions: none is taken, and no byte beyond a description is looked at. */
static void test_any_struct_size(void **state)
{
    (void)state;
    static const size_t sizes[] = {1, 4, 7, SIZE_MAX, SIZE_MAX / 2, (size_t)1 << 32, 0xcccccccc};
    on_disk             d;
    on_disk_make(&d);
    const vxs_baked_light *light  = vxs_asset_light(d.sample.full, 0);
    vxs_stream_desc       *stream = calloc(1, sizeof *stream); /* of their own, so that a sanitizer sees where they end */
    vxs_read_desc         *read   = calloc(1, sizeof *read);
    vxs_batch             *batch  = calloc(1, sizeof *batch);
    vxs_depth_map_desc    *map    = calloc(1, sizeof *map);
    for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++) {
        vxs_stream *opened;
        vxs_asset  *asset;
        stream->struct_size = read->struct_size = batch->struct_size = map->struct_size = sizes[n];
        assert_int_equal(vxs_stream_open(&opened, stream), VXS_E_ARGUMENT);
        assert_int_equal(vxs_asset_open(&asset, d.sample.file.data, d.sample.file.size_bytes, read), VXS_E_ARGUMENT);
        assert_int_equal(vxs_lookup_batch(light, 1, batch), VXS_E_ARGUMENT);
        assert_int_equal(vxs_depth_map(light, map, NULL), VXS_E_ARGUMENT);
        assert_true(!opened && !asset);
    }
    free(stream);
    free(read);
    free(batch);
    free(map);
    on_disk_free(&d);
}

/* Budgets from nothing to all there is. */
static void test_any_budget(void **state)
{
    (void)state;
    on_disk d;
    int     opens = 0;
    on_disk_make(&d);
    for (int bit = -1; bit <= 64; bit++) {
        vxs_stream *stream;
        d.desc.budget_bytes = bit < 0 ? 0 : bit < 64 ? (uint64_t)1 << bit : UINT64_MAX;
        vxs_result result   = vxs_stream_open(&stream, &d.desc);
        assert_int_equal(result, opens || result == VXS_OK ? VXS_OK : VXS_E_MEMORY);
        if (result == VXS_OK) {
            vxs_stream_status status = {.struct_size = sizeof status};
            for (int n = 0; n < 3; n++) vxs_stream_frame(stream, &stream_all, 1, &status);
            assert_true(status.bytes_held <= d.desc.budget_bytes && status.bytes_held < ENOUGH);
            opens++;
        }
        vxs_stream_close(stream);
    }
    assert_in_range(opens, 64 - 25, 64 - 19); /* from some MiB on */
    on_disk_free(&d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reads_by_path), cmocka_unit_test(test_one_file_twice), cmocka_unit_test(test_close_before_reads_end),
        cmocka_unit_test(test_nothing_given), cmocka_unit_test(test_wild_foci),      cmocka_unit_test(test_any_struct_size),
        cmocka_unit_test(test_any_budget),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
