/* Light in a homogeneous medium: one text for C99, C++, GLSL and HLSL. Built on vxs_space.h.
 *
 *     vxs_air_phase      the phase function of Henyey and Greenstein
 *     vxs_air_left       transmittance of the medium
 *     vxs_air_window     falloff of a punctual light toward the end of its range
 *     vxs_air_rim        falloff of a spot light toward the side of its cone
 *     vxs_air_reaches    unshadowed light at a position
 *
 * Surfaces and air use the same law. Light at a position = intensity / distance^2 * window of the range * rim of the cone (both
 * as in glTF's KHR_lights_punctual) * transmittance of the medium on the way there. Airlight along an eye ray (vxs_air.h) is the
 * integral of that, times the phase function and scattering, times the transmittance on the way to the eye.
 *
 *     path of light through fog    punctual light: the part of the straight line that lies below the top of the fog
 *                                  sun: from the top down to the position; fog without a top has no such path: then the
 *                                  colour of the sun is its colour inside the fog. A sun below the horizon gives no light
 *                                  through fog with a top
 *
 * Distances are metres; the numbers of the medium are per metre and colour channel.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AIR_LIGHT_H
#define VXS_AIR_LIGHT_H

#ifndef VXS_SPACE_H /* a shader that cannot include has it already */
#include "vxs_space.h"
#endif

#ifdef VXS_C
typedef struct vxs_medium    vxs_medium;
typedef struct vxs_air_light vxs_air_light;
typedef vxs_real             vxs_real2[2];
typedef vxs_real             vxs_real4[4];
#define VXS_MEDIUM    const vxs_medium *
#define VXS_AIR_LIGHT const vxs_air_light *
#else
#ifdef VXS_HLSL
#define vxs_real2 float2
#else
#define vxs_real2 vec2
#endif
#define VXS_MEDIUM    const vxs_medium
#define VXS_AIR_LIGHT const vxs_air_light
#endif

#define VXS_AIR_PI         3.14159265358979324
#define VXS_AIR_EVERYWHERE 1e30 /* top of fog without a top */

/* A shader may define VXS_ONLY_EVERYWHERE: no fog has a top, and code for a top is not compiled. */
#ifdef VXS_ONLY_EVERYWHERE
#define VXS_AIR_HAS_TOP(top)  false
#define VXS_AIR_IS_BELOW(ray) false
#else
#define VXS_AIR_HAS_TOP(top)  ((top) < VXS_AIR_EVERYWHERE)
#define VXS_AIR_IS_BELOW(ray) (VXS_FIELD(ray, above) > 0.0)
#endif
#define VXS_AIR_RIM_LEAST 1e-3 /* least difference of the cosines between which a cone fades */

/* A homogeneous medium. */
struct vxs_medium {
    vxs_real3 scattering; /* scattering coefficient per metre; >= 0, finite */
    vxs_real3 extinction; /* scattering plus absorption per metre; >= scattering, finite */
    vxs_real  anisotropy; /* g of the phase function, -0.99 (backward) to 0.99 (forward) */
};

struct vxs_air_light {
    vxs_u32   kind;          /* VXS_LIGHT_KIND_* */
    vxs_real3 place;         /* punctual light: its position, metres; sun: direction to it, of length 1 */
    vxs_real3 axis;          /* spot light: its direction, of length 1 */
    vxs_real  cos_inner;     /* spot light: cosines of the angles where the cone starts to fade, and where it ends */
    vxs_real  cos_outer;     /* >= 0 */
    vxs_real  radius_metres; /* punctual light, > 0: lower bound of distances to it */
    vxs_real  range_metres;  /* punctual light; 0: unlimited */
};

#ifdef VXS_C
VXS_FN vxs_real vxs_air_dot(const vxs_real3 a, const vxs_real3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

VXS_FN vxs_real vxs_air_less(vxs_real a, vxs_real b)
{
    return a < b ? a : b;
}

VXS_FN vxs_real vxs_air_more(vxs_real a, vxs_real b)
{
    return a > b ? a : b;
}
#else
#define vxs_air_dot(a, b)  dot(a, b)
#define vxs_air_less(a, b) min(a, b)
#define vxs_air_more(a, b) max(a, b)
#endif

/* cosine  between the directions of light before and after scattering */
VXS_FN vxs_real vxs_air_phase(const vxs_real g, const vxs_real cosine)
{
    vxs_real wide = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine);
    return (1.0 - g * g) / (4.0 * VXS_AIR_PI * wide * sqrt(wide));
}

