/* Depths of texels, for both codings; see tile_depths.h. Sums of palette blocks have 64 bits and are clamped to the bounds in a
 * square's entry, because the base of a record may be far outside the map.
 * SPDX-License-Identifier: MIT */
#include "tile_depths.h"

#include <string.h>

#include "vxs_lookup.h"

/* texels ---------------------------------------------------------------------------------------------------------------------- */

/* Column and row of texel z of quadrant c of a tile. */
static int32_t column_of(uint32_t c, uint32_t z)
{
    return (int32_t)(4 * (c & 1) + (z & 3));
}

static int32_t row_of(uint32_t c, uint32_t z)
{
    return (int32_t)(4 * (c >> 1) + (z >> 2));
}

static void plane_depths(vxs_blocks_tile plane, int32_t depth[64])
{
    for (uint32_t y = 0; y < 8; y++)
        for (uint32_t x = 0; x < 8; x++) depth[8 * y + x] = vxs_depths_plane(plane, x, y);
}

/* Depths of a tile of masks. Each mask contains the texels of the one before it. A texel has the depth of the first mask that
 * contains it. */
static void mask_depths(const uint32_t *words, const vxs_depths_tile *r, const int32_t *entries, int32_t depth[64])
{
    static const int32_t   bit[16] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
    const vxs_blocks_tile *tile    = &r->tile;
    uint32_t               next    = tile->at + ((tile->count + 1) >> 1);
    for (uint32_t c = 0; c < 4; c++) {
        int32_t quadrant[16], last = 0;
        for (int z = 0; z < 16; z++) quadrant[z] = entries[0];
        for (uint32_t n = 0; n < tile->count; n++) {
            uint32_t state = vxs_byte(words, tile->pool, 2 * tile->at + n) >> 2 * c & 3;
            if (state == 1) continue;
            if (state == 2) last = (int32_t)vxs_half(words, tile->pool, next++);
            int32_t bits = state == 0 ? 0 : last, deeper = entries[n + 1];
            for (int z = 0; z < 16; z++) quadrant[z] = bits & bit[z] ? quadrant[z] : deeper;
        }
        for (uint32_t y = 0; y < 4; y++) memcpy(depth + 8 * (4 * (c >> 1) + y) + 4 * (c & 1), quadrant + 4 * y, 4 * sizeof *depth);
    }
}

/* Nibble of a texel: an index, or relative to a base of its quadrant. */
static uint32_t tile_nibble(const uint32_t *words, const vxs_blocks_tile *tile, uint32_t c, uint32_t z)
{
    return vxs_byte(words, tile->pool, 2 * tile->at + 16 * (c & 1) + z) >> 4 * (c >> 1) & 15;
}

static void nibble_depths(const uint32_t *words, const vxs_depths_tile *r, const int32_t *entries, int32_t depth[64])
{
    for (uint32_t n = 0; n < 64; n++)
        depth[8 * row_of(n >> 4, n & 15) + column_of(n >> 4, n & 15)] = entries[tile_nibble(words, &r->tile, n >> 4, n & 15)];
}

/* Read the depths of all texels of a tile; returns as vxs_tile_depths. */
static int read_depths(const uint32_t *words, const vxs_depths_tile *r, int32_t depth[64])
{
    int32_t base = vxs_depths_held(r->base, -(1 << 29), 1 << 29), low = r->low,
            high = r->high; /* depths of planes are below 2^22 voxels */
    if (r->indexed) {
        int32_t entries[16];
        for (uint32_t n = 0; n < 16; n++) entries[n] = n <= r->last ? vxs_depths_of_index(words, r, n) : entries[n - 1];
        (r->tile.kind == VXS_BLOCKS_MASKS ? mask_depths : nibble_depths)(words, r, entries, depth);
        return VXS_TILE_MIXED;
    }
    depth[0] = vxs_depths_held(r->base, low, high);
    if (r->tile.kind == VXS_BLOCKS_SHADOW) return VXS_TILE_WHOLE;
    if (r->tile.kind < VXS_BLOCKS_PLANE) {
        for (uint32_t n = 0; n < 64; n++) {
            const vxs_blocks_tile *tile = &r->tile;
            uint32_t               c = n >> 4, z = n & 15, size = tile->kind - 3; /* bytes of a depth, but for nibbles */
            uint64_t               value              = tile->kind == VXS_BLOCKS_NIBBLES
                                                            ? tile_nibble(words, tile, c, z) + (tile->bases >> 8 * c & 0xff)
                                                            : vxs_four_bytes(words, tile->pool, 2 * tile->at + size * n) & vxs_first_bytes((int32_t)size);
            depth[8 * row_of(c, z) + column_of(c, z)] = vxs_depths_held(r->base + (int64_t)(value << r->shift), low, high);
        }
        return VXS_TILE_MIXED;
    }
    if (r->tile.kind == VXS_BLOCKS_PLANE)
        plane_depths(r->tile, depth);
    else {
        /* Depths of a tile of two planes: for each texel one of the two, as the kind of the tile selects it. */
        vxs_blocks_tile tile = r->tile;
        int32_t         second[64];
        plane_depths(vxs_blocks_one_plane(words, tile, 0), depth);
        plane_depths(vxs_blocks_one_plane(words, tile, 1), second);
        for (uint32_t c = 0; c < 4; c++) {
            uint32_t of_second = vxs_half(words, tile.pool, tile.at + 6 + c);
            for (uint32_t z = 0; z < 16; z++) {
                int32_t n = 8 * row_of(c, z) + column_of(c, z), is_less = second[n] < depth[n],
                        take = (int32_t)(of_second >> z & 1);
                if (tile.kind != VXS_BLOCKS_EITHER) take = tile.kind == VXS_BLOCKS_NEARER ? is_less : !is_less;
                if (take) depth[n] = second[n];
            }
        }
    }
    for (int n = 0; n < 64; n++) depth[n] = depth[n] + base < low ? low : depth[n] + base > high ? high : depth[n] + base;
    return VXS_TILE_MIXED;
}

