/* An eye ray in a homogeneous medium, relative to a punctual light: one text for C99, C++, GLSL and HLSL. Include
 * vxs_air_light.h first.
 *
 *     vxs_air_ray_of      an eye ray relative to a punctual light
 *     vxs_air_in_cone     the part of the ray in a spot light's cone; vxs_air_before_face: before a face that emits to one side
 *     vxs_air_in_fog      the part of the ray below the level top of ground fog
 *     vxs_air_below_top   prepares a ray for such fog, so that only the path below the top dims light
 *     vxs_air_way         length of the path through the fog, from a punctual light over a point of the ray to the eye
 *
 * Distances are metres along the ray from the eye; the ray's direction has length 1. The numbers of the medium are per metre and
 * colour channel.
 *
 *           * light       Fog with a level top dims light only below the top. From a punctual light above it, light first crosses
 *           clear air:
 *     above |`.           of its path r to a point `below` the top, the share below / (above + below) is in fog.
 *     ------+--`.-----    Light that scatters `metres` behind the point where the ray enters the fog has a path through the fog of
 *           :    `. below
 *       ----------->x-->      metres + r below / (above + below)
 *
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AIR_RAY_H
#define VXS_AIR_RAY_H

#ifndef VXS_AIR_LIGHT_H /* a shader that cannot include has it already */
#include "vxs_air_light.h"
#endif

#ifdef VXS_C
typedef struct vxs_air_ray vxs_air_ray;
#define VXS_AIR_RAY       const vxs_air_ray *
#define VXS_AIR_RAY_INOUT vxs_air_ray *
#else
#define VXS_AIR_RAY       const vxs_air_ray
#define VXS_AIR_RAY_INOUT inout vxs_air_ray
#endif

/* Whether a ray is that of a spot light, and whether its light may have a rim: of point lights, only faces do. A shader defines
 * VXS_AIR_FACES if it has faces. Constants where a shader has one kind of light. */
#if !defined(VXS_ONLY_KIND)
#define VXS_AIR_IS_SPOT(ray) (VXS_FIELD(ray, cos_outer) >= 0.0)
#else
#define VXS_AIR_IS_SPOT(ray) (VXS_U(VXS_ONLY_KIND) != VXS_LIGHT_KIND_POINT)
#endif
#if !defined(VXS_ONLY_KIND) || defined(VXS_AIR_FACES)
#define VXS_AIR_HAS_RIM (0 < 1)
#else
#define VXS_AIR_HAS_RIM VXS_AIR_IS_SPOT(0)
#endif

#define VXS_AIR_ALL 1e30 /* metres: all of a ray lies between this and its negative */

/* An eye ray relative to a punctual light. */
struct vxs_air_ray {
    vxs_real  along;     /* metres along the ray to its point nearest to the light; negative: behind the eye */
    vxs_real  beside;    /* distance of this point from the light, but at least the light's radius; > 0 */
    vxs_real  facing;    /* cosine between the ray and a spot light's axis */
    vxs_real  before;    /* metres from the light to this point, along the axis */
    vxs_real  cos_outer; /* cosine where the cone ends; point lights: -1 */
    /* cosine where the cone starts to fade, as in glTF: intensity is clamp(cosine * rim_scale + rim_offset, 0, 1)^2 */
    vxs_real  cos_inner;
    vxs_real  rim_scale;  /* point lights: 0 */
    vxs_real  rim_offset; /* point lights: 1 */
    vxs_i32   is_face;    /* 1: the clamp is not squared (vxs_air_ray_of_face) */
    /* spot lights: the parts of the ray in the cone, and where it does not fade; from begin to end, end < begin: none */
    vxs_real2 cone, full;

    /* fog with a level top; all 0 without a top */
    vxs_real in_fog; /* metres along the ray to where it enters the fog; 0: the eye is in the fog */
    vxs_real above;  /* height of the light above the top; 0: it is below, and the whole path of its light is in the fog */
    vxs_real below;  /* depth of the ray below the top where it enters the fog */
    vxs_real up;     /* vertical component of the ray's direction */

    vxs_real per_range; /* 1 / range of the light; 0: unlimited */
};

/* to_light        from the eye, metres
 * direction      of the ray, of length 1
 * radius_metres  of the light, > 0: without it, airlight is unbounded where a ray meets a point light */
VXS_FN vxs_air_ray vxs_air_ray_of(const vxs_real3 to_light, const vxs_real3 direction, const vxs_real radius_metres)
{
    vxs_air_ray ray;
    vxs_real3   normal;
    normal[0]  = to_light[1] * direction[2] - to_light[2] * direction[1];
    normal[1]  = to_light[2] * direction[0] - to_light[0] * direction[2];
    normal[2]  = to_light[0] * direction[1] - to_light[1] * direction[0];
    ray.along  = vxs_air_dot(to_light, direction);
    ray.beside = vxs_air_more(sqrt(vxs_air_dot(normal, normal)), radius_metres);
    ray.facing = ray.before = VXS_REAL(0.0);
    ray.cos_outer = ray.cos_inner = VXS_REAL(-1.0);
    ray.rim_scale                 = VXS_REAL(0.0);
    ray.rim_offset                = VXS_REAL(1.0);
    ray.is_face                   = 0;
    ray.in_fog = ray.above = ray.below = ray.up = ray.per_range = VXS_REAL(0.0);
    ray.cone[0] = ray.full[0] = VXS_REAL(-VXS_AIR_ALL);
    ray.cone[1] = ray.full[1] = VXS_REAL(VXS_AIR_ALL);
    return ray;
}

