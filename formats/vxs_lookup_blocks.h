/* Layout of a light of palette blocks, and the lookup in it. One text for C99, C++, GLSL and HLSL; it needs vxs_lookup.h.
 *
 * A map of 2^levels texels a side is divided into squares of 256 x 256 texels (nodes), blocks of 32 x 32 and tiles of 8 x 8:
 *
 *     top ------ node ----- block ----- tile ----- pattern
 *     T x T      8 x 8      4 x 4       8 x 8      which texels are shadowed, for each depth of the tile
 *     squares    blocks     tiles       texels
 *
 * Each of these has either one depth for all of its texels, or a record of its own. Depths below the top are relative, so
 * that equal shapes at different depths share one record. A block uses few different depths: its palette. The rank of a
 * voxel is the number of palette depths at or before its depth; it is usually computed once for each block. A tile has the set of
 * palette entries that it uses, and a pattern: a mask of shadowed texels for each of these entries except the last, from
 * which on all texels are shadowed. Slanted sheets are stored as planes: one plane for several tiles of a block, or a plane
 * in a pattern.
 *
 * In the words of a light, word 0 is the number of pages, word 1 is where the common pool starts, words 2 to 7 are where the
 * top of each map starts, and words 8... are where each page starts (0: the page is not loaded). The rest is:
 *
 *     top         T x T entries of 2 words, by rows, T = max(1, 2^(levels-8)); from 15 levels on T/8 x T/8 cells of 1 word, by rows
 *     cell        0x80000000 | depth, or the word where 8 x 8 entries start, by rows
 *     entry       0x80000000 | depth, 0, or page << 16 | offset of a node, base | min << 16 | max << 24
 *     node        halves: mixed, 4; fresh, 4; slope, 2; flags; refs and bases of mixed blocks; depths of fresh blocks
 *     block       mixed | fresh << 16, own | head << 16, two words of a plane if a tile lies on it, a word for each mixed tile;
 *                 then bytes: deltas of the palette, nibbles of fresh tiles; then words: bases of mixed own tiles that are far
 *     tile        half of a pool << 14 | the palette entries it uses, or base + 8192 if the pattern is own: has depths of its own
 *     plane       slopes, 2; shift, 4 bits; depth, 28, in 1/256 voxel
 *     pattern     masks: a byte of states for each mask, then quadrants of 4 x 4 texels; or 0xff, 0, and a nibble for each texel
 *     own         kind << 12 | shift << 8 | count, then: a palette and a pattern; bases and nibbles; a depth of 1 to 3 bytes a
 *                 texel; slopes of a plane; or slopes of two planes, how much deeper the second is, and for kind 10 a mask of
 *                 the texels on the second plane
 *
 * There are two pools of halves: the common pool of the light, and the pool of the page. `mixed` has a bit for each block or
 * tile that has a record or pattern of its own. `fresh` has a bit for each of the others whose depth differs from that of
 * the previous one of the others. `own` has a bit for each mixed tile with a private-palette pattern (depths of its own),
 * and for each tile that is not mixed and lies on the plane of the block. Texels of a tile are numbered quadrant by
 * quadrant, by rows in a quadrant: (x, y) is bit (x & 3) + 4 (y & 3) + 16 (x >> 2) of the low word of a mask, or of the high
 * word if y > 3.
 *
 * If a page is not loaded, its entry gives the answer. With c = max(0, levels - 8): a voxel is lit if k >> c < min, and
 * shadowed if k >> c > max; both are exact. Between them it is shadowed if 2 (k >> c) >= min + max + 1: the coarse answer.
 * If a filter needs one page that is not loaded, the entries of all squares that it touches give its answer, so that its
 * taps are consistent.
 *
 * Macros are those of vxs_lookup.h; `blocks`, the words of a light, corresponds to `dag` there. In C and C++ with GCC and
 * Clang, where the words are an array in little-endian memory, bytes and halves are read directly and compared sixteen at a
 * time. If the includer defines VXS_SCALAR, they are read word by word, as in shaders. Both ways give identical bits.
 *
 * The array needs four readable words of any value after its last word. Offsets are not checked here; all loops end for any
 * words.
 * Source: ours; [Sintorn 2014] for PCF by popcount.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_LOOKUP_BLOCKS_H
#define VXS_LOOKUP_BLOCKS_H

#ifndef VXS_LOOKUP_H /* a shader that cannot include already has this text */
#include "vxs_lookup.h"
#endif

#if defined(VXS_WORDS_IN_MEMORY) && !defined(VXS_SCALAR) && defined(__GNUC__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define VXS_VECTORS
#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif
#endif

/* Kind of a node or a tile, at the depth of a voxel. Private-palette patterns of kinds 3 to 10 are tiles of these kinds. */
#define VXS_BLOCKS_LIT     0u
#define VXS_BLOCKS_SHADOW  1u
#define VXS_BLOCKS_MASKS   2u /* of a tile: masks; of a node: look into its blocks */
#define VXS_BLOCKS_NIBBLES 3u /* a base for each quadrant, a nibble for each texel */
#define VXS_BLOCKS_RAW     4u /* 4, 5, 6: one, two, three bytes for each texel */
#define VXS_BLOCKS_PLANE   7u
#define VXS_BLOCKS_NEARER  8u  /* two planes: each texel has the smaller of the two depths */
#define VXS_BLOCKS_FARTHER 9u  /* each texel has the greater of the two depths */
#define VXS_BLOCKS_EITHER  10u /* a mask selects the plane of each texel */

#ifdef VXS_C
typedef struct vxs_blocks_node  vxs_blocks_node;
typedef struct vxs_blocks_block vxs_blocks_block;
typedef struct vxs_blocks_tile  vxs_blocks_tile;
typedef struct vxs_blocks_box   vxs_blocks_box;
typedef struct vxs_blocks_taps  vxs_blocks_taps;
#endif

struct vxs_blocks_node {
    vxs_u32 kind;  /* VXS_BLOCKS_LIT, _SHADOW: the whole square is, and the other fields are unused */
    vxs_u32 page;  /* word where the page starts */
    vxs_u32 at;    /* word where the node starts */
    vxs_u32 slope; /* across | down << 16, signed: in 1/256 voxel a tile */
    vxs_i32 k;     /* depth, relative to the node */
};

/* A block. A uniform block is represented as a block with one palette entry that all of its tiles use. */
struct vxs_blocks_block {
    vxs_u32 page;    /* word where the page of the node starts */
    vxs_u32 at;      /* word where the block starts; 0: uniform block */
    vxs_u32 mixed;   /* bit t: tile t has a pattern */
    vxs_u32 fresh;   /* bit t: tile t has no pattern, and its palette entry differs from that of the previous such tile */
    vxs_u32 own;     /* bit t: tile t has a private-palette pattern, or lies on the plane */
    vxs_u32 head;    /* palette entries - 1 | shift << 4 | width << 8 | far << 10 */
    vxs_u32 palette; /* word where the deltas of the palette start */
    vxs_i32 base;    /* first depth of the palette, relative to the node */
};

struct vxs_blocks_tile {
    vxs_u32 kind;  /* VXS_BLOCKS_* */
    vxs_u32 pool;  /* word where the pool starts */
    vxs_u32 at;    /* half where states, nibbles or bytes start; two planes: where the pattern starts */
    vxs_u32 count; /* masks: number of masks; plane: increase of depth per texel across, in 1/256 voxel */
    vxs_u32 bases; /* nibbles: a base byte for each quadrant; plane: increase of depth per texel down, in 1/256 voxel */
    /* masks: index of the mask; else depth (planes: in 1/256 voxel): texels of at most this depth are shadowed */
    vxs_i32 k;
};

/* Texels [x0, x1) x [y0, y1) of a map. */
struct vxs_blocks_box {
    vxs_i32 x0, x1, y0, y1;
};

/* The taps of a filter and their weights: weight of the column times weight of the row. In a plain box each tap has weight
 * 1; `farther` is then the same box with weight 0. A smooth box (vxs_smooth_box) is the weighted sum of `box` and `farther`;
 * `farther` begins one texel later across, or down, if the smooth box does not begin at a texel border. */
struct vxs_blocks_taps {
    vxs_blocks_box box, farther;
    vxs_u32        across, across_farther, down, down_farther; /* weights of the columns and rows of each box */
};

/* halves, bytes, bits -------------------------------------------------------------------------------------------------------------
 * Indices count from word `at` of a light; half 0 is the low half of that word, byte 0 is the low byte. */

#ifdef VXS_VECTORS

typedef const char *vxs_chars;
typedef uint8_t     vxs_bytes16 __attribute__((vector_size(16)));
typedef int32_t     vxs_lanes4 __attribute__((vector_size(16)));
typedef uint32_t    vxs_words4 __attribute__((vector_size(16)));

VXS_FN vxs_chars vxs_address(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at)
{
    return VXS_CAST(vxs_chars, blocks + at) + byte_at;
}

VXS_FN vxs_u32 vxs_half(VXS_WORDS blocks, vxs_u32 at, vxs_u32 half_at)
{
    uint16_t value;
    memcpy(&value, vxs_address(blocks, at, 2u * half_at), sizeof value);
    return value;
}

VXS_FN vxs_u32 vxs_byte(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at)
{
    return VXS_CAST(uint8_t, *vxs_address(blocks, at, byte_at));
}

VXS_FN vxs_u32 vxs_four_bytes(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at)
{
    vxs_u32 value;
    memcpy(&value, vxs_address(blocks, at, byte_at), sizeof value);
    return value;
}

