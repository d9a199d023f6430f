/* A workgroup for each capsule, layer and part of its texels: appends to the list of each texel whose ray meets the capsule. The
 * parts interleave texels; there are enough parts to keep the loop below the iterations that drivers allow. */
#include "transmittance_lists.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly restrict buffer vxs_capsules_buffer { vec4 capsules[]; };

void main()
{
    uint  n = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    int   layer = int(gl_WorkGroupID.z % vxs_curve_map.layers), part = int(gl_WorkGroupID.z / vxs_curve_map.layers);
    int   parts = int(gl_NumWorkGroups.z / vxs_curve_map.layers);
    ivec4 box;
    if (n >= vxs_curve_map.capsules) return;
    vxs_capsule c = vxs_capsule_of(capsules[2u * n], capsules[2u * n + 1u], layer);
    if (!vxs_capsule_texels(c, layer, box)) return;
    int wide = box.z - box.x, count = wide * (box.w - box.y);
    for (int k = 64 * part + int(gl_LocalInvocationID.x); k < count; k += 64 * parts) {
        ivec3 texel = ivec3(box.x + k % wide, box.y + k / wide, layer);
        vec3  segment;
        if (vxs_capsule_segment(c, texel, vxs_opaque_depth(texel), segment)) vxs_list_add(texel, segment);
    }
}
