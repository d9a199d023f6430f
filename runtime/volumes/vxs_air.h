/* Light that a homogeneous medium scatters toward the eye, along a part of an eye ray that is all lit: one text for C99, C++, GLSL and
 * HLSL, that stands on vxs_space.h.
 *
 *     vxs_air_ray_of       how an eye ray passes a lamp
 *     vxs_air_in_cone      the part of the ray in a spot light's cone; vxs_air_before_face: before a face that shines to one side
 *     vxs_air_lamp         airlight of a spot or point light along a part of the ray
 *     vxs_air_in_fog       the part of the ray below the top of ground fog
 *     vxs_air_sun          airlight of the sun along a part of the ray
 *     vxs_air_left         what the medium leaves of what is behind it
 *     vxs_air_phase        the phase function: Henyey and Greenstein
 *
 * Distances are metres along the ray, whose direction has length 1, from the eye; the medium's numbers are per metre and colour channel.
 * Airlight is radiance for an intensity (lamps: candela, per steradian) or an irradiance (the sun: lux) of 1 in each channel: times the
 * light's colour it is what the eye sees.
 *
 *     lamp             Light that turns toward the eye at x has gone the way x + r, r from the lamp to there. That is `along` and a detour
 *       *              d = r + x - along, which only grows with x. For h = beside,
 *       |`.  r
 *     h |  `.              r = (d^2 + h^2) / 2d        x = along + (d^2 - h^2) / 2d        d / h = tan(half the angle of scattering)
 *       |    `.
 *     --+------+-->  w Of an angle b with tan b = k d / h, k = (1 + g) / (1 - g), phase and falloff together are
 *     along    x
 *                          p / r^2 dx = sqrt((h^2 + d^2) / (h^2 + k^2 d^2)) / (2 pi h (1 - g)) db
 *
 *                      which is smooth and near to constant however sharp the phase is, and so is quadrature in b. No exponent is positive,
 *                      and nothing is a difference of what is nearly equal.
 *
 * The segment is cut where the detour has cost 1, 5, 21... units of optical depth, and ends at 24. Relative error, of 10^5 random rays of
 * any optical depth from 1e-6 to 1e4 and g from -0.99 to 0.99: docs/volumes.md.
 * Source: [Sun 2005] for airlight by angles; [Billeter 2010] for the sum over lit segments. The variable b is ours.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AIR_H
#define VXS_AIR_H

#ifndef VXS_SPACE_H /* a shader that cannot include has it already */
#include "vxs_space.h"
#endif

#ifdef VXS_C
typedef struct vxs_medium   vxs_medium;
typedef struct vxs_air_ray  vxs_air_ray;
typedef struct vxs_air_part vxs_air_part;
typedef vxs_real            vxs_real2[2];
#define VXS_MEDIUM   const vxs_medium *
#define VXS_AIR_RAY  const vxs_air_ray *
#define VXS_AIR_PART const vxs_air_part *
#else
#ifdef VXS_HLSL
#define vxs_real2 float2
#else
#define vxs_real2 vec2
#endif
#define VXS_MEDIUM   vxs_medium
#define VXS_AIR_RAY  vxs_air_ray
#define VXS_AIR_PART vxs_air_part
#endif

/* What fills the air. */
struct vxs_medium {
    vxs_real3 scattering; /* of light that goes a metre, how much turns; >= 0, finite */
    vxs_real3 extinction; /* how much turns or is absorbed; >= scattering, finite */
    vxs_real  anisotropy; /* g of the phase function, -0.99 (back to where it came from) to 0.99 (on the same way) */
};

/* How an eye ray passes a lamp. */
struct vxs_air_ray {
    vxs_real along;      /* where it is nearest to the lamp; negative: behind the eye */
    vxs_real beside;     /* how near that is, but no less than the lamp's radius; > 0 */
    vxs_real facing;     /* cosine between the ray and a spot light's axis */
    vxs_real before;     /* metres along the axis from the lamp to that place */
    vxs_real cos_outer;  /* of the cone; point lights: -1 */
    vxs_real cos_inner;  /* of where it is dimmer, as in glTF: intensity is clamp(cosine * rim_scale + rim_offset, 0, 1)^2 */
    vxs_real rim_scale;  /* point lights: 0, */
    vxs_real rim_offset; /* and 1 */
    vxs_i32  is_face;    /* 1: that clamp is not squared (vxs_air_ray_of_face) */
};

