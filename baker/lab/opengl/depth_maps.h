/* A pair of depth maps and its min-max pyramid: the columns of rendered or stored maps.
 * Source: [CPVS16] 3 (min-max hierarchy), 6.1 (down to one entry per 8 x 8 tile).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DEPTH_MAPS_H
#define DEPTH_MAPS_H

#include "baker/columns/columns.h"

enum { PYRAMID_LEVELS_MAX = 16 };

typedef struct depth_maps {
    uint32_t side_px;  /* texels a side; a power of two, at least 8 */
    uint32_t depth_vx; /* voxels in depth; a power of two, so that scaling is exact */
    double voxel_log;  /* 0: depths are shares of depth_vx, [0, 1], and 1 is no caster. Else perspective maps: depths are -near / z,
                         [-1, 0], 0 is no caster, and distance z is log(z / near) / voxel_log voxels deep ([CPVS16] 5) */
    float *enter;      /* [side_px * side_px] rows of texels: depths that grow away from the light */
    float *exit;       /* same size; never less than enter. May be the same array as enter: then everything is a sheet */

    uint32_t       pyramid_levels;
    column_bounds *pyramid[PYRAMID_LEVELS_MAX]; /* [l]: squares of 8 << l texels, rows of squares; pyramid[0] owns all */
} depth_maps;

/* Allocate maps without contents.   with_exit  0: exit is the same array as enter.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result depth_maps_init(depth_maps *d, uint32_t side_px, uint32_t depth_vx, double voxel_log, int with_exit, run_context *m);

/* Compute the pyramid from the maps; call again whenever they change. */
void depth_maps_reduce(depth_maps *d, uint32_t threads);

/* The maps as a square of columns, which borrows d and is valid until depth_maps_free. */
column_square depth_maps_square(const depth_maps *d);

void depth_maps_free(depth_maps *d);

#endif
