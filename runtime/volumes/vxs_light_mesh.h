/* The mesh around the lit volume of a light: the vertices of its triangles, and their positions. One text for C99, C++ and GLSL.
 * Built on vxs_space.h.
 *
 *     vxs_mesh_triangles   number of triangles, with a quad for each texel
 *     vxs_mesh_corner      the vertex at a corner of a triangle
 *     vxs_mesh_texel       the texel of the light's map that gives the depth of a vertex
 *     vxs_mesh_place       the position of a vertex in light space
 *     vxs_mesh_held        the same vertex for all that coincide; vxs_mesh_code: a vertex as a number
 *
 * A shadow depth map stores where shadow begins on the light ray through each texel's middle. A grid of (side + 1) x (side + 1)
 * vertices is displaced to these depths. Inner vertices are on the rays through the middles of texels. Outer vertices are on the
 * border, so that the grid covers the whole map and has a power of two of quads:
 *
 *     0   1   2   3   4     vertices of a map of 4 texels
 *     |---:-|---:-|-:---:|
 *     texel 0  1    2   3
 *
 * The mesh is closed as follows:
 *
 *     spot        four walls of triangles connect the border to the light
 *     six maps    nothing is added. The maps meet in the edges of the cube, inside of their borders. Vertices beyond an edge
 *                 coincide in it. One of the faces that meet there gives the depth of the edge
 *     sun         everything beside the map is lit. So the mesh is the surface of the shadow volume below the grid, with four walls
 *                 and a far side, turned inside out, together with a box around everything
 *
 * Normals point out of the lit volume, if light space is right-handed.
 * Source: [Billeter 2010] 4, [McCool 2000] for the displaced grid; vertices on borders and edges, and those of the sun, are ours.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_LIGHT_MESH_H
#define VXS_LIGHT_MESH_H

#ifndef VXS_SPACE_H /* a shader that cannot include has it already */
#include "vxs_space.h"
#endif

#ifdef VXS_C
typedef struct vxs_mesh_shape  vxs_mesh_shape;
typedef struct vxs_mesh_vertex vxs_mesh_vertex;
#define VXS_MESH const vxs_mesh_shape *
#else
#define VXS_MESH const vxs_mesh_shape
#endif

/* The layout of a light's map, and the limits of its lit volume. */
struct vxs_mesh_shape {
    vxs_i32   side, layers; /* texels per side, a power of two; 1 or 6 */
    vxs_i32   levels;       /* side = 2^levels */
    vxs_i32   is_sun;       /* 0 or 1 */
    vxs_i32   first, last;  /* first and last texel of the grid */
    vxs_real  low, high;    /* ends of the grid, in texels: 0 and side; of six maps, the edges of the cube */
    /* suns: texels of the baked map per texel; punctual lights: metres per texel, at one metre along the axis */
    vxs_real  texel;
    vxs_real  least, reach;      /* depths are clamped to [least, reach]; where light does not end, it ends at reach */
    vxs_real3 box_low, box_high; /* suns: the box around everything, in light space */
    /* texel widths per unit of error: suns: per voxel of depth; punctual lights: per relative error of a depth */
    vxs_real  error_scale;
};

/* A vertex of the grid. If layer is -1, vertex number i outside of the grid: 0 to 3 where walls end, 4 to 11 of the sun's box. */
struct vxs_mesh_vertex {
    vxs_i32 layer, i, j;
};

/* -1, 1: vertex i of a row is at its low or high end; 0: between them. */
VXS_FN vxs_i32 vxs_mesh_end(VXS_MESH shape, vxs_i32 i)
{
    vxs_real middle = VXS_REAL(i) + 0.5;
    if (i == 0 || middle <= VXS_FIELD(shape, low)) return -1;
    return i == VXS_FIELD(shape, side) || middle >= VXS_FIELD(shape, high) ? 1 : 0;
}

/* Position of vertex i of a row, in texels of the map. */
VXS_FN vxs_real vxs_mesh_at(VXS_MESH shape, vxs_i32 i)
{
    vxs_i32 end = vxs_mesh_end(shape, i);
    return end < 0 ? VXS_FIELD(shape, low) : end > 0 ? VXS_FIELD(shape, high) : VXS_REAL(i) + 0.5;
}

VXS_FN vxs_i32 vxs_mesh_texel_of(VXS_MESH shape, vxs_i32 i)
{
    vxs_i32 end = vxs_mesh_end(shape, i);
    return end < 0 ? VXS_FIELD(shape, first) : end > 0 ? VXS_FIELD(shape, last) : i;
}

/* The texel that gives the depth of a vertex of the grid. In an edge of a cube, it belongs to the face with the lower axis.
 * texel  [out] i, j, layer */
