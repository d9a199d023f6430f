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

/* Find the points, in ascending order. Changes s.
 * s       at least one interval
 * groups  [most]
 * most    stop after this number of points
 * cpu     level of cpu.h; the result does not depend on it
 * Returns the number of points. */
int minimum_stabbing_set(intervals *s, stab_group *groups, int most, int cpu);

/* The points in the range of each texel of a tile.
 * points       [count] ascending, at most 127
 * first, last  [out] index of the first and the last of them */
void points_of_ranges(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, uint8_t first[64],
                      uint8_t last[64]);

#endif
