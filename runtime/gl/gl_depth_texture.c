/* A whole map as a depth texture; see vxs_gl_depths.h.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"
#include "vxs_gl_depths.h"
#include "vxs_query.h"

/* Texels that are decoded at a time. */
enum { TEXELS_AT_ONCE = 1 << 21 };

/* In place: voxel depths as 16 bits have them. */
static void pack_depths(uint32_t *voxels, size_t count, uint32_t levels)
{
    for (size_t n = 0; n < count; n++) {
        uint64_t depth  = (((uint64_t)voxels[n] << 16) + (1u << levels) - 1) >> levels;
        uint16_t packed = depth > 65535 ? 65535 : (uint16_t)depth;
        memcpy((char *)voxels + n * sizeof packed, &packed, sizeof packed);
    }
}

/* Decode and write strips of rows.   rows  [strip_px * side] room for a strip */
static int write_map(const vxs_gl *gl, const vxs_baked_light *baked, vxs_depth_map_desc *desc, uint32_t bits, gl_name texture,
                     void *rows, uint32_t strip_px)
{
    uint32_t side = desc->wide_px;
    int      coarse, any = 0;
    for (uint32_t y = 0; y < side; y += desc->high_px) {
        desc->j       = (int32_t)(y << desc->shift);
        desc->high_px = side - y < strip_px ? side - y : strip_px;
        desc->voxels  = bits == 16 ? rows : NULL;
        desc->depths  = bits == 16 ? NULL : rows;
        vxs_depth_map(baked, desc, &coarse); /* arguments are known to be good */
        if (bits == 16) pack_depths(rows, (size_t)side * desc->high_px, baked->light.levels);
        vxs_gl_depths_write(gl, texture, bits, (gl_rectangle){0, (int)y, (int)side, (int)desc->high_px}, 0, rows);
        any |= coarse;
    }
    return any;
}

vxs_result vxs_gl_depth_texture(const vxs_gl *gl, const vxs_baked_light *baked, int map, uint32_t level, uint32_t bits,
                                unsigned *texture, int *coarse)
{
    uint32_t levels = baked->light.levels, maps = vxs_map_count(&baked->light);
    *texture = 0;
    if (coarse) *coarse = 0;
    if (map < 0 || (uint32_t)map >= maps || level > levels || (bits != 16 && bits != 32)) return VXS_E_ARGUMENT;
    uint32_t side = 1u << (levels - level), strip_px = side * (uint64_t)side < TEXELS_AT_ONCE ? side : TEXELS_AT_ONCE / side;
    uint64_t texels         = (uint64_t)side * strip_px;
    /* rows of 16 bits are aligned to 4 bytes, but for a texture of one texel, which is one row */
    vxs_depth_map_desc desc = {.struct_size = sizeof desc, .map = map, .wide_px = side, .shift = level};
    void              *rows = vxs_gl_alloc(gl, texels, sizeof(uint32_t));
    if (!rows) return VXS_E_MEMORY;
    *texture = vxs_gl_depths_make(gl, side, bits);
    if (*texture) {
        int any = write_map(gl, baked, &desc, bits, *texture, rows, strip_px);
        if (coarse) *coarse = any;
    }
    vxs_gl_free(gl, rows, texels, sizeof(uint32_t));
    return *texture ? VXS_OK : VXS_E_MEMORY;
}
