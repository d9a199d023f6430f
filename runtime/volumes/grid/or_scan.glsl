/* An inclusive scan by OR along segments of 128-bit texels. */
#include "frame.glsl"

layout(std140, binding = VXS_AT_OWN) uniform vxs_or_scan_block {
    uint texels, segments, first, step; /* texels of a segment; the first of all; of passes: the distance that is combined */
} vxs_scan;

#ifdef VXS_SCAN_STEPS
/* One of the log2(length) steps; each doubles the number of texels that a texel covers. */
layout(local_size_x = 256) in;
layout(std430, binding = VXS_AT_GRID) readonly buffer vxs_scan_from { uvec4 scanned_before[]; };
layout(std430, binding = VXS_AT_GRID + 1) writeonly buffer vxs_scan_to { uvec4 scanned[]; };

void main()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, n = group * 256u + gl_LocalInvocationID.x;
    if (n >= vxs_scan.texels * vxs_scan.segments) return;
    uvec4 bits = scanned_before[vxs_scan.first + n];
    if (n % vxs_scan.texels >= vxs_scan.step) bits |= scanned_before[vxs_scan.first + n - vxs_scan.step];
    scanned[vxs_scan.first + n] = bits;
}
#else
/* A workgroup for each segment. Each invocation combines adjacent texels; the results are scanned in shared memory; the OR of
 * everything before is then combined with each of its texels. */
layout(local_size_x = 128) in;
layout(std430, binding = VXS_AT_GRID) buffer vxs_scan_in_place { uvec4 scanned[]; };
shared uvec4 parts[2][128];

void main()
{
    uvec4 bits = uvec4(0u);
    uint  segment = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, at = gl_LocalInvocationID.x, which = 0u;
    if (segment >= vxs_scan.segments) return;
    uint each = (vxs_scan.texels + 127u) / 128u, start = vxs_scan.first + segment * vxs_scan.texels;
    uint begin = start + min(at * each, vxs_scan.texels), end = start + min((at + 1u) * each, vxs_scan.texels);
    for (uint n = begin; n < end; n++) bits |= scanned[n];
    parts[0][at] = bits;
    barrier();
    for (uint step = 1u; step < 128u; step *= 2u) {
        if (at >= step) bits |= parts[which][at - step];
        which = 1u - which;
        parts[which][at] = bits;
        barrier();
    }
    bits = at > 0u ? parts[which][at - 1u] : uvec4(0u);
    for (uint n = begin; n < end; n++) {
        bits |= scanned[n];
        scanned[n] = bits;
    }
}
#endif
