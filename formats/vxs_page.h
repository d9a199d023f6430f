/* Pages and the resident part of a light of palette blocks: their words in memory, and their bytes on disk.
 *
 * A page is coded alone: nothing of another page is needed, so pages are decoded in any order and at once. What a page may know is
 * the resident part: the common pool of patterns, and which entries of the top use its nodes (vxs_page_node).
 *
 * Bytes of a page:
 *
 *     u16 words - 1      of the page, 1..65536
 *     u16 node words     of nodes and blocks - 1; the rest is the pool of patterns
 *     u16 ...            words of the coder (vxs_page_coder.h)
 *     u32 u32            its two states
 *
 * Bytes of a resident part: u32 words, u32 pages, u32 nodes, u32 patterns, then as above.
 *
 * Decoding is the check: what was decoded holds every rule of the layout, so that a lookup never leaves the page's words or the
 * common pool. Bytes that are damaged may decode to other words, never to words that break a rule.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_H
#define VXS_PAGE_H

#include <stddef.h>
#include <stdint.h>

#include "vxs_file.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    VXS_PAGES_MAX         = 32767,
    VXS_PAGE_WORDS_MAX    = 65536,
    VXS_COMMON_HALVES_MAX = 1 << 17,
    VXS_PATTERN_KINDS     = 15, /* of patterns: 0: depths of its own; 2..14: so many depths of a block's palette; 1 is none */
};

/* A node of a page, and the entry of the top that uses it first: what lies beside it is where the coder looks for what is alike. */
typedef struct vxs_page_node {
    uint32_t offset; /* word of the page where it starts; nodes are in ascending order */
    uint32_t x, y;   /* the entry's square of 256 x 256 texels, in its map */
    uint32_t map;    /* 0..5 */
    int32_t  base;   /* depth that the entry takes off, k - base is asked */
} vxs_page_node;

/* The common pool of a light. */
typedef struct vxs_common {
    const uint32_t *words; /* [(half_count + 1) / 2] */
    uint32_t        half_count;
    const uint32_t *patterns;                     /* halves of the pool where they start, by kind, then as they lie */
    uint32_t        first[VXS_PATTERN_KINDS + 1]; /* patterns of kind p are first[p]..first[p + 1] - 1 */
} vxs_common;

/* What decoding needs beside its results: memory of the size below, aligned to 16 bytes, one for each thread, no part of any result. It serves
 * any number of pages, one at a time, and needs neither a beginning nor an end. */
typedef struct vxs_page_scratch vxs_page_scratch;

/* Size of the above, some 360 KiB. */
size_t vxs_page_scratch_bytes(void);

/* How many words the page of these bytes takes, 1..VXS_PAGE_WORDS_MAX; 0: too few bytes to say so. */
uint32_t vxs_page_word_count(const uint8_t *bytes, size_t size_bytes);

/* Decode a page.
 * words   [vxs_page_word_count(bytes, size_bytes)] out; what it holds after an error means nothing
 * nodes   [node_count] as the top says; a page whose nodes start elsewhere is refused
 * common  checked: what vxs_resident_decode made
 * Returns VXS_OK; VXS_E_TRUNCATED: too few bytes to be a page; VXS_E_CORRUPT: they break a rule, or do not end where the page does.
 * Reads bytes[0 .. size_bytes - 1] only. Time is bounded by the number of words, whatever the bytes. No allocation.
 * Threads: any, each with a scratch of its own. */
vxs_result vxs_page_decode(uint32_t *words, const uint8_t *bytes, size_t size_bytes, const vxs_page_node *nodes,
                           uint32_t node_count, const vxs_common *common, vxs_page_scratch *scratch);

/* Append the bytes of a page.
 * out     grown with realloc
 * words   [word_count] of a page in canonical order, 1..VXS_PAGE_WORDS_MAX
 * nodes   [node_count] all of its nodes
 * common  of its light
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT: the page is not in canonical order, or breaks a rule of the layout: it would not be
 * decoded to the same words. The runtime library does not hold this function. */
vxs_result vxs_page_encode(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                           uint32_t node_count, const vxs_common *common);

/* How much the resident part of a light takes. */
typedef struct vxs_resident_sizes {
    uint32_t word_count;    /* of its words: the head, a word for each page, the tops, the common pool */
    uint32_t page_count;    /* 0..VXS_PAGES_MAX */
    uint32_t node_count;    /* of all pages */
    uint32_t pattern_count; /* of the common pool */
} vxs_resident_sizes;

/* Where the resident part of a light goes: arrays of the caller, of the sizes that it was told. */
typedef struct vxs_resident {
    uint32_t      *words;      /* [word_count] words 8.. of pages are 0: no page is there yet */
    vxs_page_node *nodes;      /* [node_count] page by page */
    uint32_t      *page_first; /* [page_count + 1] nodes of page n are page_first[n]..page_first[n + 1] - 1 */
    uint32_t      *patterns;   /* [pattern_count] what common points to */
    vxs_common     common;
} vxs_resident;

/* What the resident part of these bytes takes. It is what they say, not yet checked: hold it against a limit before it is allocated; no
 * count is more than 2^31 / 32, and none but node_count can be much more than 16 times size_bytes in a light of `levels` and
 * `map_count`. Returns VXS_OK; VXS_E_TRUNCATED; VXS_E_CORRUPT: more than a light can have. */
vxs_result vxs_resident_sizes_of(vxs_resident_sizes *sizes, const uint8_t *bytes, size_t size_bytes);

/* Decode a resident part.
 * out        its arrays are the caller's, of the sizes that vxs_resident_sizes_of says; what they hold after an error means nothing
 * levels     of the light, 3..18
 * map_count  1..6
 * Returns as vxs_page_decode. No allocation. Threads: any, each with a scratch of its own. */
vxs_result vxs_resident_decode(vxs_resident *out, uint32_t levels, uint32_t map_count, const uint8_t *bytes, size_t size_bytes,
                               vxs_page_scratch *scratch);

/* Append the bytes of a resident part.
 * out     grown with realloc
 * words   [word_count] in this order: head, words of pages (whatever they are), tops of maps 0.., each with the entries of its cells in
 *         z order behind it, the common pool
 * common  its pool; words are not looked at
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT: it would not be decoded to the same words. */
vxs_result vxs_resident_encode(vxs_bytes *out, const uint32_t *words, uint32_t word_count, uint32_t levels, uint32_t map_count,
                               const vxs_common *common);

/* Say what is in a common pool.
 * patterns  [pattern_count] out, what common->patterns points to
 * kinds     [pattern_count] of the patterns as they lie
 * words     [(half_count + 1) / 2] of the pool
 * Returns VXS_OK; VXS_E_ARGUMENT: they are not these patterns, one behind the other. */
vxs_result vxs_common_index(vxs_common *common, uint32_t *patterns, const uint8_t *kinds, uint32_t pattern_count,
                            const uint32_t *words, uint32_t half_count);

#ifdef __cplusplus
}
#endif

#endif
