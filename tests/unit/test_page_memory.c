/* The encoder of pages (formats/vxs_page.h) from within: compiled with an allocator whose n-th allocation fails; and with symbols
 * that no decoder would get back.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "page_sample.h"
#include "repeats.h"

#include <cmocka.h>

static size_t calls, fail_at, live;

static void *counted(void *memory)
{
    live += memory != NULL;
    return memory;
}

static void *failing_malloc(size_t size)
{
    return ++calls == fail_at ? NULL : counted(malloc(size));
}

static void *failing_calloc(size_t count, size_t size)
{
    return ++calls == fail_at ? NULL : counted(calloc(count, size));
}

static void *failing_realloc(void *memory, size_t size)
{
    if (++calls == fail_at) return NULL;
    return memory ? realloc(memory, size) : counted(malloc(size));
}

static void counted_free(void *memory)
{
    live -= memory != NULL;
    free(memory);
}

vxs_page_encoder *encoder_new_failing(void);
void              encoder_free_counted(vxs_page_encoder *e);
vxs_result        page_encode_failing(vxs_page_encoder *e, vxs_bytes *out, const uint32_t *words, uint32_t word_count,
                                      const vxs_page_node *nodes, uint32_t node_count, const vxs_common *common);
vxs_result        resident_encode_failing(vxs_bytes *out, vxs_page_nodes *nodes, const uint32_t *words, uint32_t word_count,
                                          uint32_t levels, uint32_t map_count, const vxs_common *common);
vxs_result        common_index_again(vxs_common *common, uint32_t *patterns, const uint8_t *kinds, uint32_t pattern_count,
                                     const uint32_t *words, uint32_t half_count);

#define malloc                failing_malloc
#define calloc                failing_calloc
#define realloc               failing_realloc
#define free                  counted_free
#define vxs_page_encoder_new  encoder_new_failing
#define vxs_page_encoder_free encoder_free_counted
#define vxs_page_encode       page_encode_failing
#define vxs_resident_encode   resident_encode_failing
#define vxs_common_index      common_index_again
#include "formats/vxs_page_encode.c"
#include "page_encoded.h"
#undef malloc
#undef calloc
#undef realloc
#undef free
#undef vxs_page_encoder_new
#undef vxs_page_encoder_free
#undef vxs_page_encode
#undef vxs_resident_encode
#undef vxs_common_index

static sample_page   page;
static sample_common common;

/* A light of one square, a depth. */
static vxs_result encode_resident(vxs_bytes *out)
{
    uint32_t pool = (common.common.half_count + 1) / 2, *words = calloc(10 + pool, sizeof *words);
    words[1] = 10;
    words[2] = 8;
    words[8] = 0x80000007;
    memcpy(words + 10, common.words, pool * sizeof *words);
    vxs_result result = resident_encoded(out, words, 10 + pool, 8, 1, &common.common);
    free(words);
    return result;
}

static vxs_result encode_page(vxs_bytes *out)
{
    return page_encoded(out, page.words, page.word_count, page.nodes, page.node_count, &common.common);
}

/* Each allocation fails once: nothing is kept, and what was there before stays. */
static void check_failing(vxs_result (*encode)(vxs_bytes *out), size_t least)
{
    vxs_result result = VXS_E_MEMORY;
    for (size_t n = 1; result != VXS_OK; n++) {
        vxs_bytes out = {0};
        calls = fail_at = live = 0;
        assert_int_equal(encode(&out), VXS_OK);
        size_t before = out.size_bytes;
        calls         = 0;
        fail_at       = n;
        result        = encode(&out);
        assert_true(result == VXS_OK || result == VXS_E_MEMORY);
        if (result == VXS_E_MEMORY) assert_int_equal(out.size_bytes, before);
        assert_int_equal(live, 1);
        if (result == VXS_OK) assert_true(n > least);
        free(out.data);
    }
}

static void pages_without_memory(void **state)
{
    (void)state;
    rng r = rng_split(3, 1);
    assert_int_equal(sample_common_make(&r, &common, 20), VXS_OK);
    sample_page_make(&r, &page, &common, 0); /* large enough for lists that grow */
    check_failing(encode_page, 6);
}

static void resident_parts_without_memory(void **state)
{
    (void)state;
    rng r = rng_split(4, 1);
    assert_int_equal(sample_common_make(&r, &common, 20), VXS_OK);
    check_failing(encode_resident, 6);
}

/* Take the symbols back, as the decoder does. */
static void are_taken_back(const vxs_bytes *out, const uint32_t *parts, uint32_t count)
{
    const uint8_t *in = out->data, *end = in + out->size_bytes - 8;
    uint32_t       state[2] = {vxs_load32(end), vxs_load32(end + 4)};
    for (uint32_t n = 0; n < count; n++) {
        uint32_t *s = &state[n & 1], from = parts[n] & 0xffff, behind = parts[n] >> 16, at = *s & (ODDS_ONE - 1);
        assert_true(at >= from && at < behind);
        *s = (behind - from) * (*s >> ODDS_BITS) + at - from;
        if (*s >= STATE_LEAST) continue;
        assert_true(in < end);
        *s = *s << 16 | vxs_load16(in);
        in += 2;
    }
    assert_true(in == end && state[0] == STATE_LEAST && state[1] == STATE_LEAST);
}

/* A part of the odds beyond their end, or of size 0, is no symbol. All others are taken. */
static void faults_of_the_coder_are_found(void **state)
{
    (void)state;
    rng r   = rng_split(5, 1);
    fail_at = 0;
    for (uint64_t n = 0; n < repeats(2000, 100000); n++) {
        uint32_t parts[64], copy[64], count = 1 + rng_below(&r, 64), wrong = rng_below(&r, count);
        for (uint32_t k = 0; k < count; k++) {
            uint32_t from = rng_below(&r, ODDS_ONE), most = rng_below(&r, 4);
            uint32_t size = most ? 1 + rng_below(&r, most > 1 ? ODDS_ONE - from : 1) : ODDS_ONE - from;
            parts[k]      = from | (from + size) << 16;
        }
        for (uint32_t is_wrong = 0; is_wrong < 2; is_wrong++) {
            vxs_bytes out = {0};
            memcpy(copy, parts, sizeof copy);
            if (is_wrong)
                copy[wrong] = rng_below(&r, 2) ? (copy[wrong] & 0xffff) | copy[wrong] << 16 : 5u | (uint32_t)(ODDS_ONE + 1) << 16;
            vxs_result result = append_coded(&out, &(coder){.parts = copy, .at = copy + count});
            assert_int_equal(result, is_wrong ? VXS_E_ARGUMENT : VXS_OK);
            if (is_wrong)
                assert_int_equal(out.size_bytes, 0);
            else
                are_taken_back(&out, parts, count);
            free(out.data);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pages_without_memory),
        cmocka_unit_test(resident_parts_without_memory),
        cmocka_unit_test(faults_of_the_coder_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
