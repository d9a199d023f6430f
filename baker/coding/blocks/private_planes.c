/* Patterns of planes; see private_patterns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/private_patterns.h"

#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/integer.h"
#include "baker/base/simd.h"
#include "baker/coding/blocks/patterns.h"

enum {
    ONE_PLANE = 7,
    NEARER,
    FARTHER,
    BY_MASK,
    FAR_SHIFT_MAX = 5,
    PLANE_PART    = PLANE_ONE / 4, /* unit of least depths */
    FIRST_PARTS   = 3,             /* bits of their fraction */
    SECOND_PARTS  = 5
};

/* A range that any plane may pass. If the true range forbids it, the result is found invalid later, and is not used. */
enum { FAR_VX = PLANE_FREE / PLANE_ONE };

void plane_ranges_of(plane_ranges *to, const tile_ranges *t, int32_t from)
{
    const f32x4 far = f32x4_all(FAR_VX), last = f32x4_all(PLANE_ONE - 1), none = f32x4_all(PLANE_FREE);
    to->quadrants = 15;
    for (int n = 0; n < 64; n += 4) {
        f32x4 low  = __builtin_convertvector(i32x4_load(t->low + n) - from, f32x4);
        f32x4 high = __builtin_convertvector(i32x4_load(t->high + n) - from, f32x4);
        low        = f32x4_max(f32x4_min(low, far), -far) * PLANE_ONE;
        high       = f32x4_min(high * PLANE_ONE + last, none);
        memcpy(to->low + n, &low, sizeof low);
        memcpy(to->high + n, &high, sizeof high);
    }
}

/* Ranges of four texels in a row. */
typedef struct four_ranges {
    i32x4 low, high;
} four_ranges;

static ALWAYS_INLINE four_ranges four_of(const tile_ranges *t, int x, int y)
{
    int n = pattern_texel(x, y);
    return (four_ranges){i32x4_load(t->low + n), i32x4_load(t->high + n)};
}

/* The last two of `left` and the first two of `right`. */
static ALWAYS_INLINE four_ranges between(four_ranges left, four_ranges right)
{
    return (four_ranges){{left.low[2], left.low[3], right.low[0], right.low[1]},
                         {left.high[2], left.high[3], right.high[0], right.high[1]}};
}

/* Where a + b = c + d holds for every plane, but not for these ranges. Each holds a whole voxel more than its ends say. */
static ALWAYS_INLINE i32x4 differ(four_ranges a, four_ranges b, four_ranges c, four_ranges d)
{
    return (i32x4)(a.low + b.low > c.high + d.high + 1) | (i32x4)(c.low + d.low > a.high + b.high + 1);
}

int tile_may_be_plane(const tile_ranges *t)
{
    i32x4       out = i32x4_all(0);
    four_ranges left[8], middle[8], right[8];
    for (int y = 0; y < 8; y++) {
        left[y]  = four_of(t, 0, y);
        right[y] = four_of(t, 4, y);
    }
    for (int y = 0; y < 2; y++)
        out |= differ(left[y], left[y + 6], left[y + 3], left[y + 3]) | differ(right[y], right[y + 6], right[y + 3], right[y + 3]);
    if (i32x4_bits(out)) return 0;
    for (int y = 0; y < 8; y++) {
        middle[y] = between(left[y], right[y]);
        out |= differ(left[y], right[y], middle[y], middle[y]);
    }
    if (i32x4_bits(out)) return 0;
    for (int y = 0; y < 4; y++) {
        out |= differ(left[y], right[y + 4], middle[y + 2], middle[y + 2]);
        out |= differ(left[y + 4], right[y], middle[y + 2], middle[y + 2]);
        out |= differ(left[y + 4], right[y], left[y], right[y + 4]);
    }
    return !i32x4_bits(out);
}

static uint16_t slope_half(int32_t slope, int shift)
{
    return (uint16_t)(slope >> shift);
}

/* Subtract the whole voxels of the plane's least depth. Returns them. */
static int32_t whole_voxels(plane *p)
{
    int32_t whole = p->least >> 8;
    p->least -= whole * PLANE_ONE;
    return whole;
}

static int parts(const plane *p)
{
    return p->least / PLANE_PART;
}

/* Whether each depth is in its range. */
static int all_fit(const tile_ranges *t, const int32_t depth[64], int32_t base)
{
    i32x4 off = i32x4_all(0);
    for (int n = 0; n < 64; n += 4) {
        i32x4 d = i32x4_load(depth + n), at = d + base;
        off |= (i32x4)(d < 0) | (i32x4)(at < i32x4_load(t->low + n)) | (i32x4)(at > i32x4_load(t->high + n));
    }
    return !i32x4_bits(off);
}

void private_plane(private_planes *to, const tile_ranges *t)
{
    plane_ranges        ranges = {.x = 0};
    const plane_ranges *tile   = &ranges;
    int32_t             from   = least_high(t);
    to->count                  = 0;
    plane_ranges_of(&ranges, t, from);
    plane p = plane_start(&ranges);
    if (!plane_fit(&p, &tile, 1, 8)) return;
    plane_round(&p, &ranges);
    if (p.least % PLANE_PART) return;
    to->base = from + whole_voxels(&p);
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) to->depth[pattern_texel(x, y)] = plane_depth(&p, 8, x, y);
    if (!all_fit(t, to->depth, to->base)) return;
    int shift     = plane_shift(&p);
    to->halves[0] = (uint16_t)(ONE_PLANE << 12 | shift << 8 | parts(&p) << FIRST_PARTS);
    to->halves[1] = slope_half(p.across, shift);
    to->halves[2] = slope_half(p.down, shift);
    to->count     = PRIVATE_PLANE_HALVES;
}

