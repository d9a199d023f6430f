/* Small pictures of a light's maps: depths, and number of masks. They are filled tile by tile while the light is baked.
 *
 * A picture has the side of its map, but at most PICTURE_MAX_PX, or CUBE_PICTURE_MAX_PX for each of six: a pixel is a square of
 * texels.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_PICTURE_H
#define LIGHT_PICTURE_H

#include "baker/coding/dag/column_tree.h"
#include "baker/columns/rendered_columns.h"
#include "formats/vxs_file.h"

enum { PICTURES_MAX = 4, PICTURE_MAX_PX = 1024, CUBE_PICTURE_MAX_PX = 512, PICTURE_NO_CASTER = 65535 };

typedef struct light_picture {
    uint32_t  light;      /* index among the baked lights */
    uint32_t  map_count;  /* 1 or 6 */
    uint32_t  map_px;     /* side of a map */
    uint32_t  side_px;    /* side of a picture of depths */
    uint32_t  mask_px;    /* side of a picture of masks: side_px, or less so that a pixel is at least a tile of 8 x 8 */
    uint32_t  mask_tiles; /* side of a pixel of masks in tiles of 8 x 8 */
    uint16_t *depth;      /* [map_count * side_px^2] rows; mean depth, 0 to 65534 over the map's depth, or PICTURE_NO_CASTER */
    uint8_t  *masks;      /* [map_count * mask_px^2] rows; most masks (runs) of any tile in the pixel */
} light_picture;

/* Memory of a picture of maps of map_px. */
uint64_t light_picture_bytes(uint32_t map_px, uint32_t map_count);

/* A picture without casters. p  [out] zeroed on failure; released with light_picture_free.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result light_picture_init(light_picture *p, uint32_t light, uint32_t map_px, uint32_t map_count, run_context *m);

/* Add a rendered tile of a map: tile (i, j), counted in tiles of its side. */
void light_picture_add_depths(light_picture *p, const rendered_tile *tile, uint32_t map, uint32_t i, uint32_t j, uint32_t threads);

/* Side of the coarser map that is enough for the picture. */
uint32_t light_picture_enter_px(const light_picture *p);

/* Add enter depths of a map, or of a coarser one.
 * enter  [side_px^2] rows, [0, depth_vx]; depth_vx: no caster */
void light_picture_add_enter(light_picture *p, const uint32_t *enter, uint32_t side_px, uint32_t depth_vx, uint32_t map);

/* Add the masks of a square of a map.
 * Threads: at once for squares that are aligned to their side, which is a power of two and at least a pixel's. */
void light_picture_add_masks(light_picture *p, const column_tree *tree, uint32_t map);

/* Accepts a zeroed object. */
void light_picture_free(light_picture *p);

#endif
