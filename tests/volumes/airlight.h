/* Airlight by its definition, by adaptive quadrature in double: what runtime/volumes is held against. It shares no line with it.
 *
 * Of punctual lights the integrand phase(cosine) * exp(-extinction * way) / r^2, times what their cone and range leave, is queried
 * place by place along a ray, in pieces between places where it may change fast, the way being what lies in fog of the ways from
 * the light to there and on to the eye; of the sun phase * exp(-extinction * way). Metres; for an intensity or irradiance and a
 * scattering of 1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AIRLIGHT_H
#define AIRLIGHT_H

/* How a ray from the eye, of length 1, passes a punctual light. */
typedef struct air_passing {
    double along, beside;        /* where it is nearest to the light, and how near, but no nearer than its radius */
    double facing, before;       /* cosine between ray and axis; metres along the axis from the light to that place */
    double cos_inner, cos_outer; /* of a spot light */
    int    is_spot;
    double range;   /* 0: none; nothing is lit behind it, and before it 1 - (r / range)^4 of what would be */
    int    is_face; /* 1: what a spot light squares is as it is, such as the cosine of a face (1 and 0 for the cosines) */

    int    has_top;           /* 1: the fog has a level top, and what is queried of is below it; air_passing_of says 0 */
    double top, punctual, up; /* heights of the top and of the light from the eye's; the ray's direction along the vertical */
} air_passing;

/* axis  of a spot light, of length 1; NULL: a point light, and the cosines do not count */
air_passing air_passing_of(const double direction[3], const double to_light[3], double radius, const double *axis, double cos_inner,
                           double cos_outer);

/* One colour channel of what is scattered toward the eye between begin and begin + length, both >= 0, to 1e-9 of it.
 * g  anisotropy.   Threads: one at a time. */
double air_of_punctual(const air_passing *p, double g, double extinction, double begin, double length);

/* The way through fog of light that turns at x. */
double air_way_of(const air_passing *p, double x);

/* Of the sun, as air_of_punctual: at x light has gone way + slope * x before it meets the eye, >= 0 in the whole interval.
 * cosine  between the ray and the way to the sun */
double air_of_sun(double cosine, double g, double extinction, double way, double slope, double begin, double length);

#endif
