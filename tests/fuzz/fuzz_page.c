/* Any bytes as a page, or as the resident part of a light (formats/vxs_page.h): what is decoded must keep every rule of the layout that
 * a lookup relies on, as tests/unit/page_sample.h states them.
 *
 *     byte 0      even: a page; odd: a resident part of a map of 2^(3 + (byte 0 >> 1) % 15) texels
 *     page        byte 1: nodes - 1, modulo 8; a u16 for each but the first: how far it starts behind the one before; then the bytes
 *     resident    the bytes
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "fuzz.h"
#include "tests/unit/page_sample.h"

enum { NODES_MAX = 8, WORDS_MAX = 1 << 20 };

static vxs_page_scratch *scratch;
static sample_common     common;

static int start(void)
{
    rng r   = rng_split(1, 1);
    scratch = malloc(vxs_page_scratch_bytes());
    FUZZ_CHECK(scratch);
    vxs_page_scratch_init(scratch);
    FUZZ_CHECK(sample_common_make(&r, &common, 30) == VXS_OK);
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

static void read_page(const uint8_t *data, size_t size)
{
    vxs_page_node nodes[NODES_MAX] = {{0}};
    uint32_t      count = 1 + data[0] % NODES_MAX, head = 1 + 2 * (count - 1);
    if (size < head) return;
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
        result          = vxs_page_encode(&again, page, words, nodes, count, &common.common);
        FUZZ_CHECK(result == VXS_OK || result == VXS_E_ARGUMENT); /* it may be no canonical one */
        free(again.data);
    }
    free(page);
    free(bytes);
}

static void read_resident(uint32_t levels, const uint8_t *data, size_t size)
{
    uint8_t           *bytes = copy_of(data, size);
    vxs_resident_sizes sizes;
    vxs_result         result = vxs_resident_sizes_of(&sizes, bytes, size);
    if (result == VXS_OK && sizes.word_count <= WORDS_MAX) {
        vxs_resident o = {.words      = malloc(sizes.word_count * sizeof *o.words),
                          .nodes      = malloc(sizes.node_count * sizeof *o.nodes + 1),
                          .page_first = malloc((sizes.page_count + 1) * sizeof *o.page_first),
                          .patterns   = malloc(sizes.pattern_count * sizeof *o.patterns + 1)};
        result         = vxs_resident_decode(&o, levels, 1, bytes, size, scratch);
        FUZZ_CHECK(result == VXS_OK || result == VXS_E_TRUNCATED || result == VXS_E_CORRUPT);
        checked_words pool = {o.common.words, result == VXS_OK ? o.common.half_count : 0};
        int           good = 1;
        for (uint32_t n = 0; n < sizes.pattern_count && result == VXS_OK; n++) {
            uint32_t half = o.patterns[n].ref & (REF_OF_COMMON - 1);
            if (o.patterns[n].kind)
                check_masks(pool, half, o.patterns[n].kind, &good);
            else
                check_own(pool, half, &good);
        }
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
        read_resident(3 + (data[0] >> 1) % 15, data + 1, size - 1);
    else
        read_page(data + 1, size - 1);
    return 0;
}
