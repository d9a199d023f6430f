/* The light's own maps as layers of curves, instead of area_curves.glsl. Positions are metres along the axes of one of the
 * light's maps: for punctual lights from the light, for suns from the map's corner. */
#include "transmittance.glsl"

bool vxs_is_sun()
{
    return VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL;
}

/* Width of a texel: for suns in metres, for punctual lights at one metre along the axis. */
float vxs_curve_texel_size()
{
    return vxs_frame.light.texel_metres * float(1u << vxs_frame.light.levels) / float(vxs_curve_map.side);
}

vec3 vxs_map_metres(const vec3 ls, const int layer)
{
    vec3 turned = ls * vec3(vec2(vxs_frame.light.texel_metres), vxs_frame.light.voxel_metres);
    if (!vxs_is_sun()) vxs_face_from_ls(vxs_face_of_map(vxs_frame.light, layer), ls, turned);
    return turned;
}

vxs_capsule vxs_capsule_of(const vec4 begin, const vec4 end, const int layer)
{
    vxs_capsule c = vxs_capsule_stored(begin, end);
    for (int n = 0; n < 2; n++) { /* its ends change places twice; one call, because it is inlined */
        vec3 ls;
        vxs_ls_from_ws(vxs_frame.light, c.begin, 1.0, ls);
        c.begin = c.end;
        c.end   = vxs_map_metres(ls, layer);
    }
    return c;
}

/* The range of slopes x / z and y / z of a ball before a punctual light. */
vec4 vxs_ball_slopes(const vec3 middle, const float radius)
{
    float far = (middle.z - radius) * (middle.z + radius);
    vec2  root = radius * sqrt(middle.xy * middle.xy + far);
    return vec4(middle.xy * middle.z - root, middle.xy * middle.z + root) / far;
}

/* Texels of a layer whose rays may meet a capsule.   box  [out] first, end   Returns whether there are any */
bool vxs_capsule_texels(const vxs_capsule c, const int layer, out ivec4 box)
{
    float side = float(vxs_curve_map.side), middle = vxs_is_sun() ? 0.0 : 0.5 * side;
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

/* Metres along the map's axis to where opaque shadow begins in a texel; VXS_NO_END: nowhere. */
float vxs_opaque_depth(const ivec3 texel)
{
    if ((vxs_curve_map.flags & VXS_CURVE_OPAQUE) == 0u) return VXS_NO_END;
    vec2  at = (vec2(texel.xy) + 0.5) * (float(vxs_curve_map.opaque_side) / float(vxs_curve_map.side));
    float first = texelFetch(vxs_map, ivec3(at, texel.z), 0).r;
    if (!(first < VXS_NO_END)) return VXS_NO_END;
    return vxs_is_sun() ? first * vxs_frame.light.voxel_metres : first;
}

/* The segment of a capsule on the ray of a texel, before an opaque depth; as vxs_ray_segment. */
bool vxs_capsule_segment(const vxs_capsule c, const ivec3 texel, const float opaque, out vec3 segment)
{
    float size = vxs_curve_texel_size(), side = float(vxs_curve_map.side);
    vec3  begin = vxs_is_sun() ? vec3((vec2(texel.xy) + 0.5) * size, 0.0) : vec3(0.0), way = vec3(0.0, 0.0, 1.0);
    if (!vxs_is_sun()) way.xy = (vec2(texel.xy) + 0.5 - 0.5 * side) * size;
    float per_metre = vxs_is_sun() ? 1.0 : 1.0 / length(way);
    return vxs_ray_segment(c, begin, way * per_metre, per_metre, !vxs_is_sun(), opaque, segment);
}

/* Transmittance of smoke between the light and a position; 1 outside of the map. */
float vxs_transmittance(const vec3 at)
{
    vec3  ls;
    ivec2 side = ivec2(vxs_curve_map.side);
    vxs_ls_from_ws(vxs_frame.light, at, 1.0, ls);
    int  layer = vxs_is_sun() ? 0 : vxs_map_from_ls(vxs_frame.light, ls);
    vec3 place = vxs_map_metres(ls, layer);
    if (!vxs_is_sun()) {
        if (!(place.z > 0.0)) return 1.0;
        place.xy = place.xy / place.z + 0.5 * vxs_curve_texel_size() * vec2(side);
    }
    place.xy /= vxs_curve_texel_size();
    if (!(all(greaterThanEqual(place.xy, vec2(0.0))) && all(lessThan(place.xy, vec2(side))))) return 1.0;
    return vxs_curves_left(place.xy, layer, place.z, vxs_curve_map.lookup);
}
