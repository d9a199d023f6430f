/* Conversion from the depths of a map to voxels. Depths grow away from the light. Directional light: shares of the whole depth, [0,
 * 1]; 1 is no caster. Perspective map: -near / z, [-1, 0]; 0 is no caster, and distance z is log(z / near) / voxel_log voxels
 * deep ([CPVS16] 5).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DEPTH_SCALE_H
#define DEPTH_SCALE_H

#include <math.h>
#include <stdint.h>

typedef struct depth_scale {
    uint32_t depth_vx;  /* a power of two, so that scaling is exact */
    double   voxel_log; /* 0: depths are shares */
} depth_scale;

/* Depth that means no caster. The least depth is 1 less than that. */
static inline double depth_none(depth_scale s)
{
    return s.voxel_log == 0 ? 1 : 0;
}

/* Clamp a depth to the range between the near plane and the far plane. */
static inline double depth_clamped(depth_scale s, double depth)
{
    return fmax(depth_none(s) - 1, fmin(depth, depth_none(s)));
}

/* A depth in voxels, [0, depth_vx], not rounded: the depth in the contract of an asset (docs/overview.md). */
static inline double depth_in_voxels(depth_scale s, double depth)
{
    if (s.voxel_log == 0) return depth * s.depth_vx;
    double voxels = depth < 0 ? -log(-depth) / s.voxel_log : INFINITY;
    return fmax(0, fmin(voxels, s.depth_vx));
}

static inline uint32_t depth_down(depth_scale s, double depth)
{
    return (uint32_t)depth_in_voxels(s, depth);
}

static inline uint32_t depth_up(depth_scale s, double depth)
{
    double   voxels = depth_in_voxels(s, depth);
    uint32_t down   = (uint32_t)voxels;
    return down + (down < voxels);
}

#endif
