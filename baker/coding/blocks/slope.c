/* The slope of a node; see plane.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/plane.h"

#include <stdlib.h>

#include "baker/base/cpu.h"
#include "baker/base/simd.h"

enum {
    TILES     = NODE_TILES * NODE_TILES,
    ROWS      = NODE_TILES / 4, /* of blocks */
    SHIFT_MAX = 12000,
    STEPS     = NODE_TILES / 2 * (NODE_TILES / 2 - 2) /* pairs of tiles from which slopes are estimated */
};

/* Bounds of tiles in steps that fit into 16 bits with a slope added. */
typedef struct tile_bounds {
    int16_t emax[TILES], xmin[TILES];
    int     helpless[ROWS]; /* number of helpless blocks (mixed_blocks) in a row of blocks */
} tile_bounds;

/* Blocks without a common depth, as bits. */
typedef struct mixed_blocks {
    uint64_t helpless; /* a tile has no single depth: no slope can help them */
    uint64_t others;
} mixed_blocks;

static int steps_of(int32_t deepest)
{
    int steps = 0;
    while (deepest >> steps > 16384) steps++;
    return steps;
}

/* The same bounds, as they are given. */
typedef struct node_bounds {
    const int32_t *emax, *xmin;
    int            steps;
} node_bounds;

/* Whether a block has no common depth with a slope.   helpless  [out] nonzero if a tile has no single depth */
static ALWAYS_INLINE int is_mixed(const node_bounds *b, int block, node_slope s, int *helpless)
{
    const int x = block % 8 * 4, y = block / 8 * 4;
    i32x4     low = i32x4_all(0), high = i32x4_all(INT32_MAX), mixed_tiles = i32x4_all(0);
    i32x4     shift = (i32x4){0, s.x, 2 * s.x, 3 * s.x} + (s.x * (s.x < 0 ? x - 31 : x) + s.y * (s.y < 0 ? y - 31 : y));
    for (int row = 0, at = NODE_TILES * y + x; row < 4; row++, at += NODE_TILES, shift += i32x4_all(s.y)) {
        i32x4 e = i32x4_load(b->emax + at) >> b->steps, exit = i32x4_load(b->xmin + at) >> b->steps;
        mixed_tiles |= (i32x4)(e > exit);
        low  = i32x4_max(low, e + (shift >> 8));
        high = i32x4_min(high, exit + (shift >> 8));
    }
    *helpless = (int)i32x4_bits(mixed_tiles);
    return i32x4_greatest(low) > i32x4_least(high);
}

static mixed_blocks mixed_without_slope(const node_bounds *b, uint64_t mixed)
{
    mixed_blocks f = {0, 0};
    for (; mixed; mixed &= mixed - 1) {
        int      helpless, mixed_now = is_mixed(b, __builtin_ctzll(mixed), (node_slope){0, 0}, &helpless);
        uint64_t block = mixed & -mixed;
        if (helpless)
            f.helpless |= block;
        else if (mixed_now)
            f.others |= block;
    }
    return f;
}

int slope_may_help(const int32_t *emax, const int32_t *xmin, int32_t deepest, uint64_t mixed)
{
    node_bounds b      = {emax, xmin, steps_of(deepest)};
    uint64_t    others = mixed_without_slope(&b, mixed).others;
    return (others & (others - 1)) != 0;
}

/* At least how many blocks have no common depth with a slope: the helpless ones, and others that it does not help. */
static int left_at_least(const node_bounds *b, uint64_t others, int helpless, node_slope s)
{
    for (int ignored; others; others &= others - 1) helpless += is_mixed(b, __builtin_ctzll(others), s, &ignored);
    return helpless;
}

/* How many of two blocks have no common depth, from four columns of bounds each. */
static int mixed_count(i16x8 low, i16x8 high)
{
    i16x8 no_depth = (i16x8)(i16x8_max_of_four(low) > i16x8_min_of_four(high));
    return -no_depth[0] - no_depth[4];
}

/* Depth added by a slope along a row of tiles: whole voxels, and the rest in 1/256 voxel. */
typedef struct row_shift {
    int16_t whole[NODE_TILES], part[NODE_TILES];
} row_shift;

static void shift_along(row_shift *r, int32_t slope)
{
    for (int x = 0; x < NODE_TILES; x++) {
        int32_t shift = slope < 0 ? slope * (x - 31) : slope * x;
        r->whole[x]   = (int16_t)(shift >> 8);
        r->part[x]    = (int16_t)(shift & 255);
    }
}

