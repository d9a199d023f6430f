/* Builds the curve of each texel from the segments in its list. Segments after the first VXS_CURVE_SORTED_MOST are inserted
 * without sorting. So drivers that end loops after 65535 iterations do so after 30000 segments instead of 3500; such texels are
 * counted. */
#include "transmittance.glsl"

#define VXS_CURVE_SORTED_MOST 2048
layout(local_size_x = 8, local_size_y = 8) in;

float number_of(uint order)
{
    return uintBitsToFloat((order & 0x80000000u) != 0u ? order & 0x7fffffffu : ~order);
}

uint first_segment; /* its word, which is computed once, because calls are inlined */

vec3 segment_at(uint n)
{
    uint at = first_segment + 4u * n;
    return vec3(uintBitsToFloat(vxs_curves.words[at]), uintBitsToFloat(vxs_curves.words[at + 1u]), uintBitsToFloat(vxs_curves.words[at + 2u]));
}

/* Order by entry, then exit, then transmittance: it does not depend on the order of capture. */
bool is_before(vec3 a, vec3 b)
{
    if (a.x != b.x) return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

uint next_of(uint n)
{
    return vxs_curves.words[first_segment + 4u * n + 3u];
}

void set_next(uint n, uint next)
{
    vxs_curves.words[first_segment + 4u * n + 3u] = next;
}

/* Merge two sorted lists, neither of which is empty.   Returns the first segment */
uint joined(uint a, uint b)
{
    uint first = VXS_NO_SEGMENT, last = VXS_NO_SEGMENT;
    while (a != VXS_NO_SEGMENT && b != VXS_NO_SEGMENT) {
        bool is_b = is_before(segment_at(b), segment_at(a));
        uint n = is_b ? b : a;
        if (is_b)
            b = next_of(b);
        else
            a = next_of(a);
        if (last == VXS_NO_SEGMENT)
            first = n;
        else
            set_next(last, n);
        last = n;
    }
    set_next(last, a != VXS_NO_SEGMENT ? a : b);
    return first;
}

/* Merge sort of links. List k is empty or has 2^k segments, as bit k of their number.   list  [in, out] what follows the first
 * VXS_CURVE_SORTED_MOST segments */
uint sorted(inout uint list)
{
    uint lists[16], all = VXS_NO_SEGMENT;
    for (int k = 0; k < 16; k++) lists[k] = VXS_NO_SEGMENT;
    for (int n = 0; n < VXS_CURVE_SORTED_MOST && list != VXS_NO_SEGMENT; n++) {
        uint some = list;
        int  k = 0;
        list = next_of(some);
        set_next(some, VXS_NO_SEGMENT);
        for (; lists[k] != VXS_NO_SEGMENT; k++) {
            some     = joined(lists[k], some);
            lists[k] = VXS_NO_SEGMENT;
        }
        lists[k] = some;
    }
    for (int k = 0; k < 16; k++)
        if (lists[k] != VXS_NO_SEGMENT) all = all == VXS_NO_SEGMENT ? lists[k] : joined(lists[k], all);
    return all;
}

/* Cut a segment at an opaque depth, as those of the caller's shaders may continue behind it; its transmittance is that of the
 * part before, as if density was constant. */
vec3 ends_at(float opaque, vec3 segment)
{
    return vec3(segment.x, opaque, pow(segment.z, max(opaque - segment.x, 0.0) / (segment.y - segment.x)));
}

void main()
{
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(texel.xy, ivec2(vxs_curve_map.side)))) return;
    first_segment = vxs_curve_segment(0u);
    uint      index = vxs_curve_texel(texel), record = vxs_curve_record(index);
    vxs_curve curve = vxs_curve_empty();
    uint      n = vxs_curves.words[record], rest = VXS_NO_SEGMENT;
    float     opaque = vxs_opaque_depth(texel);
    if ((vxs_curve_map.flags & VXS_CURVE_SORTED) != 0u) {
        rest = n;
        n    = sorted(rest);
        vxs_curves.words[record] = n;
    }
    vxs_curve_insertion pieces = vxs_curve_inserted();
    /* the list, then `last`: what had no room in it, and the opaque depth; in one loop, because its calls are inlined */
    int last = 0;
    while (last < 2 || pieces.next <= pieces.last) {
        if (pieces.next > pieces.last) {
            vec3 segment = vec3(opaque, opaque, 0.0);
            if (n != VXS_NO_SEGMENT) {
                segment = segment_at(n);
                if (segment.y > opaque) segment = ends_at(opaque, segment);
                if (!(segment.x < opaque)) segment.z = 1.0;
                uint next = next_of(n);
                if (next == VXS_NO_SEGMENT && rest != VXS_NO_SEGMENT) {
                    next = rest;
                    rest = VXS_NO_SEGMENT;
                    set_next(n, next);
                }
                n = next;
            } else if (last++ == 0)
                segment = vec3(number_of(vxs_curves.words[record + 1u]), number_of(vxs_curves.words[record + 2u]),
                               uintBitsToFloat(vxs_curves.words[record + 3u]));
            pieces = vxs_curve_insertion_of(curve, VXS_CURVE_MOST, segment.x, segment.y, segment.z);
        }
        vxs_curve_insert_next(curve, VXS_CURVE_MOST, pieces);
    }
    if (last < 2 || pieces.next <= pieces.last) atomicAdd(vxs_curves.cut, 1u);
    vxs_curve_store(index, curve);
}
