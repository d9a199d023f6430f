/* What virtual point lights and their shadow volumes are, to shaders and C: one text for C99, C++, GLSL and HLSL, that stands on vxs_shadow_grid.h.
 *
 *     vxs_area_hash     an integer that looks random
 *
 * Source: [IVSV13].
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AREA_GRID_H
#define VXS_AREA_GRID_H

#ifndef VXS_SHADOW_GRID_H /* a shader that cannot include has it already */
#include "vxs_shadow_grid.h"
#endif

/* Every bit of it depends on every bit of n; no two n have one. */
VXS_FN vxs_u32 vxs_area_hash(vxs_u32 n)
{
    n = (n ^ (n >> 16)) * 0x7feb352du;
    n = (n ^ (n >> 15)) * 0x846ca68bu;
    return n ^ (n >> 16);
}

#endif
