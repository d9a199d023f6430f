/* Depths in palette blocks: where shadow begins in squares of texels, blocks, tiles, and single texels. A lookup finds
 * whether one voxel is in shadow; these functions read the same records (vxs_lookup_blocks.h) for the depth itself, and for
 * bounds of it. Every texel has one depth (formats/vxs.md 13). One text for C99, C++, GLSL and HLSL.
 *
 *     vxs_depths_square_at   bounds from the top, of the square or cell that contains a texel
 *     vxs_depths_node_of     the node of a square that has one
 *     vxs_depths_bound_block bounds of a block
 *     vxs_depths_tile_of     a tile, as it is stored
 *     vxs_depths_bound       bounds of a tile
 *     vxs_depths_texel       the depth of one texel of a tile
 *
 * Offsets are not checked here. For any words, loops end, and depths lie within the bounds of the square.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DEPTHS_H
#define VXS_DEPTHS_H

#ifndef VXS_SPACE_H /* a shader that cannot include already has this text */
#include "vxs_space.h"
#endif

#ifdef VXS_C
typedef struct vxs_depths_square vxs_depths_square;
typedef struct vxs_depths_tile   vxs_depths_tile;
typedef struct vxs_depths_bounds vxs_depths_bounds;
typedef int64_t                  vxs_sum; /* 64 bits: damaged records may have a base far from the map */
#define VXS_SUM(x)      VXS_CAST(vxs_sum, x)
#define VXS_DEPTHS_TILE const vxs_depths_tile *
#else
#define vxs_sum         int
#define VXS_SUM(x)      int(x)
#define VXS_DEPTHS_TILE const vxs_depths_tile
#endif

/* A square of texels. For each of its texels, voxels before `least` are lit, and voxels from `greatest` on are in shadow. */
struct vxs_depths_square {
    vxs_i32 i, j, side_px;   /* first texel; side: a power of two, at most that of the map */
    vxs_i32 least, greatest; /* [0, 2^levels]; equal: all texels have this depth */
    vxs_i32 coarse;          /* 1: the page is missing, and least and greatest are the coarse answer (vxs_lookup_blocks.h) */
    /* for a coarse square: exact bounds; voxels before low are lit, voxels from high on are in shadow */
    vxs_i32 low, high;
};

#ifndef VXS_TABLES /* which shaders of libvxs_gl read in place of records */

/* A tile of 8 x 8 texels: the base depth, and where the depths of the texels relative to it are stored. */
struct vxs_depths_tile {
    /* kind VXS_BLOCKS_SHADOW: the whole tile has depth `base`; planes: texels whose plane depth is at most tile.k are in shadow
     * from depth `base` on */
    vxs_blocks_tile tile;
    vxs_sum         base;      /* relative to the map */
    vxs_i32         low, high; /* bounds of the depths */
    vxs_u32         shift;     /* left shift of nibbles, of raw depths, or of the deltas of the palette */
    vxs_u32         indexed;   /* 1: texels have an index into a palette, as masks or as nibbles */
    vxs_u32         last;      /* greatest index */
    vxs_u32         used;      /* palette entries that indices count: index n is the n-th bit set; 0: all entries */
    vxs_u32         palette, palette_half, width; /* as for vxs_blocks_rank */
};

struct vxs_depths_bounds {
    vxs_i32 least, greatest;
};

VXS_FN vxs_i32 vxs_depths_held(vxs_sum depth, vxs_i32 low, vxs_i32 high)
{
    return depth < low ? low : depth > high ? high : VXS_I(depth);
}

/* Palette entry n, relative to the first entry; clamped to 2^29. Arguments as for vxs_blocks_rank. */
VXS_FN vxs_i32 vxs_depths_entry(VXS_WORDS blocks, vxs_u32 at, vxs_u32 half_at, vxs_u32 width, vxs_u32 shift, vxs_u32 n)
{
    if (n == 0u) return 0;
    vxs_u32 delta, most = 0x20000000u;
    if (width == 0u)
        delta = vxs_byte(blocks, at, 2u * half_at + n - 1u);
    else
        delta = vxs_half(blocks, at, half_at + (n - 1u) * width);
    if (width == 2u) delta |= vxs_half(blocks, at, half_at + 2u * n - 1u) << 16;
    return VXS_I(delta > most >> shift ? most : delta << shift);
}

/* squares and blocks ----------------------------------------------------------------------------------------------------------- */

