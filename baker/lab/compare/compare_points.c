/* Points that are drawn, and points that are seen; see compare_points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <math.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/light/baked_light.h"
#include "runtime/vxs.h"

enum { TRIES = 20 };

/* Bounds of all triangles, 5 % larger; a flat scene gets some height, too. */
static box measure_box(const casters *c)
{
    box    b = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double extent[3];
    vec3_sub(b.max, b.min, extent);
    double diagonal = box_diagonal(&b);
    for (int i = 0; i < 3; i++) {
        double margin = fmax(0.025 * extent[i], 0.01 * diagonal);
        b.min[i] -= margin;
        b.max[i] += margin;
    }
    return b;
}

void compare_picture_size(uint32_t points, uint32_t *width_px, uint32_t *height_px)
{
    *height_px = (uint32_t)fmax(1, floor(sqrt(points / COMPARE_CAMERA_ASPECT)));
    *width_px  = points / *height_px;
}

void comparison_init(comparison *out, const truth *t, const casters *c, const vxs_baked_light *baked, const compare_options *o)
{
    const vxs_light *light  = &baked->light;
    box              box_ws = measure_box(c);
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

static int random_sample(const comparison *c, rng *r, sample *s)
{
    int32_t voxel[3];
    if (!light_volume_draw(&c->volume, r, s->point_ws)) return 0;
    s->normal = NULL;
    s->map    = vxs_voxel(c->light, s->point_ws, NULL, 1, voxel);
    baked_light_coordinates(c->light, s->map, s->point_ws, s->truth_ls);
    memcpy(s->truth_ws, s->point_ws, sizeof s->truth_ws);
    return 1;
}

/* Fill a sample from its point and normal. Returns 0 when the light does not reach the point. */
static int finish_surface_sample(const comparison *c, sample *s)
{
    int32_t voxel[3];
    s->normal = s->normal_ws;
    s->map    = vxs_voxel(c->light, s->point_ws, s->normal_ws, 1, voxel);
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

/* A spot may reach only a small part of the casters: try again, and finally sample along its own rays. */
static int surface_sample(const comparison *c, rng *r, sample *s)
{
    if (c->light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return sample_by_area(c, r, s);
    int found = 0;
    for (int n = 0; n < TRIES && !found; n++) found = sample_by_area(c, r, s);
    for (int n = 0; n < TRIES && !found; n++) found = sample_along_light(c, r, s);
    return found;
}

/* The surface at a pixel's centre, with the normal towards the eye. */
static int camera_sample(const comparison *c, size_t pixel, sample *s)
{
    const double *eye_ws = c->options->camera->eye_ws;
    double        x      = ((double)(pixel % c->width_px) + 0.5) / c->width_px;
    double        y      = ((double)(pixel / c->width_px) + 0.5) / c->height_px;
    double        way_ws[3], distance;
    camera_direction(&c->view, x, y, way_ws);
    if (!truth_first_hit(c->truth, eye_ws, way_ws, &distance, s->normal_ws, NULL)) return 0;
    vec3_mad(eye_ws, distance, way_ws, s->point_ws);
    if (vec3_dot(s->normal_ws, way_ws) > 0) turn_normal(s);
    return finish_surface_sample(c, s);
}

int compare_point(const comparison *c, compare_kind kind, size_t index, sample *s)
{
    if (kind == COMPARE_CAMERA) return camera_sample(c, index, s);
    rng all = rng_split(c->options->seed, (uint64_t)kind);
    rng r   = rng_split(all.state, index);
    return kind == COMPARE_SURFACE ? surface_sample(c, &r, s) : random_sample(c, &r, s);
}

int compare_lit_at(const comparison *c, int map, double u, double v, double depth)
{
    double p[3];
    vxs_point(c->light, map, (double[3]){u, v, depth}, p);
    return truth_lit(c->truth, p, &c->shape);
}
