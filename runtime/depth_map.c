/* Depth maps from baked lights; see vxs_query.h. The rectangle is covered by strips of eight texel rows, and each strip by boxes
 * of uniform depth: the strip's part of a uniform square of 256 texels or more, a tile, or a texel. A box is written to all
 * pixels that it overlaps.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "tile_depths.h"
#include "vxs_desc.h"
#include "vxs_query.h"

/* Texels [i0, i1) x [j0, j1) of a map. */
typedef struct texel_box {
    int32_t i0, i1, j0, j1;
} texel_box;

typedef struct depth_painter {
    const vxs_baked_light *baked;
    vxs_depth_map_desc     to;
    vxs_block_cursor       cursor;
    int                    coarse;
} depth_painter;

/* pixels ---------------------------------------------------------------------------------------------------------------------- */

static uint32_t *voxels_at(const vxs_depth_map_desc *to, uint32_t y)
{
    size_t stride = to->row_stride_bytes ? to->row_stride_bytes : to->wide_px * sizeof *to->voxels;
    return (uint32_t *)((char *)to->voxels + y * stride);
}

static float *depths_at(const vxs_depth_map_desc *to, uint32_t y)
{
    size_t stride = to->row_stride_bytes ? to->row_stride_bytes : to->wide_px * sizeof *to->depths;
    return (float *)((char *)to->depths + y * stride);
}

/* First pixel that depends on texels from `texel` on (relative to the rectangle): with VXS_DEPTH_CENTRE by its middle texel, else
 * by any texel. */
static uint32_t pixel_from(const vxs_depth_map_desc *to, int32_t texel)
{
    uint32_t size = 1u << to->shift, rest = to->which == VXS_DEPTH_CENTRE ? size / 2 : size - 1;
    return to->which == VXS_DEPTH_CENTRE ? ((uint32_t)texel + size - 1 - rest) >> to->shift : (uint32_t)texel >> to->shift;
}

/* End of the pixels that depend on texels before `texel`. */
static uint32_t pixel_end(const vxs_depth_map_desc *to, int32_t texel)
{
    if (to->which == VXS_DEPTH_CENTRE) return pixel_from(to, texel);
    return (uint32_t)(texel + (1 << to->shift) - 1) >> to->shift;
}

/* Write a depth to all pixels that overlap a box. Depths divided by 2^levels are exact floats in the same order, so that floats can
 * be compared instead of voxels. */
static void put_box(const depth_painter *p, texel_box box, int32_t depth)
{
    const vxs_depth_map_desc *to = &p->to;
    uint32_t x0 = pixel_from(to, box.i0 - to->i), x1 = pixel_end(to, box.i1 - to->i), y1 = pixel_end(to, box.j1 - to->j);
    uint32_t whole  = (uint32_t)depth;
    float    scaled = (float)whole * (1.0f / (float)(1 << p->baked->light.levels));
    for (uint32_t y = pixel_from(to, box.j0 - to->j); y < y1; y++) {
        uint32_t *voxels = to->voxels ? voxels_at(to, y) : NULL;
        float    *depths = to->depths ? depths_at(to, y) : NULL;
        for (uint32_t x = x0; x < x1 && voxels; x++)
            if (to->which == VXS_DEPTH_LEAST ? whole < voxels[x] : to->which == VXS_DEPTH_GREATEST ? whole > voxels[x] : 1)
                voxels[x] = whole;
        for (uint32_t x = x0; x < x1 && depths; x++)
            if (to->which == VXS_DEPTH_CENTRE || (to->which == VXS_DEPTH_LEAST ? scaled < depths[x] : scaled > depths[x]))
                depths[x] = scaled;
    }
}

/* texels ---------------------------------------------------------------------------------------------------------------------- */

