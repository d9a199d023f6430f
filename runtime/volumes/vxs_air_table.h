/* Airlight of a lamp along a part of an eye ray from a table: two places of it and an exponential for each colour channel, where
 * the quadrature of vxs_air.h takes up to a hundred. One text for C99, C++ and GLSL, that stands on vxs_air.h.
 *
 *     vxs_air_table_fill   make the table of a phase function; C and C++
 *     vxs_air_table_lamp   as vxs_air_lamp
 *     vxs_air_table_until  from the eye on, as one term of a sum
 *
 * In the words of vxs_air.h, u = extinction * h, T = k d / h = tan b: what a lamp adds from T on, all the way to infinity, is
 *
 *     H(u, T) = Int[T..inf] s(t) exp(-u (t - T) / k) / (1 + t^2) dt        s(t) = sqrt((1 + t^2 / k^2) / (1 + t^2))
 *
 * times what is lost until there; a segment is the difference of two such tails. They fall to nothing behind the lamp and in dense
 * air, too fast for a table. So the table holds H over a formula that falls as they do and is within a factor of two, which leaves
 * something smooth:
 *
 *     c s(T + m) (z + p) / (z^2 + (p + 2) z + p)     c = cos b, z = u / (k c), m = 0.7 / (u / k + 1 / (1 + T)), p = 1.1
 *
 * The fraction is (1 + z)^-1 made better, of the exponential integral exp(z) E_2(z), which the tail is far behind the lamp; s is
 * asked where the tail has its middle.
 *
 *           x ->  0            u             1       x^2 = (z / (1 + z) + z' / (1 + z')) / 2,
 *                                                    z' = u / cos t, tan t = T / k = d / h
 *      y   0  begins far before the lamp             y = (b + t) / pi
 *      |      ...
 *      v   1  begins far behind it                   both have as much room for d = h / k as for d = h,
 *                                                    where phase and distance change
 *
 * A difference of tails that are nearly equal says little: where one leaves more than VXS_AIR_TABLE_MOST of the other, and in the
 * rims of spot lights, the quadrature is asked instead. Errors and times: docs/volumes.md.
 * Source: [Sun 2005] tabulates such an integral from the lamp on, of even scattering, without the formula; scaled tails are ours.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AIR_TABLE_H
#define VXS_AIR_TABLE_H

#ifndef VXS_AIR_H /* a shader that cannot include has it already */
#include "vxs_air.h"
#endif

/* A shader's table is a texture of side x side R32F texels, filtered linearly, clamped to edges; or what the includer says. */
#ifdef VXS_C
typedef struct vxs_air_table vxs_air_table;
struct vxs_air_table {
    const float *values; /* [side][side], rows of y, of vxs_air_table_fill; borrowed */
    vxs_i32      side;   /* 2 to 4096 */
};
#define VXS_AIR_TABLE const vxs_air_table *
#elif !defined(VXS_AIR_TABLE)
#define VXS_AIR_TABLE sampler2D
#endif

#define VXS_AIR_TABLE_SIDE 128
#define VXS_AIR_TABLE_MOST 0.9

/* The table at a place, [0, 1] each. */
VXS_FN vxs_real vxs_air_table_at(VXS_AIR_TABLE table, vxs_real x, vxs_real y)
{
#ifdef VXS_C
    vxs_real     last = VXS_REAL(table->side - 1), across = x * last, down = y * last;
    vxs_i32      i = VXS_I(across), j = VXS_I(down);
    const float *at;
    if (i > table->side - 2) i = table->side - 2;
    if (j > table->side - 2) j = table->side - 2;
    at = table->values + j * table->side + i;
    across -= i;
    down -= j;
    return (1.0 - down) * ((1.0 - across) * VXS_REAL(at[0]) + across * VXS_REAL(at[1])) +
           down * ((1.0 - across) * VXS_REAL(at[table->side]) + across * VXS_REAL(at[table->side + 1]));
#else
    vec2 side = vec2(textureSize(table, 0));
    return textureLod(table, (vec2(x, y) * (side - 1.0) + 0.5) / side, 0.0).x;
#endif
}

