/* Tiles of a map where light passes what casts shadows: around edges of which one side alone faces the light, or which have one
 * side.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXACT_SILHOUETTES_H
#define EXACT_SILHOUETTES_H

#include "baker/light/projection.h"

/* Tile (i, j) of 8 x 8 texels. */
typedef struct map_tile {
    uint32_t j, i;
} map_tile;

/* Of random silhouettes, all tiles that one passes, and the eight about each; a tile once.
 * tiles  [out] [*tile_count] released with free
 * count  of silhouettes, or all where there are fewer
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result silhouette_tiles(map_tile **tiles, size_t *tile_count, const projection *p, uint32_t side_px, uint32_t count,
                            uint64_t seed);

#endif
