/* What a map will be made of, found out from a part of it without OpenGL: for the plan.
 *
 * The map is divided into squares, and one window of each, at a place that its number decides, is made as the bake makes it: columns,
 * and in its coding masks and inserted nodes, or palette blocks. Which blocks hold triangles is counted for the whole map, and exact.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MAP_SAMPLE_H
#define MAP_SAMPLE_H

#include "baker/bake/bake_options.h"
#include "baker/columns/rendered_columns.h"
#include "baker/light/projection.h"

enum { SAMPLE_LEVELS = 3, SAMPLE_WINDOW_PX = 32, TILE_SIZES = 4 };

/* What windows are as palette blocks: those with patterns. */
typedef struct palette_sample {
    uint64_t blocks, unique_blocks;  /* all, and different ones */
    uint64_t patterns, own_patterns; /* different ones; of them, those with depths of their own */
    uint64_t block_words, pattern_words;
} palette_sample;

typedef struct map_sample {
    /* of the whole map; blocks are those of depth_block.h */
    uint64_t blocks, blocks_empty;                       /* blocks_empty: no triangle may touch them */
    uint64_t blocks_peeled;                              /* hold solids that meet another */
    uint64_t blocks_not_peeled;                          /* hold solids, and none that meets another */
    uint64_t block_triangles;                            /* over all blocks, the triangles that may touch each */
    uint64_t block_most;                                 /* of the block with the most */
    uint64_t peeled_triangles;                           /* the same over blocks_peeled, solids alone */
    uint64_t tiles[TILE_SIZES], tiles_empty[TILE_SIZES]; /* of TILE_MAX_PX >> n texels a side, or the whole map */

    /* of the windows */
    uint64_t texels;
    double   weight;                      /* texels of the map for each texel looked at */
    uint64_t peeled_windows, layers;      /* windows with solids; over them, the layers that are peeled where there are most */
    uint64_t mask_tiles;                  /* tiles that no single depth parts into lit and shadowed */
    uint64_t mask_runs;                   /* of a DAG: their masks */
    uint64_t masks, nodes[SAMPLE_LEVELS]; /* inserted, by level */
    uint64_t unique_masks, unique_nodes;  /* different ones among them */

    palette_sample palette; /* of palette blocks */
} map_sample;

/* Look at map `map` of a light; p is its projection. peels_all: solids count as meeting whatever is known of them.
 * maps  how many are looked at, of all lights: of many, each gets less
 * s  [out] zeroed on failure.   Returns VXS_OK or VXS_E_MEMORY.  Same input, same result. */
vxs_result map_sample_take(map_sample *s, const projection *p, const vxs_light *light, int peels_all, uint32_t maps,
                           const bake_options *o, message *m);

#endif
