/* Pages and the resident part, to bytes and back (formats/vxs_page.h): the same words for all that the layout allows, and from
 * bytes that are damaged never words that a lookup could leave. The decoder is compiled a second time without SIMD: both must
 * agree. VXS_PAGES_OUT=FILE writes random resident parts and pages, and what they are to come to, instead.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "page_encoded.h"
#include "resident_sample.h"

#include <cmocka.h>

size_t     plain_scratch_bytes(void);
uint32_t   plain_word_count(const uint8_t *bytes, size_t size_bytes);
vxs_result plain_decode(uint32_t *words, const uint8_t *bytes, size_t size_bytes, const vxs_page_node *nodes, uint32_t node_count,
                        const vxs_common *common, vxs_page_scratch *scratch);
vxs_result plain_sizes_of(vxs_resident_sizes *sizes, const uint8_t *bytes, size_t size_bytes);
vxs_result plain_resident_decode(vxs_resident *out, uint32_t levels, uint32_t map_count, uint32_t packing, const uint8_t *bytes,
                                 size_t size_bytes, vxs_page_scratch *scratch);

#undef __SSE2__
#define vxs_page_scratch_bytes plain_scratch_bytes
#define vxs_page_word_count    plain_word_count
#define vxs_page_decode        plain_decode
#define vxs_resident_sizes_of  plain_sizes_of
#define vxs_resident_decode    plain_resident_decode
#include "formats/vxs_page_decode.c"
#include "tests/unit/repeats.h"
#undef vxs_page_scratch_bytes
#undef vxs_page_word_count
#undef vxs_page_decode
#undef vxs_resident_sizes_of
#undef vxs_resident_decode

static sample_page       page; /* large */
static sample_common     common;
static vxs_page_scratch *scratch;

static int make_scratch(void **state)
{
    (void)state;
    scratch = malloc(vxs_page_scratch_bytes());
    return !scratch;
}

/* Streams have one for each thread, beside few pages. */
static void scratch_is_small(void **state)
{
    (void)state;
    assert_in_range(vxs_page_scratch_bytes(), 1, 640 << 10);
}

static int free_scratch(void **state)
{
    (void)state;
    free(scratch);
    return 0;
}

/* Bytes and words without room behind them, so that a sanitizer sees what goes beyond; NULL, with the result, if they are
 * refused. */
static uint32_t *decode(const uint8_t *bytes, size_t size, uint32_t *word_count, vxs_result *result)
{
    uint8_t *exact = malloc(size ? size : 1);
    memcpy(exact, bytes, size);
    *word_count     = vxs_page_word_count(exact, size);
    uint32_t *words = malloc(*word_count ? *word_count * sizeof *words : 1);
    *result         = vxs_page_decode(words, exact, size, page.nodes, page.node_count, &common.common, scratch);
    free(exact);
    if (*result == VXS_OK) return words;
    free(words);
    return NULL;
}

static vxs_bytes encoded(void)
{
    vxs_bytes bytes = {0};
    assert_int_equal(page_encoded(&bytes, page.words, page.word_count, page.nodes, page.node_count, &common.common), VXS_OK);
    return bytes;
}

static void check_round_trip(void)
{
    vxs_bytes  bytes = encoded();
    uint32_t   count;
    vxs_result result;
    uint32_t  *words = decode(bytes.data, bytes.size_bytes, &count, &result);
    assert_int_equal(result, VXS_OK);
    assert_int_equal(count, page.word_count);
    assert_memory_equal(words, page.words, count * sizeof *words);
    assert_true(check_page(words, count, page.nodes, page.node_count, &common.common));

    memset(words, 0xa5, count * sizeof *words);
    assert_int_equal(plain_decode(words, bytes.data, bytes.size_bytes, page.nodes, page.node_count, &common.common, scratch),
                     VXS_OK);
    assert_memory_equal(words, page.words, count * sizeof *words);
    free(words);
    free(bytes.data);
}

