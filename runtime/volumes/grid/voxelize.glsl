/* Voxelizes triangles into a shadow grid, before its scan. All eye rays and light rays of a row are in one half plane that
 * begins at the axis. It cuts a triangle in a segment. Along the segment, phi and alpha only increase or only decrease, so that
 * each ray meets it at most once. So there are no seams, no poles and no edges that are curved in angles.
 *
 *     across                 VXS_VOXELS_RAYS     light rays through the middles of voxels: a bit in the column where shadow begins
 *       |       q            VXS_VOXELS_SOLID    eye rays through the middles: flips all bits before the segment; a bit stays
 *       |     /                                  flipped if an odd number of segments is behind it [Eisemann 2008]
 *       |   p                VXS_VOXELS_COVERED  all light rays of a voxel whose wedge the triangle touches: a bit where it is
 *       *----------*--> along                    nearest to the light; the scan sets the rest [Schwarz 2010]
 *      eye       light
 *
 * A group processes 64 triangles and shares the rows of all of them; groups with different y process these rows in turn. */
#include "grid.glsl"
#include "vxs_shadow_grid.h"

layout(std140, binding = VXS_AT_OWN) uniform vxs_voxelize_block {
    mat4 axes_from_place; /* from positions of casters to coordinates along the axis, `ahead` and `side` */
    uint triangles, first_word, place_words, is_indexed;
    uint first_triangle;
    int  columns;
} vxs_voxels;
layout(local_size_x = 64) in;
layout(std430, binding = VXS_AT_GRID + 1) readonly buffer vxs_places_block { float vxs_places[]; };
layout(std430, binding = VXS_AT_GRID + 2) readonly buffer vxs_corners_block { uint vxs_corners[]; };
shared vec3 corners[3 * 64];
shared int  first_rows[64];
shared uint ends[64]; /* running sum of the number of rows of each triangle */

/* Coordinates along the axis, `ahead` and `side`. Returns whether the position is valid. */
bool read_corner(uint corner, out vec3 place)
{
    uint words = uint(vxs_places.length()), n = corner;
    place = vec3(0.0);
    if (vxs_voxels.is_indexed != 0u) {
        if (corner >= uint(vxs_corners.length())) return false;
        n = vxs_corners[corner];
    }
    if (words < vxs_voxels.first_word + 3u || n > (words - vxs_voxels.first_word - 3u) / vxs_voxels.place_words) return false;
    uint word = vxs_voxels.first_word + n * vxs_voxels.place_words;
    place = (vxs_voxels.axes_from_place * vec4(vxs_places[word], vxs_places[word + 1u], vxs_places[word + 2u], 1.0)).xyz;
    return all(lessThan(abs(place), vec3(VXS_FAR_MOST)));
}

float theta_of(vec3 place)
{
    float turn = vxs_epipolar_angle(abs(place.z), place.y);
    return place.z < 0.0 ? -turn : turn;
}

/* The rows that a triangle may touch: the first, and how many, which may wrap around the seam. All rows if the triangle contains
 * the axis, or nearly. */
ivec2 rows_of(vxs_epipolar space, vxs_grid_size size, vec3 triangle[3])
{
    const float spare = 0.01;
    float first = 0.0, low = 0.0, high = 0.0;
    for (int n = 0; n < 3; n++) {
        float theta = theta_of(triangle[n]), turn = n == 0 ? 0.0 : theta - first;
        if (n == 0) first = theta;
        turn = abs(turn) > VXS_AIR_PI ? turn - sign(turn) * 2.0 * VXS_AIR_PI : turn;
        low = min(low, turn);
        high = max(high, turn);
    }
    if (!(high - low < VXS_AIR_PI - 1e-3)) return ivec2(0, size.rows);
    float wide = space.theta.y - space.theta.x, away = first + 0.5 * (low + high) - 0.5 * (space.theta.x + space.theta.y);
    away -= 2.0 * VXS_AIR_PI * round(away / (2.0 * VXS_AIR_PI));
    float rows = float(size.rows), middle = (0.5 + away / wide) * rows, half_rows = 0.5 * (high - low) / wide * rows + spare;
#ifdef VXS_VOXELS_COVERED
    vec2 found = floor(vec2(middle - half_rows, middle + half_rows + 1.0));
#else
    vec2 found = ceil(vec2(middle - half_rows, middle + half_rows) - 0.5);
#endif
    int begin = int(clamp(found.x, -rows, 2.0 * rows)), end = int(clamp(found.y, -rows, 2.0 * rows));
    if (wide < 2.0 * VXS_AIR_PI - 1e-3) {
        begin = max(begin, 0);
        end = min(end, size.rows);
    } else if (end - begin >= size.rows)
        return ivec2(0, size.rows);
    return ivec2(begin, max(end - begin, 0));
}

