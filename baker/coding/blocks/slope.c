/* The slope of a node; see plane.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/plane.h"

#include <stdlib.h>

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
    int     torn[ROWS]; /* of a row of blocks: blocks with a tile that has no single depth. No slope can help them */
} tile_bounds;

/* How many of two blocks have no common depth, from four columns of bounds each. */
static int folded_count(i16x8 low, i16x8 high)
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

static int torn_blocks(const tile_bounds *t)
{
    int count = 0;
    for (int row = 0; row < ROWS; row++) count += t->torn[row];
    return count;
}

/* Number of blocks without a common depth; stops at `enough`. */
static int blocks_left(const tile_bounds *t, node_slope s, int enough)
{
    row_shift across, down;
    int       count = torn_blocks(t);
    shift_along(&across, s.x);
    shift_along(&down, s.y);
    for (int row = 0; row < ROWS && count < enough; row++) {
        count -= t->torn[row];
        for (int n = 0; n < NODE_TILES; n += 8) {
            i16x8 low = i16x8_all(INT16_MIN), high = i16x8_all(INT16_MAX);
            i16x8 whole = i16x8_load(across.whole + n), part = i16x8_load(across.part + n);
            for (int y = 4 * row; y < 4 * row + 4; y++) {
                i16x8 up = whole + down.whole[y] + ((part + down.part[y]) >> 8);
                low      = i16x8_max(low, i16x8_adds(i16x8_load(t->emax + NODE_TILES * y + n), up));
                high     = i16x8_min(high, i16x8_adds(i16x8_load(t->xmin + NODE_TILES * y + n), up));
            }
            count += folded_count(low, high);
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

/* Mask elements are -1 in tiles without a single depth. */
static void find_torn(tile_bounds *t)
{
    for (int row = 0; row < ROWS; row++) {
        t->torn[row] = 0;
        for (int n = 0; n < NODE_TILES; n += 8) {
            i16x8 torn = i16x8_all(0);
            for (int y = 4 * row; y < 4 * row + 4; y++)
                torn |= (i16x8)(i16x8_load(t->emax + NODE_TILES * y + n) > i16x8_load(t->xmin + NODE_TILES * y + n));
            t->torn[row] += folded_count(i16x8_all(0), torn);
        }
    }
}

node_slope slope_find(const int32_t *emax, const int32_t *xmin, node_slope first)
{
    tile_bounds t;
    node_slope  best = {0, 0};
    int32_t     deepest, steps = 0;
    i32x4       most = i32x4_all(0);
    for (int n = 0; n < TILES; n += 4) most = i32x4_max(most, i32x4_load(emax + n));
    deepest = i32x4_greatest(most);
    while (deepest >> steps > 16384) steps++;
    for (int n = 0; n < TILES; n += 8) {
        i16x8_store(t.emax + n, i16x8_clamped(i32x4_load(emax + n) >> steps, i32x4_load(emax + n + 4) >> steps));
        i16x8_store(t.xmin + n, i16x8_clamped(i32x4_load(xmin + n) >> steps, i32x4_load(xmin + n + 4) >> steps));
    }
    first.x >>= steps;
    first.y >>= steps;
    find_torn(&t);

    /* a slope must save more than its own size */
    int fewest = blocks_left(&t, best, TILES) - 1;
    if (fewest <= torn_blocks(&t)) return best;

    /* median of the depth differences over four tiles, in 1/256 voxel per tile */
    int16_t across[STEPS], down[STEPS];
    int     count = 0;
    for (int a = 1; a < NODE_TILES; a += 2)
        for (int b = 0; b < NODE_TILES - 4; b += 2, count++) {
            across[count] = (int16_t)(t.emax[a * NODE_TILES + b + 4] - t.emax[a * NODE_TILES + b]);
            down[count]   = (int16_t)(t.emax[(b + 4) * NODE_TILES + a] - t.emax[b * NODE_TILES + a]);
        }
    node_slope middle = {-64 * middle_of(across), -64 * middle_of(down)};
    for (int n = -1; n < 25; n++) {
        node_slope s = n < 0 ? first : (node_slope){middle.x + (n % 5 - 2) * 32, middle.y + (n / 5 - 2) * 32};
        if (abs(s.x) > SLOPE_MAX || abs(s.y) > SLOPE_MAX || slope_shift_max(s) > SHIFT_MAX) continue;
        int left = blocks_left(&t, s, fewest) + (n >= 0);
        if (left >= fewest) continue;
        fewest = left;
        best   = s;
    }
    node_slope whole = {best.x * (1 << steps), best.y * (1 << steps)};
    return abs(whole.x) <= SLOPE_MAX && abs(whole.y) <= SLOPE_MAX ? whole : (node_slope){0, 0};
}
