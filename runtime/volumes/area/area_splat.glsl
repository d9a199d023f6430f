/* Draws points of shadow casters into imperfect shadow maps. A workgroup has 64 consecutive points, and draws as many of them
 * into a VPL's map as that can resolve. */
#include "area_map.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly buffer vxs_area_points { vec4 points[]; };

const uint group_size = 64u;

/* Normal of the plane through points [first, first + count), by least squares; 0 if they are in a line, far apart, or not in a
 * plane.
 * point  one of them
 * off    largest RMS distance from the plane, in widths of what the point represents */
vec3 plane_of(uint first, uint count, vec4 point, float off)
{
    vec3 sum = vec3(0.0), squares = vec3(0.0), products = vec3(0.0);
    for (uint n = first; n < first + count; n++) {
        vec3 from = points[n].xyz - point.xyz;
        sum += from;
        squares += from * from;
        products += from.yzx * from.zxy;
    }
    vec3 mean = sum / float(count), along = squares / float(count) - mean * mean, both = products / float(count) - mean.yzx * mean.zxy;
    /* the columns of the adjugate of their covariance are along the normal: take the longest */
    vec3  minors = along.yzx * along.zxy - both * both, rest = both.yzx * both.zxy - both * along, normal = vec3(minors.x, rest.z, rest.y);
    float size = dot(along, vec3(1.0)), flat_size = dot(minors, vec3(1.0));
    if (minors.y > minors.x) normal = vec3(rest.z, minors.y, rest.x);
    if (minors.z > max(minors.x, minors.y)) normal = vec3(rest.y, rest.x, minors.z);
    /* along a row of triangles, points may be in a plane that is not that of their surface */
    if (!(flat_size > 0.05 * size * size && size < 0.5 * float(count) * point.w && dot(normal, normal) > 0.0)) return vec3(0.0);
    normal *= inversesqrt(dot(normal, normal));
    float square = dot(normal * normal, along) + 2.0 * dot(normal.yzx * normal.zxy, both);
    return square <= off * off * point.w ? normal : vec3(0.0);
}

/* The normal of the surface of a point, from neighbouring points; near an edge of a flat part, from points behind it or before
 * it. 0 if they are not in a plane.
 * first, count  consecutive points that contain this one */
vec3 normal_of(uint n, uint first, uint count)
{
    const uint some = 9u;
    const uint before[3] = uint[3](4u, 0u, 8u);
    vec3 normal = vec3(0.0);
    for (int k = 0; k < 3 && count >= some && normal == vec3(0.0); k++)
        normal = plane_of(min(n - min(n - first, before[k]), first + count - some), some, points[n], k == 0 ? 0.1 : 0.05);
    return normal;
}

/* Position of a point in a VPL's map, and its depth; for a distant VPL, metres from one side of the sphere around all casters.
 * wide  [out] width of a texel there, in metres
 * Returns 0 or less if the point is not in the map. */
float depth_of(uint vpl, vec3 way, int side, out vec2 at, out float wide)
{
    float radius = vxs_area.vpls[vpl].place.w, metres = length(way);
    at   = vxs_area_far_texel(vpl, way, side);
    wide = 2.0 * radius / float(side);
    if (vxs_area_is_far(vpl)) return max(abs(way.x), abs(way.y)) < 2.0 * radius ? way.z + radius : 0.0;
    if (!(way.z > 1e-4 * metres && metres > radius)) return 0.0;
    wide = metres * vxs_area_texel(way, side, at);
    return metres;
}

/* Width of a disc along x and y of the map, relative to a disc that faces the light.   normal  of the disc, in the VPL's frame */
vec2 foreshortened(uint vpl, vec3 normal, vec2 at)
{
    float square = dot(at, at);
    vec3  right = vec3(1.0, 0.0, 0.0), up = vec3(0.0, 1.0, 0.0);
    if (!vxs_area_is_far(vpl)) {
        right = vec3(1.0 + square - 2.0 * at.x * at.x, -2.0 * at.x * at.y, -2.0 * at.x) / (1.0 + square);
        up    = vec3(-2.0 * at.x * at.y, 1.0 + square - 2.0 * at.y * at.y, -2.0 * at.y) / (1.0 + square);
    }
    vec2 along = vec2(dot(normal, right), dot(normal, up));
    return sqrt(max(1.0 - along * along, vec2(0.0)));
}

/* Draw the texels whose middles are in the area of a point: in a disc on its surface, with the depth of that surface; or, if the
 * surface is not known, in a square that faces the light. An area narrower than the distance of texels covers as many of them as
 * its share of the map.
 * normal      of the surface; 0: not known
 * stands_for  number of points that this point represents */
