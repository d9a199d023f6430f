/* Virtual point lights and their shadow volumes, for shaders and C: one text for C99, C++, GLSL and HLSL. Built on
 * vxs_shadow_grid.h.
 *
 *     vxs_area_hash     an integer hash
 *     vxs_area_texel    direction to position in the imperfect shadow map of a virtual point light
 *     vxs_area_path     an eye ray in the light of a virtual point light
 *
 * An imperfect shadow map covers the half of all directions to which a light emits, by a paraboloid projection: a disc in a
 * square. A texel is the distance from the light where shadow begins.
 * Source: [IVSV13] 3; [Ritschel 2008] for imperfect shadow maps.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AREA_GRID_H
#define VXS_AREA_GRID_H

#ifndef VXS_SHADOW_GRID_H /* a shader that cannot include has it already */
#include "vxs_shadow_grid.h"
#endif

/* A bijective hash: each bit of the result depends on each bit of n. */
VXS_FN vxs_u32 vxs_area_hash(vxs_u32 n)
{
    n = (n ^ (n >> 16)) * 0x7feb352du;
    n = (n ^ (n >> 15)) * 0x846ca68bu;
    return n ^ (n >> 16);
}

/* way  from the light, in its frame: across, up, along its normal; along > 0; of any length
 * at   [out] texels
 * Returns the width of a texel there, divided by the distance from the light. */
VXS_FN vxs_real vxs_area_texel(const vxs_real3 way, vxs_i32 side, VXS_OUT vxs_real2 at)
{
    vxs_real metres = sqrt(vxs_air_dot(way, way)), depth = metres + way[2], half_side = 0.5 * VXS_REAL(side);
    vxs_real x = way[0] / depth, y = way[1] / depth;
    at[0] = half_side * (1.0 + x);
    at[1] = half_side * (1.0 + y);
    return 2.0 / (half_side * (1.0 + x * x + y * y));
}

/* An eye ray in the light of a virtual point light.
 * light    its place and radius, and, if it is a face, its normal as axis
 * is_face  1: it emits to one side
 * Other parameters as for vxs_air_path_of. */
VXS_FN vxs_air_path vxs_area_path(VXS_AIR_LIGHT light, vxs_i32 is_face, const vxs_real3 eye, const vxs_real3 direction,
                                  vxs_real metres, vxs_real top)
{
    vxs_real3    to_vpl;
    vxs_real2    part;
    vxs_air_path path = vxs_air_path_of(light, eye, direction, metres, top, part);
    if (is_face == 0) return path;
    for (vxs_i32 n = 0; n < 3; n++) to_vpl[n] = VXS_FIELD(light, place)[n] - eye[n];
    path.passed = vxs_air_ray_of_face(to_vpl, direction, VXS_FIELD(light, radius_metres), VXS_FIELD(light, axis));
    part[0]     = path.begin;
    part[1]     = path.end;
    vxs_air_before_face(VXS_REF(path.passed), part);
    path.begin = part[0];
    path.end   = part[1] > part[0] ? part[1] : part[0];
    return path;
}

#endif
