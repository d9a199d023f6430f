/* Spheres in fog: shadow depth maps of them, views, and airlight by exact traversal of a shadow depth map, in double. Included
 * behind cmocka.h.
 *
 * A shadow depth map is as vxs_volumes.h has it: where shadow begins on the light ray through each texel's centre; of suns in
 * voxels, of punctual lights in metres along the map's axis; 1e30 where light does not end. Here everything about it is computed
 * from matrices, and not by vxs_epipolar.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_SCENE_H
#define FOG_SCENE_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/spread.h"
#include "random_light.h"
#include "runtime/volumes/vxs_air_path.h"

enum { SPHERES_MOST = 32 };

typedef struct fog_scene {
    double   spheres[SPHERES_MOST][4]; /* places and radii */
    uint32_t count;
} fog_scene;

typedef struct shadow_depth_map {
    vxs_light light;
    float    *first; /* [layers][side][side] */
    int       side, layers;
} shadow_depth_map;

typedef struct fog_view {
    double eye[3], axes[3][3]; /* right, up, ahead, each of length 1 */
    double half_wide, half_high, far_metres;
    int    wide, high;
} fog_view;

/* Where a ray meets the nearest sphere; INFINITY: nowhere.   direction  of length 1 */
static inline double spheres_hit(const fog_scene *s, const double *from, const double *direction)
{
    double nearest = INFINITY;
    for (uint32_t n = 0; n < s->count; n++) {
        double to[3], square = s->spheres[n][3] * s->spheres[n][3];
        for (int i = 0; i < 3; i++) to[i] = s->spheres[n][i] - from[i];
        double along = dot(to, direction), inside = square - dot(to, to) + along * along;
        if (inside > 0 && along - sqrt(inside) > 0) nearest = fmin(nearest, along - sqrt(inside));
    }
    return nearest;
}

/* Light space of a direction and a place: row n is axis n. */
static inline vxs_light light_make(uint32_t kind, const double *place, const double *direction, double cone_rad, double metres)
{
    vxs_light light = {.kind = kind, .levels = 10};
    double    axes[3][3], side = ldexp(1, (int)light.levels);
    memcpy(axes[2], direction, sizeof axes[2]);
    make_unit(axes[2]);
    double up[3] = {fabs(axes[2][0]) < 0.6, fabs(axes[2][0]) >= 0.6, 0};
    cross(up, axes[2], axes[0]);
    make_unit(axes[0]);
    cross(axes[2], axes[0], axes[1]);
    int is_sun         = kind == VXS_LIGHT_KIND_DIRECTIONAL;
    light.flags        = kind == VXS_LIGHT_KIND_POINT ? VXS_LIGHT_CUBE : 0;
    light.texel_metres = is_sun ? metres / side : (kind == VXS_LIGHT_KIND_POINT ? 1 : tan(cone_rad)) / (side / 2 - 26);
    light.voxel_metres = is_sun ? metres / side : log(1e4) / side;
    light.near_metres  = 0.01;
    light.cos_outer    = kind == VXS_LIGHT_KIND_SPOT ? cos(cone_rad) : 0;
    memcpy(light.direction_ws, axes[2], sizeof axes[2]);
    for (int row = 0; row < 3; row++) {
        double scale = is_sun ? side / metres : 1;
        for (int i = 0; i < 3; i++) light.ls_from_ws[4 * row + i] = axes[row][i] * scale;
        light.ls_from_ws[4 * row + 3] = -dot(axes[row], place) * scale + (is_sun ? side / 2 : 0);
    }
    return light;
}

/* The face's axes and place in world space: metres about the light; of suns u, v, depth in texels of the baked map. */
static inline void face_from_ws(const shadow_depth_map *m, int face, const double *ws, double one, double *out)
{
    double ls[3];
    for (int row = 0; row < 3; row++) ls[row] = dot(m->light.ls_from_ws + 4 * row, ws) + one * m->light.ls_from_ws[4 * row + 3];
    const char *axes = map_axes[m->layers > 1 ? face : 4];
    for (int n = 0; n < 3; n++) out[n] = axes[n] < 'a' ? -ls[axes[n] - 'X'] : ls[axes[n] - 'x'];
}

