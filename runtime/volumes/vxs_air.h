/* Airlight in a homogeneous medium, along a part of an eye ray that is fully lit: one text for C99, C++, GLSL and HLSL. Built on
 * vxs_air_ray.h.
 *
 *     vxs_air_punctual         airlight of a spot or point light along a part of the ray
 *     vxs_air_sun          airlight of the sun along a part of the ray
 *
 * Distances are metres along the ray from the eye; the ray's direction has length 1. The numbers of
 * the medium are per metre and colour channel. Airlight is radiance for an intensity (punctual lights: candela, per steradian)
 * or an irradiance (sun: lux) of 1 in each channel. Multiply it by the colour of the light to get what the eye sees.
 *
 *     light            Light that scatters at x toward the eye has travelled x + r, where r is the distance from the light to x.
 *       *              This is `along` plus a detour d = r + x - along, which increases with x. With h = beside:
 *       |`.  r
 *     h |  `.              r = (d^2 + h^2) / 2d        x = along + (d^2 - h^2) / 2d        d / h = tan(half the scattering angle)
 *       |    `.
 *     --+------+-->    Let b be the angle with tan b = k d / h, k = (1 + g) / (1 - g). Then phase and falloff together are
 *     along    x
 *                          p / r^2 dx = sqrt((h^2 + d^2) / (h^2 + k^2 d^2)) / (2 pi h (1 - g)) db
 *
 *                      This is smooth and nearly constant, however sharp the phase function is. So a quadrature in b needs few
 *                      nodes. No exponent is positive, and no nearly equal numbers are subtracted. If a punctual light has a
 *                      range, each node is multiplied by 1 - (r / range)^4.
 *
 * The segment is split where the optical depth of the detour reaches 1, 5, 21..., and ends at 24. If the light has a range, the
 * segment is also split at a third of the range: beyond that, the window of the range changes while b hardly does. In fog with a
 * level top and with a punctual light above it, the path through the fog may get shorter along the ray. Then the segment is split
 * by optical depth, starting from its bright end.
 * Relative error of 10^5 random rays with optical depths from 1e-6 to 1e4 and g from -0.99 to 0.99: docs/measurements.md.
 * Source: [Sun 2005] for airlight by angles; [Billeter 2010] for the sum over lit segments. The variable b is ours.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AIR_H
#define VXS_AIR_H

#ifndef VXS_AIR_RAY_H /* a shader that cannot include has it already */
#include "vxs_air_ray.h"
#endif

#ifdef VXS_C
typedef struct vxs_air_part vxs_air_part;
#define VXS_AIR_PART const vxs_air_part *
#else
#define VXS_AIR_PART const vxs_air_part
#endif

#define VXS_AIR_DEPTH_MAX 24.0 /* optical depth beyond which light is ignored: e^-24 */
#define VXS_AIR_PARTS     12

/* sin x, x in [0, pi / 2], with a relative error of 4e-6. Shading languages guarantee no relative error. */
VXS_FN vxs_real vxs_air_sine(const vxs_real x)
{
    vxs_real s = x * x;
    return x * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362880.0)))));
}

/* atan(y / x) in [0, pi / 2], x, y >= 0, with a relative error of 1e-6: the angle is halved twice, then a series. */
VXS_FN vxs_real vxs_air_angle(const vxs_real y, const vxs_real x)
{
    vxs_real most = vxs_air_more(y, x), angle = VXS_REAL(0.0);
    if (most > 0.0) {
        vxs_real v = y / most, u = x / most, t = v / (u + sqrt(u * u + v * v));
        t          = t / (1.0 + sqrt(1.0 + t * t));
        vxs_real s = t * t;
        angle =
            4.0 * t *
            (1.0 + s * (-1.0 / 3.0 + s * (1.0 / 5.0 + s * (-1.0 / 7.0 + s * (1.0 / 9.0 + s * (-1.0 / 11.0 + s * (1.0 / 13.0)))))));
    }
    return angle;
}

/* Gauss-Legendre quadrature of 2, 4 or 8 nodes, in pairs about the middle: the distance of node n from the middle, in half
 * lengths of the part, and below its weight. */
