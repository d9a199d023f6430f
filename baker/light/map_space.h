/* Points of the world in the maps of a light: map space, in which a map is a box or a pyramid, for clipping; light space; and the
 * shape of a baked light.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MAP_SPACE_H
#define MAP_SPACE_H

#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

enum { MAP_SIDES = 5, MAP_CORNERS_MAX = 16 }; /* 3 + MAP_SIDES corners, and a reserve for rounding */

typedef struct map_corner {
    double at[3]; /* map space */
    double uv[2]; /* position in the image of an alpha-tested material, if any; interpolated for new corners */
} map_corner;

/* Convex. */
typedef struct map_polygon {
    map_corner corners[MAP_CORNERS_MAX];
    int        count;
} map_polygon;

/* A point (x, y, z) is inside when n[0] x + n[1] y + n[2] z + n[3] >= 0 for each side. The last side cuts off the tip of a
 * pyramid. */
typedef struct map_sides {
    double n[MAP_SIDES][4];
} map_sides;

/* Transform from world space to map space. */
typedef struct map_frame {
    double rows[3][4];
    double unit; /* scale of the third coordinate */
} map_frame;

/* Frame of map `map` of a light (numbered as in runtime/vxs.h). */
map_frame map_frame_of(const vxs_light *light, int map);

static inline void map_space_from_ws(const map_frame *f, const double point_ws[3], double out[3])
{
    for (int n = 0; n < 3; n++)
        out[n] = f->rows[n][0] * point_ws[0] + f->rows[n][1] * point_ws[1] + f->rows[n][2] * point_ws[2] + f->rows[n][3];
    out[2] *= f->unit;
}

struct box; /* baker/base/box.h */

/* A linear function of points in world space. */
typedef struct map_plane {
    double n[4], sizes[4]; /* n . point + n[3]; sums of the sizes of the terms of n, for rounding */
} map_plane;

/* A linear function of map space, such as one of map_sides. */
map_plane map_plane_of(const map_frame *f, const double side[4]);

/* No point of the box gets more than this from the function in map space, computed as map_side_at. */
double map_plane_most(const map_plane *p, const struct box *b);

/* 1 when a point, or all of a triangle, lies behind a spot light. No cone includes it, but some maps of a cube do. */
int map_space_point_behind(const vxs_light *light, int map, const double at[3]);
int map_space_behind(const vxs_light *light, int map, const map_polygon *triangle);

/* Sides of a light's maps, moved outward by beyond_px texels. */
map_sides map_sides_of(const vxs_light *light, double beyond_px);

/* How far inside a side a point of map space is; below 0: outside. */
static inline double map_side_at(const double side[4], const double at[3])
{
    return side[0] * at[0] + side[1] * at[1] + side[2] * at[2] + side[3];
}

/* 0 when a triangle is outside one of the sides; 1: it may be inside. */
int map_sides_touch(const map_sides *s, const map_polygon *triangle);

/* Clip a triangle to all sides. Fewer than 3 corners: nothing is inside. Returns 0 when all of it is inside. Triangles that share
 * an edge get identical new corners on it, so that no crack opens. */
int map_sides_clip(const map_sides *s, const map_polygon *triangle, map_polygon *out);

/* Shape of a baked light, and coordinates of points in its maps. */

/* Kind, position, direction, cone and range, in world space. */
light_shape baked_light_shape(const vxs_light *light);

/* Light-space coordinates of a point in a map: texels u, v and depth in voxels, not rounded. Inverse of vxs_point.
 * map  0, or 0 to 5 for a light with six maps: the map that vxs_voxel returns, in front of which the point lies */
void baked_light_coordinates(const vxs_light *light, int map, const double point_ws[3], double coordinates[3]);

#endif
