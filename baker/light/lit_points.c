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

vxs_result reach_init(reach_index *x, const casters *c, run_context *m)
{
    x->run_count = (c->triangle_count + REACH_RUN - 1) / REACH_RUN;
    x->runs      = malloc((x->run_count + 1) * sizeof *x->runs);
    if (!x->runs) return fail(m, VXS_E_MEMORY, "out of memory for the reach of lights");
    for (size_t n = 0; n < x->run_count; n++) {
        box    around = box_empty();
        double size[3];
        for (size_t k = 3 * n * REACH_RUN; k < 3 * (n + 1) * REACH_RUN && k < 3 * c->triangle_count; k++)
            box_add(&around, c->positions_ws + 3 * (size_t)c->indices[k]);
        vec3_sub(around.max, around.min, size);
        vec3_mad(around.min, 0.5, size, x->runs[n].center_ws);
        x->runs[n].radius_metres = 0.5 * sqrt(vec3_dot(size, size)) * (1 + 1e-9) + 1e-12;
    }
    return VXS_OK;
}

void reach_free(reach_index *x)
{
    free(x->runs);
    memset(x, 0, sizeof *x);
}

static int touches_cone(const reach_run *run, const light_shape *light, double slope)
{
    double from[3], across[3];
    vec3_sub(run->center_ws, light->position_ws, from);
    double along = vec3_dot(from, light->direction_ws);
    vec3_mad(from, -along, light->direction_ws, across);
    double beside = sqrt(vec3_dot(across, across)) - along * slope; /* distance from the axis minus the cone's radius */
    return along > -run->radius_metres && beside <= run->radius_metres * sqrt(1 + slope * slope);
}

/* arrays of the casters that are kept ------------------------------------------------------------------------------------------ */

typedef struct selection {
    casters       *out;
    const casters *c;
    uint32_t      *slot; /* [c->vertex_count] 1 + vertex number in out; 0: not copied yet */
} selection;

static uint32_t keep_vertex(selection *k, uint32_t vertex)
{
    if (!k->slot[vertex]) {
        memcpy(k->out->positions_ws + 3 * k->out->vertex_count, k->c->positions_ws + 3 * (size_t)vertex, 3 * sizeof(double));
        k->slot[vertex] = (uint32_t)++k->out->vertex_count;
    }
    return k->slot[vertex] - 1;
}

static void keep_runs(selection *k, const uint8_t *kept, size_t run_count)
{
    casters       *out = k->out;
    const casters *c   = k->c;
    for (size_t n = 0; n < run_count; n++)
        for (size_t t = n * REACH_RUN; t < (n + 1) * REACH_RUN && t < c->triangle_count && kept[n]; t++) {
            size_t to = out->triangle_count++;
            for (size_t i = 0; i < 3; i++) out->indices[3 * to + i] = keep_vertex(k, c->indices[3 * t + i]);
            if (t < c->solid_triangle_count && c->solid_meets) out->solid_meets[to] = c->solid_meets[t];
            if (t < c->solid_triangle_count) out->solid_triangle_count = to + 1;
            if (c->double_sided) out->double_sided[to] = c->double_sided[t];
            if (t < c->holed_first) {
                out->holed_first = to + 1;
                continue;
            }
            memcpy(out->hole_uvs + 6 * (to - out->holed_first), c->hole_uvs + 6 * (t - c->holed_first), 6 * sizeof *c->hole_uvs);
            size_t mask = 0;
            while (t >= c->alpha_mask_first[mask + 1]) mask++;
            out->alpha_mask_first[mask + 1]++;
        }
    if (!out->alpha_mask_first) return;
    /* prefix sums: counts of each mask become first indices */
    out->alpha_mask_first[0] = out->holed_first;
    for (size_t mask = 0; mask < out->alpha_mask_count; mask++) out->alpha_mask_first[mask + 1] += out->alpha_mask_first[mask];
}

static int allocate(selection *k, size_t triangles)
{
    casters       *out    = k->out;
    const casters *c      = k->c;
    out->alpha_mask_count = c->alpha_mask_count;
    out->alpha_masks      = c->alpha_masks;
    out->images           = c->images;
    out->positions_ws     = malloc((9 * triangles + 1) * sizeof *out->positions_ws);
    out->indices          = malloc((3 * triangles + 1) * sizeof *out->indices);
    out->hole_uvs         = malloc((6 * triangles + 1) * sizeof *out->hole_uvs);
    out->alpha_mask_first = calloc(c->alpha_mask_count + 1, sizeof *out->alpha_mask_first);
    out->solid_meets      = c->solid_meets ? malloc(triangles + 1) : NULL;
    out->double_sided     = c->double_sided ? malloc(triangles + 1) : NULL;
    k->slot               = calloc(c->vertex_count + 1, sizeof *k->slot);
    return out->positions_ws && out->indices && out->hole_uvs && out->alpha_mask_first && k->slot &&
           (out->solid_meets || !c->solid_meets) && (out->double_sided || !c->double_sided);
}

