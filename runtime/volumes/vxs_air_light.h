/* Light in a homogeneous medium: one text for C99, C++, GLSL and HLSL, that stands on vxs_space.h.
 *
 *     vxs_air_phase      the phase function: Henyey and Greenstein
 *     vxs_air_left       what the medium leaves of what is behind it
 *     vxs_air_window     how a lamp fades toward the end of its range
 *     vxs_air_rim        how a spot light fades toward the side of its cone
 *     vxs_air_reaches    what of a light reaches a place
 *
 * The law is one for surfaces and for the air: what reaches a place is the light's intensity, over the square of the distance, times its range's
 * window and its cone's rim (both as glTF's KHR_lights_punctual has them), times what the medium leaves on the way there. Airlight along an eye ray
 * (vxs_air.h) is the integral of that, times what turns there and what is left of it on the way to the eye.
 *
 *     way of light through the fog    a lamp: of the straight way, what lies below the fog's top
 *                                     the sun: from the top down to the place; fog without a top has no such place, and the colour of the sun is
 *                                     what it is inside; from below the horizon none comes through fog with a top
 *
 * Distances are metres; the medium's numbers are per metre and colour channel.
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
#define VXS_MEDIUM    vxs_medium
#define VXS_AIR_LIGHT vxs_air_light
#endif

#define VXS_AIR_PI         3.14159265358979324
#define VXS_AIR_EVERYWHERE 1e30 /* the top of fog that has none */
#define VXS_AIR_RIM_LEAST  1e-3 /* cosines between which a cone fades: no rim is sharper */

/* What fills the air. */
struct vxs_medium {
    vxs_real3 scattering; /* of light that goes a metre, how much turns; >= 0, finite */
    vxs_real3 extinction; /* how much turns or is absorbed; >= scattering, finite */
    vxs_real  anisotropy; /* g of the phase function, -0.99 (back to where it came from) to 0.99 (on the same way) */
};

struct vxs_air_light {
    vxs_u32   kind;          /* VXS_LIGHT_KIND_* */
    vxs_real3 place;         /* of a lamp, metres; of the sun the way to it, of length 1 */
    vxs_real3 axis;          /* of a spot light: where it shines, of length 1 */
    vxs_real  cos_inner;     /* of its cone: where it begins to fade, and where it ends */
    vxs_real  cos_outer;     /* >= 0 */
    vxs_real  radius_metres; /* of a lamp, > 0: nothing is nearer to it than this */
    vxs_real  range_metres;  /* of a lamp; 0: it has none */
};

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

/* metres  through the medium;   left  [out] of what is behind it */
VXS_FN void vxs_air_left(VXS_MEDIUM medium, vxs_real metres, VXS_OUT vxs_real3 left)
{
    for (vxs_i32 n = 0; n < 3; n++) left[n] = exp(-VXS_FIELD(medium, extinction)[n] * metres);
}

/* 1 - (r / range)^4, and nothing behind the range.   per_range  1 over the range; 0: there is none */
VXS_FN vxs_real vxs_air_window(vxs_real r, vxs_real per_range)
{
    vxs_real part = r * per_range, square = part * part, window = 1.0 - square * square;
    return window > 0.0 ? window : VXS_REAL(0.0);
}

/* clamp(cosine * scale + offset, 0, 1)^2.   cosine  between a cone's axis and the way from the lamp */
VXS_FN vxs_real vxs_air_rim(vxs_real cosine, vxs_real cos_inner, vxs_real cos_outer)
{
    vxs_real wide = cos_inner - cos_outer > VXS_AIR_RIM_LEAST ? cos_inner - cos_outer : VXS_REAL(VXS_AIR_RIM_LEAST);
    vxs_real rim  = (cosine - cos_outer) / wide;
    rim           = rim < 0.0 ? VXS_REAL(0.0) : rim > 1.0 ? VXS_REAL(1.0) : rim;
    return rim * rim;
}

/* How many of so many metres between two heights are below a level top. */
VXS_FN vxs_real vxs_air_metres_below(vxs_real metres, vxs_real a, vxs_real b, vxs_real top)
{
    vxs_real low = a < b ? a : b, high = a < b ? b : a;
    if (!(high > top)) return metres;
    return low < top ? metres * ((top - low) / (high - low)) : VXS_REAL(0.0);
}

/* at        a place, metres;   top  height (along y) of the fog's level top; VXS_AIR_EVERYWHERE: it has none
 * to_light  [out] of length 1
 * reaches   [out] of an intensity (lamps) or irradiance (the sun) of 1 in each channel, before shadows: the irradiance of a surface that faces the light */
VXS_FN void vxs_air_reaches(VXS_MEDIUM medium, VXS_AIR_LIGHT light, const vxs_real3 at, vxs_real top, VXS_OUT vxs_real3 to_light,
                            VXS_OUT vxs_real3 reaches)
{
    vxs_real strength = VXS_REAL(1.0), way = VXS_REAL(0.0), metres;
    vxs_i32  has_top = top < VXS_AIR_EVERYWHERE ? 1 : 0;
    for (vxs_i32 n = 0; n < 3; n++) to_light[n] = VXS_FIELD(light, place)[n];
    if (VXS_FIELD(light, kind) == VXS_LIGHT_KIND_DIRECTIONAL) {
        if (has_top != 0 && !(to_light[1] > 0.0)) strength = VXS_REAL(0.0);
        if (has_top != 0 && to_light[1] > 0.0 && at[1] < top) way = (top - at[1]) / to_light[1];
    } else {
        for (vxs_i32 n = 0; n < 3; n++) to_light[n] -= at[n];
        metres = sqrt(vxs_air_dot(to_light, to_light));
        metres = metres > VXS_FIELD(light, radius_metres) ? metres : VXS_FIELD(light, radius_metres);
        for (vxs_i32 n = 0; n < 3; n++) to_light[n] /= metres;
        strength = VXS_FIELD(light, range_metres) > 0.0 ? vxs_air_window(metres, 1.0 / VXS_FIELD(light, range_metres)) : VXS_REAL(1.0);
        strength /= metres * metres;
        if (VXS_FIELD(light, kind) != VXS_LIGHT_KIND_POINT)
            strength *= vxs_air_rim(-vxs_air_dot(to_light, VXS_FIELD(light, axis)), VXS_FIELD(light, cos_inner), VXS_FIELD(light, cos_outer));
        way = has_top != 0 ? vxs_air_metres_below(metres, at[1], VXS_FIELD(light, place)[1], top) : metres;
    }
    for (vxs_i32 n = 0; n < 3; n++) reaches[n] = strength * exp(-VXS_FIELD(medium, extinction)[n] * way);
}

#endif
