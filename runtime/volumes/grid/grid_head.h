/* The head of a shadow grid for shaders, and the view of the grid. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef GRID_HEAD_H
#define GRID_HEAD_H

#include "volumes_state.h"
#include "vxs_shadow_grid.h"

/* As in grid.glsl (std430). */
typedef struct grid_head {
    float    axis[3], away;
    float    ahead[4], side[4];
    float    alpha[2], theta[2];
    float    phi[4];
    int32_t  columns, rows, bits, runs;
    int32_t  eye_lit, between_rows, reserved[2];
    uint32_t cut[4]; /* the first: number of invocations of the voxelizer that a driver ended early */
} grid_head;
enum { HEAD_TEXELS = sizeof(grid_head) / 16 };

/* runs  of the lookup */
grid_head vxs_grid_head_of(const vxs_epipolar *space, const vxs_grid_size *size, uint32_t runs);

/* The corners of the drawn pixels. */
vxs_epipolar_view vxs_grid_view_of(const frame_block *frame);

/* Make the grid of the current light and pixels, as vxs_volumes_grid uses it. Leaves storage bindings as vxs_or_scan_run does.
 * map  a texture; 0: looks the asset up */
void vxs_shadow_grid_make(vxs_shadow_grid *grid, gl_name map, uint32_t runs);

#endif