/* The square of 256 x 256 texels that contains texel (i, j); or its whole cell, if all squares of the cell have the same
 * depth. */
VXS_FN vxs_depths_square vxs_depths_square_at(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j)
{
    vxs_depths_square s;
    vxs_u32           x = VXS_U(i) >> 8, y = VXS_U(j) >> 8, entry = vxs_blocks_entry(blocks, map, levels, x, y);
    vxs_u32           place = vxs_word(blocks, entry), coarse = levels > 8u ? levels - 8u : 0u;
    vxs_i32           side = VXS_I(1) << levels;
    s.side_px              = side < 256 ? side : 256;
    if (levels >= 15u && entry == vxs_word(blocks, 2u + map) + ((y >> 3) << (levels - 11u)) + (x >> 3)) s.side_px = 2048;
    s.i      = i & -s.side_px;
    s.j      = j & -s.side_px;
    s.coarse = 0;
    s.low    = 0;
    s.high   = side;
    s.least = s.greatest = vxs_clamp(VXS_I(place & 0x7fffffffu), 0, side);
    if (place >= 0x80000000u) return s;
    vxs_u32 bounds = vxs_word(blocks, entry + 1u), nearest = (bounds >> 16) & 0xffu, farthest = bounds >> 24;
    s.least    = vxs_clamp(VXS_I(nearest << coarse), 0, side);
    s.greatest = vxs_clamp(VXS_I((farthest + 1u) << coarse), 0, side);
    if (vxs_word(blocks, 8u + (place >> 16)) != 0u) return s;
    s.coarse = 1;
    s.low    = s.least;
    s.high   = s.greatest;
    s.least = s.greatest = vxs_clamp(VXS_I(((nearest + farthest) / 2u + 1u) << coarse), s.low, s.high);
    return s;
}

/* The node of the square that contains texel (i, j); its k corresponds to depth 0.
 * least  of the square, which has neither a single depth nor a coarse answer */
VXS_FN vxs_blocks_node vxs_depths_node_of(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_i32 least)
{
    vxs_blocks_node node = vxs_blocks_find_node(blocks, map, levels, VXS_U(i) >> 8, VXS_U(j) >> 8, least);
    node.k -= least;
    return node;
}

/* Bounds of a block; (x, y) is its first tile in its node, and it has last + 1 tiles a side. The slope is least and greatest
 * in two of its corners.
 * low, high  bounds of the square */
VXS_FN vxs_depths_bounds vxs_depths_bound_block(VXS_WORDS blocks, vxs_blocks_node node, vxs_blocks_block block, vxs_i32 x,
                                                vxs_i32 y, vxs_i32 last, vxs_i32 low, vxs_i32 high)
{
    vxs_depths_bounds b;
    b.least    = low;
    b.greatest = high;
    if (block.own != 0u) return b; /* some tiles have depths that are not in the palette */
    vxs_i32 left = (node.slope & 0x8000u) != 0u ? x + last : x, right = 2 * x + last - left;
    vxs_i32 up = node.slope >= 0x80000000u ? y + last : y, down = 2 * y + last - up;
    vxs_sum near = vxs_blocks_tile_depth(node, left, up), far = vxs_blocks_tile_depth(node, right, down);
    vxs_sum deepest =
        vxs_depths_entry(blocks, block.palette, 0u, (block.head >> 8) & 3u, (block.head >> 4) & 15u, block.head & 15u);
    b.least    = vxs_depths_held(block.base - far, low, high);
    b.greatest = vxs_depths_held(block.base + deepest - near, low, high);
    return b;
}

/* tiles ------------------------------------------------------------------------------------------------------------------------ */

/* A tile with a private-palette pattern; its base is r.base. */
VXS_FN vxs_depths_tile vxs_depths_own(VXS_WORDS blocks, vxs_depths_tile r, vxs_u32 pool, vxs_u32 at)
{
    vxs_u32 first = vxs_half(blocks, pool, at), kind = first >> 12, count = (first - 1u) & 31u;
    r.shift = (first >> 8) & 15u;
    if (kind < VXS_BLOCKS_NIBBLES) {
        r.indexed      = 1u;
        r.last         = count < 15u ? count : 15u;
        r.used         = 0u;
        r.palette      = pool;
        r.palette_half = at + 1u;
        r.width        = kind;
        r.tile         = vxs_blocks_pattern(blocks, pool, at + 1u + (kind != 0u ? kind * count : (count + 1u) >> 1), r.last, 0u);
    } else if (kind == VXS_BLOCKS_PLANE)
        r.tile = vxs_blocks_plane(vxs_four_bytes(blocks, pool, 2u * at + 2u), r.shift, 7u, 0u, 0u, -vxs_blocks_quarters(first, 0u));
    else if (kind > VXS_BLOCKS_PLANE)
        r.tile = vxs_blocks_tile_of(kind, pool, at, 0u, 0u, 0);
    else if (kind == VXS_BLOCKS_NIBBLES)
        r.tile = vxs_blocks_tile_of(kind, pool, at + 3u, 0u, vxs_four_bytes(blocks, pool, 2u * at + 2u), 0);
    else
        r.tile = vxs_blocks_tile_of(kind, pool, at + 1u, 0u, 0u, 0);
    return r;
}