/* Of punctual lights, how far across at z = 1 the edge of texel n lies; of suns, its u. */
static inline double texel_edge(const shadow_depth_map *m, double n)
{
    double baked = ldexp(1, (int)m->light.levels);
    return m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? n * baked / m->side
                                                       : (n * baked / m->side - baked / 2) * m->light.texel_metres;
}

/* The light ray through a texel's centre: of a punctual light from it on, of a sun from depth 0 on.
 * way  [out] of length 1
 * Returns how many metres along it the map's depth grows by 1 */
static inline double shadow_depth_map_ray(const shadow_depth_map *m, int face, int x, int y, double *from, double *way)
{
    /* the face's axes in world space, from what it makes of those of the world */
    int    is_sun = m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double columns[3][3], middle[3], scale[3] = {m->light.texel_metres, m->light.texel_metres, m->light.voxel_metres};
    double at[3] = {texel_edge(m, x + 0.5), texel_edge(m, y + 0.5), is_sun ? 0 : 1};
    for (int i = 0; i < 3; i++) {
        double unit[3] = {i == 0, i == 1, i == 2};
        face_from_ws(m, face, unit, 0, columns[i]);
    }
    face_from_ws(m, face, (double[3]){0, 0, 0}, 1, middle);
    for (int i = 0; i < 3; i++) {
        from[i] = 0; /* of a punctual light, where the face's place is 0 */
        for (int k = 0; k < 3; k++) from[i] += columns[i][k] * (is_sun ? (at[k] - middle[k]) * scale[k] * scale[k] : -middle[k]);
        way[i] = is_sun ? columns[i][2] * scale[2] * scale[2] : dot(columns[i], at);
    }
    double metres = sqrt(dot(way, way));
    make_unit(way);
    return metres;
}

static inline shadow_depth_map shadow_depth_map_make(const fog_scene *s, const vxs_light *light, int side)
{
    shadow_depth_map m = {.light = *light, .side = side, .layers = light->flags & VXS_LIGHT_CUBE ? 6 : 1};
    double back        = light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 1e4 : 0; /* metres: suns see what is before their maps, too */
    m.first            = malloc((size_t)m.layers * (size_t)(side * side) * sizeof *m.first);
    assert_non_null(m.first);
    for (int face = 0; face < m.layers; face++)
        for (int y = 0; y < side; y++)
            for (int x = 0; x < side; x++) {
                double from[3], way[3], metres = shadow_depth_map_ray(&m, face, x, y, from, way);
                for (int i = 0; i < 3; i++) from[i] -= back * way[i];
                double first = (spheres_hit(s, from, way) - back) / metres;
                m.first[((size_t)face * (size_t)side + (size_t)y) * (size_t)side + (size_t)x] = first < 1e30 ? (float)first : 1e30F;
            }
    return m;
}

/* Which texel of which face a place is in; 0: none. depth [out] as the map's. */
static inline int shadow_depth_map_texel(const shadow_depth_map *m, const double *ws, size_t *texel, double *depth)
{
    double side = m->side;
    for (int face = 0; face < m->layers; face++) {
        double p[3], u, v, edge = ldexp(1, (int)m->light.levels);
        face_from_ws(m, face, ws, 1, p);
        if (m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL) {
            u = p[0] * side / edge;
            v = p[1] * side / edge;
        } else {
            if (!(p[2] > 0) || (m->layers > 1 && (fabs(p[0]) > p[2] || fabs(p[1]) > p[2]))) continue;
            u = side / 2 + p[0] / p[2] / (m->light.texel_metres * edge / side);
            v = side / 2 + p[1] / p[2] / (m->light.texel_metres * edge / side);
        }
        if (!(u >= 0 && v >= 0 && u < side && v < side)) continue;
        *texel = ((size_t)face * (size_t)m->side + (size_t)v) * (size_t)m->side + (size_t)u;
        *depth = p[2];
        return 1;
    }
    return 0;
}

static inline int shadow_depth_map_lit(const shadow_depth_map *m, const double *ws)
{
    size_t texel;
    double depth;
    return !shadow_depth_map_texel(m, ws, &texel, &depth) || depth < (double)m->first[texel];
}

