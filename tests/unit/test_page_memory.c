/* The encoder of pages without memory (formats/vxs_page.h): compiled with an allocator whose n-th allocation fails.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "page_sample.h"

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

vxs_result page_encode_failing(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                               uint32_t node_count, const vxs_common *common);
vxs_result resident_encode_failing(vxs_bytes *out, const uint32_t *words, uint32_t word_count, uint32_t levels, uint32_t map_count,
                                   const vxs_common *common);
vxs_result common_index_again(vxs_common *common, uint32_t *patterns, const uint8_t *kinds, uint32_t pattern_count,
                              const uint32_t *words, uint32_t half_count);

#define malloc              failing_malloc
#define calloc              failing_calloc
#define realloc             failing_realloc
#define free                counted_free
#define vxs_page_encode     page_encode_failing
#define vxs_resident_encode resident_encode_failing
#define vxs_common_index    common_index_again
#include "formats/vxs_page_encode.c"
#undef malloc
#undef calloc
#undef realloc
#undef free
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
    vxs_result result = resident_encode_failing(out, words, 10 + pool, 8, 1, &common.common);
    free(words);
    return result;
}

static vxs_result encode_page(vxs_bytes *out)
{
    return page_encode_failing(out, page.words, page.word_count, page.nodes, page.node_count, &common.common);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pages_without_memory),
        cmocka_unit_test(resident_parts_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