/* Depth of tile (x, y) of a node, x and y 0 to 31, which has neither a pattern nor a plane. The slope of the node is
 * subtracted. */
VXS_INLINE vxs_i32 vxs_depths_whole(VXS_WORDS blocks, vxs_blocks_node node, vxs_blocks_block block, vxs_i32 x, vxs_i32 y,
                                    vxs_i32 low, vxs_i32 high)
{
    vxs_u32 n = vxs_blocks_entry_of_tile(blocks, block, VXS_U((x & 3) | ((y & 3) << 2))), last = block.head & 15u;
    vxs_i32 more =
        vxs_depths_entry(blocks, block.palette, 0u, (block.head >> 8) & 3u, (block.head >> 4) & 15u, n < last ? n : last);
    return vxs_depths_held(VXS_SUM(block.base) + more - vxs_blocks_tile_depth(node, x, y), low, high);
}

/* Tile (x, y) of a node, x and y 0 to 31. The slope of the node is subtracted. */
VXS_INLINE vxs_depths_tile vxs_depths_tile_of(VXS_WORDS blocks, vxs_blocks_node node, vxs_blocks_block block, vxs_i32 x, vxs_i32 y,
                                              vxs_i32 low, vxs_i32 high)
{
    vxs_depths_tile r;
    vxs_u32         t = VXS_U((x & 3) | ((y & 3) << 2)), mixed = (block.mixed >> t) & 1u, own = (block.own >> t) & 1u;
    r.tile         = vxs_blocks_whole(VXS_BLOCKS_SHADOW);
    r.base         = VXS_SUM(block.base) - vxs_blocks_tile_depth(node, x, y);
    r.low          = low;
    r.high         = high;
    r.indexed      = 0u;
    r.last         = 0u;
    r.used         = 0u;
    r.palette      = block.palette;
    r.palette_half = 0u;
    r.width        = (block.head >> 8) & 3u;
    r.shift        = (block.head >> 4) & 15u;
    if (mixed == 0u) {
        if (own == 0u) {
            r.base = vxs_depths_whole(blocks, node, block, x, y, low, high);
            return r;
        } /* the slope of the node is already in the plane */
        r.base   = VXS_SUM(block.base) - node.k;
        r.tile   = vxs_blocks_on_plane(blocks, block, t, 0);
        /* removes the 255 of vxs_blocks_limit(0); unsigned, because damaged words may overflow */
        r.tile.k = VXS_I(VXS_U(r.tile.k) - 255u);
        return r;
    }
    vxs_u32 word = vxs_word(blocks, block.palette - vxs_popcount(block.mixed >> t)), used = word & 0x3fffu,
            at   = (word >> 14) & 0x1ffffu;
    vxs_u32 pool = word >= 0x80000000u ? vxs_word(blocks, 1u) : block.page;
    if (own != 0u) {
        r.base += vxs_blocks_private_base(blocks, block, t, used);
        return vxs_depths_own(blocks, r, pool, at);
    }
    r.indexed = 1u;
    r.used    = used;
    r.last    = used != 0u ? vxs_popcount(used) - 1u : 0u;
    r.tile    = vxs_blocks_pattern(blocks, pool, at, r.last, 0u);
    return r;
}

/* Index of the lowest bit set; bits is not 0. */
VXS_FN vxs_u32 vxs_depths_lowest(vxs_u32 bits)
{
#if defined(VXS_C) && defined(__GNUC__)
    return VXS_U(__builtin_ctz(bits));
#else
    return vxs_popcount((bits & (0u - bits)) - 1u);
#endif
}

