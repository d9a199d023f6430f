/* Shadows of triangles along an eye ray, exactly, in double: of each triangle an interval, where a ray enters and leaves the
 * pyramid or prism that it casts. Included behind random_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRIANGLE_SHADOWS_H
#define TRIANGLE_SHADOWS_H

#include "runtime/volumes/vxs_air_path.h"

/* The part of a ray where origin + x way is on one side of a plane.   positive  a place on that side
 * part  [in, out] begin, end; empty where the plane is none */
static inline void clip_to_plane(const double normal[3], const double on[3], const double positive[3], const double origin[3],
                                 const double way[3], double part[2])
{
    double side = dot(normal, positive) - dot(normal, on), at = dot(normal, origin) - dot(normal, on), slope = dot(normal, way);
    if (side < 0) at = -at, slope = -slope;
    double x = -at / slope;
    if (side == 0 || (slope == 0 && at < 0)) part[1] = part[0];
    if (slope > 0) part[0] = fmax(part[0], x);
    if (slope < 0) part[1] = fmin(part[1], x);
}

/* light  of a punctual light its place, of a sun the way to it;   part  as above */
static inline void triangle_shadow(double corners[3][3], const vxs_air_light *light, const double origin[3], const double way[3],
                                   double part[2])
{
    int    is_sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double to_light[3][3], edge[3], other[3], normal[3], behind[3];
    for (int n = 0; n < 3; n++)
        for (int i = 0; i < 3; i++) to_light[n][i] = light->place[i] - (is_sun ? 0 : corners[n][i]);
    for (int n = 0; n < 3; n++) {
        for (int i = 0; i < 3; i++) edge[i] = corners[(n + 1) % 3][i] - corners[n][i];
        cross(edge, to_light[n], normal);
        clip_to_plane(normal, corners[n], corners[(n + 2) % 3], origin, way, part);
    }
    for (int i = 0; i < 3; i++) {
        edge[i]   = corners[1][i] - corners[0][i];
        other[i]  = corners[2][i] - corners[0][i];
        behind[i] = corners[0][i] - to_light[0][i];
    }
    cross(edge, other, normal);
    clip_to_plane(normal, corners[0], behind, origin, way, part);
}

static inline int by_begin(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (p[0] > q[0]) - (p[0] < q[0]);
}

/* Airlight of a path in all shadows.   places, corners, count  triangles;   airlight  [out] for an intensity of 1 */
static inline void triangles_airlight(const float *places, const uint32_t *corners, uint32_t count, const vxs_medium *medium,
                                      const vxs_air_light *light, const vxs_air_path *path, const double eye[3],
                                      const double direction[3], double airlight[3])
{
    enum { MOST = 4096 };
    static double parts[MOST][2];
    size_t        dark = 0;
    double        lit[3], begin = path->begin;
    assert_true(count < MOST);
    for (uint32_t t = 0; t < count; t++) {
        double at[3][3];
        for (int n = 0; n < 3; n++)
            for (int i = 0; i < 3; i++) at[n][i] = (double)places[3 * corners[3 * t + (uint32_t)n] + (uint32_t)i];
        parts[dark][0] = path->begin;
        parts[dark][1] = path->end;
        triangle_shadow(at, light, eye, direction, parts[dark]);
        dark += parts[dark][1] > parts[dark][0];
    }
    qsort(parts, dark, sizeof *parts, by_begin);
    parts[dark][0] = parts[dark][1] = path->end;
    airlight[0] = airlight[1] = airlight[2] = 0;
    for (size_t n = 0; n <= dark && path->end > path->begin; n++) {
        if (parts[n][0] > begin) vxs_air_lit(medium, path, begin, parts[n][0], lit);
        for (int i = 0; i < 3 && parts[n][0] > begin; i++) airlight[i] += lit[i];
        begin = fmax(begin, parts[n][1]);
    }
}

#endif
