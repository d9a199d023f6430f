/* The path of an eye ray in the light of a sun, a spot or a point light, in fog that may have a level top: one text for C99,
 * C++, GLSL and HLSL. Built on vxs_air.h.
 *
 *     vxs_air_path_of    the part of the ray that can scatter the light: in fog, in the cone, in range
 *     vxs_air_seen_to    its end, where extinction leaves nothing of its light
 *     vxs_air_lit        airlight of the path between two points, if all of it is lit
 *     vxs_air_at         airlight per metre at a point: the integrand
 *     vxs_air_step       airlight per metre, averaged over a step, for marches
 *
 * Units are those of vxs_air.h. A technique for shadows in fog finds which parts of the path are lit; it needs no more of media
 * and lights than this file.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AIR_PATH_H
#define VXS_AIR_PATH_H

#ifndef VXS_AIR_H /* a shader that cannot include has it already */
#include "vxs_air.h"
#endif

#ifdef VXS_C
typedef struct vxs_air_path vxs_air_path;
#define VXS_AIR_PATH const vxs_air_path *
#else
#define VXS_AIR_PATH const vxs_air_path
#endif

struct vxs_air_path {
    vxs_real    begin, end; /* metres along the ray; end <= begin: empty */
    vxs_u32     kind;
    vxs_air_ray passed;             /* punctual lights */
    vxs_real    cosine, way, slope; /* sun: as for vxs_air_sun; way at begin */
};

/* Clip to a sphere about the light. */
VXS_FN void vxs_air_in_range(const vxs_real along, const vxs_real beside2, const vxs_real range, VXS_INOUT vxs_real2 part)
{
    vxs_real half_length = sqrt(vxs_air_more(range * range - beside2, VXS_REAL(0.0)));
    part[0]              = vxs_air_more(along - half_length, part[0]);
    part[1]              = vxs_air_less(along + half_length, part[1]);
}

/* eye        position, metres
 * direction  of the ray, of length 1
 * metres     to the surface behind the air, >= 0, finite
 * top        height (along y) of the level top of the fog; VXS_AIR_EVERYWHERE: no top
 * in_fog     [out] the part of the ray in fog: its length, if positive, dims the light of the surface */
VXS_FN vxs_air_path vxs_air_path_of(VXS_AIR_LIGHT light, const vxs_real3 eye, const vxs_real3 direction, const vxs_real metres,
                                    const vxs_real top, VXS_OUT vxs_real2 in_fog)
{
    vxs_air_path path;
    vxs_real3    to_light;
    in_fog[0] = VXS_REAL(0.0);
    in_fog[1] = metres;
#ifndef VXS_ONLY_EVERYWHERE
    if (VXS_AIR_HAS_TOP(top)) vxs_air_in_fog(eye[1], direction[1], top, in_fog);
#endif
    path.begin  = in_fog[0];
    path.end    = in_fog[1];
    path.kind   = VXS_FIELD(light, kind);
    path.cosine = path.slope = VXS_REAL(1.0);
    path.way                 = path.begin;
    for (vxs_i32 n = 0; n < 3; n++)
        to_light[n] = VXS_FIELD(light, place)[n] - (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL ? VXS_REAL(0.0) : eye[n]);
#ifdef VXS_HAS_SUNS
    if (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL) {
#ifdef VXS_C
        path.passed = vxs_air_ray_of(to_light, direction, VXS_REAL(1.0)); /* not used */
#endif
        path.cosine = vxs_air_dot(direction, to_light);
#ifndef VXS_ONLY_EVERYWHERE
        /* light from below the horizon would have crossed infinite fog */
        if (VXS_AIR_HAS_TOP(top) && !(to_light[1] > 0.0)) path.end = path.begin;
        if (VXS_AIR_HAS_TOP(top) && to_light[1] > 0.0) {
            path.way   = (top - eye[1] - direction[1] * path.begin) / to_light[1];
            path.slope = 1.0 - direction[1] / to_light[1];
        }
#endif
    }
#endif
#ifdef VXS_HAS_PUNCTUAL
    if (VXS_KIND(light) != VXS_LIGHT_KIND_DIRECTIONAL) {
        vxs_real2 part;
#if !defined(VXS_ONLY_KIND) || VXS_ONLY_KIND == 3
        if (VXS_KIND(light) == VXS_LIGHT_KIND_POINT)
            path.passed = vxs_air_ray_of(to_light, direction, VXS_FIELD(light, radius_metres));
#endif
#if !defined(VXS_ONLY_KIND) || VXS_ONLY_KIND != 3
        if (VXS_KIND(light) != VXS_LIGHT_KIND_POINT)
            path.passed = vxs_air_ray_of_spot(to_light, direction, VXS_FIELD(light, radius_metres), VXS_FIELD(light, axis),
                                              VXS_FIELD(light, cos_inner), VXS_FIELD(light, cos_outer));
#endif
        part[0] = vxs_air_more(path.begin, path.passed.cone[0]);
        part[1] = vxs_air_less(path.end, path.passed.cone[1]);
#ifndef VXS_ONLY_EVERYWHERE
        if (VXS_AIR_HAS_TOP(top)) vxs_air_below_top(VXS_REF(path.passed), to_light[1], direction[1], top - eye[1], in_fog[0]);
#endif
        if (VXS_FIELD(light, range_metres) > 0.0) {
            path.passed.per_range = 1.0 / VXS_FIELD(light, range_metres);
            vxs_air_in_range(path.passed.along, path.passed.beside * path.passed.beside, VXS_FIELD(light, range_metres), part);
        }
        path.begin = part[0];
        path.end   = vxs_air_more(part[1], part[0]);
    }
#endif
    return path;
}