VXS_FN vxs_u32 vxs_popcount_pair(vxs_u32 low, vxs_u32 high)
{
#ifdef __POPCNT__
    return (vxs_u32)__builtin_popcountll(low | (uint64_t)high << 32);
#else
    uint64_t x = low | VXS_CAST(uint64_t, high) << 32, ones = ~VXS_CAST(uint64_t, 0);
    x -= (x >> 1) & (ones / 3);
    x = (x & (ones / 5)) + ((x >> 2) & (ones / 5));
    return VXS_U((((x + (x >> 4)) & (ones / 17)) * (ones / 255)) >> 56);
#endif
}

/* Bit n: byte n is 0xff. Each byte must be 0xff or 0. */
VXS_FN vxs_u32 vxs_bits_of_bytes(vxs_bytes16 bytes)
{
#ifdef __SSE2__
    return VXS_U(_mm_movemask_epi8(VXS_CAST(__m128i, bytes)));
#else
    static const vxs_bytes16 bit  = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
    /* 1 in each byte; a product with it has the sum of all bytes in the last byte */
    const uint64_t           ones = ~(uint64_t)0 / 255;
    uint64_t                 eight[2];
    bytes &= bit;
    memcpy(eight, &bytes, sizeof eight);
    return (vxs_u32)((eight[0] * ones) >> 56 | ((eight[1] * ones) >> 56) << 8);
#endif
}

/* Bit 4 y + x: lane x of row y (of four) is all ones. Each lane must be all ones or zero. */
VXS_FN vxs_u32 vxs_bits_of_rows(const vxs_lanes4 *rows)
{
#ifdef __SSE2__
    __m128i row[4];
    memcpy(row, rows, sizeof row);
    return vxs_bits_of_bytes(
        VXS_CAST(vxs_bytes16, _mm_packs_epi16(_mm_packs_epi32(row[0], row[1]), _mm_packs_epi32(row[2], row[3]))));
#else
    static const vxs_lanes4 bit  = {1, 2, 4, 8};
    vxs_lanes4              bits = (rows[0] & bit) | (rows[1] & (bit << 4)) | (rows[2] & (bit << 8)) | (rows[3] & (bit << 12));
    return (vxs_u32)(bits[0] | bits[1] | bits[2] | bits[3]);
#endif
}

VXS_FN vxs_u32 vxs_bytes_at_most(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at, vxs_u32 shift, vxs_u32 keep, vxs_u32 limit)
{
    vxs_bytes16 bytes, zero = {0};
    memcpy(&bytes, vxs_address(blocks, at, byte_at), sizeof bytes);
    bytes = (bytes >> VXS_CAST(uint8_t, shift)) & (zero + VXS_CAST(uint8_t, keep));
    return vxs_bits_of_bytes(VXS_CAST(vxs_bytes16, bytes <= zero + VXS_CAST(uint8_t, limit)));
}

VXS_FN vxs_u32 vxs_deltas_at_most(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at, vxs_u32 count, vxs_u32 limit)
{
    vxs_bytes16 bytes, zero = {0};
    memcpy(&bytes, vxs_address(blocks, at, byte_at), sizeof bytes);
    bytes = VXS_CAST(vxs_bytes16, bytes <= zero + VXS_CAST(uint8_t, limit > 255u ? 255u : limit));
    return VXS_U(__builtin_ctz(~(vxs_bits_of_bytes(bytes) & ((1u << count) - 1u))));
}

#else

VXS_FN vxs_u32 vxs_half(VXS_WORDS blocks, vxs_u32 at, vxs_u32 half_at)
{
    return (vxs_word(blocks, at + (half_at >> 1)) >> (16u * (half_at & 1u))) & 0xffffu;
}

VXS_FN vxs_u32 vxs_byte(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at)
{
    return (vxs_word(blocks, at + (byte_at >> 2)) >> (8u * (byte_at & 3u))) & 0xffu;
}

/* Four bytes at any byte position. */
VXS_FN vxs_u32 vxs_four_bytes(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at)
{
    vxs_u32 first = at + (byte_at >> 2), bits = 8u * (byte_at & 3u), low = vxs_word(blocks, first);
    return (low >> bits) | ((vxs_word(blocks, first + 1u) << 1) << (31u - bits));
}

VXS_FN vxs_u32 vxs_popcount_pair(vxs_u32 low, vxs_u32 high)
{
    return vxs_popcount(low) + vxs_popcount(high);
}

/* Bits 0 to 3: which bytes of a word are at most `limit`, 0 to 255. The highest bits of byte and limit decide if they
 * differ; else a subtraction of the lower 7 bits decides, which cannot borrow from the next byte. */
VXS_FN vxs_u32 vxs_four_at_most(vxs_u32 bytes, vxs_u32 limit)
{
    vxs_u32 limits = limit * 0x01010101u;
    vxs_u32 others = (limits | 0x80808080u) - (bytes & 0x7f7f7f7fu);
    vxs_u32 fit    = ((limits & ~bytes) | (~(limits ^ bytes) & others)) & 0x80808080u;
    return ((fit >> 7) * 0x01020408u) >> 24;
}

/* Number of bytes that are at most `limit`, of `count` ascending bytes; count up to 15. */
VXS_FN vxs_u32 vxs_deltas_at_most(VXS_WORDS blocks, vxs_u32 at, vxs_u32 byte_at, vxs_u32 count, vxs_u32 limit)
{
    vxs_u32 bits = 0u;
    for (vxs_u32 n = 0u; n < count; n += 4u)
        bits |= vxs_four_at_most(vxs_four_bytes(blocks, at, byte_at + n), limit > 255u ? 255u : limit) << n;
    return vxs_popcount(bits & ((1u << count) - 1u));
}

#endif

/* Mask of the first `count` bytes of a word; any count. */
VXS_FN vxs_u32 vxs_first_bytes(vxs_i32 count)
{
    return count >= 4 ? 0xffffffffu : count <= 0 ? 0u : (1u << VXS_U(8 * count)) - 1u;
}

/* Number of palette depths at or before k, which is relative to the first palette depth.
 * at, half_at  where the deltas start;  count  number of deltas, up to 31
 * width        0: bytes, 1: halves, 2: two halves each;  shift  left shift of the deltas */
VXS_FN vxs_u32 vxs_blocks_rank(VXS_WORDS blocks, vxs_u32 at, vxs_u32 half_at, vxs_u32 width, vxs_u32 shift, vxs_u32 count,
                               vxs_i32 k)
{
    if (k < 0) return 0u;
    if (count == 0u) return 1u;
    vxs_u32 limit = VXS_U(k) >> shift, rank = 1u;
    if (width == 0u) return 1u + vxs_deltas_at_most(blocks, at, 2u * half_at, count, limit);
    for (vxs_u32 n = 0u; n < count; n++) {
        vxs_u32 delta = vxs_half(blocks, at, half_at + n * width);
        if (width == 2u) delta |= vxs_half(blocks, at, half_at + 2u * n + 1u) << 16;
        rank += delta <= limit ? 1u : 0u;
    }
    return rank;
}

/* top -------------------------------------------------------------------------------------------------------------------------- */

/* Word where the entry of a square of 256 x 256 texels is; or the word of its cell, if the whole cell has one depth. */
VXS_FN vxs_u32 vxs_blocks_entry(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_u32 x, vxs_u32 y)
{
    vxs_u32 at = vxs_word(blocks, 2u + map);
    if (levels >= 15u) {
        vxs_u32 cell = at + ((y >> 3) << (levels - 11u)) + (x >> 3), entries = vxs_word(blocks, cell);
        at = entries >= 0x80000000u ? cell : entries + 2u * (((y & 7u) << 3) + (x & 7u));
    } else if (levels > 8u)
        at += 2u * ((y << (levels - 8u)) + x);
    return at;
}

/* Whether the exact answer for a square of 256 x 256 texels at depth k is available: its entry decides, or its page is
 * loaded. */
VXS_FN vxs_u32 vxs_blocks_square_is_known(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_u32 x, vxs_u32 y, vxs_i32 k)
{
    vxs_u32 entry = vxs_blocks_entry(blocks, map, levels, x, y), place = vxs_word(blocks, entry);
    if (place >= 0x80000000u) return 1u;
    vxs_u32 bounds = vxs_word(blocks, entry + 1u), coarse = VXS_U(k) >> (levels > 8u ? levels - 8u : 0u);
    if (coarse < ((bounds >> 16) & 0xffu) || coarse > (bounds >> 24)) return 1u;
    return vxs_word(blocks, 8u + (place >> 16)) != 0u ? 1u : 0u;
}

/* Answer of the top for a square of 256 x 256 texels at depth k, VXS_BLOCKS_LIT or _SHADOW, whether or not its page is
 * loaded. */
VXS_FN vxs_u32 vxs_blocks_coarse(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_u32 x, vxs_u32 y, vxs_i32 k)
{
    vxs_u32 entry = vxs_blocks_entry(blocks, map, levels, x, y), place = vxs_word(blocks, entry);
    if (place >= 0x80000000u) return k >= VXS_I(place & 0x7fffffffu) ? VXS_BLOCKS_SHADOW : VXS_BLOCKS_LIT;
    vxs_u32 bounds = vxs_word(blocks, entry + 1u), coarse = VXS_U(k) >> (levels > 8u ? levels - 8u : 0u);
    return 2u * coarse > ((bounds >> 16) & 0xffu) + (bounds >> 24) ? VXS_BLOCKS_SHADOW : VXS_BLOCKS_LIT;
}

/* A square that is all lit or all shadowed at depth k.   kind  VXS_BLOCKS_LIT or _SHADOW */
VXS_INLINE vxs_blocks_node vxs_blocks_whole_node(vxs_u32 kind, vxs_i32 k)
{
    vxs_blocks_node node;
    node.kind  = kind;
    node.page  = 0u;
    node.at    = 0u;
    node.slope = 0u;
    node.k     = k;
    return node;
}

