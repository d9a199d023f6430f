/* Triangles into a shadow grid (voxelize.glsl). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VOXELIZE_H
#define VOXELIZE_H

#include "volumes_state.h"
#include "vxs_shadow_grid.h"

typedef struct voxelizer {
    vxs_volumes *volumes;
    gl_name      programs[VXS_VOXELS_KINDS];
} voxelizer;

/* Returns VXS_OK; VXS_E_GL, when a shader does not compile. Then there is nothing to destroy. */
vxs_result vxs_voxelizer_create(voxelizer *voxelizer, vxs_volumes *volumes);
void       vxs_voxelizer_destroy(voxelizer *voxelizer); /* accepts one of zeros */

/* Whether all of them are what vxs_volumes.h asks for, for a grid of such a size. */
int vxs_are_casters(const vxs_casters *casters, uint32_t count, const vxs_grid_size *size);

/* What all casters of a kind set; solid ones first, as they do not spare what others have set.
 * grid    a buffer with its head;   columns  what begins behind so many is left out, by VXS_VOXELS_RAYS alone
 * as      how they are voxelized, whatever they say of it
 * Leaves storage bindings with the grid first. */
void vxs_voxelize(const voxelizer *voxelizer, gl_name grid, const vxs_epipolar *space, const vxs_casters *casters, uint32_t count,
                  vxs_voxels kind, vxs_voxels as, uint32_t columns);

#endif