VXS_FN vxs_real vxs_air_table_x(vxs_real k, vxs_real u, vxs_real tangent)
{
    vxs_real sharp = tangent / k, near = u / k * sqrt(1.0 + tangent * tangent), wide = u * sqrt(1.0 + sharp * sharp);
    return sqrt(0.5 * (near / (1.0 + near) + wide / (1.0 + wide)));
}

VXS_FN vxs_real vxs_air_table_y(vxs_real k, vxs_real tangent)
{
    return (vxs_air_angle(tangent, VXS_REAL(1.0)) + vxs_air_angle(tangent, k)) / VXS_AIR_PI;
}

/* The formula. */
VXS_FN vxs_real vxs_air_table_scale(vxs_real k, vxs_real u, vxs_real tangent)
{
    vxs_real w = u / k, c = 1.0 / sqrt(1.0 + tangent * tangent), z = w / c;
    vxs_real middle = tangent + 0.7 / (w + 1.0 / (1.0 + tangent)), sharp = middle / k;
    vxs_real s = sqrt(1.0 + sharp * sharp) / sqrt(1.0 + middle * middle);
    return c * s * ((z + 1.1) / (z * (z + 3.1) + 1.1));
}

/* Add the airlight of [begin, begin + length), all within a spot light's inner cone, but for what does not depend on it: as
 * vxs_air_add.
 * most  where the tail at the end is more of that at the begin, the difference says little: nothing is added, and 0 is returned;
 *       else 1 */
VXS_FN vxs_i32 vxs_air_table_add(VXS_AIR_TABLE table, VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real begin, vxs_real length,
                                 vxs_real most, VXS_INOUT vxs_real3 sum)
{
    vxs_real  h = VXS_FIELD(ray, beside), y = begin - VXS_FIELD(ray, along), end = y + length;
    vxs_real  k      = (1.0 + VXS_FIELD(medium, anisotropy)) / (1.0 - VXS_FIELD(medium, anisotropy));
    vxs_real  detour = vxs_air_detour(ray, y), detour_end = vxs_air_detour(ray, end);
    vxs_real  more    = length * ((detour + detour_end) / (sqrt(h * h + y * y) + sqrt(h * h + end * end)));
    vxs_real  tangent = k * (detour / h), tangent_end = k * (detour_end / h);
    vxs_real3 tail, left;
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real dense = VXS_FIELD(medium, extinction)[n];
        tail[n]        = vxs_air_table_scale(k, dense * h, tangent);
        left[n]        = vxs_air_table_scale(k, dense * h, tangent_end) * exp(-dense * more);
        if (!(left[n] <= most * tail[n])) return 0;
    }
    vxs_real row = vxs_air_table_y(k, tangent), row_end = vxs_air_table_y(k, tangent_end);
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real dense = VXS_FIELD(medium, extinction)[n], u = dense * h;
        vxs_real seen = tail[n] * vxs_air_table_at(table, vxs_air_table_x(k, u, tangent), row) -
                        left[n] * vxs_air_table_at(table, vxs_air_table_x(k, u, tangent_end), row_end);
        if (seen > 0.0) sum[n] += seen * exp(-dense * (VXS_FIELD(ray, along) - VXS_FIELD(ray, in_fog) + detour));
    }
    return 1;
}

/* As vxs_air_lamp, which is asked of lamps above a level top of the fog, and of lamps with a range: tails know nothing of either.
 * table  of the medium's anisotropy */
VXS_FN void vxs_air_table_lamp(VXS_AIR_TABLE table, VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real begin, vxs_real length,
                               VXS_OUT vxs_real3 airlight)
{
    vxs_real2 part;
    part[0]     = begin;
    part[1]     = length;
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    vxs_air_add_rims(medium, ray, part, airlight);
    if (part[1] > 0.0 && (VXS_FIELD(ray, above) > 0.0 || VXS_FIELD(ray, per_range) > 0.0 ||
                          vxs_air_table_add(table, medium, ray, part[0], part[1], VXS_REAL(VXS_AIR_TABLE_MOST), airlight) == 0))
        vxs_air_add(medium, ray, part[0], part[1], airlight);
    vxs_air_finish(medium, ray, airlight);
}

