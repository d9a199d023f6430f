/* Capsules as the light rays of a map of transmittance curves meet them, and what the curves say; behind vxs_curve.h. Places are metres along the axes of one
 * of the light's maps: of lamps about the light, of suns from the map's corner. */
struct vxs_capsule {
    vec3  begin;
    float radius; /* 0: there is none */
    vec3  end;
    float extinction;
};

bool vxs_is_sun()
{
    return vxs_frame.light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
}

/* How wide a texel is: of suns in metres, of lamps at one metre along the axis. */
float vxs_curve_texel_size()
{
    return vxs_frame.light.texel_metres * float(1u << vxs_frame.light.levels) / float(vxs_frame.counts.w);
}

vec3 vxs_map_metres(vec3 ls, int layer)
{
    vec3 turned = ls * vec3(vec2(vxs_frame.light.texel_metres), vxs_frame.light.voxel_metres);
    if (!vxs_is_sun()) vxs_face_from_ls(vxs_face_of_map(vxs_frame.light, layer), ls, turned);
    return turned;
}

vxs_capsule vxs_capsule_of(vec4 begin, vec4 end, int layer)
{
    vxs_capsule c;
    vec3        ls;
    bool        is_one = begin.w > 0.0 && begin.w < 1e12 && end.w > 0.0 && end.w < 1e30 && dot(begin.xyz, begin.xyz) < 1e24 && dot(end.xyz, end.xyz) < 1e24;
    vxs_ls_from_ws(vxs_frame.light, is_one ? begin.xyz : vec3(0.0), 1.0, ls);
    c.begin = vxs_map_metres(ls, layer);
    vxs_ls_from_ws(vxs_frame.light, is_one ? end.xyz : vec3(0.0), 1.0, ls);
    c.end        = vxs_map_metres(ls, layer);
    c.radius     = is_one ? begin.w : 0.0;
    c.extinction = end.w;
    return c;
}

/* Between which slopes x / z and y / z a ball before a lamp lies. */
vec4 vxs_ball_slopes(vec3 middle, float radius)
{
    float far = (middle.z - radius) * (middle.z + radius);
    vec2  root = radius * sqrt(middle.xy * middle.xy + far);
    return vec4(middle.xy * middle.z - root, middle.xy * middle.z + root) / far;
}

/* Texels whose rays may meet it.   box  [out] first, end   Returns whether there are any */
bool vxs_capsule_texels(vxs_capsule c, out ivec4 box)
{
    float side = float(vxs_frame.counts.w), middle = vxs_is_sun() ? 0.0 : 0.5 * side;
    vec4  ends = vec4(min(c.begin.xy, c.end.xy) - c.radius, max(c.begin.xy, c.end.xy) + c.radius);
    box = ivec4(0);
    if (!(c.radius > 0.0)) return false;
    if (!vxs_is_sun()) {
        if (max(c.begin.z, c.end.z) + c.radius <= 0.0) return false;
        vec4 first = vxs_ball_slopes(c.begin, c.radius), second = vxs_ball_slopes(c.end, c.radius);
        ends = vec4(min(first.xy, second.xy), max(first.zw, second.zw));
        if (!(min(c.begin.z, c.end.z) > c.radius)) ends = vec4(-1e12, -1e12, 1e12, 1e12);
    }
    ends = ends / vxs_curve_texel_size() + middle;
    box  = ivec4(clamp(vec4(floor(ends.xy - 0.5), ceil(ends.zw + 0.5)), 0.0, side));
    return box.z > box.x && box.w > box.y;
}

/* Metres along the map's axis where what is opaque begins in a texel; VXS_NO_END: nowhere. */
float vxs_opaque_depth(ivec3 texel)
{
    if ((vxs_frame.counts.z & VXS_CURVE_OPAQUE) == 0u) return VXS_NO_END;
    vec2  at = (vec2(texel.xy) + 0.5) * (float(vxs_frame.map.x) / float(vxs_frame.counts.w));
    float first = texelFetch(vxs_map, ivec3(at, texel.z), 0).r;
    if (!(first < VXS_NO_END)) return VXS_NO_END;
    return vxs_is_sun() ? first * vxs_frame.light.voxel_metres : first;
}

/* What a capsule does to the ray of a texel before an opaque depth.
 * segment  [out] entry and exit, depths; what it lets through
 * Returns whether they meet */
bool vxs_capsule_segment(vxs_capsule c, ivec3 texel, float opaque, out vec3 segment)
{
    float size = vxs_curve_texel_size(), side = float(vxs_frame.counts.w), per_metre = 1.0;
    vec3  begin = vec3(0.0), way = vec3(0.0, 0.0, 1.0);
    segment = vec3(0.0, 0.0, 1.0);
    if (vxs_is_sun()) {
        begin = vec3((vec2(texel.xy) + 0.5) * size, 0.0);
    } else {
        way       = vec3((vec2(texel.xy) + 0.5 - 0.5 * side) * size, 1.0);
        per_metre = 1.0 / length(way);
        way *= per_metre;
    }
    float near;
    vec2  part = vxs_capsule_part(c.begin - begin, c.end - c.begin, c.radius, way, near);
    if (!vxs_is_sun()) part.x = max(part.x, -near);
    part.y = min(part.y, opaque / per_metre - near);
    if (!(part.y > part.x)) return false;
    segment = vec3((near + part) * per_metre, exp(-c.extinction * (part.y - part.x)));
    return segment.z < 1.0;
}

void vxs_curve_store(uint texel, vxs_curve curve)
{
    uint at = vxs_curve_words(texel);
    vxs_curve_pad(curve, VXS_CURVE_MOST);
    for (int n = 0; n < VXS_CURVE_MOST; n++) {
        vxs_curves.words[at + uint(2 * n)]     = floatBitsToUint(curve.depth[n]);
        vxs_curves.words[at + uint(2 * n + 1)] = floatBitsToUint(curve.left[n]);
    }
}

/* What a texel's curve says: curves of other kinds say something of their own. */
#ifndef vxs_curve_left
#define vxs_curve_left(texel, depth, exponential) vxs_curve_read(vxs_curve_words(texel), 0, VXS_CURVE_NODES, depth, exponential)
#endif

/* How much light is left at a place: of four texels' curves, weighed. Beyond the map's border its last texels go on, and outside it there is no smoke. */
float vxs_transmittance(vec3 at, int exponential)
{
    vec3  ls;
    ivec2 side = ivec2(vxs_frame.counts.w);
    vxs_ls_from_ws(vxs_frame.light, at, 1.0, ls);
    int  layer = vxs_is_sun() ? 0 : vxs_map_from_ls(vxs_frame.light, ls);
    vec3 place = vxs_map_metres(ls, layer);
    if (!vxs_is_sun()) {
        if (!(place.z > 0.0)) return 1.0;
        place.xy = place.xy / place.z + 0.5 * vxs_curve_texel_size() * vec2(side);
    }
    place.xy /= vxs_curve_texel_size();
    if (!(all(greaterThanEqual(place.xy, vec2(0.0))) && all(lessThan(place.xy, vec2(side))))) return 1.0;
    ivec2 first = ivec2(floor(place.xy - 0.5));
    vec2  part = place.xy - 0.5 - vec2(first);
    vec4  left;
    for (int n = 0; n < 4; n++) {
        ivec2 texel = clamp(first + ivec2(n & 1, n >> 1), ivec2(0), side - 1);
        left[n] = vxs_curve_left(vxs_curve_texel(ivec3(texel, layer)), place.z, exponential);
    }
    return mix(mix(left.x, left.y, part.x), mix(left.z, left.w, part.x), part.y);
}
