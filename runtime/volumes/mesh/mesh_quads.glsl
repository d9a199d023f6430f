/* An adaptive mesh while it is built: which quads are split (vxs_mesh_quads.h), and the list of its triangles. */
#include "mesh.glsl"

layout(std430, binding = VXS_AT_GRID) buffer vxs_mesh_split_buffer { uint split[]; } vxs_mesh_tree;

layout(std430, binding = VXS_AT_GRID + 1) buffer vxs_mesh_list_buffer {
    uint corners_drawn, instances, first_corner, first_instance; /* of an indirect draw */
    uint triangles;                                              /* number of triangles of the mesh, even if there is no room */
    uint reserved[3];
    uint corners[]; /* three vertices per triangle (vxs_mesh_code) */
} vxs_mesh_list;

float vxs_mesh_first(int first, vxs_mesh_shape shape, ivec3 texel)
{
    return texelFetch(vxs_map, texel, 0).r;
}

int vxs_mesh_split(int splits, int at)
{
    return int(vxs_mesh_tree.split[at]);
}

void vxs_mesh_set_split(int splits, int at)
{
    vxs_mesh_tree.split[at] = 1u;
}
