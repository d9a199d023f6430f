/* Sets for each light ray of a shadow grid a bit in the column where shadow begins, by the light's map or the asset. The first
 * invocation also tests whether the eye is lit. */
layout(local_size_x = 32, local_size_y = 4) in;

float first_depth(ivec3 texel)
{
#ifdef VXS_ASK_ASSET
    return vxs_first_depth(vxs_frame.light, vxs_first_shadow(vxs_frame.light, texel.z, texel.x, texel.y));
#else
    return texelFetch(vxs_map, texel, 0).r;
#endif
}

/* Metres from the origin of a light ray; VXS_NO_END: light does not end. A ray is a point of the map. */
float shadow_begins(vec3 begin, vec3 direction)
{
    bool  is_sun = vxs_frame.light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    vec3  ls;
    ivec3 texel;
    float depth;
    if (is_sun)
        vxs_ls_from_ws(vxs_frame.light, vxs_frame.eye_far.xyz + begin, 1.0, ls);
    else
        vxs_ls_from_ws(vxs_frame.light, direction, 0.0, ls);
    if (!vxs_map_texel(is_sun ? vec3(ls.xy, 0.0) : ls, texel, depth)) return VXS_NO_END;
    float first = first_depth(texel);
    if (!(first < VXS_NO_END)) return VXS_NO_END;
    return is_sun ? (first - ls.z) * vxs_frame.light.voxel_metres : first / depth;
}

bool eye_lit()
{
    vec3  ls;
    ivec3 texel;
    float depth;
    vxs_ls_from_ws(vxs_frame.light, vxs_frame.eye_far.xyz, 1.0, ls);
    return !vxs_map_texel(ls, texel, depth) || depth < first_depth(texel);
}

void main()
{
    int           bit = int(gl_GlobalInvocationID.x), row = int(gl_GlobalInvocationID.y);
    vxs_epipolar  space = vxs_grid_space();
    vxs_grid_size size = vxs_grid_size(vxs_grid.size.x, vxs_grid.size.y, vxs_grid.size.z);
    if (bit >= size.bits || row >= size.rows) return;
    if (bit == 0 && row == 0 && vxs_grid.eye.x == 1 && !eye_lit()) vxs_grid.eye.x = 0;
    vec2 turned;
    vec3 begin, direction;
    vxs_grid_light_ray(space, size, row, bit, turned, begin, direction);
    float metres = shadow_begins(begin, direction);
    if (!(metres < VXS_NO_END)) return;
    int column = vxs_grid_column(space, size, vxs_epipolar_alpha_at(space, turned, metres));
    if (column < size.columns) atomicOr(vxs_grid.words[vxs_grid_word_of(size, column, row, bit)], 1u << (bit & 31));
}
