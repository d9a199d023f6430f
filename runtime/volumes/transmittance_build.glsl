/* The curve of each texel, of the segments in its list. */
layout(local_size_x = 8, local_size_y = 8) in;

float number_of(uint order)
{
    return uintBitsToFloat((order & 0x80000000u) != 0u ? order & 0x7fffffffu : ~order);
}

vec3 segment_at(uint n)
{
    uint at = vxs_curve_segment(n);
    return vec3(uintBitsToFloat(vxs_curves.words[at]), uintBitsToFloat(vxs_curves.words[at + 1u]), uintBitsToFloat(vxs_curves.words[at + 2u]));
}

/* By entry, then exit, then what is left: an order that does not depend on which was captured first. */
bool is_before(vec3 a, vec3 b)
{
    if (a.x != b.x) return a.x < b.x;
    return a.y != b.y ? a.y < b.y : a.z < b.z;
}

/* Insertion sort: the links of a list, again.   Returns its first segment */
uint sorted(uint list)
{
    uint first = VXS_NO_SEGMENT;
    while (list != VXS_NO_SEGMENT) {
        uint n = list, before = VXS_NO_SEGMENT, behind = first;
        vec3 segment = segment_at(n);
        list = vxs_curves.words[vxs_curve_segment(n) + 3u];
        while (behind != VXS_NO_SEGMENT && is_before(segment_at(behind), segment)) {
            before = behind;
            behind = vxs_curves.words[vxs_curve_segment(behind) + 3u];
        }
        vxs_curves.words[vxs_curve_segment(n) + 3u] = behind;
        if (before == VXS_NO_SEGMENT)
            first = n;
        else
            vxs_curves.words[vxs_curve_segment(before) + 3u] = n;
    }
    return first;
}

void main()
{
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(texel.xy, ivec2(vxs_frame.counts.w)))) return;
    uint      index = vxs_curve_texel(texel), record = vxs_curve_record(index);
    vxs_curve curve = vxs_curve_empty();
    if ((vxs_frame.counts.z & VXS_CURVE_SORTED) != 0u) vxs_curves.words[record] = sorted(vxs_curves.words[record]);
    for (uint n = vxs_curves.words[record]; n != VXS_NO_SEGMENT; n = vxs_curves.words[vxs_curve_segment(n) + 3u]) {
        vec3 segment = segment_at(n);
        vxs_curve_insert(curve, VXS_CURVE_MOST, segment.x, segment.y, segment.z);
    }
    vxs_curve_insert(curve, VXS_CURVE_MOST, number_of(vxs_curves.words[record + 1u]), number_of(vxs_curves.words[record + 2u]),
                     uintBitsToFloat(vxs_curves.words[record + 3u]));
    float opaque = vxs_opaque_depth(texel);
    vxs_curve_insert(curve, VXS_CURVE_MOST, opaque, opaque, 0.0);
    vxs_curve_store(index, curve);
}
