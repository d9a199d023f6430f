/* Files for tests of the format: read, with what was found in them, and taken apart, to be changed inside and put together again
 * with checksums that hold. Include after <cmocka.h>.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FORMAT_PARTS_H
#define FORMAT_PARTS_H

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "formats/vxs_bytes.h"
#include "formats/vxs_findings.h"
#include "formats/vxs_write_file.h"
#include "runtime/vxs.h"
#include "tests/unit/alloc_fail.h"

/* reading, and what was found -------------------------------------------------------------------------------------------------- */

enum { FINDINGS_END = 800 };

static int produced[FINDINGS_END]; /* over all tests: how often each number was a file's first finding */

typedef struct findings {
    int      first, section, count;
    uint64_t offset;
} findings;

/* Whether a finding is one of palette blocks, of smoke, or of points: test_format_blocks.c, test_smoke_file.c and
 * test_points_file.c produce it; test_format.c all others. */
static inline int is_of_blocks(int number)
{
    return number == 212 || number == 309 || number == 310 || number / 100 == 5;
}

static inline int is_of_smoke(int number)
{
    return number / 100 == 6;
}

static inline int is_of_points(int number)
{
    return number / 100 == 7;
}

static inline vxs_result result_of(int number)
{
#define RESULT_OF(n, result, text)                                                                                                 \
    if (number == n) return result;
    VXS_FINDINGS(RESULT_OF)
#undef RESULT_OF
    fail_msg("finding %d is not in the list", number);
    return VXS_OK;
}

static inline void collect(void *user, int number, const char *text, int section, uint64_t offset)
{
    findings *f = user;
    assert_true(number > 0 && number < FINDINGS_END && text && *text);
    if (!f->count++) *f = (findings){number, section, 1, offset};
}

/* vxs_read, where a refusal must come with a finding, whose result is the one returned. */
static inline vxs_result read_bytes(vxs_contents *contents, const vxs_bytes *file, findings *f, int find_all)
{
    vxs_read_desc desc = {.finding = collect, .finding_user = f, .find_all = find_all, .metadata = 1};
    *f                 = (findings){0};
    vxs_result r       = vxs_read(contents, file->data, file->size_bytes, &desc);
    assert_int_equal(r == VXS_OK, f->count == 0);
    if (r == VXS_OK) return r;
    assert_int_equal(r, result_of(f->first));
    produced[f->first]++;
    return r;
}

static inline void refused(const vxs_bytes *file, int number)
{
    vxs_contents contents;
    findings     f;
    assert_int_not_equal(read_bytes(&contents, file, &f, 0), VXS_OK);
    assert_int_equal(f.first, number);
    assert_in_range(f.count, 1, 3); /* a light's record is looked at as a whole */
    assert_int_not_equal(read_bytes(&contents, file, &f, 1), VXS_OK);
    assert_int_equal(f.first, number);
}

/* files taken apart ------------------------------------------------------------------------------------------------------------ */

enum { PARTS_MAX = 24 };

static inline void *parts_alloc(size_t size)
{
    void *memory = calloc(size ? size : 1, 1);
    if (!memory) abort();
    return memory;
}

typedef struct part {
    uint32_t  kind, flags, light, level;
    uint64_t  inflated_bytes; /* what the directory says */
    vxs_bytes content, stored;
} part;

typedef struct parts {
    part     part[PARTS_MAX];
    uint32_t count, version;
} parts;

static inline void set_bytes(vxs_bytes *b, const void *data, size_t size)
{
    uint8_t *copy = parts_alloc(size);
    if (size) memcpy(copy, data, size);
    free(b->data);
    *b = (vxs_bytes){copy, size, size};
}

/* Compress a part again, after its content changed; or take it as it is. */
static inline void store(part *p)
{
    if (p->flags & VXS_SECTION_STORED) {
        set_bytes(&p->stored, p->content.data, p->content.size_bytes);
        p->inflated_bytes = p->content.size_bytes;
        return;
    }
    size_t   bound = ZSTD_compressBound(p->content.size_bytes);
    uint8_t *to    = parts_alloc(bound);
    size_t   size  = ZSTD_compress(to, bound, p->content.data, p->content.size_bytes, 1);
    assert_false(ZSTD_isError(size));
    free(p->stored.data);
    p->stored         = (vxs_bytes){to, size, bound};
    p->inflated_bytes = p->content.size_bytes;
}

static inline void take_apart(parts *p, const vxs_bytes *file)
{
    *p =
        (parts){.count = vxs_load32(file->data + VXS_HEADER_SECTION_COUNT), .version = vxs_load32(file->data + VXS_HEADER_VERSION)};
    assert_in_range(p->count, 1, PARTS_MAX);
    for (uint32_t n = 0; n < p->count; n++) {
        const uint8_t *e    = file->data + VXS_HEADER_BYTES + n * VXS_ENTRY_BYTES;
        part          *to   = &p->part[n];
        const uint8_t *from = file->data + vxs_load64(e + VXS_ENTRY_OFFSET);
        to->kind            = vxs_load32(e + VXS_ENTRY_KIND);
        to->flags           = vxs_load32(e + VXS_ENTRY_FLAGS);
        to->light           = vxs_load32(e + VXS_ENTRY_LIGHT);
        to->level           = vxs_load32(e + VXS_ENTRY_LEVEL);
        to->inflated_bytes  = vxs_load64(e + VXS_ENTRY_INFLATED_BYTES);
        set_bytes(&to->stored, from, vxs_load64(e + VXS_ENTRY_STORED_BYTES));
        set_bytes(&to->content, NULL, 0);
        to->content.data       = realloc(to->content.data, to->inflated_bytes + 1);
        to->content.size_bytes = to->inflated_bytes;
        if (to->flags & VXS_SECTION_STORED)
            memcpy(to->content.data, from, to->inflated_bytes);
        else
            assert_int_equal(ZSTD_decompress(to->content.data, to->inflated_bytes, from, to->stored.size_bytes),
                             to->inflated_bytes);
    }
}

