/* Points of what casts shadows, into imperfect shadow maps: of so many in a row each lamp has one. counts: lamps, points, how many in a row, the first word of
 * all maps; knobs: the side of a map, and how wide a point is drawn, and how wide texels are from which gaps may be filled, of what it stands for. */
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

/* The texels whose middles are in a square as wide as what the point stands for, or the one it is in, of the lamp's own map. */
void splat(uint lamp, vec4 point, float shared_by)
{
    const float most = 32.0;
    int  side = int(vxs_frame.knobs.x);
    uint texels = vxs_area_level(vxs_frame.counts.w, lamp, uint(side), 0u);
    vec3 way = vxs_area_way(lamp, point.xyz - vxs_area.lamps[lamp].place.xyz);
    vec2 at;
    float texel, metres = depth_of(lamp, way, side, at, texel);
    if (!(metres > 0.0)) return;
    float wide = sqrt(point.w * shared_by) / texel;
    uint  reach = uint(log2(clamp(vxs_frame.knobs.z * wide, 2.0, most)));
    float across = clamp(vxs_frame.knobs.y * wide - 0.5 * float(1u << reach), 1.0, most); /* the wider, the less wide gaps are filled */
    uint  word = vxs_area_word(metres, reach);
    ivec2 first = max(ivec2(ceil(at - 0.5 * across - 0.5)), ivec2(0)), last = min(ivec2(floor(at + 0.5 * across - 0.5)), ivec2(side - 1));
    for (int y = first.y; y <= last.y; y++)
        for (int x = first.x; x <= last.x; x++) atomicMin(vxs_area.words[texels + uint(y * side + x)], word);
}

void main()
{
    uvec4 counts = vxs_frame.counts;
    uint  n = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationID.x;
    if (n >= counts.y) return;
    for (uint first = 0u; first < counts.x; first += counts.z) {
        uint lamp = first + (n + vxs_area_hash(n / counts.z + first)) % counts.z;
        if (lamp < counts.x) splat(lamp, points[n], float(counts.z));
    }
}
