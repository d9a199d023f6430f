/* Changes to .vxs files that pass the checksums: a file is taken apart, a section's content is changed, and all is compressed,
 * counted and hashed again. Without that, no more than a file's first 64 bytes would ever be looked at.
 *
 * Some changes are blind (libFuzzer's own), some know what a record or a level is. word_count is made right again most of the time,
 * because it is compared before levels are decoded; so are checksums of pages. Words that are packed fast change within their
 * frames.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "formats/vxs_bytes.h"
#include "formats/vxs_format.h"
#include "formats/vxs_lookup.h"
#include "formats/vxs_page.h"
#include "fuzz.h"
#include "mutate_page.h"

enum { PARTS_MAX = 64, CONTENT_MAX = 1 << 16, FRAME_MAX = 1 << 18 };

typedef struct part {
    uint32_t kind, flags, light, level;
    uint8_t *content; /* [CONTENT_MAX] */
    size_t   size;
} part;

typedef struct parts {
    part     part[PARTS_MAX];
    uint32_t count, version;
} parts;

/* chance ----------------------------------------------------------------------------------------------------------------------- */

static uint64_t random_state;

static uint32_t random_below(uint32_t count)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((random_state >> 33) % count);
}

/* taking apart and putting together -------------------------------------------------------------------------------------------- */

static void parts_free(parts *p)
{
    for (uint32_t n = 0; n < p->count; n++) free(p->part[n].content);
    p->count = 0;
}

static part *add_part(parts *p)
{
    if (p->count == PARTS_MAX) return NULL;
    part *to = &p->part[p->count++];
    *to      = (part){.content = calloc(CONTENT_MAX, 1)};
    FUZZ_CHECK(to->content);
    return to;
}

/* Returns 0 when these are not the sections of a file. */
static int take_apart(parts *p, const uint8_t *data, size_t size)
{
    *p = (parts){0};
    if (size < VXS_HEADER_BYTES) return 0;
    p->version     = vxs_load32(data + VXS_HEADER_VERSION);
    uint32_t count = vxs_load32(data + VXS_HEADER_SECTION_COUNT);
    if (count > PARTS_MAX || size < VXS_HEADER_BYTES + (size_t)count * VXS_ENTRY_BYTES) return 0;
    for (uint32_t n = 0; n < count; n++) {
        const uint8_t *e      = data + VXS_HEADER_BYTES + n * VXS_ENTRY_BYTES;
        uint64_t       offset = vxs_load64(e + VXS_ENTRY_OFFSET), stored = vxs_load64(e + VXS_ENTRY_STORED_BYTES);
        if (offset > size || stored > size - offset) return parts_free(p), 0;
        part *to  = add_part(p);
        to->kind  = vxs_load32(e + VXS_ENTRY_KIND);
        to->flags = vxs_load32(e + VXS_ENTRY_FLAGS);
        to->light = vxs_load32(e + VXS_ENTRY_LIGHT);
        to->level = vxs_load32(e + VXS_ENTRY_LEVEL);
        if (to->flags & VXS_SECTION_STORED) {
            to->size = stored < CONTENT_MAX ? stored : CONTENT_MAX;
            memcpy(to->content, data + offset, to->size);
            continue;
        }
        size_t inflated = ZSTD_decompress(to->content, CONTENT_MAX, data + offset, stored);
        to->size        = ZSTD_isError(inflated) ? 0 : inflated;
    }
    return 1;
}

static void seal(uint8_t *data, size_t size)
{
    size_t entries = (size_t)vxs_load32(data + VXS_HEADER_SECTION_COUNT) * VXS_ENTRY_BYTES;
    if (entries <= size - VXS_HEADER_BYTES)
        vxs_store64(data + VXS_HEADER_DIRECTORY_HASH, XXH64(data + VXS_HEADER_BYTES, entries, 0));
    vxs_store64(data + VXS_HEADER_HASH, XXH64(data, VXS_HEADER_HASH, 0));
}

/* Store a section. Returns its size, or 0 when there is no room. */
static size_t store(uint8_t *to, size_t room, const part *from)
{
    if (from->flags & VXS_SECTION_STORED) {
        if (from->size > room) return 0;
        memcpy(to, from->content, from->size);
        return from->size;
    }
    size_t stored = ZSTD_compress(to, room, from->content, from->size, 1);
    return ZSTD_isError(stored) ? 0 : stored;
}

