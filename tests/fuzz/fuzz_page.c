/* Any bytes as a page, or as the resident part of a light (formats/vxs_page.h): what is decoded must keep every rule of the layout
 * that a lookup relies on, as tests/unit/page_sample.h states them. The bytes of a page are taken for words as well, which the
 * check of pages that are packed fast (formats/vxs_page_fast.h) has to take exactly where the coder does.
 *
 *     byte 0      even: a page; odd: a resident part of a map of 2^(3 + (byte 0 >> 1) % 15) texels
 *     page        byte 1: nodes - 1, + 8 when it is packed fine, modulo 16; a u16 for each node but the first: how far it starts
 *                 behind the one before; then the bytes
 *     resident    the bytes
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_bytes.h"
#include "formats/vxs_page_fast.h"
#include "fuzz.h"
#include "tests/unit/page_encoded.h"
#include "tests/unit/page_sample.h"

enum { NODES_MAX = 8, WORDS_MAX = 1 << 20 };

static vxs_page_scratch *scratch;
static sample_common     common;
static uint8_t           in_common_at[VXS_COMMON_HALVES_MAX];
static vxs_common_marks  in_common = {in_common_at, 0};
static vxs_page_marks    marks     = {.common = &in_common};

static int start(void)
{
    rng r   = rng_split(1, 1);
    scratch = malloc(vxs_page_scratch_bytes());
    FUZZ_CHECK(scratch);
    FUZZ_CHECK(sample_common_make(&r, &common, 30) == VXS_OK);
    vxs_common_mark(&in_common, &common.common);
    return 1;
}

/* Of their own, so that a byte read beyond them is seen. */
static uint8_t *copy_of(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1);
    FUZZ_CHECK(copy);
    if (size) memcpy(copy, data, size);
    return copy;
}

/* Words as they are looked up, in which names of what is new are known, are packed where they are coded. */
static void check_named_words(const uint32_t *words, uint32_t count, const vxs_page_node *nodes, uint32_t node_count)
{
    vxs_bytes  coded = {0}, packed = {0};
    ZSTD_CCtx *zstd   = ZSTD_createCCtx();
    vxs_result wanted = page_encoded(&coded, words, count, nodes, node_count, &common.common);
    FUZZ_CHECK(zstd && vxs_page_pack(&packed, words, count, nodes, node_count, &marks, zstd) == wanted);
    ZSTD_freeCCtx(zstd);
    free(coded.data);
    free(packed.data);
}

/* u16: words of nodes - 1, then words as they are stored. */
static void read_words(const uint8_t *data, size_t size, const vxs_page_node *nodes, uint32_t node_count)
{
    uint32_t count = size < 6 ? 0 : (uint32_t)(size - 2) / 4, *words = malloc((size_t)count * 4 + 1);
    FUZZ_CHECK(words);
    if (count > VXS_PAGE_WORDS_MAX) count = VXS_PAGE_WORDS_MAX;
    for (uint32_t n = 0; n < count; n++) words[n] = vxs_load32(data + 2 + 4 * (size_t)n);
    if (count) {
        check_named_words(words, count, nodes, node_count);
        if (vxs_page_check(words, count, vxs_load16(data) + 1u, nodes, node_count, &marks, VXS_PAGE_UNPACK) == VXS_OK) {
            FUZZ_CHECK(check_page(words, count, nodes, node_count, &common.common));
            check_named_words(words, count, nodes, node_count);
        }
    }
    free(words);
}

static void read_page(const uint8_t *data, size_t size)
{
    vxs_page_node nodes[NODES_MAX] = {{0}};
    uint32_t      count = 1 + data[0] % NODES_MAX, head = 1 + 2 * (count - 1);
    if (size < head) return;
    common.common.packing = data[0] & NODES_MAX ? VXS_PACKING_FINE : VXS_PACKING_SMALL;
    for (uint32_t n = 1; n < count; n++)
        nodes[n] =
            (vxs_page_node){.offset = nodes[n - 1].offset + (data[2 * n - 1] | (uint32_t)data[2 * n] << 8), .x = n % 3, .y = n / 3};
    uint8_t   *bytes  = copy_of(data + head, size - head);
    uint32_t   words  = vxs_page_word_count(bytes, size - head);
    uint32_t  *page   = malloc(words * sizeof *page + 1);
    vxs_result result = vxs_page_decode(page, bytes, size - head, nodes, count, &common.common, scratch);
    FUZZ_CHECK(result == VXS_OK || result == VXS_E_TRUNCATED || result == VXS_E_CORRUPT);
    if (result == VXS_OK) {
        FUZZ_CHECK(check_page(page, words, nodes, count, &common.common));
        vxs_bytes again = {0};
        result          = page_encoded(&again, page, words, nodes, count, &common.common);
        FUZZ_CHECK(result == VXS_OK || result == VXS_E_ARGUMENT); /* it may be no canonical one */
        free(again.data);
    }
    read_words(bytes, size - head, nodes, count);
    free(page);
    free(bytes);
}

static void read_resident(uint32_t levels, uint32_t packing, const uint8_t *data, size_t size)
{
    uint8_t           *bytes = copy_of(data, size);
    vxs_resident_sizes sizes;
    vxs_result         result = vxs_resident_sizes_of(&sizes, bytes, size);
    if (result == VXS_OK && sizes.word_count <= WORDS_MAX) {
        vxs_resident o = {.words      = malloc(sizes.word_count * sizeof *o.words),
                          .nodes      = malloc(sizes.node_count * sizeof *o.nodes + 1),
                          .page_first = malloc((sizes.page_count + 1) * sizeof *o.page_first),
                          .patterns   = malloc(sizes.pattern_count * sizeof *o.patterns + 1)};
        result         = vxs_resident_decode(&o, levels, 1, packing, bytes, size, scratch);
        FUZZ_CHECK(result == VXS_OK || result == VXS_E_TRUNCATED || result == VXS_E_CORRUPT);
        checked_words pool = {o.common.words, result == VXS_OK ? o.common.half_count : 0};
        int           good = 1;
        for (uint32_t kind = 0; kind < VXS_PATTERN_KINDS && result == VXS_OK; kind++)
            for (uint32_t n = o.common.first[kind]; n < o.common.first[kind + 1]; n++)
                if (kind)
                    check_masks(pool, o.patterns[n], kind, &good);
                else
                    check_private(pool, o.patterns[n], &good);
        FUZZ_CHECK(good);
        free(o.words);
        free(o.nodes);
        free(o.page_first);
        free(o.patterns);
    }
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static int started;
    if (!started) started = start();
    if (size < 2) return 0;
    if (data[0] & 1)
        read_resident(3 + (data[0] >> 1) % 15, data[0] >> 7 ? VXS_PACKING_FINE : VXS_PACKING_SMALL, data + 1, size - 1);
    else
        read_page(data + 1, size - 1);
    return 0;
}