/* Index of the highest bit set; bits is not 0, and less than 2^16. */
VXS_FN vxs_u32 vxs_depths_highest(vxs_u32 bits)
{
#if defined(VXS_C) && defined(__GNUC__)
    return 31u - VXS_U(__builtin_clz(bits));
#else
    bits |= bits >> 1;
    bits |= bits >> 2;
    bits |= bits >> 4;
    bits |= bits >> 8;
    return vxs_popcount(bits) - 1u;
#endif
}

/* Entry n of the palette of a tile, clamped to the bounds of the tile. */
VXS_INLINE vxs_i32 vxs_depths_of_entry(VXS_WORDS blocks, VXS_DEPTHS_TILE r, vxs_u32 n)
{
    vxs_i32 entry =
        vxs_depths_entry(blocks, VXS_FIELD(r, palette), VXS_FIELD(r, palette_half), VXS_FIELD(r, width), VXS_FIELD(r, shift), n);
    return vxs_depths_held(VXS_FIELD(r, base) + entry, VXS_FIELD(r, low), VXS_FIELD(r, high));
}

/* Depth of an index; indices beyond the last are clamped to the last. */
VXS_INLINE vxs_i32 vxs_depths_of_index(VXS_WORDS blocks, VXS_DEPTHS_TILE r, vxs_u32 index)
{
    vxs_u32 n = index < VXS_FIELD(r, last) ? index : VXS_FIELD(r, last);
    if (VXS_FIELD(r, used) != 0u) { /* index of the n-th bit set */
        vxs_u32 used = VXS_FIELD(r, used);
        while (n != 0u) {
            used &= used - 1u;
            n--;
        }
        n = vxs_depths_lowest(used);
    }
    return vxs_depths_of_entry(blocks, r, n);
}

/* Depth of a plane at a texel, relative to the base of the tile: the least k at which vxs_blocks_plane_texel is 1. */
VXS_FN vxs_i32 vxs_depths_plane(vxs_blocks_tile plane, vxs_u32 x, vxs_u32 y)
{
    return VXS_I(plane.count * x + plane.bases * y - VXS_U(plane.k)) >> 8;
}

VXS_FN vxs_depths_bounds vxs_depths_bound_plane(vxs_blocks_tile plane)
{
    vxs_depths_bounds b;
    vxs_u32           x = plane.count >= 0x80000000u ? 7u : 0u, y = plane.bases >= 0x80000000u ? 7u : 0u;
    b.least    = vxs_depths_plane(plane, x, y);
    b.greatest = vxs_depths_plane(plane, 7u - x, 7u - y);
    return b;
}

/* Bounds of the depths of a tile, from few words. For palettes and planes they are depths of some of its texels; for other
 * kinds they are the bounds of the square. */
VXS_INLINE vxs_depths_bounds vxs_depths_bound(VXS_WORDS blocks, VXS_DEPTHS_TILE r)
{
    vxs_depths_bounds b;
    vxs_u32           kind = VXS_FIELD(r, tile).kind;
    vxs_i32           low = VXS_FIELD(r, low), high = VXS_FIELD(r, high);
    if (VXS_FIELD(r, indexed) != 0u) {
        vxs_u32 used = VXS_FIELD(r, used);
        b.least      = vxs_depths_of_entry(blocks, r, used != 0u ? vxs_depths_lowest(used) : 0u);
        b.greatest   = vxs_depths_of_entry(blocks, r, used != 0u ? vxs_depths_highest(used) : VXS_FIELD(r, last));
        return b;
    }
    b.least    = vxs_depths_held(VXS_FIELD(r, base), low, high);
    b.greatest = kind == VXS_BLOCKS_SHADOW ? b.least : high;
    if (kind < VXS_BLOCKS_PLANE) return b;
    for (vxs_u32 n = 0u; n < (kind == VXS_BLOCKS_PLANE ? 1u : 2u); n++) {
        vxs_blocks_tile plane = VXS_FIELD(r, tile);
        if (kind != VXS_BLOCKS_PLANE) plane = vxs_blocks_one_plane(blocks, plane, n);
        vxs_depths_bounds of = vxs_depths_bound_plane(plane);
        b.least              = n == 0u || of.least < b.least ? of.least : b.least;
        b.greatest           = n == 0u || of.greatest > b.greatest ? of.greatest : b.greatest;
    }
    b.least    = vxs_depths_held(VXS_FIELD(r, base) + b.least, low, high);
    b.greatest = vxs_depths_held(VXS_FIELD(r, base) + b.greatest, low, high);
    return b;
}

/* Index of the first mask that has texel z of quadrant c; tile.count if none has. Each mask has all texels of the one before
 * it. */
