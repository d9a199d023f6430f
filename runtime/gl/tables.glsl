/* Tiles of the tables of a light (gl_tables.h). Compiled behind words.glsl. Loops end for any words. */
#ifdef VXS_GL_TABLES
#define VXS_TABLES
/* What vxs_tile takes for a map of a light of palette blocks: 0x80000000 | where its squares start; and 0x40000000, if loaded pages
 * are taken as missing. */
uint vxs_table_root(const uint words, const uint map, const uint levels)
{
    return 0x80000000u | (words + (map << (2u * max(levels, 8u) - 16u)));
}

/* What a slope adds to k at tile (x, y) of its node, 0 to 31. */
int vxs_table_slope(const uint slope, const int x, const int y)
{
    int across = int(slope << 16) >> 16, down = int(slope) >> 16;
    return (across * (across < 0 ? x - 31 : x) + down * (down < 0 ? y - 31 : y)) >> 8;
}

/* Greatest delta of a record. */
uint vxs_table_last(const uint record)
{
    uint last = 0u, node = 0u, at = record & 0x0fffffffu;
    for (uint n = record >> 28; n > 0u; n--) {
        uint delta = vxs_word(at, node);
        if (delta < 0x7fffffffu) last = delta;
        node = 2u * node + (delta < 0x7fffffffu ? 2u : 1u);
    }
    return last;
}

/* Delta of texel (x, y), 0 to 7. */
uint vxs_table_delta(const uint record, const uint x, const uint y)
{
    uint bits = record >> 28, at = record & 0x0fffffffu, planes = at + (1u << bits) - 1u + (y >> 2), rank = 0u, node = 0u;
    for (uint n = 0u; n < bits; n++) {
        uint bit = (vxs_word(planes, 2u * n) >> (x + 8u * (y & 3u))) & 1u;
        if (bit != 0u) node = (1u << n) - 1u + rank; /* the tree has the delta of a rank at the level of its last bit */
        rank = 2u * rank + bit;
    }
    return rank != 0u ? vxs_word(at, node) : 0u;
}

#ifdef VXS_GL_STREAM
#define VXS_TABLE_AT 0x3fffffffu /* of a root */
#else
#define VXS_TABLE_AT 0x7fffffffu
#endif

/* Word of square (x, y) in the top. */
#define vxs_table_top(root, levels, x, y) vxs_word((root) & VXS_TABLE_AT, ((y) << (max(levels, 8u) - 8u)) + (x))

#ifndef VXS_GL_STREAM
#define vxs_table_square vxs_table_top
#else
bool vxs_table_is_missing(uint top)
{
    return (top >> 30) == 1u;
}

/* The same; where a page is missing, as a square of one depth: that at which its coarse answer begins. */
uint vxs_table_square(uint root, uint levels, uint x, uint y)
{
    uint square = vxs_table_top(root, levels, x, y);
    if (root >= 0xc0000000u && square < 0x40000000u) square = vxs_word(square, 3u);
    if (vxs_table_is_missing(square))
        square = 0x80000000u | (((((square & 0xffu) + ((square >> 8) & 0xffu)) >> 1) + 1u) << (max(levels, 8u) - 8u));
    return square;
}

/* Whether the answer for texels [begin, end) at depth k needs no page that is missing. */
bool vxs_table_is_known(uint root, uint levels, ivec2 begin, ivec2 end, uint k)
{
    uint  up     = max(levels, 8u) - 8u;
    ivec2 square = max(begin, 0) >> 8, last = (min(end, 1 << levels) - 1) >> 8;
    bool  known  = true;
    for (int y = square.y; y <= last.y; y++)
        for (int x = square.x; x <= last.x; x++) {
            uint top = vxs_table_top(root, levels, uint(x), uint(y)), least = top & 0xffu, greatest = (top >> 8) & 0xffu;
            known = known && (!vxs_table_is_missing(top) || (k >> up) < least || (k >> up) > greatest);
        }
    return known;
}

/* The root for a filter over texels [begin, end), cut to the map: if it needs a page that is missing, all of its taps get the coarse answer. */
uint vxs_table_root_for(uint root, uint levels, ivec2 begin, ivec2 end, uint k)
{
    bool crosses = any(notEqual(begin >> 8, (end - 1) >> 8));
    return root >= 0x80000000u && crosses && !vxs_table_is_known(root, levels, begin, end, k) ? root | 0x40000000u : root;
}
#endif

/* Find tile (x, y).
 * record  [out] of the tile; 0: all texels have one depth
 * Returns its least depth. */
int vxs_table_find(const uint root, const uint levels, const uint x, const uint y, out uint record)
{
    uint depth = vxs_table_square(root, levels, x >> 5, y >> 5);
    int  slope = 0;
    record     = 0u;
    if (depth < 0x80000000u) {
        slope = vxs_table_slope(vxs_word(depth, 0u), int(x & 31u), int(y & 31u));
        depth = vxs_word(depth, 4u + ((x >> 2) & 7u) + ((y & 28u) << 1));
        if (depth < 0x80000000u) {
            depth += 2u + 2u * (x & 3u) + 8u * (y & 3u);
            record = vxs_word(depth, 1u);
            depth  = vxs_word(depth, 0u);
        }
    }
    return int(depth & 0x7fffffffu) - slope;
}

/* Depth where the shadow of a texel begins, [0, 2^levels]; 2^levels: it has none. */
int vxs_table_depth(const uint root, const uint levels, const uint i, const uint j)
{
    uint record;
    int  least = vxs_table_find(root, levels, i >> 3, j >> 3, record);
    return clamp(least + int(vxs_table_delta(record, i & 7u, j & 7u)), 0, 1 << levels);
}

/* Texels of a tile that are in shadow at its least depth + deep: texel (x, y) is bit x + 8y of two words. */
uvec2 vxs_table_shadow(const uint record, const int deep)
{
    uint  bits = deep < 0 ? 0u : record >> 28, at = record & 0x0fffffffu, plane_at = at + (1u << bits) - 1u, node = 0u;
    uvec2 same = uvec2(deep < 0 ? 0u : 0xffffffffu), less = uvec2(0u); /* texels whose rank is that of k so far, or less */
    for (uint n = 0u; n < bits; n++) {
        uint  is_deeper = deep >= int(vxs_word(at, node)) ? 0xffffffffu : 0u;
        uvec2 plane     = uvec2(vxs_word(plane_at, 0u), vxs_word(plane_at, 1u)), other = plane ^ is_deeper;
        less |= same & other & is_deeper;
        same &= ~other;
        node = 2u * node + 1u - is_deeper;
        plane_at += 2u;
    }
    return same | less;
}

/* Texels of tile (x, y) that are in shadow at depth k. */
uvec2 vxs_table_tile(const uint root, const uint levels, const uint x, const uint y, const uint k)
{
    uint record;
    int  deep = int(k) - vxs_table_find(root, levels, x, y, record);
    return vxs_table_shadow(record, deep);
}

/* 1 if voxel (i, j, k) is in shadow, else 0. */
uint vxs_table_tap(const uint root, const uint levels, const uint i, const uint j, const uint k)
{
    uint record;
    int  deep = int(k) - vxs_table_find(root, levels, i >> 3, j >> 3, record);
    return deep >= int(vxs_table_delta(record, i & 7u, j & 7u)) ? 1u : 0u;
}
#endif
