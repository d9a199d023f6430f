/* The frame, and the light whose airlight is added; after vxs_air_path.h. One uniform block, with the fields of struct
 * frame_block in volumes_blocks.h. */
#include "vxs_air_path.h"

layout(std140, binding = VXS_AT_FRAME) uniform vxs_frame_block {
    mat4                point_from_depth;
    vec4                eye_far;        /* origin of eye rays; length of rays that meet nothing, metres */
    vec4                sizes;          /* of the view: width, height; empty depth; height of the fog's top */
    vec4                scattering;     /* and anisotropy */
    vec4                extinction;     /* and 2 */
    vec4                ambient;
    vec4                colour;         /* of the light, and its radius */
    vec4                place;          /* punctual light: position; sun: direction to it; and cosine of the inner cone */
    vec4                axis;           /* direction of a spot light */
    vxs_light_constants light;
    uint                map_side, map_layers; /* of the light's map: texels per side, and layers */
    uvec4               pixels;               /* drawn pixels: the first, and how many across and up */
} vxs_frame;

layout(binding = VXS_AT_DEPTHS) uniform highp sampler2D vxs_depths;
layout(binding = VXS_AT_MAP) uniform highp sampler2DArray vxs_map; /* of the light */
layout(binding = VXS_AT_MESH) uniform highp usamplerBuffer vxs_mesh; /* corners, then positions; or as in mesh_quads.glsl */
layout(binding = VXS_AT_OTHER) uniform highp sampler2D vxs_airlight;

/* Whether a driver has ended the loops of this invocation, so that no further loop iterates more than once: llvmpipe does so
 * after 65535 iterations of all loops. */
bool vxs_is_cut()
{
    int rounds = 0;
    while (rounds < int(vxs_frame.extinction.w)) rounds++;
    return rounds < 2;
}

/* The pixel of an invocation, in groups of 8 x 8.   Returns whether it is drawn */
#ifdef VXS_COMPUTE
bool vxs_pixel(out ivec2 pixel)
{
    pixel = ivec2(gl_GlobalInvocationID.xy + vxs_frame.pixels.xy);
    return all(lessThan(gl_GlobalInvocationID.xy, vxs_frame.pixels.zw));
}
#endif

vxs_medium vxs_frame_medium()
{
    vxs_medium medium;
    medium.scattering = vxs_frame.scattering.xyz;
    medium.extinction = vxs_frame.extinction.xyz;
    medium.anisotropy = vxs_frame.scattering.w;
    return medium;
}

vxs_air_light vxs_frame_light()
{
    vxs_air_light light;
    light.kind          = VXS_KIND(vxs_frame.light);
    light.place         = vxs_frame.place.xyz;
    light.axis          = vxs_frame.axis.xyz;
    light.cos_inner     = vxs_frame.place.w;
    light.cos_outer     = vxs_frame.light.cos_outer;
    light.radius_metres = vxs_frame.colour.w;
    light.range_metres  = vxs_frame.light.range_metres;
    return light;
}

/* Vector from the eye to the point at a pixel's depth. The eye comes from the matrix: the position of a near point has too few
 * digits for a difference. */
vec3 vxs_way_from_depth(const vec2 at, const float depth)
{
    mat4 m     = vxs_frame.point_from_depth;
    vec3 eye   = vxs_frame.eye_far.xyz;
    mat3 way   = mat3(m[0].xyz - eye * m[0].w, m[1].xyz - eye * m[1].w, m[2].xyz - eye * m[2].w);
    vec4 place = vec4(at, depth, 1.0);
    return (way * place.xyz + (m[3].xyz - eye * m[3].w)) / dot(vec4(m[0].w, m[1].w, m[2].w, m[3].w), place);
}

/* The direction of an eye ray, of length 1.   at  of the view, 0 to 1;   metres  [out] to the visible surface, at a depth. Depths that
 * give no finite point end the ray at the far bound. */
vec3 vxs_ray_of_depth(const vec2 at, const float depth, out float metres)
{
    vec3 direction = vec3(0.0, 0.0, -1.0);
    metres         = 0.0;
    for (int n = 0; n < 5; n++) { /* a pixel's direction does not depend on its depth, but some depths give no finite point */
        vec3  way = vxs_way_from_depth(at, n == 0 ? depth : 0.375 + 0.125 * float(n));
        float far = dot(way, way);
        if ((n > 0 || depth != vxs_frame.sizes.z) && far > 0.0 && far < VXS_FAR_MOST * VXS_FAR_MOST) {
            metres    = n > 0 ? vxs_frame.eye_far.w : min(sqrt(far), vxs_frame.eye_far.w);
            direction = way / sqrt(far);
            break;
        }
    }
    return direction;
}

/* The same of a pixel. */
vec3 vxs_eye_ray(ivec2 pixel, out float metres)
{
    return vxs_ray_of_depth((vec2(pixel) + 0.5) / vxs_frame.sizes.xy, texelFetch(vxs_depths, pixel, 0).r, metres);
}

/* The path of the frame's light along an eye ray. */
vxs_air_path vxs_eye_path(vec3 direction, const float metres)
{
    vec2 in_fog;
    return vxs_air_path_of(vxs_frame_light(), vxs_frame.eye_far.xyz, direction, metres, vxs_frame.sizes.w, in_fog);
}

/* Find the texel and depth of a point of light space in its map. Returns false outside of the map, where nothing is in shadow.
 * texel  [out] of the light's map, and its layer
 * depth  [out] distance from the light, along the axis of the map */
bool vxs_map_texel(vec3 ls, out ivec3 texel, out float depth)
{
    float side = float(vxs_frame.map_side);
    vec2  at;
    depth = ls.z;
    texel = ivec3(0);
    if (VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL) {
        float baked = float(1u << vxs_frame.light.levels);
        at = ls.xy * (side / baked);
        if ((vxs_frame.light.flags & VXS_LIGHT_BOUNDED) != 0u && !(depth >= 0.0 && depth < baked)) return false;
    } else {
        vec3 turned;
        texel.z = vxs_map_from_ls(vxs_frame.light, ls);
        vxs_face_from_ls(vxs_face_of_map(vxs_frame.light, texel.z), ls, turned);
        depth = turned.z;
        if (!(depth > 0.0)) return false;
        float baked = float(1u << vxs_frame.light.levels);
        at = 0.5 * side + turned.xy / turned.z * (side / (baked * vxs_frame.light.texel_metres));
    }
    if (!(all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(side))))) return false;
    texel.xy = ivec2(at);
    return true;
}

/* Whether the frame's light reaches a position, by its map. */
bool vxs_map_lit(vec3 at)
{
    vec3  ls;
    ivec3 texel;
    float depth;
    vxs_ls_from_ws(vxs_frame.light, at, 1.0, ls);
    return !vxs_map_texel(ls, texel, depth) || depth < texelFetch(vxs_map, texel, 0).r;
}
