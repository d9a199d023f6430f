/* The points of a comparison, and random points of a light's volume; see compare_points.h.
 *
 * Random points of a volume: draw points in the box or in the light's volume, and reject those outside the other. If the light is
 * bounded, draw in the smaller of the two. A cone may be narrow in a large box, and may reach far beyond it, so its own volume is
 * taken within the box:
 *
 *         light *        box +---------+
 *                 \ ` .      |         |        the cone's directions in cells of equal solid angle; a cell's probability is its
 *                   \   ` . t0- - - - -t1       volume in the box, t1^3 - t0^3; then a direction in the cell, and a distance
 *                     \      |` .      |        from t0 to t1
 *                       ` ...|.....` . |
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <math.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/light/map_space.h"
#include "runtime/vxs.h"

/* random points of a volume ---------------------------------------------------------------------------------------------------- */

enum { VOLUME_TRIES = 100, CELL_PROBES_SIDE = 3 };

static const double pi = 3.14159265358979323846;

/* cones ------------------------------------------------------------------------------------------------------------------------ */

/* A direction of the cone from x and y in [0, 1): angle around the axis, and away from it, uniform in solid angle. */
static void cone_direction(const light_volume *v, double x, double y, double direction_ws[3])
{
    double sunk = y * (1 - cos(v->shape.kind == LIGHT_POINT ? pi : v->shape.outer_rad)), wide = sqrt(sunk * (2 - sunk));
    for (int i = 0; i < 3; i++)
        direction_ws[i] = wide * (cos(2 * pi * x) * v->axes[0][i] + sin(2 * pi * x) * v->axes[1][i]) + (1 - sunk) * v->axes[2][i];
}

/* The interval of a ray from the light that is in the box and in range. Returns 0 when it is empty. */
static int cross_box(const light_volume *v, const double direction_ws[3], double *begin, double *end)
{
    *begin = 0;
    *end   = v->shape.range_metres;
    for (int i = 0; i < 3; i++) {
        double to_min = v->box_ws.min[i] - v->shape.position_ws[i], to_max = v->box_ws.max[i] - v->shape.position_ws[i];
        if (direction_ws[i] == 0) {
            if (to_min > 0 || to_max < 0) return 0;
            continue;
        }
        *begin = fmax(*begin, fmin(to_min / direction_ws[i], to_max / direction_ws[i]));
        *end   = fmin(*end, fmax(to_min / direction_ws[i], to_max / direction_ws[i]));
    }
    return *begin < *end;
}

/* box or cone ------------------------------------------------------------------------------------------------------------------ */

void light_volume_init(light_volume *v, const vxs_light *light, const box *box_ws)
{
    double box_volume = 1;
    v->light          = light;
    v->shape          = baked_light_shape(light);
    v->box_ws         = *box_ws;
    for (int i = 0; i < 3; i++) box_volume *= box_ws->max[i] - box_ws->min[i];
    if (v->shape.kind == LIGHT_DIRECTIONAL) {
        /* without a region, the volume of a sun is unbounded along the light, and was fitted to the box */
        const double *m = v->light->ls_from_ws;
        double        across[3];
        vec3_cross(m, m + 4, across);
        double map_volume = ldexp(1, 3 * (int)v->light->levels) / fabs(vec3_dot(across, m + 8));
        v->way            = (v->light->flags & VXS_LIGHT_BOUNDED) && map_volume < box_volume ? DRAW_FROM_MAP : DRAW_FROM_BOX;
    } else {
        double       *along = v->axes[2];
        const double *given = v->shape.direction_ws;
        memcpy(along, v->shape.kind == LIGHT_POINT ? (double[3]){0, 0, 1} : given, sizeof v->axes[2]);
        double beside[3] = {fabs(along[0]) < 0.5, fabs(along[0]) >= 0.5, 0};
        vec3_cross(along, beside, v->axes[0]);
        vec3_unit(v->axes[0], v->axes[0]);
        vec3_cross(along, v->axes[0], v->axes[1]);

        double sum = 0;
        for (int cell = 0; cell < VOLUME_CELLS; cell++) {
            v->cell_weight[cell] = 0;
            for (int n = 0; n < CELL_PROBES_SIDE * CELL_PROBES_SIDE; n++) {
                double x = (cell % VOLUME_CELLS_SIDE + (n % CELL_PROBES_SIDE + 0.5) / CELL_PROBES_SIDE) / VOLUME_CELLS_SIDE;
                double y = (cell / VOLUME_CELLS_SIDE + (n / CELL_PROBES_SIDE + 0.5) / CELL_PROBES_SIDE) / VOLUME_CELLS_SIDE;
                double direction[3], begin, end;
                cone_direction(v, x, y, direction);
                if (cross_box(v, direction, &begin, &end)) /* three times the volume along the direction, per solid angle */
                    v->cell_weight[cell] += (end * end * end - begin * begin * begin) / (CELL_PROBES_SIDE * CELL_PROBES_SIDE);
            }
            v->cell_sum[cell] = sum += v->cell_weight[cell];
        }

        /* for a small or distant box the cells are too coarse: then most of the box is in the cone, or none of it */
        double solid_angle = 2 * pi * (1 - cos(v->shape.kind == LIGHT_POINT ? pi : v->shape.outer_rad));
        double volume      = v->cell_sum[VOLUME_CELLS - 1] / VOLUME_CELLS * solid_angle / 3;
        v->way             = volume > 0 && volume < 0.3 * box_volume ? DRAW_FROM_CONE : DRAW_FROM_BOX;
    }
}

