/* Maps the depths of a block to 16-bit codes, for SIMD. Depths outside of all possible choices are clamped. If the depths of a
 * block span more than 16 bits, only the depths that occur have codes, and the gaps between them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DEPTH_AXIS_H
#define DEPTH_AXIS_H

#include <stdint.h>

enum { AXIS_DEPTHS_MAX = 2 * (1024 + 16), AXIS_MARGIN = 4096 };

typedef struct depth_axis {
    int32_t floor;                   /* depth of code 0, if codes are steps of one voxel */
    int     count;                   /* 0; or number of depths with codes: depth n has code 2n + 1, the gap before it 2n */
    int32_t depths[AXIS_DEPTHS_MAX]; /* ascending */
} depth_axis;

/* Use steps of one voxel. The lows of all intervals are at most `greatest_low`, the highs at least `least_high`: every choice of
 * depths is between the two. Returns 0 if 16 bits are not enough. */
int axis_init(depth_axis *a, int32_t least_high, int32_t greatest_low);

/* Use only the depths that occur.
 * depths  [count] all ends of intervals, each >= 0; at most AXIS_DEPTHS_MAX
 * codes   [out] [count] their codes */
void axis_init_by_depths(depth_axis *a, const int32_t *depths, int16_t *codes, int count);

/* Codes of depths. Their order is that of the depths; codes are equal only for equal depths, or if both are clamped. */
void axis_codes(const depth_axis *a, const int32_t *depths, int16_t *codes, int count);

static inline int16_t axis_code(const depth_axis *a, int32_t depth)
{
    int16_t code;
    axis_codes(a, &depth, &code, 1);
    return code;
}

/* Depth of a code that axis_codes returned for the end of an interval. */
int32_t axis_depth(const depth_axis *a, int16_t code);

#endif
