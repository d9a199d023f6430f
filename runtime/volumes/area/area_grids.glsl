/* Sets for each light ray of each VPL's grid a bit in the column where shadow begins, by the VPL's imperfect shadow map; a
 * layer of groups for each VPL. */
#include "area_map.glsl"

layout(local_size_x = 32, local_size_y = 4) in;

/* Depth where shadow begins at a point of a map.   at  in texels */
float depth_at(uint vpl, vec2 at, int side)
{
    ivec2 texel = clamp(ivec2(at), ivec2(0), ivec2(side - 1));
    vxs_area_surface s = vxs_area_surface_of(vpl, vxs_area.words[vxs_area_map_word(vxs_area_pass.first_word, vpl, side, texel)]);
    if (!(s.depth < VXS_NO_END)) return VXS_NO_END;
    return vxs_area_beside(vpl, s, vxs_area_middle(texel, side), at * (2.0 / float(side)) - 1.0).depth;
}

/* Metres along a light ray; VXS_NO_END: light does not end, or never begins.   from  the VPL, where the ray begins; for a
 * distant VPL any point on the ray */
float shadow_begins(uint vpl, vec3 from, vec3 direction)
{
    int   side = int(vxs_area_pass.side);
    bool  is_far = vxs_area_is_far(vpl);
    vec3  way = vxs_area_way(vpl, is_far ? from - vxs_area.vpls[vpl].place.xyz : direction);
    vec2  at = vxs_area_far_texel(vpl, way, side);
    if (is_far ? any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(side))) : !(way.z > 0.0)) return VXS_NO_END;
    if (!is_far) vxs_area_texel(way, side, at);
    float ends = depth_at(vpl, at, side), before = is_far ? way.z + vxs_area.vpls[vpl].place.w : 0.0;
    return ends < VXS_NO_END ? ends - before : VXS_NO_END;
}

void main()
{
    int           bit = int(gl_GlobalInvocationID.x), row = int(gl_GlobalInvocationID.y);
    uint          vpl = gl_WorkGroupID.z;
    vxs_epipolar  space = vxs_area_space(vpl);
    vxs_grid_size size = vxs_grid_size(vxs_area.vpls[vpl].size.x, vxs_area.vpls[vpl].size.y, vxs_area.vpls[vpl].size.z);
    if (bit >= size.bits || row >= size.rows) return;
    vec3  eye = vxs_frame.eye_far.xyz, place = vxs_area.vpls[vpl].place.xyz, begin, direction;
    bool  is_far = vxs_area_is_far(vpl);
    float metres, eye_metres = is_far ? 0.0 : length(eye - place);
    vec2  turned;
    vxs_grid_light_ray(space, size, row, bit, turned, begin, direction);
    /* first, once for each VPL, the light ray to the eye; in one loop, because the call is inlined */
    for (int ray = bit == 0 && row == 0 ? 0 : 1; ray < 2; ray++) {
        bool is_eye = ray == 0;
        vec3 from = is_far ? eye : place, along = is_far ? vxs_area.vpls[vpl].normal.xyz : (eye - place) / eye_metres;
        metres = shadow_begins(vpl, is_eye ? from : eye + begin, is_eye ? along : direction);
        if (is_eye) vxs_area.vpls[vpl].eye.x = !is_far && !(eye_metres > vxs_area.vpls[vpl].place.w) ? 2 : eye_metres < metres ? 1 : 0;
    }
    if (!(metres < VXS_NO_END)) return;
    int column = vxs_grid_column(space, size, vxs_epipolar_alpha_at(space, turned, metres));
    if (column < size.columns)
        atomicOr(vxs_area.words[vpl * uint(vxs_grid_words(size)) + uint(vxs_grid_word_of(size, column, row, bit))], 1u << (bit & 31));
}