static int draw_once(const light_volume *v, rng *r, double point_ws[3])
{
    int32_t voxel[3];
    if (v->way == DRAW_FROM_CONE) {
        double sum  = rng_unit(r) * v->cell_sum[VOLUME_CELLS - 1];
        int    cell = 0, high = VOLUME_CELLS - 1;
        while (cell < high) {
            int middle = (cell + high) / 2;
            if (v->cell_sum[middle] > sum)
                high = middle;
            else
                cell = middle + 1;
        }

        double x = (cell % VOLUME_CELLS_SIDE + rng_unit(r)) / VOLUME_CELLS_SIDE;
        double y = (cell / VOLUME_CELLS_SIDE + rng_unit(r)) / VOLUME_CELLS_SIDE, direction[3], begin, end;
        cone_direction(v, x, y, direction);
        double kept = rng_unit(r), along = rng_unit(r);
        if (!cross_box(v, direction, &begin, &end)) return 0;

        /* directions of a cell are not equally likely: rejection by their volume */
        double volume = end * end * end - begin * begin * begin;
        if (kept * 2 * v->cell_weight[cell] > volume) return 0;
        vec3_mad(v->shape.position_ws, cbrt(begin * begin * begin + along * volume), direction, point_ws);
    } else {
        double u[3] = {rng_unit(r), rng_unit(r), rng_unit(r)}, at[3];
        for (int i = 0; i < 3; i++) {
            at[i]       = ldexp(u[i], (int)v->light->levels);
            point_ws[i] = v->box_ws.min[i] + u[i] * (v->box_ws.max[i] - v->box_ws.min[i]);
        }
        if (v->way == DRAW_FROM_MAP) vxs_point(v->light, 0, at, point_ws);
    }
    for (int i = 0; i < 3; i++)
        if (point_ws[i] < v->box_ws.min[i] || point_ws[i] > v->box_ws.max[i]) return 0;
    return vxs_voxel(v->light, point_ws, NULL, vxs_box(1), voxel) >= 0;
}

int light_volume_draw(const light_volume *v, rng *r, double point_ws[3])
{
    for (int n = 0; n < VOLUME_TRIES; n++)
        if (draw_once(v, r, point_ws)) return 1;
    return 0;
}

/* points of each kind ---------------------------------------------------------------------------------------------------------- */

enum { TRIES = 20 };

void compare_picture_size(uint32_t points, uint32_t *width_px, uint32_t *height_px)
{
    *height_px = (uint32_t)fmax(1, floor(sqrt(points / COMPARE_CAMERA_ASPECT)));
    *width_px  = points / *height_px;
}

void comparison_init(comparison *out, const truth *t, const casters *c, const vxs_baked_light *baked, const compare_options *o)
{
    const vxs_light *light = &baked->light;

    /* bounds of all triangles, 5 % larger; a flat scene gets some height, too */
    box    box_ws = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double extent[3];
    vec3_sub(box_ws.max, box_ws.min, extent);
    double diagonal = box_diagonal(&box_ws);
    for (int i = 0; i < 3; i++) {
        double margin = fmax(0.025 * extent[i], 0.01 * diagonal);
        box_ws.min[i] -= margin;
        box_ws.max[i] += margin;
    }

    *out = (comparison){.truth = t, .casters = c, .baked = baked, .light = light, .shape = baked_light_shape(light), .options = o};
    light_volume_init(&out->volume, light, &box_ws);
    if (!o->camera) return;
    compare_picture_size(o->points, &out->width_px, &out->height_px);
    out->view = camera_view_of(o->camera, COMPARE_CAMERA_ASPECT);
}