/* Clip to the points where facing * y + before >= cosine * r, y = x - along. These are between the roots of a quadratic
 * equation, or beyond one of them. A ray that is parallel to a side of the cone has one root: a = 0, and the other root is
 * infinitely far away.
 * cosine    of the angle between the axis of a spot light and its cone, >= 0
 * interval  [in, out] clipped to the cone; end < begin: empty */
VXS_FN void vxs_air_in_cone(VXS_AIR_RAY ray, const vxs_real cosine, VXS_INOUT vxs_real2 interval)
{
    vxs_real c = cosine, f = VXS_FIELD(ray, facing), b = VXS_FIELD(ray, before), h = VXS_FIELD(ray, beside);
    vxs_real a = (f - c) * (f + c), square = b * b + a * h * h, along = VXS_FIELD(ray, along);
    vxs_real root = sqrt(vxs_air_more(square, VXS_REAL(0.0))), half_sum = -(f * b + (f * b < 0.0 ? -c : c) * root);
    /* half_sum / a is the root farther from 0; the nearer root is a product divided by half_sum */
    vxs_real near = half_sum != 0.0 ? (b - c * h) * ((b + c * h) / half_sum) : VXS_REAL(0.0), far = a != 0.0 ? half_sum / a : near;
    vxs_real begin = vxs_air_less(near, far), end = vxs_air_more(near, far);
    if (!(a < 0.0)) { /* the ray stays in the cone from one of the roots on, or up to one of them */
        begin = b >= 0.0 ? near : far;
        end   = b > 0.0 ? near : far;
    }
    if (a < 0.0 ? !(square > 0.0 && f * (near + far) + 2.0 * b >= 0.0) : !(a > 0.0 || b > 0.0))
        interval[1] = interval[0] - 1.0;
    else {
        if (a < 0.0 || f > 0.0) interval[0] = vxs_air_more(along + begin, interval[0]);
        if (a < 0.0 || f < 0.0) interval[1] = vxs_air_less(along + end, interval[1]);
    }
}

/* The same for a spot light.   axis  its direction, of length 1;   cos_inner >= cos_outer >= 0 */
VXS_FN vxs_air_ray vxs_air_ray_of_spot(const vxs_real3 to_light, const vxs_real3 direction, const vxs_real radius_metres,
                                       const vxs_real3 axis, const vxs_real cos_inner, const vxs_real cos_outer)
{
    vxs_air_ray ray = vxs_air_ray_of(to_light, direction, radius_metres);
    ray.facing      = vxs_air_dot(axis, direction);
    ray.before      = ray.along * ray.facing - vxs_air_dot(axis, to_light);
    ray.cos_outer   = cos_outer;
    ray.cos_inner   = vxs_air_more(cos_inner, cos_outer + VXS_AIR_RIM_LEAST);
    ray.rim_scale   = 1.0 / (ray.cos_inner - cos_outer);
    ray.rim_offset  = -cos_outer * ray.rim_scale;
    for (vxs_i32 n = 0; n < 2; n++) { /* one call, because it is inlined */
        vxs_real2 part;
        part[0] = VXS_REAL(-VXS_AIR_ALL);
        part[1] = VXS_REAL(VXS_AIR_ALL);
        vxs_air_in_cone(VXS_REF(ray), n == 0 ? ray.cos_outer : ray.cos_inner, part);
        for (vxs_i32 end = 0; end < 2; end++) {
            if (n == 0) ray.cone[end] = part[end];
            ray.full[end] = part[end];
        }
    }
    return ray;
}

/* The same for a small face that emits to one side, with the cosine to its normal, of length 1. It emits nothing behind it:
 * vxs_air_before_face. */
VXS_FN vxs_air_ray vxs_air_ray_of_face(const vxs_real3 to_light, const vxs_real3 direction, vxs_real radius_metres,
                                       const vxs_real3 normal)
{
    vxs_air_ray ray = vxs_air_ray_of(to_light, direction, radius_metres);
    ray.facing      = vxs_air_dot(normal, direction);
    ray.before      = ray.along * ray.facing - vxs_air_dot(normal, to_light);
    ray.rim_scale   = VXS_REAL(1.0);
    ray.rim_offset  = VXS_REAL(0.0);
    ray.is_face     = 1;
    return ray;
}