/* The point of the path from which on less than e^-depth of its airlight can come, by extinction in all channels. Marches and
 * walks can stop there. At most the path's end.
 * depth  optical depth more than at the begin */
VXS_FN vxs_real vxs_air_seen_to(VXS_MEDIUM medium, VXS_AIR_PATH path, const vxs_real depth)
{
    vxs_real begin = VXS_FIELD(path, begin), end = VXS_FIELD(path, end), thinnest = vxs_air_thinnest(medium), seen = end;
    if (thinnest * (end - begin) > 0.0) {
        vxs_real more = depth / thinnest;
#ifdef VXS_HAS_SUNS
        if (VXS_KIND(path) == VXS_LIGHT_KIND_DIRECTIONAL && VXS_FIELD(path, slope) * (end - begin) > more)
            seen = begin + more / VXS_FIELD(path, slope);
#endif
#ifdef VXS_HAS_PUNCTUAL
        if (VXS_KIND(path) != VXS_LIGHT_KIND_DIRECTIONAL) {
            vxs_real detour = vxs_air_detour(VXS_REF_OF(path, passed), begin - VXS_FIELD(path, passed).along) + more;
            seen            = vxs_air_place_of(VXS_REF_OF(path, passed), detour);
#ifndef VXS_ONLY_EVERYWHERE
            if (VXS_AIR_IS_BELOW(VXS_REF_OF(path, passed))) {
                /* bounded by the path to the eye alone: the path to the light may get shorter */
                vxs_real fog = VXS_FIELD(path, passed).in_fog, way = vxs_air_way_at(VXS_REF_OF(path, passed), begin - fog);
                seen = fog + vxs_air_less(way, vxs_air_way_at(VXS_REF_OF(path, passed), end - fog)) + more;
            }
#endif
            seen = vxs_air_less(seen, end);
        }
#endif
    }
    return seen;
}

/* Airlight of the path's part in [begin, end], if all of it is lit.
 * airlight  [out] for an intensity or irradiance of 1; finite, >= 0 */
