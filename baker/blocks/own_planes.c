/* Patterns of planes; see own_planes.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/blocks/own_planes.h"

#include "baker/base/integer.h"
#include "baker/blocks/patterns.h"

enum { ONE_PLANE = 7, NEARER, FARTHER, BY_MASK, FAR_SHIFT_MAX = 5 };

/* What is so far away that any plane may pass it; where none may, what was found is not right, and is not taken. */
enum { FAR_VX = PLANE_FREE / PLANE_ONE };

void plane_ranges_of(plane_ranges *to, const tile_ranges *t, int32_t from)
{
    for (int n = 0; n < 64; n++) {
        int32_t low = t->low[n] - from, high = t->high[n] - from;
        to->low[n]  = (float)(max_i32(min_i32(low, FAR_VX), -FAR_VX) * PLANE_ONE);
        to->high[n] = (float)(high >= FAR_VX ? PLANE_FREE : high * PLANE_ONE + PLANE_ONE - 1);
    }
}

static int32_t least_high(const tile_ranges *t)
{
    int32_t least = t->high[0];
    for (int n = 1; n < 64; n++) least = min_i32(least, t->high[n]);
    return least;
}

static uint16_t slope_half(int32_t slope, int shift)
{
    return (uint16_t)(slope >> shift);
}

/* Whether each depth lies in its range. */
static int all_fit(const tile_ranges *t, const int32_t depth[64], int32_t base)
{
    for (int n = 0; n < 64; n++)
        if (depth[n] < 0 || depth[n] + base < t->low[n] || depth[n] + base > t->high[n]) return 0;
    return 1;
}

uint32_t own_plane(const tile_ranges *t, uint16_t *halves, int32_t depth[64], int32_t *base)
{
    plane_ranges        ranges = {.x = 0};
    const plane_ranges *tile   = &ranges;
    int32_t             from   = least_high(t);
    plane_ranges_of(&ranges, t, from);
    if (!plane_may_fit(&ranges)) return 0;
    plane p = plane_start(&ranges);
    if (!plane_fit(&p, &tile, 1, 8) || p.least % PLANE_ONE) return 0;
    *base   = from + p.least / PLANE_ONE;
    p.least = 0;
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) depth[pattern_texel(x, y)] = plane_depth(&p, 8, x, y);
    if (!all_fit(t, depth, *base)) return 0;
    int shift = plane_shift(&p);
    halves[0] = (uint16_t)(ONE_PLANE << 12 | shift << 8);
    halves[1] = slope_half(p.across, shift);
    halves[2] = slope_half(p.down, shift);
    return OWN_PLANE_HALVES;
}

/* Two planes as they are written: from the nearer one on, with slopes in the same steps. */
typedef struct plane_pair {
    plane    p[2];
    uint64_t second;
    int      shift;
    uint32_t far, far_shift; /* the second one's least depth: far << far_shift */
} plane_pair;

/* 0: they cannot be written. */
static int prepare_pair(plane_pair *pair)
{
    plane *p = pair->p;
    if (p[0].least % PLANE_ONE || p[1].least % PLANE_ONE) return 0;
    if (p[1].least < p[0].least) {
        plane was    = p[0];
        p[0]         = p[1];
        p[1]         = was;
        pair->second = ~pair->second;
    }
    pair->shift = max_i32(plane_shift(&p[0]), plane_shift(&p[1]));
    for (int n = 0; n < 2; n++) {
        p[n].across = p[n].across >> pair->shift << pair->shift;
        p[n].down   = p[n].down >> pair->shift << pair->shift;
    }
    uint32_t far = (uint32_t)(p[1].least - p[0].least) / PLANE_ONE;
    for (pair->far_shift = 0; far >> pair->far_shift > 0xffff;) pair->far_shift++;
    pair->far  = (far + (1u << pair->far_shift) - 1) >> pair->far_shift;
    p[1].least = (int32_t)(pair->far << pair->far_shift) * PLANE_ONE;
    p[0].least = 0;
    return pair->far <= 0xffff && pair->far_shift <= FAR_SHIFT_MAX;
}

static void depths_of_pair(const plane_pair *pair, int kind, int32_t depth[64])
{
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            int     n = pattern_texel(x, y);
            int32_t a = plane_depth(&pair->p[0], 8, x, y), b = plane_depth(&pair->p[1], 8, x, y);
            depth[n] = kind == NEARER ? min_i32(a, b) : kind == FARTHER ? max_i32(a, b) : pair->second >> n & 1 ? b : a;
        }
}

uint32_t own_plane_pair(const tile_ranges *t, uint32_t most, uint16_t *halves, int32_t depth[64], int32_t *base)
{
    plane_ranges ranges = {.x = 0};
    plane_pair   pair;
    int32_t      from = least_high(t);
    plane_ranges_of(&ranges, t, from);
    if (!plane_fit_pair(pair.p, &pair.second, &ranges)) return 0;
    if (!pair.second) pair.p[1] = pair.p[0];
    *base = from + min_i32(pair.p[0].least, pair.p[1].least) / PLANE_ONE;
    if (!prepare_pair(&pair)) return 0;
    for (int kind = NEARER; kind <= BY_MASK; kind++) {
        uint32_t count = kind == BY_MASK ? OWN_PLANES_HALVES_MAX : OWN_PAIR_HALVES;
        if (count > most) return 0;
        depths_of_pair(&pair, kind, depth);
        if (!all_fit(t, depth, *base)) continue;
        halves[0] = (uint16_t)((uint32_t)kind << 12 | (uint32_t)pair.shift << 8 | pair.far_shift);
        for (int n = 0; n < 2; n++) {
            halves[1 + 2 * n] = slope_half(pair.p[n].across, pair.shift);
            halves[2 + 2 * n] = slope_half(pair.p[n].down, pair.shift);
        }
        halves[5] = (uint16_t)pair.far;
        for (uint32_t n = OWN_PAIR_HALVES; n < count; n++) halves[n] = (uint16_t)(pair.second >> 16 * (n - OWN_PAIR_HALVES));
        return count;
    }
    return 0;
}
