/* VPLs of an area light as layers of curves, instead of transmittance_light.glsl: over the half of all directions to which a
 * VPL emits, as in its imperfect shadow map, or over the sphere around all casters. Positions are metres in the VPL's frame,
 * from the VPL or from the middle of the sphere. Depths are metres along a ray from the VPL, or from the plane through the
 * middle of the sphere, across the light. */
#include "area.glsl"
#include "vxs_area_grid.h"
#include "transmittance.glsl"

/* Position in a VPL's layer, in texels.   wide  [out] width of a texel there, in metres */
vec2 vxs_area_place(int vpl, vec3 way, out float wide)
{
    int  side = int(vxs_curve_map.side);
    vec2 at = vxs_area_far_texel(uint(vpl), way, side);
    wide = 2.0 * vxs_area.vpls[vpl].place.w / float(side);
    if (!vxs_area_is_far(vpl)) wide = length(way) * vxs_area_texel(way, side, at);
    return at;
}

/* Widen a capsule to at least a texel, and reduce its density by the increase of its area: so it takes the same light in all, as
 * long as that is little. */
vxs_capsule vxs_capsule_of(vec4 begin, vec4 end, int vpl)
{
    vxs_capsule c = vxs_capsule_stored(begin, end);
    float       wide, size = length(c.end - c.begin);
    c.begin = vxs_area_way(uint(vpl), c.begin - vxs_area.vpls[vpl].place.xyz);
    c.end   = vxs_area_way(uint(vpl), c.end - vxs_area.vpls[vpl].place.xyz);
    vxs_area_place(vpl, 0.5 * (c.begin + c.end), wide);
    if (c.radius > 0.0 && 0.5 * wide > c.radius) {
        float part = c.radius / (0.5 * wide);
        c.extinction *= part * part * (size + 4.0 / 3.0 * c.radius) / (size + 2.0 / 3.0 * wide);
        c.radius = 0.5 * wide;
    }
    return c;
}

/* Texels of a ball around the capsule. A paraboloid shows a ball's outline as a circle. The circle's ends toward the normal and
 * away from it are tangents of half the angles of the ball's outline. */
bool vxs_capsule_texels(vxs_capsule c, int vpl, out ivec4 box)
{
    float side = float(vxs_curve_map.side), wide;
    vec3  middle = 0.5 * (c.begin + c.end);
    float radius = c.radius + 0.5 * length(c.end - c.begin), metres = length(middle), beside = length(middle.xy);
    vec2  at = vxs_area_place(vpl, middle, wide);
    float reach = radius / wide;
    box = ivec4(0);
    if (!(c.radius > 0.0)) return false;
    if (!vxs_area_is_far(vpl)) {
        float from = atan(beside, middle.z), half_wide = metres > radius ? asin(radius / metres) : 4.0;
        vec2  ends = tan(0.5 * vec2(from - half_wide, from + half_wide));
        bool  is_all = !(from + half_wide < 3.1);
        at    = 0.5 * side * (1.0 + (beside > 0.0 ? middle.xy / beside : vec2(0.0)) * (0.5 * (ends.x + ends.y)));
        reach = 0.25 * side * (ends.y - ends.x);
        if (is_all) at = vec2(0.5 * side);
        if (is_all) reach = side;
    }
    box = ivec4(clamp(vec4(floor(at - reach - 0.5), ceil(at + reach + 0.5)), 0.0, side));
    return box.z > box.x && box.w > box.y;
}

/* Opaque casters are in shadow maps, not here. */
float vxs_opaque_depth(ivec3 texel)
{
    return VXS_NO_END;
}

bool vxs_capsule_segment(vxs_capsule c, ivec3 texel, float opaque, out vec3 segment)
{
    vec2  at = (vec2(texel.xy) + 0.5) * (2.0 / float(vxs_curve_map.side)) - 1.0;
    float square = dot(at, at);
    bool  is_far = vxs_area_is_far(texel.z);
    vec3  begin = is_far ? vec3(at * vxs_area.vpls[texel.z].place.w, 0.0) : vec3(0.0);
    vec3  way = is_far ? vec3(0.0, 0.0, 1.0) : vec3(2.0 * at, 1.0 - square) / (1.0 + square);
    return vxs_ray_segment(c, begin, way, 1.0, !is_far, opaque, segment);
}

/* Transmittance of smoke between a VPL and a position, by its curves; 1 outside of its layer. */
float vxs_area_curves_left(uint vpl, vec3 at)
{
    vec3  way = vxs_area_way(vpl, at - vxs_area.vpls[vpl].place.xyz);
    float wide;
    vec2  place = vxs_area_place(int(vpl), way, wide);
    if (!(all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(vxs_curve_map.side))))) return 1.0;
    return vxs_curves_left(place, int(vpl), vxs_area_is_far(vpl) ? way.z : length(way), 0);
}
