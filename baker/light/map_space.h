/* The space in which a light's map is flat or a pyramid, and what of a triangle lies in it.
 *
 *     directional    (u, v, depth as a share of the whole): the sides of the map are parallel
 *     spot, point    metres across, down, and along the map's axis, from the light: the sides meet at the light
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MAP_SPACE_H
#define MAP_SPACE_H

#include "formats/vxs_file.h"

enum { MAP_SIDES = 5, MAP_CORNERS_MAX = 16 }; /* 3 + MAP_SIDES corners, and room for what rounding may add */

typedef struct map_corner {
    double at[3]; /* map space */
    double uv[2]; /* place in an alpha-tested material's image, where it has one: new corners get theirs, too */
} map_corner;

/* Convex. */
typedef struct map_polygon {
    map_corner corners[MAP_CORNERS_MAX];
    int        count;
} map_polygon;

/* Inside is where n[0] x + n[1] y + n[2] z + n[3] >= 0 for each; the last is what keeps a pyramid from its tip. */
typedef struct map_sides {
    double n[MAP_SIDES][4];
} map_sides;

/* The way from the world into the space of a map. */
typedef struct map_frame {
    double rows[3][4];
    double unit; /* of the third coordinate */
} map_frame;

/* Of map `map` of a light (runtime/vxs.h numbers them). */
map_frame map_frame_of(const vxs_light *light, int map);

static inline void map_space_from_ws(const map_frame *f, const double point_ws[3], double out[3])
{
    for (int n = 0; n < 3; n++)
        out[n] = f->rows[n][0] * point_ws[0] + f->rows[n][1] * point_ws[1] + f->rows[n][2] * point_ws[2] + f->rows[n][3];
    out[2] *= f->unit;
}

/* 1 when a triangle lies behind a spot light, which no cone covers, but some of a cube's maps do. */
int map_space_behind(const vxs_light *light, int map, const map_polygon *triangle);

/* The sides of a light's maps, moved outward by so many texels. */
map_sides map_sides_of(const vxs_light *light, double beyond_px);

/* 0 when a triangle is outside one of the sides; 1: it may be inside all. */
int map_sides_touch(const map_sides *s, const map_polygon *triangle);

/* What of a triangle is inside all sides; fewer than 3 corners: nothing. Returns 0 when it is all of it.
 * Two triangles that share an edge get the same new corner on it: no crack opens. */
int map_sides_clip(const map_sides *s, const map_polygon *triangle, map_polygon *out);

#endif