#define VXS_AIR_PI        3.14159265358979324
#define VXS_AIR_DEPTH_MAX 24.0 /* units of optical depth behind which nothing is seen: e^-24 */
#define VXS_AIR_PARTS     12

VXS_FN vxs_real vxs_air_dot(const vxs_real3 a, const vxs_real3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* cosine  between the ways of light before and behind */
VXS_FN vxs_real vxs_air_phase(vxs_real g, vxs_real cosine)
{
    vxs_real wide = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine);
    return (1.0 - g * g) / (4.0 * VXS_AIR_PI * wide * sqrt(wide));
}

/* to_lamp       from the eye, metres;   direction  of the ray, of length 1
 * radius_metres of the lamp, > 0: airlight has no bound where a ray meets a light that is a point */
VXS_FN vxs_air_ray vxs_air_ray_of(const vxs_real3 to_lamp, const vxs_real3 direction, vxs_real radius_metres)
{
    vxs_air_ray ray;
    vxs_real    x = to_lamp[1] * direction[2] - to_lamp[2] * direction[1];
    vxs_real    y = to_lamp[2] * direction[0] - to_lamp[0] * direction[2];
    vxs_real    z = to_lamp[0] * direction[1] - to_lamp[1] * direction[0];
    vxs_real    h = sqrt(x * x + y * y + z * z);
    ray.along     = vxs_air_dot(to_lamp, direction);
    ray.beside    = h > radius_metres ? h : radius_metres;
    ray.facing = ray.before = VXS_REAL(0.0);
    ray.cos_outer = ray.cos_inner = VXS_REAL(-1.0);
    ray.rim_scale                 = VXS_REAL(0.0);
    ray.rim_offset                = VXS_REAL(1.0);
    ray.is_face                   = 0;
    return ray;
}

/* The same of a spot light.   axis  where it shines, of length 1;   cos_inner >= cos_outer >= 0 */
VXS_FN vxs_air_ray vxs_air_ray_of_spot(const vxs_real3 to_lamp, const vxs_real3 direction, vxs_real radius_metres,
                                       const vxs_real3 axis, vxs_real cos_inner, vxs_real cos_outer)
{
    vxs_air_ray ray = vxs_air_ray_of(to_lamp, direction, radius_metres);
    ray.facing      = vxs_air_dot(axis, direction);
    ray.before      = ray.along * ray.facing - vxs_air_dot(axis, to_lamp);
    ray.cos_outer   = cos_outer;
    ray.cos_inner   = cos_inner > cos_outer + 1e-3 ? cos_inner : cos_outer + 1e-3;
    ray.rim_scale   = 1.0 / (ray.cos_inner - cos_outer);
    ray.rim_offset  = -cos_outer * ray.rim_scale;
    return ray;
}

/* The same of a small face that shines to one side, with the cosine to its normal, of length 1. Behind it there is nothing: vxs_air_before_face. */
VXS_FN vxs_air_ray vxs_air_ray_of_face(const vxs_real3 to_lamp, const vxs_real3 direction, vxs_real radius_metres,
                                       const vxs_real3 normal)
{
    vxs_air_ray ray = vxs_air_ray_of(to_lamp, direction, radius_metres);
    ray.facing      = vxs_air_dot(normal, direction);
    ray.before      = ray.along * ray.facing - vxs_air_dot(normal, to_lamp);
    ray.rim_scale   = VXS_REAL(1.0);
    ray.rim_offset  = VXS_REAL(0.0);
    ray.is_face     = 1;
    return ray;
}

