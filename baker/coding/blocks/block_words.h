/* Palette blocks as the words that lookups read: the top, common patterns, and pages (formats/vxs.md).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_WORDS_H
#define BLOCK_WORDS_H

#include "baker/coding/blocks/blocks.h"

/* Contents of a light's words. */
typedef struct block_counts {
    uint32_t pages, nodes, blocks, tiles, own_tiles, patterns, own_patterns;  /* equal ones in a page are counted once */
    uint32_t top_words, common_words, node_words, block_words, pattern_words; /* their sizes; patterns in pages only */
} block_counts;

typedef struct block_words {
    uint32_t    *words; /* [count + VXS_BLOCKS_SPARE_WORDS] the spare words are 0 */
    uint32_t     count;
    uint8_t     *common_kinds; /* [common_count] patterns in the order of the common pool: number of depths; 0: private palette */
    uint32_t     common_count, common_halves;
    block_counts counts;
} block_words;

/* Lay out the maps of a light: map_count maps of 2^levels texels a side. The set must have all squares of them.
 * out      [out] zeroed on failure; released with block_words_free
 * threads  that share the work; words do not depend on it
 * Returns VXS_OK, VXS_E_MEMORY; VXS_E_REFERENCES for more than 32767 pages or 2^32 - 1 words. */
vxs_result block_words_lay_out(block_words *out, const block_set *s, uint32_t levels, uint32_t map_count, uint32_t threads);

/* Accepts a zeroed object. */
void block_words_free(block_words *w);

#endif