static inline void parts_free(parts *p)
{
    for (uint32_t n = 0; n < p->count; n++) {
        free(p->part[n].content.data);
        free(p->part[n].stored.data);
    }
}

/* Make the checksums of header and directory hold. */
static inline void seal(vxs_bytes *file)
{
    uint32_t count = vxs_load32(file->data + VXS_HEADER_SECTION_COUNT);
    size_t   size  = (size_t)count * VXS_ENTRY_BYTES;
    if (size <= file->size_bytes - VXS_HEADER_BYTES)
        vxs_store64(file->data + VXS_HEADER_DIRECTORY_HASH, XXH64(file->data + VXS_HEADER_BYTES, size, 0));
    vxs_store64(file->data + VXS_HEADER_HASH, XXH64(file->data, VXS_HEADER_HASH, 0));
}

static inline vxs_bytes put_together(const parts *p)
{
    size_t size = VXS_HEADER_BYTES + p->count * VXS_ENTRY_BYTES;
    for (uint32_t n = 0; n < p->count; n++) size += p->part[n].stored.size_bytes;
    vxs_bytes file   = {parts_alloc(size), size, size};
    size_t    offset = VXS_HEADER_BYTES + p->count * VXS_ENTRY_BYTES;
    for (uint32_t n = 0; n < p->count; n++) {
        const part *from = &p->part[n];
        uint8_t    *e    = file.data + VXS_HEADER_BYTES + n * VXS_ENTRY_BYTES;
        vxs_store32(e + VXS_ENTRY_KIND, from->kind);
        vxs_store32(e + VXS_ENTRY_FLAGS, from->flags);
        vxs_store32(e + VXS_ENTRY_LIGHT, from->light);
        vxs_store32(e + VXS_ENTRY_LEVEL, from->level);
        vxs_store64(e + VXS_ENTRY_OFFSET, offset);
        vxs_store64(e + VXS_ENTRY_STORED_BYTES, from->stored.size_bytes);
        vxs_store64(e + VXS_ENTRY_INFLATED_BYTES, from->inflated_bytes);
        vxs_store64(e + VXS_ENTRY_HASH, XXH64(from->stored.data, from->stored.size_bytes, 0));
        memcpy(file.data + offset, from->stored.data, from->stored.size_bytes);
        offset += from->stored.size_bytes;
    }
    memcpy(file.data, VXS_MAGIC, VXS_MAGIC_BYTES);
    vxs_store32(file.data + VXS_HEADER_VERSION, p->version);
    vxs_store32(file.data + VXS_HEADER_SECTION_COUNT, p->count);
    vxs_store64(file.data + VXS_HEADER_FILE_BYTES, size);
    seal(&file);
    return file;
}

static inline part *find_part(parts *p, uint32_t kind, uint32_t level)
{
    for (uint32_t n = 0; n < p->count; n++)
        if (p->part[n].kind == kind && p->part[n].level == level) return &p->part[n];
    fail_msg("no section of kind %08x, level %u", kind, level);
    return NULL;
}

static inline part *add_part(parts *p, uint32_t kind, uint32_t flags, const void *content, size_t size)
{
    assert_in_range(p->count, 0, PARTS_MAX - 1);
    part *to = &p->part[p->count++];
    *to      = (part){.kind = kind, .flags = flags, .light = VXS_NO_LIGHT};
    set_bytes(&to->content, content, size);
    store(to);
    return to;
}

/* The file is refused when the first section of a kind is changed. */
static inline void refused_with(const vxs_bytes *file, uint32_t kind, void (*change)(part *section), int number)
{
    parts p;
    take_apart(&p, file);
    part *section = find_part(&p, kind, 0);
    change(section);
    store(section);
    vxs_bytes changed = put_together(&p);
    refused(&changed, number);
    parts_free(&p);
    free(changed.data);
}

/* The file is refused when the first section of a kind is there twice. */
static inline void refused_twice(const vxs_bytes *file, uint32_t kind)
{
    parts p;
    take_apart(&p, file);
    const part *section                                                                           = find_part(&p, kind, 0);
    add_part(&p, kind, section->flags, section->content.data, section->content.size_bytes)->light = section->light;
    vxs_bytes twice                                                                               = put_together(&p);
    refused(&twice, 208);
    parts_free(&p);
    free(twice.data);
}

/* Opening the file fails at each allocation that fails, and gives all memory back. Returns what opening takes. */
static inline alloc_fail opened_without_memory(const vxs_bytes *file)
{
    alloc_fail needed = {0};
    vxs_asset *asset;
    for (uint64_t at = 0; !at || at <= needed.calls; at++) {
        alloc_fail    memory    = {.fail_at = at};
        vxs_allocator allocator = alloc_fail_allocator(at ? &memory : &needed);
        vxs_read_desc desc      = {.allocator = &allocator};
        assert_int_equal(vxs_asset_open(&asset, file->data, file->size_bytes, &desc), at ? VXS_E_MEMORY : VXS_OK);
        vxs_asset_close(asset);
        assert_int_equal((at ? memory : needed).live_bytes + (at ? memory : needed).wrong_sizes, 0);
    }
    return needed;
}

#endif
