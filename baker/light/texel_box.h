/* Bounding boxes of triangles in texels.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEXEL_BOX_H
#define TEXEL_BOX_H

#include "baker/light/projection.h"

/* The rasterizer snaps vertices to a grid of this many steps per texel. */
enum { SUBTEXELS = 256 };

/* Texels whose centres are in a triangle's bounding box. Empty when u0 > u1 or v0 > v1. */
typedef struct texel_box {
    int32_t u0, v0, u1, v1;
} texel_box;

/* Box of a triangle of a projection. */
texel_box texel_box_of(const projection *p, size_t triangle);

/* 1 when the triangle may touch the square of `side` texels at (u0, v0). */
int texel_box_touches(const texel_box *box, int32_t u0, int32_t v0, int32_t side);

#endif