VXS_FN vxs_real vxs_air_offset(const vxs_i32 pairs, const vxs_i32 n)
{
    return pairs == 1   ? VXS_REAL(0.5773502691896258)
           : pairs == 2 ? (n == 0 ? VXS_REAL(0.3399810435848563) : VXS_REAL(0.8611363115940526))
           : n < 2      ? (n == 0 ? VXS_REAL(0.1834346424956498) : VXS_REAL(0.5255324099163290))
                        : (n == 2 ? VXS_REAL(0.7966664774136267) : VXS_REAL(0.9602898564975362));
}

VXS_FN vxs_real vxs_air_weight(const vxs_i32 pairs, const vxs_i32 n)
{
    return pairs == 1   ? VXS_REAL(1.0)
           : pairs == 2 ? (n == 0 ? VXS_REAL(0.6521451548625461) : VXS_REAL(0.3478548451374539))
           : n < 2      ? (n == 0 ? VXS_REAL(0.3626837833783620) : VXS_REAL(0.3137066458778873))
                        : (n == 2 ? VXS_REAL(0.2223810344533745) : VXS_REAL(0.1012285362903763));
}

/* A part of the ray, described by detours at its ends. */
struct vxs_air_part {
    vxs_real detour, more;         /* detour at its begin; increase of the detour to its end */
    vxs_real wide;                 /* difference of the angle b between its ends */
    vxs_real near_begin, near_end; /* cos b at its ends */
};

VXS_FN vxs_air_part vxs_air_part_of(VXS_AIR_RAY ray, const vxs_real k, const vxs_real detour, const vxs_real more)
{
    vxs_air_part part;
    vxs_real     h = VXS_FIELD(ray, beside), begin = k * (detour / h), end = k * ((detour + more) / h);
    part.detour     = detour;
    part.more       = more;
    part.wide       = vxs_air_angle(k * (more / h), 1.0 + begin * end);
    part.near_begin = 1.0 / sqrt(1.0 + begin * begin);
    part.near_end   = 1.0 / sqrt(1.0 + end * end);
    return part;
}

/* k, with which the integrand over b is most even. */
VXS_FN vxs_real vxs_air_sharpness(VXS_MEDIUM medium)
{
    return (1.0 + VXS_FIELD(medium, anisotropy)) / (1.0 - VXS_FIELD(medium, anisotropy));
}

/* Detour at `begin`, and its increase over a length, computed without subtracting nearly equal numbers. */
VXS_FN void vxs_air_detours(VXS_AIR_RAY ray, const vxs_real begin, const vxs_real length, VXS_OUT vxs_real2 detours)
{
    vxs_real h = VXS_FIELD(ray, beside), y = begin - VXS_FIELD(ray, along), end = y + length;
    vxs_real detour = vxs_air_detour(ray, y), sum_of_r = sqrt(h * h + y * y) + sqrt(h * h + end * end);
    detours[0] = detour;
    detours[1] = length * ((detour + vxs_air_detour(ray, end)) / sum_of_r);
}

/* The part from `begin` on, of a given length. */
VXS_FN vxs_air_part vxs_air_part_between(VXS_AIR_RAY ray, const vxs_real k, const vxs_real begin, const vxs_real length)
{
    vxs_real2 detours;
    vxs_air_detours(ray, begin, length, detours);
    return vxs_air_part_of(ray, k, detours[0], detours[1]);
}

/* Increase of the detour from the part's begin to a share, [0, 1], of the part's angle. The direction in between is a sum of
 * both directions, weighted by sines: no term is negative. */
VXS_FN vxs_real vxs_air_more_at(VXS_AIR_PART part, const vxs_real share)
{
    vxs_real wide = VXS_FIELD(part, wide), first = 1.0 - share, second = share;
    if (wide > 1e-3) {
        first  = vxs_air_sine(first * wide);
        second = vxs_air_sine(second * wide);
    }
    first *= VXS_FIELD(part, near_begin);
    second *= VXS_FIELD(part, near_end);
    return VXS_FIELD(part, more) * (second / (first + second));
}

