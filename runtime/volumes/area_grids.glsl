/* Sets for each light ray of each lamp's grid a bit in the column where shadow begins, by the lamp's imperfect shadow map; a
 * layer of groups for each lamp. counts: lamps, the side of a map, the first word of all maps. */
#include "area_map.glsl"

layout(local_size_x = 32, local_size_y = 4) in;

/* Depth where shadow begins at a point of a map.   at  in texels */
float depth_at(uint lamp, vec2 at, int side)
{
    ivec2 texel = clamp(ivec2(at), ivec2(0), ivec2(side - 1));
    vxs_area_surface s = vxs_area_surface_of(lamp, vxs_area.words[vxs_area_map_word(vxs_frame.counts.z, lamp, side, texel)]);
    if (!(s.depth < VXS_NO_END)) return VXS_NO_END;
    return vxs_area_beside(lamp, s, vxs_area_middle(texel, side), at * (2.0 / float(side)) - 1.0).depth;
}

/* Metres along a light ray; VXS_NO_END: light does not end, or never begins.   from  the lamp, where the ray begins; for a
 * distant lamp any point on the ray */
float shadow_begins(uint lamp, vec3 from, vec3 direction)
{
    int   side = int(vxs_frame.counts.y);
    bool  is_far = vxs_area.lamps[lamp].normal.w == vxs_area_far;
    vec3  way = vxs_area_way(lamp, is_far ? from - vxs_area.lamps[lamp].place.xyz : direction);
    vec2  at = vxs_area_far_texel(lamp, way, side);
    if (is_far) {
        float depth = way.z + vxs_area.lamps[lamp].place.w, ends;
        if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(side)))) return VXS_NO_END;
        ends = depth_at(lamp, at, side);
        return ends < VXS_NO_END ? ends - depth : VXS_NO_END;
    }
    if (!(way.z > 0.0)) return VXS_NO_END;
    vxs_area_texel(way, side, at);
    return depth_at(lamp, at, side);
}

int eye_lit(uint lamp)
{
    vec3  eye = vxs_frame.eye_far.xyz, place = vxs_area.lamps[lamp].place.xyz, way = eye - place;
    float metres = length(way);
    if (vxs_area.lamps[lamp].normal.w == vxs_area_far) return 0.0 < shadow_begins(lamp, eye, vxs_area.lamps[lamp].normal.xyz) ? 1 : 0;
    if (!(metres > vxs_area.lamps[lamp].place.w)) return 2;
    return metres < shadow_begins(lamp, place, way / metres) ? 1 : 0;
}

void main()
{
    int           bit = int(gl_GlobalInvocationID.x), row = int(gl_GlobalInvocationID.y);
    uint          lamp = gl_WorkGroupID.z;
    vxs_epipolar  space = vxs_area_space(lamp);
    vxs_grid_size size = vxs_grid_size(vxs_area.lamps[lamp].size.x, vxs_area.lamps[lamp].size.y, vxs_area.lamps[lamp].size.z);
    if (bit >= size.bits || row >= size.rows) return;
    if (bit == 0 && row == 0) vxs_area.lamps[lamp].eye.x = eye_lit(lamp);
    vec2 turned;
    vec3 begin, direction;
    vxs_grid_light_ray(space, size, row, bit, turned, begin, direction);
    float metres = shadow_begins(lamp, vxs_frame.eye_far.xyz + begin, direction);
    if (!(metres < VXS_NO_END)) return;
    int column = vxs_grid_column(space, size, vxs_epipolar_alpha_at(space, turned, metres));
    if (column < size.columns)
        atomicOr(vxs_area.words[lamp * uint(vxs_grid_words(size)) + uint(vxs_grid_word_of(size, column, row, bit))], 1u << (bit & 31));
}
