/* A workgroup for each capsule: into the list of each texel whose ray it meets. */
layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly restrict buffer vxs_capsules_buffer { vec4 capsules[]; };

void main()
{
    uint n = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (n >= vxs_frame.counts.x) return;
    for (int layer = 0; layer < int(vxs_frame.map.y); layer++) {
        vxs_capsule c = vxs_capsule_of(capsules[2u * n], capsules[2u * n + 1u], layer);
        ivec4       box;
        if (!vxs_capsule_texels(c, layer, box)) continue;
        int wide = box.z - box.x, count = wide * (box.w - box.y);
        for (int k = int(gl_LocalInvocationID.x); k < count; k += 64) {
            ivec3 texel = ivec3(box.x + k % wide, box.y + k / wide, layer);
            vec3  segment;
            if (vxs_capsule_segment(c, texel, vxs_opaque_depth(texel), segment)) vxs_list_add(texel, segment);
        }
    }
}
