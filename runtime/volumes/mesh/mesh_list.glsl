/* Appends the triangles of the drawn quads of a level to the list; at level 1 also those of one-texel quads, at the root also
 * those that close the mesh. */
#include "mesh_quads.glsl"
#include "vxs_mesh_quads.h"

layout(local_size_x = 8, local_size_y = 8) in;

#define VXS_QUAD_TRIANGLES 6 /* at most, with walls */
uint found[3 * VXS_QUAD_TRIANGLES];
uint found_count = 0u;

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

/* The triangles of a drawn quad: a fan, and walls where the map ends; or those that close the mesh. One loop has one call of what
 * finds a vertex, because calls are inlined. */
void list_triangles(vxs_mesh_shape shape, vxs_mesh_quad q, bool is_closing)
{
    int finer = is_closing ? 0 : vxs_mesh_finer(0, shape, q), first = vxs_mesh_fan_first(finer), b = vxs_mesh_fan_next(finer, first);
    int fan = is_closing ? 0 : 2 + bitCount(finer & 15), all = is_closing ? vxs_mesh_closing(shape) : fan + 4;
    for (int n = 0; n < all; n++) {
        int   edge = n - fan;
        bool  is_wall = !is_closing && edge >= 0;
        uvec3 codes;
        ivec3 places = ivec3(first, b, b);
        if (is_wall) places = ivec3(2 * edge + 2, 2 * edge, 0);
        if (!is_wall) places.z = b = vxs_mesh_fan_next(finer, b);
        for (int corner = 0; corner < 3; corner++) {
            vxs_mesh_vertex v = vxs_mesh_vertex_of(-1, edge, 0);
            if (is_closing)
                v = vxs_mesh_closing_corner(shape, n, corner);
            else if (!is_wall || corner < 2)
                v = vxs_mesh_outline(q, places[corner]);
            codes[corner] = vxs_mesh_code(vxs_mesh_held(shape, v));
        }
        bool has_area = codes.x != codes.y && codes.y != codes.z && codes.z != codes.x; /* else vertices coincide */
        if (has_area && (!is_wall || (finer >> (4 + edge) & 1) != 0)) {
            for (int corner = 0; corner < 3; corner++) found[3u * found_count + uint(corner)] = codes[corner];
            found_count++;
        }
        if (n == all - 1 || found_count == uint(VXS_QUAD_TRIANGLES)) list_found(shape);
    }
}

void main()
{
    vxs_mesh_shape shape = vxs_frame_mesh();
    ivec3          at = ivec3(gl_GlobalInvocationID);
    int            level = vxs_mesh_of.level, quads = 0;
    vxs_mesh_quad  q = vxs_mesh_quad_of(at.z, level, at.x, at.y);
    if (any(greaterThanEqual(at.xy, ivec2(shape.side >> level)))) return;
    if (vxs_mesh_is_drawn(0, shape, q) != 0) quads = 1;
    if (level == 1 && vxs_mesh_has_split(0, shape, q) != 0) quads = 4;
    for (int n = 0; n < (level == shape.levels ? quads + 1 : quads); n++)
        list_triangles(shape, quads == 4 ? vxs_mesh_quad_of(q.layer, 0, 2 * q.x + (n & 1), 2 * q.y + (n >> 1)) : q, n == quads);
}
