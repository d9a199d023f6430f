/* Don't-care rules of --behind and --thickness: voxels of a column that may be lit or shadowed, in addition to the insides of
 * solids (docs/overview.md, "Solids and sheets").
 *
 *     behind       if no surface lies behind the exit depth, all voxels behind it are don't-care voxels
 *     thickness    a one-sided sheet that faces the light has this thickness, or less if the next surface is nearer
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DONT_CARE_H
#define DONT_CARE_H

#include <math.h>

#include "formats/vxs_file.h"

typedef struct dont_care_rules {
    int    behind;      /* 1: voxels behind the last surface are don't-care voxels */
    double thickness;   /* of sheets, >= 0: in units of depth (directional light) or of the near distance (other lights), along
                           the map's axis */
    int    perspective; /* 1: depths are -near / z (depth_scale.h) */
} dont_care_rules;

/* The rules of a fitted light. */
static inline dont_care_rules dont_care_rules_of(const vxs_light *light, int behind, double thickness_m)
{
    const int perspective = light->kind != VXS_LIGHT_KIND_DIRECTIONAL;
    return (dont_care_rules){
        behind, thickness_m / (perspective ? light->near_metres : ldexp(light->voxel_metres, (int)light->levels)), perspective};
}

/* 1 if the rules depend on the next surface behind the exit depth. */
static inline int dont_care_needs_next(const dont_care_rules *f)
{
    return f->behind || f->thickness > 0;
}

/* A depth plus the thickness. Monotonic in depth, except for rounding. */
static inline double dont_care_through(const dont_care_rules *f, double depth)
{
    return f->perspective ? depth / (1 - f->thickness * depth) : depth + f->thickness;
}

#endif
