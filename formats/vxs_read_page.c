/* The parts of a light of palette blocks, checked and decoded one by one; vxs_read_page.h.
 *
 * Before decoding, the sizes in the table are added up, and compared with the section and the light's record. Decoding
 * checks the rest (vxs_page.h), except for pages packed fast, whose words are checked (vxs_page_fast.h).
 * SPDX-License-Identifier: MIT */
#include "vxs_read_page.h"

#include <xxhash.h>

#include "vxs_bytes.h"

uint64_t vxs_page_table_bytes(uint32_t page_count)
{
    return VXS_PAGES_PREFIX_BYTES + (uint64_t)page_count * VXS_PAGE_BYTES;
}

int vxs_check_page_table(const uint8_t *table, uint64_t section_bytes, const vxs_resident_sizes *sizes, uint32_t word_count)
{
    uint64_t at = vxs_page_table_bytes(sizes->page_count), words = sizes->word_count;
    if (section_bytes < at || vxs_load32(table) != sizes->page_count || vxs_load32(table + 4) != VXS_PAGE_BYTES) return 502;
    for (uint32_t page = 0; page < sizes->page_count; page++) {
        at += vxs_load32(vxs_page_entry(table, page) + VXS_PAGE_STORED_BYTES);
        words += vxs_load32(vxs_page_entry(table, page) + VXS_PAGE_WORD_COUNT);
    }
    if (at != section_bytes) return 502;
    return words != word_count ? 406 : 0;
}

static int same_sizes(const vxs_resident_sizes *a, const vxs_resident_sizes *b)
{
    return a->word_count == b->word_count && a->page_count == b->page_count && a->node_count == b->node_count &&
           a->pattern_count == b->pattern_count;
}

int vxs_read_resident(vxs_paged_light *light, const vxs_resident_sizes *sizes, const uint8_t *bytes, uint64_t size_bytes,
                      const vxs_page_tools *tools)
{
    vxs_resident_sizes now;
    if (vxs_resident_sizes_of(&now, bytes, size_bytes) != VXS_OK || !same_sizes(&now, sizes)) return 501;
    vxs_result r = light->packing == VXS_PACKING_FAST
                       ? vxs_resident_unpack(&light->resident, &light->marks, light->levels, light->map_count, bytes, size_bytes,
                                             light->inflated, tools->zstd)
                       : vxs_resident_decode(&light->resident, light->levels, light->map_count, bytes, size_bytes, tools->scratch);
    return r == VXS_OK ? 0 : 501;
}

static int read_small(uint32_t *words, const vxs_page_content *p, const vxs_paged_light *light, const vxs_page_tools *tools)
{
    if (vxs_page_word_count(p->bytes, p->size_bytes) != p->word_count) return 504;
    vxs_result r =
        vxs_page_decode(words, p->bytes, p->size_bytes, p->nodes, p->node_count, &light->resident.common, tools->scratch);
    return r == VXS_OK ? 0 : 504;
}

static int read_fast(uint32_t *words, const vxs_page_content *p, const vxs_paged_light *light, const vxs_page_tools *tools)
{
    if (vxs_page_inflate(words, p->word_count, p->bytes, p->size_bytes, tools->zstd) != VXS_OK) return 505;
    tools->marks->common = &light->marks;
    vxs_result r =
        vxs_page_check(words, p->word_count, vxs_page_node_words(p->bytes), p->nodes, p->node_count, tools->marks, VXS_PAGE_UNPACK);
    return r == VXS_OK ? 0 : 504;
}

int vxs_read_page(uint32_t *words, const vxs_page_content *p, const vxs_paged_light *light, const vxs_page_tools *tools)
{
    if (XXH64(p->bytes, p->size_bytes, 0) != p->hash) return 503;
    return light->packing == VXS_PACKING_FAST ? read_fast(words, p, light, tools) : read_small(words, p, light, tools);
}
