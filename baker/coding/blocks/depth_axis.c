/* Maps the depths of a block to 16-bit codes; see depth_axis.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/depth_axis.h"

#include "baker/base/integer.h"
#include "baker/base/simd.h"

int axis_init(depth_axis *a, int32_t least_high, int32_t greatest_low)
{
    a->count = 0;
    a->floor = least_high > AXIS_MARGIN ? least_high - AXIS_MARGIN : 0;
    return greatest_low - a->floor <= INT16_MAX - AXIS_MARGIN;
}

/* A depth, and its index in the input. */
typedef struct placed_depth {
    int32_t depth, place;
} placed_depth;

/* A stable radix sort step: by one byte of the depths relative to `least`. */
static void order_by_byte(placed_depth *to, const placed_depth *from, int count, int32_t least, int shift)
{
    int next[256] = {0}, before = 0;
    for (int n = 0; n < count; n++) next[(from[n].depth - least) >> shift & 255]++;
    for (int byte = 0; byte < 256; byte++) {
        int of_byte = next[byte];
        next[byte]  = before;
        before += of_byte;
    }
    for (int n = 0; n < count; n++) to[next[(from[n].depth - least) >> shift & 255]++] = from[n];
}

void axis_init_by_depths(depth_axis *a, const int32_t *depths, int16_t *codes, int count)
{
    placed_depth first[AXIS_DEPTHS_MAX], second[AXIS_DEPTHS_MAX], *ordered = first, *other = second;
    int32_t      least = INT32_MAX, most = 0;
    for (int n = 0; n < count; n++) {
        least    = min_i32(least, depths[n]);
        most     = max_i32(most, depths[n]);
        first[n] = (placed_depth){depths[n], n};
    }
    for (int shift = 0; shift < 32 && (most - least) >> shift; shift += 8) {
        placed_depth *was = ordered;
        order_by_byte(other, ordered, count, least, shift);
        ordered = other;
        other   = was;
    }
    a->count = 0;
    for (int n = 0; n < count; n++) {
        if (!n || ordered[n].depth != a->depths[a->count - 1]) a->depths[a->count++] = ordered[n].depth;
        codes[ordered[n].place] = (int16_t)(2 * a->count - 1);
    }
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