/* Metres from the part's begin to there, also without a difference. */
VXS_FN vxs_real vxs_air_metres_of(VXS_AIR_RAY ray, VXS_AIR_PART part, const vxs_real more)
{
    vxs_real h = VXS_FIELD(ray, beside), detour = VXS_FIELD(part, detour);
    return 0.5 * more * (1.0 + (h / detour) * (h / (detour + more)));
}

/* Length of the path through the fog of light that scatters there.   from  metres of fog before the part's begin */
VXS_FN vxs_real vxs_air_node_way(VXS_AIR_RAY ray, VXS_AIR_PART part, const vxs_real from, const vxs_real more)
{
    vxs_real h = VXS_FIELD(ray, beside), detour = VXS_FIELD(part, detour) + more;
    vxs_real way = VXS_FIELD(ray, along) - VXS_FIELD(ray, in_fog) + detour;
#ifndef VXS_ONLY_EVERYWHERE
    if (VXS_AIR_IS_BELOW(ray)) way = vxs_air_way(ray, from + vxs_air_metres_of(ray, part, more), 0.5 * (detour + h * (h / detour)));
#endif
    return way;
}

/* Add a node: phase and falloff without the factors that all nodes share, the rim of a spot light, and the extinction on the path.
 * more  increase of the detour from the part's begin;   from  metres of fog before the part's begin */
VXS_FN void vxs_air_add_node(VXS_MEDIUM medium, VXS_AIR_RAY ray, const vxs_real k, VXS_AIR_PART part, const vxs_real from,
                             const vxs_real more, const vxs_real weight, VXS_INOUT vxs_real3 sum)
{
    vxs_real detour = VXS_FIELD(part, detour) + more, ratio = VXS_FIELD(ray, beside) / detour, square = ratio * ratio;
    vxs_real way = vxs_air_node_way(ray, part, from, more);
    vxs_real rim = vxs_air_window(0.5 * detour * (1.0 + square), VXS_FIELD(ray, per_range));
    if (VXS_AIR_HAS_RIM)
        rim *= vxs_air_rim_at(ray,
                              ((1.0 - square) * VXS_FIELD(ray, facing) + 2.0 * (VXS_FIELD(ray, before) / detour)) / (1.0 + square));
    rim = weight * (rim * sqrt((1.0 + square) / (k * k + square)));
    for (vxs_i32 n = 0; n < 3; n++) sum[n] += rim * exp(-VXS_FIELD(medium, extinction)[n] * way);
}

/* Distance from the light at a detour, divided by the range. */
VXS_FN vxs_real vxs_air_part_of_range(VXS_AIR_RAY ray, const vxs_real detour)
{
    vxs_real h = VXS_FIELD(ray, beside);
    return 0.5 * (detour + h * (h / detour)) * VXS_FIELD(ray, per_range);
}

/* Add a part. The number of nodes depends on how much the integrand changes: by extinction, by b, by d / (d + h), where b is
 * less useful because k is great, and by the range.
 * depth  optical depth of the part, in the densest channel
 * from   metres of fog before the part's begin; used below a level top */
VXS_FN void vxs_air_add_part(VXS_MEDIUM medium, VXS_AIR_RAY ray, const vxs_real k, VXS_AIR_PART part, const vxs_real depth,
                             const vxs_real from, VXS_INOUT vxs_real3 sum)
{
    vxs_real wide = VXS_FIELD(part, wide), h = VXS_FIELD(ray, beside), begin = h + VXS_FIELD(part, detour);
    vxs_real turn   = (h / begin) * (VXS_FIELD(part, more) / (begin + VXS_FIELD(part, more)));
    vxs_real change = depth + vxs_air_more(wide, turn) * (1.0 + VXS_FIELD(ray, rim_scale));
    if (VXS_FIELD(ray, per_range) > 0.0) {
        vxs_real first = vxs_air_part_of_range(ray, VXS_FIELD(part, detour));
        vxs_real last  = vxs_air_part_of_range(ray, VXS_FIELD(part, detour) + VXS_FIELD(part, more));
        change += vxs_abs(last * last * last * last - first * first * first * first);
    }
    vxs_i32 pairs = change < 0.1 ? 1 : change < 0.7 ? 2 : 4;
    for (vxs_i32 n = 0; n < 2 * pairs; n++) { /* one call, because it is inlined */
        vxs_real offset = 0.5 * vxs_air_offset(pairs, n >> 1), weight = 0.5 * vxs_air_weight(pairs, n >> 1) * wide;
        vxs_real share = (n & 1) == 0 ? 0.5 - offset : 0.5 + offset;
        vxs_air_add_node(medium, ray, k, part, from, vxs_air_more_at(part, share), weight, sum);
    }
}

