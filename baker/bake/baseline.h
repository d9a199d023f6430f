/* What the shadow map itself would take: the 16-bit enter depths under zstd -19, of all rows or of a sample.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BASELINE_H
#define BASELINE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/columns/stored/depth_maps.h"

typedef struct baseline {
    uint32_t  tile_px;       /* side of the tiles that are added */
    uint32_t  tiles_a_map;   /* of a map, a power of four */
    size_t    texels_a_tile; /* that are kept of each, about; 0: all */
    uint64_t  tiles_seen;    /* over all maps, those without casters too */
    uint16_t *texels;        /* [count] kept rows */
    size_t    count, capacity;
} baseline;

/* texels_a_map  to keep of each map, about; 0: all */
void baseline_init(baseline *b, uint32_t map_px, uint32_t tile_px, size_t texels_a_map);

/* Add the enter depths of tile (i, j) of map `map`. Tiles come in z order, maps one after the other; those that do not come are empty.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result baseline_add(baseline *b, const depth_maps *tile, uint32_t map, uint32_t i, uint32_t j);

/* All maps are done.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result baseline_end(baseline *b, uint32_t map_count);

/* Compressed size over raw size of what was kept; 0 when nothing was kept or memory ran out. *share: of all texels. */
double baseline_ratio(const baseline *b, double *share);

/* Accepts a zeroed object. */
void baseline_free(baseline *b);

#endif
