/* What a scene is made of, as hashes: those of two scenes are equal where the scenes are, whatever files, buffers and folders they come
 * from. One for each thing that may change, so that a difference has a name.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FINGERPRINT_H
#define FINGERPRINT_H

#include "baker/scene/scene.h"

/* 32 hexadecimal digits of XXH3-128, and NUL. */
enum { FINGERPRINT_BYTES = 33 };

typedef struct scene_fingerprint {
    char geometry[FINGERPRINT_BYTES]; /* triangles in their order: corners, and which have two sides or holes. Not how vertices are
                                            shared */
    char alpha_masks[FINGERPRINT_BYTES]; /* where the triangles with holes have them, in their order: images, thresholds, samplers,
                                            texture coordinates. Not how images and masks are shared */
    char cameras[FINGERPRINT_BYTES];     /* where they are: what has one inside is no solid */
    char lights[FINGERPRINT_BYTES]; /* names of all, and where spot and point lights are: baked or not, these are no solid's inside,
                                            and what is not baked is listed. The rest is what lights that are baked say of themselves */
} scene_fingerprint;

/* Take the fingerprint of a scene. 0 and -0 are equal, and so is all that is not a number.
 * f  [out]
 * Returns VXS_OK or VXS_E_MEMORY.
 * Cost: one pass over what the scene holds, 10 to 50 ns for each triangle; loading takes ten times as long. */
vxs_result scene_fingerprint_take(scene_fingerprint *f, const scene *s, message *m);

/* The fingerprint of one alpha mask: of what it makes opaque, not of how images are shared. */
typedef struct mask_fingerprint {
    uint64_t low, high;
} mask_fingerprint;

mask_fingerprint alpha_mask_fingerprint(const alpha_mask *mask, const alpha_image *image);

#endif
