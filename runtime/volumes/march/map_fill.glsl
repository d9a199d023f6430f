/* Looks texels [first, end) of a shadow depth map up in the asset; each takes the baked texel at the middle of those that it
 * covers. */
#include "frame.glsl"
#include "first_depth.glsl"

layout(std140, binding = VXS_AT_OWN) uniform vxs_map_fill_block { uint first, end; } vxs_map_fill;
layout(local_size_x = 64) in;
layout(r32f, binding = VXS_AT_IMAGE) uniform writeonly restrict image2DArray first_depths;

void main()
{
    uint n = vxs_map_fill.first + gl_GlobalInvocationID.x, side = vxs_frame.map_side, layer = n / (side * side);
    if (n >= vxs_map_fill.end || layer >= vxs_frame.map_layers) return;
    ivec2 at = ivec2(n % side, n / side % side);
    int   covers = (1 << vxs_frame.light.levels) / int(side), half_of_it = covers >> 1;
    int   voxel = vxs_first_shadow(vxs_frame.light, int(layer), at.x * covers + half_of_it, at.y * covers + half_of_it);
    imageStore(first_depths, ivec3(at, layer), vec4(vxs_first_depth(vxs_frame.light, voxel), 0.0, 0.0, 0.0));
}
