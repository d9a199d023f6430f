/* Map space and clipping in it; see map_space.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/map_space.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "baker/base/portable_math.h"
#include "baker/base/vec3.h"
#include "formats/vxs_space.h"
#include "runtime/vxs.h"

#include "baker/base/box.h" /* after vxs_space.h, which has variables of that name */

/* Casters may be nearer than the near plane. Parts nearer than this share of it are clipped. */
#define NEAREST_SHARE (1.0 / 1024)

map_frame map_frame_of(const vxs_light *light, int map)
{
    const int face = vxs_face_of_map(light, map);
    map_frame f    = {.unit = light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? ldexp(1, -(int)light->levels) : vxs_face_sign(face)};
    for (int n = 0; n < 3; n++) memcpy(f.rows[n], light->ls_from_ws + 4 * vxs_ls_axis_from_face(face, n), sizeof f.rows[n]);
    return f;
}

map_plane map_plane_of(const map_frame *f, const double side[4])
{
    map_plane p = {{0, 0, 0, side[3]}, {0, 0, 0, fabs(side[3])}};
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 4; k++) {
            double term = (row == 2 ? side[row] * f->unit : side[row]) * f->rows[row][k];
            p.n[k] += term;
            p.sizes[k] += fabs(term);
        }
    return p;
}

double map_plane_most(const map_plane *p, const box *b)
{
    double most = p->n[3], size = p->sizes[3];
    for (int k = 0; k < 3; k++) {
        most += p->n[k] * (p->n[k] > 0 ? b->max[k] : b->min[k]);
        size += p->sizes[k] * fmax(fabs(b->min[k]), fabs(b->max[k]));
    }
    return most + 0x1p-46 * size;
}

int map_space_point_behind(const vxs_light *light, int map, const double at[3])
{
    if (light->kind != VXS_LIGHT_KIND_SPOT) return 0;
    const int face = vxs_face_of_map(light, map), n = vxs_face_axis_from_ls(face, 2);
    return (n == 2 ? at[2] * vxs_face_sign(face) : at[n]) < 0;
}

int map_space_behind(const vxs_light *light, int map, const map_polygon *triangle)
{
    for (int n = 0; n < triangle->count; n++)
        if (!map_space_point_behind(light, map, triangle->corners[n].at)) return 0;
    return 1;
}

map_sides map_sides_of(const vxs_light *light, double beyond_px)
{
    int       is_punctual = light->kind != VXS_LIGHT_KIND_DIRECTIONAL;
    double    middle = ldexp(0.5, (int)light->levels), half = middle + beyond_px;
    map_sides s = {{{0}}};
    for (int n = 0; n < 4; n++) {
        double sign   = n % 2 ? 1 : -1;
        s.n[n][n / 2] = sign;
        if (is_punctual)
            s.n[n][2] = half * light->texel_metres;
        else
            s.n[n][3] = half - sign * middle;
    }
    s.n[4][2] = is_punctual;
    s.n[4][3] = is_punctual ? -light->near_metres * NEAREST_SHARE : 1;
    return s;
}

int map_sides_touch(const map_sides *s, const map_polygon *triangle)
{
    for (int n = 0; n < MAP_SIDES; n++) {
        int outside = 1;
        for (int k = 0; k < triangle->count; k++) outside &= map_side_at(s->n[n], triangle->corners[k].at) < 0;
        if (outside) return 0;
    }
    return 1;
}

static void copy(map_polygon *to, const map_polygon *from)
{
    to->count = from->count;
    memcpy(to->corners, from->corners, (size_t)from->count * sizeof *to->corners);
}

/* Intersection of an edge with a side. Always computed from the inside corner to the outside one, so that both triangles of an edge
 * get the same result. */
static map_corner crossing(const map_corner *inside, double d_inside, const map_corner *outside, double d_outside)
{
    map_corner c;
    double     share = d_inside / (d_inside - d_outside);
    for (int n = 0; n < 3; n++) c.at[n] = inside->at[n] + share * (outside->at[n] - inside->at[n]);
    for (int n = 0; n < 2; n++) c.uv[n] = inside->uv[n] + share * (outside->uv[n] - inside->uv[n]);
    return c;
}

