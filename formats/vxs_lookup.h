/* Layout of a DAG node, and the lookup in a DAG: one text for C99, C++, GLSL and HLSL.
 *
 * The DAG of a light is an array of 32-bit words (formats/vxs.md section 6). The root is at word 0; a light with six maps
 * has six roots, and words 0 to 5 are where they start. A node is
 *
 *     word 0      bits 2c, 2c+1: state of child c (VXS_CHILD_*), c = 0..7; bits 16..31 are zero
 *     word 1...   one offset for each child that is VXS_CHILD_OWN, in the order of c
 *
 * A node of side 16 voxels or more is an octree node: c = x + 2y + 4z, z away from the light; an offset is the word where
 * the child starts. A node of side 8 is a stack of eight slices, c = z; an offset is the word where a visibility mask of 8 x
 * 8 texels starts: texel (x, y) is bit x + 8y of two words, low word first, 1 for shadow.
 *
 *     octree node      [states][child 1][child 4]                   children 0..7, two of them own
 *     slice node       [states][mask a][mask b]                     slices  ..aaab#  .. lit, # shadow, aa the same mask
 *     mask             [rows 0 to 3][rows 4 to 7]
 *
 * Shading languages have no pointers and no common way to access a buffer. So the includer defines how a word is read:
 *
 *     vxs_word(dag, i)   word i of a light. C and C++: dag[i]. A shader defines it before this text; there dag is the word
 *                        where the words of the light start in a buffer or texture with the words of all lights:
 *                            #define vxs_word(dag, i) shadow_words[(dag) + (i)]
 *     vxs_popcount(x)    number of bits set in x; the default is a built-in function, or arithmetic if the language has none
 *     VXS_WORDS          type of dag: const uint32_t * in C and C++, uint in a shader
 *     VXS_HLSL           defined by the includer for HLSL compilers that do not define __HLSL_VERSION
 *
 * GLSL 3.30 and later, ES 3.00 and later, and GLSL for Vulkan are distinguished by their predefined macros. The text
 * declares only structs and functions, and has no continued lines, which GLSL 3.30 lacks. In ES it sets highp for int and
 * float from here on, because mediump may be 16 bits.
 *
 * Offsets are not checked here: vxs_read_dag.c checks them once, before any lookup.
 * Source: [CPVS16] 3 and 5; [Sintorn 2014] for PCF by popcount.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_LOOKUP_H
#define VXS_LOOKUP_H

#if defined(__HLSL_VERSION) && !defined(VXS_HLSL)
#define VXS_HLSL
#endif
#if !defined(VXS_HLSL) && (defined(__STDC__) || defined(__cplusplus) || defined(_MSC_VER))
#define VXS_C
#endif

#ifdef VXS_C
#include <stdint.h>
typedef uint32_t              vxs_u32;
typedef int32_t               vxs_i32;
typedef struct vxs_mask       vxs_mask;
typedef struct vxs_smooth_box vxs_smooth_box;
#define VXS_FN static inline
#ifdef __cplusplus /* a C cast may be a warning there */
#define VXS_CAST(type, x) (type(x))
#else
#define VXS_CAST(type, x) ((type)(x))
#endif
#define VXS_U(x) VXS_CAST(vxs_u32, x)
#define VXS_I(x) VXS_CAST(vxs_i32, x)
#if !defined(VXS_WORDS) && !defined(vxs_word)
#define VXS_WORDS_IN_MEMORY
#endif
#ifndef VXS_WORDS
#define VXS_WORDS const uint32_t *
#endif
#ifndef vxs_word
#define vxs_word(dag, i) (dag)[i]
#endif
#if !defined(vxs_popcount) && defined(__GNUC__) && defined(__POPCNT__)
#define vxs_popcount(x) ((vxs_u32)__builtin_popcount(x))
#endif
#else
#ifdef GL_ES
precision highp float;
precision highp int;
#endif
#define vxs_u32 uint
#define vxs_i32 int
#define VXS_FN
#define VXS_U(x) uint(x)
#define VXS_I(x) int(x)
#ifndef VXS_WORDS
#define VXS_WORDS uint
#endif
#ifndef vxs_word
#error vxs_word is not defined: see the head of vxs_lookup.h
#endif
#if !defined(vxs_popcount) && defined(VXS_HLSL)
#define vxs_popcount(x) countbits(x)
#elif !defined(vxs_popcount) && (__VERSION__ >= 400 || (defined(GL_ES) && __VERSION__ >= 310))
#define vxs_popcount(x) uint(bitCount(x))
#endif
#endif