VXS_FN void vxs_air_lit(VXS_MEDIUM medium, VXS_AIR_PATH path, const vxs_real begin, const vxs_real end, VXS_OUT vxs_real3 airlight)
{
    vxs_real first = vxs_air_more(begin, VXS_FIELD(path, begin)), last = vxs_air_less(end, VXS_FIELD(path, end));
    airlight[0] = airlight[1] = airlight[2] = VXS_REAL(0.0);
    if (last > first) {
#ifdef VXS_HAS_SUNS
        if (VXS_KIND(path) == VXS_LIGHT_KIND_DIRECTIONAL)
            vxs_air_sun(medium, VXS_FIELD(path, cosine), last - first,
                        VXS_FIELD(path, way) + VXS_FIELD(path, slope) * (first - VXS_FIELD(path, begin)), VXS_FIELD(path, slope),
                        airlight);
#endif
#ifdef VXS_HAS_PUNCTUAL
        if (VXS_KIND(path) != VXS_LIGHT_KIND_DIRECTIONAL)
            vxs_air_punctual(medium, VXS_REF_OF(path, passed), first, last - first, airlight);
#endif
    }
    for (vxs_i32 i = 0; i < 3; i++)
        airlight[i] = vxs_air_more(VXS_REAL(0.0), airlight[i]); /* differences of nearly equal numbers */
}

/* Light per metre that scatters toward the eye at x, without extinction.
 * way  [out] length of the path through the medium over x, and its derivative */
VXS_FN vxs_real vxs_air_strength_at(VXS_MEDIUM medium, VXS_AIR_PATH path, const vxs_real x, VXS_OUT vxs_real2 way)
{
    vxs_real cosine = VXS_FIELD(path, cosine), strength = VXS_REAL(1.0), distance2 = VXS_REAL(1.0);
#ifdef VXS_HAS_SUNS
    if (VXS_KIND(path) == VXS_LIGHT_KIND_DIRECTIONAL) {
        way[1] = VXS_FIELD(path, slope);
        way[0] = VXS_FIELD(path, way) + way[1] * (x - VXS_FIELD(path, begin));
    }
#endif
#ifdef VXS_HAS_PUNCTUAL
    if (VXS_KIND(path) != VXS_LIGHT_KIND_DIRECTIONAL) {
        vxs_real h = VXS_FIELD(path, passed).beside, y = x - VXS_FIELD(path, passed).along, r = sqrt(h * h + y * y);
        vxs_real metres = x - VXS_FIELD(path, passed).in_fog;
        if (VXS_AIR_HAS_RIM)
            strength =
                vxs_air_rim_at(VXS_REF_OF(path, passed), (VXS_FIELD(path, passed).before + y * VXS_FIELD(path, passed).facing) / r);
        strength *= vxs_air_window(r, VXS_FIELD(path, passed).per_range);
        way[0]    = vxs_air_way(VXS_REF_OF(path, passed), metres, r);
        way[1]    = vxs_air_way_rate(VXS_REF_OF(path, passed), metres, r, y / r);
        cosine    = -y / r;
        distance2 = r * r;
    }
#endif
    return strength * vxs_air_phase(VXS_FIELD(medium, anisotropy), cosine) / distance2;
}

/* Airlight per metre at x, on the path. */
VXS_FN void vxs_air_at(VXS_MEDIUM medium, VXS_AIR_PATH path, const vxs_real x, VXS_OUT vxs_real3 airlight)
{
    vxs_real2 way;
    vxs_real  strength = vxs_air_strength_at(medium, path, x, way);
    if (way[0] < 0.0) way[0] = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 3; n++)
        airlight[n] = VXS_FIELD(medium, scattering)[n] * strength * exp(-VXS_FIELD(medium, extinction)[n] * way[0]);
}

/* The same, averaged over a step of `metres` about x. Transmittance is averaged, so that in thick fog long steps give the same
 * airlight as short ones. */
VXS_FN void vxs_air_step(VXS_MEDIUM medium, VXS_AIR_PATH path, const vxs_real x, const vxs_real metres, VXS_OUT vxs_real3 airlight)
{
    vxs_real2 way;
    vxs_real  strength = vxs_air_strength_at(medium, path, x, way), change = vxs_abs(way[1]) * metres;
    for (vxs_i32 n = 0; n < 3; n++)
        airlight[n] =
            VXS_FIELD(medium, scattering)[n] * strength * vxs_air_mean_about(VXS_FIELD(medium, extinction)[n], way[0], change);
}

#endif
