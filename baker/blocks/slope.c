/* The slope of a node; see slope.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/blocks/slope.h"

#include <stdlib.h>

#include "baker/base/simd.h"

enum { TILES = NODE_TILES * NODE_TILES, SHIFT_MAX = 12000 };

/* Bounds of tiles in steps that fit into halves with a slope on top. */
typedef struct tile_bounds {
    int16_t emax[TILES], xmin[TILES];
} tile_bounds;

/* Which of two blocks of four columns of bounds have no depth: bounds are folded until each half of the vectors has its own. */
static int folded_count(i16x8 low, i16x8 high)
{
    int16_t l[8], h[8];
    int     count = 0;
    i16x8_store(l, low);
    i16x8_store(h, high);
    for (int n = 0; n < 8; n += 4) {
        int a = l[n], b = h[n];
        for (int m = n + 1; m < n + 4; m++) {
            a = l[m] > a ? l[m] : a;
            b = h[m] < b ? h[m] : b;
        }
        count += a > b;
    }
    return count;
}

/* Blocks that are left without a depth; counting ends at `enough`. */
static int blocks_left(const tile_bounds *t, node_slope s, int enough)
{
    int count = 0;
    for (int row = 0; row < NODE_TILES; row += 4) {
        i16x8 low[4], high[4];
        for (int n = 0; n < 4; n++) {
            low[n]  = i16x8_all(INT16_MIN);
            high[n] = i16x8_all(INT16_MAX);
        }
        for (int y = row; y < row + 4; y++) {
            int16_t shift[NODE_TILES];
            for (int x = 0; x < NODE_TILES; x++) shift[x] = (int16_t)slope_shift(s, x, y);
            for (int n = 0; n < 4; n++) {
                i16x8 up = i16x8_load(shift + 8 * n);
                low[n]   = i16x8_max(low[n], i16x8_adds(i16x8_load(t->emax + NODE_TILES * y + 8 * n), up));
                high[n]  = i16x8_min(high[n], i16x8_adds(i16x8_load(t->xmin + NODE_TILES * y + 8 * n), up));
            }
        }
        for (int n = 0; n < 4; n++) count += folded_count(low[n], high[n]);
        if (count >= enough) break;
    }
    return count;
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* The middle of how much deeper the map is four tiles on, in 1/256 voxel a tile. */
static node_slope middle_slope(const tile_bounds *t)
{
    int across[256], down[256], count = 0;
    for (int a = 1; a < NODE_TILES; a += 2)
        for (int b = 0; b < NODE_TILES - 4; b += 2, count++) {
            across[count] = (t->emax[a * NODE_TILES + b + 4] - t->emax[a * NODE_TILES + b]) * 64;
            down[count]   = (t->emax[(b + 4) * NODE_TILES + a] - t->emax[b * NODE_TILES + a]) * 64;
        }
    qsort(across, (size_t)count, sizeof *across, ascending);
    qsort(down, (size_t)count, sizeof *down, ascending);
    return (node_slope){-across[count / 2], -down[count / 2]};
}

static int within_range(node_slope s)
{
    return abs(s.x) <= SLOPE_MAX && abs(s.y) <= SLOPE_MAX && slope_shift_max(s) <= SHIFT_MAX;
}

node_slope slope_find(const int32_t *emax, const int32_t *xmin, node_slope first)
{
    tile_bounds t;
    node_slope  best    = {0, 0};
    int32_t     deepest = 0, steps = 0;
    for (int n = 0; n < TILES; n++) deepest = emax[n] > deepest ? emax[n] : deepest;
    while (deepest >> steps > 16384) steps++;
    for (int n = 0; n < TILES; n++) {
        t.emax[n] = (int16_t)(emax[n] >> steps);
        t.xmin[n] = (int16_t)(xmin[n] >> steps > INT16_MAX ? INT16_MAX : xmin[n] >> steps);
    }
    first.x >>= steps;
    first.y >>= steps;

    /* a slope has to save more than itself */
    int fewest = blocks_left(&t, best, TILES) - 1;
    if (fewest < 0) return best;
    node_slope middle = middle_slope(&t);
    for (int n = -1; n < 25; n++) {
        node_slope s = n < 0 ? first : (node_slope){middle.x + (n % 5 - 2) * 32, middle.y + (n / 5 - 2) * 32};
        if (!within_range(s)) continue;
        int left = blocks_left(&t, s, fewest + 1) + (n >= 0);
        if (left >= fewest) continue;
        fewest = left;
        best   = s;
    }
    node_slope whole = {best.x * (1 << steps), best.y * (1 << steps)};
    return abs(whole.x) <= SLOPE_MAX && abs(whole.y) <= SLOPE_MAX ? whole : (node_slope){0, 0};
}
