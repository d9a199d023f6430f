/* A workgroup for each tile of texels. It marks 64 capsules at a time that may overlap the tile; each texel inserts these, in
 * order. */
#include "transmittance.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly restrict buffer vxs_capsules_buffer { vec4 capsules[]; };
shared vec4 begins[64], ends[64];
shared uint seen[2];

bool in_tile(vxs_capsule c)
{
    ivec4 box;
    ivec2 first = ivec2(gl_WorkGroupID.xy) * 8;
    return vxs_capsule_texels(c, int(gl_GlobalInvocationID.z), box) && all(lessThan(box.xy, first + 8)) && all(greaterThan(box.zw, first));
}

void main()
{
    ivec3     texel = ivec3(gl_GlobalInvocationID);
    uint      own = gl_LocalInvocationIndex, count = vxs_curve_map.capsules;
    bool      is_one = all(lessThan(texel.xy, ivec2(vxs_curve_map.side)));
    float     opaque = is_one ? vxs_opaque_depth(texel) : VXS_NO_END;
    vxs_curve curve = vxs_curve_empty();
    uint      steps = (count + 63u) / 64u, step = 0u, bits = 0u; /* a last step inserts the opaque depth: one call, because it is inlined */
    vxs_curve_insertion pieces = vxs_curve_inserted();
    for (; step <= steps; step++) {
        uint first = 64u * step;
        if (own < 2u) seen[own] = 0u;
        barrier();
        if (first + own < count) {
            vxs_capsule c = vxs_capsule_of(capsules[2u * (first + own)], capsules[2u * (first + own) + 1u], texel.z);
            begins[own] = vec4(c.begin, c.radius);
            ends[own]   = vec4(c.end, c.extinction);
            if (in_tile(c)) atomicOr(seen[own >> 5], 1u << (own & 31u));
        }
        barrier();
        for (uint half_of_them = 0u; half_of_them < 2u; half_of_them++) {
            bits = !is_one ? 0u : step < steps ? seen[half_of_them] : 1u - half_of_them;
            while (bits != 0u || pieces.next <= pieces.last) {
                if (pieces.next > pieces.last) {
                    vec3 segment = vec3(opaque, opaque, 0.0);
                    if (step < steps) {
                        uint        n = 32u * half_of_them + uint(findLSB(bits));
                        vxs_capsule c = vxs_capsule(begins[n].xyz, begins[n].w, ends[n].xyz, ends[n].w);
                        if (!vxs_capsule_segment(c, texel, opaque, segment)) segment.z = 1.0;
                    }
                    pieces = vxs_curve_insertion_of(curve, VXS_CURVE_MOST, segment.x, segment.y, segment.z);
                    bits &= bits - 1u;
                }
                vxs_curve_insert_next(curve, VXS_CURVE_MOST, pieces);
            }
        }
        barrier();
    }
    /* a driver ended the loops */
    if (is_one && (step <= steps || bits != 0u || pieces.next <= pieces.last)) atomicAdd(vxs_curves.cut, 1u);
    if (is_one) vxs_curve_store(vxs_curve_texel(texel), curve);
}
