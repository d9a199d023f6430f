/* Pages and resident parts packed fast: their words compressed by zstd. They are unpacked in a fraction of the time of
 * decoding (vxs_page.h), and take more than half as many bytes again.
 *
 * Bytes of such a page:
 *
 *     u16 words - 1, u16 node words - 1      as in vxs_page.h
 *     a zstd frame                           the words; a reference to a new block or pattern is stored as 0
 *
 * Bytes of a resident part: u32 words, u32 pages, u32 nodes, u32 patterns, as in vxs_page.h; then a zstd frame: the words,
 * with 0 for the words where pages start; and for each pattern of the common pool, in storage order, a byte: its kind.
 *
 * A new block or pattern starts where the last one ended, so that its reference needs no value. Words from zstd are
 * unchecked: vxs_page_check fills in references to new records, and checks every rule that decoding would keep;
 * vxs_resident_check does the same. They accept exactly the words that vxs_page_encode and vxs_resident_encode accept.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_FAST_H
#define VXS_PAGE_FAST_H

#include <zstd.h>

#include "vxs_page.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What starts at each half of a pool. 0: nothing known; 1: a private-palette pattern; n + 1: a pattern over n palette
 * depths. The array belongs to the caller. */
typedef struct vxs_common_marks {
    uint8_t *at;         /* [half_count] */
    uint32_t half_count; /* of the pool */
} vxs_common_marks;

/* One for each thread, for any number of pages, one at a time. The caller sets only `common`, of the light. */
typedef struct vxs_page_marks {
    const vxs_common_marks *common;
    uint8_t                 at[2 * VXS_PAGE_WORDS_MAX]; /* as above; 255: a block */
} vxs_page_marks;

/* Mark the patterns of the common pool of a light.
 * marks  its array has room for common->half_count */
void vxs_common_mark(vxs_common_marks *marks, const vxs_common *common);

/* Direction of vxs_page_check. */
typedef enum vxs_page_way {
    VXS_PAGE_UNPACK, /* from stored words to words for lookups */
    VXS_PAGE_PACK,   /* from words for lookups to stored words */
} vxs_page_way;

/* Check the words of a page, and convert its references to new records.
 * words       [word_count] in and out, 1..VXS_PAGE_WORDS_MAX; undefined after an error
 * node_words  words of nodes and blocks; the rest is the pool of patterns
 * nodes       [node_count] from the top; a page with nodes at other offsets is refused
 * marks       for its light
 * Returns VXS_OK; VXS_E_CORRUPT: a rule of the layout or of its order is broken (formats/vxs.md 13.2 to 13.4). No
 * allocation. */
vxs_result vxs_page_check(uint32_t *words, uint32_t word_count, uint32_t node_words, const vxs_page_node *nodes,
                          uint32_t node_count, vxs_page_marks *marks, vxs_page_way way);

/* Inflate the words of a page, as stored.
 * words  [word_count] out; undefined after an error
 * zstd   one for each thread
 * Returns VXS_OK; VXS_E_CORRUPT: the bytes are not a head and one frame of exactly so many words. Reads only bytes[0 ..
 * size_bytes - 1]. */
vxs_result vxs_page_inflate(uint32_t *words, uint32_t word_count, const uint8_t *bytes, size_t size_bytes, ZSTD_DCtx *zstd);

/* Number of words of nodes and blocks according to the bytes of a page that were inflated; it may exceed the number of words
 * of the page. */
uint32_t vxs_page_node_words(const uint8_t *bytes);

/* Append the bytes of a page; vxs_write_blocks.c. Arguments as for vxs_page_encode, without an encoder; zstd has its level set.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT: the page would not be accepted. The runtime library does not contain this
 * function. */
vxs_result vxs_page_pack(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                         uint32_t node_count, vxs_page_marks *marks, ZSTD_CCtx *zstd);

/* Greatest possible number of halves in the common pool of a light: 0 to VXS_COMMON_HALVES_MAX. */
uint32_t vxs_resident_common_halves(const vxs_resident_sizes *sizes);

/* Number of bytes in the frame of a resident part. */
uint64_t vxs_resident_inflated_bytes(const vxs_resident_sizes *sizes);

/* Inflate and check a resident part.
 * out       its words, nodes and page_first belong to the caller and have the sizes from vxs_resident_sizes_of; undefined
 *           after an error. Other fields are not used
 * marks     [out] patterns of the common pool; its array belongs to the caller and has vxs_resident_common_halves elements
 * inflated  [vxs_resident_inflated_bytes] working memory
 * Returns VXS_OK; VXS_E_CORRUPT. Other arguments as for vxs_resident_decode. No allocation. */
vxs_result vxs_resident_unpack(vxs_resident *out, vxs_common_marks *marks, uint32_t levels, uint32_t map_count,
                               const uint8_t *bytes, size_t size_bytes, uint8_t *inflated, ZSTD_DCtx *zstd);

/* Append the bytes of a resident part that vxs_resident_encode accepts; vxs_write_blocks.c.
 * words  [sizes->word_count]
 * kinds  [sizes->pattern_count] of the patterns, in storage order
 * Returns VXS_OK; VXS_E_MEMORY. The runtime library does not contain this function. */
vxs_result vxs_resident_pack(vxs_bytes *out, const vxs_resident_sizes *sizes, const uint32_t *words, const uint8_t *kinds,
                             ZSTD_CCtx *zstd);

#ifdef __cplusplus
}
#endif

#endif