static void pages_come_back(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < repeats(100, 300); seed++) {
        rng r = rng_split(seed, 1);
        assert_int_equal(sample_common_make(&r, &common, seed % 3 ? rng_below(&r, SAMPLE_COMMON_MAX) : 0), VXS_OK);
        sample_page_make(&r, &page, &common, 1 + (uint32_t)seed % 20);
        check_round_trip();
    }
}

static void pages_come_back_up_to_the_last_word(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < repeats(2, 6); seed++) {
        rng r = rng_split(seed, 2);
        assert_int_equal(sample_common_make(&r, &common, SAMPLE_COMMON_MAX), VXS_OK);
        sample_page_make(&r, &page, &common, 0);
        assert_int_equal(page.word_count, VXS_PAGE_WORDS_MAX);
        check_round_trip();
    }
}

/* What a page is coded to knows nothing of the pages that the scratch served before. */
static void a_page_is_coded_alone(void **state)
{
    (void)state;
    rng r = rng_split(7, 3);
    assert_int_equal(sample_common_make(&r, &common, 20), VXS_OK);
    sample_page_make(&r, &page, &common, 5);
    vxs_bytes first = encoded(), second = {0};
    assert_int_equal(page_encoded(&second, page.words, page.word_count, page.nodes, page.node_count, &common.common), VXS_OK);
    assert_int_equal(first.size_bytes, second.size_bytes);
    assert_memory_equal(first.data, second.data, first.size_bytes);
    /* appended, not overwritten */
    assert_int_equal(page_encoded(&second, page.words, page.word_count, page.nodes, page.node_count, &common.common), VXS_OK);
    assert_int_equal(second.size_bytes, 2 * first.size_bytes);
    assert_memory_equal(first.data, second.data + first.size_bytes, first.size_bytes);
    free(first.data);
    free(second.data);
}

/* damage ----------------------------------------------------------------------------------------------------------------------- */

/* Whatever comes out may be looked up. Returns whether anything did. */
static int check_damaged(const uint8_t *bytes, size_t size)
{
    uint32_t   count;
    vxs_result result;
    uint32_t  *words = decode(bytes, size, &count, &result);
    if (words) assert_true(check_page(words, count, page.nodes, page.node_count, &common.common));
    assert_true(result == VXS_OK || result == VXS_E_TRUNCATED || result == VXS_E_CORRUPT);
    free(words);
    return result == VXS_OK;
}

static void small_page(uint64_t seed)
{
    rng r = rng_split(seed, 4);
    assert_int_equal(sample_common_make(&r, &common, 12), VXS_OK);
    sample_page_make(&r, &page, &common, 1 + (uint32_t)seed % 3);
}

static void prefixes_are_refused(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < repeats(12, 40); seed++) {
        small_page(seed);
        vxs_bytes bytes = encoded();
        for (size_t size = 0; size < bytes.size_bytes; size++) assert_false(check_damaged(bytes.data, size));
        free(bytes.data);
    }
}

static void flipped_bits_do_no_harm(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < repeats(12, 40); seed++) {
        small_page(seed);
        vxs_bytes bytes = encoded();
        size_t    step  = 1 + bytes.size_bytes / 200;
        for (size_t bit = seed % step; bit < 8 * bytes.size_bytes; bit += step) {
            bytes.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
            check_damaged(bytes.data, bytes.size_bytes);
            bytes.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
        }
        free(bytes.data);
    }
}

/* The coder without words: symbols that need one do not end where the words do, whatever the states are then. */
static void words_that_are_not_there_are_missed(void **state)
{
    (void)state;
    const uint8_t states[8] = {0};
    coder         c         = {.now = STATE_LEAST, .next = STATE_LEAST, .in = states, .end = states};
    for (int n = 0; n < 40; n++) {
        code_plain(&c, 12, 0);
        assert_true(c.in > c.end && c.in + 2 <= states + sizeof states);
    }
}