/* The eye is in shadow if a triangle meets the axis between the eye and the light. */
void darken_eye(vec3 a, vec3 b, vec3 c)
{
    vec3  sides = vec3(b.y * c.z - b.z * c.y, c.y * a.z - c.z * a.y, a.y * b.z - a.z * b.y);
    float all_sides = sides.x + sides.y + sides.z, along = dot(sides, vec3(a.x, b.x, c.x)) / all_sides;
    if (!(all(greaterThanEqual(sides * sign(all_sides), vec3(0.0))) && along > 0.0)) return;
    if ((vxs_grid.axis.w == 0.0 || along < vxs_grid.axis.w) && vxs_grid.eye.x == 1) vxs_grid.eye.x = 0;
}

/* The zero of a segment with these signed distances at its ends. */
vec2 between(vec2 p, vec2 q, float at_p, float at_q)
{
    float apart = at_p - at_q;
    return apart == 0.0 ? p : mix(p, q, clamp(at_p / apart, 0.0, 1.0));
}

/* Signed distance of a point (along, across) from a light ray; positive on the side of the axis.   turned  vxs_epipolar_turn_of
 * phi */
float before_light_ray(vxs_epipolar space, vec2 turned, vec2 place)
{
    return space.away > 0.0 ? turned.x * (space.away - place.x) - turned.y * place.y : turned.x - place.y;
}

/* Number of bits, and below of columns, before a point. */
float bits_before(vxs_epipolar space, vxs_grid_size size, vec2 place)
{
    float phi = space.away > 0.0 ? vxs_epipolar_angle(place.y, space.away - place.x) : place.y;
    return vxs_grid_before(space.phi, phi, size.bits);
}

float columns_before(vxs_epipolar space, vxs_grid_size size, vec2 place)
{
    return vxs_grid_before(space.alpha, vxs_epipolar_angle(place.y, place.x), size.columns);
}

/* The voxels whose middles are between two such numbers: the first, and the end. */
ivec2 middles_between(float a, float b, int count)
{
    return ivec2(clamp(ceil(vec2(min(a, b), max(a, b)) - 0.5), 0.0, float(count)));
}

/* Unit vector across the axis at theta, in `ahead` and `side`. */
vec2 way_at(float theta)
{
    vec2 turned;
    vxs_epipolar_turn(min(abs(theta), VXS_AIR_PI), turned);
    return vec2(turned.y, theta < 0.0 ? -turned.x : turned.x);
}

void set_bit(vxs_grid_size size, int column, int row, int bit)
{
    atomicOr(vxs_grid.words[vxs_grid_word_of(size, column, row, bit)], 1u << (bit & 31));
}

#ifndef VXS_VOXELS_COVERED
/* The segment in which the half plane of a row cuts a triangle.   way  across the axis, in `ahead` and `side`;   Returns whether
 * it cuts */
bool cut(vec3 triangle[3], vec2 way, out vec2 p, out vec2 q)
{
    vec2 found[2] = vec2[2](vec2(0.0), vec2(0.0));
    int  count = 0;
    for (int n = 0; n < 3; n++) {
        vec3  a = triangle[n], b = triangle[(n + 1) % 3];
        float at_a = way.x * a.z - way.y * a.y, at_b = way.x * b.z - way.y * b.y;
        if ((at_a < 0.0) == (at_b < 0.0)) continue;
        if (at_a < 0.0) { /* both triangles of an edge compute the same point */
            vec4 swapped = vec4(a, at_a);
            a = b;
            at_a = at_b;
            b = swapped.xyz;
            at_b = swapped.w;
        }
        vec2 from = vec2(a.x, dot(way, a.yz)), to = vec2(b.x, dot(way, b.yz));
        found[count++] = between(from, to, at_a, at_b);
    }
    p = found[0];
    q = found[1];
    if (count < 2 || max(p.y, q.y) <= 0.0) return false;
    vec2 on_axis = vec2(between(p, q, p.y, q.y).x, 0.0);
    if (p.y < 0.0) p = on_axis;
    if (q.y < 0.0) q = on_axis;
    return true;
}
#endif

