/* Splits the neighbours of a level's split quads, so that neighbours differ by at most one level. */
#include "mesh_quads.glsl"
#include "vxs_mesh_quads.h"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    vxs_mesh_shape shape = vxs_frame_mesh();
    ivec3          at = ivec3(gl_GlobalInvocationID);
    int            level = vxs_mesh_of.level;
    if (any(greaterThanEqual(at.xy, ivec2(shape.side >> level)))) return;
    vxs_mesh_balance(0, shape, vxs_mesh_quad_of(at.z, level, at.x, at.y));
}
