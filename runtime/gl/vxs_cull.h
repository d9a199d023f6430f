/* Test of a light's volume against a box. One text for C99, C++, GLSL and HLSL; it needs vxs_space.h.
 *
 * The volume is that of vxs_voxel_from_ws: the prism over a directional light's map, the cone and range of a spot or point light.
 * The test is conservative: it returns 1 whenever the light may reach the lookup of a point in the box, including float rounding
 * and the bias along a normal. The three axes of light space of a spot or point light must be orthonormal.
 * Source: [CPVS16] 6.3 for boxes of tiles; separating planes for a box and a cone.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_CULL_H
#define VXS_CULL_H

#ifndef VXS_SPACE_H /* shaders without #include have it in their text already */
#include "vxs_space.h"
#endif

/* Bound on the rounding error of a float sum, relative to the sum of the absolute values of its terms. */
#define VXS_CULL_ROUNDING 2e-6

/* Half of the extent of a box along direction (x, y, z). */
VXS_FN vxs_real vxs_box_reach(const vxs_real3 half_size, vxs_real x, vxs_real y, vxs_real z)
{
    return vxs_abs(x) * half_size[0] + vxs_abs(y) * half_size[1] + vxs_abs(z) * half_size[2];
}

/* The same along row `row` of light space, plus a bound on rounding. */
VXS_FN vxs_real vxs_row_reach(VXS_LIGHT light, vxs_i32 row, const vxs_real3 middle, const vxs_real3 half_size)
{
    vxs_real x = VXS_LS_FROM_WS(light, row, 0), y = VXS_LS_FROM_WS(light, row, 1), z = VXS_LS_FROM_WS(light, row, 2);
    vxs_real size =
        vxs_abs(x * middle[0]) + vxs_abs(y * middle[1]) + vxs_abs(z * middle[2]) + vxs_abs(VXS_LS_FROM_WS(light, row, 3));
    vxs_real reach = vxs_box_reach(half_size, x, y, z);
    return reach + VXS_CULL_ROUNDING * (size + reach);
}

/* Returns 1 when a box meets the slab of a directional light's map between its sides along row: u, v or depth. The bias of a
 * point (vxs_space.h) may move it into the slab: by at most (1 + sqrt(2)) / 2 times the filter's reach, where the normal is a
 * diagonal of the map, plus rounding. */
VXS_FN vxs_i32 vxs_sun_meets_box(VXS_LIGHT light, vxs_i32 row, const vxs_real3 middle, const vxs_real3 half_size, vxs_filter pcf)
{
    vxs_real x = VXS_LS_FROM_WS(light, row, 0), y = VXS_LS_FROM_WS(light, row, 1), z = VXS_LS_FROM_WS(light, row, 2);
    vxs_real side = VXS_REAL(VXS_I(1) << VXS_FIELD(light, levels)), at = vxs_ls_coordinate(light, row, middle, VXS_REAL(1.0));
    vxs_real most  = sqrt(x * x + y * y + z * z) * VXS_FIELD(light, texel_metres) * 1.21 * (vxs_filter_reach(pcf) + 0.6) + 3.0;
    vxs_real slack = vxs_row_reach(light, row, middle, half_size) + most;
    return at + slack >= 0.0 && at - slack <= side ? 1 : 0;
}

/* Returns 0 when a box is beyond the range of a spot or point light. */
VXS_FN vxs_i32 vxs_punctual_in_range(VXS_LIGHT light, const vxs_real3 middle, const vxs_real3 half_size)
{
    vxs_real range = VXS_FIELD(light, range_metres), square = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real at   = -(VXS_LS_FROM_WS(light, 0, n) * VXS_LS_FROM_WS(light, 0, 3) +
                        VXS_LS_FROM_WS(light, 1, n) * VXS_LS_FROM_WS(light, 1, 3) +
                        VXS_LS_FROM_WS(light, 2, n) * VXS_LS_FROM_WS(light, 2, 3));
        vxs_real size = vxs_abs(VXS_LS_FROM_WS(light, 0, 3)) + vxs_abs(VXS_LS_FROM_WS(light, 1, 3)) +
                        vxs_abs(VXS_LS_FROM_WS(light, 2, 3)) + vxs_abs(middle[n]);
        vxs_real away = vxs_abs(middle[n] - at) - half_size[n] * (1.0 + VXS_CULL_ROUNDING) - VXS_CULL_ROUNDING * size;
        if (away > 0.0) square += away * away;
    }
    return range <= 0.0 || square <= range * range * (1.0 + 4.0 * VXS_CULL_ROUNDING) ? 1 : 0;
}