/* The node of a square of 256 x 256 texels, at depth k. */
VXS_INLINE vxs_blocks_node vxs_blocks_find_node(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_u32 x, vxs_u32 y, vxs_i32 k)
{
    vxs_u32         entry = vxs_blocks_entry(blocks, map, levels, x, y), place = vxs_word(blocks, entry);
    vxs_blocks_node node = vxs_blocks_whole_node(k >= VXS_I(place & 0x7fffffffu) ? VXS_BLOCKS_SHADOW : VXS_BLOCKS_LIT, k);
    if (place >= 0x80000000u) return node;

    vxs_u32 bounds = vxs_word(blocks, entry + 1u), nearest = (bounds >> 16) & 0xffu, farthest = bounds >> 24;
    vxs_u32 coarse = VXS_U(k) >> (levels > 8u ? levels - 8u : 0u);
    node.page      = vxs_word(blocks, 8u + (place >> 16));
    node.kind      = 2u * coarse > nearest + farthest ? VXS_BLOCKS_SHADOW : VXS_BLOCKS_LIT;
    if (coarse < nearest || coarse > farthest || node.page == 0u) return node;

    node.kind  = VXS_BLOCKS_MASKS;
    node.at    = node.page + (place & 0xffffu);
    node.slope = vxs_word(blocks, node.at + 4u);
    node.k     = k - VXS_I((bounds & 0xffffu) << (levels > 16u ? levels - 16u : 0u));
    return node;
}

/* Depth k at tile (x, y), 0 to 31, corrected by the slope of the node. The slope makes flat slanted ground uniform. */
VXS_FN vxs_i32 vxs_blocks_tile_depth(vxs_blocks_node node, vxs_i32 x, vxs_i32 y)
{
    vxs_i32 across = VXS_I(node.slope << 16) >> 16, down = VXS_I(node.slope) >> 16;
    return node.k + ((across * (across < 0 ? x - 31 : x) + down * (down < 0 ? y - 31 : y)) >> 8);
}

/* blocks ----------------------------------------------------------------------------------------------------------------------- */

/* Number of bits set before bit c of two words. */
VXS_FN vxs_u32 vxs_blocks_before(vxs_u32 low, vxs_u32 high, vxs_u32 c)
{
    vxs_u32 before = (1u << (c & 31u)) - 1u;
    return vxs_popcount_pair(low & (c < 32u ? before : 0xffffffffu), high & (c < 32u ? 0u : before));
}

/* A block with one palette entry, at `depth`, relative to the node. */
VXS_INLINE vxs_blocks_block vxs_blocks_whole_block(vxs_u32 page, vxs_i32 depth)
{
    vxs_blocks_block block;
    block.page    = page;
    block.at      = 0u;
    block.mixed   = 0u;
    block.fresh   = 0u;
    block.own     = 0u;
    block.head    = 0u;
    block.palette = 0u;
    block.base    = depth;
    return block;
}

/* Uniform block c: its depth is that of the last fresh block at or before it. A depth of all ones means never shadowed: it
 * is replaced by a depth that no k reaches, and from which k can be subtracted without overflow.
 * wide  1: depths are two halves each;   mixed  number of mixed blocks of the node */
VXS_INLINE vxs_blocks_block vxs_blocks_uniform(VXS_WORDS blocks, vxs_blocks_node node, vxs_u32 c, vxs_u32 wide, vxs_u32 mixed)
{
    vxs_u32 low = vxs_word(blocks, node.at + 2u), high = vxs_word(blocks, node.at + 3u);
    vxs_u32 nth   = vxs_blocks_before(low, high, c) + (((c < 32u ? low : high) >> (c & 31u)) & 1u) - 1u;
    vxs_u32 at    = 11u + mixed * (2u + wide) + nth * (1u + wide);
    vxs_u32 depth = vxs_half(blocks, node.at, at);
    if (wide != 0u) depth |= vxs_half(blocks, node.at, at + 1u) << 16;

    return vxs_blocks_whole_block(node.page, VXS_I((wide == 0u && depth == 0xffffu ? 0x3fffffffu : depth) & 0x3fffffffu));
}

/* Block c, x + 8y, of a node. */
VXS_INLINE vxs_blocks_block vxs_blocks_find_block(VXS_WORDS blocks, vxs_blocks_node node, vxs_u32 c)
{
    vxs_u32 low = vxs_word(blocks, node.at), high = vxs_word(blocks, node.at + 1u);
    vxs_u32 wide = vxs_half(blocks, node.at, 10u) & 1u, mixed = vxs_popcount_pair(low, high);
    if ((((c < 32u ? low : high) >> (c & 31u)) & 1u) == 0u) return vxs_blocks_uniform(blocks, node, c, wide, mixed);

    vxs_u32 nth = vxs_blocks_before(low, high, c), at = 11u + mixed + nth * (1u + wide);
    vxs_u32 base = vxs_half(blocks, node.at, at);
    if (wide != 0u) base |= vxs_half(blocks, node.at, at + 1u) << 16;

    vxs_blocks_block block;
    block.page    = node.page;
    block.at      = node.page + vxs_half(blocks, node.at, 11u + nth);
    block.mixed   = vxs_word(blocks, block.at) & 0xffffu;
    block.fresh   = vxs_word(blocks, block.at) >> 16;
    block.own     = vxs_word(blocks, block.at + 1u) & 0xffffu;
    block.head    = vxs_word(blocks, block.at + 1u) >> 16;
    block.palette = block.at + ((block.own & ~block.mixed) != 0u ? 4u : 2u) + vxs_popcount(block.mixed);
    block.base    = VXS_I(base);
    return block;
}

/* Number of palette entries of a block at or before k, which is relative to the node. */
VXS_FN vxs_u32 vxs_blocks_block_rank(VXS_WORDS blocks, vxs_blocks_block block, vxs_i32 k)
{
    vxs_u32 width = (block.head >> 8) & 3u, shift = (block.head >> 4) & 15u;
    return vxs_blocks_rank(blocks, block.palette, 0u, width, shift, block.head & 15u, k - block.base);
}

/* VXS_BLOCKS_LIT or _SHADOW if all tiles of a block are so at all depths from k to k_last; else _MASKS.  rank  of the block
 * at depth k */
VXS_FN vxs_u32 vxs_blocks_block_kind(vxs_blocks_block block, vxs_u32 rank, vxs_i32 k_last)
{
    if (block.own != 0u) return VXS_BLOCKS_MASKS;
    if (rank > (block.head & 15u)) return VXS_BLOCKS_SHADOW;
    return k_last < block.base ? VXS_BLOCKS_LIT : VXS_BLOCKS_MASKS;
}

VXS_FN vxs_u32 vxs_blocks_palette_bytes(vxs_blocks_block block)
{
    return (block.head & 15u) << ((block.head >> 8) & 3u);
}

/* tiles ------------------------------------------------------------------------------------------------------------------------ */

VXS_FN vxs_blocks_tile vxs_blocks_tile_of(vxs_u32 kind, vxs_u32 pool, vxs_u32 at, vxs_u32 count, vxs_u32 bases, vxs_i32 k)
{
    vxs_blocks_tile tile;
    tile.kind  = kind;
    tile.pool  = pool;
    tile.at    = at;
    tile.count = count;
    tile.bases = bases;
    tile.k     = k;
    return tile;
}

/* A tile that is all lit or all shadowed.  kind  VXS_BLOCKS_LIT or _SHADOW */
VXS_FN vxs_blocks_tile vxs_blocks_whole(vxs_u32 kind)
{
    return vxs_blocks_tile_of(kind, 0u, 0u, 0u, 0u, 0);
}

/* Mask n of a pattern of `count` masks, which is stored as masks, or as a depth index for each texel. */
VXS_FN vxs_blocks_tile vxs_blocks_pattern(VXS_WORDS blocks, vxs_u32 pool, vxs_u32 at, vxs_u32 count, vxs_u32 n)
{
    if ((vxs_half(blocks, pool, at) & 0xffu) == 0xffu)
        return vxs_blocks_tile_of(VXS_BLOCKS_NIBBLES, pool, at + 1u, 0u, 0u, VXS_I(n));
    return vxs_blocks_tile_of(VXS_BLOCKS_MASKS, pool, at, count, 0u, VXS_I(n));
}

/* Greatest plane depth, in 1/256 voxel, that is at or before voxel k. Planes are less than 2^22 voxels deep. */
VXS_FN vxs_i32 vxs_blocks_limit(vxs_i32 k)
{
    return 256 * vxs_clamp(k, -4194304, 4194304) + 255;
}

/* Start of plane `which` of a pattern within its first voxel, in 1/256 voxel.   first  first half of the pattern */
VXS_FN vxs_i32 vxs_blocks_quarters(vxs_u32 first, vxs_u32 which)
{
    return VXS_I(((first >> (3u + 2u * which)) & 3u) << 6);
}

/* A tile on a plane. Its first texel is (x, y) of a square of last + 1 texels a side; the least depth of the plane in that
 * square is 0. Arithmetic is unsigned, because damaged words may hold slopes and shifts whose sums overflow.
 * slopes  across | down << 16, signed: in (1 << shift) / 256 voxel per texel
 * limit   texels of at most this depth are shadowed */
VXS_FN vxs_blocks_tile vxs_blocks_plane(vxs_u32 slopes, vxs_u32 shift, vxs_u32 last, vxs_u32 x, vxs_u32 y, vxs_i32 limit)
{
    vxs_u32 across = VXS_U(VXS_I(slopes << 16) >> 16) << shift, down = VXS_U(VXS_I(slopes) >> 16) << shift;
    vxs_u32 first = across * ((slopes & 0x8000u) != 0u ? x - last : x) + down * (slopes >= 0x80000000u ? y - last : y);
    return vxs_blocks_tile_of(VXS_BLOCKS_PLANE, 0u, 0u, across, down, VXS_I(VXS_U(limit) - first));
}