VXS_FN void vxs_mesh_texel(VXS_MESH shape, vxs_mesh_vertex v, VXS_OUT vxs_int3 texel)
{
    vxs_i32 across = vxs_mesh_end(shape, v.i), down = vxs_mesh_end(shape, v.j), face = v.layer;
    texel[0] = vxs_mesh_texel_of(shape, v.i);
    texel[1] = vxs_mesh_texel_of(shape, v.j);
    texel[2] = v.layer;
    if (VXS_FIELD(shape, layers) == 1 || (across == 0 && down == 0)) return;
    vxs_int3 end, at; /* along the axes of light space */
    end[vxs_ls_axis_from_face(face, 0)] = across;
    end[vxs_ls_axis_from_face(face, 1)] = down;
    end[face / 2]                       = (face & 1) != 0 ? -1 : 1;
    at[vxs_ls_axis_from_face(face, 0)]  = texel[0];
    at[vxs_ls_axis_from_face(face, 1)]  = texel[1];
    at[face / 2]                        = (face & 1) != 0 ? VXS_FIELD(shape, first) : VXS_FIELD(shape, last);
    vxs_i32 along                       = end[0] != 0 ? 0 : 1;
    texel[2]                            = 2 * along + (end[along] < 0 ? 1 : 0);
    texel[0]                            = at[vxs_ls_axis_from_face(texel[2], 0)];
    texel[1]                            = at[vxs_ls_axis_from_face(texel[2], 1)];
}

/* A depth of the map, clamped to the limits of the mesh; NaN counts as the least. */
VXS_FN vxs_real vxs_mesh_depth(VXS_MESH shape, vxs_real depth)
{
    if (!(depth > VXS_FIELD(shape, least))) return VXS_FIELD(shape, least);
    return depth < VXS_FIELD(shape, reach) ? depth : VXS_FIELD(shape, reach);
}

/* Metres of vertex i across a punctual light's map, at one metre along its axis. Exactly one in the edge of a cube, so that two
 * faces agree. */
VXS_FN vxs_real vxs_mesh_across(VXS_MESH shape, vxs_i32 i)
{
    vxs_i32 end = vxs_mesh_end(shape, i);
    if (VXS_FIELD(shape, layers) != 1 && end != 0) return VXS_REAL(end);
    return (vxs_mesh_at(shape, i) - 0.5 * VXS_REAL(VXS_FIELD(shape, side))) * VXS_FIELD(shape, texel);
}

/* Position of a vertex outside of the grid. */
VXS_FN void vxs_mesh_place_beside(VXS_MESH shape, vxs_i32 n, VXS_OUT vxs_real3 ls)
{
    ls[0] = ls[1] = ls[2] = VXS_REAL(0.0);
    if (VXS_FIELD(shape, is_sun) == 0) return; /* the position of the light */
    if (n < 4) {
        ls[0] = (n == 1 || n == 2 ? VXS_FIELD(shape, high) : VXS_FIELD(shape, low)) * VXS_FIELD(shape, texel);
        ls[1] = (n >= 2 ? VXS_FIELD(shape, high) : VXS_FIELD(shape, low)) * VXS_FIELD(shape, texel);
        ls[2] = VXS_FIELD(shape, reach);
        return;
    }
    for (vxs_i32 axis = 0; axis < 3; axis++)
        ls[axis] = (((n - 4) >> axis) & 1) != 0 ? VXS_FIELD(shape, box_high)[axis] : VXS_FIELD(shape, box_low)[axis];
}

/* Position of a vertex.
 * depth  of texel vxs_mesh_texel of the map; not used for vertices outside of the grid
 * ls     [out] light space */
VXS_FN void vxs_mesh_place(VXS_MESH shape, vxs_mesh_vertex v, vxs_real depth, VXS_OUT vxs_real3 ls)
{
    vxs_real3 turned;
    vxs_real  z = vxs_mesh_depth(shape, depth);
    if (v.layer < 0) {
        vxs_mesh_place_beside(shape, v.i, ls);
        return;
    }
    if (VXS_FIELD(shape, is_sun) != 0) {
        ls[0] = vxs_mesh_at(shape, v.i) * VXS_FIELD(shape, texel);
        ls[1] = vxs_mesh_at(shape, v.j) * VXS_FIELD(shape, texel);
        ls[2] = z;
        return;
    }
    turned[0] = vxs_mesh_across(shape, v.i) * z;
    turned[1] = vxs_mesh_across(shape, v.j) * z;
    turned[2] = z;
    vxs_ls_from_face(VXS_FIELD(shape, layers) == 1 ? 4 : v.layer, turned, ls);
}

/* The same vertex for all vertices of the grid that coincide. Outside of the grid, all vertices of a punctual light are the
 * light itself. */
VXS_FN vxs_mesh_vertex vxs_mesh_held(VXS_MESH shape, vxs_mesh_vertex v)
{
    vxs_i32 across = vxs_mesh_end(shape, v.i), down = vxs_mesh_end(shape, v.j), side = VXS_FIELD(shape, side);
    if (v.layer < 0) {
        if (VXS_FIELD(shape, is_sun) == 0) v.i = 0;
        return v;
    }
    if (across != 0) v.i = across < 0 ? 0 : side;
    if (down != 0) v.j = down < 0 ? 0 : side;
    return v;
}

