/* Texels of imperfect shadow maps. If the surface is known, a texel is a small plane, so that the depth between the middles of
 * texels, and in gaps beside them, is that of the surface. Coordinates of a map are from -1 to 1. */
#include "area.glsl"
#include "vxs_area_grid.h"

const float vxs_area_steepest = 8.0;         /* limit of the slopes of a texel */
const uint  vxs_area_none     = 0xffffffffu; /* the word of an empty texel */
const uint  vxs_area_reach    = 7u;          /* the bits of a word for the width of gaps beside it */

struct vxs_area_surface {
    /* where shadow begins, metres from the VPL; for a distant VPL, from the side of the sphere that faces its light */
    float depth;
    vec2  slope; /* change of depth per metre across, along x and y of the map */
    uint  reach; /* number of coarser levels from which gaps beside it may be filled */
    bool  is_plane; /* false: only the depth is known; the object is about as wide as a texel of the coarsest of these levels */
};

/* The middle of a texel in a map of the given side. */
vec2 vxs_area_middle(ivec2 texel, int side)
{
    return (vec2(texel) + 0.5) * (2.0 / float(side)) - 1.0;
}

/* Width of a texel in metres, at the depth where shadow begins. */
float vxs_area_texel_metres(uint vpl, vec2 at, int side, float depth)
{
    if (vxs_area_is_far(vpl)) return 2.0 * vxs_area.vpls[vpl].place.w / float(side);
    return 4.0 * depth / (float(side) * (1.0 + dot(at, at)));
}

/* The point at a depth, in the VPL's frame. */
vec3 vxs_area_place_of(uint vpl, vec2 at, float depth)
{
    float square = dot(at, at), radius = vxs_area.vpls[vpl].place.w;
    if (vxs_area_is_far(vpl)) return vec3(at * radius, depth - radius);
    return vec3(2.0 * at, 1.0 - square) * (depth / (1.0 + square));
}

/* A plane seen at a point of the map: its depth, and its slope.
 * normal, way  normal of the plane, of any length; vector to a point of it; in the VPL's frame
 * Returns a depth of 0 or less if it is not visible. */
vxs_area_surface vxs_area_plane(uint vpl, vec3 normal, vec3 way, vec2 at)
{
    vxs_area_surface found = vxs_area_surface(0.0, vec2(0.0), 0u, true);
    float square = dot(at, at), radius = vxs_area.vpls[vpl].place.w;
    if (vxs_area_is_far(vpl)) {
        if (normal.z == 0.0) return found;
        found.slope = -normal.xy / normal.z;
        found.depth = way.z + dot(found.slope, at * radius - way.xy) + radius;
        return found;
    }
    float height = dot(normal, way), toward = 2.0 * dot(normal.xy, at) + normal.z * (1.0 - square);
    if (!(height * toward > 0.0)) return found;
    found.depth = (1.0 + square) * height / toward;
    found.slope = at - (normal.xy - normal.z * at) * ((1.0 + square) / toward);
    return found;
}

/* The plane of a texel, at another point. For a plane, (1 + x^2 + y^2) / depth is a x + b y + c (1 - x^2 - y^2). Depth and slope
 * give a, b and c. Depths change by at most the steepest slope.
 * at  the middle of the texel */
vxs_area_surface vxs_area_beside(uint vpl, vxs_area_surface s, vec2 at, vec2 other)
{
    if (!s.is_plane) return s;
    if (vxs_area_is_far(vpl)) {
        s.depth += vxs_area.vpls[vpl].place.w * dot(s.slope, other - at);
        return s;
    }
    float square = dot(at, at), there = dot(other, other), wide = 2.0 / (1.0 + square), most = 1.0 + vxs_area_steepest * wide * length(other - at);
    float here = (1.0 + square) / s.depth;
    vec2  change = here * wide * (at - s.slope);
    float c = (here - dot(change, at)) / (1.0 + square);
    vec2  ab = change + 2.0 * c * at;
    float beside = clamp(dot(ab, other) + c * (1.0 - there), here / most, here * most);
    s.depth = (1.0 + there) / beside;
    s.slope = other - (0.5 * ab - c * other) * ((1.0 + there) / beside);
    return s;
}

/* Pack a texel into a word; a nearer texel has a smaller word. 15 bits: a float of the depth in radii of the VPL, which is >=
 * 1. For each slope, the sign and 6 bits of the square root; -0 along x if no plane is known. 3 bits: the reach, at most 6. */
uint vxs_area_word(uint vpl, vxs_area_surface s)
{
    float part = s.depth / vxs_area.vpls[vpl].place.w + (vxs_area_is_far(vpl) ? 1.0 : 0.0);
    uint  depth = (floatBitsToUint(clamp(part, 1.0, 4e9)) - 0x3f800000u + 0x1000u) >> 13;
    uvec2 slope = uvec2(sqrt(min(abs(s.slope) / vxs_area_steepest, 1.0)) * 63.0 + 0.5);
    slope |= uvec2(greaterThan(slope, uvec2(0u))) * uvec2(lessThan(s.slope, vec2(0.0))) << 6;
    if (!s.is_plane) slope = uvec2(64u, 0u);
    return min(depth, 0x7fffu) << 17 | slope.x << 10 | slope.y << 3 | s.reach;
}

/* The inverse of vxs_area_word.   depth  VXS_NO_END: empty */
vxs_area_surface vxs_area_surface_of(uint vpl, uint word)
{
    float part = uintBitsToFloat((word >> 17 << 13) + 0x3f800000u) - (vxs_area_is_far(vpl) ? 1.0 : 0.0);
    uvec2 code = uvec2(word >> 10, word >> 3);
    vec2  root = vec2(code & 63u) / 63.0, slope = root * root * vxs_area_steepest * (1.0 - 2.0 * vec2(code >> 6 & 1u));
    return vxs_area_surface(word == vxs_area_none ? VXS_NO_END : part * vxs_area.vpls[vpl].place.w, slope, word & vxs_area_reach, (code.x & 127u) != 64u);
}

/* The word of a texel of a VPL's map.   maps  the first word of all maps */
uint vxs_area_map_word(uint maps, uint vpl, int side, ivec2 texel)
{
    return vxs_area_level(maps, vpl, uint(side), 0u) + uint(texel.y * side + texel.x);
}
