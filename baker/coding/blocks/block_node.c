/* The palette blocks of a square of 256 x 256 texels; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/base/cpu.h"
#include "baker/base/simd.h"
#include "baker/coding/blocks/block_build.h"

/* Give these bounds to `side` x `side` tiles. */
static ALWAYS_INLINE void give_bounds(node_builder *b, const column_bounds *bounds, uint32_t x, uint32_t y, uint32_t side)
{
    /* a column that is lit to the end may be lit beyond */
    int32_t emax = (int32_t)bounds->emax, xmin = bounds->xmin >= b->columns->depth_vx ? FAR_DEPTH : (int32_t)bounds->xmin;
    for (uint32_t row = y; row < y + side; row++)
        for (uint32_t n = NODE_TILES * row + x; n < NODE_TILES * row + x + side; n++) {
            b->emax[n] = emax;
            b->xmin[n] = xmin;
        }
}

/* Set the bounds of the tiles of a square of the node at tile (x, y). If all columns of a square are equal, its tiles get the
 * same bounds. */
static vxs_result bound_tiles(node_builder *b, uint32_t level, uint32_t x, uint32_t y)
{
    const column_square *from = b->columns;
    uint32_t             side = 1u << level;
    column_bounds        bounds;
    vxs_result           r = from->bounds(from->data, level, (b->tile_x + x) >> level, (b->tile_y + y) >> level, &bounds);
    if (r != VXS_OK || !level || bounds_alike(&bounds)) {
        give_bounds(b, &bounds, x, y, side);
        return r;
    }
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) {
        uint32_t inner_x = x + (c & 1) * side / 2, inner_y = y + (c >> 1) * side / 2;
        if (level > 1) {
            r = bound_tiles(b, level - 1, inner_x, inner_y);
            continue;
        }
        r = from->bounds(from->data, 0, b->tile_x + inner_x, b->tile_y + inner_y, &bounds);
        give_bounds(b, &bounds, inner_x, inner_y, 1);
    }
    return r;
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
        /* the depths that the block may have as its single depth */
        i32x4 low = i32x4_all(0), high = i32x4_all(2 * FAR_DEPTH);
        for (uint32_t row = 0, at = 4 * (NODE_TILES * (n / 8) + n % 8); row < 4; row++, at += NODE_TILES) {
            low  = i32x4_max(low, i32x4_load(b->emax + at));
            high = i32x4_min(high, i32x4_load(b->xmin + at));
        }
        run_range may      = {i32x4_greatest(low), i32x4_least(high)};
        b->chosen[n].count = 0;
        if (may.low > may.high) {
            b->node.mixed |= 1ull << n;
        } else if (!run_takes(&run, may.low, may.high)) {
            depth_of_run(b, first, n, run);
            run   = may;
            first = n;
        }
    }
    depth_of_run(b, first, NODE_BLOCKS, run);
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
    b->fine    = columns->depth_vx >> FINE_LEVELS != 0;
    b->tile_x  = NODE_TILES * x;
    b->tile_y  = NODE_TILES * y;
    b->node    = (block_node){.map = map, .x = map_x, .y = map_y, .emin = bounds.emin, .xmax = bounds.xmax};
    for (uint32_t n = 0; n < NODE_TILE_COUNT && columns->side_px < NODE_PX; n++) { /* tiles outside may have any depth */
        b->emax[n] = 0;
        b->xmin[n] = FAR_DEPTH;
    }
    if ((r = bound_tiles(b, level, 0, 0)) == VXS_OK) {
        node_slope last = s->node_count ? s->nodes[s->node_count - 1].slope : (node_slope){0, 0};
        b->node.slope   = slope_find(b->emax, b->xmin, last);

        if (b->node.slope.x || b->node.slope.y) {
            for (int32_t c = 0, n = 0; c < NODE_TILES; c++)
                for (int32_t a = 0; a < NODE_TILES; a++, n++) {
                    int32_t shift = slope_shift(b->node.slope, a, c);
                    b->emax[n] += shift;
                    b->xmin[n] += shift;
                }
        }

        r = build_blocks(b);
    }
    if (r == VXS_OK) r = block_set_add_node(s, &b->node);
    free(b);
    return r;
}
