/* Builds palette blocks from columns: of one node, and of a whole map.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_BUILD_H
#define BLOCK_BUILD_H

#include "baker/coding/blocks/blocks.h"

/* Add the node (x, y), counted in squares of NODE_PX from the corner of fetched columns. A smaller map is added as a whole.
 * map  index of the light's map. Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the columns return. */
vxs_result block_build_node(block_set *s, const column_square *columns, uint32_t map, uint32_t x, uint32_t y);

/* Side of the squares that are built at once, each with its own patterns, before they are merged in z order. The source must be
 * able to fetch squares of this side. */
uint32_t block_square_side(uint32_t map_side_px);

/* Add map `map` of a light, from its open columns. Bytes do not depend on the number of threads or the size of fetched squares.
 * ctx  threads; STAGE_MASKS is timed here, and a step of progress is done for each square of fetch_px
 * Returns the same, or VXS_E_ARGUMENT if fetch_px is less than block_square_side. */
vxs_result block_build_map(block_set *s, uint32_t map, const column_map *columns, bake_context *ctx);

#endif
