/* Sample positions on an emitting picture, for virtual point lights. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef AREA_SITES_H
#define AREA_SITES_H

#include "vxs_area_light.h"

typedef struct area_picture {
    const float *texture;  /* [high_px][wide_px][3] NULL: 1 everywhere */
    const float *radiance; /* [3] factor */
    uint32_t     wide_px, high_px;
    int          is_sky; /* 1: rows are equal angles from the zenith down, weighted by solid angle; 0: all rows have equal weight */
    double       aspect; /* aspect ratio of u and v, if these are unrolled evenly */
} area_picture;

/* A sample: its position and its light; the mean over all samples is that of the texture. v runs down the rows by weight, from 0
 * to 1: uniform in area, or in solid angle. */
typedef struct area_site {
    double u, v, light[3];
} area_site;

/* The share of a picture before row y. */
double vxs_area_before_row(const area_picture *p, uint32_t y);

/* The row that contains v, [0, 1]. */
uint32_t vxs_area_row_of(const area_picture *p, double v);

/* Texel x of row y.   [3] */
const float *vxs_area_texel_of(const area_picture *p, uint32_t x, uint32_t y);

/* A point of a picture: on a rectangle, in units of its `up`; on a sky, the direction, of length 1. */
void vxs_area_place_of(const area_picture *p, double u, double v, double place[3]);

/* Give each site the light of its Voronoi cell. */
void vxs_area_share_light(const area_picture *p, area_site *sites, uint32_t count);

/* Choose sample positions as vxs_area_sample describes.   sites  [out] [count] */
void vxs_area_sites(const area_picture *p, vxs_area_places places, uint32_t seed, area_site *sites, uint32_t count);

/* Whether three numbers are finite, and at least `least`. */
int vxs_area_is_number(const float v[3], float least);

#endif