static void random_bytes_do_no_harm(void **state)
{
    (void)state;
    uint8_t bytes[600];
    for (uint64_t seed = 0; seed < repeats(2400, 8000); seed++) {
        rng r = rng_split(seed, 5);
        if (seed % 400 == 0) small_page(seed / 400);
        size_t size = rng_below(&r, sizeof bytes + 1);
        for (size_t n = 0; n < size; n++) bytes[n] = (uint8_t)rng_u32(&r);
        check_damaged(bytes, size);
    }
}

/* The coder's symbols, as an encoder that is free to break every rule would choose them: random words of the coder behind a good
 * head, so that what is decoded goes on for long. */
static void random_symbols_do_no_harm(void **state)
{
    (void)state;
    static uint8_t bytes[40000];
    for (uint64_t seed = 0; seed < repeats(120, 400); seed++) {
        rng r = rng_split(seed, 6);
        if (seed % 20 == 0) small_page(seed / 20);
        for (size_t n = 0; n < sizeof bytes; n++) bytes[n] = seed % 2 ? (uint8_t)rng_u32(&r) : (uint8_t)(rng_u32(&r) & rng_u32(&r));
        memset(bytes, 0xff, 4);
        check_damaged(bytes, sizeof bytes);
    }
}

/* Words that are no page in canonical order are refused, not coded to something else. */
static void changed_words_are_refused_or_come_back(void **state)
{
    (void)state;
    size_t refused = 0, tried = 0;
    for (uint64_t seed = 0; seed < repeats(20, 60); seed++) {
        small_page(seed);
        rng r = rng_split(seed, 7);
        for (int n = 0; n < 60; n++) {
            uint32_t at = rng_below(&r, page.word_count), bit = rng_below(&r, 32), was = page.words[at];
            page.words[at] ^= 1u << bit;
            vxs_bytes  bytes  = {0};
            vxs_result result = page_encoded(&bytes, page.words, page.word_count, page.nodes, page.node_count, &common.common);
            tried++;
            if (result == VXS_OK) {
                uint32_t  count;
                uint32_t *words = decode(bytes.data, bytes.size_bytes, &count, &result);
                assert_int_equal(result, VXS_OK);
                assert_memory_equal(words, page.words, page.word_count * sizeof *words);
                free(words);
            } else {
                assert_int_equal(result, VXS_E_ARGUMENT);
                assert_int_equal(bytes.size_bytes, 0);
                refused++;
            }
            free(bytes.data);
            page.words[at] = was;
        }
    }
    assert_true(refused > tried / 10);
    vxs_bytes none = {0};
    assert_int_equal(page_encoded(&none, page.words, page.word_count, page.nodes, 0, &common.common), VXS_E_ARGUMENT);
    assert_int_equal(page_encoded(&none, page.words, 0, page.nodes, page.node_count, &common.common), VXS_E_ARGUMENT);
    page.nodes[0].offset = 1;
    assert_int_equal(page_encoded(&none, page.words, page.word_count, page.nodes, page.node_count, &common.common), VXS_E_ARGUMENT);
    free(none.data);
}

/* A page whose nodes are not where the top says is refused. */
static void nodes_must_be_where_the_top_says(void **state)
{
    (void)state;
    small_page(2);
    assert_true(page.node_count > 1);
    vxs_bytes bytes = encoded();
    page.nodes[1].offset++;
    assert_false(check_damaged(bytes.data, bytes.size_bytes));
    page.nodes[1].offset--;
    page.node_count--;
    assert_false(check_damaged(bytes.data, bytes.size_bytes));
    page.node_count++;
    assert_true(check_damaged(bytes.data, bytes.size_bytes));
    free(bytes.data);
}

/* the resident part ------------------------------------------------------------------------------------------------------------ */

