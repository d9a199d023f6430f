/* Fog along a ray; see fog.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/picture/fog.h"

#include <math.h>

#include "baker/base/vec3.h"
#include "runtime/volumes/vxs_air.h"
#include "runtime/vxs_query.h"

enum { INTERVALS = 32 }; /* asked for at a time */

typedef struct eye_ray {
    vxs_medium    medium;
    const double *eye_ws, *direction;
    double        part[2]; /* in fog */
} eye_ray;

static eye_ray ray_in_fog(const fog_medium *f, const double eye_ws[3], const double direction[3], double metres)
{
    eye_ray r = {{.anisotropy = f->anisotropy}, eye_ws, direction, {0, metres}};
    for (int i = 0; i < 3; i++) {
        r.medium.scattering[i] = f->scattering[i];
        r.medium.extinction[i] = f->extinction[i];
    }
    if (f->top_ws < INFINITY) vxs_air_in_fog(eye_ws[1], direction[1], f->top_ws, r.part);
    return r;
}

static void add_times(double sum[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++) sum[i] += a[i] * b[i];
}

static void add_sun(const fog_medium *f, const fog_light *light, const eye_ray *r, double begin, double end, double airlight[3])
{
    double to_sun[3] = {-light->shape.direction_ws[0], -light->shape.direction_ws[1], -light->shape.direction_ws[2]};
    double cosine = vec3_dot(r->direction, to_sun), way = begin, slope = 1, found[3];
    if (f->top_ws < INFINITY) {
        if (!(to_sun[1] > 0)) return; /* from below it has come through fog without end */
        way   = begin - r->part[0] + (f->top_ws - r->eye_ws[1] - r->direction[1] * begin) / to_sun[1];
        slope = 1 - r->direction[1] / to_sun[1];
    }
    vxs_air_sun(&r->medium, cosine, end - begin, way, slope, found);
    add_times(airlight, light->colour, found);
}

static vxs_air_ray pass_lamp(const fog_light *light, const eye_ray *r)
{
    double to_lamp[3];
    vec3_sub(light->shape.position_ws, r->eye_ws, to_lamp);
    if (light->shape.kind == LIGHT_POINT) return vxs_air_ray_of(to_lamp, r->direction, light->radius_metres);
    return vxs_air_ray_of_spot(to_lamp, r->direction, light->radius_metres, light->shape.direction_ws, light->cos_inner,
                               cos(light->shape.outer_rad));
}

/* Where a map ends, the sun shines on, and a lamp does not. */
static void add_light(const fog_medium *f, const fog_light *light, const eye_ray *r, double airlight[3])
{
    int          is_sun = light->shape.kind == LIGHT_DIRECTIONAL;
    vxs_ray      ray    = {.t_begin = r->part[0], .t_end = r->part[1]};
    vxs_air_ray  passed = {0};
    vxs_lit_walk walk;
    vxs_interval found[INTERVALS];
    size_t       count = INTERVALS;
    for (int i = 0; i < 3; i++) {
        ray.origin_ws[i]    = r->eye_ws[i];
        ray.direction_ws[i] = r->direction[i];
    }
    if (!is_sun) passed = pass_lamp(light, r);
    if (vxs_lit_begin(&walk, light->light, &ray) != VXS_OK) return;
    while (count == INTERVALS) {
        count = vxs_lit_next(&walk, found, INTERVALS);
        for (size_t n = 0; n < count; n++) {
            const vxs_interval *at = &found[n];
            double              lamp[3];
            if (is_sun && at->state != VXS_INTERVAL_SHADOW)
                add_sun(f, light, r, at->t_begin, at->t_end, airlight);
            else if (!is_sun && at->state == VXS_INTERVAL_LIT) {
                vxs_air_lamp(&r->medium, &passed, at->t_begin, at->t_end - at->t_begin, lamp);
                add_times(airlight, light->colour, lamp);
            }
        }
    }
}

void fog_add_airlight(const fog_medium *f, const fog_light *lights, uint32_t light_count, const double eye_ws[3],
                      const double direction[3], double metres, double airlight[3])
{
    eye_ray r = ray_in_fog(f, eye_ws, direction, metres);
    if (!(r.part[1] > r.part[0])) return;
    for (uint32_t n = 0; n < light_count; n++) add_light(f, &lights[n], &r, airlight);
}

void fog_left(const fog_medium *f, const double eye_ws[3], const double direction[3], double metres, double left[3])
{
    eye_ray r = ray_in_fog(f, eye_ws, direction, metres);
    vxs_air_left(&r.medium, fmax(0, r.part[1] - r.part[0]), left);
}