/* Clipping by Sutherland and Hodgman, 1974. Returns 0 when all of it is inside. */
static int clip(const double side[4], const map_polygon *polygon, map_polygon *out)
{
    double d[MAP_CORNERS_MAX];
    int    whole = 1;
    for (int n = 0; n < polygon->count; n++) whole &= (d[n] = map_side_at(side, polygon->corners[n].at)) >= 0;
    if (whole) return 0;
    out->count = 0;
    for (int n = 0; n < polygon->count && out->count < MAP_CORNERS_MAX - 1; n++) {
        int               to = (n + 1) % polygon->count;
        const map_corner *a = &polygon->corners[n], *b = &polygon->corners[to];
        if (d[n] >= 0) out->corners[out->count++] = *a;
        if (d[n] >= 0 && d[to] < 0) out->corners[out->count++] = crossing(a, d[n], b, d[to]);
        if (d[n] < 0 && d[to] >= 0) out->corners[out->count++] = crossing(b, d[to], a, d[n]);
    }
    return 1;
}

int map_sides_clip(const map_sides *s, const map_polygon *triangle, map_polygon *out)
{
    map_polygon kept;
    int         clipped = 0;
    copy(out, triangle);
    /* the last side (the tip) first: the other sides are only valid in front of it */
    for (int n = MAP_SIDES - 1; n >= 0 && out->count; n--)
        if (clip(s->n[n], out, &kept)) {
            copy(out, &kept);
            clipped = 1;
        }
    return clipped;
}

light_shape baked_light_shape(const vxs_light *light)
{
    light_shape shape = {.kind = LIGHT_DIRECTIONAL, .range_metres = INFINITY};
    memcpy(shape.direction_ws, light->direction_ws, sizeof shape.direction_ws);
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return shape;

    shape.kind      = light->kind == VXS_LIGHT_KIND_SPOT ? LIGHT_SPOT : LIGHT_POINT;
    shape.outer_rad = portable_acos(light->cos_outer);
    if (light->range_metres > 0) shape.range_metres = light->range_metres;
    /* the pyramid of a map ends at the light, where log depth is -infinity */
    double middle = ldexp(0.5, (int)light->levels);
    vxs_point(light, 0, (double[]){middle, middle, -INFINITY}, shape.position_ws);
    return shape;
}

void baked_light_coordinates(const vxs_light *light, int map, const double point_ws[3], double coordinates[3])
{
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        for (int row = 0; row < 3; row++)
            coordinates[row] = vec3_dot(light->ls_from_ws + 4 * row, point_ws) + light->ls_from_ws[4 * row + 3];
        return;
    }
    double p[3];

    /* A point in metres across, down and away from the light, along the axes of a map. The axes are found with a copy of the
     * light whose light space is world space. */
    vxs_light plain    = *light;
    double    half     = ldexp(0.5, (int)light->levels), ls[3];
    double    one      = -portable_log(light->near_metres) / light->voxel_metres; /* depth at one metre */
    double    texels   = 1 / light->texel_metres;                                 /* per metre, at that depth */
    double    at[3][3] = {{half + texels, half, one}, {half, half + texels, one}, {half, half, one}}, axis[3][3];
    memcpy(plain.ls_from_ws, (double[12]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, sizeof plain.ls_from_ws);
    for (int row = 0; row < 3; row++) {
        const double *m = light->ls_from_ws + 4 * row;
        ls[row]         = vec3_dot(m, point_ws) + m[3];
        vxs_point(&plain, map, at[row], axis[row]);
    }
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3 && row < 2; k++) axis[row][k] -= axis[2][k];
        for (int k = 0; k < 3; k++) axis[row][k] = round(axis[row][k]); /* they are axes of light space */
        p[row] = vec3_dot(axis[row], ls);
    }

    double z = fmax(p[2], DBL_MIN);
    for (int i = 0; i < 2; i++) coordinates[i] = ldexp(0.5, (int)light->levels) + p[i] / z / light->texel_metres;
    coordinates[2] = portable_log(z / light->near_metres) / light->voxel_metres;
}