/* interval  [in, out] its part before a face; end < begin: there is none */
VXS_FN void vxs_air_before_face(VXS_AIR_RAY ray, VXS_INOUT vxs_real2 interval)
{
    vxs_real f = VXS_FIELD(ray, facing), b = VXS_FIELD(ray, before), at = VXS_FIELD(ray, along) - b / f;
    if (f > 0.0 && at > interval[0]) interval[0] = at;
    if (f < 0.0 && at < interval[1]) interval[1] = at;
    if (f == 0.0 && !(b > 0.0)) interval[1] = interval[0] - 1.0;
}

/* How much longer the way over a place of the ray is than `along`; y = x - along. */
VXS_FN vxs_real vxs_air_detour(VXS_AIR_RAY ray, vxs_real y)
{
    vxs_real h = VXS_FIELD(ray, beside), r = sqrt(h * h + y * y);
    return y > 0.0 ? r + y : h * (h / (r - y));
}

/* Where facing * y + before >= cosine * r, y = x - along: between the roots of a quadratic, or beyond one of them.
 * cosine    of the angle between the axis of a spot light and its cone, >= 0
 * interval  [in, out] its part in the cone; end < begin: there is none */
VXS_FN void vxs_air_in_cone(VXS_AIR_RAY ray, vxs_real cosine, VXS_INOUT vxs_real2 interval)
{
    vxs_real c = cosine, f = VXS_FIELD(ray, facing), b = VXS_FIELD(ray, before), h = VXS_FIELD(ray, beside);
    vxs_real a = (f - c) * (f + c), square = b * b + a * h * h;
    if (square < 0.0) {
        interval[1] = interval[0] - 1.0;
        return;
    }
    vxs_real half_sum =
        -(f * b + (f * b < 0.0 ? -c : c) * sqrt(square)); /* roots half_sum / a and the other coefficient / half_sum */
    vxs_real first = half_sum / a, second = (b - c * h) * (b + c * h) / half_sum;
    vxs_real low = first < second ? first : second, high = first < second ? second : first, along = VXS_FIELD(ray, along);
    if (a > 0.0) { /* from one of them on, the ray stays in the cone */
        if (f > 0.0 && along + high > interval[0]) interval[0] = along + high;
        if (f <= 0.0 && along + low < interval[1]) interval[1] = along + low;
    } else if (a < 0.0 && f * (low + high) + 2.0 * b >= 0.0) {
        if (along + low > interval[0]) interval[0] = along + low;
        if (along + high < interval[1]) interval[1] = along + high;
    } else
        interval[1] = interval[0] - 1.0;
}

/* x in [0, pi / 2], to 4e-6 of it: shading languages promise no relative error. */
VXS_FN vxs_real vxs_air_sine(vxs_real x)
{
    vxs_real s = x * x;
    return x * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s * (1.0 / 362880.0)))));
}

/* atan(y / x) in [0, pi / 2] of what is not negative, to 1e-6 of it: halved twice, then a series. */
VXS_FN vxs_real vxs_air_angle(vxs_real y, vxs_real x)
{
    vxs_real most = y > x ? y : x;
    if (!(most > 0.0)) return VXS_REAL(0.0);
    vxs_real v = y / most, u = x / most, t = v / (u + sqrt(u * u + v * v));
    t          = t / (1.0 + sqrt(1.0 + t * t));
    vxs_real s = t * t;
    return 4.0 * t *
           (1.0 + s * (-1.0 / 3.0 + s * (1.0 / 5.0 + s * (-1.0 / 7.0 + s * (1.0 / 9.0 + s * (-1.0 / 11.0 + s * (1.0 / 13.0)))))));
}

/* Gauss-Legendre quadrature of 2, 4 or 8 nodes, in pairs about the middle: how far from it a node lies, of half a part, and its weight. */
VXS_FN vxs_real vxs_air_offset(vxs_i32 pairs, vxs_i32 n)
{
    if (pairs == 1) return VXS_REAL(0.5773502691896258);
    if (pairs == 2) return n == 0 ? VXS_REAL(0.3399810435848563) : VXS_REAL(0.8611363115940526);
    if (n < 2) return n == 0 ? VXS_REAL(0.1834346424956498) : VXS_REAL(0.5255324099163290);
    return n == 2 ? VXS_REAL(0.7966664774136267) : VXS_REAL(0.9602898564975362);
}