static vxs_result resident_decode(vxs_resident *o, vxs_resident_sizes *sizes, const light_sample *l, uint32_t packing,
                                  const uint8_t *bytes, size_t size, int plain)
{
    uint8_t *exact = malloc(size ? size : 1);
    memcpy(exact, bytes, size);
    *o                = (vxs_resident){0};
    vxs_result result = vxs_resident_sizes_of(sizes, exact, size);
    if (result == VXS_OK && sizes->word_count < 4 * l->word_count) {
        o->words      = malloc(sizes->word_count * 4);
        o->nodes      = malloc(sizes->node_count * sizeof *o->nodes + 1);
        o->page_first = malloc((sizes->page_count + 1) * 4);
        o->patterns   = malloc(sizes->pattern_count * sizeof *o->patterns + 1);
        result = (plain ? plain_resident_decode : vxs_resident_decode)(o, l->levels, l->map_count, packing, exact, size, scratch);
    } else if (result == VXS_OK)
        result = VXS_E_CORRUPT;
    free(exact);
    return result;
}

static void resident_free(vxs_resident *o)
{
    free(o->words);
    free(o->nodes);
    free(o->page_first);
    free(o->patterns);
}

/* Every entry names a depth, or a node of the list. */
static void check_tops(const vxs_resident *o, const vxs_resident_sizes *sizes, const light_sample *l)
{
    uint32_t side = l->levels <= 8 ? 1 : 1u << (l->levels - 8);
    assert_true(o->words[0] == sizes->page_count && o->words[1] <= sizes->word_count);
    for (uint32_t map = 0; map < l->map_count; map++)
        for (uint32_t y = 0; y < side; y++)
            for (uint32_t x = 0; x < side; x++) {
                uint32_t top = o->words[2 + map], at = top + 2 * (y * side + x);
                if (l->levels >= 15) {
                    at = top + y / 8 * (side / 8) + x / 8;
                    assert_true(at < o->words[1]);
                    if (o->words[at] & 0x80000000u) continue;
                    at = o->words[at] + 2 * (y % 8 * 8 + x % 8);
                }
                assert_true(at + 1 < o->words[1]);
                uint32_t entry = o->words[at], page_index = entry >> 16, met = 0;
                if (entry & 0x80000000u) {
                    assert_true((entry & 0x7fffffff) <= 1 << 18 && !o->words[at + 1]);
                    continue;
                }
                assert_true(page_index < sizes->page_count);
                assert_in_range(o->words[at + 1] >> 24, o->words[at + 1] >> 16 & 255, 255); /* max, from min on */
                for (uint32_t n = o->page_first[page_index]; n < o->page_first[page_index + 1]; n++)
                    met |= o->nodes[n].offset == (entry & 0xffff);
                assert_true(met);
            }
}

static void resident_parts_come_back(void **state)
{
    (void)state;
    static const uint32_t levels[] = {3, 8, 9, 11, 13, 14, 15, 16, 17};
    for (uint64_t seed = 0; seed < repeats(18, 36); seed++) {
        rng          r = rng_split(seed, 8);
        light_sample l;
        vxs_bytes    bytes = {0};
        assert_int_equal(sample_common_make(&r, &common, (uint32_t)seed % SAMPLE_COMMON_MAX), VXS_OK);
        light_make(&r, &l, &common, levels[seed % 9], seed % 4 == 1 ? 6 : 1);
        assert_int_equal(resident_encoded(&bytes, l.words, l.word_count, l.levels, l.map_count, &common.common), VXS_OK);
        for (int plain = 0; plain < 2; plain++) {
            vxs_resident       o;
            vxs_resident_sizes sizes;
            assert_int_equal(resident_decode(&o, &sizes, &l, common.common.packing, bytes.data, bytes.size_bytes, plain), VXS_OK);
            assert_int_equal(sizes.word_count, l.word_count);
            assert_int_equal(sizes.node_count, l.node_count);
            assert_int_equal(sizes.page_count, l.page_count);
            assert_memory_equal(o.words, l.words, 4 * l.word_count);
            assert_memory_equal(o.nodes, l.nodes, l.node_count * sizeof *l.nodes);
            assert_memory_equal(o.page_first, l.page_first, 4 * (l.page_count + 1));
            assert_memory_equal(o.common.first, common.common.first, sizeof common.common.first);
            assert_memory_equal(o.patterns, common.patterns, sizes.pattern_count * sizeof *o.patterns);
            assert_int_equal(o.common.half_count, common.common.half_count);
            assert_ptr_equal(o.common.words, o.words + l.words[1]);
            if (l.levels < 15) check_tops(&o, &sizes, &l);
            resident_free(&o);
        }
        if (l.page_count) {
            l.words[8]     = 1; /* a page that is there is not reported */
            vxs_bytes same = {0};
            assert_int_equal(resident_encoded(&same, l.words, l.word_count, l.levels, l.map_count, &common.common), VXS_OK);
            assert_int_equal(same.size_bytes, bytes.size_bytes);
            assert_memory_equal(same.data, bytes.data, same.size_bytes);
            free(same.data);
        }
        free(bytes.data);
        light_free(&l);
    }
}