/* The size of the file, or 0 when there is no room. */
static size_t put_together(const parts *p, uint8_t *data, size_t size_max)
{
    size_t at = VXS_HEADER_BYTES + (size_t)p->count * VXS_ENTRY_BYTES;
    if (at > size_max) return 0;
    memset(data, 0, at);
    for (uint32_t n = 0; n < p->count; n++) {
        const part *from   = &p->part[n];
        uint8_t    *e      = data + VXS_HEADER_BYTES + n * VXS_ENTRY_BYTES;
        size_t      stored = store(data + at, size_max - at, from);
        if (!stored && from->size) return 0;
        vxs_store32(e + VXS_ENTRY_KIND, from->kind);
        vxs_store32(e + VXS_ENTRY_FLAGS, from->flags);
        vxs_store32(e + VXS_ENTRY_LIGHT, from->light);
        vxs_store32(e + VXS_ENTRY_LEVEL, from->level);
        vxs_store64(e + VXS_ENTRY_OFFSET, at);
        vxs_store64(e + VXS_ENTRY_STORED_BYTES, stored);
        vxs_store64(e + VXS_ENTRY_INFLATED_BYTES, from->size);
        vxs_store64(e + VXS_ENTRY_HASH, XXH64(data + at, stored, 0));
        at += stored;
    }
    memcpy(data, VXS_MAGIC, VXS_MAGIC_BYTES);
    vxs_store32(data + VXS_HEADER_VERSION, p->version);
    vxs_store32(data + VXS_HEADER_SECTION_COUNT, p->count);
    vxs_store64(data + VXS_HEADER_FILE_BYTES, at);
    seal(data, at);
    return at;
}

/* what belongs together -------------------------------------------------------------------------------------------------------- */

static part *find_part(parts *p, uint32_t kind, uint32_t light, uint32_t level)
{
    for (uint32_t n = 0; n < p->count; n++)
        if (p->part[n].kind == kind && p->part[n].light == light && p->part[n].level == level) return &p->part[n];
    return NULL;
}

static uint32_t light_count(parts *p)
{
    part *table = find_part(p, VXS_KIND_LIGHTS, VXS_NO_LIGHT, 0);
    return table && table->size > VXS_LIGHTS_PREFIX_BYTES ? (uint32_t)((table->size - VXS_LIGHTS_PREFIX_BYTES) / VXS_LIGHT_BYTES)
                                                          : 0;
}

static uint8_t *light_record(parts *p, uint32_t light)
{
    return find_part(p, VXS_KIND_LIGHTS, VXS_NO_LIGHT, 0)->content + VXS_LIGHTS_PREFIX_BYTES + (size_t)light * VXS_LIGHT_BYTES;
}

/* Make each page of a section what its bytes are now: its checksum and its words; the last one ends where the section does.
 * Returns the words of all. */
static uint64_t count_pages(part *pages)
{
    uint32_t count = pages->size >= VXS_PAGES_PREFIX_BYTES ? vxs_load32(pages->content) : 0;
    uint64_t words = 0, at = VXS_PAGES_PREFIX_BYTES + (uint64_t)count * VXS_PAGE_BYTES;
    for (uint32_t n = 0; n < count && at <= pages->size; n++) {
        uint8_t *entry = pages->content + VXS_PAGES_PREFIX_BYTES + (size_t)n * VXS_PAGE_BYTES;
        uint64_t size  = n + 1 < count ? vxs_load32(entry + VXS_PAGE_STORED_BYTES) : pages->size - at;
        if (size > pages->size - at) break;
        vxs_store32(entry + VXS_PAGE_STORED_BYTES, (uint32_t)size);
        vxs_store32(entry + VXS_PAGE_WORD_COUNT, vxs_page_word_count(pages->content + at, size));
        vxs_store64(entry + VXS_PAGE_HASH, XXH64(pages->content + at, size, 0));
        words += vxs_load32(entry + VXS_PAGE_WORD_COUNT);
        at += size;
    }
    return words;
}

