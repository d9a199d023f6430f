/* Decoding pages and the resident part: bytes to words; vxs_page.h.
 * SPDX-License-Identifier: MIT */
#define PAGE_ENCODING 0
#include "vxs_resident_model.h"

size_t vxs_page_scratch_bytes(void)
{
    return sizeof(vxs_page_scratch);
}

uint32_t vxs_page_word_count(const uint8_t *bytes, size_t size_bytes)
{
    return size_bytes < 4 ? 0 : vxs_load16(bytes) + 1u;
}

vxs_result vxs_page_decode(uint32_t *words, const uint8_t *bytes, size_t size_bytes, const vxs_page_node *nodes,
                           uint32_t node_count, const vxs_common *common, vxs_page_scratch *scratch)
{
    if (size_bytes < 4 + 8 || size_bytes % 2) return VXS_E_TRUNCATED;
    const uint8_t *end = bytes + size_bytes - 8;
    walk           w   = {.c          = {.now = vxs_load32(end), .next = vxs_load32(end + 4), .in = bytes + 4, .end = end},
                          .odds       = &scratch->odds,
                          .s          = scratch,
                          .words      = words,
                          .word_count = vxs_load16(bytes) + 1u,
                          .node_words = vxs_load16(bytes + 2) + 1u,
                          .common     = common};
    if (w.node_words > w.word_count || !node_count) return VXS_E_CORRUPT;
    memset(words, 0, w.word_count * sizeof *words);
    if (!code_page(&w, nodes, node_count)) return VXS_E_CORRUPT;
    return w.c.in == end && w.c.now == STATE_LEAST && w.c.next == STATE_LEAST ? VXS_OK : VXS_E_CORRUPT;
}

vxs_result vxs_resident_sizes_of(vxs_resident_sizes *sizes, const uint8_t *bytes, size_t size_bytes)
{
    if (size_bytes < RESIDENT_HEAD_BYTES) return VXS_E_TRUNCATED;
    vxs_resident_sizes s = {vxs_load32(bytes), vxs_load32(bytes + 4), vxs_load32(bytes + 8), vxs_load32(bytes + 12)};
    if (s.word_count >= top_uniform / 32 || s.page_count > VXS_PAGES_MAX || s.node_count > s.word_count / 2 ||
        s.pattern_count > VXS_COMMON_HALVES_MAX || s.word_count < RESIDENT_WORDS + s.page_count)
        return VXS_E_CORRUPT;
    *sizes = s;
    return VXS_OK;
}

vxs_result vxs_resident_decode(vxs_resident *out, uint32_t levels, uint32_t map_count, uint32_t packing, const uint8_t *bytes,
                               size_t size_bytes, vxs_page_scratch *scratch)
{
    vxs_resident_sizes sizes;
    vxs_result         result = vxs_resident_sizes_of(&sizes, bytes, size_bytes);
    if (result != VXS_OK) return result;
    if (size_bytes < RESIDENT_HEAD_BYTES + 8 || size_bytes % 2) return VXS_E_TRUNCATED;
    const uint8_t *end = bytes + size_bytes - 8;
    top_odds       odds;
    resident_walk  r = {
         .w          = {.c          = {.now = vxs_load32(end), .next = vxs_load32(end + 4), .in = bytes + RESIDENT_HEAD_BYTES, .end = end},
                        .odds       = &scratch->odds,
                        .s          = scratch,
                        .words      = out->words,
                        .fine       = packing == VXS_PACKING_FINE,
                        .word_count = sizes.word_count},
         .odds       = &odds,
         .levels     = levels,
         .map_count  = map_count,
         .page_count = sizes.page_count,
         .node_count = sizes.node_count,
         .nodes      = out->nodes,
         .page_first = out->page_first,
         .patterns   = out->patterns,
         .pattern_count = sizes.pattern_count};
    memset(out->words, 0, sizes.word_count * sizeof *out->words);
    if (!code_resident(&r, NULL)) return VXS_E_CORRUPT;
    if (r.w.c.in != end || r.w.c.now != STATE_LEAST || r.w.c.next != STATE_LEAST) return VXS_E_CORRUPT;
    out->common = (vxs_common){out->words + out->words[1], r.w.half - 2 * out->words[1], out->patterns, {0}, packing};
    memcpy(out->common.first, r.first, sizeof r.first);
    return VXS_OK;
}
