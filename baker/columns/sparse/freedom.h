/* What a column leaves free where it was asked for, besides the insides of solids (docs/overview.md, "Solids and sheets").
 *
 *     behind       where light leaves, and no surface lies farther on the ray, all is free that lies behind
 *     thickness    a sheet that is seen from one side, and there by the light, is so thick, or as thick as what lies behind it leaves room for
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FREEDOM_H
#define FREEDOM_H

#include <math.h>

#include "formats/vxs_file.h"

typedef struct column_freedom {
    int    behind;    /* 1: nobody asks behind the last surface */
    double thickness; /* of the sheets, >= 0: in depths of a directional light, in near distances of others, along the map's axis */
    int    perspective; /* 1: depths are -near / z (depth_scale.h) */
} column_freedom;

/* Of a fitted light's maps. A voxel of a directional light is so many metres deep. */
static inline column_freedom freedom_of(const vxs_light *light, int behind, double thickness_m)
{
    const int perspective = light->kind != VXS_LIGHT_KIND_DIRECTIONAL;
    return (column_freedom){
        behind, thickness_m / (perspective ? light->near_metres : ldexp(light->voxel_metres, (int)light->levels)), perspective};
}

/* Whether it matters what lies behind where light leaves. */
static inline int freedom_looks_on(const column_freedom *f)
{
    return f->behind || f->thickness > 0;
}

/* The depth that lies so much deeper. It never falls where depth grows, but by rounding. */
static inline double freedom_through(const column_freedom *f, double depth)
{
    return f->perspective ? depth / (1 - f->thickness * depth) : depth + f->thickness;
}

#endif