/* Base of mixed own tile t, relative to its block.   low  low 14 bits of the word of the tile */
VXS_FN vxs_i32 vxs_blocks_private_base(VXS_WORDS blocks, vxs_blocks_block block, vxs_u32 t, vxs_u32 low)
{
    if ((block.head & 0x400u) == 0u) return VXS_I(low) - 8192;
    vxs_u32 bytes = vxs_blocks_palette_bytes(block) + ((vxs_popcount(block.fresh) + 1u) >> 1);
    return VXS_I(vxs_word(blocks, block.palette + ((bytes + 3u) >> 2) + vxs_popcount(block.own & block.mixed & ((1u << t) - 1u))));
}

/* Palette entry of uniform tile t: that of the last fresh tile at or before it. */
VXS_FN vxs_u32 vxs_blocks_entry_of_tile(VXS_WORDS blocks, vxs_blocks_block block, vxs_u32 t)
{
    if (block.at == 0u) return 0u;
    vxs_u32 nth = vxs_popcount(block.fresh & ((2u << t) - 1u)) - 1u;
    return (vxs_byte(blocks, block.palette, vxs_blocks_palette_bytes(block) + (nth >> 1)) >> (4u * (nth & 1u))) & 15u;
}

/* Tile t, x + 4y, of a block; the tile lies on the plane of the block.
 * k  depth relative to the block, without the slope of the node, which is already in the plane */
VXS_FN vxs_blocks_tile vxs_blocks_on_plane(VXS_WORDS blocks, vxs_blocks_block block, vxs_u32 t, vxs_i32 k)
{
    vxs_u32 slopes = vxs_word(blocks, block.at + 2u), depth = vxs_word(blocks, block.at + 3u);
    vxs_i32 limit = vxs_blocks_limit(k) - (VXS_I(depth) >> 4);
    return vxs_blocks_plane(slopes, depth & 15u, 31u, 8u * (t & 3u), 8u * (t >> 2), limit);
}

#ifdef VXS_C

/* A tile with a private-palette pattern; k is relative to its base. */
VXS_FN vxs_blocks_tile vxs_blocks_own(VXS_WORDS blocks, vxs_u32 pool, vxs_u32 at, vxs_i32 k)
{
    if (k < 0) return vxs_blocks_whole(VXS_BLOCKS_LIT);
    vxs_u32 first = vxs_half(blocks, pool, at), kind = first >> 12, shift = (first >> 8) & 15u, count = (first - 1u) & 31u;
    if (kind < VXS_BLOCKS_NIBBLES) {
        vxs_u32 rank = vxs_blocks_rank(blocks, pool, at + 1u, kind, shift, count, k);
        if (rank > count) return vxs_blocks_whole(VXS_BLOCKS_SHADOW);
        return vxs_blocks_pattern(blocks, pool, at + 1u + (kind == 0u ? (count + 1u) >> 1 : kind * count), count, rank - 1u);
    }
    if (kind == VXS_BLOCKS_PLANE)
        return vxs_blocks_plane(vxs_four_bytes(blocks, pool, 2u * at + 2u), shift, 7u, 0u, 0u,
                                vxs_blocks_limit(k) - vxs_blocks_quarters(first, 0u));
    if (kind > VXS_BLOCKS_PLANE) return vxs_blocks_tile_of(kind, pool, at, 0u, 0u, vxs_blocks_limit(k));
    k >>= shift;
    if (kind != VXS_BLOCKS_NIBBLES) return vxs_blocks_tile_of(kind, pool, at + 1u, 0u, 0u, k);
    return vxs_blocks_tile_of(kind, pool, at + 3u, 0u, vxs_four_bytes(blocks, pool, 2u * at + 2u), k);
}

/* Tile t, x + 4y, of a block, at depth k relative to the node.   rank  of the block at that depth */
VXS_INLINE vxs_blocks_tile vxs_blocks_find_tile(VXS_WORDS blocks, vxs_blocks_node node, vxs_blocks_block block, vxs_u32 t,
                                                vxs_u32 rank, vxs_i32 k)
{
    if (((block.mixed >> t) & 1u) == 0u) {
        if (((block.own >> t) & 1u) != 0u) return vxs_blocks_on_plane(blocks, block, t, node.k - block.base);
        return vxs_blocks_whole(rank > vxs_blocks_entry_of_tile(blocks, block, t) ? VXS_BLOCKS_SHADOW : VXS_BLOCKS_LIT);
    }

    vxs_u32 word = vxs_word(blocks, block.palette - vxs_popcount(block.mixed >> t));
    vxs_u32 pool = word >= 0x80000000u ? vxs_word(blocks, 1u) : block.page, at = (word >> 14) & 0x1ffffu, used = word & 0x3fffu;
    if (((block.own >> t) & 1u) != 0u)
        return vxs_blocks_own(blocks, pool, at, k - block.base - vxs_blocks_private_base(blocks, block, t, used));

    vxs_u32 passed = used & ((1u << rank) - 1u);
    if (passed == 0u || passed == used) return vxs_blocks_whole(passed != 0u ? VXS_BLOCKS_SHADOW : VXS_BLOCKS_LIT);
    return vxs_blocks_pattern(blocks, pool, at, vxs_popcount(used) - 1u, vxs_popcount(passed) - 1u);
}

#else

/* Tile (x, y) of a node's map, at the depth of the node. Compilers inline every call, so there is one call for the palette of a
 * block and that of a pattern, and one for a plane of either. */
VXS_FN vxs_blocks_tile vxs_blocks_find_tile(VXS_WORDS blocks, vxs_blocks_node node, vxs_blocks_block block, vxs_u32 x, vxs_u32 y)
{
    vxs_u32 t = (x & 3u) | ((y & 3u) << 2), is_mixed = (block.mixed >> t) & 1u, is_own = (block.own >> t) & 1u;
    vxs_u32 word = is_mixed != 0u ? vxs_word(blocks, block.palette - vxs_popcount(block.mixed >> t)) : 0u;
    vxs_u32 pool = word >= 0x80000000u ? vxs_word(blocks, 1u) : block.page, at = (word >> 14) & 0x1ffffu;
    vxs_i32 k = vxs_blocks_tile_depth(node, VXS_I(x & 31u), VXS_I(y & 31u)) - block.base;

    vxs_u32 kind = 0u, width = (block.head >> 8) & 3u, shift = (block.head >> 4) & 15u, last = block.head & 15u, first = 0u;
    vxs_u32 palette = block.palette, half_at = 0u, has_private = is_mixed & is_own;
    if (has_private != 0u) {
        k -= vxs_blocks_private_base(blocks, block, t, word & 0x3fffu);
        first   = vxs_half(blocks, pool, at);
        kind    = first >> 12;
        width   = kind;
        shift   = (first >> 8) & 15u;
        last    = (first - 1u) & 31u;
        palette = pool;
        half_at = at + 1u;
    }
    vxs_blocks_tile tile = vxs_blocks_tile_of(kind, pool, at, 0u, 0u, k >> shift);
    if (has_private != 0u && k < 0) {
        tile.kind = VXS_BLOCKS_LIT;
    } else if ((is_own & ~is_mixed) != 0u || kind == VXS_BLOCKS_PLANE) {
        vxs_u32 side  = 7u, slopes, depth;
        vxs_i32 limit = vxs_blocks_limit(is_mixed != 0u ? k : node.k - block.base) - vxs_blocks_quarters(first, 0u);
        if (is_mixed == 0u) { /* the slope of the node is already in the plane */
            side   = 31u;
            slopes = vxs_word(blocks, block.at + 2u);
            depth  = vxs_word(blocks, block.at + 3u);
            shift  = depth & 15u;
            limit -= VXS_I(depth) >> 4;
        } else
            slopes = vxs_four_bytes(blocks, pool, 2u * at + 2u);
        tile = vxs_blocks_plane(slopes, shift, side, (side - 7u) / 3u * (x & 3u), (side - 7u) / 3u * (y & 3u), limit);
    } else if (kind > VXS_BLOCKS_PLANE) {
        tile.k = vxs_blocks_limit(k);
    } else if (kind > VXS_BLOCKS_NIBBLES) {
        tile.at += 1u;
    } else if (kind == VXS_BLOCKS_NIBBLES) {
        tile.at += 3u;
        tile.bases = vxs_four_bytes(blocks, pool, 2u * at + 2u);
    } else {
        vxs_u32 rank = vxs_blocks_rank(blocks, palette, half_at, width, shift, last, k);
        if (is_mixed == 0u) {
            rank = rank > vxs_blocks_entry_of_tile(blocks, block, t) ? 1u : 0u;
            last = 0u;
        } else if (is_own == 0u) { /* of the palette entries that the tile uses */
            last = vxs_popcount(word & 0x3fffu) - 1u;
            rank = vxs_popcount(word & 0x3fffu & ((1u << rank) - 1u));
        } else
            at += 1u + (kind == 0u ? (last + 1u) >> 1 : kind * last);
        tile.kind = rank == 0u ? VXS_BLOCKS_LIT : VXS_BLOCKS_SHADOW;
        if (rank != 0u && rank <= last) tile = vxs_blocks_pattern(blocks, pool, at, last, rank - 1u);
    }
    return tile;
}

#endif

/* patterns --------------------------------------------------------------------------------------------------------------------- */

/* 16 bits of quadrant c of a mask: no texels, all texels, or the stored half with index nth - 1 of the pattern. */
VXS_FN vxs_u32 vxs_blocks_half(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 states, vxs_u32 c, vxs_u32 nth)
{
    vxs_u32 state = (states >> (2u * c)) & 3u, kept = 0u - (state >> 1);
    return ((vxs_half(blocks, tile.pool, tile.at + ((tile.count + 1u) >> 1) + nth - 1u) & kept) | (0u - (state & ~kept))) & 0xffffu;
}