/* Two planes in their stored form: relative to the nearer one, with slopes in the same unit. */
typedef struct plane_pair {
    plane    p[2];
    uint64_t second; /* texels of the second one */
    int      shift;
    int32_t  base;
    uint32_t far, far_shift; /* integer part of the second one's least depth: far << far_shift */
} plane_pair;

/* Returns 0 if they cannot be stored. */
static int prepare_pair(plane_pair *pair)
{
    plane *p = pair->p;
    if (p[0].least % PLANE_PART || p[1].least % PLANE_PART) return 0;
    if (p[1].least < p[0].least) {
        plane was    = p[0];
        p[0]         = p[1];
        p[1]         = was;
        pair->second = ~pair->second;
    }
    pair->shift = max_i32(plane_shift(&p[0]), plane_shift(&p[1]));
    for (int n = 0; n < 2; n++) {
        p[n].across = p[n].across & -(1 << pair->shift);
        p[n].down   = p[n].down & -(1 << pair->shift);
    }
    pair->base   = whole_voxels(&p[0]);
    uint32_t far = (uint32_t)(whole_voxels(&p[1]) - pair->base);
    for (pair->far_shift = 0; far >> pair->far_shift > 0xffff;) pair->far_shift++;
    pair->far = far >> pair->far_shift;
    return pair->far_shift <= FAR_SHIFT_MAX;
}

/* Returns the number of halves; 0: some texel's range does not contain its plane. */
static uint32_t encode_pair(private_planes *to, plane_pair pair, int kind, const tile_ranges *t, int32_t from)
{
    if (!prepare_pair(&pair)) return 0;
    uint16_t *halves = to->halves;
    to->base         = from + pair.base;

    const plane *first = &pair.p[0], *second = &pair.p[1];
    int32_t      far = (int32_t)(pair.far << pair.far_shift);
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            int     n = pattern_texel(x, y);
            int32_t a = plane_depth(first, 8, x, y), b = far + plane_depth(second, 8, x, y);
            to->depth[n] = kind == NEARER ? min_i32(a, b) : kind == FARTHER ? max_i32(a, b) : pair.second >> n & 1 ? b : a;
        }

    if (!all_fit(t, to->depth, to->base)) return 0;
    halves[0] = (uint16_t)((uint32_t)kind << 12 | (uint32_t)pair.shift << 8 | pair.far_shift);
    halves[0] |= (uint16_t)(parts(&pair.p[0]) << FIRST_PARTS | parts(&pair.p[1]) << SECOND_PARTS);
    for (int n = 0; n < 2; n++) {
        halves[1 + 2 * n] = slope_half(pair.p[n].across, pair.shift);
        halves[2 + 2 * n] = slope_half(pair.p[n].down, pair.shift);
    }
    halves[5] = (uint16_t)pair.far;
    if (kind != BY_MASK) return PRIVATE_PAIR_HALVES;
    for (int n = 0; n < 4; n++) halves[PRIVATE_PAIR_HALVES + n] = (uint16_t)(pair.second >> 16 * n);
    return PRIVATE_PLANES_HALVES_MAX;
}

void private_plane_pair(private_planes *to, const tile_ranges *t, int thorough)
{
    plane_ranges ranges = {.x = 0};
    plane_pair   found;
    int32_t      from = least_high(t);
    to->count         = 0;
    plane_ranges_of(&ranges, t, from);
    if (!plane_fit_pair(found.p, &found.second, &ranges, thorough)) return;
    if (!found.second) found.p[1] = found.p[0];
    for (int kind = NEARER; kind <= FARTHER && !to->count; kind++) {
        /* if the texels of each plane end where the planes meet, no mask is needed */
        plane_pair   pair   = found;
        plane_others others = kind == NEARER ? OTHERS_BEHIND : OTHERS_BEFORE;
        if (!plane_fit_texels(&pair.p[0], &ranges, ~pair.second, others)) continue;
        if (!plane_fit_texels(&pair.p[1], &ranges, pair.second, others)) continue;
        to->count = encode_pair(to, pair, kind, t, from);
    }
    if (to->count) return;
    plane_round_texels(&found.p[0], &ranges, ~found.second);
    plane_round_texels(&found.p[1], &ranges, found.second);
    to->count = encode_pair(to, found, BY_MASK, t, from);
}

int private_planes_are_sound(const uint16_t *halves, uint32_t count)
{
    if (count < PRIVATE_PLANE_HALVES) return 0;
    uint32_t kind = halves[0] >> 12, shift = halves[0] >> 8 & 15, parts = halves[0] & 0xff, far_shift = parts & 7;
    if (shift > PLANE_SHIFT_MAX) return 0;
    if (kind == ONE_PLANE) return count == PRIVATE_PLANE_HALVES && !(parts & ~(3u << FIRST_PARTS));
    return count == (kind == BY_MASK ? PRIVATE_PLANES_HALVES_MAX : PRIVATE_PAIR_HALVES) && kind > ONE_PLANE && kind <= BY_MASK &&
           far_shift <= FAR_SHIFT_MAX && parts < 1u << (SECOND_PARTS + 2);
}
