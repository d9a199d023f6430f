/* A vertex of the mesh. Nothing is cut off by a near or a far side: a face before the one or behind the other counts, too, so that all have one depth. */
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
    gl_Position = vxs_frame.clip_from_ls * vec4(ls, 1.0);
    gl_Position.z = 0.0;
}
