/* Transmittance of baked smoke at a point: one text for C99, C++, GLSL and HLSL; it needs vxs_space.h.
 *
 * The smoke of a light is an array of 32-bit words (formats/vxs.md section 15): a map of curves over each map of the light,
 * with as many texels or fewer. A curve has the transmittance at depths along the light ray through the centre of its texel.
 * Depths are in metres along the axis of the map: from a punctual light itself; for a sun from the near side of its map,
 * before which depths are negative.
 *
 *     word 0      log2 of the texels along a side
 *     word 1, 2   floats: the depth of unit 0 in metres, and metres per unit
 *     word 3...   for each tile of 8 x 8 texels, by rows, map after map, the word where it starts; 0: transmittance 1
 *     a tile      32 words, 64 halves: number of nodes of the texels up to and including this one; then the nodes
 *     a node      depth in units, and in the high half the transmittance, of 65535; along a curve the depth never decreases,
 *                 and the transmittance never increases
 *
 *     vxs_smoke_left    transmittance at a point: a weighted mean of four curves, since curves themselves cannot be filtered
 *
 * A curve is 1 before its first node, constant behind the last, and linear between two nodes. Curves are undefined behind
 * the first surface that the light meets: such a point is in shadow anyway. In a march through fog, multiply it with the lit
 * fraction of each step, at the same place. In C any numbers are allowed, and the result is never NaN; shaders as for
 * vxs_space.h.
 * Source: [AVSM10] 3.2 and 4.1, with integers.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_SMOKE_H
#define VXS_SMOKE_H

#ifndef VXS_SPACE_H /* a shader that cannot include already has this text */
#include "vxs_space.h"
#endif

#ifdef VXS_C
#include <string.h>
VXS_FN vxs_real vxs_real_of(vxs_u32 bits)
{
    float number;
    memcpy(&number, &bits, sizeof number);
    return VXS_REAL(number);
}
#endif

/* Number of nodes of the texels of a tile before texel n. */
VXS_FN vxs_u32 vxs_smoke_nodes_before(VXS_WORDS smoke, vxs_u32 tile, vxs_u32 n)
{
    if (n == 0u) return 0u;
    vxs_u32 both = vxs_word(smoke, tile + ((n - 1u) >> 1));
    return (n & 1u) != 0u ? both & 0xffffu : both >> 16;
}

/* Transmittance of the curve of a texel at a depth in units.   map, x, y  texel of the maps of the smoke */
VXS_FN vxs_real vxs_smoke_curve(VXS_WORDS smoke, vxs_i32 map, vxs_i32 x, vxs_i32 y, vxs_real depth)
{
    vxs_i32 wide = VXS_I(1) << (vxs_word(smoke, 0u) - 3u), before = 0;
    vxs_u32 tile = vxs_word(smoke, 3u + VXS_U((map * wide + (y >> 3)) * wide + (x >> 3))), n = VXS_U((x & 7) + 8 * (y & 7));
    if (tile == 0u) return VXS_REAL(1.0);
    vxs_u32 first = vxs_smoke_nodes_before(smoke, tile, n), end = vxs_smoke_nodes_before(smoke, tile, n + 1u),
            at    = tile + 32u + first;
    vxs_i32 count = VXS_I(end - first);
    for (vxs_i32 step = 16; step > 0; step >>= 1)
        if (before + step <= count && !(VXS_REAL(vxs_word(smoke, at + VXS_U(before + step - 1)) & 0xffffu) > depth)) before += step;
    if (before == 0) return VXS_REAL(1.0);
    vxs_u32  a    = vxs_word(smoke, at + VXS_U(before - 1));
    vxs_real left = VXS_REAL(a >> 16);
    if (before < count) {
        vxs_u32  b    = vxs_word(smoke, at + VXS_U(before));
        vxs_real near = VXS_REAL(a & 0xffffu), far = VXS_REAL(b & 0xffffu);
        left += (VXS_REAL(b >> 16) - left) * ((depth - near) / (far - near));
    }
    return left / 65535.0;
}

