/* What dims light without stopping it: smoke, hair, dust.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_CAPSULE_H
#define VXS_CAPSULE_H

/* All that is no farther from a segment than a radius, evenly dense. Puffs of smoke begin where they end; a hair is a chain of
 * thin ones. One that is thinner than a texel is missed by the rays beside it: make it as wide as a texel, and thinner in
 * extinction by the square. One that is no capsule, of no size or extinction, with numbers that are none, or beyond 1e12, dims
 * nothing. */
typedef struct vxs_capsule {
    float begin[3], radius_metres;
    float end[3], extinction; /* per metre */
} vxs_capsule;

#endif