/* Make each word_count what the light's sections are now. */
static void count_words(parts *p)
{
    for (uint32_t light = 0; light < light_count(p); light++) {
        uint8_t *record   = light_record(p, light);
        part    *resident = find_part(p, VXS_KIND_RESIDENT, light, 0), *pages = find_part(p, VXS_KIND_PAGES, light, 0);
        if (resident && pages) {
            uint64_t all = (resident->size >= 4 ? vxs_load32(resident->content) : 0) + count_pages(pages);
            vxs_store32(record + VXS_LIGHT_WORD_COUNT, (uint32_t)all);
            continue;
        }
        uint64_t words = vxs_load32(record + VXS_LIGHT_FLAGS) & VXS_LIGHT_CUBE ? VXS_CUBE_FACES : 0;
        for (uint32_t level = 0; level < VXS_LEVELS_MAX; level++) {
            part    *l     = find_part(p, VXS_KIND_LEVEL, light, level);
            uint32_t count = l && l->size >= 4 ? vxs_load32(l->content) : 0;
            if (!l || l->size < 4 || count > (l->size - 4) / 2) continue;
            for (uint32_t n = 0; n < count; n++) words += 1 + vxs_popcount(vxs_own(vxs_load16(l->content + 4 + 2 * (size_t)n)));
        }
        part *masks = find_part(p, VXS_KIND_MASKS, light, 0);
        words += (words & 1) + (masks ? masks->size / 4 : 0);
        vxs_store32(record + VXS_LIGHT_WORD_COUNT, (uint32_t)words);
    }
}

/* changes ---------------------------------------------------------------------------------------------------------------------- */

static const uint32_t numbers[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 17, 18, 19, 31, 32, 255, 256, 0x7fffffff, 0x80000000, 0xffffffff};
static const double   reals[]   = {0, -0.0, 1, -1, 0.5, 1e-300, 1e300, 1e-30, 1e30, 5e-324, INFINITY, -INFINITY, NAN, 1e9};
enum { NUMBERS = sizeof numbers / sizeof *numbers, REALS = sizeof reals / sizeof *reals };

static void change_content(part *p)
{
    p->size = LLVMFuzzerMutate(p->content, p->size, CONTENT_MAX);
}

/* A field of a light becomes a number that is special to it, or to arithmetic. */
static void change_light(parts *p)
{
    if (!light_count(p)) return;
    uint8_t *record = light_record(p, random_below(light_count(p)));
    uint32_t field  = random_below(7);
    if (field < 4)
        vxs_store32(record + 4 * field, numbers[random_below(NUMBERS)]);
    else if (field < 6)
        vxs_store32(record + (field == 4 ? VXS_LIGHT_CODING : VXS_LIGHT_PACKING), numbers[random_below(NUMBERS)]);
    else
        vxs_store_f64(record + VXS_LIGHT_LS_FROM_WS + 8 * random_below(20), reals[random_below(REALS)]);
}

/* The light becomes another kind, with all that makes it a good one. */
static void change_kind(parts *p)
{
    if (!light_count(p)) return;
    uint32_t light  = random_below(light_count(p));
    uint8_t *record = light_record(p, light);
    uint32_t kind = 1 + random_below(3), levels = vxs_load32(record + VXS_LIGHT_LEVELS);
    int      cube = kind == VXS_LIGHT_KIND_POINT || (kind == VXS_LIGHT_KIND_SPOT && random_below(2));
    vxs_store32(record + VXS_LIGHT_KIND, kind);
    vxs_store32(record + VXS_LIGHT_FLAGS, cube ? VXS_LIGHT_CUBE : kind == VXS_LIGHT_KIND_DIRECTIONAL ? random_below(2) : 0);
    vxs_store_f64(record + VXS_LIGHT_NEAR_METRES, kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : 0.5);
    vxs_store_f64(record + VXS_LIGHT_COS_OUTER, kind == VXS_LIGHT_KIND_SPOT ? 0.25 * random_below(4) : 0);
    vxs_store_f64(record + VXS_LIGHT_RANGE_METRES, kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : 20 * random_below(2));

    part *top = find_part(p, VXS_KIND_LEVEL, light, levels - VXS_LEVELS_MIN);
    if (!top || top->size < 6 || top->size > CONTENT_MAX / 2) return;
    uint32_t count = vxs_load32(top->content), wanted = cube ? VXS_CUBE_FACES : 1;
    if (count >= wanted || count > (top->size - 4) / 2) return;
    size_t more = 2 * (size_t)(wanted - count), states_end = 4 + 2 * (size_t)count; /* roots that are all lit */
    memmove(top->content + states_end + more, top->content + states_end, top->size - states_end);
    memset(top->content + states_end, 0, more);
    vxs_store32(top->content, wanted);
    top->size += more;
}

