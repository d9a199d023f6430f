/* Texels of imperfect shadow maps: each is a small plane, where the surface is known, so that what lies between the middles of texels, and in gaps beside them, is
 * as deep as the surface is there. Places of a map reach from -1 to 1 both ways. */
#ifdef VXS_USES_AREA
const float vxs_area_steepest = 8.0;         /* slopes that a texel can have */
const uint  vxs_area_none     = 0xffffffffu; /* the word of a texel in which there is nothing */
const uint  vxs_area_reach    = 7u;          /* the bits of a word that say how wide gaps beside it may be */

struct vxs_area_surface {
    float depth; /* where shadow begins, metres from the lamp; of a lamp that is far away, from the side of the sphere that its light comes from */
    vec2  slope; /* how many metres deeper that is for each metre across, along x and y of the map */
    uint  reach; /* from how many levels coarser gaps beside it may be filled */
    bool  is_plane; /* else the depth alone is known, of something about as wide as a texel of the coarsest of these levels */
};

/* The middle of a texel of a map with so many a side. */
vec2 vxs_area_middle(ivec2 texel, int side)
{
    return (vec2(texel) + 0.5) * (2.0 / float(side)) - 1.0;
}

/* How wide a texel is, in metres, where shadow begins so deep. */
float vxs_area_texel_metres(uint lamp, vec2 at, int side, float depth)
{
    if (vxs_area.lamps[lamp].normal.w == vxs_area_far) return 2.0 * vxs_area.lamps[lamp].place.w / float(side);
    return 4.0 * depth / (float(side) * (1.0 + dot(at, at)));
}

/* Where a depth is, in the lamp's frame. */
vec3 vxs_area_place_of(uint lamp, vec2 at, float depth)
{
    float square = dot(at, at), radius = vxs_area.lamps[lamp].place.w;
    if (vxs_area.lamps[lamp].normal.w == vxs_area_far) return vec3(at * radius, depth - radius);
    return vec3(2.0 * at, 1.0 - square) * (depth / (1.0 + square));
}

/* A plane as it is seen at a place of the map: its depth, and its slope.
 * normal, way  of the plane, of any length; to a place on it; in the lamp's frame
 * Returns a depth of 0 and less where it is not seen. */
vxs_area_surface vxs_area_plane(uint lamp, vec3 normal, vec3 way, vec2 at)
{
    vxs_area_surface found = vxs_area_surface(0.0, vec2(0.0), 0u, true);
    float square = dot(at, at), radius = vxs_area.lamps[lamp].place.w;
    if (vxs_area.lamps[lamp].normal.w == vxs_area_far) {
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

/* The plane of a texel at another place. Of a plane (1 + x^2 + y^2) / depth is a x + b y + c (1 - x^2 - y^2): a, b and c are known by the depth and the slope.
 * Depths change by no more than the steepest slope does.
 * at  the middle of the texel */
vxs_area_surface vxs_area_beside(uint lamp, vxs_area_surface s, vec2 at, vec2 other)
{
    if (!s.is_plane) return s;
    if (vxs_area.lamps[lamp].normal.w == vxs_area_far) {
        s.depth += vxs_area.lamps[lamp].place.w * dot(s.slope, other - at);
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

/* A texel in a word, of which the nearer is the less: 15 bits of a float of the depth in radii of the lamp, which is 1 and more; of each slope its sign and 6 bits
 * of its square root, or -0 along x where no plane is known; 3 bits of the reach, 6 and less. */
uint vxs_area_word(uint lamp, vxs_area_surface s)
{
    float part = s.depth / vxs_area.lamps[lamp].place.w + (vxs_area.lamps[lamp].normal.w == vxs_area_far ? 1.0 : 0.0);
    uint  depth = (floatBitsToUint(clamp(part, 1.0, 4e9)) - 0x3f800000u + 0x1000u) >> 13;
    uvec2 slope = uvec2(sqrt(min(abs(s.slope) / vxs_area_steepest, 1.0)) * 63.0 + 0.5);
    slope |= uvec2(greaterThan(slope, uvec2(0u))) * uvec2(lessThan(s.slope, vec2(0.0))) << 6;
    if (!s.is_plane) slope = uvec2(64u, 0u);
    return min(depth, 0x7fffu) << 17 | slope.x << 10 | slope.y << 3 | s.reach;
}

/* And back.   depth  VXS_NO_END: there is nothing */
vxs_area_surface vxs_area_surface_of(uint lamp, uint word)
{
    float part = uintBitsToFloat((word >> 17 << 13) + 0x3f800000u) - (vxs_area.lamps[lamp].normal.w == vxs_area_far ? 1.0 : 0.0);
    uvec2 code = uvec2(word >> 10, word >> 3);
    vec2  root = vec2(code & 63u) / 63.0, slope = root * root * vxs_area_steepest * (1.0 - 2.0 * vec2(code >> 6 & 1u));
    return vxs_area_surface(word == vxs_area_none ? VXS_NO_END : part * vxs_area.lamps[lamp].place.w, slope, word & vxs_area_reach, (code.x & 127u) != 64u);
}

/* The word of a texel of a lamp's map.   maps  the first word of all maps */
uint vxs_area_map_word(uint maps, uint lamp, int side, ivec2 texel)
{
    return vxs_area_level(maps, lamp, uint(side), 0u) + uint(texel.y * side + texel.x);
}
#endif
