/* A light's maps as palette blocks: baker/coding/blocks/ behind the seam of light_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCKS_CODER_H
#define BLOCKS_CODER_H

#include "baker/bake/light_coder.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/coding/dag/build.h"

/* Contents of a light's words; equal things in a page are counted once. */
typedef struct palette_counts {
    uint64_t pages, nodes, blocks;
    uint64_t tiles, own_tiles; /* with patterns; those of them with a private palette */
    uint64_t patterns;         /* of both kinds, in pages and common ones */
} palette_counts;

typedef struct blocks_coder {
    const vxs_light *light; /* NULL: not begun */
    block_set        set;
    build_stats      stats;  /* tiles and squares */
    palette_counts   counts; /* set by finish */
    uint32_t         threads;
    uint32_t         packing; /* VXS_PACKING_* */
} blocks_coder;

/* Valid until blocks_coder_free, while c stays at its address. Zero c before, except for threads and packing. */
light_coder blocks_coder_seam(blocks_coder *c);

/* Accepts a coder that was not begun. */
void blocks_coder_free(blocks_coder *c);

#endif
