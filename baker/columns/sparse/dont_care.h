/* Don't-care rules of --behind and --thickness: which voxels of a column may be lit or shadowed, besides the insides of solids
 * (docs/overview.md, "Solids and sheets").
 *
 *     behind       where light leaves, and no surface lies farther on the ray, all voxels behind are don't-care
 *     thickness    a one-sided sheet that faces the light has this thickness, or less where the next surface is nearer
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DONT_CARE_H
#define DONT_CARE_H

#include <math.h>

#include "formats/vxs_file.h"

typedef struct dont_care_rules {
    int    behind;      /* 1: no lookups behind the last surface */
    double thickness;   /* of sheets, >= 0: in depths of a directional light, in near distances of others, along the map's axis */
    int    perspective; /* 1: depths are -near / z (depth_scale.h) */
} dont_care_rules;

/* The rules of a fitted light. */
static inline dont_care_rules dont_care_rules_of(const vxs_light *light, int behind, double thickness_m)
{
    const int perspective = light->kind != VXS_LIGHT_KIND_DIRECTIONAL;
    return (dont_care_rules){
        behind, thickness_m / (perspective ? light->near_metres : ldexp(light->voxel_metres, (int)light->levels)), perspective};
}

/* 1 where the rules depend on the next surface behind the exit depth. */
static inline int dont_care_needs_next(const dont_care_rules *f)
{
    return f->behind || f->thickness > 0;
}

/* A depth, deeper by the thickness. Grows with depth, but for rounding. */
static inline double dont_care_through(const dont_care_rules *f, double depth)
{
    return f->perspective ? depth / (1 - f->thickness * depth) : depth + f->thickness;
}

#endif
