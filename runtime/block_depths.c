/* Depths in palette blocks; see block_depths.h. Sums are of 64 bits, and held between the bounds that a square's entry has: a record may
 * have its base far from the map.
 * SPDX-License-Identifier: MIT */
#include "block_depths.h"

#include <string.h>

/* How the depths of a tile are kept: what is added to what each texel has, and where that is. */
typedef struct tile_record {
    vxs_blocks_tile
             tile; /* kind VXS_BLOCKS_SHADOW: all of it has depth `base`; planes: what is at most tile.k is shadow from it on */
    int64_t  base; /* of the map */
    int32_t  low, high;   /* bounds of the depths */
    uint32_t shift;       /* of nibbles and raw depths */
    int32_t  indexed;     /* 1: texels have the index of one of `entries`, by masks or nibbles */
    uint32_t last;        /* of them */
    int32_t  entries[16]; /* depths of the map */
} tile_record;

static int32_t held(int64_t depth, int32_t low, int32_t high)
{
    return depth < low ? low : depth > high ? high : (int32_t)depth;
}

/* Entry n of a palette, relative to the first; arguments as for vxs_blocks_rank. */
static int32_t palette_entry(const uint32_t *words, uint32_t at, uint32_t half_at, uint32_t width, uint32_t shift, uint32_t n)
{
    if (n == 0) return 0;
    uint32_t delta = width ? vxs_half(words, at, half_at + (n - 1) * width) : vxs_byte(words, at, 2 * half_at + n - 1);
    if (width == 2) delta |= vxs_half(words, at, half_at + 2 * n - 1) << 16;
    return held((int64_t)((uint64_t)delta << shift), 0, 1 << 29);
}

/* squares and blocks ------------------------------------------------------------------------------------------------------------- */

