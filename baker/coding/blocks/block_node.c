/* The palette blocks of a square of 256 x 256 texels; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/base/cpu.h"
#include "baker/base/simd.h"
#include "baker/coding/blocks/block_build.h"

enum { BLOCK_LEVEL = 2 };

/* Set the bounds of the blocks of a square of the node, which begins at tile (x, y). If all columns of a square are equal, its
 * blocks get the same bounds. */
static vxs_result bound_blocks(node_builder *b, uint32_t level, uint32_t x, uint32_t y)
{
    const column_square *from = b->columns;
    uint32_t             side = 1u << level;
    column_bounds       *to   = &b->bounds[8 * (y / 4) + x / 4];
    vxs_result           r    = from->bounds(from->data, level, (b->tile_x + x) >> level, (b->tile_y + y) >> level, to);
    if (r != VXS_OK || level <= BLOCK_LEVEL) return r;
    if (bounds_alike(to)) {
        for (uint32_t n = 0, across = side / 4; n < across * across; n++) to[8 * (n / across) + n % across] = *to;
        return r;
    }
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) r = bound_blocks(b, level - 1, x + (c & 1) * side / 2, y + (c >> 1) * side / 2);
    return r;
}

/* A column that is lit to the end may be lit beyond. */
static int32_t exit_least(const node_builder *b, const column_bounds *bounds)
{
    return bounds->xmin >= b->columns->depth_vx ? FAR_DEPTH : (int32_t)bounds->xmin;
}

/* Set the bounds of the tiles of these blocks. */
static vxs_result bound_tiles(node_builder *b, uint64_t blocks)
{
    const column_square *from   = b->columns;
    const uint32_t       across = min_u32(from->side_px / 8, 4); /* tiles outside of a smaller map have their bounds */
    for (; blocks; blocks &= blocks - 1) {
        uint32_t      n = (uint32_t)__builtin_ctzll(blocks), x = n % 8 * 4, y = n / 8 * 4;
        column_bounds bounds = b->bounds[n];
        const int     alike  = bounds_alike(&bounds);
        for (uint32_t t = 0; t < across * across; t++) {
            uint32_t   tile_x = x + t % across, tile_y = y + t / across, at = NODE_TILES * tile_y + tile_x;
            vxs_result r = alike ? VXS_OK : from->bounds(from->data, 0, b->tile_x + tile_x, b->tile_y + tile_y, &bounds);
            if (r != VXS_OK) return r;
            b->emax[at] = (int32_t)bounds.emax;
            b->xmin[at] = exit_least(b, &bounds);
        }
    }
    return VXS_OK;
}

/* Add the slope to the bounds of tiles, and find the depths that each block may have then. */
static void add_slope(node_builder *b)
{
    for (int32_t y = 0, n = 0; y < NODE_TILES; y++)
        for (int32_t x = 0; x < NODE_TILES; x++, n++) {
            int32_t shift = slope_shift(b->node.slope, x, y);
            b->emax[n] += shift;
            b->xmin[n] += shift;
        }
    for (uint32_t n = 0; n < NODE_BLOCKS; n++) {
        i32x4 low = i32x4_all(0), high = i32x4_all(INT32_MAX);
        for (uint32_t row = 0, at = 4 * (NODE_TILES * (n / 8) + n % 8); row < 4; row++, at += NODE_TILES) {
            low  = i32x4_max(low, i32x4_load(b->emax + at));
            high = i32x4_min(high, i32x4_load(b->xmin + at));
        }
        b->may[n] = (run_range){i32x4_greatest(low), i32x4_least(high)};
    }
}

/* Choose the slope. Only blocks with more than one depth, and nodes that may have a slope, need bounds of tiles. */
static vxs_result choose_slope(node_builder *b)
{
    uint64_t mixed   = 0;
    int32_t  deepest = 0;
    for (uint32_t n = 0; n < NODE_BLOCKS; n++) {
        b->may[n] = (run_range){(int32_t)b->bounds[n].emax, exit_least(b, &b->bounds[n])};
        mixed |= (uint64_t)(b->may[n].low > b->may[n].high) << n;
        deepest = max_i32(deepest, b->may[n].low);
    }
    vxs_result r = bound_tiles(b, mixed);
    if (r != VXS_OK || !slope_may_help(b->emax, b->xmin, deepest, mixed)) return r;
    r = bound_tiles(b, ~mixed);
    if (r != VXS_OK) return r;
    const block_set *s    = b->set;
    node_slope       last = s->node_count ? s->nodes[s->node_count - 1].slope : (node_slope){0, 0};
    b->node.slope         = slope_find(b->emax, b->xmin, deepest, mixed, last);
    if (b->node.slope.x || b->node.slope.y) add_slope(b);
    return VXS_OK;
}

