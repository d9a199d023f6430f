/* Depth maps as an open map of columns, which is one square.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef STORED_MAPS_H
#define STORED_MAPS_H

#include "baker/lab/opengl/depth_maps.h"

static inline vxs_result stored_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    column_square all = depth_maps_square(data);
    return all.bounds(data, level, i, j, out);
}

static inline vxs_result stored_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    (void)ctx;
    (void)i;
    (void)j;
    *out = depth_maps_square(data);
    return 8u << level == out->side_px ? VXS_OK : VXS_E_ARGUMENT;
}

static inline void stored_release(void *data, column_square *square)
{
    (void)data;
    (void)square;
}

static inline void stored_close(void *data)
{
    (void)data;
}

/* Borrows d; valid until depth_maps_free. */
static inline column_map stored_map(const depth_maps *d)
{
    return (column_map){.data     = (void *)(uintptr_t)d,
                        .side_px  = d->side_px,
                        .depth_vx = d->depth_vx,
                        .fetch_px = d->side_px,
                        .bounds   = stored_bounds,
                        .fetch    = stored_fetch,
                        .release  = stored_release,
                        .close    = stored_close};
}

/* A depth of the maps in voxels, [0, depth_vx], not rounded. */
static inline double stored_voxels(const depth_maps *d, float depth)
{
    return depth_in_voxels((depth_scale){d->depth_vx, d->voxel_log}, (double)depth);
}

#endif