static int helpless_blocks(const tile_bounds *t)
{
    int count = 0;
    for (int row = 0; row < ROWS; row++) count += t->helpless[row];
    return count;
}

/* Number of blocks without a common depth; stops at `enough`. */
static int blocks_left(const tile_bounds *t, node_slope s, int enough)
{
    row_shift across, down;
    int       count = helpless_blocks(t);
    shift_along(&across, s.x);
    shift_along(&down, s.y);
    for (int row = 0; row < ROWS && count < enough; row++) {
        count -= t->helpless[row];
        for (int n = 0; n < NODE_TILES; n += 8) {
            i16x8 low = i16x8_all(INT16_MIN), high = i16x8_all(INT16_MAX);
            i16x8 whole = i16x8_load(across.whole + n), part = i16x8_load(across.part + n);
            for (int y = 4 * row; y < 4 * row + 4; y++) {
                i16x8 up = whole + down.whole[y] + ((part + down.part[y]) >> 8);
                low      = i16x8_max(low, i16x8_adds(i16x8_load(t->emax + NODE_TILES * y + n), up));
                high     = i16x8_min(high, i16x8_adds(i16x8_load(t->xmin + NODE_TILES * y + n), up));
            }
            count += mixed_count(low, high);
        }
    }
    return count;
}

/* Median of [STEPS]. */
static int middle_of(const int16_t *steps)
{
    int least = INT16_MIN, most = INT16_MAX; /* bisect the range that contains the median */
    while (least < most) {
        int   middle = (least + most) >> 1;
        i16x8 at = i16x8_all((int16_t)middle), count = i16x8_all(0);
        for (int n = 0; n < STEPS; n += 8) count -= (i16x8)(i16x8_load(steps + n) <= at);
        if (i16x8_sum(count) > STEPS / 2)
            most = middle;
        else
            least = middle + 1;
    }
    return least;
}

node_slope slope_find(const int32_t *emax, const int32_t *xmin, int32_t deepest, uint64_t mixed, node_slope first)
{
    tile_bounds  t;
    node_slope   best      = {0, 0};
    node_bounds  given     = {emax, xmin, steps_of(deepest)};
    const int    steps     = given.steps;
    mixed_blocks mixed_now = mixed_without_slope(&given, mixed);
    for (int n = 0; n < TILES; n += 8) {
        i16x8_store(t.emax + n, i16x8_clamped(i32x4_load(emax + n) >> steps, i32x4_load(emax + n + 4) >> steps));
        i16x8_store(t.xmin + n, i16x8_clamped(i32x4_load(xmin + n) >> steps, i32x4_load(xmin + n + 4) >> steps));
    }
    first.x >>= steps;
    first.y >>= steps;
    for (int row = 0; row < ROWS; row++) t.helpless[row] = __builtin_popcount(mixed_now.helpless >> 8 * row & 255);

    /* median of the depth differences over four tiles, in 1/256 voxel per tile */
    int16_t across[STEPS], down[STEPS];
    int     count = 0;
    for (int a = 1; a < NODE_TILES; a += 2)
        for (int b = 0; b < NODE_TILES - 4; b += 2, count++) {
            across[count] = (int16_t)(t.emax[a * NODE_TILES + b + 4] - t.emax[a * NODE_TILES + b]);
            down[count]   = (int16_t)(t.emax[(b + 4) * NODE_TILES + a] - t.emax[b * NODE_TILES + a]);
        }
    node_slope middle   = {-64 * middle_of(across), -64 * middle_of(down)};
    const int  helpless = helpless_blocks(&t);
    int        fewest   = helpless + __builtin_popcountll(mixed_now.others) - 1; /* a slope must save more than its own size */
    for (int n = -1; n < 25; n++) {
        node_slope s    = n < 0 ? first : (node_slope){middle.x + (n % 5 - 2) * 32, middle.y + (n / 5 - 2) * 32};
        int        cost = n >= 0;
        if (abs(s.x) > SLOPE_MAX || abs(s.y) > SLOPE_MAX || slope_shift_max(s) > SHIFT_MAX) continue;
        if (left_at_least(&given, mixed_now.others, helpless, s) + cost >= fewest) continue;
        int left = blocks_left(&t, s, fewest) + cost;
        if (left >= fewest) continue;
        fewest = left;
        best   = s;
    }
    node_slope whole = {best.x * (1 << steps), best.y * (1 << steps)};
    return abs(whole.x) <= SLOPE_MAX && abs(whole.y) <= SLOPE_MAX ? whole : (node_slope){0, 0};
}
