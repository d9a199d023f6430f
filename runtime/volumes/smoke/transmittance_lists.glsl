/* Lists of segments, of limited capacity; after curves.glsl. Segments without room are merged into the record of their texel. */
#include "curves.glsl"

/* Unsigned integers in the order of the floats. */
uint vxs_ordered(float x)
{
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

/* Add a segment to the list of a texel.   segment  entry and exit depth; transmittance */
void vxs_list_add(ivec3 texel, vec3 segment)
{
    uint record = vxs_curve_record(vxs_curve_texel(texel)), n = atomicAdd(vxs_curves.segments, 1u);
    if (n < VXS_CURVE_SHAPE.w) {
        uint at = vxs_curve_segment(n);
        for (int k = 0; k < 3; k++) vxs_curves.words[at + uint(k)] = floatBitsToUint(segment[k]);
        vxs_curves.words[at + 3u] = atomicExchange(vxs_curves.words[record], n);
        return;
    }
    atomicAdd(vxs_curves.merged, 1u);
    atomicMin(vxs_curves.words[record + 1u], vxs_ordered(segment.x));
    atomicMax(vxs_curves.words[record + 2u], vxs_ordered(segment.y));
    uint was = vxs_curves.words[record + 3u], found = ~was;
    while (found != was) {
        found = was;
        was   = atomicCompSwap(vxs_curves.words[record + 3u], found, floatBitsToUint(uintBitsToFloat(found) * segment.z));
    }
}
