/* Shadow rays by Embree, one from the centre of each voxel that a filter queries; see rival.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "runtime/vxs.h"
#include "tests/bench/rival.h"

typedef struct tracer {
    truth      *rays;
    light_shape shape;
    double      origin_ws[3], step_ws[3][3]; /* the corner of voxel (0, 0, 0), and the way to the next in i, j and k */
    int32_t     side;
} tracer;

static vxs_result rays_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    run_context m = {0};
    tracer     *t = calloc(1, sizeof *t);
    (void)options;
    (void)file;
    if (!t) return VXS_E_MEMORY;
    t->side       = 1 << maps->levels;
    t->shape.kind = LIGHT_DIRECTIONAL;
    memcpy(t->shape.direction_ws, maps->light.direction_ws, sizeof t->shape.direction_ws);
    vxs_point(&maps->light, 0, (const double[3]){0, 0, 0}, t->origin_ws);
    for (int axis = 0; axis < 3; axis++) {
        double one[3] = {axis == 0, axis == 1, axis == 2};
        vxs_point(&maps->light, 0, one, t->step_ws[axis]);
        for (int n = 0; n < 3; n++) t->step_ws[axis][n] -= t->origin_ws[n];
    }
    vxs_result r = truth_create(&t->rays, &maps->casters, 1, &m);
    run_free(&m);
    if (r != VXS_OK)
        free(t);
    else
        *asset = (rival_asset){.state = t};
    return r;
}

static uint32_t is_dark(const tracer *t, double i, double j, double k)
{
    double point_ws[3];
    for (int n = 0; n < 3; n++) point_ws[n] = t->origin_ws[n] + i * t->step_ws[0][n] + j * t->step_ws[1][n] + k * t->step_ws[2][n];
    return !truth_lit(t->rays, point_ws, &t->shape);
}

static void rays_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const tracer *t = state;
    for (size_t n = 0; n < count; n++) {
        tap_box box = tap_box_at(at[n], filter.width_px, t->side);
        dark[n]     = 0;
        for (int32_t y = box.y0; y < box.y1; y++)
            for (int32_t x = box.x0; x < box.x1; x++) dark[n] += is_dark(t, x + 0.5, y + 0.5, at[n].k + 0.5);
    }
}

static void rays_close(void *state)
{
    tracer *t = state;
    truth_destroy(t->rays);
    free(t);
}

const rival ray_rivals[] = {
    {"Embree shadow rays", "a ray for each tap; built: the tree of triangles", NULL, RIVAL_RAYS, NULL, rays_open, rays_count_dark,
     rays_close},
    {.name = NULL},
};