void splat(uint vpl, vec4 point, vec3 normal, float stands_for)
{
    /* largest width in texels; radius of a disc with the area of a square of side 1 */
    const float most = 32.0, radius_of_1 = 0.564;
    int   side = int(vxs_area_pass.side);
    bool  is_flat = normal != vec3(0.0);
    vec3  way = vxs_area_way(vpl, point.xyz - vxs_area.vpls[vpl].place.xyz), turned = vxs_area_way(vpl, normal);
    vec2  at;
    float texel, depth = depth_of(vpl, way, side, at, texel);
    if (!(depth > 0.0)) return;
    float wide = sqrt(point.w * stands_for) / texel, across = min(vxs_area_pass.point_wide * wide, most);
    uint  reach = uint(log2(clamp(vxs_area_pass.gap_wide * wide, 2.0, most)));
    /* so that it extends no farther from its surface than needed */
    if (!is_flat) across = max(across - 0.5 * float(1u << reach), min(across, 1.0));
    float radius = radius_of_1 * across * texel;
    vec2  half_wide = vec2(0.5 * across);
    if (is_flat) /* the nearer part of it appears wider */
        half_wide = min((1.0 + min(radius / depth, 1.0)) * radius / texel * foreshortened(vpl, turned, at * (2.0 / float(side)) - 1.0), vec2(0.5 * most));
    ivec2 first = max(ivec2(ceil(at - half_wide - 0.5)), ivec2(0)), last = min(ivec2(floor(at + half_wide - 0.5)), ivec2(side - 1));
    for (int y = first.y; y <= last.y; y++)
        for (int x = first.x; x <= last.x; x++) {
            vxs_area_surface s = vxs_area_surface(depth, vec2(0.0), reach, is_flat);
            if (is_flat) {
                vec2 middle = vxs_area_middle(ivec2(x, y), side);
                s = vxs_area_plane(vpl, turned, way, middle);
                s.reach = reach;
                vec3 off = vxs_area_place_of(vpl, middle, s.depth) - way;
                if (!(s.depth > 0.0 && dot(off, off) <= radius * radius)) continue;
            }
            atomicMin(vxs_area.words[vxs_area_map_word(vxs_area_pass.first_word, vpl, side, ivec2(x, y))], vxs_area_word(vpl, s));
        }
}

/* Number of points of a group that a VPL's map can resolve, at the distance that the frame gives, for the point nearest to the
 * VPL; at most group_size.
 * ball           around the points, and its radius
 * square_metres  the largest area that a point represents
 * Returns 0 if all of them are behind the VPL. */
float count_of(uint vpl, vec4 ball, float square_metres)
{
    float side = float(vxs_area_pass.side), radius = vxs_area.vpls[vpl].place.w, texel = 2.0 * radius / side, cosine = 1.0;
    if (!vxs_area_is_far(vpl)) {
        vec3  way = ball.xyz - vxs_area.vpls[vpl].place.xyz;
        float metres = length(way), before = dot(way, vxs_area.vpls[vpl].normal.xyz) + ball.w;
        if (!(before > 0.0)) return 0.0;
        cosine = clamp(before / max(metres, 1e-20), 0.1, 1.0); /* fewer in directions where the VPL emits less */
        texel  = 4.0 / side * max(metres - ball.w, radius);
    }
    texel *= vxs_area_pass.points_apart;
    return min(float(group_size) * cosine * square_metres / (texel * texel), float(group_size));
}

/* A ball around most of a group's points: around every eighth point, enlarged by about the distance between these.
 * square_metres  [out] the largest area that a point represents */
vec4 ball_about(uint first, uint count, out float square_metres)
{
    vec3 low = points[first].xyz, high = low;
    square_metres = 0.0;
    for (uint n = 7u; n < count + 7u; n += 8u) {
        vec4 some = points[first + min(n, count - 1u)];
        low  = min(low, some.xyz);
        high = max(high, some.xyz);
        square_metres = max(square_metres, some.w);
    }
    return vec4(0.5 * (low + high), 0.5 * length(high - low) + 2.0 * sqrt(square_metres));
}

void main()
{
    uint  group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, first = group * group_size, at_once = 1u; /* VPLs */
    if (first >= vxs_area_pass.points) return;
    uint  here = min(vxs_area_pass.points - first, group_size);
    float square_metres;
    vec4  ball = ball_about(first, here, square_metres);
    while (at_once < min(vxs_area_pass.vpls, group_size)) at_once *= 2u;
    for (uint vpl = gl_LocalInvocationID.x % at_once; vpl < vxs_area_pass.vpls; vpl += at_once) {
        uint  turn = vxs_area_hash(group * 256u + vpl), drawn = group_size;
        float shown = float(group_size);
        if (vxs_area_pass.is_whole == 0u && here == group_size) {
            shown = count_of(vpl, ball, square_metres);
            drawn = uint(ceil(shown));
            if (shown > 1.0) shown = float(drawn);
            if (shown <= float(turn >> 8) / 16777216.0) drawn = 0u; /* if the map needs less than a point of the group: at random */
        }
        for (uint rank = gl_LocalInvocationID.x / at_once; rank < drawn; rank += group_size / at_once) {
            uint n = first + ((bitfieldReverse(rank) >> 26) + turn) % group_size; /* evenly distributed */
            if (n < first + here) splat(vpl, points[n], normal_of(n, first, here), float(group_size) / shown);
        }
    }
}
