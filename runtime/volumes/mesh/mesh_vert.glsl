/* A vertex of the mesh. All vertices have the same depth, so that no near or far plane clips faces: those before and behind
 * these planes count, too. */
#include "mesh.glsl"

#ifndef VXS_MESH_OF_MAP
layout(location = 0) in vec3 place;
#endif

void main()
{
#ifdef VXS_MESH_OF_MAP
    vec3 ls = vxs_mesh_corner_ls(gl_VertexID / 3, gl_VertexID % 3);
#else
    vec3 ls = place;
#endif
    gl_Position = vxs_mesh_of.clip_from_ls * vec4(ls, 1.0);
    gl_Position.z = 0.0;
}
