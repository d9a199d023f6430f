/* Depths of a block on a scale of halves; see depth_axis.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/blocks/depth_axis.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/simd.h"

static int ascending(const void *a, const void *b)
{
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

int axis_init(depth_axis *a, int32_t least_high, int32_t greatest_low)
{
    a->count = 0;
    a->floor = least_high > AXIS_MARGIN ? least_high - AXIS_MARGIN : 0;
    return greatest_low - a->floor <= INT16_MAX - AXIS_MARGIN;
}

void axis_init_by_depths(depth_axis *a, const int32_t *low, const int32_t *high, int count)
{
    int all = 2 * count;
    memcpy(a->depths, low, (size_t)count * sizeof *low);
    memcpy(a->depths + count, high, (size_t)count * sizeof *high);
    qsort(a->depths, (size_t)all, sizeof *a->depths, ascending);
    a->count = 0;
    for (int n = 0; n < all; n++)
        if (!n || a->depths[n] != a->depths[a->count - 1]) a->depths[a->count++] = a->depths[n];
}

static int16_t code_by_depths(const depth_axis *a, int32_t depth)
{
    int from = 0, to = a->count;
    while (from < to) {
        int middle = (from + to) / 2;
        if (a->depths[middle] < depth)
            from = middle + 1;
        else
            to = middle;
    }
    return (int16_t)(2 * from + (from < a->count && a->depths[from] == depth));
}

void axis_codes(const depth_axis *a, const int32_t *depths, int16_t *codes, int count)
{
    if (a->count) {
        for (int n = 0; n < count; n++) codes[n] = code_by_depths(a, depths[n]);
        return;
    }
    int n = 0;
    for (; n + 8 <= count; n += 8) {
        i16x8 code = i16x8_clamped(i32x4_load(depths + n) - a->floor, i32x4_load(depths + n + 4) - a->floor);
        i16x8_store(codes + n, i16x8_max(code, i16x8_all(0)));
    }
    for (; n < count; n++) {
        int32_t code = depths[n] - a->floor;
        codes[n]     = (int16_t)(code < 0 ? 0 : code > INT16_MAX ? INT16_MAX : code);
    }
}

int32_t axis_depth(const depth_axis *a, int16_t code)
{
    return a->count ? a->depths[code >> 1] : a->floor + code;
}