static int32_t less(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

/* Write the texels of a box within a tile. */
static void paint_texels(const depth_painter *p, texel_box box, const int32_t depth[64])
{
    for (int32_t j = box.j0; j < box.j1; j++)
        for (int32_t i = box.i0; i < box.i1; i++) put_box(p, (texel_box){i, i + 1, j, j + 1}, depth[(i & 7) + 8 * (j & 7)]);
}

/* Write the first part of a strip: texels of one uniform square, or of one tile. Returns the column where it ends. */
static int32_t paint_blocks(depth_painter *p, texel_box strip)
{
    const vxs_blocks_map m = {p->baked->words, (uint32_t)p->to.map, p->baked->light.levels};
    vxs_depth_square     s = vxs_depth_square_at(m, strip.i0, strip.j0, -1, VXS_SQUARE_PX);
    int32_t              depth[64], whole = s.least == s.greatest;
    p->coarse |= s.coarse && s.low < s.high;
    strip.i1 = less(strip.i1, whole ? s.i + s.side_px : (strip.i0 | 7) + 1);
    if (!whole) whole = vxs_tile_depths(m, &p->cursor, strip.i0 >> 3, strip.j0 >> 3, depth) == VXS_TILE_WHOLE;
    if (whole)
        put_box(p, strip, s.least == s.greatest ? s.least : depth[0]);
    else
        paint_texels(p, strip, depth);
    return strip.i1;
}

/* Write a strip that is inside one row of tiles of the map, or completely above or below the map. */
static void paint_strip(depth_painter *p, texel_box strip)
{
    int32_t side = 1 << p->baked->light.levels, end = strip.i1, beside = strip.j0 < 0 || strip.j0 >= side;
    while (strip.i0 < end) {
        strip.i1 = end;
        if (beside || strip.i0 < 0 || strip.i0 >= side) {
            if (!beside && strip.i0 < 0) strip.i1 = less(end, 0);
            put_box(p, strip, side);
        } else if (p->baked->light.coding == VXS_CODING_BLOCKS) {
            strip.i1 = less(end, side);
            strip.i1 = paint_blocks(p, strip);
        } else {
            int32_t depth[64];
            strip.i1 = less(less(end, side), (strip.i0 | 7) + 1);
            vxs_dag_first_shadows(p->baked, (uint32_t)p->to.map, (uint32_t)strip.i0 >> 3, (uint32_t)strip.j0 >> 3, ~(uint64_t)0,
                                  depth);
            paint_texels(p, strip, depth);
        }
        strip.i0 = strip.i1;
    }
}

vxs_result vxs_depth_map(const vxs_baked_light *baked, const vxs_depth_map_desc *desc, int *coarse)
{
    depth_painter       p     = {.baked = baked};
    vxs_depth_map_desc *to    = &p.to;
    const int64_t       limit = 1 << 30;
    if (coarse) *coarse = 0;
    if (vxs_desc_take(to, sizeof *to, sizeof *to, desc) != VXS_OK) return VXS_E_ARGUMENT;
    if (to->map < 0 || to->map >= (int32_t)vxs_map_count(&baked->light)) return VXS_E_ARGUMENT;
    if (to->shift > baked->light.levels || to->which > VXS_DEPTH_GREATEST) return VXS_E_ARGUMENT;
    if (to->i < -limit || to->j < -limit || to->wide_px > limit || to->high_px > limit) return VXS_E_ARGUMENT;
    const int64_t wide = (int64_t)to->wide_px << to->shift, high = (int64_t)to->high_px << to->shift;
    if (wide > limit || high > limit || to->i + wide > limit || to->j + high > limit) return VXS_E_ARGUMENT;
    if (!to->wide_px || !to->high_px) return VXS_OK;

    /* Fill with the value that any depth replaces. */
    uint32_t levels = baked->light.levels;
    for (uint32_t y = 0; y < to->high_px && to->which != VXS_DEPTH_CENTRE; y++)
        for (uint32_t x = 0; x < to->wide_px; x++) {
            if (to->voxels) voxels_at(to, y)[x] = to->which == VXS_DEPTH_LEAST ? 1u << levels : 0;
            if (to->depths) depths_at(to, y)[x] = to->which == VXS_DEPTH_LEAST ? 1.0f : 0.0f;
        }

    int32_t   side = 1 << baked->light.levels;
    texel_box all  = {to->i, to->i + (int32_t)wide, to->j, to->j + (int32_t)high};
    for (int32_t j = all.j0, end; j < all.j1; j = end) {
        end = less(j < 0 ? 0 : j < side ? (j | 7) + 1 : all.j1, all.j1);
        paint_strip(&p, (texel_box){all.i0, all.i1, j, end});
    }
    if (coarse) *coarse = p.coarse;
    return VXS_OK;
}
