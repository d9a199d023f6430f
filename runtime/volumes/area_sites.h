/* Places on a picture that shines, for virtual lights. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef AREA_SITES_H
#define AREA_SITES_H

#include "vxs_area_light.h"

typedef struct area_picture {
    const float *texture;  /* [high_px][wide_px][3] NULL: 1 everywhere */
    const float *radiance; /* [3] what it is times */
    uint32_t     wide_px, high_px;
    int is_sky; /* 1: rows are of equal angles from the zenith down, and count by their part of all directions; 0: all count alike */
    double aspect; /* of u and v, where these are spread out evenly */
} area_picture;

/* Where a light is, its light, and what that is times. v runs down the rows as these count: from 0 to 1, evenly through area, or through directions. */
typedef struct area_site {
    double       u, v, scale;
    const float *texel; /* [3] */
} area_site;

/* Choose places, as vxs_area_sample says.   sites  [out] [count] */
void vxs_area_sites(const area_picture *p, vxs_area_places places, uint32_t seed, area_site *sites, uint32_t count);

/* Whether three are numbers, `least` or more. */
int vxs_area_is_number(const float v[3], float least);

#endif
