/* Sets for each light ray of a shadow grid a bit in the column where shadow begins, by the light's map or the asset. The first
 * invocation also tests whether the eye is lit. */
#include "grid.glsl"
#include "vxs_shadow_grid.h"
#include "first_depth.glsl"

layout(local_size_x = 32, local_size_y = 4) in;

#define IS_SUN (VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL)

float first_depth(ivec3 texel)
{
#ifdef VXS_ASK_ASSET
    return vxs_first_depth(vxs_frame.light, vxs_first_shadow(vxs_frame.light, texel.z, texel.x, texel.y));
#else
    return texelFetch(vxs_map, texel, 0).r;
#endif
}

/* A point of the light's map: for the eye its position; for a light ray any of its points, without a depth. */
vec3 point_of_map(bool is_eye, vec3 begin, vec3 direction)
{
    vec3 ls;
    bool is_point = is_eye || IS_SUN;
    vxs_ls_from_ws(vxs_frame.light, is_point ? vxs_frame.eye_far.xyz + (is_eye ? vec3(0.0) : begin) : direction, is_point ? 1.0 : 0.0, ls);
    return ls;
}

void main()
{
    int           bit = int(gl_GlobalInvocationID.x), row = int(gl_GlobalInvocationID.y);
    vxs_epipolar  space = vxs_grid_space();
    vxs_grid_size size = vxs_grid_size(vxs_grid.size.x, vxs_grid.size.y, vxs_grid.size.z);
    if (bit >= size.bits || row >= size.rows) return;
    vec2  turned;
    vec3  begin, direction;
    ivec3 texel;
    float depth, first, metres = VXS_NO_END;
    vxs_grid_light_ray(space, size, row, bit, turned, begin, direction);
    for (int n = bit == 0 && row == 0 && vxs_grid.eye.x == 1 ? 0 : 1; n < 2; n++) { /* the eye, then the ray; one call, which is inlined */
        bool is_eye = n == 0;
        vec3 ls = point_of_map(is_eye, begin, direction);
        if (!vxs_map_texel(IS_SUN && !is_eye ? vec3(ls.xy, 0.0) : ls, texel, depth)) continue;
        first = first_depth(texel);
        if (is_eye && !(depth < first)) vxs_grid.eye.x = 0;
        if (!is_eye && first < VXS_NO_END) metres = IS_SUN ? (first - ls.z) * vxs_frame.light.voxel_metres : first / depth;
    }
    if (!(metres < VXS_NO_END)) return;
    int column = vxs_grid_column(space, size, vxs_epipolar_alpha_at(space, turned, metres));
    if (column < size.columns) atomicOr(vxs_grid.words[vxs_grid_word_of(size, column, row, bit)], 1u << (bit & 31));
}