/* Extinction of the channels with the least and the most. */
VXS_FN vxs_real vxs_air_thinnest(VXS_MEDIUM medium)
{
    return vxs_air_less(VXS_FIELD(medium, extinction)[2],
                        vxs_air_less(VXS_FIELD(medium, extinction)[1], VXS_FIELD(medium, extinction)[0]));
}

VXS_FN vxs_real vxs_air_densest(VXS_MEDIUM medium)
{
    return vxs_air_more(VXS_FIELD(medium, extinction)[2],
                        vxs_air_more(VXS_FIELD(medium, extinction)[1], VXS_FIELD(medium, extinction)[0]));
}

/* Detours where the integrand changes its form: near the light, where phase and distance change, and where the ray comes within a
 * third of the range and leaves it. Sorted, except for the last two. Detours that are not on any ray are 0. */
VXS_FN void vxs_air_cuts(VXS_AIR_RAY ray, const vxs_real k, VXS_OUT vxs_real4 cuts)
{
    vxs_real h = VXS_FIELD(ray, beside), sharp = h / sqrt(k), part = 3.0 * h * VXS_FIELD(ray, per_range);
    cuts[0] = vxs_air_less(sharp, h);
    cuts[1] = vxs_air_more(sharp, h);
    cuts[2] = cuts[3] = VXS_REAL(0.0);
    if (part > 0.0 && part < 1.0) {
        cuts[2] = (1.0 + sqrt(1.0 - part * part)) * (h / part);
        cuts[3] = h * (h / cuts[2]);
    }
}

/* Add the airlight of [begin, begin + length), without the factors of vxs_air_finish, of a punctual light in the fog. */
VXS_FN void vxs_air_add_in_fog(VXS_MEDIUM medium, VXS_AIR_RAY ray, const vxs_real begin, const vxs_real length,
                               VXS_INOUT vxs_real3 sum)
{
    vxs_real  k = vxs_air_sharpness(medium), thinnest = vxs_air_thinnest(medium), densest = vxs_air_densest(medium);
    vxs_real4 cuts;
    vxs_real2 detours;
    vxs_air_detours(ray, begin, length, detours);
    vxs_air_cuts(ray, k, cuts);
    vxs_real detour = detours[0], rest = detours[1], depth = VXS_REAL(1.0);
    if (rest * thinnest > VXS_AIR_DEPTH_MAX) rest = VXS_AIR_DEPTH_MAX / thinnest;
    for (vxs_i32 n = 1; rest > 0.0 && n <= VXS_AIR_PARTS; n++) {
        vxs_real more = rest;
        if (n < VXS_AIR_PARTS) {
            if (more * densest > 1.5 * depth) more = depth / densest;
            for (vxs_i32 i = 0; i < 4; i++)
                if (detour < cuts[i] && detour + more > cuts[i]) more = cuts[i] - detour;
        }
        vxs_air_part part = vxs_air_part_of(ray, k, detour, more);
        vxs_air_add_part(medium, ray, k, VXS_REF(part), densest * more, VXS_REAL(0.0), sum);
        if (more * densest >= depth) depth *= 4.0;
        detour += more;
        rest -= more;
    }
}

/* Length of the next step from a position, forward (turn 1) or back (-1), at most `rest`. It ends where phase and distance
 * change, keeps the height below the light within a factor of 4, and changes the path length of the light by about `change`
 * metres. */