/* The states of some node, or a count. */
static void change_level(parts *p)
{
    part *l = &p->part[random_below(p->count)];
    if (l->kind != VXS_KIND_LEVEL || l->size < 6) return;
    uint32_t nodes = vxs_load32(l->content);
    uint8_t *at    = l->content + 4 + 2 * (size_t)random_below(nodes && nodes <= (l->size - 4) / 2 ? nodes : 1);
    switch (random_below(4)) {
    case 0: vxs_store32(l->content, nodes + random_below(5) - 2); break;
    case 1: vxs_store16(at, (uint16_t)random_below(0x10000)); break;
    default: vxs_store16(at, (uint16_t)(vxs_load16(at) ^ 1u << random_below(16)));
    }
}

/* Masks come and go by whole ones. */
static void change_masks(parts *p)
{
    part *m = &p->part[random_below(p->count)];
    if (m->kind != VXS_KIND_MASKS) return;
    size_t size = 8 * (size_t)random_below(8);
    m->size     = random_below(2) && m->size >= size ? m->size - size : m->size + size > CONTENT_MAX ? m->size : m->size + size;
}

/* Where the bytes of a page are in their section. 0: they are not. */
static int find_page(const part *pages, uint32_t page_count, uint32_t page, size_t *at, size_t *size)
{
    *at   = VXS_PAGES_PREFIX_BYTES + (size_t)page_count * VXS_PAGE_BYTES;
    *size = 0;
    if (*at > pages->size) return 0;
    for (uint32_t n = 0; n <= page; n++) {
        if (*size > pages->size - *at) return 0;
        *at += *size;
        *size = vxs_load32(pages->content + VXS_PAGES_PREFIX_BYTES + (size_t)n * VXS_PAGE_BYTES + VXS_PAGE_STORED_BYTES);
    }
    return *size <= pages->size - *at;
}

/* A number of a plane of some page, or another of its words. */
static void change_a_plane(const light_pages *l, part *pages)
{
    if (!l->sizes.page_count) return;
    uint32_t page   = random_below(l->sizes.page_count),
             number = random_below(2) ? numbers[random_below(NUMBERS)] : random_below(1 << 20);
    size_t    at, size;
    vxs_bytes coded;
    if (!find_page(pages, l->sizes.page_count, page, &at, &size)) return;
    change_plane(&coded, l, page, pages->content + at, size, (int)random_below(2), random_below(1 << 30), number);
    if (coded.size_bytes && pages->size - size + coded.size_bytes <= CONTENT_MAX) {
        uint8_t *entry = pages->content + VXS_PAGES_PREFIX_BYTES + (size_t)page * VXS_PAGE_BYTES;
        memmove(pages->content + at + coded.size_bytes, pages->content + at + size, pages->size - at - size);
        memcpy(pages->content + at, coded.data, coded.size_bytes);
        vxs_store32(entry + VXS_PAGE_STORED_BYTES, (uint32_t)coded.size_bytes);
        pages->size += coded.size_bytes - size;
    }
    free(coded.data);
}

/* Some word of a resident part: an entry of a top, or a pattern that pages share. */
static void change_a_top(light_pages *l, uint32_t levels, uint32_t map_count, part *resident)
{
    vxs_bytes coded = {0};
    for (int tries = 8; tries && !coded.size_bytes; tries--) {
        free(coded.data);
        change_resident(&coded, l, levels, map_count, random_below(1 << 30), random_below(1 << 20));
    }
    if (coded.size_bytes && coded.size_bytes <= CONTENT_MAX) {
        memcpy(resident->content, coded.data, coded.size_bytes);
        resident->size = coded.size_bytes;
    }
    free(coded.data);
}