VXS_FN vxs_real vxs_air_weight(vxs_i32 pairs, vxs_i32 n)
{
    if (pairs == 1) return VXS_REAL(1.0);
    if (pairs == 2) return n == 0 ? VXS_REAL(0.6521451548625461) : VXS_REAL(0.3478548451374539);
    if (n < 2) return n == 0 ? VXS_REAL(0.3626837833783620) : VXS_REAL(0.3137066458778873);
    return n == 2 ? VXS_REAL(0.2223810344533745) : VXS_REAL(0.1012285362903763);
}

/* A stretch of the ray, by the detours at its ends. */
struct vxs_air_part {
    vxs_real detour, more;         /* at its begin; what is added to its end */
    vxs_real wide;                 /* the angle b between them */
    vxs_real near_begin, near_end; /* cos b of each */
};

VXS_FN vxs_air_part vxs_air_part_of(VXS_AIR_RAY ray, vxs_real k, vxs_real detour, vxs_real more)
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

/* k, by which b is as even as it gets. */
VXS_FN vxs_real vxs_air_sharpness(VXS_MEDIUM medium)
{
    return (1.0 + VXS_FIELD(medium, anisotropy)) / (1.0 - VXS_FIELD(medium, anisotropy));
}

/* The part between two places of the ray: the detour at its begin, and what is more at its end, without a difference of what is nearly equal. */
VXS_FN vxs_air_part vxs_air_part_between(VXS_AIR_RAY ray, vxs_real k, vxs_real begin, vxs_real length)
{
    vxs_real h = VXS_FIELD(ray, beside), y = begin - VXS_FIELD(ray, along), end = y + length;
    vxs_real detour = vxs_air_detour(ray, y), sum_of_r = sqrt(h * h + y * y) + sqrt(h * h + end * end);
    return vxs_air_part_of(ray, k, detour, length * ((detour + vxs_air_detour(ray, end)) / sum_of_r));
}

/* Where a detour is so long: metres along the ray. */
VXS_FN vxs_real vxs_air_place_of(VXS_AIR_RAY ray, vxs_real detour)
{
    vxs_real h = VXS_FIELD(ray, beside);
    return VXS_FIELD(ray, along) + 0.5 * (detour - h * (h / detour));
}

/* The detour at a share of the part's angle. The direction between two is their sum, weighed by sines: no term is negative. */
VXS_FN vxs_real vxs_air_detour_at(VXS_AIR_PART part, vxs_real share)
{
    vxs_real wide = VXS_FIELD(part, wide), first = 1.0 - share, second = share;
    if (wide > 1e-3) {
        first  = vxs_air_sine(first * wide);
        second = vxs_air_sine(second * wide);
    }
    first *= VXS_FIELD(part, near_begin);
    second *= VXS_FIELD(part, near_end);
    return VXS_FIELD(part, detour) + VXS_FIELD(part, more) * (second / (first + second));
}

/* What a node adds: phase and falloff but for what is the same at all nodes, a spot light's rim, and what is lost on the way. */
VXS_FN void vxs_air_add_node(VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real k, vxs_real detour, vxs_real weight,
                             VXS_INOUT vxs_real3 sum)
{
    vxs_real ratio = VXS_FIELD(ray, beside) / detour, square = ratio * ratio, way = VXS_FIELD(ray, along) + detour;
    vxs_real rim = ((1.0 - square) * VXS_FIELD(ray, facing) + 2.0 * (VXS_FIELD(ray, before) / detour)) / (1.0 + square);
    rim          = rim * VXS_FIELD(ray, rim_scale) + VXS_FIELD(ray, rim_offset);
    rim          = rim < 0.0 ? VXS_REAL(0.0) : rim > 1.0 ? VXS_REAL(1.0) : rim;
    rim *= VXS_FIELD(ray, is_face) != 0 ? VXS_REAL(1.0) : rim;
    weight *= rim * sqrt((1.0 + square) / (k * k + square));
    sum[0] += weight * exp(-VXS_FIELD(medium, extinction)[0] * way);
    sum[1] += weight * exp(-VXS_FIELD(medium, extinction)[1] * way);
    sum[2] += weight * exp(-VXS_FIELD(medium, extinction)[2] * way);
}

