/* Palette blocks of a whole map; see block_build.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/base/cpu.h"
#include "baker/base/run_control.h"
#include "baker/base/z_order.h"
#include "baker/coding/blocks/block_build.h"
#include "baker/coding/blocks/block_file.h"
#include "baker/columns/descent.h"

enum { SQUARE_PX_MAX = 1024 };

uint32_t block_square_side(uint32_t map_side_px)
{
    return min_u32(map_side_px, max_u32(NODE_PX, min_u32(map_side_px / 4, SQUARE_PX_MAX)));
}

typedef struct map_builder {
    block_set *set;
    uint32_t   map, square_level, depth_vx;
    int        cpu;
    block_set  batch[DESCENT_BATCH];
} map_builder;

/* Before a fetch, a square is settled only if every part of it would get the same depth: bounds may be tighter after the fetch. */
static descent_step look(const void *user, const column_bounds *bounds, uint32_t level, int fetched)
{
    const map_builder *b = user;
    if (!fetched && (bounds->xmin >= b->depth_vx || bounds_alike(bounds))) return DESCENT_SETTLED;
    return level == b->square_level ? DESCENT_BUILD : DESCENT_SPLIT;
}

static vxs_result settle(void *user, const column_bounds *bounds, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b = user;
    return block_set_add_uniform(b->set, &(uniform_square){b->map, level, i, j, uniform_depth(bounds, b->depth_vx)});
}

static vxs_result build_slot(void *user, uint32_t slot, const column_square *columns, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b     = user;
    uint32_t     nodes = max_u32((8u << level) / NODE_PX, 1);
    vxs_result   r     = VXS_OK;
    b->batch[slot]     = (block_set){.patterns.cpu = b->cpu, .own.cpu = b->cpu};
    for (uint32_t n = 0; n < nodes * nodes && r == VXS_OK; n++) {
        z_place at = z_order(n);
        run_control_wait();
        r = block_build_node(&b->batch[slot], columns, b->map, i * nodes + at.i, j * nodes + at.j);
    }
    return r;
}

static vxs_result add_slot(void *user, uint32_t slot, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b = user;
    (void)level;
    (void)i;
    (void)j;
    return block_set_merge(b->set, &b->batch[slot]);
}

static vxs_result save_slot(void *user, uint32_t slot, vxs_bytes *out)
{
    map_builder *b = user;
    return block_set_save(&b->batch[slot], out);
}

static vxs_result load_slot(void *user, uint32_t slot, const vxs_bytes *bytes, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b    = user;
    uint32_t     side = max_u32((8u << level) / NODE_PX, 1);
    block_area   area = {b->map, b->depth_vx, i * side, j * side, side};
    if (level != b->square_level) return VXS_E_CORRUPT;
    return block_set_load(&b->batch[slot], bytes->data, bytes->size_bytes, &area);
}

static void drop_slot(void *user, uint32_t slot)
{
    map_builder *b = user;
    block_set_free(&b->batch[slot]);
}

/* Merging overlaps with building. */
static void time_batch(void *user, bake_context *ctx, int phase, uint32_t count, const double seconds[2])
{
    (void)user;
    (void)count;
    if (phase == 0) stage_begin(ctx, STAGE_MASKS);
    if (phase == 1) stage_begin_after(ctx, STAGE_NONE, STAGE_MAPS, (double[]){seconds[0], 0, seconds[1]}, 3);
}

vxs_result block_build_map(block_set *s, uint32_t map, const column_map *columns, bake_context *ctx)
{
    uint32_t side = block_square_side(columns->side_px);
    if (columns->fetch_px < side) return VXS_E_ARGUMENT;
    map_builder *b = calloc(1, sizeof *b);
    if (!b) return VXS_E_MEMORY;
    *b = (map_builder){.cpu = cpu_level(), .set = s, .map = map, .square_level = square_level(side), .depth_vx = columns->depth_vx};
    s->patterns.cpu = b->cpu;
    s->own.cpu      = b->cpu;
    descent    d    = {.user            = b,
                       .square_px       = side,
                       .squares_fetched = &s->squares_fetched,
                       .look            = look,
                       .settle          = settle,
                       .build           = build_slot,
                       .add             = add_slot,
                       .save            = save_slot,
                       .load            = load_slot,
                       .drop            = drop_slot,
                       .batch           = time_batch,
                       .add_early       = 1};
    vxs_result r    = descend(&d, columns, ctx);
    for (uint32_t n = 0; n < DESCENT_BATCH; n++) block_set_free(&b->batch[n]);
    free(b);
    return r;
}
