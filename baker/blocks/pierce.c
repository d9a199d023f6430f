/* The fewest points that pierce intervals; see pierce.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/blocks/pierce.h"

#include <string.h>

#include "baker/base/simd.h"

int pierce(intervals *s, pierce_group *groups, int most)
{
    const i16x8 far = i16x8_all(INT16_MAX);
    for (; s->count & 7; s->count++) {
        s->low[s->count]  = s->low[0];
        s->high[s->count] = s->high[0];
    }
    i16x8 next = far;
    for (int n = 0; n < s->count; n += 8) next = i16x8_min(next, i16x8_load(s->high + n));

    for (int count = 0;;) {
        /* one pass a point: vectors with nothing left to pierce are dropped, and the next point is found on the way */
        int   point = i16x8_least(next), kept = 0;
        i16x8 at = i16x8_all((int16_t)point), last_low = i16x8_all(INT16_MIN);
        next = far;
        for (int n = 0; n < s->count; n += 8) {
            i16x8 low = i16x8_load(s->low + n), high = i16x8_load(s->high + n), behind = (i16x8)(low > at);
            last_low = i16x8_max(last_low, i16x8_select(behind, last_low, low));
            next     = i16x8_min(next, i16x8_select(behind, high, far));
            i16x8_store(s->low + kept, low);
            i16x8_store(s->high + kept, high);
            kept += i16x8_any(behind) ? 8 : 0;
        }
        s->count        = kept;
        groups[count++] = (pierce_group){(int16_t)i16x8_greatest(last_low), (int16_t)point};
        if (!kept || count == most) return count;
    }
}

void points_of_ranges(const int16_t low[64], const int16_t high[64], const int16_t *points, int count, uint8_t first[64],
                      uint8_t last[64])
{
    for (int n = 0; n < 64; n += 8) {
        i16x8 l = i16x8_load(low + n), h = i16x8_load(high + n), from = i16x8_all(0), to = i16x8_all((int16_t)(count - 1));
        for (int point = 0; point < count; point++) {
            i16x8 at = i16x8_all(points[point]);
            from -= (i16x8)(l > at);
            to += (i16x8)(at > h);
        }
        i8x8 from_bytes = __builtin_convertvector(from, i8x8), to_bytes = __builtin_convertvector(to, i8x8);
        memcpy(first + n, &from_bytes, 8);
        memcpy(last + n, &to_bytes, 8);
    }
}