/* As many nodes as it changes: by what is lost, by b, and by d / (d + h), where b says little because k is great.
 * depth  optical, of the part, of the densest channel */
VXS_FN void vxs_air_add_part(VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real k, VXS_AIR_PART part, vxs_real depth,
                             VXS_INOUT vxs_real3 sum)
{
    vxs_real wide = VXS_FIELD(part, wide), h = VXS_FIELD(ray, beside), begin = h + VXS_FIELD(part, detour);
    vxs_real turn   = (h / begin) * (VXS_FIELD(part, more) / (begin + VXS_FIELD(part, more)));
    vxs_real change = depth + (wide > turn ? wide : turn) * (1.0 + VXS_FIELD(ray, rim_scale));
    vxs_i32  pairs  = change < 0.1 ? 1 : change < 0.7 ? 2 : 4;
    for (vxs_i32 n = 0; n < pairs; n++) {
        vxs_real offset = 0.5 * vxs_air_offset(pairs, n), weight = 0.5 * vxs_air_weight(pairs, n) * wide;
        vxs_air_add_node(medium, ray, k, vxs_air_detour_at(part, 0.5 - offset), weight, sum);
        vxs_air_add_node(medium, ray, k, vxs_air_detour_at(part, 0.5 + offset), weight, sum);
    }
}

/* Add the airlight of [begin, begin + length), but for what does not depend on it. */
VXS_FN void vxs_air_add(VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real begin, vxs_real length, VXS_INOUT vxs_real3 sum)
{
    vxs_real     h = VXS_FIELD(ray, beside), k = vxs_air_sharpness(medium), most = VXS_REAL(0.0), least = most;
    vxs_air_part whole  = vxs_air_part_between(ray, k, begin, length);
    vxs_real     detour = whole.detour, rest = whole.more;
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real dense = VXS_FIELD(medium, extinction)[n];
        most           = dense > most ? dense : most;
        least          = n == 0 || dense < least ? dense : least;
    }
    if (rest * least > VXS_AIR_DEPTH_MAX) rest = VXS_AIR_DEPTH_MAX / least;
    vxs_real depth = VXS_REAL(1.0), sharp = h / sqrt(k), cut = sharp < h ? sharp : h, next = sharp < h ? h : sharp;
    for (vxs_i32 n = 1; rest > 0.0 && n <= VXS_AIR_PARTS; n++) {
        vxs_real more = rest;
        if (n < VXS_AIR_PARTS) {
            if (more * most > 1.5 * depth) more = depth / most;
            if (detour < cut && detour + more > cut)
                more = cut - detour;
            else if (detour < next && detour + more > next)
                more = next - detour;
        }
        vxs_air_part part = vxs_air_part_of(ray, k, detour, more);
        vxs_air_add_part(medium, ray, k, VXS_REF(part), most * more, sum);
        if (more * most >= depth) depth *= 4.0;
        detour += more;
        rest -= more;
    }
}

/* What a sum of nodes is times, for an intensity of 1. */
VXS_FN vxs_real vxs_air_node_scale(VXS_MEDIUM medium, VXS_AIR_RAY ray)
{
    return 1.0 / (2.0 * VXS_AIR_PI * (1.0 - VXS_FIELD(medium, anisotropy)) * VXS_FIELD(ray, beside));
}

/* Add what a spot light lights before its inner cone and behind it: at the ends of that its rim has kinks. What lies in the inner cone is
 * left to the caller; of a point light, all.
 * part  [in, out] begin and length; a length that is not positive: nothing is left */
