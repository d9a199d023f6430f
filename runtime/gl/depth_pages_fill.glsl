/* Depths of the texels of new pages, and the bounds of each page. Compiled behind first_shadow.glsl,
 * vxs_depths.h, and depth_pages.glsl with VXS_PAGES_FILL. */
layout(local_size_x = 8, local_size_y = 8) in;
/* 8 words for each page: light, map, level, x, y of the page, page of the atlas, 0, 0; then 32-bit depths by rows, page by page;
 * then the same as the atlas has them, two to a word (depth_pages_pack.glsl) */
layout(std430, binding = VXS_PAGES_AT_WORK) restrict buffer vxs_fill_block { uint vxs_fill[]; };

/* Depth of a texel of a map; 2^levels: never in shadow.   is_there  [in, out] becomes false where words are missing */
uint vxs_depth_of(VXS_LIGHT light, int map, ivec2 texel, inout bool is_there)
{
#ifdef VXS_READS_BLOCKS
    if (VXS_CODING(light) == VXS_CODING_BLOCKS) {
        uint              words = light.first_word, m = uint(map);
        vxs_depths_square s     = vxs_depths_square_at(words, m, light.levels, texel.x, texel.y);
        is_there = is_there && s.coarse == 0;
        if (s.least == s.greatest) return uint(s.least);
        ivec2             tile  = (texel >> 3) & 31;
        vxs_blocks_node   node  = vxs_depths_node_of(words, m, light.levels, texel.x, texel.y, s.least);
        vxs_blocks_block  block = vxs_blocks_find_block(words, node, uint((tile.x >> 2) | ((tile.y >> 2) << 3)));
        vxs_depths_tile   t     = vxs_depths_tile_of(words, node, block, tile.x, tile.y, s.least, s.greatest);
        vxs_depths_bounds b     = vxs_depths_bound(words, t);
        if (b.least == b.greatest) return uint(b.least);
        return uint(vxs_depths_texel(words, t, b.least, b.greatest, uint(texel.x & 7), uint(texel.y & 7)));
    } else
#elif defined(VXS_GL_STREAM)
    if (VXS_CODING(light) == VXS_CODING_BLOCKS) {
        uint root = vxs_root_of(light.first_word, light, map);
        is_there = is_there && !vxs_table_is_missing(vxs_table_top(root, light.levels, uint(texel.x) >> 8, uint(texel.y) >> 8));
    }
#endif
        return uint(vxs_first_shadow(light, map, texel.x, texel.y));
}

void main()
{
    uint job = 8u * gl_WorkGroupID.z, level = vxs_fill[job + 2u], slot = vxs_fill[job + 5u];
    if (gl_GlobalInvocationID.x >= VXS_PAGES_STRIDE || gl_GlobalInvocationID.y >= VXS_PAGES_STRIDE) return;
    vxs_light_constants light = vxs_light_at(vxs_fill[job]);
    ivec2 texel = ivec2(vxs_fill[job + 3u], vxs_fill[job + 4u]) * 128 + ivec2(gl_GlobalInvocationID.xy) - int(VXS_PAGES_BORDER);
    int   side  = 1 << (light.levels - level), map = int(vxs_fill[job + 1u]);
    uint  never = uint(side), depth = never;
    if (all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(side)))) {
        ivec2 fine = (texel << level) + ((1 << level) >> 1);
        bool is_there = true;
        depth = vxs_depth_of(light, map, fine, is_there) >> level;
        if (!is_there) atomicOr(vxs_pages[VXS_PAGES_INFO + 4u * slot + 2u], 1u);
    }
    if (depth < never) {
        atomicMin(vxs_pages[VXS_PAGES_INFO + 4u * slot], depth);
        atomicMax(vxs_pages[VXS_PAGES_INFO + 4u * slot + 1u], depth);
    }
    vxs_fill[8u * VXS_PAGES_AT_ONCE + (gl_WorkGroupID.z * VXS_PAGES_STRIDE + gl_GlobalInvocationID.y) * VXS_PAGES_STRIDE +
             gl_GlobalInvocationID.x] = depth;
}