#ifdef VXS_VOXELS_RAYS
/* Shadow that begins behind the columns is left out. */
void voxelize(vxs_epipolar space, vxs_grid_size size, int row, vec3 triangle[3])
{
    vec2 p, q;
    if (!cut(triangle, way_at(vxs_grid_middle(space.theta, row, size.rows)), p, q)) return;
    float columns = min(columns_before(space, size, p), columns_before(space, size, q));
    ivec2 bits = middles_between(bits_before(space, size, p), bits_before(space, size, q), size.bits);
    int   columns_end = vxs_voxels.columns;
    if (columns > float(columns_end)) return;
    for (int bit = bits.x; bit < bits.y; bit++) {
        vec2 turned;
        vxs_epipolar_turn_of(space, vxs_grid_middle(space.phi, bit, size.bits), turned);
        vec2 met = between(p, q, before_light_ray(space, turned, p), before_light_ray(space, turned, q));
        int  column = vxs_grid_column(space, size, vxs_epipolar_angle(met.y, met.x));
        if (column < columns_end) set_bit(size, column, row, bit);
    }
}
#endif

#ifdef VXS_VOXELS_SOLID
void voxelize(vxs_epipolar space, vxs_grid_size size, int row, vec3 triangle[3])
{
    vec2 p, q, turned;
    if (!cut(triangle, way_at(vxs_grid_middle(space.theta, row, size.rows)), p, q)) return;
    ivec2 columns = middles_between(columns_before(space, size, p), columns_before(space, size, q), size.columns);
    for (int column = columns.x; column < columns.y; column++) {
        vxs_epipolar_turn(vxs_grid_middle(space.alpha, column, size.columns), turned);
        vec2 met = between(p, q, turned.x * p.x - turned.y * p.y, turned.x * q.x - turned.y * q.y);
        int  end = int(clamp(ceil(bits_before(space, size, met) - 0.5), 0.0, float(size.bits)));
        for (int bit = 0; bit < end; bit += 32) {
            uint mask = end - bit < 32 ? ~(0xffffffffu << (end - bit)) : 0xffffffffu;
            atomicXor(vxs_grid.words[vxs_grid_word_of(size, column, row, bit)], mask);
        }
    }
}
#endif

#ifdef VXS_VOXELS_COVERED
/* A convex polygon: a triangle cut by planes through the axis. */
struct polygon {
    vec3 at[5];
    int  count;
};

/* Clip a polygon to one side of such a plane. It can have five corners; further corners, which only rounding can add, are
 * dropped.   normal  across the axis */
void clip(inout polygon of, vec2 normal)
{
    polygon part;
    part.count = 0;
    for (int n = 0; n < of.count; n++) {
        vec3  a = of.at[n], b = of.at[(n + 1) % of.count];
        float at_a = dot(normal, a.yz), at_b = dot(normal, b.yz);
        if (at_a >= 0.0 && part.count < 5) part.at[part.count++] = a;
        if ((at_a >= 0.0) != (at_b >= 0.0) && part.count < 5) part.at[part.count++] = mix(a, b, clamp(at_a / (at_a - at_b), 0.0, 1.0));
    }
    of = part;
}

/* The smallest alpha of a segment's part between two light rays; 4: there is no such part. */
float least_alpha(vxs_epipolar space, vec2 near_ray, vec2 far_ray, vec2 p, vec2 q)
{
    float begin = 0.0, end = 1.0;
    for (int n = 0; n < 2; n++) { /* negative: outside */
        float at_p = n == 0 ? -before_light_ray(space, near_ray, p) : before_light_ray(space, far_ray, p);
        float at_q = n == 0 ? -before_light_ray(space, near_ray, q) : before_light_ray(space, far_ray, q);
        if (max(at_p, at_q) < 0.0) return 4.0;
        if (at_p < 0.0) begin = max(begin, at_p / (at_p - at_q));
        if (at_q < 0.0) end = min(end, at_p / (at_p - at_q));
    }
    if (begin > end) return 4.0;
    vec2 a = mix(p, q, begin), b = mix(p, q, end);
    bool is_b = a.x * b.y < a.y * b.x || (b.y == 0.0 && b.x >= 0.0); /* b has the smaller angle */
    return vxs_epipolar_angle(is_b ? b.y : a.y, is_b ? b.x : a.x);
}

/* A row is a wedge. Its points are moved to the half plane by their distance from the axis. This bends edges toward the axis, to
 * at least this share of the distance, */
float bent_part(vxs_epipolar space, vxs_grid_size size)
{
    return cos(0.5 * (space.theta.y - space.theta.x) / float(size.rows));
}