static void damaged_resident_parts_do_no_harm(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < repeats(3, 12); seed++) {
        rng          r = rng_split(seed, 9);
        light_sample l;
        vxs_bytes    bytes = {0};
        assert_int_equal(sample_common_make(&r, &common, 10), VXS_OK);
        light_make(&r, &l, &common, seed % 3 == 2 ? 15 : 10, 1);
        assert_int_equal(resident_encoded(&bytes, l.words, l.word_count, l.levels, l.map_count, &common.common), VXS_OK);
        size_t step = 1 + bytes.size_bytes / 150;
        for (size_t n = 0; n < bytes.size_bytes / step + 8 * bytes.size_bytes / step; n++) {
            size_t             bit = n * step, size = bytes.size_bytes;
            vxs_resident       o;
            vxs_resident_sizes sizes;
            if (n < bytes.size_bytes / step)
                size = n * step; /* a prefix */
            else {
                bit = (n - bytes.size_bytes / step) * step;
                bytes.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
            }
            vxs_result result = resident_decode(&o, &sizes, &l, common.common.packing, bytes.data, size, 0);
            assert_true(result == VXS_OK || result == VXS_E_TRUNCATED || result == VXS_E_CORRUPT);
            if (result == VXS_OK) check_tops(&o, &sizes, &l);
            resident_free(&o);
            if (size == bytes.size_bytes) bytes.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
        }
        l.words[1]++;
        vxs_bytes none = {0};
        assert_int_equal(resident_encoded(&none, l.words, l.word_count, l.levels, l.map_count, &common.common), VXS_E_ARGUMENT);
        free(none.data);
        free(bytes.data);
        light_free(&l);
    }
}

/* Depths below min are lit, those above max shadowed: where min is above max, both are so. The coder does not write such an entry,
 * and the bytes of one, made by a coder without that rule, are refused. */
static void min_is_not_above_max(void **state)
{
    (void)state;
    enum { BASE = 0x10, BYTES = 28 };
    static const struct {
        uint32_t min, max;
        uint8_t  bytes[BYTES];
    } entries[] = {
        {32, 32, {11, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0x77, 0x81, 0x29, 0x25, 0, 0xa4, 0x40, 0, 0x80, 0x20, 6, 0}},
        {33, 32, {11, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0x77, 0x91, 0x29, 5, 0, 0xa4, 0x20, 4, 0x88, 0x20, 0x60, 0}},
        {255, 0, {11, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0x77, 0xc1, 0x29, 0, 5, 0xa4, 0x38, 0x40, 8, 0x20, 0x70, 3}},
    };
    const light_sample l = {.levels = 8, .map_count = 1, .word_count = 11};
    for (size_t n = 0; n < sizeof entries / sizeof *entries; n++) {
        uint32_t           min = entries[n].min, max = entries[n].max;
        uint32_t           words[] = {1, 11, 9, 0, 0, 0, 0, 0, 0, 0, BASE | min << 16 | max << 24};
        const vxs_common   nothing = {0};
        vxs_resident       o;
        vxs_resident_sizes sizes;
        vxs_bytes          bytes = {0};
        vxs_result         made  = resident_encoded(&bytes, words, l.word_count, l.levels, l.map_count, &nothing);
        assert_int_equal(made, min > max ? VXS_E_ARGUMENT : VXS_OK);
        if (made == VXS_OK) assert_int_equal(bytes.size_bytes, BYTES);
        if (made == VXS_OK) assert_memory_equal(bytes.data, entries[n].bytes, BYTES);
        for (int plain = 0; plain < 2; plain++) {
            assert_int_equal(resident_decode(&o, &sizes, &l, VXS_PACKING_SMALL, entries[n].bytes, BYTES, plain),
                             min > max ? VXS_E_CORRUPT : VXS_OK);
            resident_free(&o);
        }
        free(bytes.data);
    }
}