/* Place of a point in the maps of curves: texels across and down, depth in metres.
 * Returns the map; -1: outside, where nothing is known and the transmittance is 1 */
VXS_FN vxs_i32 vxs_smoke_place(VXS_LIGHT light, const vxs_real3 point_ws, vxs_real texels, VXS_OUT vxs_real3 place)
{
    vxs_real3 ls, p;
    vxs_real  side = VXS_REAL(VXS_I(1) << VXS_FIELD(light, levels));
    vxs_i32   map  = 0;
    vxs_ls_from_ws(light, point_ws, VXS_REAL(1.0), ls);
#ifdef VXS_HAS_SUNS
    if (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL) {
        place[0] = ls[0];
        place[1] = ls[1];
        place[2] = ls[2] * VXS_FIELD(light, voxel_metres);
        if (!(ls[0] >= 0.0 && ls[1] >= 0.0 && ls[0] < side && ls[1] < side)) map = -1;
    }
#endif
#ifdef VXS_HAS_PUNCTUAL
    if (VXS_KIND(light) != VXS_LIGHT_KIND_DIRECTIONAL) {
        map = vxs_map_from_ls(light, ls);
        vxs_face_from_ls(vxs_face_of_map(light, map), ls, p);
        place[2] = p[2] > VXS_REAL_MIN ? p[2] : VXS_REAL_MIN;
        place[0] = vxs_punctual_coordinate(light, p[0], place[2]);
        place[1] = vxs_punctual_coordinate(light, p[1], place[2]);
        if (vxs_in_reach(light, ls) == 0) map = -1;
    }
#endif
    place[0] = place[0] * (texels / side);
    place[1] = place[1] * (texels / side);
    return map;
}

/* Transmittance at a point, 0 to 1; 1 outside the volume of the light and beside its map. The outer half texel of a map uses
 * the values of its last texels.
 * smoke     the words
 * point_ws  as for vxs_place_from_ws */
VXS_FN vxs_real vxs_smoke_left(VXS_WORDS smoke, VXS_LIGHT light, const vxs_real3 point_ws)
{
    vxs_real3 place;
    vxs_i32   side = VXS_I(1) << vxs_word(smoke, 0u);
    vxs_i32   map  = vxs_smoke_place(light, point_ws, VXS_REAL(side), place);
    vxs_real  left = VXS_REAL(0.0), depth = (place[2] - vxs_real_of(vxs_word(smoke, 1u))) / vxs_real_of(vxs_word(smoke, 2u));
    if (map < 0) return VXS_REAL(1.0);
    for (vxs_i32 k = 0; k < 2; k++) /* infinite for a point beside a spot whose cone is a half space */
        place[k] = !(place[k] > 0.0) ? VXS_REAL(0.0) : place[k] < VXS_REAL(side) ? place[k] : VXS_REAL(side);
    vxs_i32  x = vxs_clamped(floor(place[0] - 0.5)), y = vxs_clamped(floor(place[1] - 0.5));
    vxs_real across = place[0] - 0.5 - VXS_REAL(x), down = place[1] - 0.5 - VXS_REAL(y);
    for (vxs_i32 n = 0; n < 4; n++) {
        vxs_i32  i = x + (n & 1), j = y + (n >> 1);
        vxs_real weight = ((n & 1) != 0 ? across : 1.0 - across) * (n > 1 ? down : 1.0 - down);
        i               = i < 0 ? 0 : i < side ? i : side - 1;
        j               = j < 0 ? 0 : j < side ? j : side - 1;
        left += weight * vxs_smoke_curve(smoke, map, i, j, depth);
    }
    return left < 0.0 ? VXS_REAL(0.0) : left > 1.0 ? VXS_REAL(1.0) : left;
}

#endif
