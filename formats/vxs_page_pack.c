/* Writing pages packed fast; vxs_page_fast.h.
 * SPDX-License-Identifier: MIT */
#include "vxs_page_fast.h"

#include <stdlib.h>
#include <string.h>

#include "vxs_bytes.h"
#include "vxs_page_layout.h"
#include "vxs_resident_layout.h"
#include "vxs_writer.h"

enum { PAGE_HEAD_BYTES = 4 };

/* Append a head and the content as a frame. */
static vxs_result append_packed(vxs_bytes *out, const uint8_t *head, size_t head_bytes, const uint8_t *content,
                                size_t content_bytes, ZSTD_CCtx *zstd)
{
    size_t   before = out->size_bytes, bound = ZSTD_compressBound(content_bytes);
    uint8_t *to = vxs_append(out, head_bytes + bound);
    if (!to) return VXS_E_MEMORY;
    memcpy(to, head, head_bytes);
    size_t stored   = ZSTD_compress2(zstd, to + head_bytes, bound, content, content_bytes);
    out->size_bytes = before + (ZSTD_isError(stored) ? 0 : head_bytes + stored);
    return ZSTD_isError(stored) ? VXS_E_MEMORY : VXS_OK;
}

/* Convert words to bytes in place. */
static uint8_t *to_bytes(uint32_t *words, uint32_t word_count)
{
    uint8_t *bytes = (uint8_t *)words;
    for (uint32_t n = 0; n < word_count; n++) vxs_store32(bytes + 4 * (size_t)n, words[n]);
    return bytes;
}

vxs_result vxs_page_pack(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                         uint32_t node_count, vxs_page_marks *marks, ZSTD_CCtx *zstd)
{
    if (!word_count || word_count > VXS_PAGE_WORDS_MAX) return VXS_E_ARGUMENT;
    uint32_t  node_words = node_words_of(words, word_count, nodes, node_count);
    uint32_t *copy       = malloc(word_count * sizeof *copy);
    if (!copy) return VXS_E_MEMORY;
    memcpy(copy, words, word_count * sizeof *copy);
    vxs_result r = vxs_page_check(copy, word_count, node_words, nodes, node_count, marks, VXS_PAGE_PACK);
    uint8_t    head[PAGE_HEAD_BYTES];
    vxs_store16(head, (uint16_t)(word_count - 1));
    vxs_store16(head + 2, (uint16_t)(node_words - 1));
    r = r != VXS_OK ? VXS_E_ARGUMENT
                    : append_packed(out, head, sizeof head, to_bytes(copy, word_count), 4 * (size_t)word_count, zstd);
    free(copy);
    return r;
}

vxs_result vxs_resident_pack(vxs_bytes *out, const vxs_resident_sizes *sizes, const uint32_t *words, const uint8_t *kinds,
                             ZSTD_CCtx *zstd)
{
    const uint32_t numbers[] = {sizes->word_count, sizes->page_count, sizes->node_count, sizes->pattern_count};
    uint8_t        head[RESIDENT_HEAD_BYTES];
    size_t         size = vxs_resident_inflated_bytes(sizes);
    uint32_t      *copy = malloc(size);
    if (!copy) return VXS_E_MEMORY;
    for (int n = 0; n < 4; n++) vxs_store32(head + 4 * n, numbers[n]);
    memcpy(copy, words, 4 * (size_t)sizes->word_count);
    memset(copy + RESIDENT_WORDS, 0, 4 * (size_t)sizes->page_count);
    if (sizes->pattern_count) memcpy(copy + sizes->word_count, kinds, sizes->pattern_count);
    vxs_result r = append_packed(out, head, sizeof head, to_bytes(copy, sizes->word_count), size, zstd);
    free(copy);
    return r;
}