static inline fog_view view_make(const double *eye, const double *ahead, double half_rad, int wide, int high, double far_metres)
{
    fog_view v = {
        .half_wide = tan(half_rad), .half_high = tan(half_rad) * high / wide, .far_metres = far_metres, .wide = wide, .high = high};
    double up[3] = {0, 1, 0};
    memcpy(v.eye, eye, sizeof v.eye);
    memcpy(v.axes[2], ahead, sizeof v.axes[2]);
    make_unit(v.axes[2]);
    if (fabs(v.axes[2][1]) > 0.999) up[0] = 1, up[1] = 0;
    cross(v.axes[2], up, v.axes[0]);
    make_unit(v.axes[0]);
    cross(v.axes[0], v.axes[2], v.axes[1]);
    return v;
}

/* x, y  in [-1, 1] of the image */
static inline void view_direction(const fog_view *v, double x, double y, double *direction)
{
    for (int i = 0; i < 3; i++) direction[i] = v->axes[2][i] + x * v->half_wide * v->axes[0][i] + y * v->half_high * v->axes[1][i];
    make_unit(direction);
}

static inline void pixel_direction(const fog_view *v, int x, int y, double *direction)
{
    view_direction(v, (2 * x + 1.0) / v->wide - 1, (2 * y + 1.0) / v->high - 1, direction);
}

/* Airlight of an eye ray by the map: cut where it passes from texel to texel, and in each where it passes the texel's depth. */
static inline void map_airlight(const shadow_depth_map *m, const vxs_medium *medium, const vxs_air_path *path, const double *eye,
                                const double *direction, double airlight[3])
{
    static double cuts[1 << 16];
    size_t        count       = 0;
    int           is_punctual = m->light.kind != VXS_LIGHT_KIND_DIRECTIONAL;
    cuts[count++]             = path->begin;
    cuts[count++]             = path->end;
    for (int face = 0; face < m->layers; face++) {
        double o[3], w[3];
        face_from_ws(m, face, eye, 1, o);
        face_from_ws(m, face, direction, 0, w);
        for (int n = -1; n <= m->side + 1; n++)
            for (int axis = 0; axis < 2; axis++) {
                /* beyond both ends, of a cube: the sides of the face */
                double edge = n < 0 ? -1 : n > m->side ? 1 : texel_edge(m, n), x;
                if (is_punctual)
                    x = -(o[axis] - edge * o[2]) / (w[axis] - edge * w[2]);
                else
                    x = (edge - o[axis]) / w[axis];
                if (!(x > path->begin && x < path->end) || count >= sizeof cuts / sizeof *cuts) continue;
                if (is_punctual) {
                    double z = o[2] + x * w[2];
                    if (z < 0 || (m->layers > 1 && fabs(o[1 - axis] + x * w[1 - axis]) > z * (1 + 1e-9))) continue;
                }
                cuts[count++] = x;
            }
    }
    qsort(cuts, count, sizeof *cuts, doubles_ascending);
    airlight[0] = airlight[1] = airlight[2] = 0;
    double begin                            = path->begin;
    int    lit                              = 0; /* since begin */
    for (size_t n = 0; n + 1 <= count; n++) {
        double ends[3] = {cuts[n], n + 1 < count ? cuts[n + 1] : cuts[n], 0}, middle[3], depth, from, to;
        size_t texel;
        if (n + 1 < count && !(ends[1] > ends[0])) continue;
        int parts = 1, states[2] = {0, 0};
        ends[2] = ends[1];
        if (n + 1 < count) {
            for (int i = 0; i < 3; i++) middle[i] = eye[i] + (ends[0] + ends[1]) / 2 * direction[i];
            states[0] = 1;
            if (shadow_depth_map_texel(m, middle, &texel, &depth)) {
                int    face = (int)(texel / (size_t)(m->side * m->side));
                double o[3], w[3], z = (double)m->first[texel];
                face_from_ws(m, face, eye, 1, o);
                face_from_ws(m, face, direction, 0, w);
                from = o[2] + ends[0] * w[2], to = o[2] + ends[1] * w[2];
                states[0] = from < z;
                states[1] = to < z;
                if (states[0] != states[1]) {
                    parts   = 2;
                    ends[1] = fmin(fmax((z - o[2]) / w[2], ends[0]), ends[2]);
                }
            }
        }
        for (int k = 0; k < parts; k++) {
            if (states[k] == lit) continue;
            if (lit) {
                double found[3];
                vxs_air_lit(medium, path, begin, ends[k], found);
                for (int i = 0; i < 3; i++) airlight[i] += found[i];
            }
            lit   = states[k];
            begin = ends[k];
        }
    }
}

#endif
