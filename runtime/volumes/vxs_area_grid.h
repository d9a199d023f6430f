/* What virtual point lights and their shadow volumes are, to shaders and C: one text for C99, C++, GLSL and HLSL, that stands on vxs_shadow_grid.h.
 *
 *     vxs_area_hash     an integer that looks random
 *     vxs_area_texel    a direction to a place in a lamp's imperfect shadow map
 *     vxs_area_path     an eye ray in the light of a lamp
 *     vxs_grid_lit      how lit a place is, between two rows and two bits of its grid
 *
 * An imperfect shadow map has the half of all directions that a lamp shines to, as a paraboloid mirror shows them: a disc in a square. A texel is how far
 * from the lamp shadow begins, in metres.
 * Source: [IVSV13] 3, and its appendix for the interpolation by bits; [Ritschel 2008] for imperfect shadow maps.
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

/* way   from the lamp, in its frame: across, up, and along its normal; along > 0; of any length
 * at    [out] texels
 * Returns how wide a texel is there, as a part of the distance from the lamp. */
VXS_FN vxs_real vxs_area_texel(const vxs_real3 way, vxs_i32 side, VXS_OUT vxs_real2 at)
{
    vxs_real metres = sqrt(vxs_air_dot(way, way)), depth = metres + way[2], half_side = 0.5 * VXS_REAL(side);
    vxs_real x = way[0] / depth, y = way[1] / depth;
    at[0] = half_side * (1.0 + x);
    at[1] = half_side * (1.0 + y);
    return 2.0 / (half_side * (1.0 + x * x + y * y));
}

/* An eye ray in the light of a lamp.
 * light  its place, radius, and, where it is a face, its normal as axis;   is_face  1: it shines to one side;   all else as for vxs_air_path_of */
VXS_FN vxs_air_path vxs_area_path(VXS_AIR_LIGHT light, vxs_i32 is_face, const vxs_real3 eye, const vxs_real3 direction,
                                  vxs_real metres, vxs_real top)
{
    vxs_real3    to_lamp;
    vxs_real2    part;
    vxs_air_path path = vxs_air_path_of(light, eye, direction, metres, top, part);
    if (is_face == 0) return path;
    for (vxs_i32 n = 0; n < 3; n++) to_lamp[n] = VXS_FIELD(light, place)[n] - eye[n];
    path.passed = vxs_air_ray_of_face(to_lamp, direction, VXS_FIELD(light, radius_metres), VXS_FIELD(light, axis));
    part[0]     = path.begin;
    part[1]     = path.end;
    vxs_air_before_face(VXS_REF(path.passed), part);
    path.begin = part[0];
    path.end   = part[1] > part[0] ? part[1] : part[0];
    return path;
}

/* How lit a place is between two bits of a row, [0, 1]: both of one word, or of two. */
VXS_FN vxs_real vxs_grid_lit_between(VXS_GRID_WORDS words, VXS_GRID_SIZE size, vxs_i32 column, vxs_i32 row, vxs_i32 bit,
                                     vxs_i32 next, vxs_real part)
{
    vxs_u32 here = vxs_grid_word(words, vxs_grid_word_of(size, column, row, bit)), there = here;
    if ((next >> 5) != (bit >> 5)) there = vxs_grid_word(words, vxs_grid_word_of(size, column, row, next));
    vxs_real dark = VXS_REAL((here >> (bit & 31)) & 1u), then = VXS_REAL((there >> (next & 31)) & 1u);
    return 1.0 - dark - part * (then - dark);
}

/* How lit a place is, [0, 1], between the middles of two bits and two rows. None of an eye ray's bits goes on in another ray's: beyond the first and the
 * last there is nothing to change. Along columns visibility changes once, and lies between no two.
 * bits  how many lie before it */
VXS_FN vxs_real vxs_grid_lit(VXS_GRID_WORDS words, VXS_GRID_SIZE size, vxs_i32 column, VXS_GRID_ROWS rows, vxs_real bits)
{
    vxs_i32  count = VXS_FIELD(size, bits);
    vxs_real at = bits - 0.5, floored = floor(at), part = at - floored;
    vxs_i32  bit = vxs_grid_voxel(floored, count), next = at < 0.0 ? 0 : bit + 1 < count ? bit + 1 : bit;
    vxs_real lit = vxs_grid_lit_between(words, size, column, VXS_FIELD(rows, row), bit, next, part);
    if (!(VXS_FIELD(rows, part) > 0.0)) return lit;
    return lit + VXS_FIELD(rows, part) * (vxs_grid_lit_between(words, size, column, VXS_FIELD(rows, next), bit, next, part) - lit);
}

#endif
