/* Fills gaps between points in imperfect shadow maps from coarser levels of the same map: a workgroup for each map. */
#include "area_map.glsl"

layout(local_size_x = 256) in;

const float steepest = 4.0; /* for texels of one surface: largest depth step between neighbours, in distances between them */

/* Largest depth of a surface that has the given depth in a texel of a level of the given side. */
float end_of_surface(uint vpl, int side, ivec2 texel, float depth)
{
    return depth + steepest * vxs_area_texel_metres(vpl, vxs_area_middle(texel, side), side, depth);
}

/* Of four texels, 2 x 2 of a finer level, the mean of those on the nearest surface, each evaluated in the middle of all; as a word.
 * side, texel  of the coarser level;   finer  the first word of the finer level */
uint mean_of(uint vpl, int side, ivec2 texel, uint finer)
{
    uint first = finer + uint(4 * texel.y * side + 2 * texel.x), below = first + 2u * uint(side);
    uint words[4] = uint[4](vxs_area.words[first], vxs_area.words[first + 1u], vxs_area.words[below], vxs_area.words[below + 1u]);
    uint nearest = min(min(words[0], words[1]), min(words[2], words[3]));
    if (nearest == vxs_area_none) return nearest;
    vxs_area_surface mean = vxs_area_surface(0.0, vec2(0.0), nearest & vxs_area_reach, true);
    float end = end_of_surface(vpl, side, texel, vxs_area_surface_of(vpl, nearest).depth), count = 0.0;
    for (int n = 0; n < 4; n++) {
        vxs_area_surface s = vxs_area_surface_of(vpl, words[n]);
        if (s.depth > end) continue;
        s = vxs_area_beside(vpl, s, vxs_area_middle(2 * texel + ivec2(n & 1, n >> 1), 2 * side), vxs_area_middle(texel, side));
        mean.depth += s.depth;
        mean.slope += s.slope;
        mean.is_plane = mean.is_plane && s.is_plane;
        count += 1.0;
    }
    mean.depth /= count;
    mean.slope /= count;
    return vxs_area_word(vpl, mean);
}

/* The greatest depth of a texel of a level and its four neighbours; VXS_NO_END at the border of a caster, which must not grow. */
float farthest_about(uint vpl, uint level, int side, ivec2 texel)
{
    const ivec2 sides[5] = ivec2[5](ivec2(0), ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));
    float farthest = 0.0;
    for (int n = 0; n < 5; n++) {
        ivec2 at = clamp(texel + sides[n], ivec2(0), ivec2(side - 1));
        farthest = max(farthest, vxs_area_surface_of(vpl, vxs_area.words[level + uint(at.y * side + at.x)]).depth);
    }
    return farthest;
}

/* Fill gaps in the four texels of a finer level that are in a texel: empty ones, and those behind a surface that continues
 * around them.
 * number, level, finer  of the coarser level: its number above the map, its first word, and that of the finer level */
void fill(uint vpl, int side, ivec2 texel, uint number, uint level, uint finer)
{
    uint word = vxs_area.words[level + uint(texel.y * side + texel.x)];
    if (word == vxs_area_none || (word & vxs_area_reach) < number) return;
    vxs_area_surface s = vxs_area_surface_of(vpl, word);
    float end = end_of_surface(vpl, side, texel, s.depth), farthest = 0.0;
    for (int n = 0; n < 4; n++) {
        ivec2 there = 2 * texel + ivec2(n & 1, n >> 1);
        uint  at = finer + uint(there.y * 2 * side + there.x);
        if (!(vxs_area_surface_of(vpl, vxs_area.words[at]).depth >= end)) continue;
        if (farthest == 0.0) farthest = farthest_about(vpl, level, side, texel);
        if (!(farthest < VXS_NO_END && farthest <= end)) return;
        vxs_area.words[at] = vxs_area_word(vpl, vxs_area_beside(vpl, s, vxs_area_middle(texel, side), vxs_area_middle(there, 2 * side)));
    }
}

void main()
{
    uint vpl = gl_WorkGroupID.x, side = vxs_area_pass.side, maps = vxs_area_pass.first_word, levels = vxs_area_pass.levels;
    for (uint turn = 0u; turn < 2u * levels; turn++) { /* to coarser levels, and back */
        bool is_back = turn >= levels;
        uint number = is_back ? 2u * levels - turn : turn + 1u;
        uint level = vxs_area_level(maps, vpl, side, number), finer = vxs_area_level(maps, vpl, side, number - 1u);
        int  part = int(side >> number), shift = findMSB(part);
        for (int n = int(gl_LocalInvocationID.x); n < part * part; n += 256) {
            ivec2 texel = ivec2(n & (part - 1), n >> shift);
            if (is_back)
                fill(vpl, part, texel, number, level, finer);
            else
                vxs_area.words[level + uint(n)] = mean_of(vpl, part, texel, finer);
        }
        memoryBarrierBuffer();
        barrier();
    }
}
