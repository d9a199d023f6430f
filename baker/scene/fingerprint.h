/* Fingerprint of a scene: hashes of its contents. Equal scenes have equal hashes, whatever files, buffers and folders they come
 * from. Separate hashes for separate aspects allow a report to name what changed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FINGERPRINT_H
#define FINGERPRINT_H

#include "baker/scene/scene.h"

/* 32 hexadecimal digits of XXH3-128, and a NUL. */
enum { FINGERPRINT_BYTES = 33 };

typedef struct scene_fingerprint {
    char geometry[FINGERPRINT_BYTES]; /* triangles in order: corners, and which are double-sided or have holes. Independent of how
                                         vertices are shared */
    char alpha_masks[FINGERPRINT_BYTES]; /* holes of the triangles with holes, in order: images, thresholds, samplers, texture
                                            coordinates. Independent of how images and masks are shared */
    char cameras[FINGERPRINT_BYTES];     /* camera positions: a component with a camera inside is not a solid */
    char lights[FINGERPRINT_BYTES]; /* names of all lights, and positions of spot and point lights: a component with one inside is
                                       not a solid, baked or not, and lights that are not baked are listed. Other properties are
                                       stored with each baked light */
} scene_fingerprint;

/* Compute the fingerprint of a scene. 0 and -0 are equal, and all NaN are equal.
 * f  [out]
 * Returns VXS_OK or VXS_E_MEMORY.
 * Time: one pass over the scene, 10 to 50 ns per triangle; loading takes ten times as long. */
vxs_result scene_fingerprint_take(scene_fingerprint *f, const scene *s, run_context *m);

/* Fingerprint of one alpha mask: of the opaque area that it defines, not of how images are shared. */
typedef struct mask_fingerprint {
    uint64_t low, high;
} mask_fingerprint;

mask_fingerprint alpha_mask_fingerprint(const alpha_mask *mask, const alpha_image *image);

#endif
