/* Steps of reading a light of palette blocks: its table of pages, its resident part, and each page. Used to read all at once
 * (vxs_read_blocks.c) and page by page (runtime/stream_*.c). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_READ_PAGE_H
#define VXS_READ_PAGE_H

#include "vxs_page_fast.h"

/* Working memory of one thread. Pages packed small need `scratch`, pages packed fast need the others. */
typedef struct vxs_page_tools {
    vxs_page_scratch *scratch;
    vxs_page_marks   *marks;
    ZSTD_DCtx        *zstd;
} vxs_page_tools;

/* A light whose pages are decoded. Arrays belong to the caller. */
typedef struct vxs_paged_light {
    uint32_t         packing, levels, map_count;
    vxs_resident     resident;
    vxs_common_marks marks;    /* only for packing fast, like the next; packing small uses resident.patterns */
    uint8_t         *inflated; /* [vxs_resident_inflated_bytes] working memory for the resident part */
} vxs_paged_light;

/* The bytes of a page, and the expected numbers of its words and nodes. */
typedef struct vxs_page_content {
    const uint8_t       *bytes;
    uint32_t             size_bytes, word_count, node_count;
    uint64_t             hash;
    const vxs_page_node *nodes; /* [node_count] from the top */
} vxs_page_content;

/* Size of the table of so many pages; the bytes of the pages follow it. */
uint64_t vxs_page_table_bytes(uint32_t page_count);

/* The entry of a page in a table. */
static inline const uint8_t *vxs_page_entry(const uint8_t *table, uint32_t page)
{
    return table + VXS_PAGES_PREFIX_BYTES + (size_t)page * VXS_PAGE_BYTES;
}

/* Whether a table matches the resident part, its section and the light's record. Returns 0, or the number of a finding: 502,
 * 406.
 * table          the first vxs_page_table_bytes of the section, or fewer if it is shorter
 * section_bytes  size of the whole section, with its pages */
int vxs_check_page_table(const uint8_t *table, uint64_t section_bytes, const vxs_resident_sizes *sizes, uint32_t word_count);

/* Decode the resident part. Its words mark all pages as not loaded.
 * light  its arrays have these sizes; resident.patterns is needed for packing small, marks and inflated for packing fast
 * sizes  from vxs_resident_sizes_of at allocation. The bytes may come from a second read, and may have changed
 * Returns 0, or the number of a finding: 501, also if the bytes have other sizes. Threads: any, each with its own tools. */
int vxs_read_resident(vxs_paged_light *light, const vxs_resident_sizes *sizes, const uint8_t *bytes, uint64_t size_bytes,
                      const vxs_page_tools *tools);

/* Check and decode a page.
 * words  [page->word_count] out; undefined after an error
 * Returns 0, or the number of a finding: 503, 504, 505. Threads: any, each with its own tools. */
int vxs_read_page(uint32_t *words, const vxs_page_content *page, const vxs_paged_light *light, const vxs_page_tools *tools);

#endif
