/* The fewest points that pierce all of many intervals: the depths that an area of a map cannot do without.
 *
 * A column may have any depth of an interval [e, x]. Sorted by x, the first interval needs a point at its x at the latest, and a point
 * there pierces every interval that begins at or before it; what is left is the same question again. Each point may then be moved to
 * anywhere between the last of the e of what it pierces, and that x.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PIERCE_H
#define PIERCE_H

#include <stdint.h>

enum { INTERVALS_MAX = 1024 + 16, INTERVALS_SPARE = 32 };

/* Intervals [low, high], both 0..32767. Set the count to 0. */
typedef struct intervals {
    int16_t low[INTERVALS_MAX + INTERVALS_SPARE], high[INTERVALS_MAX + INTERVALS_SPARE];
    int     count;
} intervals;

/* Where one point may lie. */
typedef struct pierce_group {
    int16_t low, high;
} pierce_group;

/* The points that pierce a set, ascending; the set is used up.
 * s       at least one interval
 * groups  [most]
 * most    the search ends there
 * cpu     what may be used, of cpu.h: it decides on time alone
 * Returns their number. */
int pierce(intervals *s, pierce_group *groups, int most, int cpu);

/* Which points each texel of a tile may have: those in its range.
 * points       [count] ascending, at most 127
 * first, last  [out] the numbers of the first and the last of them */
void points_of_ranges(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, uint8_t first[64],
                      uint8_t last[64]);

#endif
