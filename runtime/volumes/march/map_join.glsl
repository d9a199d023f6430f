/* Joins moving casters into a shadow depth map: the nearer depth on each light ray. A light ray is one point of a depth map that is
 * seen from the light. The point of the ray at that depth follows from the change of depth along the ray. */
#include "frame.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32f, binding = VXS_AT_IMAGE) uniform restrict image2DArray first_depths;

/* A point of light space, or a vector (one = 0), in metres. */
vec4 from_ls(vec3 ls, float one)
{
    vec3 from = ls - one * vec3(vxs_frame.light.ls_from_ws[0].w, vxs_frame.light.ls_from_ws[1].w, vxs_frame.light.ls_from_ws[2].w);
    return vec4(vxs_ws_coordinate(vxs_frame.light, from, 0), vxs_ws_coordinate(vxs_frame.light, from, 1),
                vxs_ws_coordinate(vxs_frame.light, from, 2), one);
}

void main()
{
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    float side = float(vxs_frame.map_side), baked = float(1u << vxs_frame.light.levels), typical = 0.5 * baked;
    vec3  at = vec3((vec2(texel) + 0.5) * (baked / side), 0.0), begin = at, way = vec3(0.0, 0.0, 1.0);
    if (any(greaterThanEqual(texel.xy, ivec2(side)))) return;
    if (VXS_KIND(vxs_frame.light) != VXS_LIGHT_KIND_DIRECTIONAL) {
        begin = vec3(0.0);
        way   = vec3((at.xy - 0.5 * baked) * vxs_frame.light.texel_metres, 1.0);
        vxs_ls_from_face(vxs_face_of_map(vxs_frame.light, texel.z), way, way);
        typical = 1.0;
    }
    vec4 first = vxs_frame.point_from_depth * from_ls(begin, 1.0), more = vxs_frame.point_from_depth * from_ls(way, 0.0);
    vec4 seen = first + typical * more;
    if (!(seen.w > 0.0)) return; /* behind the light of the depth map */
    vec2  pixel = seen.xy / seen.w * vxs_frame.sizes.xy;
    if (!(all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, vxs_frame.sizes.xy)))) return;
    float depth = texelFetch(vxs_depths, ivec2(pixel), 0).r;
    if (depth == vxs_frame.sizes.z) return;
    float met = (depth * first.w - first.z) / (more.z - depth * more.w);
    if (!(met > 0.0) && VXS_KIND(vxs_frame.light) != VXS_LIGHT_KIND_DIRECTIONAL) return;
    if (!(met < imageLoad(first_depths, texel).r)) return;
    imageStore(first_depths, texel, vec4(met, 0.0, 0.0, 0.0));
}
