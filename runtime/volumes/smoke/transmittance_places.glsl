/* Transmittance between the light and given positions. */
#include "transmittance_light.glsl"

layout(std140, binding = VXS_AT_OWN) uniform vxs_places_block { uint count, first; } vxs_places_of;
layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly restrict buffer vxs_places_buffer { vec4 places[]; };
layout(std430, binding = VXS_AT_GRID + 2) writeonly restrict buffer vxs_left_buffer { float left[]; };

void main()
{
    uint n = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (n < vxs_places_of.count) left[vxs_places_of.first + n] = vxs_transmittance(places[n].xyz);
}
