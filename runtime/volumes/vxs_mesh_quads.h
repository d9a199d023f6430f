/* The quads of an adaptive mesh around the lit volume of a light: large quads where it is flat. One text for C99, C++ and GLSL.
 * Built on vxs_light_mesh.h.
 *
 *     vxs_mesh_is_off      whether a quad's two triangles are too far from the depths of the map: then it is split
 *     vxs_mesh_balance    splits the neighbours of a split quad where needed
 *     vxs_mesh_is_drawn    whether a quad is a leaf
 *     vxs_mesh_finer       the edges where smaller quads meet it; vxs_mesh_fan_first, vxs_mesh_fan_next: its triangles in that case
 *
 * Each layer of a map is a quadtree, whose root covers the layer. A quad is split if its two triangles are too far from the
 * depth of any vertex in it. It is also split if a neighbour has been split twice, so that neighbours differ by at most one
 * level. Then the larger quad has a vertex in the middle of that edge, which avoids gaps. Quadtrees of a cube's faces meet in
 * its edges in the same way.
 *
 *     +-------+---+---+
 *     |       |   |   |     the left quad is a fan of three triangles around *
 *     |       *---+---+
 *     |       |   |   |
 *     +-------+---+---+
 *
 * A list stores for each quad larger than a texel whether it is split, 0 or 1: by layer, then from coarse to fine levels, then
 * by row.
 *
 * A shader must define, before this text, the functions that C has here: vxs_mesh_first, vxs_mesh_split and vxs_mesh_set_split.
 * `first` and `splits` are passed to them.
 * Source: [Billeter 2010] 4.1 for a restricted quadtree and its fans. There an edge filter chooses the quads to split; here the
 * error decides, and is bounded.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_MESH_QUADS_H
#define VXS_MESH_QUADS_H

#ifndef VXS_LIGHT_MESH_H /* a shader that cannot include has it already */
#include "vxs_light_mesh.h"
#endif

#ifdef VXS_C
typedef struct vxs_mesh_quad vxs_mesh_quad;
#define VXS_MESH_FIRST  const float *
#define VXS_MESH_SPLITS uint8_t *

/* A texel of a shadow depth map: [layers][side][side]. */
VXS_FN vxs_real vxs_mesh_first(VXS_MESH_FIRST first, VXS_MESH shape, const vxs_int3 texel)
{
    return VXS_REAL(first[(texel[2] * shape->side + texel[1]) * shape->side + texel[0]]); /* six layers of 8192: less than 2^31 */
}

VXS_FN vxs_i32 vxs_mesh_split(VXS_MESH_SPLITS splits, vxs_i32 at)
{
    return splits[at];
}

VXS_FN void vxs_mesh_set_split(VXS_MESH_SPLITS splits, vxs_i32 at)
{
    splits[at] = 1;
}
#else
#define VXS_MESH_FIRST  int
#define VXS_MESH_SPLITS int
#endif

/* A quad of 2^level x 2^level texels; x, y count such quads. */
struct vxs_mesh_quad {
    vxs_i32 layer, level, x, y;
};

VXS_FN vxs_mesh_quad vxs_mesh_quad_of(vxs_i32 layer, vxs_i32 level, vxs_i32 x, vxs_i32 y)
{
    vxs_mesh_quad q;
    q.layer = layer;
    q.level = level;
    q.x     = x;
    q.y     = y;
    return q;
}

VXS_FN vxs_mesh_quad vxs_mesh_parent(vxs_mesh_quad q)
{
    return vxs_mesh_quad_of(q.layer, q.level + 1, q.x >> 1, q.y >> 1);
}

/* Number of quads larger than a texel in a layer of 2^levels texels: (4^levels - 1) / 3. */
VXS_FN vxs_i32 vxs_mesh_larger_quads(vxs_i32 levels)
{
    return ((VXS_I(1) << (2 * levels)) - 1) / 3;
}

/* Index of a quad in the list. */
VXS_FN vxs_i32 vxs_mesh_quad_at(VXS_MESH shape, vxs_mesh_quad q)
{
    vxs_i32 levels = VXS_FIELD(shape, levels), halved = levels - q.level;
    return q.layer * vxs_mesh_larger_quads(levels) + vxs_mesh_larger_quads(halved) + (q.y << halved) + q.x;
}

/* The quad of the same size beyond edge `edge`: 0 above, 1 right, 2 below, 3 left. Beyond an edge of a cube it belongs to
 * another face.
 * Returns layer -1 at the border of a light with one map. */
