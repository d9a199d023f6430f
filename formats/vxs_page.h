/* Pages and the resident part of a light of palette blocks: their words in memory, and their bytes on disk.
 *
 * Each page is coded alone, without any content of another page. So pages can be decoded in any order and in parallel. A
 * page depends only on the resident part: the common pool of patterns, and the entries of the top that use its nodes
 * (vxs_page_node).
 *
 * Bytes of a page:
 *
 *     u16 words - 1      of the page, 1..65536
 *     u16 node words     words of nodes and blocks, minus 1; the rest is the pool of patterns
 *     u16 ...            words of the coder (vxs_page_coder.h)
 *     u32 u32            its two states
 *
 * Bytes of a resident part: u32 words, u32 pages, u32 nodes, u32 patterns, then as above.
 *
 * Decoding is also the check: decoded words keep every rule of the layout, so that a lookup never leaves the words of the
 * page or the common pool. Damaged bytes may decode to other words, but never to words that break a rule.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_H
#define VXS_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "vxs_write_file.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    VXS_PAGES_MAX         = 32767,
    VXS_PAGE_WORDS_MAX    = 65536,
    VXS_COMMON_HALVES_MAX = 1 << 17,
    /* 0: private-palette patterns; 2..14: patterns over so many depths of the block palette; 1 is unused */
    VXS_PATTERN_KINDS     = 15,
};

/* A node of a page, and the first entry of the top that uses it. The coder predicts the node from its neighbours at that
 * entry. */
typedef struct vxs_page_node {
    uint32_t offset; /* word of the page where the node starts; nodes are in ascending order */
    uint32_t x, y;   /* the square of 256 x 256 texels of the entry, in its map */
    uint32_t map;    /* 0..5 */
    int32_t  base;   /* base depth of the entry; lookups use k - base in the node */
} vxs_page_node;

/* The common pool of a light. */
typedef struct vxs_common {
    const uint32_t *words; /* [(half_count + 1) / 2] */
    uint32_t        half_count;
    /* halves of the pool where patterns start, ordered by kind, then by position */
    const uint32_t *patterns;
    uint32_t        first[VXS_PATTERN_KINDS + 1]; /* patterns of kind p are first[p]..first[p + 1] - 1 */
    uint32_t        packing;                      /* of the pages: VXS_PACKING_SMALL or VXS_PACKING_FINE */
} vxs_common;

/* Working memory for decoding: of the size below, aligned to 16 bytes, one for each thread, never part of a result. It can
 * be used for any number of pages, one at a time, and needs no initialization or release. */
typedef struct vxs_page_scratch vxs_page_scratch;

/* Size of vxs_page_scratch, some 600 KiB. */
size_t vxs_page_scratch_bytes(void);

/* Number of words of the page that these bytes encode, 1..VXS_PAGE_WORDS_MAX; 0: too few bytes. */
uint32_t vxs_page_word_count(const uint8_t *bytes, size_t size_bytes);

/* Decode a page.
 * words   [vxs_page_word_count(bytes, size_bytes)] out; undefined after an error
 * nodes   [node_count] from the top; a page with nodes at other offsets is refused
 * common  checked: made by vxs_resident_decode
 * Returns VXS_OK; VXS_E_TRUNCATED: too few bytes for a page; VXS_E_CORRUPT: the bytes break a rule, or do not end where the
 * page ends. Reads only bytes[0 .. size_bytes - 1]. The time is bounded by the number of words, for any bytes. No
 * allocation.
 * Threads: any, each with its own scratch. */
vxs_result vxs_page_decode(uint32_t *words, const uint8_t *bytes, size_t size_bytes, const vxs_page_node *nodes,
                           uint32_t node_count, const vxs_common *common, vxs_page_scratch *scratch);

/* Working memory for encoding, one for each thread, for any number of pages, one at a time: some 2 MiB, which grow with the
 * symbols of a page. vxs_page_encoder_new returns NULL without memory; vxs_page_encoder_free accepts NULL. */
typedef struct vxs_page_encoder vxs_page_encoder;
vxs_page_encoder               *vxs_page_encoder_new(void);
void                            vxs_page_encoder_free(vxs_page_encoder *e);

