/* Visibility masks of 8 x 8 tiles, each with the depth to which it can be reused.
 * Source: [CPVS16] 3.4.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MASKS_H
#define MASKS_H

#include "baker/base/message.h"
#include "baker/columns/columns.h"

typedef enum mask_rule {
    MASK_RULE_GREEDY, /* [CPVS16] 3.4: a mask is reused until the nearest exit depth of the texels that it leaves lit */
    MASK_RULE_SHADOW  /* [Sintorn 2014]: in a slice with lit and shadowed voxels, undefined becomes shadow */
} mask_rule;

/* The masks of a square of tiles. A tile is lit in front of its xmin; then each of its runs holds up to its `until`; behind its
 * emax it is shadowed. A tile with emax <= xmin has no run: one depth parts lit from shadowed. */
typedef struct tile_masks {
    uint32_t  side_tiles;
    uint32_t *xmin, *emax; /* [side_tiles * side_tiles] exact for tiles with runs, the source's bounds for others */
    uint32_t *first;       /* [side_tiles * side_tiles + 1] runs of tile t are [first[t], first[t + 1]), near to far */
    uint64_t *mask;        /* [run_count] bit x + 8y: texel (x, y) is in shadow */
    uint32_t *until;       /* [run_count] voxels: the run holds for depths k < until */
    uint32_t  run_count;
    uint32_t  run_capacity;
} tile_masks;

/* Masks of the tiles [i, i + side) x [j, j + side) of a source.
 * out  [out] zeroed on failure; released with tile_masks_free.   Returns VXS_OK or VXS_E_MEMORY.
 * Threads: none shared; different squares of one source may be worked on at once. */
vxs_result tile_masks_build(tile_masks *out, const column_source *source, uint32_t i, uint32_t j, uint32_t side_tiles,
                            mask_rule rule);

void tile_masks_free(tile_masks *t);

#endif