/* Returns 0 when a box is outside the cone of a spot light: behind its tip, or on the outer side of the plane that touches the
 * cone next to the middle of the box.
 *
 *            \  n    /         n is the plane's normal, pointing away from the cone.
 *      box    \ ^   / cone     The cosine is reduced by more than the lookup's own rounding. */
VXS_FN vxs_i32 vxs_spot_meets_box(VXS_LIGHT light, const vxs_real3 middle, const vxs_real3 half_size)
{
    vxs_real3 ls, reach;
    vxs_ls_from_ws(light, middle, VXS_REAL(1.0), ls);
    reach[0] = vxs_row_reach(light, 0, middle, half_size);
    reach[1] = vxs_row_reach(light, 1, middle, half_size);
    reach[2] = vxs_row_reach(light, 2, middle, half_size);
    if (ls[2] + reach[2] < 0.0) return 0;

    vxs_real cosine = VXS_FIELD(light, cos_outer) - VXS_REAL(1e-6), across = sqrt(ls[0] * ls[0] + ls[1] * ls[1]);
    vxs_real sine = sqrt((1.0 - cosine) * (1.0 + cosine)), to_x = VXS_REAL(1.0), to_y = VXS_REAL(0.0);
    if (across > VXS_REAL_MIN) {
        to_x = ls[0] / across;
        to_y = ls[1] / across;
    }
    vxs_real x = cosine * to_x, y = cosine * to_y, z = -sine;
    vxs_real along = vxs_box_reach(
        half_size, x * VXS_LS_FROM_WS(light, 0, 0) + y * VXS_LS_FROM_WS(light, 1, 0) + z * VXS_LS_FROM_WS(light, 2, 0),
        x * VXS_LS_FROM_WS(light, 0, 1) + y * VXS_LS_FROM_WS(light, 1, 1) + z * VXS_LS_FROM_WS(light, 2, 1),
        x * VXS_LS_FROM_WS(light, 0, 2) + y * VXS_LS_FROM_WS(light, 1, 2) + z * VXS_LS_FROM_WS(light, 2, 2));
    vxs_real rounding = 0.0;
    for (vxs_i32 row = 0; row < 3; row++)
        rounding += reach[row] - vxs_box_reach(half_size, VXS_LS_FROM_WS(light, row, 0), VXS_LS_FROM_WS(light, row, 1),
                                               VXS_LS_FROM_WS(light, row, 2));
    return cosine * across - sine * ls[2] <= along * (1.0 + VXS_CULL_ROUNDING) + 2.0 * rounding ? 1 : 0;
}

/* Returns 1 when a light may reach a point of a box, 0 when it reaches none.
 * middle, half_size  metres; in a shader, relative to the origin of the light's constants. half_size is not negative
 * pcf                widest filter of the lookups, as for vxs_lit */
VXS_FN vxs_i32 vxs_light_meets_box(VXS_LIGHT light, const vxs_real3 middle, const vxs_real3 half_size, vxs_filter pcf)
{
    if (VXS_FIELD(light, kind) == VXS_LIGHT_KIND_DIRECTIONAL) {
        if (vxs_sun_meets_box(light, 0, middle, half_size, pcf) == 0) return 0;
        if (vxs_sun_meets_box(light, 1, middle, half_size, pcf) == 0) return 0;
        if ((VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) == 0u) return 1;
        return vxs_sun_meets_box(light, 2, middle, half_size, pcf);
    }
    if (vxs_punctual_in_range(light, middle, half_size) == 0) return 0;
    if (VXS_FIELD(light, kind) == VXS_LIGHT_KIND_POINT) return 1;
    return vxs_spot_meets_box(light, middle, half_size);
}

#endif
