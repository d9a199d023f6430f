/* Tiles of the tables of a light (gl_tables.h). Compiled behind words.glsl. Loops end for any words. */
#ifdef VXS_GL_TABLES
#define VXS_TABLES
/* What vxs_tile takes for a map of a light of palette blocks: 0x80000000 | where its squares start. */
uint vxs_table_root(uint words, uint map, uint levels)
{
    return 0x80000000u | (vxs_word(words, 0u) + (map << (2u * max(levels, 8u) - 16u)));
}

/* Texels of tile (x, y) that are in shadow at depth k: texel (x, y) is bit x + 8y of two words, of which words.x and words.y are
 * computed: 0 or 1. */
uvec2 vxs_table_words(uint root, uint levels, uint x, uint y, uint k, uvec2 words)
{
    int  deep   = int(k);
    uint record = 0u, depth = vxs_word(root & 0x7fffffffu, ((y >> 5) << (max(levels, 8u) - 8u)) + (x >> 5));
    if (depth < 0x80000000u) {
        uint slope = vxs_word(depth, 0u);
        int  u = int(x & 31u), v = int(y & 31u), across = int(slope << 16) >> 16, down = int(slope) >> 16;
        deep += (across * (across < 0 ? u - 31 : u) + down * (down < 0 ? v - 31 : v)) >> 8;
        depth = vxs_word(depth, 1u + ((x >> 2) & 7u) + ((y & 28u) << 1));
        if (depth < 0x80000000u) {
            depth += 2u * (x & 3u) + 8u * (y & 3u);
            record = vxs_word(depth, 1u);
            depth  = vxs_word(depth, 0u);
        }
    }
    deep -= int(depth & 0x7fffffffu);
    uint  bits = deep < 0 ? 0u : record >> 28, at = record & 0x0fffffffu, plane_at = at + (1u << bits) - 1u, node = 0u;
    uvec2 same = uvec2(deep < 0 ? 0u : 0xffffffffu), less = uvec2(0u); /* texels whose rank is that of k so far, or less */
    for (uint n = 0u; n < bits; n++) {
        uint  is_deeper = deep >= int(vxs_word(at, node)) ? 0xffffffffu : 0u;
        uvec2 plane     = uvec2(vxs_word(plane_at, words.x), vxs_word(plane_at, words.y)), other = plane ^ is_deeper;
        less |= same & other & is_deeper;
        same &= ~other;
        node = 2u * node + 1u - is_deeper;
        plane_at += 2u;
    }
    return same | less;
}

uvec2 vxs_table_tile(uint root, uint levels, uint x, uint y, uint k)
{
    return vxs_table_words(root, levels, x, y, k, uvec2(0u, 1u));
}

/* 1 if voxel (i, j, k) is in shadow, else 0. */
uint vxs_table_tap(uint root, uint levels, uint i, uint j, uint k)
{
    return (vxs_table_words(root, levels, i >> 3, j >> 3, k, uvec2((j >> 2) & 1u)).x >> ((i & 7u) + 8u * (j & 3u))) & 1u;
}
#endif