size_t compare_point_count(const comparison *c, compare_kind kind)
{
    return kind == COMPARE_CAMERA ? (size_t)c->width_px * c->height_px : c->options->points;
}

/* Fill a sample from its point and normal. Returns 0 when the light does not reach the point. */
static int finish_surface_sample(const comparison *c, sample *s)
{
    int32_t voxel[3];
    s->normal = s->normal_ws;
    s->map    = vxs_voxel(c->light, s->point_ws, s->normal_ws, vxs_box(1), voxel);
    if (s->map < 0) return 0;
    truth_lift(c->truth, s->point_ws, s->normal_ws, s->truth_ws);
    baked_light_coordinates(c->light, s->map, s->truth_ws, s->truth_ls);
    return 1;
}

static void turn_normal(sample *s)
{
    for (int i = 0; i < 3; i++) s->normal_ws[i] = -s->normal_ws[i];
}

/* Choose a random side of a sheet, or the outer side of a solid. */
static int finish_drawn_sample(const comparison *c, uint32_t triangle, rng *r, sample *s)
{
    if (triangle >= c->casters->solid_triangle_count && rng_below(r, 2)) turn_normal(s);
    return finish_surface_sample(c, s);
}

static int sample_by_area(const comparison *c, rng *r, sample *s)
{
    double   uniforms[3] = {rng_unit(r), rng_unit(r), rng_unit(r)};
    uint32_t triangle;
    return truth_sample_surface(c->truth, uniforms, s->point_ws, s->normal_ws, &triangle) && finish_drawn_sample(c, triangle, r, s);
}

/* A sample at the first surface behind a random point of the light's volume. */
static int sample_along_light(const comparison *c, rng *r, sample *s)
{
    double   from_ws[3], way_ws[3], distance;
    uint32_t triangle;
    if (!light_volume_draw(&c->volume, r, from_ws)) return 0;
    vec3_sub(from_ws, c->shape.position_ws, way_ws);
    if (!vec3_unit(way_ws, way_ws)) return 0;
    if (!truth_first_hit(c->truth, from_ws, way_ws, &distance, s->normal_ws, &triangle)) return 0;
    vec3_mad(from_ws, distance, way_ws, s->point_ws);
    return finish_drawn_sample(c, triangle, r, s);
}

int compare_point(const comparison *c, compare_kind kind, size_t index, sample *s)
{
    if (kind == COMPARE_CAMERA) {
        /* the surface at a pixel's centre, with the normal towards the eye */
        const double *eye_ws = c->options->camera->eye_ws;
        double        x      = ((double)(index % c->width_px) + 0.5) / c->width_px;
        double        y      = ((double)(index / c->width_px) + 0.5) / c->height_px;
        double        way_ws[3], distance;
        camera_direction(&c->view, x, y, way_ws);
        if (!truth_first_hit(c->truth, eye_ws, way_ws, &distance, s->normal_ws, NULL)) return 0;
        vec3_mad(eye_ws, distance, way_ws, s->point_ws);
        if (vec3_dot(s->normal_ws, way_ws) > 0) turn_normal(s);
        return finish_surface_sample(c, s);
    }
    rng all = rng_split(c->options->seed, (uint64_t)kind);
    rng r   = rng_split(all.state, index);
    if (kind == COMPARE_RANDOM) {
        int32_t voxel[3];
        if (!light_volume_draw(&c->volume, &r, s->point_ws)) return 0;
        s->normal = NULL;
        s->map    = vxs_voxel(c->light, s->point_ws, NULL, vxs_box(1), voxel);
        baked_light_coordinates(c->light, s->map, s->point_ws, s->truth_ls);
        memcpy(s->truth_ws, s->point_ws, sizeof s->truth_ws);
        return 1;
    }
    if (c->light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return sample_by_area(c, &r, s);
    int found = 0; /* a spot may reach only a small part of the casters: try again, and finally sample along its own rays */
    for (int n = 0; n < TRIES && !found; n++) found = sample_by_area(c, &r, s);
    for (int n = 0; n < TRIES && !found; n++) found = sample_along_light(c, &r, s);
    return found;
}

int compare_lit_at(const comparison *c, int map, double u, double v, double depth)
{
    double p[3];
    vxs_point(c->light, map, (double[3]){u, v, depth}, p);
    return truth_lit(c->truth, p, &c->shape);
}
