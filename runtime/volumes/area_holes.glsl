/* Gaps between points in imperfect shadow maps, from coarser levels of the same map: a workgroup for each. counts: lamps, levels, the side of a map, the first
 * word of all maps. */
layout(local_size_x = 256) in;

const float steepest = 4.0; /* of one surface: how much farther it goes away from a texel to the next than these are apart */

float depth_at(uint n)
{
    return uintBitsToFloat(vxs_area.words[n]);
}

/* How far away a surface may be that has a depth in a texel of a level with so many a side. */
float end_of_surface(uint lamp, uint side, ivec2 texel, float depth)
{
    return depth + steepest * vxs_area_texel_metres(lamp, vec2(texel) + 0.5, side, depth);
}

/* The mean of those of four texels, 2 by 2 of a finer level, that are of the nearest surface, as a word; VXS_NO_END: there is none.   first  of the four */
uint mean_of(uint lamp, uint side, ivec2 texel, uint first)
{
    uint  words[4] = uint[4](vxs_area.words[first], vxs_area.words[first + 1u], vxs_area.words[first + 2u * side], vxs_area.words[first + 2u * side + 1u]);
    uint  nearest = min(min(words[0], words[1]), min(words[2], words[3]));
    float depth = uintBitsToFloat(nearest), end = end_of_surface(lamp, side, texel, depth), sum = 0.0, count = 0.0;
    if (!(depth < VXS_NO_END)) return nearest;
    for (int n = 0; n < 4; n++) {
        if (uintBitsToFloat(words[n]) > end) continue;
        sum += uintBitsToFloat(words[n]);
        count += 1.0;
    }
    return vxs_area_word(sum / count, nearest & vxs_area_reach);
}

/* The farthest depth of a texel of a level and of those on its four sides; VXS_NO_END: it is at the border of what casts shadows, which would grow. */
float farthest_about(uint level, int side, ivec2 texel)
{
    const ivec2 sides[5] = ivec2[5](ivec2(0), ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));
    float farthest = 0.0;
    for (int n = 0; n < 5; n++) {
        ivec2 at = clamp(texel + sides[n], ivec2(0), ivec2(side - 1));
        farthest = max(farthest, depth_at(level + uint(at.y * side + at.x)));
    }
    return farthest;
}

void main()
{
    uint lamp = gl_WorkGroupID.x, side = vxs_frame.counts.z, maps = vxs_frame.counts.w, levels = vxs_frame.counts.y;
    for (uint level = 1u; level <= levels; level++) {
        uint part = side >> level, from = vxs_area_level(maps, lamp, side, level - 1u), to = vxs_area_level(maps, lamp, side, level);
        for (uint n = gl_LocalInvocationID.x; n < part * part; n += 256u)
            vxs_area.words[to + n] = mean_of(lamp, part, ivec2(n % part, n / part), from + 4u * part * (n / part) + 2u * (n % part));
        memoryBarrierBuffer();
        barrier();
    }
    for (uint level = levels; level > 0u; level--) {
        int  part = int(side >> level), finer = 2 * part;
        uint from = vxs_area_level(maps, lamp, side, level), to = vxs_area_level(maps, lamp, side, level - 1u);
        for (int n = int(gl_LocalInvocationID.x); n < finer * finer; n += 256) {
            ivec2 block = ivec2(n % finer, n / finer) / 2;
            uint  word = vxs_area.words[from + uint(block.y * part + block.x)];
            if ((word & vxs_area_reach) < level) continue;
            float depth = depth_at(to + uint(n)), farthest = farthest_about(from, part, block);
            float end = depth < VXS_NO_END ? end_of_surface(lamp, uint(part), block, uintBitsToFloat(word)) : depth;
            /* nothing is seen there, or what is behind a surface that goes on about it */
            if (depth >= end && farthest < VXS_NO_END && farthest <= end) vxs_area.words[to + uint(n)] = word;
        }
        memoryBarrierBuffer();
        barrier();
    }
}
