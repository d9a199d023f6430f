/* A workgroup for each capsule: into the list of each texel whose ray it meets. */
layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly restrict buffer vxs_capsules_buffer { vec4 capsules[]; };

/* Integers in the order of the numbers. */
uint ordered(float x)
{
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

void capture(uint record, vec3 segment)
{
    uint n = atomicAdd(vxs_curves.segments, 1u);
    if (n < vxs_frame.counts.y) {
        uint at = vxs_curve_segment(n);
        for (int k = 0; k < 3; k++) vxs_curves.words[at + uint(k)] = floatBitsToUint(segment[k]);
        vxs_curves.words[at + 3u] = atomicExchange(vxs_curves.words[record], n);
        return;
    }
    atomicAdd(vxs_curves.merged, 1u);
    atomicMin(vxs_curves.words[record + 1u], ordered(segment.x));
    atomicMax(vxs_curves.words[record + 2u], ordered(segment.y));
    uint was = vxs_curves.words[record + 3u], found = ~was;
    while (found != was) {
        found = was;
        was   = atomicCompSwap(vxs_curves.words[record + 3u], found, floatBitsToUint(uintBitsToFloat(found) * segment.z));
    }
}

void main()
{
    uint n = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (n >= vxs_frame.counts.x) return;
    for (int layer = 0; layer < int(vxs_frame.map.y); layer++) {
        vxs_capsule c = vxs_capsule_of(capsules[2u * n], capsules[2u * n + 1u], layer);
        ivec4       box;
        if (!vxs_capsule_texels(c, box)) continue;
        int wide = box.z - box.x, count = wide * (box.w - box.y);
        for (int k = int(gl_LocalInvocationID.x); k < count; k += 64) {
            ivec3 texel = ivec3(box.x + k % wide, box.y + k / wide, layer);
            vec3  segment;
            if (vxs_capsule_segment(c, texel, vxs_opaque_depth(texel), segment)) capture(vxs_curve_record(vxs_curve_texel(texel)), segment);
        }
    }
}
