/* Uniform nodes; see vxs_query.h.
 * SPDX-License-Identifier: MIT */
#include "block_depths.h"
#include "dag_depths.h"
#include "vxs_query.h"

static void set_depths(vxs_node *node, int32_t state, int32_t first, int32_t end)
{
    node->state    = state;
    node->first[2] = first;
    node->end[2]   = end;
}

/* Of the greatest square that is decided at depth k: what is before its depths, behind them, or between. */
static void find_in_blocks(const vxs_baked_light *baked, uint32_t map, const int32_t voxel[3], int32_t least_px, vxs_node *node)
{
    const vxs_blocks_map m = {baked->words, map, baked->light.levels};
    vxs_depth_square     s = vxs_depth_square_at(m, voxel[0], voxel[1], voxel[2], least_px);
    int32_t              k = voxel[2], side = 1 << baked->light.levels, near = s.coarse ? s.low : 0, far = s.coarse ? s.high : side;
    node->first[0] = s.i;
    node->first[1] = s.j;
    node->end[0]   = s.i + s.side_px;
    node->end[1]   = s.j + s.side_px;
    node->coarse   = k >= near && k < far && s.coarse;
    if (k < near)
        set_depths(node, VXS_NODE_LIT, 0, near);
    else if (k >= far)
        set_depths(node, VXS_NODE_SHADOW, far, side);
    else if (k < s.least)
        set_depths(node, VXS_NODE_LIT, near, s.least);
    else if (k >= s.greatest)
        set_depths(node, VXS_NODE_SHADOW, s.greatest, far);
    else
        set_depths(node, VXS_NODE_MIXED, s.least, s.greatest);
}

int vxs_uniform_node(const vxs_baked_light *baked, int map, const int32_t voxel[3], int least_px, vxs_node *node)
{
    int32_t side = 1 << baked->light.levels, bounded = (baked->light.flags & VXS_LIGHT_BOUNDED) != 0, k = voxel[2];
    if (map < 0 || map >= (int)vxs_light_map_count(&baked->light)) return 0;
    if (voxel[0] < 0 || voxel[1] < 0 || voxel[0] >= side || voxel[1] >= side) return 0;
    if (bounded && (k < 0 || k >= side)) return 0;
    *node = (vxs_node){.end = {side, side, 0}};
    if (k < 0) {
        set_depths(node, VXS_NODE_LIT, -VXS_NODE_FAR, 0);
        return 1;
    }

    const int32_t at[3] = {voxel[0], voxel[1], k < side ? k : side - 1}; /* behind the map all is as its last voxels are */
    if (baked->light.coding == VXS_CODING_BLOCKS)
        find_in_blocks(baked, (uint32_t)map, at, least_px, node);
    else
        vxs_dag_uniform_node(baked, (uint32_t)map, at, least_px, node);
    if (bounded) return 1;
    if (node->end[2] == side) node->end[2] = VXS_NODE_FAR;
    if (node->first[2] == 0 && node->state == VXS_NODE_LIT) node->first[2] = -VXS_NODE_FAR;
    return 1;
}