/* The airlight of [0, metres), of a point light without a range that is not above a level top of the fog, to an error relative to that of the whole ray and not to its own: for sums of such
 * terms, as light meshes are. No quadrature, and no branch. */
VXS_FN void vxs_air_table_until(VXS_AIR_TABLE table, VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real metres,
                                VXS_OUT vxs_real3 airlight)
{
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    vxs_air_table_add(table, medium, ray, VXS_REAL(0.0), metres, VXS_REAL(1e9), airlight);
    vxs_air_finish(medium, ray, airlight);
}

#ifdef VXS_C
/* The detour of a row, for h = 1, by tan(pi y) = tan(b + atan(d)), k d = tan b; no more than where nothing changes any more. */
VXS_FN vxs_real vxs_air_table_detour(vxs_real k, vxs_real y)
{
    vxs_real s = sin(VXS_AIR_PI * y), c = (1.0 + k) * cos(VXS_AIR_PI * y), root = sqrt(c * c + 4.0 * k * s * s);
    vxs_real detour = c > 0.0 ? 2.0 * s / (c + root) : (root - c) / (2.0 * k * s), most = 1e6 * (1.0 + 1.0 / k);
    return detour < most ? detour : most;
}

/* u of a place, x in [0, 1), h = 1: the positive root of a quadratic. */
VXS_FN vxs_real vxs_air_table_u(vxs_real k, vxs_real x, vxs_real detour)
{
    vxs_real near = sqrt(1.0 / (k * k) + detour * detour), wide = sqrt(1.0 + detour * detour);
    vxs_real a = (2.0 - 2.0 * x) * near * wide, b = (1.0 - 2.0 * x) * (near + wide), root = sqrt(b * b + 8.0 * a * x);
    return b > 0.0 ? 4.0 * x / (b + root) : (root - b) / (2.0 * a);
}

/* The tail behind a detour, h = 1, in pieces in which little changes. */
VXS_FN vxs_real vxs_air_table_tail(vxs_real k, vxs_real u, vxs_real from)
{
    vxs_medium  medium = {{0.0, 0.0, 0.0}, {u, 0.0, 0.0}, 0.0};
    vxs_air_ray ray    = {-from, 1.0, 0.0, 0.0, -1.0, -1.0, 0.0, 1.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0};
    vxs_real    at = from, far = 1e12 * (1.0 + 1.0 / k), least = k > 1.0 ? 1.0 / k : 1.0, sum[3] = {0.0, 0.0, 0.0};
    while (at < far && u * (at - from) < 40.0) {
        vxs_real more = least + at;
        if (u * more > 2.0) more = 2.0 / u;
        vxs_air_part part = vxs_air_part_of(&ray, k, at, more);
        vxs_air_add_part(&medium, &ray, k, &part, u * more, 0.0, sum);
        at += more;
    }
    return sum[0];
}

/* Make the table of a phase function.
 * g       anisotropy, -0.99 to 0.99; the media it is used for have the same
 * values  [out] [side][side]; 1 where air is so dense that the formula is exact
 * side    2 to 4096; VXS_AIR_TABLE_SIDE for the errors of docs/volumes.md
 * Cost: 4 us a value.   Threads: any, of different tables. */
VXS_FN void vxs_air_table_fill(vxs_real g, float *values, vxs_i32 side)
{
    vxs_real k = (1.0 + g) / (1.0 - g), last = VXS_REAL(side - 1);
    for (vxs_i32 j = 0; j < side; j++) {
        vxs_real detour = vxs_air_table_detour(k, j / last);
        float   *row    = values + j * side;
        for (vxs_i32 i = 0; i < side - 1; i++) {
            vxs_real u = vxs_air_table_u(k, (i / last) * (i / last), detour);
            row[i]     = VXS_CAST(float, vxs_air_table_tail(k, u, detour) / vxs_air_table_scale(k, u, k * detour));
        }
        row[side - 1] = 1.0F;
    }
}
#endif

#endif
