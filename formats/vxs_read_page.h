/* What reading a light of palette blocks consists of: its table of pages, its resident part, and each page. One text for all who do it, at
 * once (vxs_read_blocks.c) or page by page (runtime/stream_*.c). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_READ_PAGE_H
#define VXS_READ_PAGE_H

#include "vxs_page_fast.h"

/* What a thread decodes by: pages that are packed small by the first, fast ones by the others. */
typedef struct vxs_page_tools {
    vxs_page_scratch *scratch;
    vxs_page_marks   *marks;
    ZSTD_DCtx        *zstd;
} vxs_page_tools;

/* A light whose pages are decoded. Arrays are the caller's. */
typedef struct vxs_paged_light {
    uint32_t         packing, levels, map_count;
    vxs_resident     resident;
    vxs_common_marks marks;    /* packed fast, as the next; others have the patterns of the resident part */
    uint8_t         *inflated; /* [vxs_resident_inflated_bytes] to work in, while the resident part is read */
} vxs_paged_light;

/* A page's bytes, and what its words are to be. */
typedef struct vxs_page_content {
    const uint8_t       *bytes;
    uint32_t             size_bytes, word_count, node_count;
    uint64_t             hash;
    const vxs_page_node *nodes; /* [node_count] as the top says */
} vxs_page_content;

/* Bytes of the table of so many pages, before those of pages. */
uint64_t vxs_page_table_bytes(uint32_t page_count);

/* The entry of a page in a table. */
static inline const uint8_t *vxs_page_entry(const uint8_t *table, uint32_t page)
{
    return table + VXS_PAGES_PREFIX_BYTES + (size_t)page * VXS_PAGE_BYTES;
}

/* Whether a table fits the resident part, its section and its light's record. Returns 0, or the number of a finding: 502, 406.
 * table  what the section has of vxs_page_table_bytes;   section_bytes  of all of it, pages too */
int vxs_check_page_table(const uint8_t *table, uint64_t section_bytes, const vxs_resident_sizes *sizes, uint32_t word_count);

/* Decode the resident part. Its words say that no page is there.
 * light  its arrays are of these sizes; resident.patterns of one that is packed small, marks and inflated of one that is fast
 * sizes  what vxs_resident_sizes_of said when room was made. The bytes may come from a second read, and may say something else
 * Returns 0, or the number of a finding: 501, also for bytes of other sizes. Threads: any, each with tools of its own. */
int vxs_read_resident(vxs_paged_light *light, const vxs_resident_sizes *sizes, const uint8_t *bytes, uint64_t size_bytes,
                      const vxs_page_tools *tools);

/* Check and decode a page.
 * words  [page->word_count] out; what they hold after an error means nothing
 * Returns 0, or the number of a finding: 503, 504, 505. Threads: any, each with tools of its own. */
int vxs_read_page(uint32_t *words, const vxs_page_content *page, const vxs_paged_light *light, const vxs_page_tools *tools);

#endif