/* Words of a frame: they become numbers that are special, or others, or more or less by one; at times there are more or fewer. */
static size_t change_words(uint8_t *content, size_t size)
{
    for (uint32_t n = 1 + random_below(4); n && size >= 4; n--) {
        uint8_t *word = content + 4 * random_below((uint32_t)size / 4), *half = word + 2 * random_below(2);
        switch (random_below(5)) {
        case 0: vxs_store32(word, numbers[random_below(NUMBERS)]); break;
        case 1: vxs_store32(word, vxs_load32(content + 4 * random_below((uint32_t)size / 4))); break;
        case 2: vxs_store16(half, (uint16_t)(vxs_load16(half) + (random_below(2) ? 1 : -1))); break;
        case 3: vxs_store32(word, vxs_load32(word) ^ 1u << random_below(32)); break;
        default: vxs_store16(half, (uint16_t)random_below(0x10000));
        }
    }
    return random_below(8) ? size : LLVMFuzzerMutate(content, size, FRAME_MAX);
}

/* What a frame of a section holds changes. Returns its size. */
static size_t change_frame(part *p, size_t at, size_t size)
{
    static uint8_t content[FRAME_MAX], frame[CONTENT_MAX];
    if (size > p->size - at) return size;
    size_t inflated = ZSTD_decompress(content, FRAME_MAX, p->content + at, size);
    if (ZSTD_isError(inflated)) return size;
    inflated      = change_words(content, inflated);
    size_t stored = ZSTD_compress(frame, CONTENT_MAX, content, inflated, 1);
    if (ZSTD_isError(stored) || p->size - size + stored > CONTENT_MAX) return size;
    memmove(p->content + at + stored, p->content + at + size, p->size - at - size);
    memcpy(p->content + at, frame, stored);
    p->size += stored - size;
    return stored;
}

/* Words of a light that is packed fast: of its resident part, or of a page. */
static void change_fast(parts *p)
{
    enum { PAGE_HEAD = 4, RESIDENT_HEAD = 16 };
    if (!light_count(p)) return;
    uint32_t light    = random_below(light_count(p));
    part    *resident = find_part(p, VXS_KIND_RESIDENT, light, 0), *pages = find_part(p, VXS_KIND_PAGES, light, 0);
    if (vxs_load32(light_record(p, light) + VXS_LIGHT_PACKING) != VXS_PACKING_FAST || !resident || !pages) return;
    if (random_below(4) == 0) {
        if (resident->size > RESIDENT_HEAD) change_frame(resident, RESIDENT_HEAD, resident->size - RESIDENT_HEAD);
        return;
    }
    uint32_t count = pages->size >= VXS_PAGES_PREFIX_BYTES ? vxs_load32(pages->content) : 0, page;
    size_t   at, size;
    if (!count || count > VXS_PAGES_MAX) return;
    page = random_below(count);
    if (!find_page(pages, count, page, &at, &size) || size <= PAGE_HEAD) return;
    uint8_t *entry = pages->content + VXS_PAGES_PREFIX_BYTES + (size_t)page * VXS_PAGE_BYTES;
    if (random_below(8) == 0) vxs_store16(pages->content + at + 2, (uint16_t)random_below(0x10000)); /* words of nodes */
    vxs_store32(entry + VXS_PAGE_STORED_BYTES, (uint32_t)(PAGE_HEAD + change_frame(pages, at + PAGE_HEAD, size - PAGE_HEAD)));
}

static void change_planes(parts *p)
{
    if (!light_count(p)) return;
    uint32_t       light  = random_below(light_count(p));
    const uint8_t *record = light_record(p, light);
    uint32_t       levels = vxs_load32(record + VXS_LIGHT_LEVELS), cube = vxs_load32(record + VXS_LIGHT_FLAGS) & VXS_LIGHT_CUBE;
    uint32_t       packing  = vxs_load32(record + VXS_LIGHT_PACKING);
    part          *resident = find_part(p, VXS_KIND_RESIDENT, light, 0), *pages = find_part(p, VXS_KIND_PAGES, light, 0);
    light_pages    l;
    if (!resident || !pages) return;
    uint32_t map_count = cube ? VXS_CUBE_FACES : 1;
    if (light_pages_read(&l, levels, map_count, packing, resident->content, resident->size)) {
        for (uint32_t n = 1 + random_below(4); n; n--) change_a_plane(&l, pages);
        if (random_below(2)) change_a_top(&l, levels, map_count, resident);
    }
    light_pages_free(&l);
}

