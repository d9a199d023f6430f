/* Depths in a DAG: first shadowed voxel of each texel of a tile. Columns of a DAG may be lit again behind it, where voxels are
 * don't-care (formats/vxs.md 2). Internal to the runtime; not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DAG_DEPTHS_H
#define VXS_DAG_DEPTHS_H

#include "vxs_file.h"
#include "vxs_query.h"

/* Find the first shadowed voxel of texels of tile (tile_x, tile_y).
 * wanted  one bit for each wanted texel; depths of the others are not written
 * depth   [out] texel (x, y) at [x + 8 y]; 2^levels: no shadow */
void vxs_dag_first_shadows(const vxs_baked_light *baked, uint32_t map, uint32_t tile_x, uint32_t tile_y, uint64_t wanted,
                           int32_t depth[64]);

#endif