VXS_FN vxs_mesh_quad vxs_mesh_beside(VXS_MESH shape, vxs_mesh_quad q, vxs_i32 edge)
{
    vxs_mesh_quad other = q;
    vxs_i32       last = (VXS_I(1) << (VXS_FIELD(shape, levels) - q.level)) - 1, across = edge & 1;
    vxs_i32       high = edge == 1 || edge == 2 ? 1 : 0, step = high != 0 ? 1 : -1;
    if ((across != 0 ? q.x : q.y) != (high != 0 ? last : 0)) {
        other.x += across != 0 ? step : 0;
        other.y += across != 0 ? 0 : step;
        return other;
    }
    other.layer = -1;
    if (VXS_FIELD(shape, layers) == 1) return other;
    vxs_int3 along; /* the axes of light space */
    along[vxs_ls_axis_from_face(q.layer, 0)] = q.x;
    along[vxs_ls_axis_from_face(q.layer, 1)] = q.y;
    along[q.layer / 2]                       = (q.layer & 1) != 0 ? 0 : last;
    other.layer                              = 2 * vxs_ls_axis_from_face(q.layer, across != 0 ? 0 : 1) + (high != 0 ? 0 : 1);
    other.x                                  = along[vxs_ls_axis_from_face(other.layer, 0)];
    other.y                                  = along[vxs_ls_axis_from_face(other.layer, 1)];
    return other;
}

/* splitting -------------------------------------------------------------------------------------------------------------------- */

VXS_FN vxs_i32 vxs_mesh_has_split(VXS_MESH_SPLITS splits, VXS_MESH shape, vxs_mesh_quad q)
{
    return q.level > 0 ? vxs_mesh_split(splits, vxs_mesh_quad_at(shape, q)) : 0;
}

/* 0: it is part of a larger quad that is not split. */
VXS_FN vxs_i32 vxs_mesh_exists(VXS_MESH_SPLITS splits, VXS_MESH shape, vxs_mesh_quad q)
{
    return q.level == VXS_FIELD(shape, levels) ? 1 : vxs_mesh_has_split(splits, shape, vxs_mesh_parent(q));
}

VXS_FN vxs_i32 vxs_mesh_is_drawn(VXS_MESH_SPLITS splits, VXS_MESH shape, vxs_mesh_quad q)
{
    return vxs_mesh_has_split(splits, shape, q) == 0 ? vxs_mesh_exists(splits, shape, q) : 0;
}

/* Split the larger neighbours of a split quad. Call it for all quads of each level, from level 1 up to below the root: then
 * neighbours differ by at most one level. */
VXS_FN void vxs_mesh_balance(VXS_MESH_SPLITS splits, VXS_MESH shape, vxs_mesh_quad q)
{
    if (vxs_mesh_has_split(splits, shape, q) == 0) return;
    vxs_mesh_set_split(splits, vxs_mesh_quad_at(shape, vxs_mesh_parent(q)));
    for (vxs_i32 edge = 0; edge < 4; edge++) {
        vxs_mesh_quad other = vxs_mesh_beside(shape, q, edge);
        if (other.layer >= 0) vxs_mesh_set_split(splits, vxs_mesh_quad_at(shape, vxs_mesh_parent(other)));
    }
}

/* errors ----------------------------------------------------------------------------------------------------------------------- */

/* The quantity that is linear on a triangle, as a function of the position in the map: a sun's depth, or the inverse of a
 * punctual light's depth. The latter's depths are clamped to at least 1e-6 of `reach`. */
VXS_FN vxs_real vxs_mesh_linear(VXS_MESH_FIRST first, VXS_MESH shape, vxs_i32 layer, vxs_i32 i, vxs_i32 j)
{
    vxs_int3 texel;
    vxs_mesh_texel(shape, vxs_mesh_vertex_of(layer, i, j), texel);
    vxs_real z = vxs_mesh_depth(shape, vxs_mesh_first(first, shape, texel)), nearest = 1e-6 * VXS_FIELD(shape, reach);
    if (VXS_FIELD(shape, is_sun) != 0) return z;
    return 1.0 / (z > nearest ? z : nearest);
}

/* Difference of two such quantities, in widths of a texel at the nearer depth. */
VXS_FN vxs_real vxs_mesh_error(VXS_MESH shape, vxs_real one, vxs_real other)
{
    vxs_real apart = vxs_abs(one - other), less = one < other ? one : other;
    return VXS_FIELD(shape, error_scale) * (VXS_FIELD(shape, is_sun) != 0 ? apart : apart / less);
}

