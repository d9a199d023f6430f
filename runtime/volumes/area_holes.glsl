/* Texels of imperfect shadow maps that no point fell on, from coarser levels of the same map: a workgroup for each. counts: lamps, levels, the side of a map,
 * the first word of all maps. */
layout(local_size_x = 256) in;

const float near_enough = 0.05; /* of the nearest: two of one surface; twice as much on each coarser level */

float depth_at(uint n)
{
    return uintBitsToFloat(vxs_area.words[n]);
}

/* The mean of those of four that are of the nearest surface; VXS_NO_END: there is none. */
float mean_of(float texels[4], float threshold)
{
    float nearest = min(min(texels[0], texels[1]), min(texels[2], texels[3])), sum = 0.0, count = 0.0;
    if (!(nearest < VXS_NO_END)) return VXS_NO_END;
    for (int n = 0; n < 4; n++) {
        if (texels[n] > nearest * (1.0 + threshold)) continue;
        sum += texels[n];
        count += 1.0;
    }
    return sum / count;
}

/* Whether a texel of a level has a depth, and those on its four sides have: not at the border of what casts shadows, which would grow. */
bool is_inside(uint level, int side, ivec2 texel)
{
    const ivec2 sides[5] = ivec2[5](ivec2(0), ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1));
    for (int n = 0; n < 5; n++) {
        ivec2 at = clamp(texel + sides[n], ivec2(0), ivec2(side - 1));
        if (!(depth_at(level + uint(at.y * side + at.x)) < VXS_NO_END)) return false;
    }
    return true;
}

void main()
{
    uint lamp = gl_WorkGroupID.x, side = vxs_frame.counts.z, maps = vxs_frame.counts.w, levels = vxs_frame.counts.y;
    for (uint level = 1u; level <= levels; level++) {
        uint part = side >> level, from = vxs_area_level(maps, lamp, side, level - 1u), to = vxs_area_level(maps, lamp, side, level);
        for (uint n = gl_LocalInvocationID.x; n < part * part; n += 256u) {
            uint  first = from + 4u * part * (n / part) + 2u * (n % part);
            float texels[4] = float[4](depth_at(first), depth_at(first + 1u), depth_at(first + 2u * part), depth_at(first + 2u * part + 1u));
            vxs_area.words[to + n] = floatBitsToUint(mean_of(texels, near_enough * float(1u << level)));
        }
        memoryBarrierBuffer();
        barrier();
    }
    for (uint level = levels; level > 0u; level--) {
        int  part = int(side >> level), finer = 2 * part;
        uint from = vxs_area_level(maps, lamp, side, level), to = vxs_area_level(maps, lamp, side, level - 1u);
        for (int n = int(gl_LocalInvocationID.x); n < finer * finer; n += 256) {
            ivec2 block = ivec2(n % finer, n / finer) / 2;
            if (!(depth_at(to + uint(n)) < VXS_NO_END) && is_inside(from, part, block))
                vxs_area.words[to + uint(n)] = vxs_area.words[from + uint(block.y * part + block.x)];
        }
        memoryBarrierBuffer();
        barrier();
    }
}