/* Give one depth to the blocks of single depth in [first, end): that of a block above one of them, where possible. */
static void depth_of_run(node_builder *b, uint32_t first, uint32_t end, run_range run)
{
    int32_t depth = run.low;
    for (uint32_t n = first > 8 ? first : 8, found = 0; n < end && !found && b->fine; n++) {
        const block_depths *above = &b->chosen[n - 8];
        found = !(b->node.mixed >> n & 1) && above->count && run.low <= above->depth[0] && above->depth[0] <= run.high;
        if (found) depth = above->depth[0];
    }
    for (uint32_t n = first; n < end; n++) {
        if (b->node.mixed >> n & 1) continue;
        b->node.depth[n] = b->chosen[n].depth[0] = depth;
        b->chosen[n].count                       = 1;
    }
}

/* Blocks of a single depth take the depth of the blocks before, where possible. The others follow when these are known. */
static vxs_result build_blocks(node_builder *b)
{
    run_range run   = {0, INT32_MAX};
    uint32_t  first = 0;
    for (uint32_t n = 0; n < NODE_BLOCKS; n++) {
        const run_range may = b->may[n];
        b->chosen[n].count  = 0;
        if (may.low > may.high) {
            b->node.mixed |= 1ull << n;
        } else if (!run_takes(&run, may.low, may.high)) {
            depth_of_run(b, first, n, run);
            run   = may;
            first = n;
        }
    }
    depth_of_run(b, first, NODE_BLOCKS, run);
    if (b->node.mixed == UINT64_MAX) {
        int        on;
        vxs_result r = node_on_plane(b, &on);
        if (r != VXS_OK || on) return r;
    }
    for (uint64_t rest = b->node.mixed; rest; rest &= rest - 1) {
        uint32_t n   = (uint32_t)__builtin_ctzll(rest);
        b->number    = n;
        vxs_result r = block_build(b, &b->node.block[n], &b->node.depth[n]);
        if (r != VXS_OK) return r;
    }
    return VXS_OK;
}

vxs_result block_build_node(block_set *s, const column_square *columns, uint32_t map, uint32_t x, uint32_t y)
{
    uint32_t      level = square_level(min_u32(columns->side_px, NODE_PX));
    column_bounds bounds;
    vxs_result    r = columns->bounds(columns->data, level, x, y, &bounds);
    if (r != VXS_OK) return r;
    uint32_t map_x = columns->u_px / NODE_PX + x, map_y = columns->v_px / NODE_PX + y;
    if (bounds.emax <= bounds.xmin)
        return block_set_add_uniform(
            s, &(uniform_square){map, square_level(NODE_PX), map_x, map_y, uniform_depth(&bounds, columns->depth_vx)});

    node_builder *b = malloc(sizeof *b);
    if (!b) return VXS_E_MEMORY;
    b->set     = s;
    b->columns = columns;
    b->fine    = !s->fast && columns->depth_vx >> FINE_LEVELS != 0;
    b->tile_x  = NODE_TILES * x;
    b->tile_y  = NODE_TILES * y;
    b->node    = (block_node){.map = map, .x = map_x, .y = map_y, .emin = bounds.emin, .xmax = bounds.xmax};
    if (columns->side_px < NODE_PX) { /* outside there may be any depth */
        for (uint32_t n = 0; n < NODE_BLOCKS; n++)
            b->bounds[n] = (column_bounds){.xmin = columns->depth_vx, .xmax = columns->depth_vx};
        for (uint32_t n = 0; n < NODE_TILE_COUNT; n++) {
            b->emax[n] = 0;
            b->xmin[n] = FAR_DEPTH;
        }
    }
    r = bound_blocks(b, level, 0, 0);
    if (r == VXS_OK) r = choose_slope(b);
    if (r == VXS_OK) r = build_blocks(b);
    if (r == VXS_OK) r = block_set_add_node(s, &b->node);
    free(b);
    return r;
}