/* A texel, z = 0 to 63, of a tile of raw depths. */
VXS_FN vxs_u32 vxs_blocks_raw_texel(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 z)
{
    vxs_u32 size  = tile.kind - 3u;
    vxs_u32 depth = vxs_four_bytes(blocks, tile.pool, 2u * tile.at + size * z) & vxs_first_bytes(VXS_I(size));
    return VXS_I(depth) <= tile.k ? 1u : 0u;
}

/* Plane 0 or 1 of a tile with two planes. */
VXS_FN vxs_blocks_tile vxs_blocks_one_plane(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 which)
{
    vxs_u32 first = vxs_half(blocks, tile.pool, tile.at), shift = (first >> 8) & 15u;
    vxs_u32 deeper = which == 0u ? 0u : vxs_half(blocks, tile.pool, tile.at + 5u) << (8u + (first & 7u));
    vxs_u32 slopes = vxs_four_bytes(blocks, tile.pool, 2u * tile.at + 2u + 4u * which);
    return vxs_blocks_plane(slopes, shift, 7u, 0u, 0u, VXS_I(VXS_U(tile.k) - deeper) - vxs_blocks_quarters(first, which));
}

/* Bits of a tile with two planes.   first, second  bits of each plane;   of_second  mask of the texels on the second plane */
VXS_FN vxs_u32 vxs_blocks_join(vxs_u32 kind, vxs_u32 first, vxs_u32 second, vxs_u32 of_second)
{
    if (kind == VXS_BLOCKS_NEARER) return first | second;
    if (kind == VXS_BLOCKS_FARTHER) return first & second;
    return (first & ~of_second) | (second & of_second);
}

#ifdef VXS_C

/* Quadrant c of a mask. */
VXS_INLINE vxs_u32 vxs_blocks_quadrant(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 c)
{
    vxs_u32 states = vxs_byte(blocks, tile.pool, 2u * tile.at + VXS_U(tile.k)), nth = 0u;
    vxs_u32 before = ((1u << (2u * c)) - 1u) * 0x01010101u, own = 0x01010101u << (2u * c);
    if (((states >> (2u * c)) & 2u) == 0u) return (0u - ((states >> (2u * c)) & 1u)) & 0xffffu;
    for (vxs_u32 n = 0u; n < tile.count; n += 4u) {
        vxs_u32 some = vxs_four_bytes(blocks, tile.pool, 2u * tile.at + n) & vxs_first_bytes(VXS_I(tile.count - n));
        nth += vxs_popcount((some >> 1) & ~some & (before | (own & vxs_first_bytes(tile.k + 1 - VXS_I(n)))) & 0x55555555u);
    }
    return vxs_blocks_half(blocks, tile, states, c, nth);
}

/* Texel z of quadrant c of a tile on a plane. */
VXS_FN vxs_u32 vxs_blocks_plane_texel(vxs_blocks_tile tile, vxs_u32 c, vxs_u32 z)
{
    vxs_u32 x = 4u * (c & 1u) + (z & 3u), y = 4u * (c >> 1) + (z >> 2);
    return VXS_I(tile.count * x + tile.bases * y) <= tile.k ? 1u : 0u;
}

/* Texel z of quadrant c of a tile with two planes. */
VXS_APART vxs_u32 vxs_blocks_two_planes_texel(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 c, vxs_u32 z)
{
    vxs_u32 first  = vxs_blocks_plane_texel(vxs_blocks_one_plane(blocks, tile, 0u), c, z);
    vxs_u32 second = vxs_blocks_plane_texel(vxs_blocks_one_plane(blocks, tile, 1u), c, z);
    return vxs_blocks_join(tile.kind, first, second, vxs_half(blocks, tile.pool, tile.at + 6u + c) >> z) & 1u;
}

/* Texel z of quadrant c of a tile that is neither all lit nor all shadowed. */
VXS_INLINE vxs_u32 vxs_blocks_texel(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 c, vxs_u32 z)
{
    if (tile.kind == VXS_BLOCKS_MASKS) return (vxs_blocks_quadrant(blocks, tile, c) >> z) & 1u;
    if (tile.kind == VXS_BLOCKS_PLANE) return vxs_blocks_plane_texel(tile, c, z);
    if (tile.kind > VXS_BLOCKS_PLANE) return vxs_blocks_two_planes_texel(blocks, tile, c, z);
    if (tile.kind >= VXS_BLOCKS_RAW) return vxs_blocks_raw_texel(blocks, tile, 16u * c + z);
    vxs_u32 nibble = (vxs_byte(blocks, tile.pool, 2u * tile.at + 16u * (c & 1u) + z) >> (4u * (c >> 1))) & 15u;
    return VXS_I(nibble + ((tile.bases >> (8u * c)) & 0xffu)) <= tile.k ? 1u : 0u;
}

#endif

#ifdef VXS_VECTORS

/* All quadrants of a mask, as vxs_blocks_texels finds them. */
VXS_INLINE vxs_mask vxs_blocks_quadrants(VXS_WORDS blocks, vxs_blocks_tile tile)
{
    vxs_u32 even = 0u, odd = 0u, even_upto = 0u, odd_upto = 0u, k = VXS_U(tile.k);
    for (vxs_u32 n = 0u; n < tile.count; n += 4u) {
        vxs_u32 rest = tile.count - n, skip = rest < 4u ? 4u - rest : 0u;
        vxs_u32 states = vxs_four_bytes(blocks, tile.pool, 2u * tile.at + n) << (8u * skip), halves = (states >> 1) & ~states;
        vxs_u32 even_sums = (halves & 0x11111111u) * 0x01010101u, odd_sums = ((halves >> 2) & 0x11111111u) * 0x01010101u;
        if (k - n < 4u) {
            even_upto = even + ((even_sums >> (8u * (k - n + skip))) & 0xffu);
            odd_upto  = odd + ((odd_sums >> (8u * (k - n + skip))) & 0xffu);
        }
        even += even_sums >> 24;
        odd += odd_sums >> 24;
    }
    vxs_u32 states = vxs_byte(blocks, tile.pool, 2u * tile.at + k), first = even & 15u, second = first + (odd & 15u),
            third = second + (even >> 4);
    vxs_mask mask;
    mask.low  = vxs_blocks_half(blocks, tile, states, 0u, even_upto & 15u);
    mask.high = vxs_blocks_half(blocks, tile, states, 2u, second + (even_upto >> 4));
    mask.low |= vxs_blocks_half(blocks, tile, states, 1u, first + (odd_upto & 15u)) << 16;
    mask.high |= vxs_blocks_half(blocks, tile, states, 3u, third + (odd_upto >> 4)) << 16;
    return mask;
}

/* Quadrant c of a tile of nibbles: quadrants 0 and 2 use bytes 0 to 15, quadrants 1 and 3 use bytes 16 to 31; 2 and 3 are
 * the high nibbles. */
VXS_FN vxs_u32 vxs_blocks_nibbles(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 c)
{
    vxs_i32 limit = tile.k - VXS_I((tile.bases >> (8u * c)) & 0xffu);
    if (limit < 0) return 0u;
    return vxs_bytes_at_most(blocks, tile.pool, 2u * tile.at + 16u * (c & 1u), 4u * (c >> 1), 15u, limit < 15 ? VXS_U(limit) : 15u);
}

/* Quadrant c of a tile of raw depths. */
VXS_FN vxs_u32 vxs_blocks_raw(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 c)
{
    if (tile.kind == VXS_BLOCKS_RAW)
        return vxs_bytes_at_most(blocks, tile.pool, 2u * tile.at + 16u * c, 0u, 255u, tile.k < 255 ? VXS_U(tile.k) : 255u);
    vxs_u32 bits = 0u;
    for (vxs_u32 z = 0u; z < 16u; z++) bits |= vxs_blocks_raw_texel(blocks, tile, 16u * c + z) << z;
    return bits;
}

/* Quadrant c of a tile on a plane. */
VXS_FN vxs_u32 vxs_blocks_plane_quadrant(vxs_blocks_tile tile, vxs_u32 c)
{
    const vxs_words4 zero = {0}, columns = {0u, tile.count, 2u * tile.count, 3u * tile.count};
    const vxs_lanes4 limit = VXS_CAST(vxs_lanes4, zero + VXS_U(tile.k));
    vxs_words4       row   = columns + (4u * (c & 1u) * tile.count + 4u * (c >> 1) * tile.bases);
    vxs_lanes4       rows[4];
    for (int y = 0; y < 4; y++, row += tile.bases) rows[y] = VXS_CAST(vxs_lanes4, row) <= limit;
    return vxs_bits_of_rows(rows);
}

/* All texels of a tile on a plane. */
VXS_FN vxs_mask vxs_blocks_plane_mask(vxs_blocks_tile tile)
{
    vxs_mask mask;
    mask.low  = vxs_blocks_plane_quadrant(tile, 0u) | (vxs_blocks_plane_quadrant(tile, 1u) << 16);
    mask.high = vxs_blocks_plane_quadrant(tile, 2u) | (vxs_blocks_plane_quadrant(tile, 3u) << 16);
    return mask;
}

/* All texels of a tile with two planes. */
VXS_APART vxs_mask vxs_blocks_two_planes(VXS_WORDS blocks, vxs_blocks_tile tile)
{
    vxs_mask first  = vxs_blocks_plane_mask(vxs_blocks_one_plane(blocks, tile, 0u));
    vxs_mask second = vxs_blocks_plane_mask(vxs_blocks_one_plane(blocks, tile, 1u));
    first.low       = vxs_blocks_join(tile.kind, first.low, second.low, vxs_four_bytes(blocks, tile.pool, 2u * tile.at + 12u));
    first.high      = vxs_blocks_join(tile.kind, first.high, second.high, vxs_four_bytes(blocks, tile.pool, 2u * tile.at + 16u));
    return first;
}

