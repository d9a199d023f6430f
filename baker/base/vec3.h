/* Vectors of three doubles: the operations that lights, maps and the ray-traced ground truth share.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VEC3_H
#define VEC3_H

#include <math.h>

static inline double vec3_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void vec3_sub(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[i] - b[i];
}

/* out = a + s b */
static inline void vec3_mad(const double a[3], double s, const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[i] + s * b[i];
}

/* out must not be a or b */
static inline void vec3_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* The unit vector along v, for any finite length. Returns 0, and leaves `out` unchanged, when v is 0. */
static inline int vec3_unit(const double v[3], double out[3])
{
    double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0)) return 0;

    int exponent;
    frexp(largest, &exponent);
    double scaled[3];
    for (int i = 0; i < 3; i++) scaled[i] = ldexp(v[i], -exponent);
    double length = sqrt(vec3_dot(scaled, scaled));
    for (int i = 0; i < 3; i++) out[i] = scaled[i] / length;
    return 1;
}

/* Two unit vectors that are orthogonal to the unit vector `along` and to each other. The first is also orthogonal to the coordinate
 * axis with the smallest component of `along`. */
static inline void vec3_across(const double along[3], double right[3], double up[3])
{
    double axis[3] = {0};
    int    least   = fabs(along[1]) < fabs(along[0]);
    if (fabs(along[2]) < fabs(along[least])) least = 2;
    axis[least] = 1;
    vec3_cross(along, axis, right);
    vec3_unit(right, right);
    vec3_cross(along, right, up);
}

#endif