/* Position of vertex i between vertices a and b of a row, [0, 1]; 0 if these coincide. */
VXS_FN vxs_real vxs_mesh_share(VXS_MESH shape, vxs_i32 a, vxs_i32 b, vxs_i32 i)
{
    vxs_real low = vxs_mesh_at(shape, a), high = vxs_mesh_at(shape, b);
    return high > low ? (vxs_mesh_at(shape, i) - low) / (high - low) : VXS_REAL(0.0);
}

/* Whether a vertex of a quad is farther from its two triangles than allowed. It tests the vertices of size x size texels of the
 * quad, from (i0, j0) on.
 * error_texels  in widths of a texel */
VXS_FN vxs_i32 vxs_mesh_is_off(VXS_MESH_FIRST first, VXS_MESH shape, vxs_mesh_quad q, vxs_i32 i0, vxs_i32 j0, vxs_i32 size,
                               vxs_real error_texels)
{
    vxs_i32  a = q.x << q.level, b = (q.x + 1) << q.level, c = q.y << q.level, d = (q.y + 1) << q.level;
    vxs_real ac = VXS_REAL(0.0), bc = ac, ad = ac, bd = ac, t = ac;
    vxs_i32  i = i0, j = j0;
    for (vxs_i32 n = -4; j <= j0 + size; n++) { /* first the quad's corners; in one loop, because the call is inlined */
        vxs_i32  x = n >= 0 ? i : (n & 1) != 0 ? b : a, y = n >= 0 ? j : (n & 2) != 0 ? d : c;
        vxs_real z = vxs_mesh_linear(first, shape, q.layer, x, y);
        if (n < 0) {
            ac = n == -4 ? z : ac;
            bc = n == -3 ? z : bc;
            ad = n == -2 ? z : ad;
            bd = z;
            continue;
        }
        vxs_real s = vxs_mesh_share(shape, a, b, i);
        if (i == i0) t = vxs_mesh_share(shape, c, d, j);
        vxs_real flat_at = s >= t ? (1.0 - s) * ac + (s - t) * bc + t * bd : (1.0 - t) * ac + (t - s) * ad + s * bd;
        if (vxs_mesh_error(shape, flat_at, z) > error_texels) return 1;
        i = i < i0 + size ? i + 1 : i0;
        j = i == i0 ? j + 1 : j;
    }
    return 0;
}

/* triangles -------------------------------------------------------------------------------------------------------------------- */

/* A vertex of the outline of a quad, counterclockwise: 0, 2, 4, 6 are its corners, 1, 3, 5, 7 the middles of edges 0 to 3. */
VXS_FN vxs_mesh_vertex vxs_mesh_outline(vxs_mesh_quad q, vxs_i32 place)
{
    vxs_i32 size = VXS_I(1) << q.level, half_size = size >> 1, x = place & 7, y = (place + 6) & 7;
    return vxs_mesh_vertex_of(q.layer,
                              q.x * size + (x == 1 || x == 5   ? half_size
                                            : x >= 2 && x <= 4 ? size
                                                               : 0),
                              q.y * size + (y == 1 || y == 5   ? half_size
                                            : y >= 2 && y <= 4 ? size
                                                               : 0));
}

/* Bit `edge` of four: the quads beyond it are smaller, and there is a vertex in its middle. Bit 4 + edge: the map ends there. */
VXS_FN vxs_i32 vxs_mesh_finer(VXS_MESH_SPLITS splits, VXS_MESH shape, vxs_mesh_quad q)
{
    vxs_i32 finer = 0;
    for (vxs_i32 edge = 0; edge < 4; edge++) {
        vxs_mesh_quad other = vxs_mesh_beside(shape, q, edge);
        if (other.layer < 0)
            finer |= VXS_I(16) << edge;
        else if (vxs_mesh_has_split(splits, shape, other) != 0)
            finer |= VXS_I(1) << edge;
    }
    return finer;
}

/* The place of the outline that is the centre of a quad's triangle fan: the first middle of an edge, or a corner. */
VXS_FN vxs_i32 vxs_mesh_fan_first(vxs_i32 finer)
{
    for (vxs_i32 edge = 0; edge < 4; edge++)
        if (((finer >> edge) & 1) != 0) return 2 * edge + 1;
    return 0;
}

/* The place after `place`. Triangles are `first`, a place, and the place after it, until that is `first` again. */
VXS_FN vxs_i32 vxs_mesh_fan_next(vxs_i32 finer, vxs_i32 place)
{
    vxs_i32 is_middle = place & 1, has_middle = (finer >> (place >> 1)) & 1;
    return (place + (is_middle != 0 || has_middle != 0 ? 1 : 2)) & 7;
}

#endif
