/* Appends the triangles of the drawn quads of a level to the list; at level 1 also those of one-texel quads, at the root also
 * those that close the mesh. */
#include "mesh_quads.glsl"
#include "vxs_mesh_quads.h"

layout(local_size_x = 8, local_size_y = 8) in;

#define VXS_QUAD_TRIANGLES 6 /* at most, with walls */
uint found[3 * VXS_QUAD_TRIANGLES];
uint found_count = 0u;

void find_triangle(vxs_mesh_shape shape, vxs_mesh_vertex a, vxs_mesh_vertex b, vxs_mesh_vertex c)
{
    uint codes[3] = uint[3](vxs_mesh_code(vxs_mesh_held(shape, a)), vxs_mesh_code(vxs_mesh_held(shape, b)),
                            vxs_mesh_code(vxs_mesh_held(shape, c)));
    if (codes[0] == codes[1] || codes[1] == codes[2] || codes[2] == codes[0]) return; /* vertices coincide */
    for (uint n = 0u; n < 3u; n++) found[3u * found_count + n] = codes[n];
    found_count++;
}

/* If there is no room for all triangles, all quads are drawn, without the list. */
void list_found(vxs_mesh_shape shape)
{
    if (found_count == 0u) return;
    uint at = atomicAdd(vxs_mesh_list.triangles, found_count), end = at + found_count;
    bool fits = end <= vxs_mesh_of.triangles_most;
    atomicMax(vxs_mesh_list.corners_drawn, 3u * (fits ? end : uint(vxs_mesh_triangles(shape))));
    for (uint n = 0u; n < 3u * found_count && fits; n++) vxs_mesh_list.corners[3u * at + n] = found[n];
    found_count = 0u;
}

/* Add a fan, and walls where the map ends. */
void list_quad(vxs_mesh_shape shape, vxs_mesh_quad q)
{
    int finer = vxs_mesh_finer(0, shape, q), first = vxs_mesh_fan_first(finer), a = vxs_mesh_fan_next(finer, first);
    for (int b = vxs_mesh_fan_next(finer, a); b != first; b = vxs_mesh_fan_next(finer, b)) {
        find_triangle(shape, vxs_mesh_outline(q, first), vxs_mesh_outline(q, a), vxs_mesh_outline(q, b));
        a = b;
    }
    for (int edge = 0; edge < 4; edge++)
        if (vxs_mesh_beside(shape, q, edge).layer < 0)
            find_triangle(shape, vxs_mesh_outline(q, 2 * edge + 2), vxs_mesh_outline(q, 2 * edge), vxs_mesh_vertex_of(-1, edge, 0));
    list_found(shape);
}

void list_closing(vxs_mesh_shape shape)
{
    for (int n = 0; n < vxs_mesh_closing(shape); n++) {
        find_triangle(shape, vxs_mesh_closing_corner(shape, n, 0), vxs_mesh_closing_corner(shape, n, 1),
                      vxs_mesh_closing_corner(shape, n, 2));
        list_found(shape);
    }
}

void main()
{
    vxs_mesh_shape shape = vxs_frame_mesh();
    ivec3          at = ivec3(gl_GlobalInvocationID);
    int            level = vxs_mesh_of.level, count = 0;
    vxs_mesh_quad  q = vxs_mesh_quad_of(at.z, level, at.x, at.y);
    if (any(greaterThanEqual(at.xy, ivec2(shape.side >> level)))) return;
    if (vxs_mesh_is_drawn(0, shape, q) != 0) count = 1;
    if (level == 1 && vxs_mesh_has_split(0, shape, q) != 0) count = 4;
    for (int n = 0; n < count; n++)
        list_quad(shape, count == 1 ? q : vxs_mesh_quad_of(q.layer, 0, 2 * q.x + (n & 1), 2 * q.y + (n >> 1)));
    if (level == shape.levels) list_closing(shape);
}
