/* Squares in files (baker/bake/cache/), of the cache and of a part: every wrong bit and every missing end is found, and so are
 * wrong contents under a right checksum.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "baker/bake/cache/cache_folder.h" /* before cmocka, whose fail() is a macro */
#include "baker/bake/cache/part_file.h"

#include <cmocka.h>

enum { SQUARES = 3, PART = 2, PARTS = 4, RECORD_BYTES = 40 };

static const column_key keys[SQUARES] = {{1, 2}, {3, 4}, {5, 6}};

/* Another record for each square; the last one is empty. */
static vxs_bytes record_of(int square, uint8_t bytes[RECORD_BYTES])
{
    for (int n = 0; n < RECORD_BYTES; n++) bytes[n] = (uint8_t)(n * 7 + square);
    return (vxs_bytes){bytes, square == SQUARES - 1 ? 0 : RECORD_BYTES, RECORD_BYTES};
}

/* A call for each file that differs in a bit, or ends early, or late. */
static void each_fault(const vxs_bytes *sound, void (*check_bytes)(const uint8_t *bytes, size_t size_bytes, void *of), void *of)
{
    uint8_t *bytes = malloc(sound->size_bytes + 1);
    assert_non_null(bytes);
    memcpy(bytes, sound->data, sound->size_bytes);
    for (size_t bit = 0; bit < 8 * sound->size_bytes; bit++) {
        bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
        check_bytes(bytes, sound->size_bytes, of);
        bytes[bit / 8] ^= (uint8_t)(1 << bit % 8);
    }
    for (size_t size = 0; size < sound->size_bytes; size++) check_bytes(bytes, size, of);
    bytes[sound->size_bytes] = 0;
    check_bytes(bytes, sound->size_bytes + 1, of);
    free(bytes);
}

/* squares of the cache ------------------------------------------------------------------------------------------------------- */

static vxs_result read_square(const uint8_t *bytes, size_t size_bytes, const column_key *key)
{
    vxs_bytes copy = {malloc(size_bytes + 1), size_bytes, size_bytes + 1};
    memcpy(copy.data, bytes, size_bytes);
    vxs_result r = square_file_read(&copy, key);
    free(copy.data);
    return r;
}

static void is_no_square(const uint8_t *bytes, size_t size_bytes, void *of)
{
    (void)of;
    assert_int_equal(read_square(bytes, size_bytes, &keys[0]), VXS_E_CORRUPT);
}

static void faults_of_a_square_file(void **state)
{
    uint8_t   bytes[RECORD_BYTES];
    vxs_bytes record = record_of(0, bytes), file = {0};
    (void)state;
    assert_int_equal(square_file_write(&keys[0], &record, &file), VXS_OK);
    assert_int_equal(read_square(file.data, file.size_bytes, &keys[0]), VXS_OK);
    assert_int_equal(read_square(file.data, file.size_bytes, &keys[1]), VXS_E_CORRUPT);
    each_fault(&file, is_no_square, NULL);
    free(file.data);
}

/* parts ----------------------------------------------------------------------------------------------------------------------- */

/* A part, and a file in memory that has become it, but for a fault. */
typedef struct part_copy {
    char      path[64];
    int       file;
    vxs_bytes sound;
} part_copy;

static void write_file(const part_copy *f, const uint8_t *bytes, size_t size_bytes)
{
    FILE *file = fopen(f->path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size_bytes, file), size_bytes);
    assert_int_equal(fclose(file), 0);
}

static void read_file(part_copy *f)
{
    uint8_t bytes[1 << 14];
    FILE   *file = fopen(f->path, "rb");
    assert_non_null(file);
    f->sound = (vxs_bytes){.size_bytes = fread(bytes, 1, sizeof bytes, file)};
    fclose(file);
    assert_in_range(f->sound.size_bytes, 1, sizeof bytes - 1);
    f->sound.data = malloc(f->sound.size_bytes);
    memcpy(f->sound.data, bytes, f->sound.size_bytes);
}

static int write_part(void **state)
{
    part_copy  *f      = calloc(1, sizeof *f);
    run_context m      = {0};
    vxs_bytes   common = {(uint8_t *)(char[]){"what all parts share"}, 20, 20};
    part_writer w;
    char        folder[] = "/tmp/vxs-part-XXXXXX";
    if (!f || !mkdtemp(folder)) return -1;
    snprintf(f->path, sizeof f->path, "%s/a.part", folder);
    vxs_result r = part_begin(&w, f->path, PART, PARTS, &m);
    for (int n = 0; n < SQUARES && r == VXS_OK; n++) {
        uint8_t   bytes[RECORD_BYTES];
        vxs_bytes record = record_of(n, bytes);
        r                = part_add(&w, (uint64_t)(n * PARTS + PART - 1), &keys[n], &record, &m);
    }
    if (r == VXS_OK) r = part_end(&w, &common, &m);
    part_abort(&w);
    *state = f;
    if (r == VXS_OK) read_file(f);
    unlink(f->path);
    rmdir(folder);
    f->file = memfd_create("part", MFD_CLOEXEC);
    snprintf(f->path, sizeof f->path, "/proc/self/fd/%d", f->file);
    if (r != VXS_OK || f->file < 0) return -1;
    write_file(f, f->sound.data, f->sound.size_bytes);
    return 0;
}

static int remove_part(void **state)
{
    part_copy *f = *state;
    close(f->file);
    free(f->sound.data);
    free(f);
    return 0;
}

/* The part and all of its squares. One line names the fault, whatever it is. */
static vxs_result read_part(const part_copy *f)
{
    run_context m = {0};
    part_reader p;
    vxs_result  r = part_open(&p, f->path, &m);
    for (int n = 0; n < SQUARES && r == VXS_OK; n++) {
        vxs_bytes          record = {0};
        const part_square *s      = part_find(&p, (uint64_t)(n * PARTS + PART - 1));
        assert_non_null(s);
        r = part_read(&p, s, &keys[n], &record, &m);
        free(record.data);
    }
    part_close(&p);
    assert_true((r == VXS_OK) == !m.error[0]);
    run_free(&m);
    return r;
}

static void is_no_part(const uint8_t *bytes, size_t size_bytes, void *of)
{
    const part_copy *f = of;
    write_file(f, bytes, size_bytes);
    vxs_result r = read_part(f);
    assert_true(r == VXS_E_CORRUPT || r == VXS_E_NOT_VXS || r == VXS_E_VERSION || r == VXS_E_TRUNCATED);
}

static void faults_of_a_part(void **state)
{
    part_copy *f = *state;
    assert_int_equal(read_part(f), VXS_OK);
    each_fault(&f->sound, is_no_part, f);
}

static void a_part_of_another_version(void **state)
{
    part_copy  *f = *state;
    run_context m = {0};
    part_reader p;
    uint8_t     bytes[1 << 14];
    memcpy(bytes, f->sound.data, f->sound.size_bytes);
    bytes[8] = 2;
    write_file(f, bytes, f->sound.size_bytes);
    assert_int_equal(part_open(&p, f->path, &m), VXS_E_VERSION);
    assert_non_null(strstr(m.error, "by another version of vxs"));
    part_close(&p);
    run_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faults_of_a_square_file),
        cmocka_unit_test_setup_teardown(faults_of_a_part, write_part, remove_part),
        cmocka_unit_test_setup_teardown(a_part_of_another_version, write_part, remove_part),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
