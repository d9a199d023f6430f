/* Voxelizes triangles into a shadow grid (voxelize.glsl). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VOXELIZE_H
#define VOXELIZE_H

#include "volumes_state.h"
#include "vxs_shadow_grid.h"

/* Whether all casters satisfy vxs_volumes.h, for a grid of the given size. */
int vxs_are_casters(const vxs_casters *casters, uint32_t count, const vxs_grid_size *size);

/* Voxelize all casters of a kind. Call it for solid ones first, because they overwrite bits that others have set.
 * grid     a buffer with its head
 * columns  VXS_VOXELS_RAYS alone: shadow must begin in one of so many columns
 * as       the kind that is used, instead of that of the casters
 * Leaves storage bindings with the grid first. */
void vxs_voxelize(vxs_volumes *volumes, gl_name grid, const vxs_epipolar *space, const vxs_casters *casters, uint32_t count,
                  vxs_voxels kind, vxs_voxels as, uint32_t columns);

#endif
