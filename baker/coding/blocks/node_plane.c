/* Nodes that lie on one plane as a whole. Their blocks get this plane, and are then few: nodes along a slanted sheet are equal.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/cpu.h"
#include "baker/coding/blocks/block_build.h"

enum {
    STEP       = 5, /* tiles between those that are looked at first */
    OFF_MOST   = 3, /* voxels that the greatest enter depths of tiles on a plane are off another plane */
    NODE_ZEROS = 3, /* low bits of slopes that are rounded to zero: eight steps of a block are then whole voxels */
    STEEPEST   = 32767,
    FEW        = 8, /* tiles on a side of those that are tried before all */
    BLOCK_SIDE = NODE_PX / 8,
};

/* Depth of tile (x, y) without the slope of the node. */
static int32_t tile_depth(const node_builder *b, int32_t x, int32_t y)
{
    return b->emax[NODE_TILES * y + x] - slope_shift(b->node.slope, x, y);
}

/* Whether tiles here and there are near a plane; most nodes are not.   p  [out] its slopes */
static int may_be_plane(const node_builder *b, plane *p)
{
    const int32_t last = NODE_TILES - 1, first = tile_depth(b, 0, 0);
    const int32_t across = tile_depth(b, last, 0) - first, down = tile_depth(b, 0, last) - first;
    for (int32_t y = 1; y < NODE_TILES; y += STEP)
        for (int32_t x = 1; x < NODE_TILES; x += STEP) {
            int64_t off = last * (int64_t)(tile_depth(b, x, y) - first) - (int64_t)x * across - (int64_t)y * down;
            if (off > OFF_MOST * last || off < -OFF_MOST * last) return 0;
        }
    if (abs(across) > STEEPEST || abs(down) > STEEPEST) return 0;
    *p = (plane){across * PLANE_ONE / (8 * last), down * PLANE_ONE / (8 * last), 0};
    return abs(p->across) < STEEPEST && abs(p->down) < STEEPEST;
}

/* Ranges of all texels of a node; and some tiles, with its corners. */
typedef struct node_ranges {
    plane_ranges        tile[NODE_TILE_COUNT];
    const plane_ranges *all[NODE_TILE_COUNT], *few[FEW * FEW];
} node_ranges;

static vxs_result fetch(node_builder *b, node_ranges *to, int32_t from, int *near)
{
    *near = 1;
    for (uint32_t n = 0; n < NODE_TILE_COUNT && *near; n++) {
        vxs_result r = block_fetch_tile(b, 0, n % NODE_TILES, n / NODE_TILES);
        if (r != VXS_OK) return r;
        *near         = tile_ranges_from(&to->tile[n], b, 0, from);
        to->tile[n].x = 8 * (int32_t)(n % NODE_TILES);
        to->tile[n].y = 8 * (int32_t)(n / NODE_TILES);
        to->all[n]    = &to->tile[n];
    }
    for (uint32_t n = 0; n < FEW * FEW; n++)
        to->few[n] = &to->tile[NODE_TILES * ((NODE_TILES - 1) * (n / FEW) / (FEW - 1)) + (NODE_TILES - 1) * (n % FEW) / (FEW - 1)];
    return VXS_OK;
}

/* Find only the depth of a plane through all tiles. Most planes that do not pass through all miss a few. */
static int place(plane *p, const node_ranges *t, int32_t least_room)
{
    plane at = *p;
    return plane_place(&at, t->few, FEW * FEW, NODE_PX, least_room) && plane_place(p, t->all, NODE_TILE_COUNT, NODE_PX, least_room);
}

/* A plane through all tiles: with slopes of another node, or else the roundest slopes. */
static int find(plane *p, const node_ranges *t, plane recent[PLANES_RECENT])
{
    for (int n = 0; n < PLANES_RECENT; n++) {
        plane next = recent[n];
        if (!place(&next, t, 0)) continue;
        *p = next;
        return 1;
    }
    if (!plane_fit(p, t->few, FEW * FEW, NODE_PX) || !plane_fit(p, t->all, NODE_TILE_COUNT, NODE_PX) || plane_shift(p)) return 0;
    for (int zeros = NODE_ZEROS; zeros; zeros--) {
        plane next = plane_rounded(p, zeros);
        if (plane_shift(&next) || !place(&next, t, PLANE_ONE / 4)) continue;
        *p = next;
        break;
    }
    return 1;
}

/* Make block n of a plane through the node. */
static vxs_result put_block(node_builder *b, const plane *p, uint32_t n)
{
    block         out;
    const int32_t x = BLOCK_SIDE * (int32_t)(n % 8), y = BLOCK_SIDE * (int32_t)(n / 8), last = NODE_PX - BLOCK_SIDE;
    memset(&out, 0, sizeof out);
    int32_t least    = p->least + p->across * (p->across < 0 ? x - last : x) + p->down * (p->down < 0 ? y - last : y);
    out.depths       = 1;
    b->node.depth[n] = max_i32(least >> 8, 0);
    out.plane        = (plane){p->across, p->down, least - b->node.depth[n] * PLANE_ONE};
    for (uint32_t t = 0; t < BLOCK_TILES; t++) out.tile[t].kind = TILE_PLANE;
    return block_set_find(b->set, &out, &b->node.block[n]);
}

vxs_result node_on_plane(node_builder *b, int *on)
{
    plane p;
    *on = 0;
    if (b->columns->side_px < NODE_PX || !may_be_plane(b, &p)) return VXS_OK;
    node_ranges *t    = malloc(sizeof *t);
    int32_t      from = INT32_MAX;
    if (!t) return VXS_E_MEMORY;
    for (int32_t n = 0; n < NODE_TILE_COUNT; n++) from = min_i32(from, tile_depth(b, n % NODE_TILES, n / NODE_TILES));
    int        near;
    vxs_result r     = fetch(b, t, from, &near);
    int        found = r == VXS_OK && near && find(&p, t, b->set->recent_nodes);
    free(t);
    if (!found) return r;
    plane_remember(b->set->recent_nodes, p);
    p.least += from * PLANE_ONE;
    for (uint32_t n = 0; n < NODE_BLOCKS && r == VXS_OK; n++) r = put_block(b, &p, n);
    b->node.slope = (node_slope){0, 0};
    b->set->tile_count += NODE_TILE_COUNT;
    *on = 1;
    return r;
}