/* All texels of a tile that is neither all lit nor all shadowed; 1 for shadow. */
VXS_INLINE vxs_mask vxs_blocks_mask(VXS_WORDS blocks, vxs_blocks_tile tile)
{
    vxs_mask mask;
    if (tile.kind == VXS_BLOCKS_MASKS) return vxs_blocks_quadrants(blocks, tile);
    if (tile.kind == VXS_BLOCKS_PLANE) return vxs_blocks_plane_mask(tile);
    if (tile.kind > VXS_BLOCKS_PLANE) return vxs_blocks_two_planes(blocks, tile);
    mask.low  = 0u;
    mask.high = 0u;
    for (vxs_u32 c = 0u; c < 4u; c++) {
        vxs_u32 bits = tile.kind == VXS_BLOCKS_NIBBLES ? vxs_blocks_nibbles(blocks, tile, c) : vxs_blocks_raw(blocks, tile, c);
        if (c < 2u)
            mask.low |= bits << (16u * c);
        else
            mask.high |= bits << (16u * c - 32u);
    }
    return mask;
}

#else

/* Texels z and z + 32 of a tile that is neither all lit nor all shadowed, for all z in [begin, end); 1 for shadow. If one shader
 * invocation of a group takes a branch, all of the group execute it (on some machines always); but a loop ends as soon as no
 * invocation needs it. So each kind of tile has a loop of its own. */
VXS_FN vxs_mask vxs_blocks_texels(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_u32 begin, vxs_u32 end)
{
    vxs_mask mask = vxs_uniform_mask(0u), first = mask;
    vxs_u32  kind = tile.kind, bytes_at = 2u * tile.at;
    vxs_u32  bytes  = kind == VXS_BLOCKS_NIBBLES || kind == VXS_BLOCKS_RAW ? end : 0u;
    vxs_u32  raw    = kind > VXS_BLOCKS_RAW && kind < VXS_BLOCKS_PLANE ? end : 0u;
    vxs_u32  planes = kind > VXS_BLOCKS_PLANE ? 2u : kind == VXS_BLOCKS_PLANE ? 1u : 0u;
    vxs_u32  masks = kind == VXS_BLOCKS_MASKS ? tile.count : 0u, columns = kind == VXS_BLOCKS_MASKS ? (end + 15u) >> 4 : 0u;
    vxs_u32  even = 0u, odd = 0u, even_upto = 0u, odd_upto = 0u, index = VXS_U(tile.k);

    /* Each quadrant of a mask has a state of two bits: no texels, all texels, a new half, or the previous half of the quadrant
     * again. Halves are stored quadrant by quadrant, and within a quadrant mask by mask, so the halves before the wanted one have
     * to be counted. This counts four masks at once: a product with 0x01010101 makes of each byte the sum of all bytes up to it;
     * its nibbles count quadrants 0 and 2, or 1 and 3. */
    for (vxs_u32 n = 0u; n < masks; n += 4u) {
        vxs_u32 skip = masks - n < 4u ? 4u - (masks - n) : 0u, at = 8u * (index - n + skip);
        vxs_u32 states = vxs_four_bytes(blocks, tile.pool, bytes_at + n) << (8u * skip), halves = (states >> 1) & ~states;
        vxs_u32 even_sums = (halves & 0x11111111u) * 0x01010101u, odd_sums = ((halves >> 2) & 0x11111111u) * 0x01010101u;
        if (index - n < 4u) {
            even_upto = even + ((even_sums >> at) & 0xffu);
            odd_upto  = odd + ((odd_sums >> at) & 0xffu);
        }
        even += even_sums >> 24;
        odd += odd_sums >> 24;
    }
    for (vxs_u32 c = begin >> 4; c < columns; c++) {
        vxs_u32 states = vxs_byte(blocks, tile.pool, bytes_at + index), upto = c == 0u ? even_upto : odd_upto;
        vxs_u32 before = c == 0u ? 0u : even, below = (even & 15u) + (odd & 15u) + (before >> 4);
        mask.low |= vxs_blocks_half(blocks, tile, states, c, (before & 15u) + (upto & 15u)) << (16u * c);
        mask.high |= vxs_blocks_half(blocks, tile, states, c + 2u, below + (upto >> 4)) << (16u * c);
    }
    for (vxs_u32 z = begin & 28u; z < bytes; z += 4u) {
        vxs_u32 low = vxs_four_bytes(blocks, tile.pool, bytes_at + z), high = low >> 4, bases = tile.bases >> (8u * (z >> 4));
        vxs_i32 at_low = tile.k - VXS_I(bases & 0xffu), at_high = tile.k - VXS_I((bases >> 16) & 0xffu);
        if (kind == VXS_BLOCKS_RAW) {
            high = vxs_four_bytes(blocks, tile.pool, bytes_at + z + 32u);
        } else { /* texels z and z + 32 are in one byte */
            low &= 0x0f0f0f0fu;
            high &= 0x0f0f0f0fu;
        }
        if (at_low >= 0) mask.low |= vxs_four_at_most(low, VXS_U(at_low < 255 ? at_low : 255)) << z;
        if (at_high >= 0) mask.high |= vxs_four_at_most(high, VXS_U(at_high < 255 ? at_high : 255)) << z;
    }
    for (vxs_u32 z = begin; z < raw; z++) {
        mask.low |= vxs_blocks_raw_texel(blocks, tile, z) << z;
        mask.high |= vxs_blocks_raw_texel(blocks, tile, z + 32u) << z;
    }
    for (vxs_u32 n = 0u; n < planes; n++) {
        vxs_blocks_tile plane = tile;
        if (kind != VXS_BLOCKS_PLANE) plane = vxs_blocks_one_plane(blocks, tile, n);
        first = mask;
        mask  = vxs_uniform_mask(0u);
        for (vxs_u32 z = begin; z < end; z++) {
            vxs_u32 depth = plane.count * (((z >> 2) & 4u) | (z & 3u)) + plane.bases * ((z >> 2) & 3u);
            mask.low |= (VXS_I(depth) <= plane.k ? 1u : 0u) << z;
            mask.high |= (VXS_I(depth + 4u * plane.bases) <= plane.k ? 1u : 0u) << z;
        }
    }
    if (planes == 2u) {
        mask.low  = vxs_blocks_join(kind, first.low, mask.low, vxs_four_bytes(blocks, tile.pool, bytes_at + 12u));
        mask.high = vxs_blocks_join(kind, first.high, mask.high, vxs_four_bytes(blocks, tile.pool, bytes_at + 16u));
    }
    return mask;
}

/* A word of a mask by rows of 8 texels: exchanges bytes, then nibbles. */
VXS_FN vxs_u32 vxs_blocks_by_rows(vxs_u32 bits)
{
    vxs_u32 other = (bits ^ (bits >> 8)) & 0xff00u;
    bits ^= other ^ (other << 8);
    other = (bits ^ (bits >> 4)) & 0xf000f0u;
    return bits ^ other ^ (other << 4);
}

VXS_INLINE vxs_mask vxs_blocks_mask(VXS_WORDS blocks, vxs_blocks_tile tile)
{
    return vxs_blocks_texels(blocks, tile, 0u, 32u);
}

#endif

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

/* Whether the exact answer is available for all squares of 256 x 256 texels that a box touches (vxs_blocks_square_is_known).
 * If not, the top answers for the whole box. A box touches few squares. */
VXS_FN vxs_u32 vxs_blocks_is_known(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_blocks_box box, vxs_i32 k)
{
    for (vxs_i32 y = box.y0 >> 8; y <= (box.y1 - 1) >> 8; y++)
        for (vxs_i32 x = box.x0 >> 8; x <= (box.x1 - 1) >> 8; x++)
            if (vxs_blocks_square_is_known(blocks, map, levels, VXS_U(x), VXS_U(y), k) == 0u) return 0u;
    return 1u;
}

/* Whether a box touches more than one square. */
VXS_FN vxs_u32 vxs_blocks_crosses(vxs_blocks_box box)
{
    return (((box.x0 ^ (box.x1 - 1)) | (box.y0 ^ (box.y1 - 1))) >> 8) != 0 ? 1u : 0u;
}

#ifdef VXS_C

/* 1 if voxel (i, j, k) is in shadow, else 0; each of i, j, k in [0, 2^levels).
 * blocks  the words of the light;   map  0, or 0 to 5 for a light with six maps
 * levels  the map has 2^levels texels a side, and as many voxels in depth: 3 to 18 */
VXS_FN vxs_u32 vxs_blocks_shadow(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_u32 i, vxs_u32 j, vxs_u32 k)
{
    vxs_blocks_node node = vxs_blocks_find_node(blocks, map, levels, i >> 8, j >> 8, VXS_I(k));
    if (node.kind != VXS_BLOCKS_MASKS) return node.kind;

    vxs_blocks_block block = vxs_blocks_find_block(blocks, node, ((i >> 5) & 7u) | (((j >> 5) & 7u) << 3));
    vxs_i32          depth = vxs_blocks_tile_depth(node, VXS_I((i >> 3) & 31u), VXS_I((j >> 3) & 31u));
    vxs_u32          rank  = vxs_blocks_block_rank(blocks, block, depth);
    vxs_u32          kind  = vxs_blocks_block_kind(block, rank, depth);
    if (kind != VXS_BLOCKS_MASKS) return kind;

    vxs_blocks_tile tile = vxs_blocks_find_tile(blocks, node, block, ((i >> 3) & 3u) | (((j >> 3) & 3u) << 2), rank, depth);
    if (tile.kind < VXS_BLOCKS_MASKS) return tile.kind;
    return vxs_blocks_texel(blocks, tile, ((i >> 2) & 1u) | (((j >> 2) & 1u) << 1), (i & 3u) | ((j & 3u) << 2));
}