/* entry points ---------------------------------------------------------------------------------------------------------------- */

/* Find the square of (i, j) in the top level, and its node if it is not uniform. */
static vxs_depth_square find_square(vxs_blocks_map m, int32_t i, int32_t j, vxs_blocks_node *node)
{
    vxs_depth_square s = vxs_depths_square_at(m.words, m.map, m.levels, i, j);
    if (s.least != s.greatest) *node = vxs_depths_node_of(m.words, m.map, m.levels, i, j, s.least);
    return s;
}

/* Set the cursor to the block of texel (i, j), whose square must not be uniform. */
static void set_cursor(vxs_block_cursor *c, vxs_blocks_map m, const vxs_depth_square *square, int32_t i, int32_t j)
{
    c->record = vxs_blocks_find_block(m.words, c->node, (uint32_t)((i >> 5 & 7) | (j >> 5 & 7) << 3));
    c->low    = square->least;
    c->high   = square->greatest;
}

static vxs_depths_tile tile_at(const vxs_block_cursor *c, const uint32_t *words, int32_t tile_x, int32_t tile_y)
{
    return vxs_depths_tile_of(words, c->node, c->record, tile_x & 31, tile_y & 31, c->low, c->high);
}

static int settled(const vxs_depth_square *s, int32_t k)
{
    return s->least == s->greatest || (k >= 0 && (k < s->least || k >= s->greatest));
}

/* Shrink a square to the part of side side_px around (i, j). */
static void part(vxs_depth_square *s, int32_t i, int32_t j, int32_t side_px)
{
    if (s->side_px <= side_px) return;
    s->i       = i & -side_px;
    s->j       = j & -side_px;
    s->side_px = side_px;
}

/* Bounds of a tile. With a palette they usually follow from it, without reading any texel. */
static vxs_depths_bounds bound_tile(const uint32_t *words, const vxs_depths_tile *r)
{
    vxs_depths_bounds b = vxs_depths_bound(words, r);
    int32_t           depth[64];
    if ((r->indexed && b.least <= b.greatest) || read_depths(words, r, depth) == VXS_TILE_WHOLE) return b;
    b.least = b.greatest = depth[0];
    for (int n = 1; n < 64; n++) {
        b.least    = depth[n] < b.least ? depth[n] : b.least;
        b.greatest = depth[n] > b.greatest ? depth[n] : b.greatest;
    }
    return b;
}

vxs_depth_square vxs_depth_square_at(vxs_blocks_map map, int32_t i, int32_t j, int32_t k, int32_t least_px)
{
    vxs_block_cursor c;
    vxs_depth_square s = find_square(map, i, j, &c.node);
    if (settled(&s, k) || s.side_px <= least_px) return s;
    set_cursor(&c, map, &s, i, j);
    part(&s, i, j, VXS_BLOCK_PX);
    vxs_depths_bounds b = vxs_depths_bound_block(map.words, c.node, c.record, s.i >> 3 & 28, s.j >> 3 & 28,
                                                 s.side_px / VXS_TILE_PX - 1, s.least, s.greatest);
    s.least             = b.least;
    s.greatest          = b.greatest;
    if (settled(&s, k) || s.side_px <= least_px) return s;
    vxs_depths_tile r = tile_at(&c, map.words, i >> 3, j >> 3);
    part(&s, i, j, VXS_TILE_PX);
    b          = bound_tile(map.words, &r);
    s.least    = b.least;
    s.greatest = b.greatest;
    if (settled(&s, k) || s.side_px <= least_px) return s;
    int32_t depth = vxs_depths_texel(map.words, &r, s.least, s.greatest, (uint32_t)(i & 7), (uint32_t)(j & 7));
    return (vxs_depth_square){.i = i, .j = j, .side_px = 1, .least = depth, .greatest = depth};
}