/* Append the bytes of a page.
 * out     grown with realloc
 * words   [word_count] of a page in canonical order, 1..VXS_PAGE_WORDS_MAX
 * nodes   [node_count] all of its nodes
 * common  of its light
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT: the page is not in canonical order, or breaks a rule of the layout, so it
 * would not decode to the same words. This is checked on each page: the walk of the decoder makes the words a second time, and
 * each symbol has odds with which the entropy coder can be undone. The runtime library does not contain this function. */
vxs_result vxs_page_encode(vxs_page_encoder *e, vxs_bytes *out, const uint32_t *words, uint32_t word_count,
                           const vxs_page_node *nodes, uint32_t node_count, const vxs_common *common);

/* Sizes of the resident part of a light. */
typedef struct vxs_resident_sizes {
    uint32_t word_count;    /* all words: head, one word for each page, tops, common pool */
    uint32_t page_count;    /* 0..VXS_PAGES_MAX */
    uint32_t node_count;    /* of all pages */
    uint32_t pattern_count; /* of the common pool */
} vxs_resident_sizes;

/* Arrays for the resident part of a light. They belong to the caller and have the sizes of vxs_resident_sizes. */
typedef struct vxs_resident {
    uint32_t      *words;      /* [word_count] the words of pages (8..) are 0: no page is loaded yet */
    vxs_page_node *nodes;      /* [node_count] page by page */
    uint32_t      *page_first; /* [page_count + 1] nodes of page n are page_first[n]..page_first[n + 1] - 1 */
    uint32_t      *patterns;   /* [pattern_count] common.patterns points here */
    vxs_common     common;
} vxs_resident;

/* Sizes of the resident part that these bytes encode. They are not checked yet: compare them with a limit before allocation.
 * No count is more than 2^31 / 32. In a light of `levels` and `map_count`, only node_count can be much more than 16 times
 * size_bytes.
 * Returns VXS_OK; VXS_E_TRUNCATED; VXS_E_CORRUPT: more than a light can have. */
vxs_result vxs_resident_sizes_of(vxs_resident_sizes *sizes, const uint8_t *bytes, size_t size_bytes);

/* Decode a resident part.
 * out        arrays of the caller, with the sizes from vxs_resident_sizes_of; their content is undefined after an error
 * levels     of the light, 3..18
 * map_count  1..6
 * packing    of the light: VXS_PACKING_SMALL or VXS_PACKING_FINE
 * Returns as vxs_page_decode. No allocation. Threads: any, each with its own scratch. */
vxs_result vxs_resident_decode(vxs_resident *out, uint32_t levels, uint32_t map_count, uint32_t packing, const uint8_t *bytes,
                               size_t size_bytes, vxs_page_scratch *scratch);

/* The nodes of a light's pages, as a decoder finds them in the resident part. Release both arrays with free. */
typedef struct vxs_page_nodes {
    vxs_page_node *nodes;      /* [node_count] page by page */
    uint32_t      *page_first; /* [pages + 1] */
    uint32_t       node_count;
} vxs_page_nodes;

/* Append the bytes of a resident part.
 * out     grown with realloc
 * nodes   [out] zeroed after an error
 * words   [word_count] in this order: head, words of pages (any values), tops of maps 0.., each followed by the entries of
 *         its cells in z order, the common pool
 * common  the pool; common->words is not read
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT: it would not decode to the same words. */
vxs_result vxs_resident_encode(vxs_bytes *out, vxs_page_nodes *nodes, const uint32_t *words, uint32_t word_count, uint32_t levels,
                               uint32_t map_count, const vxs_common *common);

/* Index the patterns of a common pool.
 * patterns  [pattern_count] out; common->patterns will point to it
 * kinds     [pattern_count] of the patterns, in storage order
 * words     [(half_count + 1) / 2] of the pool
 * Returns VXS_OK; VXS_E_ARGUMENT: the words are not exactly these patterns, without gaps. */
vxs_result vxs_common_index(vxs_common *common, uint32_t *patterns, const uint8_t *kinds, uint32_t pattern_count,
                            const uint32_t *words, uint32_t half_count);

#ifdef __cplusplus
}
#endif

#endif
