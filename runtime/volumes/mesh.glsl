/* Vertices of the mesh around the lit volume of a light: from its current map, for all quads or for the listed ones, or from a
 * buffer; see vxs_light_mesh.h. Used by both stages. */
#include "frame.glsl"
#include "vxs_light_mesh.h"

vxs_mesh_shape vxs_frame_mesh()
{
    vxs_mesh_shape shape;
    shape.side        = int(vxs_frame.map.x);
    shape.layers      = int(vxs_frame.map.y);
    shape.levels      = findMSB(shape.side);
    shape.is_sun      = VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL ? 1 : 0;
    shape.low         = vxs_frame.mesh.x;
    shape.high        = vxs_frame.mesh.y;
    shape.first       = int(vxs_frame.map.z);
    shape.last        = int(vxs_frame.map.w);
    shape.texel       = vxs_frame.mesh.z;
    shape.least       = vxs_frame.mesh_depths.x;
    shape.reach       = vxs_frame.mesh_depths.y;
    shape.error_scale = vxs_frame.mesh_depths.z;
    shape.box_low     = vxs_frame.box_low.xyz;
    shape.box_high    = vxs_frame.box_high.xyz;
    return shape;
}

#ifdef VXS_MESH_LISTED
/* Words of the buffer of mesh_quads.glsl. */
#define VXS_MESH_WANTED 4
#define VXS_MESH_HEAD   8

/* A corner of a triangle in the list, or, if the list did not fit, of all quads. */
vxs_mesh_vertex vxs_frame_corner(vxs_mesh_shape shape, int triangle, int corner)
{
    if (texelFetch(vxs_mesh, VXS_MESH_WANTED).r > vxs_frame.counts.y) return vxs_mesh_corner(shape, triangle, corner);
    return vxs_mesh_vertex_from_code(texelFetch(vxs_mesh, VXS_MESH_HEAD + 3 * triangle + corner).r);
}
#else
#define vxs_frame_corner vxs_mesh_corner
#endif

/* A corner, 0 to 2, of a triangle, in light space. */
vec3 vxs_mesh_corner_ls(int triangle, int corner)
{
    vec3 ls;
#ifdef VXS_MESH_OF_MAP
    vxs_mesh_shape  shape = vxs_frame_mesh();
    vxs_mesh_vertex v = vxs_frame_corner(shape, triangle, corner);
    ivec3           texel = ivec3(0);
    float           depth = 0.0;
    if (v.layer >= 0) {
        vxs_mesh_texel(shape, v, texel);
        depth = texelFetch(vxs_map, texel, 0).r;
    }
    vxs_mesh_place(shape, v, depth, ls);
#else
    int at = int(vxs_frame.map.z) + 3 * int(texelFetch(vxs_mesh, 3 * triangle + corner).r);
    for (int n = 0; n < 3; n++) ls[n] = uintBitsToFloat(texelFetch(vxs_mesh, at + n).r);
#endif
    return ls;
}
