/* First shadowed voxel of a texel; see vxs_query.h. Palette blocks contain it; in a DAG the column is walked.
 * SPDX-License-Identifier: MIT */
#include "block_depths.h"
#include "dag_depths.h"
#include "vxs_query.h"

int32_t vxs_first_shadow(const vxs_baked_light *baked, int map, int32_t i, int32_t j, int *coarse)
{
    int32_t depth[64], side = 1 << baked->light.levels, n = (i & 7) + 8 * (j & 7);
    if (coarse) *coarse = 0;
    if (map < 0 || map >= (int)vxs_map_count(&baked->light) || i < 0 || j < 0 || i >= side || j >= side) return -1;
    if (baked->light.coding == VXS_CODING_BLOCKS) {
        vxs_depth_square s = vxs_depth_square_at((vxs_blocks_map){baked->words, (uint32_t)map, baked->light.levels}, i, j, -1, 1);
        if (coarse) *coarse = s.coarse && s.low < s.high;
        return s.least;
    }
    vxs_dag_first_shadows(baked, (uint32_t)map, (uint32_t)i >> 3, (uint32_t)j >> 3, (uint64_t)1 << n, depth);
    return depth[n];
}
