/* Pages and resident parts that are packed fast: their words under zstd, which opens them in a fraction of the time that decoding takes (vxs_page.h), for
 * more than half as many bytes again.
 *
 * Bytes of such a page:
 *
 *     u16 words - 1, u16 node words - 1      as of the other ones
 *     a zstd frame                           the words, in which a reference to a block or a pattern that is new is 0
 *
 * Bytes of a resident part: u32 words, u32 pages, u32 nodes, u32 patterns, as of the other ones, then a zstd frame: the words, those where
 * pages start being 0; and a byte for each pattern of the common pool, as they lie: its kind.
 *
 * What is new lies where the last one ended, so that it needs no name. Words come from zstd as they were stored, and nothing is known
 * of them: vxs_page_check names what is new, and holds them against every rule that decoding would have kept, as vxs_resident_check does. What
 * they take is what vxs_page_encode and vxs_resident_encode take, and nothing else.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_FAST_H
#define VXS_PAGE_FAST_H

#include <zstd.h>

#include "vxs_page.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What starts at each half of a pool: 0: nothing that is known; else a pattern of so many depths of a palette, + 1, or 1 of one that has
 * its own. The array is the caller's. */
typedef struct vxs_common_marks {
    uint8_t *at;         /* [half_count] */
    uint32_t half_count; /* of the pool */
} vxs_common_marks;

/* One for each thread, for any number of pages, one at a time. The caller says the common pool of the light, and nothing else. */
typedef struct vxs_page_marks {
    const vxs_common_marks *common;
    uint8_t                 at[2 * VXS_PAGE_WORDS_MAX]; /* as above; 255: a block */
} vxs_page_marks;

/* Say what is in the common pool of a light.
 * marks  its array has room for common->half_count */
void vxs_common_mark(vxs_common_marks *marks, const vxs_common *common);

/* Which way vxs_page_check goes. */
typedef enum vxs_page_way {
    VXS_PAGE_UNPACK, /* from words as they are stored to words as they are looked up */
    VXS_PAGE_PACK,   /* back */
} vxs_page_way;

/* Check the words of a page, and turn its references to what is new.
 * words       [word_count] in and out, 1..VXS_PAGE_WORDS_MAX; what they hold after an error means nothing
 * node_words  of nodes and blocks; the rest is the pool of patterns
 * nodes       [node_count] as the top says; a page whose nodes start elsewhere is refused
 * marks       of its light
 * Returns VXS_OK; VXS_E_CORRUPT: a rule of the layout, or of its order, is broken (formats/vxs.md 13.2 to 13.4). No allocation. */
vxs_result vxs_page_check(uint32_t *words, uint32_t word_count, uint32_t node_words, const vxs_page_node *nodes,
                          uint32_t node_count, vxs_page_marks *marks, vxs_page_way way);

/* Inflate the words of a page, as they are stored.
 * words  [word_count] out; what it holds after an error means nothing
 * zstd   one for each thread
 * Returns VXS_OK; VXS_E_CORRUPT: the bytes are not a head and one frame of so many words. Reads bytes[0 .. size_bytes - 1] only. */
vxs_result vxs_page_inflate(uint32_t *words, uint32_t word_count, const uint8_t *bytes, size_t size_bytes, ZSTD_DCtx *zstd);

/* How many of a page's words are those of nodes and blocks, as its bytes say, which were inflated; it may be more than there are. */
uint32_t vxs_page_node_words(const uint8_t *bytes);

/* Append the bytes of a page; vxs_page_pack.c. Arguments as for vxs_page_encode, and zstd with a level.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT: the page would not be taken. The runtime library does not hold this function. */
vxs_result vxs_page_pack(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                         uint32_t node_count, vxs_page_marks *marks, ZSTD_CCtx *zstd);

/* How many halves the common pool of a light has at most: 0 to VXS_COMMON_HALVES_MAX. */
uint32_t vxs_resident_common_halves(const vxs_resident_sizes *sizes);

/* How many bytes the frame of a resident part holds. */
uint64_t vxs_resident_inflated_bytes(const vxs_resident_sizes *sizes);

/* Inflate and check a resident part.
 * out       its words, nodes and page_first are the caller's, of the sizes that vxs_resident_sizes_of says; of the rest nothing is looked
 *           at. What they hold after an error means nothing
 * marks     [out] what is in its common pool; its array is the caller's, vxs_resident_common_halves long
 * inflated  [vxs_resident_inflated_bytes] memory to work in
 * Returns VXS_OK; VXS_E_CORRUPT. Other arguments as for vxs_resident_decode. No allocation. */
vxs_result vxs_resident_unpack(vxs_resident *out, vxs_common_marks *marks, uint32_t levels, uint32_t map_count,
                               const uint8_t *bytes, size_t size_bytes, uint8_t *inflated, ZSTD_DCtx *zstd);

/* Append the bytes of a resident part that vxs_resident_encode takes; vxs_page_pack.c.
 * words  [sizes->word_count]
 * kinds  [sizes->pattern_count] of the patterns as they lie
 * Returns VXS_OK; VXS_E_MEMORY. The runtime library does not hold this function. */
vxs_result vxs_resident_pack(vxs_bytes *out, const vxs_resident_sizes *sizes, const uint32_t *words, const uint8_t *kinds,
                             ZSTD_CCtx *zstd);

#ifdef __cplusplus
}
#endif

#endif