/* width_px x width_px texels; (x, y) is the first. */
VXS_FN vxs_blocks_box vxs_blocks_box_at(vxs_i32 x, vxs_i32 y, vxs_i32 width_px)
{
    vxs_blocks_box box;
    box.x0 = x;
    box.x1 = x + width_px;
    box.y0 = y;
    box.y1 = y + width_px;
    return box;
}

/* Part of a box that lies in the square at (x, y), relative to (x, y). */
VXS_FN vxs_blocks_box vxs_blocks_cut(vxs_blocks_box box, vxs_i32 x, vxs_i32 y, vxs_i32 side)
{
    box.x0 = vxs_clamp(box.x0 - x, 0, side);
    box.x1 = vxs_clamp(box.x1 - x, 0, side);
    box.y0 = vxs_clamp(box.y0 - y, 0, side);
    box.y1 = vxs_clamp(box.y1 - y, 0, side);
    return box;
}

VXS_INLINE vxs_blocks_taps vxs_blocks_cut_taps(vxs_blocks_taps taps, vxs_i32 x, vxs_i32 y, vxs_i32 side)
{
    taps.box     = vxs_blocks_cut(taps.box, x, y, side);
    taps.farther = vxs_blocks_cut(taps.farther, x, y, side);
    return taps;
}

/* Sum of the weights of all taps. */
VXS_INLINE vxs_u32 vxs_blocks_area(vxs_blocks_taps taps)
{
    vxs_u32 columns =
        taps.across * VXS_U(taps.box.x1 - taps.box.x0) + taps.across_farther * VXS_U(taps.farther.x1 - taps.farther.x0);
    vxs_u32 rows = taps.down * VXS_U(taps.box.y1 - taps.box.y0) + taps.down_farther * VXS_U(taps.farther.y1 - taps.farther.y0);
    return columns * rows;
}

/* Sum of the weights of the shadowed texels of a map, by the coarse answer of the top. */
VXS_APART vxs_u32 vxs_blocks_count_coarse(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_blocks_taps taps, vxs_i32 k)
{
    vxs_u32 count = 0u;
    for (vxs_i32 y = taps.box.y0 >> 8; y <= (taps.farther.y1 - 1) >> 8; y++)
        for (vxs_i32 x = taps.box.x0 >> 8; x <= (taps.farther.x1 - 1) >> 8; x++)
            count += vxs_blocks_coarse(blocks, map, levels, VXS_U(x), VXS_U(y), k) *
                     vxs_blocks_area(vxs_blocks_cut_taps(taps, 256 * x, 256 * y, 256));
    return count;
}

/* The box of all taps. */
VXS_INLINE vxs_blocks_box vxs_blocks_span(vxs_blocks_taps taps)
{
    taps.box.x1 = taps.farther.x1;
    taps.box.y1 = taps.farther.y1;
    return taps.box;
}

/* Bits of one word of a mask in texel columns [x0, x1), 0 to 8. vxs_blocks_rows: in rows [y0, y1), 0 to 4. */
VXS_FN vxs_u32 vxs_blocks_columns(vxs_i32 x0, vxs_i32 x1)
{
    vxs_u32 row = (1u << VXS_U(x1)) - (1u << VXS_U(x0));
    return ((row & 15u) | ((row >> 4) << 16)) * 0x1111u;
}

VXS_FN vxs_u32 vxs_blocks_rows(vxs_i32 y0, vxs_i32 y1)
{
    return ((1u << VXS_U(4 * y1)) - (1u << VXS_U(4 * y0))) * 0x10001u;
}

/* Sum of the column weights of the texels of a mask in rows [y0, y1). */
VXS_INLINE vxs_u32 vxs_blocks_count_in_rows(vxs_mask mask, vxs_blocks_taps taps, vxs_i32 y0, vxs_i32 y1)
{
    vxs_u32 columns = vxs_blocks_columns(taps.box.x0, taps.box.x1), farther = vxs_blocks_columns(taps.farther.x0, taps.farther.x1);
    mask.low &= vxs_blocks_rows(vxs_clamp(y0, 0, 4), vxs_clamp(y1, 0, 4));
    mask.high &= vxs_blocks_rows(vxs_clamp(y0 - 4, 0, 4), vxs_clamp(y1 - 4, 0, 4));
    return taps.across * vxs_popcount_pair(mask.low & columns, mask.high & columns) +
           taps.across_farther * vxs_popcount_pair(mask.low & farther, mask.high & farther);
}

/* Sum of the weights of the shadowed texels of a tile.   taps  cut to the tile */
VXS_INLINE vxs_u32 vxs_blocks_count_in_tile(VXS_WORDS blocks, vxs_blocks_tile tile, vxs_blocks_taps taps)
{
    if (tile.kind < VXS_BLOCKS_MASKS) return tile.kind * vxs_blocks_area(taps);
    vxs_mask mask = vxs_blocks_mask(blocks, tile);
    return taps.down * vxs_blocks_count_in_rows(mask, taps, taps.box.y0, taps.box.y1) +
           taps.down_farther * vxs_blocks_count_in_rows(mask, taps, taps.farther.y0, taps.farther.y1);
}

/* Sum of the weights of the shadowed texels of block (x, y) of a node.   taps  cut to the block. The slope makes depth grow
 * towards one corner of the box, so the least and the last depth of its tiles are at two corners; between these depths all
 * tiles may be lit or shadowed. */
VXS_INLINE vxs_u32 vxs_blocks_count_in_block(VXS_WORDS blocks, vxs_blocks_node node, vxs_i32 x, vxs_i32 y, vxs_blocks_taps taps)
{
    vxs_blocks_block block  = vxs_blocks_find_block(blocks, node, VXS_U(x | (y << 3)));
    vxs_i32          tile_x = 4 * x, tile_y = 4 * y; /* in the node */
    vxs_i32          x0 = taps.box.x0 >> 3, x1 = (taps.farther.x1 - 1) >> 3, y0 = taps.box.y0 >> 3, y1 = (taps.farther.y1 - 1) >> 3;
    vxs_u32          left = node.slope & 0x8000u, up = node.slope & 0x80000000u; /* nonzero: depth grows to the left, or up */
    vxs_i32          depth = vxs_blocks_tile_depth(node, tile_x + (left != 0u ? x1 : x0), tile_y + (up != 0u ? y1 : y0));
    vxs_i32          last  = vxs_blocks_tile_depth(node, tile_x + (left != 0u ? x0 : x1), tile_y + (up != 0u ? y0 : y1));
    vxs_u32          rank = vxs_blocks_block_rank(blocks, block, depth), count = 0u;
    vxs_u32          kind = vxs_blocks_block_kind(block, rank, last);
    if (kind != VXS_BLOCKS_MASKS) return kind * vxs_blocks_area(taps);

    for (vxs_i32 v = y0; v <= y1; v++)
        for (vxs_i32 u = x0; u <= x1; u++) {
            vxs_i32 tile_depth = vxs_blocks_tile_depth(node, tile_x + u, tile_y + v);
            if (tile_depth != depth) rank = vxs_blocks_block_rank(blocks, block, tile_depth);
            depth                = tile_depth;
            vxs_blocks_tile tile = vxs_blocks_find_tile(blocks, node, block, VXS_U(u | (v << 2)), rank, depth);
            count += vxs_blocks_count_in_tile(blocks, tile, vxs_blocks_cut_taps(taps, 8 * u, 8 * v, 8));
        }
    return count;
}

/* Sum of the weights of the shadowed texels of the square of 256 x 256 texels at (x, y) of a map.   taps  cut to the square */
VXS_INLINE vxs_u32 vxs_blocks_count_in_square(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 x, vxs_i32 y,
                                              vxs_blocks_taps taps, vxs_i32 k)
{
    vxs_u32         count = 0u;
    vxs_blocks_node node  = vxs_blocks_find_node(blocks, map, levels, VXS_U(x), VXS_U(y), k);
    if (node.kind != VXS_BLOCKS_MASKS) return node.kind * vxs_blocks_area(taps);
    for (vxs_i32 v = taps.box.y0 >> 5; v <= (taps.farther.y1 - 1) >> 5; v++)
        for (vxs_i32 u = taps.box.x0 >> 5; u <= (taps.farther.x1 - 1) >> 5; u++)
            count += vxs_blocks_count_in_block(blocks, node, u, v, vxs_blocks_cut_taps(taps, 32 * u, 32 * v, 32));
    return count;
}

/* The same for several squares: if one has no exact answer, the top answers for all. Few lookups reach this function. */
VXS_APART vxs_u32 vxs_blocks_count_in_squares(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_blocks_taps taps, vxs_i32 k)
{
    vxs_u32 count = 0u;
    if (vxs_blocks_is_known(blocks, map, levels, vxs_blocks_span(taps), k) == 0u)
        return vxs_blocks_count_coarse(blocks, map, levels, taps, k);
    for (vxs_i32 y = taps.box.y0 >> 8; y <= (taps.farther.y1 - 1) >> 8; y++)
        for (vxs_i32 x = taps.box.x0 >> 8; x <= (taps.farther.x1 - 1) >> 8; x++)
            count += vxs_blocks_count_in_square(blocks, map, levels, x, y, vxs_blocks_cut_taps(taps, 256 * x, 256 * y, 256), k);
    return count;
}