VXS_FN vxs_real vxs_air_step_below(VXS_AIR_RAY ray, vxs_real k, vxs_real from, vxs_real turn, vxs_real rest, vxs_real change)
{
    vxs_real  rises = VXS_FIELD(ray, up) * turn, more = rest, height = VXS_FIELD(ray, above) + vxs_air_below_at(ray, from);
    vxs_real4 cuts;
    vxs_air_cuts(ray, k, cuts);
    for (vxs_i32 n = 0; n < 4; n++) {
        if (!(cuts[n] > 0.0)) continue;
        vxs_real ahead = turn * (vxs_air_place_of(ray, cuts[n]) - VXS_FIELD(ray, in_fog) - from);
        if (ahead > 1e-5 * rest && ahead < more) more = ahead;
    }
    vxs_real way = vxs_air_way_at(ray, from), least = -1e-5 * rises * rest;
    if (vxs_abs(vxs_air_way_at(ray, from + turn * more) - way) <= 0.02 * change) return more;
    if (height < least) height = least;
    if (rises < 0.0 && -rises * more > 3.0 * height) more = 3.0 * height / -rises;
    if (rises > 0.0 && rises * more > 0.75 * height) more = 0.75 * height / rises;
    if (vxs_abs(vxs_air_way_at(ray, from + turn * more) - way) <= 1.5 * change) return more;
    vxs_real low = 1e-9 * more, high = more;
    for (vxs_i32 n = 0; n < 7; n++) {
        vxs_real middle = sqrt(low * high);
        if (vxs_abs(vxs_air_way_at(ray, from + turn * middle) - way) > change)
            high = middle;
        else
            low = middle;
    }
    return low;
}

/* The same as vxs_air_add_in_fog, of a punctual light above the top of the fog. It starts at the end of the part with the shorter
 * light path. */
VXS_FN void vxs_air_add_below(VXS_MEDIUM medium, VXS_AIR_RAY ray, const vxs_real begin, const vxs_real length,
                              VXS_INOUT vxs_real3 sum)
{
    vxs_real k = vxs_air_sharpness(medium), from = begin - VXS_FIELD(ray, in_fog), rest = length, depth = VXS_REAL(1.0);
    vxs_real way = vxs_air_way_at(ray, from), behind = vxs_air_way_at(ray, from + length), turn = VXS_REAL(1.0);
    vxs_real thinnest = vxs_air_thinnest(medium), densest = vxs_air_densest(medium);
    if (behind < way) {
        turn = VXS_REAL(-1.0);
        from += length;
        way = behind;
    }
    /* bounded by the path from there to the eye alone */
    vxs_real first = way, seen = (first - from) * thinnest + VXS_AIR_DEPTH_MAX;
    if (turn > 0.0 && rest * thinnest > seen) rest = seen / thinnest;
    for (vxs_i32 n = 1; rest > 0.0 && n <= VXS_AIR_PARTS; n++) {
        vxs_real more = rest;
        if (n < VXS_AIR_PARTS && densest > 0.0) more = vxs_air_step_below(ray, k, from, turn, rest, depth / densest);
        vxs_real     low = turn > 0.0 ? from : from - more, next = vxs_air_way_at(ray, from + turn * more);
        vxs_real     lost = densest * vxs_abs(next - way);
        vxs_air_part part = vxs_air_part_between(ray, k, VXS_FIELD(ray, in_fog) + low, more);
        vxs_air_add_part(medium, ray, k, VXS_REF(part), lost, low, sum);
        if (thinnest * (next - first) > VXS_AIR_DEPTH_MAX) return;
        if (lost >= 0.5 * depth) depth *= 4.0;
        from += turn * more;
        rest -= more;
        way = next;
    }
}

VXS_FN void vxs_air_add(VXS_MEDIUM medium, VXS_AIR_RAY ray, const vxs_real begin, const vxs_real length, VXS_INOUT vxs_real3 sum)
{
#ifndef VXS_ONLY_EVERYWHERE
    if (VXS_AIR_IS_BELOW(ray)) vxs_air_add_below(medium, ray, begin, length, sum);
#endif
    if (!VXS_AIR_IS_BELOW(ray)) vxs_air_add_in_fog(medium, ray, begin, length, sum);
}

/* Factor of a sum of nodes, for an intensity of 1. */
VXS_FN vxs_real vxs_air_node_scale(VXS_MEDIUM medium, VXS_AIR_RAY ray)
{
    return 1.0 / (2.0 * VXS_AIR_PI * (1.0 - VXS_FIELD(medium, anisotropy)) * VXS_FIELD(ray, beside));
}