int vxs_tile_depths(vxs_blocks_map map, vxs_block_cursor *cursor, int32_t tile_x, int32_t tile_y, int32_t depth[64])
{
    int32_t  i = 8 * tile_x, j = 8 * tile_y;
    uint32_t number = 1 + (uint32_t)(tile_x >> 2) + ((uint32_t)(tile_y >> 2) << 13);
    if (cursor->block != number) {
        vxs_depth_square s = find_square(map, i, j, &cursor->node);
        cursor->block      = number;
        cursor->found      = !s.coarse;
        cursor->whole      = s.least == s.greatest ? s.least : -1;
        if (!s.coarse && cursor->whole < 0) set_cursor(cursor, map, &s, i, j);
    }
    if (!cursor->found) return VXS_TILE_MISSING;
    depth[0] = cursor->whole;
    if (cursor->whole >= 0) return VXS_TILE_WHOLE;
    vxs_depths_tile r = tile_at(cursor, map.words, tile_x, tile_y);
    return read_depths(map.words, &r, depth);
}

/* first shadows of a DAG -------------------------------------------------------------------------------------------------------- */

static uint32_t state_of(uint32_t states, uint32_t c)
{
    return states >> 2 * c & 3;
}

/* Address of own child c of a node. */
static uint32_t child_of(const uint32_t *dag, uint32_t node, uint32_t c)
{
    return dag[node + 1 + vxs_popcount(vxs_own(dag[node]) & ((1u << 2 * c) - 1))];
}

/* State of a walk down the columns of a tile. */
typedef struct column_walk {
    const uint32_t *dag;
    uint32_t        tile_x, tile_y;
    uint64_t        wanted; /* texels that have met no shadow yet */
    int32_t        *depth;
} column_walk;

/* Set the depth of wanted texels that are in shadow from k on. */
static void meet(column_walk *w, uint64_t mask, int32_t k)
{
    uint64_t met = mask & w->wanted;
    w->wanted &= ~mask;
    for (int n = 0; met; n++, met >>= 1)
        if (met & 1) w->depth[n] = k;
}

/* Walk a node of side 8 << level at depth k: its two children over the tile, the nearer first. A child that repeats the nearer
 * one adds no shadow and is skipped. */
static void walk_column(column_walk *w, uint32_t node, uint32_t level, int32_t k)
{
    if (level == 0) {
        /* Walk the slices of a node of side 8 at depth k. A slice that repeats the mask of the one before it adds no shadow and
         * is skipped. */
        for (uint32_t slice = 0; slice < 8 && w->wanted; slice++) {
            uint32_t state = state_of(w->dag[node], slice);
            if (state == VXS_CHILD_SHADOW) meet(w, ~(uint64_t)0, k + (int32_t)slice);
            if (state != VXS_CHILD_OWN) continue;
            const uint32_t *mask = w->dag + child_of(w->dag, node, slice);
            meet(w, mask[0] | (uint64_t)mask[1] << 32, k + (int32_t)slice);
        }
        return;
    }
    uint32_t bit = level - 1, xy = (w->tile_x >> bit & 1) | (w->tile_y >> bit & 1) << 1;
    for (uint32_t z = 0; z < 2 && w->wanted; z++) {
        uint32_t c = xy | z << 2, state = state_of(w->dag[node], c);
        int32_t  from = k + (int32_t)(z << (bit + 3));
        if (state == VXS_CHILD_SHADOW) meet(w, ~(uint64_t)0, from);
        if (state == VXS_CHILD_OWN) walk_column(w, child_of(w->dag, node, c), bit, from);
    }
}

void vxs_dag_first_shadows(const vxs_baked_light *baked, uint32_t map, uint32_t tile_x, uint32_t tile_y, uint64_t wanted,
                           int32_t depth[64])
{
    column_walk w = {baked->words, tile_x, tile_y, wanted, depth};
    walk_column(&w, baked->light.flags & VXS_LIGHT_CUBE ? vxs_face_root(baked->words, map) : 0, baked->light.levels - 3, 0);
    meet(&w, ~(uint64_t)0, 1 << baked->light.levels);
}
