/* Whether an alpha-tested material has a surface at a place of its image: the one definition that ray tracing uses as it is, and
 * that depth maps follow in their shader.
 *
 * u runs to the right and v downward, 1 the image's width and height. Pixel (i, j) has its centre at ((i + 0.5) / width,
 * (j + 0.5) / height); whatever is outside the image is a pixel of it by the wrap mode of each axis:
 *
 *     pixel         ...  -3 -2 -1 | 0  1  2  3 |  4  5  6 ...      an image 4 pixels wide
 *     WRAP_REPEAT         1  2  3 | 0  1  2  3 |  0  1  2
 *     WRAP_CLAMP          0  0  0 | 0  1  2  3 |  3  3  3
 *     WRAP_MIRROR         2  1  0 | 0  1  2  3 |  3  2  1
 *
 * Alpha is that of the pixel which u, v lies in (nearest), or bilinear between the four centres around: first along u, then along
 * v, each as a + share * (b - a), so that equal pixels give their own alpha exactly. No levels of detail: the bake has no eye.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ALPHA_MASK_H
#define ALPHA_MASK_H

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Alpha at (u, v), 0 to 255. A coordinate that is not finite counts as 0.   Threads: any. */
double alpha_mask_alpha(const alpha_mask *mask, const alpha_image *image, double u, double v);

/* 1 where there is a surface: alpha / 255, rounded to float as the threshold is, is at least the threshold. */
int alpha_mask_opaque(const alpha_mask *mask, const alpha_image *image, double u, double v);

#ifdef __cplusplus
}
#endif
#endif
