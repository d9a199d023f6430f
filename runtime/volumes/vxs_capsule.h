/* Capsules: volumes that dim light, such as smoke, hair and dust.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_CAPSULE_H
#define VXS_CAPSULE_H

/* All points whose distance from a segment is at most a radius, with constant density. A puff of smoke is a capsule whose ends
 * are equal; a hair is a chain of thin capsules. A capsule thinner than a texel falls between rays: make it as wide as a texel,
 * and multiply its extinction by the square of (old width / new width). A capsule without size or extinction, or with numbers
 * that are NaN or beyond 1e12, has no effect. */
typedef struct vxs_capsule {
    float begin[3], radius_metres;
    float end[3], extinction; /* per metre */
} vxs_capsule;

#endif