vxs_result reach_casters(casters *out, const reach_index *x, const casters *c, const light_shape *light, run_context *m)
{
    *out = *c;
    if (light->kind != LIGHT_SPOT || light->outer_rad > PUNCTUAL_SPOT_MAX_RAD) return VXS_OK;
    uint8_t  *kept  = malloc(x->run_count + 1);
    size_t    count = 0;
    /* of a cone around the whole map: its corners and its border, which is at most an eighth of the map's side at each side;
     * rounded up a little */
    double    slope = portable_tan(light->outer_rad) * (4.0 / 3) * sqrt(2) * 1.02;
    selection k     = {.out = out, .c = c};
    int       ok    = kept != NULL;
    for (size_t n = 0; n < x->run_count && kept; n++) count += kept[n] = (uint8_t)touches_cone(&x->runs[n], light, slope);
    if (kept && count == x->run_count) goto done;

    memset(out, 0, sizeof *out);
    if ((ok = kept && allocate(&k, count * REACH_RUN))) keep_runs(&k, kept, x->run_count);
done:
    free(k.slot);
    free(kept);
    if (ok) return VXS_OK;
    reach_release(out, c);
    return fail(m, VXS_E_MEMORY, "out of memory for the casters that a light reaches");
}

void reach_release(casters *out, const casters *c)
{
    if (out->positions_ws != c->positions_ws) {
        free(out->positions_ws);
        free(out->indices);
        free(out->hole_uvs);
        free(out->alpha_mask_first);
        free(out->solid_meets);
        free(out->double_sided);
    }
    memset(out, 0, sizeof *out);
}

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

/* 1 when a ball may be in reach. The caller computes cosine and sine of the cone once. */
static int touches(const light_shape *shape, double cosine, double sine, const reach_run *run)
{
    double way[3], r = run->radius_metres;
    if (shape->kind == LIGHT_DIRECTIONAL) return 1;
    vec3_sub(run->center_ws, shape->position_ws, way);
    double square = vec3_dot(way, way);
    if (square > (shape->range_metres + r) * (shape->range_metres + r)) return 0;
    if (shape->kind == LIGHT_POINT) return 1;
    double along = vec3_dot(way, shape->direction_ws), beside = square - along * along;
    return along > -r && sqrt(beside > 0 ? beside : 0) * cosine - along * sine <= r;
}

static size_t end_of_run(const lit_points_desc *d, size_t run)
{
    return (run + 1) * REACH_RUN < d->c->triangle_count ? (run + 1) * REACH_RUN : d->c->triangle_count;
}

/* Take every step-th triangle of the touched runs. Returns how many. */
static size_t take(candidates *out, const lit_points_desc *d, const uint8_t *touched, size_t step)
{
    const casters *c     = d->c;
    size_t         count = 0, until_next = 1;
    double         area = 0;
    for (size_t run = 0; run < d->reach->run_count; run++) {
        size_t end = touched[run] ? end_of_run(d, run) : 0;
        for (size_t t = run * REACH_RUN; t < end; t++) {
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

size_t lit_points_choose(lit_point *points, size_t count, const lit_points_desc *d)
{
    candidates k     = {0};
    size_t     found = 0;
    int        sun   = d->shape->kind == LIGHT_DIRECTIONAL;
    map_sides  sides = map_sides_of(d->light, sun ? 0 : slope_of(d) / d->light->texel_metres - ldexp(0.5, (int)d->light->levels));

    uint8_t *touched = malloc(d->reach->run_count + 1);
    double   cosine = portable_cos(d->shape->outer_rad), sine = portable_sin(d->shape->outer_rad);
    size_t   step = 1;
    for (size_t run = 0; touched && run < d->reach->run_count; run++) {
        touched[run] = (uint8_t)touches(d->shape, cosine, sine, &d->reach->runs[run]);
        k.count += touched[run] ? end_of_run(d, run) - run * REACH_RUN : 0; /* fewer if an object is left out */
    }
    if (d->triangles_max && k.count > d->triangles_max) step = (k.count + d->triangles_max - 1) / d->triangles_max;
    k.triangles = malloc((k.count / step + 1) * sizeof *k.triangles);
    k.area_to   = malloc((k.count / step + 1) * sizeof *k.area_to);
    k.count     = touched && k.triangles && k.area_to ? take(&k, d, touched, step) : 0;
    free(touched);
    if (!(k.count && k.area_to[k.count - 1] > 0)) goto done;

    for (size_t n = 0; n < count; n++) {
        rng        random = rng_split(SEED, n);
        double     share  = ((double)(n / 2) + rng_unit(&random)) / (double)((count + 1) / 2);
        size_t     chosen = n % 2 ? (size_t)(share * (double)k.count) : candidate_at(&k, share);
        size_t     at     = chosen < k.count ? chosen : k.count - 1;
        double     area   = k.area_to[at] - (at ? k.area_to[at - 1] : 0);
        double     likely = 0.5 * area / k.area_to[k.count - 1] + 0.5 / (double)k.count;
        lit_point *p      = &points[found];
        p->triangle       = k.triangles[at];
        if (sun) {
            const casters *c        = d->c;
            size_t         t        = p->triangle;
            map_polygon    triangle = {.count = 3};
            for (size_t i = 0; i < 3; i++)
                for (int axis = 0; axis < 3; axis++) triangle.corners[i].at[axis] = corner_of(c, t, i)[axis];
            p->weight       = polygon_area(&triangle);
            p->along_metres = 0;
            point_in(&triangle, p->weight, &random, p->at_ws);
        } else if (!point_of_punctual(p, d, &sides, cosine, p->triangle, &random))
            continue;
        p->weight /= likely * (double)count;
        found++;
    }
done:
    free(k.triangles);
    free(k.area_to);
    return found;
}