/* samples for others ----------------------------------------------------------------------------------------------------------- */

static int write_numbers(FILE *to, const void *numbers, size_t count)
{
    return fwrite(numbers, 4, count, to) == count;
}

/* A light, and a page that uses its common pool: a row of numbers as below, then what they count. */
static int write_sample(FILE *to, uint64_t seed)
{
    static const uint32_t levels[] = {3, 9, 11, 8, 10, 12};
    rng                   r        = rng_split(seed, 10);
    light_sample          l;
    vxs_bytes             resident = {0}, bytes = {0};
    assert_int_equal(sample_common_make(&r, &common, (uint32_t)seed * 7 % SAMPLE_COMMON_MAX), VXS_OK);
    sample_page_make(&r, &page, &common, 1 + (uint32_t)seed % 20);
    light_make(&r, &l, &common, seed == 7 ? 15 : levels[seed % 6], seed % 4 == 1 ? 6 : 1);
    assert_int_equal(resident_encoded(&resident, l.words, l.word_count, l.levels, l.map_count, &common.common), VXS_OK);
    assert_int_equal(page_encoded(&bytes, page.words, page.word_count, page.nodes, page.node_count, &common.common), VXS_OK);

    const uint32_t counts[] = {l.levels,        l.map_count,     (uint32_t)resident.size_bytes,
                               l.word_count,    l.node_count,    common.common.packing,
                               page.node_count, page.word_count, (uint32_t)bytes.size_bytes};
    int            good     = write_numbers(to, counts, sizeof counts / sizeof *counts);
    good &= fwrite(resident.data, 1, resident.size_bytes, to) == resident.size_bytes;
    good &= write_numbers(to, l.words, l.word_count) & write_numbers(to, l.nodes, 5 * (size_t)l.node_count);
    good &= write_numbers(to, page.nodes, 5 * (size_t)page.node_count) & write_numbers(to, page.words, page.word_count);
    good &= fwrite(bytes.data, 1, bytes.size_bytes, to) == bytes.size_bytes;
    free(resident.data);
    free(bytes.data);
    light_free(&l);
    return good;
}

static int write_samples(const char *path)
{
    FILE *to   = fopen(path, "wb");
    int   good = to != NULL;
    for (uint64_t seed = 0; seed < 30 && good; seed++) good = write_sample(to, seed);
    if (to && fclose(to)) good = 0;
    return good ? 0 : 1;
}

int main(void)
{
    if (getenv("VXS_PAGES_OUT")) return write_samples(getenv("VXS_PAGES_OUT"));
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scratch_is_small),
        cmocka_unit_test(pages_come_back),
        cmocka_unit_test(pages_come_back_up_to_the_last_word),
        cmocka_unit_test(a_page_is_coded_alone),
        cmocka_unit_test(prefixes_are_refused),
        cmocka_unit_test(flipped_bits_do_no_harm),
        cmocka_unit_test(words_that_are_not_there_are_missed),
        cmocka_unit_test(random_bytes_do_no_harm),
        cmocka_unit_test(random_symbols_do_no_harm),
        cmocka_unit_test(changed_words_are_refused_or_come_back),
        cmocka_unit_test(nodes_must_be_where_the_top_says),
        cmocka_unit_test(resident_parts_come_back),
        cmocka_unit_test(damaged_resident_parts_do_no_harm),
        cmocka_unit_test(min_is_not_above_max),
    };
    return cmocka_run_group_tests(tests, make_scratch, free_scratch);
}