/* The first depth from which a coarse square is in shadow: it is so from one to the next, and vxs_blocks_find_node knows from which. */
static int32_t coarse_depth(vxs_blocks_map m, uint32_t x, uint32_t y, int32_t low, int32_t high)
{
    while (low < high) {
        int32_t middle = low + (high - low) / 2;
        if (vxs_blocks_find_node(m.words, m.map, m.levels, x, y, middle).kind == VXS_BLOCKS_SHADOW)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* What the top says of the square, or the cell, that (i, j) is in; and its node, when there is something in it. */
static vxs_depth_square find_square(vxs_blocks_map m, int32_t i, int32_t j, vxs_blocks_node *node)
{
    uint32_t x = (uint32_t)i >> 8, y = (uint32_t)j >> 8, entry = vxs_blocks_entry(m.words, m.map, m.levels, x, y);
    uint32_t place = m.words[entry], bounds, coarse = m.levels > 8 ? m.levels - 8 : 0;
    int32_t  side = 1 << m.levels, is_cell = 0;
    if (m.levels >= 15) is_cell = entry == m.words[2 + m.map] + ((y >> 3) << (m.levels - 11)) + (x >> 3);
    int32_t          side_px = is_cell ? VXS_CELL_PX : side < VXS_SQUARE_PX ? side : VXS_SQUARE_PX;
    vxs_depth_square s       = {.i = i & -side_px, .j = j & -side_px, .side_px = side_px};
    if (place >= 0x80000000u) {
        s.least = s.greatest = held(place & 0x7fffffffu, 0, side);
        return s;
    }
    bounds     = m.words[entry + 1];
    s.least    = held((bounds >> 16 & 0xff) << coarse, 0, side);
    s.greatest = held(((bounds >> 24) + 1) << coarse, 0, side);
    *node      = vxs_blocks_find_node(m.words, m.map, m.levels, x, y, s.least);
    node->k -= s.least;
    if (node->page) return s;
    s.coarse = 1;
    s.low    = s.least;
    s.high   = s.greatest;
    s.least = s.greatest = coarse_depth(m, x, y, s.low, s.high);
    return s;
}

/* How much nearer slanted ground makes depths of tile (x, y) of a node than those of its records. */
static int64_t slant(const vxs_blocks_node *node, int32_t x, int32_t y)
{
    return vxs_blocks_tile_depth(*node, x, y);
}

/* Bounds of block (x, y) of a node, whose square has those of `s`. Slopes have their greatest and least in its corners. */
static void bound_block(vxs_depth_square *s, const uint32_t *words, const vxs_blocks_node *node, const vxs_blocks_block *block)
{
    if (block->own) return; /* some of its tiles have depths that its palette does not */
    int32_t x = s->i >> 3 & 28, y = s->j >> 3 & 28, last = s->side_px / VXS_TILE_PX - 1;
    int64_t corner[4] = {slant(node, x, y), slant(node, x + last, y), slant(node, x, y + last), slant(node, x + last, y + last)};
    int64_t near = corner[0], far = corner[0];
    for (int n = 1; n < 4; n++) {
        near = corner[n] < near ? corner[n] : near;
        far  = corner[n] > far ? corner[n] : far;
    }
    int64_t deepest = palette_entry(words, block->palette, 0, block->head >> 8 & 3, block->head >> 4 & 15, block->head & 15);
    int32_t low = s->least, high = s->greatest;
    s->least    = held(block->base - far, low, high);
    s->greatest = held(block->base + deepest - near, low, high);
}

/* tiles --------------------------------------------------------------------------------------------------------------------------- */

/* A pattern of `count` masks, whose indices are of r->entries. */
static void read_pattern(tile_record *r, const uint32_t *words, uint32_t pool, uint32_t at, uint32_t count)
{
    r->tile    = vxs_blocks_pattern(words, pool, at, count, 0);
    r->indexed = 1;
    r->last    = count;
}

/* A pattern with depths of its own, of a tile whose base is r->base. */
static void read_own(tile_record *r, const uint32_t *words, uint32_t pool, uint32_t at)
{
    uint32_t first = vxs_half(words, pool, at), kind = first >> 12, shift = first >> 8 & 15, count = (first - 1) & 31;
    if (kind < VXS_BLOCKS_NIBBLES) {
        for (uint32_t n = 0; n <= count && n < 16; n++)
            r->entries[n] = held(r->base + palette_entry(words, pool, at + 1, kind, shift, n), r->low, r->high);
        read_pattern(r, words, pool, at + 1 + (kind ? kind * count : (count + 1) >> 1), count < 15 ? count : 15);
        return;
    }
    r->shift = shift;
    if (kind == VXS_BLOCKS_PLANE)
        r->tile = vxs_blocks_plane(vxs_four_bytes(words, pool, 2 * at + 2), shift, 7, 0, 0, -vxs_blocks_quarters(first, 0));
    else if (kind > VXS_BLOCKS_PLANE)
        r->tile = vxs_blocks_tile_of(kind, pool, at, 0, 0, 0);
    else if (kind == VXS_BLOCKS_NIBBLES)
        r->tile = vxs_blocks_tile_of(kind, pool, at + 3, 0, vxs_four_bytes(words, pool, 2 * at + 2), 0);
    else
        r->tile = vxs_blocks_tile_of(kind, pool, at + 1, 0, 0, 0);
}

/* A tile of the cursor's block, which slanted ground makes nearer. Entries that no texel has are not written. */
static void read_tile(tile_record *r, const uint32_t *words, const vxs_block_cursor *c, int32_t tile_x, int32_t tile_y)
{
    const vxs_blocks_block *b = &c->record;
    uint32_t                t = (uint32_t)((tile_x & 3) | (tile_y & 3) << 2), mixed = b->mixed >> t & 1, own = b->own >> t & 1;
    r->tile.kind = VXS_BLOCKS_SHADOW;
    r->base      = b->base - slant(&c->node, tile_x & 31, tile_y & 31);
    r->low       = c->low;
    r->high      = c->high;
    r->indexed   = 0;
    if (!mixed && !own) r->base += c->entries[vxs_blocks_entry_of_tile(words, *b, t)];
    if (!mixed && own) { /* the plane has the slope of the node in its own */
        r->base   = (int64_t)b->base - c->node.k;
        r->tile   = vxs_blocks_on_plane(words, *b, t, 0);
        r->tile.k = (int32_t)((uint32_t)r->tile.k - 255); /* of the limit at depth 0; words may hold any */
    }
    if (!mixed) return;

    uint32_t word = words[b->palette - vxs_popcount(b->mixed >> t)], used = word & 0x3fff, at = word >> 14 & 0x1ffff, count = 0;
    uint32_t pool = word >> 31 ? words[1] : b->page;
    if (own) {
        r->base += vxs_blocks_own_base(words, *b, t, used);
        read_own(r, words, pool, at);
        return;
    }
    for (uint32_t n = 0; used; n++, used >>= 1)
        if (used & 1) r->entries[count++] = held(r->base + c->entries[n], c->low, c->high);
    if (count > 1) read_pattern(r, words, pool, at, count - 1);
}

/* texels -------------------------------------------------------------------------------------------------------------------------- */

/* Texel z of quadrant c: how far right, and down, it lies. */
static int32_t column_of(uint32_t c, uint32_t z)
{
    return (int32_t)(4 * (c & 1) + (z & 3));
}

static int32_t row_of(uint32_t c, uint32_t z)
{
    return (int32_t)(4 * (c >> 1) + (z >> 2));
}

/* Of a plane, the depth of each texel less r->base: what of vxs_blocks_plane_texel is the least k that it is shadowed at. */
static void plane_depths(vxs_blocks_tile plane, int32_t depth[64])
{
    for (uint32_t y = 0; y < 8; y++)
        for (uint32_t x = 0; x < 8; x++) depth[8 * y + x] = (int32_t)(plane.count * x + plane.bases * y - (uint32_t)plane.k) >> 8;
}

/* Of two planes, that of either, as their kind has it. */
static void two_planes_depths(const uint32_t *words, vxs_blocks_tile tile, int32_t depth[64])
{
    int32_t second[64];
    plane_depths(vxs_blocks_one_plane(words, tile, 0), depth);
    plane_depths(vxs_blocks_one_plane(words, tile, 1), second);
    for (uint32_t c = 0; c < 4; c++) {
        uint32_t of_second = vxs_half(words, tile.pool, tile.at + 6 + c);
        for (uint32_t z = 0; z < 16; z++) {
            int32_t n = 8 * row_of(c, z) + column_of(c, z), is_less = second[n] < depth[n], take = (int32_t)(of_second >> z & 1);
            if (tile.kind != VXS_BLOCKS_EITHER) take = tile.kind == VXS_BLOCKS_NEARER ? is_less : !is_less;
            if (take) depth[n] = second[n];
        }
    }
}

/* Of masks, each of which has all texels of the one before it: the depth that a texel has by the first that has it. */
static void mask_depths(const uint32_t *words, const tile_record *r, int32_t depth[64])
{
    static const int32_t   bit[16] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
    const vxs_blocks_tile *tile    = &r->tile;
    uint32_t               next    = tile->at + ((tile->count + 1) >> 1);
    for (uint32_t c = 0; c < 4; c++) {
        int32_t quadrant[16], last = 0;
        for (int z = 0; z < 16; z++) quadrant[z] = r->entries[0];
        for (uint32_t n = 0; n < tile->count; n++) {
            uint32_t state = vxs_byte(words, tile->pool, 2 * tile->at + n) >> 2 * c & 3;
            if (state == 1) continue;
            if (state == 2) last = (int32_t)vxs_half(words, tile->pool, next++);
            int32_t bits = state == 0 ? 0 : last, deeper = r->entries[n + 1];
            for (int z = 0; z < 16; z++) quadrant[z] = bits & bit[z] ? quadrant[z] : deeper;
        }
        for (uint32_t y = 0; y < 4; y++) memcpy(depth + 8 * (4 * (c >> 1) + y) + 4 * (c & 1), quadrant + 4 * y, 4 * sizeof *depth);
    }
}

/* Of nibbles that are indices, or relative to a base of each quadrant. */
static uint32_t nibble_at(const uint32_t *words, const vxs_blocks_tile *tile, uint32_t c, uint32_t z)
{
    return vxs_byte(words, tile->pool, 2 * tile->at + 16 * (c & 1) + z) >> 4 * (c >> 1) & 15;
}

static int64_t raw_at(const uint32_t *words, const tile_record *r, uint32_t c, uint32_t z)
{
    const vxs_blocks_tile *tile = &r->tile;
    uint64_t               value;
    if (tile->kind == VXS_BLOCKS_NIBBLES)
        value = nibble_at(words, tile, c, z) + (tile->bases >> 8 * c & 0xff);
    else {
        uint32_t size = tile->kind - 3;
        value         = vxs_four_bytes(words, tile->pool, 2 * tile->at + size * (16 * c + z)) & vxs_first_bytes((int32_t)size);
    }
    return (int64_t)(value << r->shift);
}

static void nibble_depths(const uint32_t *words, const tile_record *r, int32_t depth[64])
{
    for (uint32_t n = 0; n < 64; n++)
        depth[8 * row_of(n >> 4, n & 15) + column_of(n >> 4, n & 15)] = r->entries[nibble_at(words, &r->tile, n >> 4, n & 15)];
}

/* All texels of a tile; returns as vxs_tile_depths. */
static int read_depths(const uint32_t *words, const tile_record *r, int32_t depth[64])
{
    int32_t base = held(r->base, -(1 << 29), 1 << 29), low = r->low, high = r->high; /* planes are less than 2^22 voxels deep */
    if (r->indexed) {
        (r->tile.kind == VXS_BLOCKS_MASKS ? mask_depths : nibble_depths)(words, r, depth);
        return VXS_TILE_MIXED;
    }
    depth[0] = held(r->base, low, high);
    if (r->tile.kind == VXS_BLOCKS_SHADOW) return VXS_TILE_WHOLE;
    if (r->tile.kind < VXS_BLOCKS_PLANE) {
        for (uint32_t n = 0; n < 64; n++)
            depth[8 * row_of(n >> 4, n & 15) + column_of(n >> 4, n & 15)] =
                held(r->base + raw_at(words, r, n >> 4, n & 15), low, high);
        return VXS_TILE_MIXED;
    }
    if (r->tile.kind == VXS_BLOCKS_PLANE)
        plane_depths(r->tile, depth);
    else
        two_planes_depths(words, r->tile, depth);
    for (int n = 0; n < 64; n++) depth[n] = depth[n] + base < low ? low : depth[n] + base > high ? high : depth[n] + base;
    return VXS_TILE_MIXED;
}

/* entry points --------------------------------------------------------------------------------------------------------------------- */

/* Put the cursor on the block that texel (i, j) is in; its square has something. */
static void set_cursor(vxs_block_cursor *c, vxs_blocks_map m, const vxs_depth_square *square, int32_t i, int32_t j)
{
    c->record   = vxs_blocks_find_block(m.words, c->node, (uint32_t)((i >> 5 & 7) | (j >> 5 & 7) << 3));
    c->low      = square->least;
    c->high     = square->greatest;
    uint32_t at = c->record.palette, width = c->record.head >> 8 & 3, shift = c->record.head >> 4 & 15;
    for (uint32_t n = 0; n <= (c->record.head & 15); n++) c->entries[n] = palette_entry(m.words, at, 0, width, shift, n);
}

static int settled(const vxs_depth_square *s, int32_t k)
{
    return s->least == s->greatest || (k >= 0 && (k < s->least || k >= s->greatest));
}

/* The part of a square of `side_px` about (i, j). */
static void part(vxs_depth_square *s, int32_t i, int32_t j, int32_t side_px)
{
    if (s->side_px <= side_px) return;
    s->i       = i & -side_px;
    s->j       = j & -side_px;
    s->side_px = side_px;
}

/* Bounds of a tile's depths that need none of them; entries of a palette grow. Returns 0 where there are none. */
static int bound_tile(vxs_depth_square *s, const tile_record *r)
{
    if (r->indexed) {
        s->least    = r->entries[0];
        s->greatest = r->entries[r->last];
        return s->least <= s->greatest;
    }
    if (r->tile.kind != VXS_BLOCKS_SHADOW) return 0;
    s->least = s->greatest = held(r->base, r->low, r->high);
    return 1;
}

static void read_all(vxs_depth_cursor *c, const uint32_t *words, const tile_record *r)
{
    c->has_depths = 1;
    if (read_depths(words, r, c->depth) == VXS_TILE_WHOLE)
        for (int n = 1; n < 64; n++) c->depth[n] = c->depth[0];
}

/* Put the cursor on the tile of its block that texel (i, j) is in. */
static void find_tile(vxs_depth_cursor *c, vxs_blocks_map m, int32_t i, int32_t j)
{
    tile_record r;
    read_tile(&r, m.words, &c->of_block, i >> 3, j >> 3);
    c->tile       = c->block;
    c->has_depths = 0;
    part(&c->tile, i, j, VXS_TILE_PX);
    if (bound_tile(&c->tile, &r)) return;
    read_all(c, m.words, &r);
    c->tile.least = c->tile.greatest = c->depth[0];
    for (int n = 1; n < 64; n++) {
        c->tile.least    = c->depth[n] < c->tile.least ? c->depth[n] : c->tile.least;
        c->tile.greatest = c->depth[n] > c->tile.greatest ? c->depth[n] : c->tile.greatest;
    }
}

static int is_in(const vxs_depth_square *s, int32_t i, int32_t j)
{
    return s->side_px && !(((i ^ s->i) | (j ^ s->j)) & -s->side_px);
}

static vxs_depth_square texel_of(vxs_depth_cursor *c, vxs_blocks_map m, int32_t i, int32_t j)
{
    if (!c->has_depths) {
        tile_record r;
        read_tile(&r, m.words, &c->of_block, i >> 3, j >> 3);
        read_all(c, m.words, &r);
    }
    int32_t depth = c->depth[8 * (j & 7) + (i & 7)];
    return (vxs_depth_square){.i = i, .j = j, .side_px = 1, .least = depth, .greatest = depth};
}

vxs_depth_square vxs_depth_square_at(vxs_blocks_map map, int32_t i, int32_t j, int32_t k, int32_t least_px, vxs_depth_cursor *kept)
{
    vxs_depth_cursor none, *c = kept ? kept : &none;
    if (!kept) none.block.side_px = none.tile.side_px = 0;
    if (!is_in(&c->tile, i, j)) {
        c->tile.side_px = 0;
        if (!is_in(&c->block, i, j)) {
            c->block.side_px   = 0;
            vxs_depth_square s = find_square(map, i, j, &c->of_block.node);
            if (settled(&s, k) || s.side_px <= least_px) return s;
            set_cursor(&c->of_block, map, &s, i, j);
            part(&s, i, j, VXS_BLOCK_PX);
            bound_block(&s, map.words, &c->of_block.node, &c->of_block.record);
            c->block = s;
        }
        if (settled(&c->block, k) || c->block.side_px <= least_px) return c->block;
        find_tile(c, map, i, j);
    }
    if (settled(&c->tile, k) || c->tile.side_px <= least_px) return c->tile;
    return texel_of(c, map, i, j);
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
    tile_record r;
    read_tile(&r, map.words, cursor, tile_x, tile_y);
    return read_depths(map.words, &r, depth);
}