/* A section is copied, dropped, moved, or says that it is another. */
static void change_sections(parts *p)
{
    part *one = &p->part[random_below(p->count)], *other = &p->part[random_below(p->count)], kept = *one, *copy;
    switch (random_below(7)) {
    case 0:
        if (!(copy = add_part(p))) return;
        memcpy(copy->content, one->content, one->size);
        copy->kind  = one->kind;
        copy->flags = one->flags;
        copy->light = one->light + random_below(2);
        copy->level = one->level + random_below(2);
        copy->size  = one->size;
        return;
    case 1:
        if (p->count == 1) return;
        free(one->content);
        *one = p->part[--p->count];
        return;
    case 2:
        *one   = *other;
        *other = kept;
        return;
    case 3: one->flags ^= 1u << random_below(4); return;
    case 4: one->kind = random_below(2) ? other->kind : one->kind ^ 1u << random_below(32); return;
    case 5: one->light = random_below(2) ? other->light : numbers[random_below(NUMBERS)]; return;
    default: one->level = random_below(2) ? other->level : numbers[random_below(NUMBERS)];
    }
}

/* Stored bytes, header or directory change, and only the checksums follow. */
static size_t change_stored(uint8_t *data, size_t size, size_t size_max)
{
    size_t directory = VXS_HEADER_BYTES + (size_t)vxs_load32(data + VXS_HEADER_SECTION_COUNT) * VXS_ENTRY_BYTES;
    if (random_below(3) == 0) {
        LLVMFuzzerMutate(data + VXS_MAGIC_BYTES, directory - VXS_MAGIC_BYTES, directory - VXS_MAGIC_BYTES);
    } else { /* the last section may grow or shrink */
        uint32_t count  = vxs_load32(data + VXS_HEADER_SECTION_COUNT);
        int      last   = random_below(2) == 0;
        uint8_t *e      = data + VXS_HEADER_BYTES + (last ? count - 1 : random_below(count)) * VXS_ENTRY_BYTES;
        size_t   offset = vxs_load64(e + VXS_ENTRY_OFFSET), stored = vxs_load64(e + VXS_ENTRY_STORED_BYTES);
        if (offset < directory || offset > size || stored > size - offset) return size;
        size_t now = LLVMFuzzerMutate(data + offset, stored, last ? size_max - offset : stored);
        if (last) {
            vxs_store64(e + VXS_ENTRY_STORED_BYTES, stored = now);
            vxs_store64(data + VXS_HEADER_FILE_BYTES, size = offset + now);
        }
        vxs_store64(e + VXS_ENTRY_HASH, XXH64(data + offset, stored, 0));
    }
    seal(data, size);
    return size;
}

static void change(parts *p)
{
    switch (random_below(13)) {
    case 0: change_light(p); break;
    case 1: change_kind(p); break;
    case 2: change_level(p); break;
    case 3: change_masks(p); break;
    case 4: change_sections(p); break;
    case 5:
    case 6: change_planes(p); break;
    case 7:
    case 8:
    case 9: change_fast(p); break;
    default: change_content(&p->part[random_below(p->count)]);
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned int seed)
{
    random_state = seed;
    parts p;
    if (random_below(16) == 0 || !take_apart(&p, data, size)) return LLVMFuzzerMutate(data, size, size_max);
    if (!p.count) return LLVMFuzzerMutate(data, size, size_max);
    if (random_below(8) == 0) {
        parts_free(&p);
        return change_stored(data, size, size_max);
    }
    for (uint32_t n = 1 + random_below(3); n; n--) change(&p);
    if (random_below(4)) count_words(&p);
    uint8_t *changed = malloc(size_max);
    FUZZ_CHECK(changed);
    size_t now = put_together(&p, changed, size_max);
    if (now) memcpy(data, changed, now);
    free(changed);
    parts_free(&p);
    return now ? now : LLVMFuzzerMutate(data, size, size_max);
}
