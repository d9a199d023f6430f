/* Depths in a DAG: where shadow first begins in each texel of a tile. A DAG's columns may be lit again behind their first shadow, where
 * voxels are free (formats/vxs.md 2). Internal to the runtime; not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DAG_DEPTHS_H
#define VXS_DAG_DEPTHS_H

#include "vxs_file.h"
#include "vxs_query.h"

/* The first shadowed voxel of texels of tile (tile_x, tile_y), texel (x, y) at [x + 8 y]; 2^levels where there is none.
 * wanted  a bit for each texel that is asked for; the others are not written */
void vxs_dag_first_shadows(const vxs_baked_light *baked, uint32_t map, uint32_t tile_x, uint32_t tile_y, uint64_t wanted,
                           int32_t depth[64]);

#endif