#ifndef vxs_popcount
VXS_FN vxs_u32 vxs_popcount(vxs_u32 x)
{
    x = x - ((x >> 1) & 0x55555555u);
    x = (x & 0x33333333u) + ((x >> 2) & 0x33333333u);
    return (((x + (x >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24;
}
#endif

/* VXS_INLINE: functions on the path of every lookup; a call would pass their structs through memory, which costs a fifth of
 * the time, but for builds with VXS_SMALL, which are to be small: WebAssembly. VXS_APART: functions that few lookups need; inlined,
 * they would take registers from the others. */
#if defined(VXS_C) && defined(__GNUC__) && !defined(VXS_SMALL)
#define VXS_INLINE VXS_FN __attribute__((always_inline))
#else
#define VXS_INLINE VXS_FN
#endif
#if defined(VXS_C) && defined(__GNUC__)
#define VXS_APART static __attribute__((noinline, unused))
#else
#define VXS_APART VXS_FN
#endif

/* Mask of a slice of 8 x 8 texels: texel (x, y) is bit x + 8y of two words, 1 for shadow. */
struct vxs_mask {
    vxs_u32 low;  /* rows 0 to 3 */
    vxs_u32 high; /* rows 4 to 7 */
};

/* A box of K x K texels that need not begin at a texel border: it covers K + 1 texels in a row, the first and the last in
 * part. It is the weighted mean of four boxes of whole texels: the first begins at (x, y), two begin one texel farther along
 * one axis, and the last along both. */
struct vxs_smooth_box {
    vxs_i32 x, y; /* the first texel that the box covers */
    vxs_u32 across,
        /* uncovered part of that texel, in 1/256: [0, 255]; 0: K whole texels, and the boxes one texel farther have weight 0 */
        down;
};

/* States of children (low bit of each pair) that have an offset of their own: binary 10. */
VXS_FN vxs_u32 vxs_own(vxs_u32 states)
{
    return (states >> 1) & ~states & 0x5555u;
}

/* Word where the root of map `face` starts, for a light with six maps. The root of a light with one map is 0. */
VXS_FN vxs_u32 vxs_face_root(VXS_WORDS dag, vxs_u32 face)
{
    return vxs_word(dag, face);
}

/* Mask of a slice of 8 x 8 x 1 voxels that is all lit (state 0) or all in shadow (1). */
VXS_FN vxs_mask vxs_uniform_mask(vxs_u32 state)
{
    vxs_mask mask;
    mask.low  = 0u - state;
    mask.high = 0u - state;
    return mask;
}

/* Mask of a slice of 8 x 8 x 1 voxels: the tile of 8 x 8 texels at (tile_x, tile_y), at depth k voxels.
 * dag     the words of the light;   root  0, or vxs_face_root of the map
 * levels  the map has 2^levels texels a side, and as many voxels in depth
 * tile_x, tile_y  [0, 2^(levels-3));   k  [0, 2^levels) */
VXS_FN vxs_mask vxs_slice(VXS_WORDS dag, vxs_u32 root, vxs_u32 levels, vxs_u32 tile_x, vxs_u32 tile_y, vxs_u32 k)
{
    vxs_u32 node = root;
    vxs_u32 states, state;
    for (vxs_u32 level = levels - 3u; level > 0u; level--) {
        vxs_u32 bit = level - 1u;
        vxs_u32 xy  = ((tile_x >> bit) & 1u) | (((tile_y >> bit) & 1u) << 1);
        vxs_u32 c   = xy | (((k >> (bit + 3u)) & 1u) << 2);
        states      = vxs_word(dag, node);
        state       = (states >> (2u * c)) & 3u;
        if (state == 3u) { /* VXS_CHILD_SAME: the sibling with z = 0 owns the offset */
            c     = xy;
            state = 2u;
        }
        if (state != 2u) return vxs_uniform_mask(state);
        node = vxs_word(dag, node + 1u + vxs_popcount(vxs_own(states) & ((1u << (2u * c)) - 1u)));
    }

    vxs_u32 slice = k & 7u;
    states        = vxs_word(dag, node);
    state         = (states >> (2u * slice)) & 3u;
    if (state < 2u) return vxs_uniform_mask(state);
    /* the last slice at or before this one that owns a mask; this also covers VXS_CHILD_SAME */
    vxs_u32  at = vxs_word(dag, node + vxs_popcount(vxs_own(states) & ((2u << (2u * slice)) - 1u)));
    vxs_mask mask;
    mask.low  = vxs_word(dag, at);
    mask.high = vxs_word(dag, at + 1u);
    return mask;
}

#ifdef VXS_TABLES
/* The same for any light of libvxs_gl, which has tables of palette blocks (runtime/gl/gl_tables.h): root from vxs_root_of. */
vxs_mask vxs_tile(uint dag, uint root, uint levels, uint tile_x, uint tile_y, uint k)
{
    vxs_mask mask = vxs_uniform_mask(0u);
#if !defined(VXS_ONLY_CODING) || VXS_ONLY_CODING == 1
    if (root < 0x80000000u) mask = vxs_slice(dag, root, levels, tile_x, tile_y, k);
#endif
#if !defined(VXS_ONLY_CODING) || VXS_ONLY_CODING == 2
    if (root >= 0x80000000u) {
        uvec2 rows = vxs_table_tile(root, levels, tile_x, tile_y, k);
        mask.low   = rows.x;
        mask.high  = rows.y;
    }
#endif
    return mask;
}
#else
#define vxs_tile vxs_slice
#endif

/* 1 if voxel (i, j, k) is in shadow, else 0; each of i, j, k in [0, 2^levels). */
VXS_FN vxs_u32 vxs_shadow(VXS_WORDS dag, vxs_u32 root, vxs_u32 levels, vxs_u32 i, vxs_u32 j, vxs_u32 k)
{
    vxs_mask mask = vxs_tile(dag, root, levels, i >> 3, j >> 3, k);
    return (((j & 4u) != 0u ? mask.high : mask.low) >> ((i & 7u) + 8u * (j & 3u))) & 1u;
}

#ifdef VXS_C
VXS_FN vxs_i32 vxs_clamp(vxs_i32 x, vxs_i32 low, vxs_i32 high)
{
    return x < low ? low : x > high ? high : x;
}
#else
#define vxs_clamp(x, low, high) clamp(x, low, high)
#endif

/* Bits [first, end) of 8. The range is clamped. */
VXS_FN vxs_u32 vxs_bits(vxs_i32 first, vxs_i32 end)
{
    first = vxs_clamp(first, 0, 8);
    return (1u << VXS_U(vxs_clamp(end, first, 8))) - (1u << VXS_U(first));
}

/* Texels in the rows of a mask whose bits are set in `rows`: of 8, from vxs_bits. */
VXS_FN vxs_mask vxs_in_rows(vxs_mask mask, vxs_u32 rows)
{
    /* the product has bit n of four at bit 8 n */
    mask.low &= (((rows & 15u) * 0x204081u) & 0x1010101u) * 255u;
    mask.high &= (((rows >> 4) * 0x204081u) & 0x1010101u) * 255u;
    return mask;
}

/* Number of texels of a mask in the columns whose bits are set in `columns`: of 8, from vxs_bits. */
VXS_FN vxs_u32 vxs_count_columns(vxs_mask mask, vxs_u32 columns)
{
    columns *= 0x1010101u;
    return vxs_popcount(mask.low & columns) + vxs_popcount(mask.high & columns);
}

/* Number of texels of a mask in shadow in columns [x0, x1) and rows [y0, y1); ranges are clamped to the mask. */
VXS_FN vxs_u32 vxs_count_covered(vxs_mask mask, vxs_i32 x0, vxs_i32 x1, vxs_i32 y0, vxs_i32 y1)
{
    return vxs_count_columns(vxs_in_rows(mask, vxs_bits(y0, y1)), vxs_bits(x0, x1));
}

/* Number of the K x K texels centred on (i, j) that are in shadow at depth k: a box PCF by popcount ([CPVS16] 5).
 * i, j       any texel within +-2^30; taps outside the map are lit (no caster is there);   k  [0, 2^levels)
 * width_px  K, odd, 1 to VXS_FILTER_MAX.   Cost: one walk for each of the at most nine tiles that the box touches. */
VXS_FN vxs_u32 vxs_shadow_count(VXS_WORDS dag, vxs_u32 root, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 k, vxs_i32 width_px)
{
    vxs_i32 half_px = width_px / 2;
    vxs_i32 side    = VXS_I(1) << levels;
    vxs_i32 x0      = i - half_px < 0 ? 0 : i - half_px;
    vxs_i32 y0      = j - half_px < 0 ? 0 : j - half_px;
    vxs_i32 x1      = i + half_px + 1 > side ? side : i + half_px + 1;
    vxs_i32 y1      = j + half_px + 1 > side ? side : j + half_px + 1;
    vxs_u32 count   = 0u;
#ifdef VXS_GL_STREAM
    root = vxs_table_root_for(root, levels, ivec2(x0, y0), ivec2(x1, y1), k);
#endif
    for (vxs_i32 y = y0 & ~7; y < y1; y += 8)
        for (vxs_i32 x = x0 & ~7; x < x1; x += 8) {
            vxs_mask mask = vxs_tile(dag, root, levels, VXS_U(x) >> 3, VXS_U(y) >> 3, k);
            count += vxs_count_covered(mask, x0 - x, x1 - x, y0 - y, y1 - y);
        }
    return count;
}

/* The smooth box whose middle is `across` and `down`, [0, 255], in 1/256 texel, from the near corner of texel (i, j). */
VXS_FN vxs_smooth_box vxs_smooth_box_at(vxs_i32 i, vxs_i32 j, vxs_u32 across, vxs_u32 down, vxs_i32 width_px)
{
    vxs_i32        x = VXS_I(across) - 128 * width_px, y = VXS_I(down) - 128 * width_px;
    vxs_smooth_box box;
    box.x      = i + (x >> 8);
    box.y      = j + (y >> 8);
    box.across = VXS_U(x & 255);
    box.down   = VXS_U(y & 255);
    return box;
}

/* Weighted sum, in 1/65536, of the number of shadowed texels in the four boxes of a smooth box: the first, and those one
 * texel to the right, down, and both. */
VXS_FN vxs_u32 vxs_weighted(vxs_smooth_box box, vxs_u32 first, vxs_u32 right, vxs_u32 down, vxs_u32 both)
{
    return (256u - box.down) * ((256u - box.across) * first + box.across * right) +
           box.down * ((256u - box.across) * down + box.across * both);
}

/* Shadowed part of a mask in a smooth box; x and y: first texel of the box, relative to the mask.
 * wide  texels of the mask for one of the box: 1, or a power of two; the mask then has the texels that count, and no others */
VXS_FN vxs_u32 vxs_weigh_smooth(vxs_mask mask, vxs_smooth_box box, vxs_i32 x, vxs_i32 y, vxs_i32 width_px, vxs_i32 wide)
{
    vxs_i32  end_x = x + width_px * wide, end_y = y + width_px * wide;
    vxs_u32  columns = vxs_bits(x, end_x), right = vxs_bits(x + wide, end_x + wide);
    vxs_mask upper = vxs_in_rows(mask, vxs_bits(y, end_y)), lower = vxs_in_rows(mask, vxs_bits(y + wide, end_y + wide));
    return vxs_weighted(box, vxs_count_columns(upper, columns), vxs_count_columns(upper, right), vxs_count_columns(lower, columns),
                        vxs_count_columns(lower, right));
}

/* The same; where a shader has no smooth filters, of whole texels, which takes a quarter of the work. */
#ifdef VXS_ONLY_SMOOTH
VXS_FN vxs_u32 vxs_weigh_mask(vxs_mask mask, vxs_smooth_box box, vxs_i32 x, vxs_i32 y, vxs_i32 width_px, vxs_i32 wide)
{
    vxs_u32 part;
    if (VXS_ONLY_SMOOTH != 0)
        part = vxs_weigh_smooth(mask, box, x, y, width_px, wide);
    else
        part = 65536u * vxs_count_covered(mask, x, x + width_px * wide, y, y + width_px * wide);
    return part;
}
#else
#define vxs_weigh_mask vxs_weigh_smooth
#endif

/* Shadowed part of a box of K x K texels around a place in texel (i, j) at depth k, in units of 1 / (65536 K K). Each texel
 * counts by the part of it that the box covers. Other arguments as above.
 * across, down  the place in the texel, in 1/256 texel: [0, 255];   width_px  K, 1 to VXS_FILTER_MAX, even or odd
 * For K odd and the middle of a texel (128), the result is 65536 times vxs_shadow_count. Cost: one walk for each tile that
 * the box touches. */
VXS_FN vxs_u32 vxs_shadow_weight(VXS_WORDS dag, vxs_u32 root, vxs_u32 levels, vxs_i32 i, vxs_i32 j, vxs_u32 across, vxs_u32 down,
                                 vxs_u32 k, vxs_i32 width_px)
{
    vxs_smooth_box box  = vxs_smooth_box_at(i, j, across, down, width_px);
    vxs_i32        side = VXS_I(1) << levels;
    vxs_i32        x0 = box.x < 0 ? 0 : box.x, x1 = box.x + width_px + (box.across != 0u ? 1 : 0);
    vxs_i32        y0 = box.y < 0 ? 0 : box.y, y1 = box.y + width_px + (box.down != 0u ? 1 : 0);
    vxs_i32        x = x0 & ~7, y = y0 & ~7;
    vxs_u32        sum = 0u;
    x1                 = x1 > side ? side : x1;
    y1                 = y1 > side ? side : y1;
#ifdef VXS_GL_STREAM
    root = vxs_table_root_for(root, levels, ivec2(x0, y0), ivec2(x1, y1), k);
#endif
    /* one loop: nested ones would run as many rounds as the longest of each in a group of shader invocations */
    while (y < y1 && x < x1) {
        vxs_mask mask = vxs_tile(dag, root, levels, VXS_U(x) >> 3, VXS_U(y) >> 3, k);
        sum += vxs_weigh_mask(mask, box, box.x - x, box.y - y, width_px, 1);
        x += 8;
        if (x >= x1) {
            x = x0 & ~7;
            y += 8;
        }
    }
    return sum;
}

#endif