/* and changes angles at the eye and at a punctual light by at most this. */
float bent_angle(float part)
{
    return (1.0 - part) / (1.0 + part);
}

/* The first column of a bit that a polygon touches, or may touch if its edges are bent; size.columns or more: none. */
float first_column(vxs_epipolar space, vxs_grid_size size, int bit, vec2 places[5], int count)
{
    float part = bent_part(space, size), off = bent_angle(part), alpha = 4.0;
    float begin = vxs_grid_place(space.phi, float(bit), size.bits), end = vxs_grid_place(space.phi, float(bit + 1), size.bits);
    vec2  near_ray, far_ray;
    vxs_epipolar_turn_of(space, space.away > 0.0 ? max(begin - off, 0.0) : begin, near_ray);
    vxs_epipolar_turn_of(space, space.away > 0.0 ? min(end + off, VXS_AIR_PI) : end / part, far_ray);
    for (int n = 1; n < count; n++) { /* edges of a fan of triangles, because in the half plane the polygon's own edges may cross */
        alpha = min(alpha, least_alpha(space, near_ray, far_ray, places[0], places[n]));
        if (n > 1) alpha = min(alpha, least_alpha(space, near_ray, far_ray, places[n - 1], places[n]));
    }
    return alpha < 4.0 ? max(floor(vxs_grid_before(space.alpha, alpha - off, size.columns)), 0.0) : float(size.columns);
}

void voxelize(vxs_epipolar space, vxs_grid_size size, int row, vec3 triangle[3])
{
    polygon of;
    vec2    places[5], low = way_at(vxs_grid_place(space.theta, float(row), size.rows));
    vec2    high = way_at(vxs_grid_place(space.theta, float(row + 1), size.rows));
    float   part = bent_part(space, size), least = float(size.bits), most = 0.0;
    for (int n = 0; n < 3; n++) of.at[n] = triangle[n];
    of.count = 3;
    clip(of, vec2(-low.y, low.x));
    clip(of, vec2(high.y, -high.x));
    for (int n = 0; n < of.count; n++) {
        places[n] = vec2(of.at[n].x, length(of.at[n].yz));
        float before = bits_before(space, size, places[n]), bent = bits_before(space, size, vec2(places[n].x, part * places[n].y));
        least = min(least, min(before, bent));
        most = max(most, max(before, bent));
    }
    for (int bit = int(max(floor(least), 0.0)); bit < int(min(floor(most) + 1.0, float(size.bits))); bit++) {
        float column = first_column(space, size, bit, places, of.count);
        if (column < float(size.columns)) set_bit(size, int(column), row, bit);
    }
}
#endif

void main()
{
    uint          at = gl_LocalInvocationID.x, triangle = vxs_voxels.first_triangle + 64u * gl_WorkGroupID.x + at, turns = 64u * gl_NumWorkGroups.y;
    vxs_epipolar  space = vxs_grid_space();
    vxs_grid_size size = vxs_grid_size(vxs_grid.size.x, vxs_grid.size.y, vxs_grid.size.z);
    vec3          read[3];
    bool          is_triangle = triangle < vxs_voxels.triangles;
    ivec2         rows = ivec2(0);
    for (uint n = 0u; n < 3u && is_triangle; n++) is_triangle = read_corner(3u * triangle + n, read[n]);
    if (is_triangle) {
        rows = rows_of(space, size, read);
        if (gl_WorkGroupID.y == 0u) darken_eye(read[0], read[1], read[2]);
        for (uint n = 0u; n < 3u; n++) corners[3u * at + n] = read[n];
    }
    first_rows[at] = rows.x;
    ends[at] = uint(rows.y);
    barrier();
    for (uint step = 1u; step < 64u; step *= 2u) {
        uint before = at >= step ? ends[at - step] : 0u;
        barrier();
        ends[at] += before;
        barrier();
    }
    for (uint row = at + 64u * gl_WorkGroupID.y; row < ends[63]; row += turns) {
        uint n = 0u;
        for (uint step = 32u; step > 0u; step /= 2u)
            if (ends[n + step - 1u] <= row) n += step;
        int of_grid = first_rows[n] + int(row - (n > 0u ? ends[n - 1u] : 0u));
        for (uint k = 0u; k < 3u; k++) read[k] = corners[3u * n + k];
        voxelize(space, size, of_grid < 0 ? of_grid + size.rows : of_grid >= size.rows ? of_grid - size.rows : of_grid, read);
    }
    if (vxs_is_cut()) atomicAdd(vxs_grid.cut.x, 1u);
}
