/* Random points that a light can light; see lit_points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/lit_points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/portable_math.h"
#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/light/light_fit.h"
#include "baker/light/map_space.h"

enum { SEED = 0x11f7 };

/* Triangles that may be in reach, with the prefix sums of their areas. */
typedef struct candidates {
    size_t    count;
    uint32_t *triangles; /* [count] */
    double   *area_to;   /* [count] total square metres up to and including each triangle */
} candidates;

static double cross_length(const double *a, const double *b, const double *c)
{
    double ab[3], ac[3], normal[3];
    vec3_sub(b, a, ab);
    vec3_sub(c, a, ac);
    vec3_cross(ab, ac, normal);
    return sqrt(vec3_dot(normal, normal));
}

static const double *corner_of(const casters *c, size_t triangle, size_t n)
{
    return c->positions_ws + 3 * (size_t)c->indices[3 * triangle + n];
}

/* 1 when the ball around a box may be in reach. The caller computes cosine and sine of the cone once. */
static int touches(const light_shape *shape, double cosine, double sine, const box *run)
{
    double size[3], center[3], way[3];
    vec3_sub(run->max, run->min, size);
    vec3_mad(run->min, 0.5, size, center);
    vec3_sub(center, shape->position_ws, way);
    double r      = 0.5 * sqrt(vec3_dot(size, size)) * (1 + 1e-9) + 1e-12;
    double square = vec3_dot(way, way);
    if (square > (shape->range_metres + r) * (shape->range_metres + r)) return 0;
    if (shape->kind == LIGHT_POINT) return 1;
    double along = vec3_dot(way, shape->direction_ws), beside = square - along * along;
    return along > -r && sqrt(beside > 0 ? beside : 0) * cosine - along * sine <= r;
}

/* Take every step-th triangle of the touched runs. Returns how many. */
static size_t take(candidates *out, const lit_points_desc *d, const uint8_t *touched, size_t step)
{
    const casters *c     = d->c;
    size_t         count = 0, until_next = 1;
    double         area = 0;
    for (size_t run = 0; run < casters_run_count(d->c); run++) {
        size_t end = touched[run] ? casters_run_end(d->c, run) : 0;
        for (size_t t = run * CASTERS_RUN; t < end; t++) {
            if ((d->object_of && d->object_of[c->component_of[t]] == d->without) || --until_next) continue;
            until_next            = step;
            double own            = 0.5 * cross_length(corner_of(c, t, 0), corner_of(c, t, 1), corner_of(c, t, 2));
            out->triangles[count] = (uint32_t)t;
            out->area_to[count++] = area += isfinite(own) ? own : 0;
        }
    }
    return count;
}

