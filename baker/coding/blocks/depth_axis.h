/* Depths of a block on a scale of halves, for vectors of them: what lies beyond all choices is clamped. Where depths of one block lie
 * further apart than halves can tell, the scale has only those depths that occur, and what is between two of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DEPTH_AXIS_H
#define DEPTH_AXIS_H

#include <stdint.h>

enum { AXIS_DEPTHS_MAX = 2 * (1024 + 16), AXIS_MARGIN = 4096 };

typedef struct depth_axis {
    int32_t floor;                   /* the depth of code 0; codes are steps of one */
    int     count;                   /* 0, or the number of depths that codes stand for: depth n has 2n + 1, what is before it 2n */
    int32_t depths[AXIS_DEPTHS_MAX]; /* ascending */
} depth_axis;

/* A scale of steps of one, for intervals whose lows reach up to `greatest_low` and whose highs begin at `least_high`: any choice of depths
 * lies between. 0: halves are not enough. */
int axis_init(depth_axis *a, int32_t least_high, int32_t greatest_low);

/* A scale of the depths that occur.
 * depths  [count] of all ends of intervals, 0 or more each; at most AXIS_DEPTHS_MAX
 * codes   [out] [count] theirs */
void axis_init_by_depths(depth_axis *a, const int32_t *depths, int16_t *codes, int count);

/* Codes of depths: a < b where depths are in that order, and equal only where they are, or both are clamped. */
void axis_codes(const depth_axis *a, const int32_t *depths, int16_t *codes, int count);

static inline int16_t axis_code(const depth_axis *a, int32_t depth)
{
    int16_t code;
    axis_codes(a, &depth, &code, 1);
    return code;
}

/* The depth of a code that axis_codes gave for the end of an interval. */
int32_t axis_depth(const depth_axis *a, int16_t code);

#endif