VXS_INLINE vxs_u32 vxs_depths_mask_index(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 c, vxs_u32 z)
{
    vxs_u32 next = tile.at + ((tile.count + 1u) >> 1), before = ((1u << (2u * c)) - 1u) * 0x01010101u, half_bits = 0u;
    for (vxs_u32 n = 0u; n < tile.count && c != 0u; n += 4u) { /* counts the halves of quadrants before c */
        vxs_u32 states = vxs_four_bytes(blocks, tile.pool, 2u * tile.at + n) & vxs_first_bytes(VXS_I(tile.count - n));
        next += vxs_popcount((states >> 1) & ~states & before & 0x55555555u);
    }
    for (vxs_u32 n = 0u; n < tile.count; n++) {
        vxs_u32 state = (vxs_byte(blocks, tile.pool, 2u * tile.at + n) >> (2u * c)) & 3u;
        if (state == 1u) return n;
        if (state == 2u) {
            half_bits = vxs_half(blocks, tile.pool, next);
            next++;
        }
        if (state != 0u && ((half_bits >> z) & 1u) != 0u) return n;
    }
    return tile.count;
}

/* Depth of an index, for a tile with known bounds. Fast for the first and the last index: most tiles have only two depths. */
VXS_INLINE vxs_i32 vxs_depths_of_known(VXS_WORDS blocks, VXS_DEPTHS_TILE r, vxs_u32 index, vxs_i32 least, vxs_i32 greatest)
{
    if (index == 0u) return least;
    return index >= VXS_FIELD(r, last) ? greatest : vxs_depths_of_index(blocks, r, index);
}

/* Depth of texel (x, y), 0 to 7, of a tile that has more than one depth.   least, greatest  from vxs_depths_bound */
VXS_INLINE vxs_i32 vxs_depths_texel(VXS_WORDS blocks, VXS_DEPTHS_TILE r, vxs_i32 least, vxs_i32 greatest, vxs_u32 x, vxs_u32 y)
{
    vxs_blocks_tile tile = VXS_FIELD(r, tile);
    vxs_u32         kind = tile.kind, c = (x >> 2) | ((y >> 2) << 1), z = (x & 3u) | ((y & 3u) << 2);
    vxs_sum         more = 0;
    if (kind == VXS_BLOCKS_MASKS) return vxs_depths_of_known(blocks, r, vxs_depths_mask_index(blocks, tile, c, z), least, greatest);
    if (kind == VXS_BLOCKS_NIBBLES) {
        vxs_u32 nibble = (vxs_byte(blocks, tile.pool, 2u * tile.at + 16u * (c & 1u) + z) >> (4u * (c >> 1))) & 15u;
        if (VXS_FIELD(r, indexed) != 0u) return vxs_depths_of_known(blocks, r, nibble, least, greatest);
        more = VXS_SUM(nibble + ((tile.bases >> (8u * c)) & 0xffu)) << VXS_FIELD(r, shift);
    } else if (kind < VXS_BLOCKS_PLANE && kind > VXS_BLOCKS_NIBBLES) {
        vxs_u32 size  = kind - 3u;
        vxs_u32 value = vxs_four_bytes(blocks, tile.pool, 2u * tile.at + size * (16u * c + z)) & vxs_first_bytes(VXS_I(size));
        more          = VXS_SUM(value) << VXS_FIELD(r, shift);
    } else if (kind >= VXS_BLOCKS_PLANE) {
        vxs_i32 first = 0, second = 0;
        for (vxs_u32 n = 0u; n < (kind == VXS_BLOCKS_PLANE ? 1u : 2u); n++) {
            vxs_blocks_tile plane = tile;
            if (kind != VXS_BLOCKS_PLANE) plane = vxs_blocks_one_plane(blocks, tile, n);
            first  = second;
            second = vxs_depths_plane(plane, x, y);
        }
        vxs_u32 take = 1u;
        if (kind == VXS_BLOCKS_NEARER) take = second < first ? 1u : 0u;
        if (kind == VXS_BLOCKS_FARTHER) take = second < first ? 0u : 1u;
        if (kind == VXS_BLOCKS_EITHER) take = (vxs_half(blocks, tile.pool, tile.at + 6u + c) >> z) & 1u;
        more = take != 0u ? second : first;
    }
    return vxs_depths_held(VXS_FIELD(r, base) + more, VXS_FIELD(r, low), VXS_FIELD(r, high));
}

#endif

#endif
