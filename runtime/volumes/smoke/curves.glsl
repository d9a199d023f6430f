/* Words of a map of transmittance curves, in the layout of transmittance_map.c.
 * If there are lists, these are stored after the curves:
 *
 *     a record for each texel   the first segment of its list; of segments for which lists had no room, the least entry, the
 *                               greatest exit, and the product of transmittances
 *     a segment                 entry, exit, transmittance, the next segment */
#include "frame.glsl"

#define VXS_CURVE_SORTED 1u
#define VXS_CURVE_OPAQUE 2u
#define VXS_NO_SEGMENT   0xffffffffu
#ifndef VXS_CURVE_SHAPE /* texels per side, layers, nodes, capacity of the lists; shaders of the caller define it differently */
layout(std140, binding = VXS_AT_CURVES) uniform vxs_curve_block {
    uint capsules, segment_room, flags, side; /* segment_room: capacity of the lists; side: in texels */
    uint layers, nodes, opaque_side;          /* opaque_side: of the map of opaque casters */
    int  lookup;                              /* vxs_curve_lookup */
} vxs_curve_map;
#ifdef VXS_READS_CURVES /* of any map */
#define VXS_CURVE_NODES int(vxs_curve_map.nodes)
#else
#define VXS_CURVE_NODES VXS_CURVE_MOST
#endif
#define VXS_CURVE_SHAPE uvec4(vxs_curve_map.side, vxs_curve_map.layers, uint(VXS_CURVE_NODES), vxs_curve_map.segment_room)
#endif
layout(std430, binding = VXS_AT_GRID) restrict buffer vxs_curves_buffer {
    uint segments, merged, cut, reserved;
    uint words[];
} vxs_curves;

uint vxs_curve_texel(ivec3 texel)
{
    return (uint(texel.z) * VXS_CURVE_SHAPE.x + uint(texel.y)) * VXS_CURVE_SHAPE.x + uint(texel.x);
}

/* Word of a texel's curve, and below of its record, and of a segment. */
uint vxs_curve_words(uint texel)
{
    return texel * 2u * VXS_CURVE_SHAPE.z;
}

uint vxs_curve_record(uint texel)
{
    return vxs_curve_words(VXS_CURVE_SHAPE.x * VXS_CURVE_SHAPE.x * VXS_CURVE_SHAPE.y) + 4u * texel;
}

uint vxs_curve_segment(uint n)
{
    return vxs_curve_record(VXS_CURVE_SHAPE.x * VXS_CURVE_SHAPE.x * VXS_CURVE_SHAPE.y) + 4u * n;
}

#define vxs_curve_number(curves, i) uintBitsToFloat(vxs_curves.words[(curves) + uint(i)])
