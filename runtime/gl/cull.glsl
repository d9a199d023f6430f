/* A work group makes the list of a tile of 8 x 8 pixels: it computes the bounding box of the tile's points, then tests 64 lights
 * at a time against it. Lights keep their order, so that sums over them are the same in each frame. Compiled behind view.glsl. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(std430, binding = VXS_GL_AT_LISTS) writeonly restrict buffer vxs_lists_block { uint vxs_lists[]; };
uniform vxs_filter vxs_widest; /* filter of the lookups */
uniform uvec2 vxs_room; /* tiles in a row, lights in a list */

shared vec3 vxs_low[64], vxs_high[64];
shared uint vxs_met[2];

void main()
{
    uint  self = gl_LocalInvocationIndex, count = 0u;
    uint  tile = 4u + (gl_WorkGroupID.y * vxs_room.x + gl_WorkGroupID.x) * (vxs_room.y + 1u);
    vec3  at;
    bool  is_seen = vxs_pixel_point(ivec2(gl_GlobalInvocationID.xy), at);
    vxs_low[self]  = is_seen ? at : vec3(3e38);
    vxs_high[self] = is_seen ? at : vec3(-3e38);
    if (self < 2u) vxs_met[self] = 0u;
    for (uint span = 32u; span > 0u; span >>= 1) {
        barrier();
        if (self < span) {
            vxs_low[self]  = min(vxs_low[self], vxs_low[self + span]);
            vxs_high[self] = max(vxs_high[self], vxs_high[self + span]);
        }
    }
    barrier();
    vec3 low = vxs_low[0], high = vxs_high[0], middle = 0.5 * (low + high), half_size = high - middle;
    uint lights = low.x <= high.x ? VXS_GL_LIGHT_COUNT : 0u;
    for (uint first = 0u; first < lights; first += 64u) {
        uint n = first + self;
        bool meets = n < lights && vxs_light_meets_box(vxs_light_at(n), middle, half_size, vxs_widest) != 0;
        if (meets) atomicOr(vxs_met[self >> 5], 1u << (self & 31u));
        barrier();
        uint low_bits = vxs_met[0], high_bits = vxs_met[1], before = (1u << (self & 31u)) - 1u;
        uint place = count + uint(self < 32u ? bitCount(low_bits & before) : bitCount(low_bits) + bitCount(high_bits & before));
        if (meets && place < vxs_room.y) vxs_lists[tile + 1u + place] = n;
        count += uint(bitCount(low_bits) + bitCount(high_bits));
        barrier();
        if (self < 2u) vxs_met[self] = 0u;
        barrier();
    }
    if (self == 0u) {
        vxs_lists[tile] = count;
        if (tile == 4u) {
            vxs_lists[0] = vxs_room.x;
            vxs_lists[1] = gl_NumWorkGroups.y;
            vxs_lists[2] = vxs_room.y;
            vxs_lists[3] = VXS_GL_LIGHT_COUNT;
        }
    }
}
