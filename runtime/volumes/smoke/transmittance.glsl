/* Capsules on light rays, and lookups of curves; after vxs_curve.h. transmittance_light.glsl and area_curves.glsl define the
 * layers and their rays: which texels may see a capsule (vxs_capsule_texels), and the segment of a capsule on a texel's ray
 * (vxs_capsule_segment). */
#include "curves.glsl"
#include "vxs_curve.h"
#include "capsule.glsl"

struct vxs_capsule {
    vec3  begin;
    float radius; /* 0: no capsule */
    vec3  end;
    float extinction;
};

/* Decode a stored capsule; an invalid one is at the origin, with radius 0. */
vxs_capsule vxs_capsule_stored(const vec4 begin, const vec4 end)
{
    bool is_one = begin.w > 0.0 && begin.w < 1e12 && end.w > 0.0 && end.w < 1e30 && dot(begin.xyz, begin.xyz) < 1e24 && dot(end.xyz, end.xyz) < 1e24;
    return vxs_capsule(is_one ? begin.xyz : vec3(0.0), is_one ? begin.w : 0.0, is_one ? end.xyz : vec3(0.0), end.w);
}

/* The segment of a capsule on a ray.
 * way        of length 1;   per_metre  depth per metre of the ray
 * is_half    the ray begins at `begin`;   opaque  the depth where light ends
 * segment    [out] entry and exit depth; transmittance
 * Returns whether they meet */
bool vxs_ray_segment(const vxs_capsule c, const vec3 begin, const vec3 way, const float per_metre, const bool is_half, const float opaque,
                     out vec3 segment)
{
    float near;
    vec2  part = vxs_capsule_part(c.begin - begin, c.end - c.begin, c.radius, way, near);
    segment = vec3(0.0, 0.0, 1.0);
    if (is_half) part.x = max(part.x, -near);
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

/* Transmittance by a texel's curve; other kinds of curves define their own. */
#ifndef vxs_curve_left
#define vxs_curve_left(texel, depth, exponential) vxs_curve_read(vxs_curve_words(texel), 0, VXS_CURVE_NODES, depth, exponential)
#endif

/* At a depth, interpolated between four texels of a layer. Border texels are repeated beyond the border.   place  in texels */
float vxs_curves_left(const vec2 place, const int layer, const float depth, const int exponential)
{
    ivec2 first = ivec2(floor(place - 0.5)), side = ivec2(vxs_curve_map.side);
    vec2  part = place - 0.5 - vec2(first);
    vec4  left;
    for (int n = 0; n < 4; n++) {
        ivec2 texel = clamp(first + ivec2(n & 1, n >> 1), ivec2(0), side - 1);
        left[n] = vxs_curve_left(vxs_curve_texel(ivec3(texel, layer)), depth, exponential);
    }
    return mix(mix(left.x, left.y, part.x), mix(left.z, left.w, part.x), part.y);
}
