/* A light's maps as palette blocks: baker/coding/blocks/ behind the seam of light_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCKS_CODER_H
#define BLOCKS_CODER_H

#include "baker/bake/light_coder.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/coding/dag/build.h"

/* What the words of a light hold: equal ones are one in their page. */
typedef struct palette_counts {
    uint64_t pages, nodes, blocks;
    uint64_t tiles, own_tiles; /* with patterns; of them, those with depths of their own */
    uint64_t patterns;         /* of both kinds, in pages and common ones */
} palette_counts;

typedef struct blocks_coder {
    const vxs_light *light; /* NULL: not begun */
    block_set        set;
    build_stats      stats;  /* tiles and squares */
    palette_counts   counts; /* once it is finished */
    uint32_t         threads;
    uint32_t         packing; /* VXS_PACKING_* */
} blocks_coder;

/* Valid where c lies, which is zeroed but for threads and packing, until blocks_coder_free. */
light_coder blocks_coder_seam(blocks_coder *c);

/* Accepts a zeroed object. */
void blocks_coder_free(blocks_coder *c);

#endif
