/* Splits the quads of a level whose triangles have too large errors. An invocation for each 8 x 8 texels of a quad, or for a
 * whole smaller quad. Once one invocation has found an error, the others skip the quad. */
#include "mesh_quads.glsl"
#include "vxs_mesh_quads.h"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    vxs_mesh_shape shape = vxs_frame_mesh();
    int            level = vxs_mesh_of.level, part = min(level, 3), more = level - part;
    ivec3          at = ivec3(gl_GlobalInvocationID);
    vxs_mesh_quad  q = vxs_mesh_quad_of(at.z, level, at.x >> more, at.y >> more);
    if (any(greaterThanEqual(at.xy, ivec2(shape.side >> part)))) return;
    if (vxs_mesh_exists(0, shape, q) == 0 || vxs_mesh_has_split(0, shape, q) != 0) return;
    if (vxs_mesh_is_off(0, shape, q, at.x << part, at.y << part, 1 << part, vxs_mesh_of.error_texels) != 0)
        vxs_mesh_set_split(0, vxs_mesh_quad_at(shape, q));
}
