/* Vertices of the mesh around the lit volume of a light: from its current map, for all quads or for the listed ones, or from a
 * buffer; see vxs_light_mesh.h. Used by both stages. */
#include "frame.glsl"
#include "vxs_light_mesh.h"

layout(std140, binding = VXS_AT_OWN) uniform vxs_mesh_block {
    mat4  clip_from_ls, eye_from_ls; /* for positions relative to the eye */
    float low, high, texel, turn;    /* turn: 1 or -1, orientation of the lit volume in the view */
    float least, reach, error_scale, error_texels;
    int   first, last, level; /* level: of the quads of an adaptive mesh */
    uint  triangles_most;
    vec3  box_low;
    int   first_place; /* of a mesh made in C: the word of its buffer where positions begin */
    vec3  box_high;
} vxs_mesh_of;

vxs_mesh_shape vxs_frame_mesh()
{
    vxs_mesh_shape shape;
    shape.side        = int(vxs_frame.map_side);
    shape.layers      = int(vxs_frame.map_layers);
    shape.levels      = findMSB(shape.side);
    shape.is_sun      = VXS_KIND(vxs_frame.light) == VXS_LIGHT_KIND_DIRECTIONAL ? 1 : 0;
    shape.low         = vxs_mesh_of.low;
    shape.high        = vxs_mesh_of.high;
    shape.first       = vxs_mesh_of.first;
    shape.last        = vxs_mesh_of.last;
    shape.texel       = vxs_mesh_of.texel;
    shape.least       = vxs_mesh_of.least;
    shape.reach       = vxs_mesh_of.reach;
    shape.error_scale = vxs_mesh_of.error_scale;
    shape.box_low     = vxs_mesh_of.box_low;
    shape.box_high    = vxs_mesh_of.box_high;
    return shape;
}

#ifdef VXS_MESH_LISTED
/* Words of the buffer of mesh_quads.glsl. */
#define VXS_MESH_WANTED 4
#define VXS_MESH_HEAD   8

/* A corner of a triangle in the list, or, if the list did not fit, of all quads. */
vxs_mesh_vertex vxs_frame_corner(vxs_mesh_shape shape, int triangle, int corner)
{
    if (texelFetch(vxs_mesh, VXS_MESH_WANTED).r > vxs_mesh_of.triangles_most) return vxs_mesh_corner(shape, triangle, corner);
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
    int at = vxs_mesh_of.first_place + 3 * int(texelFetch(vxs_mesh, 3 * triangle + corner).r);
    for (int n = 0; n < 3; n++) ls[n] = uintBitsToFloat(texelFetch(vxs_mesh, at + n).r);
#endif
    return ls;
}