/* A vertex as a number, and back. */
VXS_FN vxs_u32 vxs_mesh_code(vxs_mesh_vertex v)
{
    return (VXS_U(v.layer + 1) << 28) | (VXS_U(v.j) << 14) | VXS_U(v.i);
}

VXS_FN vxs_mesh_vertex vxs_mesh_vertex_from_code(vxs_u32 code)
{
    vxs_mesh_vertex v;
    v.layer = VXS_I(code >> 28) - 1;
    v.i     = VXS_I(code & 0x3fffu);
    v.j     = VXS_I((code >> 14) & 0x3fffu);
    return v;
}

/* triangles -------------------------------------------------------------------------------------------------------------------- */

#define VXS_MESH_CORNERS_CLOSED 6  /* triangles between the ends of walls; for a spot light they have no area */
#define VXS_MESH_BOX            12 /* triangles of the sun's box */

/* Number of triangles that close a mesh, without its walls. */
VXS_FN vxs_i32 vxs_mesh_closing(VXS_MESH shape)
{
    if (VXS_FIELD(shape, layers) != 1) return 0;
    return VXS_FIELD(shape, is_sun) != 0 ? VXS_MESH_CORNERS_CLOSED + VXS_MESH_BOX : VXS_MESH_CORNERS_CLOSED;
}

VXS_FN vxs_i32 vxs_mesh_triangles(VXS_MESH shape)
{
    vxs_i32 side = VXS_FIELD(shape, side), walls = VXS_FIELD(shape, layers) == 1 ? 4 * side : 0;
    return 2 * side * side * VXS_FIELD(shape, layers) + walls + vxs_mesh_closing(shape);
}

VXS_FN vxs_mesh_vertex vxs_mesh_vertex_of(vxs_i32 layer, vxs_i32 i, vxs_i32 j)
{
    vxs_mesh_vertex v;
    v.layer = layer;
    v.i     = i;
    v.j     = j;
    return v;
}

/* Vertex n of the border of a single map, from (0, 0) on along j = 0. */
VXS_FN vxs_mesh_vertex vxs_mesh_border(VXS_MESH shape, vxs_i32 n)
{
    vxs_i32 side = VXS_FIELD(shape, side), wall = (n / side) & 3, way = n % side;
    if (wall == 0) return vxs_mesh_vertex_of(0, way, 0);
    if (wall == 1) return vxs_mesh_vertex_of(0, side, way);
    if (wall == 2) return vxs_mesh_vertex_of(0, side - way, side);
    return vxs_mesh_vertex_of(0, 0, side - way);
}

/* Corner 0 to 2 of triangle n of those that close a mesh, without its walls: at the ends of walls, the far side, the box. */
VXS_FN vxs_mesh_vertex vxs_mesh_closing_corner(VXS_MESH shape, vxs_i32 n, vxs_i32 corner)
{
    if (n < 4) {
        if (corner == 0) return vxs_mesh_border(shape, (n + 1) * VXS_FIELD(shape, side));
        return vxs_mesh_vertex_of(-1, corner == 1 ? n : (n + 1) & 3, 0);
    }
    if (n < VXS_MESH_CORNERS_CLOSED) return vxs_mesh_vertex_of(-1, corner == 0 ? 0 : 8 - n - corner, 0);
    n -= VXS_MESH_CORNERS_CLOSED;
    vxs_i32 axis = n / 4, high = (n / 2) & 1, quad = corner == 0 ? 0 : corner + (n & 1);
    vxs_i32 one = quad == 1 || quad == 2 ? 1 : 0, other = quad >= 2 ? 1 : 0; /* counterclockwise as seen from outside */
    vxs_i32 next = (axis + 1) % 3, after = (axis + 2) % 3;
    return vxs_mesh_vertex_of(-1, 4 + (high << axis) + ((high != 0 ? one : other) << next) + ((high != 0 ? other : one) << after),
                              0);
}

/* Corner 0 to 2 of triangle n, [0, vxs_mesh_triangles): first of quads, then of walls, then of the other closing triangles. */
VXS_FN vxs_mesh_vertex vxs_mesh_corner(VXS_MESH shape, vxs_i32 n, vxs_i32 corner)
{
    vxs_i32 side = VXS_FIELD(shape, side), quads = side * side * VXS_FIELD(shape, layers);
    if (n < 2 * quads) {
        vxs_i32 quad = n / 2, at = corner == 0 ? 0 : corner + (n & 1); /* in turn 0, 1, 2 and 0, 2, 3 of its corners */
        vxs_i32 i = quad % side, j = quad / side % side;
        return vxs_mesh_vertex_of(quad / (side * side), at == 1 || at == 2 ? i + 1 : i, at >= 2 ? j + 1 : j);
    }
    n -= 2 * quads;
    if (n >= 4 * side) return vxs_mesh_closing_corner(shape, n - 4 * side, corner);
    if (corner == 2) return vxs_mesh_vertex_of(-1, n / side, 0);
    return vxs_mesh_border(shape, n + 1 - corner);
}

#endif