/* Sum of the weights of the shadowed texels of a map. */
VXS_INLINE vxs_u32 vxs_blocks_count_taps(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_blocks_taps taps, vxs_i32 k)
{
    vxs_i32 x = taps.box.x0 >> 8, y = taps.box.y0 >> 8;
    if (vxs_blocks_crosses(vxs_blocks_span(taps)) != 0u) return vxs_blocks_count_in_squares(blocks, map, levels, taps, k);
    return vxs_blocks_count_in_square(blocks, map, levels, x, y, vxs_blocks_cut_taps(taps, 256 * x, 256 * y, 256), k);
}

/* Taps of a filter of width_px, centred on (i, j), that lie in the map. */
VXS_INLINE vxs_blocks_taps vxs_blocks_filter_taps(vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_i32 width_px)
{
    vxs_blocks_taps taps;
    taps.box            = vxs_blocks_cut(vxs_blocks_box_at(i - width_px / 2, j - width_px / 2, width_px), 0, 0, VXS_I(1) << levels);
    taps.farther        = taps.box;
    taps.across         = 1u;
    taps.across_farther = 0u;
    taps.down           = 1u;
    taps.down_farther   = 0u;
    return taps;
}

/* Taps of a smooth filter around a place, that lie in the map. */
VXS_INLINE vxs_blocks_taps vxs_blocks_smooth_taps(vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 across, vxs_u32 down,
                                                  vxs_i32 width_px)
{
    vxs_smooth_box  begin = vxs_smooth_box_at(i, j, across, down, width_px);
    vxs_blocks_taps taps;
    taps.box     = vxs_blocks_box_at(begin.x, begin.y, width_px);
    taps.farther = taps.box;
    if (begin.across != 0u) {
        taps.farther.x0 += 1;
        taps.farther.x1 += 1;
    }
    if (begin.down != 0u) {
        taps.farther.y0 += 1;
        taps.farther.y1 += 1;
    }
    taps.across         = 256u - begin.across;
    taps.across_farther = begin.across;
    taps.down           = 256u - begin.down;
    taps.down_farther   = begin.down;
    return vxs_blocks_cut_taps(taps, 0, 0, VXS_I(1) << levels);
}

/* Number of the K x K texels centred on (i, j) that are in shadow at depth k: a box PCF by popcount. Other arguments as above.
 * i, j       any texel within +-2^30; taps outside the map are lit (no caster is there);   k  [0, 2^levels)
 * width_px  K, odd, 1 to VXS_FILTER_MAX.   Each of the at most nine tiles that the box touches is read once. */
VXS_FN vxs_u32 vxs_blocks_shadow_count(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 k,
                                       vxs_i32 width_px)
{
    return vxs_blocks_count_taps(blocks, map, levels, vxs_blocks_filter_taps(levels, i, j, width_px), VXS_I(k));
}

/* Shadowed part of a box of K x K texels around a place in texel (i, j) at depth k, in units of 1 / (65536 K K). Each texel
 * counts by the part of it that the box covers. Arguments as for vxs_shadow_weight (vxs_lookup.h), and as above. Each of the
 * at most 16 tiles that the box touches is read once. */
VXS_APART vxs_u32 vxs_blocks_shadow_weight(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 across,
                                           vxs_u32 down, vxs_u32 k, vxs_i32 width_px)
{
    return vxs_blocks_count_taps(blocks, map, levels, vxs_blocks_smooth_taps(levels, i, j, across, down, width_px), VXS_I(k));
}

/* 1 if the answer of vxs_blocks_shadow (width_px 1) or vxs_blocks_shadow_count is exact; 0 if a page is missing and the
 * answer is coarse. */
VXS_FN vxs_u32 vxs_blocks_is_full(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 k, vxs_i32 width_px)
{
    return vxs_blocks_is_known(blocks, map, levels, vxs_blocks_span(vxs_blocks_filter_taps(levels, i, j, width_px)), VXS_I(k));
}

/* The same for vxs_blocks_shadow_weight. */
VXS_FN vxs_u32 vxs_blocks_weight_is_full(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 across,
                                         vxs_u32 down, vxs_u32 k, vxs_i32 width_px)
{
    vxs_blocks_taps taps = vxs_blocks_smooth_taps(levels, i, j, across, down, width_px);
    return vxs_blocks_is_known(blocks, map, levels, vxs_blocks_span(taps), VXS_I(k));
}

#else

/* Texels of tile (x, y) of a node's map, at least z and z + 32 for z in [begin, end) of their numbers in the tile; in the mask,
 * texel (x, y) is bit x + 8y. */
VXS_FN vxs_mask vxs_blocks_slice(VXS_WORDS blocks, vxs_blocks_node node, vxs_blocks_block block, vxs_u32 x, vxs_u32 y,
                                 vxs_u32 begin, vxs_u32 end)
{
    if (node.kind != VXS_BLOCKS_MASKS) return vxs_uniform_mask(node.kind);
    vxs_blocks_tile tile = vxs_blocks_find_tile(blocks, node, block, x, y);
    if (tile.kind < VXS_BLOCKS_MASKS) return vxs_uniform_mask(tile.kind);
    vxs_mask mask = vxs_blocks_texels(blocks, tile, begin, end);
    mask.low      = vxs_blocks_by_rows(mask.low);
    mask.high     = vxs_blocks_by_rows(mask.high);
    return mask;
}

/* The same as in C, for shaders. */
VXS_FN vxs_u32 vxs_blocks_shadow(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_u32 i, vxs_u32 j, vxs_u32 k)
{
    vxs_u32          z     = ((i & 4u) << 2) | ((j & 3u) << 2) | (i & 3u);
    vxs_blocks_node  node  = vxs_blocks_find_node(blocks, map, levels, i >> 8, j >> 8, VXS_I(k));
    vxs_blocks_block block = vxs_blocks_find_block(blocks, node, ((i >> 5) & 7u) | (((j >> 5) & 7u) << 3));
    vxs_mask         mask  = vxs_blocks_slice(blocks, node, block, i >> 3, j >> 3, z, z + 1u);
    return (((j & 4u) != 0u ? mask.high : mask.low) >> ((i & 7u) + 8u * (j & 3u))) & 1u;
}

/* Texels of a map that a smooth box covers. */
VXS_FN vxs_blocks_box vxs_blocks_covered(vxs_u32 levels, vxs_smooth_box box, vxs_i32 width_px)
{
    vxs_i32        side = VXS_I(1) << levels;
    vxs_blocks_box covered;
    covered.x0 = box.x < 0 ? 0 : box.x;
    covered.y0 = box.y < 0 ? 0 : box.y;
    covered.x1 = box.x + width_px + (box.across != 0u ? 1 : 0);
    covered.y1 = box.y + width_px + (box.down != 0u ? 1 : 0);
    covered.x1 = covered.x1 > side ? side : covered.x1;
    covered.y1 = covered.y1 > side ? side : covered.y1;
    return covered;
}

VXS_FN vxs_u32 vxs_blocks_shadow_weight(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 across,
                                        vxs_u32 down, vxs_u32 k, vxs_i32 width_px)
{
    vxs_smooth_box box     = vxs_smooth_box_at(i, j, across, down, width_px);
    vxs_blocks_box covered = vxs_blocks_covered(levels, box, width_px);
    vxs_i32        x = covered.x0 & ~7, y = covered.y0 & ~7;
    vxs_u32        sum = 0u, is_coarse = 0u, last = 0xffffffffu;

    vxs_blocks_node  node  = vxs_blocks_whole_node(VXS_BLOCKS_LIT, VXS_I(k));
    vxs_blocks_block block = vxs_blocks_whole_block(0u, 0);
    if (vxs_blocks_crosses(covered) != 0u) is_coarse = 1u - vxs_blocks_is_known(blocks, map, levels, covered, VXS_I(k));
    /* one loop: with nested ones, each would run as many rounds as the longest one in the group of shader invocations */
    while (y < covered.y1 && x < covered.x1) {
        vxs_u32 u = VXS_U(x) >> 5, v = VXS_U(y) >> 5;
        if ((u | (v << 16)) != last) {
            last = u | (v << 16);
            node = vxs_blocks_find_node(blocks, map, levels, u >> 3, v >> 3, VXS_I(k));
            if (is_coarse != 0u) node.kind = vxs_blocks_coarse(blocks, map, levels, u >> 3, v >> 3, VXS_I(k));
            block = vxs_blocks_find_block(blocks, node, (u & 7u) | ((v & 7u) << 3));
        }
        vxs_mask mask = vxs_blocks_slice(blocks, node, block, VXS_U(x) >> 3, VXS_U(y) >> 3, 0u, 32u);
        sum += vxs_weigh_mask(mask, box, box.x - x, box.y - y, width_px, 1);
        x += 8;
        if (x >= covered.x1) {
            x = covered.x0 & ~7;
            y += 8;
        }
    }
    return sum;
}

/* A box is the smooth box about the middle of a texel. */
VXS_FN vxs_u32 vxs_blocks_shadow_count(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 k,
                                       vxs_i32 width_px)
{
    return vxs_blocks_shadow_weight(blocks, map, levels, i, j, 128u, 128u, k, width_px) >> 16;
}

VXS_FN vxs_u32 vxs_blocks_weight_is_full(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 across,
                                         vxs_u32 down, vxs_u32 k, vxs_i32 width_px)
{
    vxs_smooth_box box = vxs_smooth_box_at(i, j, across, down, width_px);
    return vxs_blocks_is_known(blocks, map, levels, vxs_blocks_covered(levels, box, width_px), VXS_I(k));
}

VXS_FN vxs_u32 vxs_blocks_is_full(VXS_WORDS blocks, vxs_u32 map, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 k, vxs_i32 width_px)
{
    return vxs_blocks_weight_is_full(blocks, map, levels, i, j, 128u, 128u, k, width_px);
}

#endif

#endif