/* The candidate at a given share of the total area. */
static size_t candidate_at(const candidates *k, double share)
{
    double area = share * k->area_to[k->count - 1];
    size_t low = 0, high = k->count - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (k->area_to[middle] > area)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static double polygon_area(const map_polygon *p)
{
    double area = 0;
    for (int n = 1; n + 1 < p->count; n++) area += 0.5 * cross_length(p->corners[0].at, p->corners[n].at, p->corners[n + 1].at);
    return area;
}

/* A uniformly distributed point of a convex polygon. */
static void point_in(const map_polygon *p, double area, rng *random, double out[3])
{
    double left = rng_unit(random) * area, u = sqrt(rng_unit(random)), v = rng_unit(random);
    int    n = 1;
    for (; n + 2 < p->count; n++) {
        double part = 0.5 * cross_length(p->corners[0].at, p->corners[n].at, p->corners[n + 1].at);
        if (left < part) break;
        left -= part;
    }
    for (int axis = 0; axis < 3; axis++)
        out[axis] = (1 - u) * p->corners[0].at[axis] + u * ((1 - v) * p->corners[n].at[axis] + v * p->corners[n + 1].at[axis]);
}

/* Half width of a map at one metre, without the border, where the maps of a cube overlap. */
static double slope_of(const lit_points_desc *d)
{
    return vxs_map_count(d->light) > 1 ? 1 : portable_tan(d->shape->outer_rad);
}

/* A random point of the visible part of a triangle. Returns 0 when no part is visible. */
static int point_of_punctual(lit_point *out, const lit_points_desc *d, const map_sides *sides, double cosine, size_t t, rng *random)
{
    map_polygon seen[VXS_CUBE_FACES];
    double      areas[VXS_CUBE_FACES], all = 0, at[3];
    int         maps = (int)vxs_map_count(d->light), map = 0;
    for (int n = 0; n < maps; n++) {
        map_frame frame = map_frame_of(d->light, n);

        /* The part of a triangle that a map of a spot or point light sees, in map space. The range is cut by a plane here;
         * points beyond it are rejected later. */
        map_polygon triangle = {.count = 3}, kept;
        map_sides   range    = {{{0}}};
        seen[n].count        = 0;
        for (size_t k = 0; k < 3; k++) map_space_from_ws(&frame, corner_of(d->c, t, k), triangle.corners[k].at);
        if (map_sides_touch(sides, &triangle) && !map_space_behind(d->light, n, &triangle)) {
            map_sides_clip(sides, &triangle, &kept);
            for (int k = 0; k < MAP_SIDES; k++) range.n[k][3] = 1; /* always inside */
            if (isfinite(d->shape->range_metres)) {
                range.n[0][2] = -1;
                range.n[0][3] = d->shape->range_metres;
            }
            map_sides_clip(&range, &kept, &seen[n]);
            if (seen[n].count < 3) seen[n].count = 0;
        }

        all += areas[n] = polygon_area(&seen[n]);
    }
    if (!(all > 0)) return 0;
    for (double left = rng_unit(random) * all; map + 1 < maps && (!(areas[map] > 0) || left >= areas[map]); map++)
        left -= areas[map];
    if (!(areas[map] > 0)) return 0;
    map_frame frame = map_frame_of(d->light, map);
    point_in(&seen[map], areas[map], random, at);
    for (int axis = 0; axis < 3; axis++) out->at_ws[axis] = 0;
    for (int n = 0; n < 3; n++)
        vec3_mad(out->at_ws, (n == 2 ? at[n] * frame.unit : at[n]) - frame.rows[n][3], frame.rows[n], out->at_ws);
    out->along_metres = at[2];
    out->weight       = all;
    return light_reaches_by(d->shape, cosine, out->at_ws);
}

static int is_sun(const lit_points_desc *d)
{
    return d->shape->kind == LIGHT_DIRECTIONAL;
}

/* The casters that the light may reach; none without memory. */
static candidates candidates_of(const lit_points_desc *d)
{
    candidates k       = {0};
    uint8_t   *touched = malloc(casters_run_count(d->c) + 1);
    double     cosine = portable_cos(d->shape->outer_rad), sine = portable_sin(d->shape->outer_rad);
    size_t     step = 1;
    for (size_t run = 0; touched && run < casters_run_count(d->c); run++) {
        touched[run] = (uint8_t)(is_sun(d) || !d->c->runs || touches(d->shape, cosine, sine, &d->c->runs[run]));
        k.count += touched[run] ? casters_run_end(d->c, run) - run * CASTERS_RUN : 0; /* fewer if an object is left out */
    }
    if (d->triangles_max && k.count > d->triangles_max) step = (k.count + d->triangles_max - 1) / d->triangles_max;
    k.triangles = malloc((k.count / step + 1) * sizeof *k.triangles);
    k.area_to   = malloc((k.count / step + 1) * sizeof *k.area_to);
    k.count     = touched && k.triangles && k.area_to ? take(&k, d, touched, step) : 0;
    free(touched);
    return k;
}

static void point_of_sun(lit_point *out, const lit_points_desc *d, size_t t, rng *random)
{
    map_polygon triangle = {.count = 3};
    for (size_t i = 0; i < 3; i++) memcpy(triangle.corners[i].at, corner_of(d->c, t, i), sizeof triangle.corners[i].at);
    out->weight       = polygon_area(&triangle);
    out->along_metres = 0;
    point_in(&triangle, out->weight, random, out->at_ws);
}

size_t lit_points_choose(lit_point *points, size_t count, const lit_points_desc *d)
{
    candidates   k      = candidates_of(d);
    size_t       found  = 0;
    const int    sun    = is_sun(d);
    const double cosine = portable_cos(d->shape->outer_rad);
    map_sides    sides = map_sides_of(d->light, sun ? 0 : slope_of(d) / d->light->texel_metres - ldexp(0.5, (int)d->light->levels));
    if (k.count && !(k.area_to[k.count - 1] > 0)) k.count = 0;
    for (size_t n = 0; n < count && k.count; n++) {
        rng        random = rng_split(SEED, n);
        double     share  = ((double)(n / 2) + rng_unit(&random)) / (double)((count + 1) / 2);
        size_t     chosen = n % 2 ? (size_t)(share * (double)k.count) : candidate_at(&k, share);
        size_t     at     = chosen < k.count ? chosen : k.count - 1;
        double     area   = k.area_to[at] - (at ? k.area_to[at - 1] : 0);
        double     likely = 0.5 * area / k.area_to[k.count - 1] + 0.5 / (double)k.count;
        lit_point *p      = &points[found];
        p->triangle       = k.triangles[at];
        if (sun)
            point_of_sun(p, d, p->triangle, &random);
        else if (!point_of_punctual(p, d, &sides, cosine, p->triangle, &random))
            continue;
        p->weight /= likely * (double)count;
        found++;
    }
    free(k.triangles);
    free(k.area_to);
    return found;
}
