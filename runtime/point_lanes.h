/* Vectors of doubles: those of GCC and Clang, or a single double with other compilers or when VXS_SCALAR is defined. Code that
 * uses them gives the same numbers either way. Internal to the runtime; not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_POINT_LANES_H
#define VXS_POINT_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__GNUC__) && !defined(VXS_SCALAR)
typedef double  vxs_lanes __attribute__((vector_size(16)));
typedef int64_t vxs_lane_mask __attribute__((vector_size(16))); /* result of a comparison: all ones, or zero */

/* x where the mask is set, else 0. */
static inline vxs_lanes vxs_keep(vxs_lane_mask mask, vxs_lanes x)
{
    return (vxs_lanes)((vxs_lane_mask)x & mask);
}

static inline vxs_lanes vxs_abs_lanes(vxs_lanes x)
{
    return (vxs_lanes)((vxs_lane_mask)x & INT64_MAX);
}

/* x with the sign of `other`. x must not be negative. */
static inline vxs_lanes vxs_signed_as(vxs_lanes x, vxs_lanes other)
{
    return (vxs_lanes)((vxs_lane_mask)x | ((vxs_lane_mask)other & INT64_MIN));
}

static inline int vxs_all(vxs_lane_mask mask)
{
    return (mask[0] & mask[1]) != 0;
}

/* x where the mask is set, else `other`. */
static inline vxs_lanes vxs_pick(vxs_lane_mask mask, vxs_lanes x, vxs_lanes other)
{
    return (vxs_lanes)(((vxs_lane_mask)x & mask) | ((vxs_lane_mask)other & ~mask));
}

static inline vxs_lanes vxs_lanes_of(double x)
{
    vxs_lanes both = {x, x};
    return both;
}
#else
typedef double vxs_lanes;
typedef int    vxs_lane_mask;

static inline vxs_lanes vxs_keep(vxs_lane_mask mask, vxs_lanes x)
{
    return mask ? x : 0;
}

static inline vxs_lanes vxs_abs_lanes(vxs_lanes x)
{
    return fabs(x);
}

static inline vxs_lanes vxs_signed_as(vxs_lanes x, vxs_lanes other)
{
    return copysign(x, other);
}

static inline int vxs_all(vxs_lane_mask mask)
{
    return mask;
}

static inline vxs_lanes vxs_pick(vxs_lane_mask mask, vxs_lanes x, vxs_lanes other)
{
    return mask ? x : other;
}

static inline vxs_lanes vxs_lanes_of(double x)
{
    return x;
}
#endif

enum { VXS_LANES = sizeof(vxs_lanes) / sizeof(double) };

static inline vxs_lanes vxs_load(const double *from)
{
    vxs_lanes x;
    memcpy(&x, from, sizeof x);
    return x;
}

static inline void vxs_store(double *to, vxs_lanes x)
{
    memcpy(to, &x, sizeof x);
}

/* floor of numbers with |x| < 2^51, in any rounding mode. */
static inline vxs_lanes vxs_small_floor(vxs_lanes x)
{
    const vxs_lanes units = vxs_lanes_of(6755399441055744.0); /* 1.5 * 2^52: doubles near it are spaced by 1 */
    vxs_lanes       whole = x + units - units;
    return whole - vxs_keep(whole > x, vxs_lanes_of(1));
}

#endif
