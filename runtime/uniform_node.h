/* Uniform nodes, one after the other along a way. Internal to the runtime; not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_UNIFORM_NODE_H
#define VXS_UNIFORM_NODE_H

#include "block_depths.h"
#include "vxs_query.h"

/* vxs_uniform_node, which keeps what it came to.
 * kept  as for vxs_depth_square_at */
int vxs_find_uniform_node(const vxs_baked_light *baked, int map, const int32_t voxel[3], int least_px, vxs_node *node,
                          vxs_depth_cursor *kept);

#endif