/* Multiply by the factors that do not depend on the position. */
VXS_FN void vxs_air_finish(VXS_MEDIUM medium, VXS_AIR_RAY ray, VXS_INOUT vxs_real3 sum)
{
    vxs_real scale = vxs_air_node_scale(medium, ray);
    for (vxs_i32 n = 0; n < 3; n++) sum[n] *= scale * VXS_FIELD(medium, scattering)[n];
}

/* begin, length  of the part of the ray, >= 0, finite; it must be in the light's range, if it has one (vxs_air_in_range); for a
 *                spot light, only the part in its cone counts
 * airlight       [out] */
VXS_FN void vxs_air_punctual(VXS_MEDIUM medium, VXS_AIR_RAY ray, const vxs_real begin, const vxs_real length,
                             VXS_OUT vxs_real3 airlight)
{
    vxs_real first = begin, last = begin, full = begin, faded = begin, rest = length;
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    /* The rim of a spot light has kinks where the inner cone begins and ends, so the integral is split there: before the inner
     * cone, behind it, and in it. */
    if (VXS_AIR_IS_SPOT(ray)) {
        first = vxs_air_more(begin, VXS_FIELD(ray, cone)[0]);
        last  = vxs_air_less(begin + length, VXS_FIELD(ray, cone)[1]);
        full  = vxs_air_more(first, VXS_FIELD(ray, full)[0]);
        faded = vxs_air_less(last, VXS_FIELD(ray, full)[1]);
        if (faded <= full) full = faded = first;
        rest = faded - full;
    }
    for (vxs_i32 n = VXS_AIR_IS_SPOT(ray) ? 0 : 2; n < 3; n++) { /* one call, because it is inlined */
        vxs_real from = n == 1 ? faded : n == 0 ? first : full;
        vxs_real part = n == 1 ? last - faded : n == 0 ? full - first : rest;
        if (part > 0.0) vxs_air_add(medium, ray, from, part, airlight);
    }
    vxs_air_finish(medium, ray, airlight);
}

/* (1 - exp(-x)) / x, x >= 0 */
VXS_FN vxs_real vxs_air_mean_left(const vxs_real x)
{
    vxs_real mean = 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0))));
    if (!(x < 0.02)) mean = (1.0 - exp(-x)) / x;
    return mean;
}

/* Mean of exp(-dense * way), where the path length `way` at the middle varies linearly by `change` in all. */
VXS_FN vxs_real vxs_air_mean_about(const vxs_real dense, const vxs_real way, const vxs_real change)
{
    vxs_real nearer = vxs_air_more(way - 0.5 * change, VXS_REAL(0.0)); /* no exponent is positive */
    return exp(-dense * nearer) * vxs_air_mean_left(dense * change);
}

/* Light that scatters at x has a path of length way + slope * (x - begin) through the medium, up to the eye. Without a top of
 * the fog, way = begin and slope = 1: extinction before x is part of the sun's colour. With a top, for a ray that is in fog from
 * `in` on, and a sun in direction to_sun, of length 1: way = begin - in + (top - height at begin) / to_sun.y, slope = 1 - up /
 * to_sun.y.
 * cosine    between the ray and the direction to the sun
 * length    of the part of the ray, >= 0, finite
 * airlight  [out] */
VXS_FN void vxs_air_sun(VXS_MEDIUM medium, const vxs_real cosine, const vxs_real length, const vxs_real way, const vxs_real slope,
                        VXS_OUT vxs_real3 airlight)
{
    vxs_real phase  = vxs_air_phase(VXS_FIELD(medium, anisotropy), cosine) * length;
    vxs_real nearer = slope < 0.0 ? way + slope * length : way, change = vxs_abs(slope) * length; /* no exponent is positive */
    if (nearer < 0.0) nearer = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real dense = VXS_FIELD(medium, extinction)[n];
        airlight[n]    = VXS_FIELD(medium, scattering)[n] * phase * exp(-dense * nearer) * vxs_air_mean_left(dense * change);
    }
}

#endif
