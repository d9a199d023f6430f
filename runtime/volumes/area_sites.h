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

/* Where a light is, and its light: the mean of all is that of the texture. v runs down the rows as these count: from 0 to 1, evenly through area, or through
 * directions. */
typedef struct area_site {
    double u, v, light[3];
} area_site;

/* The part of a picture before row y. */
double vxs_area_before_row(const area_picture *p, uint32_t y);

/* The row that has v; v is [0, 1]. */
uint32_t vxs_area_row_of(const area_picture *p, double v);

/* Texel x of row y.   [3] */
const float *vxs_area_texel_of(const area_picture *p, uint32_t x, uint32_t y);

/* Where a place of a picture is: on a rectangle, with its up as unit; of a sky the way there, of length 1. */
void vxs_area_place_of(const area_picture *p, double u, double v, double place[3]);

/* Give each site the light of all that is nearer to it than to others. */
void vxs_area_share_light(const area_picture *p, area_site *sites, uint32_t count);

/* Choose places, as vxs_area_sample says.   sites  [out] [count] */
void vxs_area_sites(const area_picture *p, vxs_area_places places, uint32_t seed, area_site *sites, uint32_t count);

/* Whether three are numbers, `least` or more. */
int vxs_area_is_number(const float v[3], float least);

#endif
