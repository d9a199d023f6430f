/* What a smooth box counts of a texel, from the definition of it: what tests hold against lookups.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOOTH_BOX_H
#define SMOOTH_BOX_H

#include <stdint.h>

/* How much of texel x a row of `width` texels about a place covers, in 1/256 of it; the place is in texel i, within / 256 from its
 * near side. */
static inline uint32_t smooth_overlap(int64_t x, int64_t i, uint32_t within, int width)
{
    int64_t begin = 256 * i + within - 128 * width, end = begin + 256 * width, near = 256 * x, far = near + 256;
    if (near < begin) near = begin;
    if (far > end) far = end;
    return near < far ? (uint32_t)(far - near) : 0;
}

#endif
