/* The texels that a triangle may touch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEXEL_BOX_H
#define TEXEL_BOX_H

#include "baker/light/projection.h"

/* Maps are rendered with vertices that lie on a grid of so many steps in a texel. */
enum { SUBTEXELS = 256 };

/* Texels whose centres a triangle's bounding box covers; empty when u0 > u1 or v0 > v1. */
typedef struct texel_box {
    int32_t u0, v0, u1, v1;
} texel_box;

/* The box of a triangle of a projection. */
texel_box texel_box_of(const projection *p, size_t triangle);

/* 1 when the triangle may touch the square of `side` texels at (u0, v0). */
int texel_box_touches(const texel_box *box, int32_t u0, int32_t v0, int32_t side);

#endif
