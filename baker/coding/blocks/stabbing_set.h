/* Minimum stabbing set of intervals: the fewest points such that each interval contains one. These are the depths that an area of a
 * map needs.
 *
 * A column may have any depth in an interval [e, x]. With intervals sorted by x, the first one needs a point at its x or before. A
 * point at x stabs every interval that begins at or before it; the rest is solved in the same way. Afterwards a point may move
 * within [greatest e of the intervals that it stabs, x].
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef STABBING_SET_H
#define STABBING_SET_H

#include <stdint.h>

#include "baker/base/integer.h"
#include "baker/coding/blocks/patterns.h"

enum { INTERVALS_MAX = 1024 + 16, INTERVALS_SPARE = 32 };

/* Intervals [low, high], both 0..32767. Set the count to 0. */
typedef struct intervals {
    int16_t low[INTERVALS_MAX + INTERVALS_SPARE], high[INTERVALS_MAX + INTERVALS_SPARE];
    int     count;
} intervals;

/* Range of positions of one point. */
typedef struct stab_group {
    int16_t low, high;
} stab_group;

/* Find the points, in ascending order.
 * s       at least one interval; [out] more of them that change nothing
 * groups  [most]
 * most    stop after this number of points
 * cpu     level of cpu.h; the result does not depend on it
 * Returns the number of points. */
int minimum_stabbing_set(intervals *s, stab_group *groups, int most, int cpu);

/* The points in each of some ranges.
 * ranges       their number, a multiple of 8
 * points       [count] ascending, at most 127
 * first, last  [out] [ranges] index of the first and the last of them */
void points_of_ranges(const int16_t *low, const int16_t *high, int ranges, const int16_t *points, int count, uint8_t *first,
                      uint8_t *last);

/* Maps the depths of a block to 16-bit codes, for SIMD. Depths outside of all possible choices are clamped. If the depths of a
 * block span more than 16 bits, only the depths that occur have codes, and the gaps between them. */

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
    if (!a->count) return (int16_t)min_i32(max_i32(depth - a->floor, 0), INT16_MAX);
    axis_codes(a, &depth, &code, 1);
    return code;
}

/* Depth of a code that axis_codes returned for the end of an interval. */
int32_t axis_depth(const depth_axis *a, int16_t code);

/* Needs of a tile for a given palette: entries that it uses, and texels that must be lit or dark between them. */

/* Find the fewest entries that are enough for a tile, and the needs of each mask between two of them.
 * low, high  [64] ranges of texels, as codes
 * points     [count] codes of the palette's depths, ascending; the range of each texel contains at least one
 * from       the last entry that is at or before the ends of all ranges, or an earlier one
 * needs      [out] [entries - 1]
 * cpu        level of cpu.h; affects only time
 * Returns the bits of the entries. */
uint32_t tile_needs(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, int from, mask_need *needs,
                    int cpu);

#endif