/* interval  [in, out] clipped to the part before a face; end < begin: empty */
VXS_FN void vxs_air_before_face(VXS_AIR_RAY ray, VXS_INOUT vxs_real2 interval)
{
    vxs_real f = VXS_FIELD(ray, facing), b = VXS_FIELD(ray, before), at = VXS_FIELD(ray, along) - b / f;
    if (f > 0.0 && at > interval[0]) interval[0] = at;
    if (f < 0.0 && at < interval[1]) interval[1] = at;
    if (f == 0.0 && !(b > 0.0)) interval[1] = interval[0] - 1.0;
}

/* Share of the light that the rim leaves.   cosine  between the axis of the light and the direction from it */
VXS_FN vxs_real vxs_air_rim_at(VXS_AIR_RAY ray, const vxs_real cosine)
{
    vxs_real rim = cosine * VXS_FIELD(ray, rim_scale) + VXS_FIELD(ray, rim_offset);
    rim          = vxs_air_less(vxs_air_more(rim, VXS_REAL(0.0)), VXS_REAL(1.0));
    return VXS_FIELD(ray, is_face) != 0 ? rim : rim * rim;
}

/* Detour of the path over a point of the ray: r + x - along; y = x - along. */
VXS_FN vxs_real vxs_air_detour(VXS_AIR_RAY ray, const vxs_real y)
{
    vxs_real h = VXS_FIELD(ray, beside), r = sqrt(h * h + y * y);
    return y > 0.0 ? r + y : h * (h / (r - y));
}

/* Metres along the ray where the detour has this value. */
VXS_FN vxs_real vxs_air_place_of(VXS_AIR_RAY ray, const vxs_real detour)
{
    vxs_real h = VXS_FIELD(ray, beside);
    return VXS_FIELD(ray, along) + 0.5 * (detour - h * (h / detour));
}

/* fog with a level top --------------------------------------------------------------------------------------------------------- */

/* Clip to the part of a ray in fog with a level top.
 * height    of the eye;   up  vertical component of the ray's direction;   top  height of the top
 * interval  [in, out] end < begin: empty */
VXS_FN void vxs_air_in_fog(const vxs_real height, const vxs_real up, const vxs_real top, VXS_INOUT vxs_real2 interval)
{
    vxs_real at = (top - height) / up;
    if (up > 0.0 && at < interval[1]) interval[1] = at;
    if (up < 0.0 && at > interval[0]) interval[0] = at;
    if (up == 0.0 && height > top) interval[1] = interval[0] - 1.0;
}

/* Prepare a ray for fog with a level top: the path above the top is not dimmed.
 * height, top  of the light and of the top, relative to the eye;   up  vertical component of the ray's direction
 * in_fog       metres along the ray to where it enters the fog; 0: the eye is in the fog */
VXS_FN void vxs_air_below_top(VXS_AIR_RAY_INOUT ray, const vxs_real height, const vxs_real up, const vxs_real top,
                              const vxs_real in_fog)
{
    VXS_FIELD(ray, in_fog) = in_fog > 0.0 ? in_fog : VXS_REAL(0.0);
    VXS_FIELD(ray, above)  = height > top ? height - top : VXS_REAL(0.0);
    VXS_FIELD(ray, below)  = in_fog > 0.0 ? VXS_REAL(0.0) : top;
    VXS_FIELD(ray, up)     = up;
}

/* Depth of the ray below the top, after `metres` in the fog. */
VXS_FN vxs_real vxs_air_below_at(VXS_AIR_RAY ray, const vxs_real metres)
{
    return vxs_air_more(VXS_FIELD(ray, below) - VXS_FIELD(ray, up) * metres, VXS_REAL(0.0));
}

/* Length of the path through the fog of light that scatters after `metres` in the fog, at a distance r from the light. It
 * subtracts no nearly equal numbers. */
VXS_FN vxs_real vxs_air_way(VXS_AIR_RAY ray, const vxs_real metres, const vxs_real r)
{
    vxs_real above = VXS_FIELD(ray, above), below = vxs_air_below_at(ray, metres);
    return VXS_AIR_IS_BELOW(ray) ? metres + r * (below / (above + below)) : metres + r;
}

/* Derivative of vxs_air_way along the ray.   slope  of r: y / r */
VXS_FN vxs_real vxs_air_way_rate(VXS_AIR_RAY ray, const vxs_real metres, const vxs_real r, const vxs_real slope)
{
    vxs_real above = VXS_FIELD(ray, above), below = vxs_air_below_at(ray, metres), all = above + below;
    return VXS_AIR_IS_BELOW(ray) ? 1.0 + slope * (below / all) - VXS_FIELD(ray, up) * r * (above / all / all) : 1.0 + slope;
}

VXS_FN vxs_real vxs_air_way_at(VXS_AIR_RAY ray, const vxs_real metres)
{
    vxs_real h = VXS_FIELD(ray, beside), y = metres - (VXS_FIELD(ray, along) - VXS_FIELD(ray, in_fog));
    return vxs_air_way(ray, metres, sqrt(h * h + y * y));
}

#endif