VXS_FN void vxs_air_add_rims(VXS_MEDIUM medium, VXS_AIR_RAY ray, VXS_INOUT vxs_real2 part, VXS_INOUT vxs_real3 sum)
{
    vxs_real2 lit, full;
    if (VXS_FIELD(ray, cos_outer) < 0.0) return;
    lit[0] = part[0];
    lit[1] = part[0] + part[1];
    vxs_air_in_cone(ray, VXS_FIELD(ray, cos_outer), lit);
    full[0] = lit[0];
    full[1] = lit[1];
    vxs_air_in_cone(ray, VXS_FIELD(ray, cos_inner), full);
    if (full[1] <= full[0]) full[0] = full[1] = lit[0];
    if (full[0] > lit[0]) vxs_air_add(medium, ray, lit[0], full[0] - lit[0], sum);
    if (lit[1] > full[1]) vxs_air_add(medium, ray, full[1], lit[1] - full[1], sum);
    part[0] = full[0];
    part[1] = full[1] - full[0];
}

/* What airlight does not owe to its place. */
VXS_FN void vxs_air_finish(VXS_MEDIUM medium, VXS_AIR_RAY ray, VXS_INOUT vxs_real3 sum)
{
    vxs_real scale = vxs_air_node_scale(medium, ray);
    sum[0] *= scale * VXS_FIELD(medium, scattering)[0];
    sum[1] *= scale * VXS_FIELD(medium, scattering)[1];
    sum[2] *= scale * VXS_FIELD(medium, scattering)[2];
}

/* begin, length  of the part of the ray, >= 0, finite; of a spot light's, what lies in its cone counts
 * airlight       [out] */
VXS_FN void vxs_air_lamp(VXS_MEDIUM medium, VXS_AIR_RAY ray, vxs_real begin, vxs_real length, VXS_OUT vxs_real3 airlight)
{
    vxs_real2 part;
    part[0]     = begin;
    part[1]     = length;
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    vxs_air_add_rims(medium, ray, part, airlight);
    if (part[1] > 0.0) vxs_air_add(medium, ray, part[0], part[1], airlight);
    vxs_air_finish(medium, ray, airlight);
}

/* The part of a ray that is in fog whose top is level: height, top and up are the eye's, the fog's, and the ray's along the vertical.
 * interval  [in, out] end < begin: there is none */
VXS_FN void vxs_air_in_fog(vxs_real height, vxs_real up, vxs_real top, VXS_INOUT vxs_real2 interval)
{
    vxs_real at = (top - height) / up;
    if (up > 0.0 && at < interval[1]) interval[1] = at;
    if (up < 0.0 && at > interval[0]) interval[0] = at;
    if (up == 0.0 && height > top) interval[1] = interval[0] - 1.0;
}

/* (1 - exp(-x)) / x, x >= 0 */
VXS_FN vxs_real vxs_air_mean_left(vxs_real x)
{
    if (x < 0.02) return 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0))));
    return (1.0 - exp(-x)) / x;
}

/* The light that reaches x and turns there has gone way + slope * (x - begin) through the medium until it meets the eye. Without a top of
 * the fog, way = begin and slope = 1: what it went before is in the sun's colour. Below a top, for a ray that is in fog from `in` on and a sun
 * that stands at to_sun, of length 1, way = begin - in + (top - height at begin) / to_sun.y, slope = 1 - up / to_sun.y.
 * cosine         between the ray and the way to the sun
 * begin, length  of the part of the ray: length >= 0, finite
 * airlight       [out] */
VXS_FN void vxs_air_sun(VXS_MEDIUM medium, vxs_real cosine, vxs_real length, vxs_real way, vxs_real slope,
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

/* metres  through the medium;   left  [out] of what is behind it */
VXS_FN void vxs_air_left(VXS_MEDIUM medium, vxs_real metres, VXS_OUT vxs_real3 left)
{
    for (vxs_i32 n = 0; n < 3; n++) left[n] = exp(-VXS_FIELD(medium, extinction)[n] * metres);
}

#endif
