/* Light of a VPL on the visible surface of a pixel: irradiance, times the lit share by its shadow map. The point is compared
 * with the map at the middles of four texels. A texel shadows the surface if its depth there is nearer to the VPL than the
 * surface's plane, and nearer than the point itself. So a plane never shadows itself, in any orientation, and light does not
 * leak under objects that stand on it. */
#include "area_map.glsl"

layout(binding = VXS_AT_OTHER) uniform highp sampler2D vxs_normals;

/* Bias: share of the depth, and of a texel's width. Depths of maps are rounded to 2^-11 of their value. */
const float vxs_area_slack = 0.005, vxs_area_texel_slack = 0.1;

#ifdef VXS_GRID_DIMS
float vxs_area_left(uint vpl, vec3 at)
{
    float left = 1.0;
#ifdef VXS_USES_CURVES
    left = vxs_area_curves_left(vpl, at);
#endif
#ifdef VXS_AREA_BAKED
    float baked = vxs_area.vpls[vpl].colour.w;
    if (baked > 0.0) left *= vxs_smoke_left_by(uint(baked) - 1u, at);
#endif
    return left;
}
#endif

struct vxs_area_pixel {
    vec3       eye, direction, normal; /* normal 0: there is no surface */
    float      metres;
    vxs_medium medium;
};

vxs_area_pixel vxs_area_pixel_of(ivec2 pixel)
{
    vxs_area_pixel p;
    p.eye       = vxs_frame.eye_far.xyz;
    p.direction = vxs_eye_ray(pixel, p.metres);
    p.normal    = texelFetch(vxs_normals, pixel, 0).xyz;
    p.medium    = vxs_frame_medium();
    return p;
}

/* Irradiance of distant light; only fog below a level top dims it, as in vxs_air_path_of. */
vec3 vxs_area_far_irradiance(vxs_area_pixel p, vec3 to_light)
{
    float top = vxs_frame.sizes.w, below = max(top - p.eye.y - p.metres * p.direction.y, 0.0), cosine = max(dot(p.normal, to_light), 0.0);
    if (!(top < VXS_AIR_EVERYWHERE) || below == 0.0) return vec3(cosine);
    return to_light.y > 0.0 ? exp(-p.medium.extinction * (below / to_light.y)) * cosine : vec3(0.0);
}

/* Irradiance of a surface by a VPL, without shadow. */
vec3 vxs_area_irradiance(vxs_area_pixel p, uint n)
{
    if (vxs_area_is_far(n)) return vxs_area_far_irradiance(p, -vxs_area.vpls[n].normal.xyz);
    vec3  to_vpl = vxs_area.vpls[n].place.xyz - p.eye - p.metres * p.direction;
    float square = max(dot(to_vpl, to_vpl), 1e-20), metres = sqrt(square), radius = vxs_area.vpls[n].place.w;
    float cosine = max(dot(p.normal, to_vpl) / metres, 0.0);
    if (vxs_area_emits(n) != 0.0) cosine *= max(-dot(vxs_area.vpls[n].normal.xyz, to_vpl) / metres, 0.0);
    return exp(-p.medium.extinction * metres) * (cosine / max(square, radius * radius));
}

/* The lit share, by the VPL's imperfect shadow map. */
float vxs_area_lit(vxs_area_pixel p, uint n)
{
    int   side = int(vxs_area_pass.side);
    bool  is_far = vxs_area_is_far(n);
    vec3  way = vxs_area_way(n, p.eye + p.metres * p.direction - vxs_area.vpls[n].place.xyz), normal = vxs_area_way(n, p.normal);
    float radius = vxs_area.vpls[n].place.w, depth = is_far ? way.z + radius : length(way), texel = 2.0 * radius / float(side), lit = 0.0;
    vec2  at = vxs_area_far_texel(n, way, side);
    if (!is_far) {
        if (!(depth > radius && way.z > 0.0)) return 1.0;
        texel = depth * vxs_area_texel(way, side, at);
    }
    vec2  from = floor(at - 0.5), part = at - 0.5 - from;
    float slack = vxs_area_slack * depth;
    for (int k = 0; k < 4; k++) {
        ivec2 step = ivec2(k & 1, k >> 1), there = clamp(ivec2(from) + step, ivec2(0), ivec2(side - 1));
        vec2  near = abs(1.0 - vec2(step) - part);
        vxs_area_surface plane = vxs_area_plane(n, normal, way, vxs_area_middle(there, side));
        vxs_area_surface first = vxs_area_surface_of(n, vxs_area.words[vxs_area_map_word(vxs_area_pass.first_word, n, side, there)]);
        float ends = (plane.depth > 0.0 ? min(plane.depth, depth) : depth) - slack;
        ends -= texel * exp2(float(first.reach)) * (first.is_plane ? vxs_area_texel_slack : 0.25 + 0.75 * min(length(plane.slope), 4.0));
        if (!(first.depth < ends)) lit += near.x * near.y;
    }
    return lit;
}

/* The same by its shadow depth map, which is that of the frame; its texels have the nearest depth of all casters in them, rounded
 * toward the VPL to a voxel. */
float vxs_area_lit_exactly(vxs_area_pixel p, uint n)
{
    vec3  ls, from_ls, turned, normal;
    ivec3 texel;
    float side = float(vxs_frame.map_side), texel_wide = float(1u << vxs_frame.light.levels) * vxs_frame.light.texel_metres / side, depth, lit = 0.0;
    vec3  place = p.eye + p.metres * p.direction, to_vpl = vxs_area.vpls[n].place.xyz - place;
    if (dot(to_vpl, to_vpl) <= vxs_area.vpls[n].place.w * vxs_area.vpls[n].place.w) return 1.0;
    vxs_ls_from_ws(vxs_frame.light, place, 1.0, ls);
    vxs_ls_from_ws(vxs_frame.light, p.normal, 0.0, from_ls);
    if (!vxs_map_texel(ls, texel, depth)) return 1.0;
    vxs_face_from_ls(vxs_face_of_map(vxs_frame.light, texel.z), ls, turned);
    vxs_face_from_ls(vxs_face_of_map(vxs_frame.light, texel.z), from_ls, normal);
    vec2  at = turned.xy / (turned.z * texel_wide) + 0.5 * side, from = floor(at - 0.5), part = at - 0.5 - from;
    float height = dot(normal, turned), slack = (vxs_area_slack + 2.0 * vxs_frame.light.voxel_metres) * depth;
    for (int k = 0; k < 4; k++) {
        ivec2 step = ivec2(k & 1, k >> 1), there = clamp(ivec2(from) + step, ivec2(0), ivec2(side) - 1);
        vec2  near = abs(1.0 - vec2(step) - part), middle = (vec2(there) + 0.5 - 0.5 * side) * texel_wide;
        float toward = dot(normal, vec3(middle, 1.0)) - 0.5 * texel_wide * (abs(normal.x) + abs(normal.y));
        float ends = height < 0.0 && toward < 0.0 ? min(height / toward, depth) : depth;
        if (!(texelFetch(vxs_map, ivec3(there, texel.z), 0).r < ends - slack)) lit += near.x * near.y;
    }
    return lit;
}
