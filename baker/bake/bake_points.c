/* Random points on casters; see bake_points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_points.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/box.h"
#include "runtime/volumes/vxs_area_light.h"

/* Positions are rounded to this share of the distance between points, much less than the drawn width of a point. */
#define ROUNDED_TO (1.0 / 32)

/* Floats relative to the centre of the triangles. */
static double scatter(const casters *c, uint32_t count, double *places_ws, float *positions, vxs_area_point *points)
{
    box    b = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double middle_ws[3];
    for (int n = 0; n < 3; n++) middle_ws[n] = 0.5 * (b.min[n] + b.max[n]);
    for (size_t n = 0; n < 3 * c->vertex_count; n++) positions[n] = (float)(c->positions_ws[n] - middle_ws[n % 3]);
    double area = vxs_area_scatter(positions, c->indices, (uint32_t)c->triangle_count, points, count);
    for (uint32_t n = 0; n < count; n++)
        for (size_t i = 0; i < 3; i++) places_ws[3 * (size_t)n + i] = middle_ws[i] + (double)points[n].place[i];
    return area;
}

vxs_result bake_points(vxs_points_view *view, const casters *c, uint32_t count, message *m)
{
    double         *places_ws = malloc(3 * (size_t)count * sizeof *places_ws);
    float          *positions = malloc(3 * c->vertex_count * sizeof *positions);
    vxs_area_point *points    = calloc(count, sizeof *points);
    vxs_result      r         = VXS_E_MEMORY;
    double          area      = places_ws && positions && points ? scatter(c, count, places_ws, positions, points) : 0;
    if (!places_ws || !positions || !points)
        fail(m, r, "out of memory for %u points", count);
    else
        r = area > 0 ? VXS_OK : fail(m, VXS_E_SCENE, "--points %u: the triangles have no area", count);
    *view = (vxs_points_view){places_ws, count, area / count, ROUNDED_TO * sqrt(area / count)};
    free(positions);
    free(points);
    return r;
}
