/* Points of what casts shadows, into imperfect shadow maps: each into that of one lamp, or of all. counts: lamps, points, 1 for all, the first word of all
 * maps; knobs: the side of a map, and how wide a point is drawn, of what it stands for. */
layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly buffer vxs_area_points { vec4 points[]; };

/* Where a point is in a lamp's map, and how deep there: of a lamp that is far away, in metres from one side of the sphere about all that casts.
 * wide  [out] metres of a texel there
 * Returns 0 and less where the map has no such point. */
float depth_of(uint lamp, vec3 way, int side, out vec2 at, out float wide)
{
    float radius = vxs_area.lamps[lamp].place.w, metres = length(way);
    at   = vxs_area_far_texel(lamp, way, side);
    wide = 2.0 * radius / float(side);
    if (vxs_area.lamps[lamp].normal.w == vxs_area_far) return max(abs(way.x), abs(way.y)) < 2.0 * radius ? way.z + radius : 0.0;
    if (!(way.z > 1e-4 * metres && metres > radius)) return 0.0;
    wide = metres * vxs_area_texel(way, side, at);
    return metres;
}

/* A square of texels as wide as what the point stands for, in the lamp's own map, and nowhere beyond it. */
void splat(uint lamp, vec4 point, float shared_by)
{
    const int most = 7;
    int  side = int(vxs_frame.knobs.x);
    uint texels = vxs_area_level(vxs_frame.counts.w, lamp, uint(side), 0u);
    vec3 way = vxs_area_way(lamp, point.xyz - vxs_area.lamps[lamp].place.xyz);
    vec2 at;
    float texel, metres = depth_of(lamp, way, side, at, texel);
    if (!(metres > 0.0)) return;
    float wide = vxs_frame.knobs.y * sqrt(point.w * shared_by) / texel;
    int   across = clamp(int(wide + 0.5), 1, most);
    ivec2 first = ivec2(floor(at - 0.5 * float(across - 1)));
    for (int n = 0; n < across * across; n++) {
        ivec2 texel = first + ivec2(n % across, n / across);
        if (all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(side))))
            atomicMin(vxs_area.words[texels + uint(texel.y * side + texel.x)], floatBitsToUint(metres));
    }
}

void main()
{
    uvec4 counts = vxs_frame.counts;
    uint  n = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
    if (n >= counts.y) return;
    if (counts.z == 0u)
        splat(vxs_area_hash(n) % counts.x, points[n], float(counts.x));
    else
        for (uint lamp = 0u; lamp < counts.x; lamp++) splat(lamp, points[n], 1.0);
}
