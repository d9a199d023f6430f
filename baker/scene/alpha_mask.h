/* Evaluates alpha masks: whether an alpha-tested material has a surface at a point of its image. Ray tracing uses these functions
 * directly; the shader for depth maps follows the same definition.
 *
 * u runs to the right and v downward; the image covers [0, 1] x [0, 1]. Pixel (i, j) has its centre at ((i + 0.5) / width, (j +
 * 0.5) / height). Coordinates outside the image map to a pixel by the wrap mode of each axis:
 *
 *     pixel         ...  -3 -2 -1 | 0  1  2  3 |  4  5  6 ...      an image 4 pixels wide
 *     WRAP_REPEAT         1  2  3 | 0  1  2  3 |  0  1  2
 *     WRAP_CLAMP          0  0  0 | 0  1  2  3 |  3  3  3
 *     WRAP_MIRROR         2  1  0 | 0  1  2  3 |  3  2  1
 *
 * Alpha is that of the pixel containing (u, v) (nearest), or bilinear between the four nearest pixel centres: first along u, then
 * along v, each as a + share * (b - a), so that equal pixels give exactly their alpha. No mipmaps are used, because a bake has no
 * viewpoint.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ALPHA_MASK_H
#define ALPHA_MASK_H

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Alpha at (u, v), 0 to 255. A coordinate that is not finite counts as 0. Thread-safe. */
double alpha_mask_alpha(const alpha_mask *mask, const alpha_image *image, double u, double v);

/* 1 where there is a surface: alpha / 255, rounded to float like the threshold, is at least the threshold. */
int alpha_mask_opaque(const alpha_mask *mask, const alpha_image *image, double u, double v);

#ifdef __cplusplus
}
#endif
#endif
