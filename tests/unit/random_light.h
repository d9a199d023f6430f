/* Random spot and point lights, and their light space as formats/vxs.md section 2 has it, by names of axes: what tests hold against
 * the formulas of vxs_space.h and map_space.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RANDOM_PUNCTUAL_H
#define RANDOM_PUNCTUAL_H

#include <math.h>
#include <string.h>

#include "baker/base/random.h"
#include "formats/vxs_file.h"

static inline double uniform(rng *r, double low, double high)
{
    return low + (high - low) * (rng_u32(r) / 4294967296.0);
}

static inline double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double *a, const double *b, double *out)
{
    for (int n = 0; n < 3; n++) out[n] = a[(n + 1) % 3] * b[(n + 2) % 3] - a[(n + 2) % 3] * b[(n + 1) % 3];
}

static inline void make_unit(double *v)
{
    double length = sqrt(dot(v, v));
    for (int n = 0; n < 3; n++) v[n] /= length;
}

static inline void random_direction(rng *r, double *out)
{
    do {
        for (int n = 0; n < 3; n++) out[n] = uniform(r, -1, 1);
    } while (dot(out, out) < 0.01 || dot(out, out) > 1);
    make_unit(out);
}

/* Parts of a punctual light besides those in the file. */
typedef struct punctual {
    vxs_light light;
    double    axis[3][3]; /* of light space, in world space */
    double    at[3];
    double    cone_rad; /* pi: all around */
} punctual;

typedef enum punctual_shape { SPOT, WIDE_SPOT, POINT, PUNCTUAL_SHAPES } punctual_shape;

static inline punctual random_punctual(rng *r, punctual_shape shape)
{
    punctual l    = {.cone_rad = shape == SPOT ? uniform(r, 0.01, 1.04) : shape == WIDE_SPOT ? uniform(r, 1.05, 1.57) : acos(-1)};
    double   side = ldexp(1, 3 + rng_between(r, 0, 11)), border = fmin(18, side / 8), far = uniform(r, 1.5, 4);
    random_direction(r, l.axis[2]);
    random_direction(r, l.axis[1]);
    cross(l.axis[1], l.axis[2], l.axis[0]);
    make_unit(l.axis[0]);
    cross(l.axis[2], l.axis[0], l.axis[1]);
    for (int n = 0; n < 3; n++) l.at[n] = uniform(r, -100, 100);
    for (int row = 0; row < 3; row++) {
        memcpy(l.light.ls_from_ws + 4 * row, l.axis[row], sizeof l.axis[row]);
        l.light.ls_from_ws[4 * row + 3] = -dot(l.axis[row], l.at);
    }
    while (1u << l.light.levels < side) l.light.levels++;
    l.light.kind         = shape == POINT ? VXS_LIGHT_KIND_POINT : VXS_LIGHT_KIND_SPOT;
    l.light.flags        = shape == SPOT ? 0 : VXS_LIGHT_CUBE;
    l.light.texel_metres = (shape == SPOT ? tan(l.cone_rad) : 1) / (side / 2 - border);
    l.light.near_metres  = uniform(r, 0.01, 2);
    l.light.voxel_metres = log(pow(10, far)) / side;
    l.light.cos_outer    = shape == POINT ? 0 : cos(l.cone_rad);
    memcpy(l.light.direction_ws, l.axis[2], sizeof l.axis[2]);
    return l;
}

static inline int map_count(const vxs_light *light)
{
    return light->flags & VXS_LIGHT_CUBE ? 6 : 1;
}

/* Axes of a map by name, as vxs.md section 2 has them: across, down, along; capitals are negative. */
static const char *const map_axes[6] = {"yzx", "zyX", "zxy", "xzY", "xyz", "yxZ"};

static inline void map_space(const punctual *l, int map, const double *point_ws, double *out)
{
    const char *axes = map_axes[map_count(&l->light) > 1 ? map : 4];
    double      from[3];
    for (int n = 0; n < 3; n++) from[n] = point_ws[n] - l->at[n];
    for (int n = 0; n < 3; n++) out[n] = axes[n] < 'a' ? -dot(l->axis[axes[n] - 'X'], from) : dot(l->axis[axes[n] - 'x'], from);
}

/* u, v and depth of a point that is before the map. */
static inline void place(const punctual *l, int map, const double *point_ws, double *out)
{
    double p[3], side = ldexp(1, (int)l->light.levels);
    map_space(l, map, point_ws, p);
    out[0] = side / 2 + p[0] / p[2] / l->light.texel_metres;
    out[1] = side / 2 + p[1] / p[2] / l->light.texel_metres;
    out[2] = log(p[2] / l->light.near_metres) / l->light.voxel_metres;
}

#endif
