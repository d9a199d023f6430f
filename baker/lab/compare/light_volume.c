/* Random points in a baked light's volume and a box; see light_volume.h.
 *
 * Draw points in one of them, and reject those outside the other. If the light is bounded, draw in the smaller of the two. A
 * cone may be narrow in a large box, and may reach far beyond it, so its own volume is taken within the box:
 *
 *         light *        box +---------+
 *                 \ ` .      |         |        the cone's directions in cells of equal solid angle; a cell's probability is its
 *                   \   ` . t0- - - - -t1       volume in the box, t1^3 - t0^3; then a direction in the cell, and a distance
 *                     \      |` .      |        from t0 to t1
 *                       ` ...|.....` . |
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/light_volume.h"

#include <math.h>
#include <string.h>

#include "baker/base/vec3.h"
#include "baker/light/baked_light.h"
#include "runtime/vxs.h"

enum { TRIES = 100, CELL_PROBES_SIDE = 3 };

static const double pi = 3.14159265358979323846;

static int in_box(const light_volume *v, const double point_ws[3])
{
    for (int i = 0; i < 3; i++)
        if (point_ws[i] < v->box_ws.min[i] || point_ws[i] > v->box_ws.max[i]) return 0;
    return 1;
}

/* cones ----------------------------------------------------------------------------------------------- */

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
    *end   = v->shape.range_m;
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

/* Three times the volume along a direction, per solid angle. */
static double weight_of(const light_volume *v, double x, double y)
{
    double direction[3], begin, end;
    cone_direction(v, x, y, direction);
    return cross_box(v, direction, &begin, &end) ? end * end * end - begin * begin * begin : 0;
}

static void weigh_cells(light_volume *v)
{
    double sum = 0;
    for (int cell = 0; cell < VOLUME_CELLS; cell++) {
        v->cell_weight[cell] = 0;
        for (int n = 0; n < CELL_PROBES_SIDE * CELL_PROBES_SIDE; n++) {
            double x = (cell % VOLUME_CELLS_SIDE + (n % CELL_PROBES_SIDE + 0.5) / CELL_PROBES_SIDE) / VOLUME_CELLS_SIDE;
            double y = (cell / VOLUME_CELLS_SIDE + (n / CELL_PROBES_SIDE + 0.5) / CELL_PROBES_SIDE) / VOLUME_CELLS_SIDE;
            v->cell_weight[cell] += weight_of(v, x, y) / (CELL_PROBES_SIDE * CELL_PROBES_SIDE);
        }
        v->cell_sum[cell] = sum += v->cell_weight[cell];
    }
}

static int cell_at(const light_volume *v, double sum)
{
    int low = 0, high = VOLUME_CELLS - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (v->cell_sum[middle] > sum)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static int draw_from_cone(const light_volume *v, rng *r, double point_ws[3])
{
    int    cell = cell_at(v, rng_unit(r) * v->cell_sum[VOLUME_CELLS - 1]);
    double x    = (cell % VOLUME_CELLS_SIDE + rng_unit(r)) / VOLUME_CELLS_SIDE;
    double y    = (cell / VOLUME_CELLS_SIDE + rng_unit(r)) / VOLUME_CELLS_SIDE, direction[3], begin, end;
    cone_direction(v, x, y, direction);
    double kept = rng_unit(r), along = rng_unit(r);
    if (!cross_box(v, direction, &begin, &end)) return 0;

    /* directions of a cell are not equally likely: rejection by their volume */
    double volume = end * end * end - begin * begin * begin;
    if (kept * 2 * v->cell_weight[cell] > volume) return 0;
    vec3_mad(v->shape.position_ws, cbrt(begin * begin * begin + along * volume), direction, point_ws);
    return 1;
}

/* all of it ------------------------------------------------------------------------------------------- */

static void cone_axes(light_volume *v)
{
    double       *along = v->axes[2];
    const double *given = v->shape.direction_ws;
    memcpy(along, v->shape.kind == LIGHT_POINT ? (double[3]){0, 0, 1} : given, sizeof v->axes[2]);
    double beside[3] = {fabs(along[0]) < 0.5, fabs(along[0]) >= 0.5, 0};
    vec3_cross(along, beside, v->axes[0]);
    vec3_unit(v->axes[0], v->axes[0]);
    vec3_cross(along, v->axes[0], v->axes[1]);
}

/* For a small or distant box the cells are too coarse: then most of the box is in the cone, or none of it. */
static void choose_for_cone(light_volume *v, double box_volume)
{
    cone_axes(v);
    weigh_cells(v);
    double solid_angle = 2 * pi * (1 - cos(v->shape.kind == LIGHT_POINT ? pi : v->shape.outer_rad));
    double volume      = v->cell_sum[VOLUME_CELLS - 1] / VOLUME_CELLS * solid_angle / 3;
    v->way             = volume > 0 && volume < 0.3 * box_volume ? DRAW_FROM_CONE : DRAW_FROM_BOX;
}

/* A directional volume without a region is unbounded along the light, and was fitted to the box. */
static void choose_for_sun(light_volume *v, double box_volume)
{
    const double *m = v->light->ls_from_ws;
    double        across[3];
    vec3_cross(m, m + 4, across);
    double map_volume = ldexp(1, 3 * (int)v->light->levels) / fabs(vec3_dot(across, m + 8));
    v->way            = (v->light->flags & VXS_LIGHT_BOUNDED) && map_volume < box_volume ? DRAW_FROM_MAP : DRAW_FROM_BOX;
}

void light_volume_init(light_volume *v, const vxs_light *light, const box *box_ws)
{
    double box_volume = 1;
    v->light          = light;
    v->shape          = baked_light_shape(light);
    v->box_ws         = *box_ws;
    for (int i = 0; i < 3; i++) box_volume *= box_ws->max[i] - box_ws->min[i];
    if (v->shape.kind == LIGHT_DIRECTIONAL)
        choose_for_sun(v, box_volume);
    else
        choose_for_cone(v, box_volume);
}

static int draw_once(const light_volume *v, rng *r, double point_ws[3])
{
    int32_t voxel[3];
    if (v->way == DRAW_FROM_CONE) {
        if (!draw_from_cone(v, r, point_ws)) return 0;
    } else {
        double u[3] = {rng_unit(r), rng_unit(r), rng_unit(r)}, at[3];
        for (int i = 0; i < 3; i++) {
            at[i]       = ldexp(u[i], (int)v->light->levels);
            point_ws[i] = v->box_ws.min[i] + u[i] * (v->box_ws.max[i] - v->box_ws.min[i]);
        }
        if (v->way == DRAW_FROM_MAP) vxs_point(v->light, 0, at, point_ws);
    }
    return in_box(v, point_ws) && vxs_voxel(v->light, point_ws, NULL, 1, voxel) >= 0;
}

int light_volume_draw(const light_volume *v, rng *r, double point_ws[3])
{
    for (int n = 0; n < TRIES; n++)
        if (draw_once(v, r, point_ws)) return 1;
    return 0;
}