/* metres  length of the path;   left  [out] transmittance */
VXS_FN void vxs_air_left(VXS_MEDIUM medium, vxs_real metres, VXS_OUT vxs_real3 left)
{
    for (vxs_i32 n = 0; n < 3; n++) left[n] = exp(-VXS_FIELD(medium, extinction)[n] * metres);
}

/* 1 - (r / range)^4, and 0 beyond the range.   per_range  1 / range; 0: unlimited */
VXS_FN vxs_real vxs_air_window(const vxs_real r, const vxs_real per_range)
{
    vxs_real part = r * per_range, square = part * part;
    return vxs_air_more(1.0 - square * square, VXS_REAL(0.0));
}

/* clamp(cosine * scale + offset, 0, 1)^2.   cosine  between a cone's axis and the direction from the light */
VXS_FN vxs_real vxs_air_rim(vxs_real cosine, vxs_real cos_inner, vxs_real cos_outer)
{
    vxs_real wide = cos_inner - cos_outer > VXS_AIR_RIM_LEAST ? cos_inner - cos_outer : VXS_REAL(VXS_AIR_RIM_LEAST);
    vxs_real rim  = (cosine - cos_outer) / wide;
    rim           = rim < 0.0 ? VXS_REAL(0.0) : rim > 1.0 ? VXS_REAL(1.0) : rim;
    return rim * rim;
}

/* Length of the part of a segment that lies below a level top. The segment is `metres` long and ends at heights a and b. */
VXS_FN vxs_real vxs_air_metres_below(vxs_real metres, vxs_real a, vxs_real b, vxs_real top)
{
    vxs_real low = a < b ? a : b, high = a < b ? b : a;
    if (!(high > top)) return metres;
    return low < top ? metres * ((top - low) / (high - low)) : VXS_REAL(0.0);
}

/* at        a position, metres
 * top       height (along y) of the level top of the fog; VXS_AIR_EVERYWHERE: no top
 * to_light  [out] of length 1
 * reaches   [out] for an intensity (punctual lights) or irradiance (sun) of 1 in each channel, without shadows: the irradiance
 *           of a surface that faces the light */
VXS_FN void vxs_air_reaches(VXS_MEDIUM medium, VXS_AIR_LIGHT light, const vxs_real3 at, vxs_real top, VXS_OUT vxs_real3 to_light,
                            VXS_OUT vxs_real3 reaches)
{
    vxs_real strength = VXS_REAL(1.0), way = VXS_REAL(0.0), metres;
    for (vxs_i32 n = 0; n < 3; n++) to_light[n] = VXS_FIELD(light, place)[n];
    if (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL) {
        if (VXS_AIR_HAS_TOP(top) && !(to_light[1] > 0.0)) strength = VXS_REAL(0.0);
        if (VXS_AIR_HAS_TOP(top) && to_light[1] > 0.0 && at[1] < top) way = (top - at[1]) / to_light[1];
    } else {
        for (vxs_i32 n = 0; n < 3; n++) to_light[n] -= at[n];
        metres = sqrt(vxs_air_dot(to_light, to_light));
        metres = metres > VXS_FIELD(light, radius_metres) ? metres : VXS_FIELD(light, radius_metres);
        for (vxs_i32 n = 0; n < 3; n++) to_light[n] /= metres;
        strength =
            VXS_FIELD(light, range_metres) > 0.0 ? vxs_air_window(metres, 1.0 / VXS_FIELD(light, range_metres)) : VXS_REAL(1.0);
        strength /= metres * metres;
        if (VXS_KIND(light) != VXS_LIGHT_KIND_POINT)
            strength *= vxs_air_rim(-vxs_air_dot(to_light, VXS_FIELD(light, axis)), VXS_FIELD(light, cos_inner),
                                    VXS_FIELD(light, cos_outer));
        way = VXS_AIR_HAS_TOP(top) ? vxs_air_metres_below(metres, at[1], VXS_FIELD(light, place)[1], top) : metres;
    }
    for (vxs_i32 n = 0; n < 3; n++) reaches[n] = strength * exp(-VXS_FIELD(medium, extinction)[n] * way);
}

#endif
