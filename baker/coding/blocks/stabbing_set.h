/* Minimum stabbing set of intervals: the fewest points so that each interval holds one. They are the depths that an area of a map needs.
 *
 * A column may have any depth of an interval [e, x]. Sorted by x, the first interval needs a point at its x at the latest, and a point
 * there stabs every interval that begins at or before it; the rest is solved in the same way. A point may then be moved to anywhere
 * between the greatest e of the intervals that it stabs, and that x.
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

/* Where one point may lie. */
typedef struct stab_group {
    int16_t low, high;
} stab_group;

/* Points in ascending order; the set is used up.
 * s       at least one interval
 * groups  [most]
 * most    number of points after which the search ends
 * cpu     of cpu.h; the result does not depend on it
 * Returns their number. */
int minimum_stabbing_set(intervals *s, stab_group *groups, int most, int cpu);

/* Which points each texel of a tile may have: those in its range.
 * points       [count] ascending, at most 127
 * first, last  [out] the numbers of the first and the last of them */
void points_of_ranges(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, uint8_t first[64],
                      uint8_t last[64]);

#endif
