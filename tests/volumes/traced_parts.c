/* Lit parts by asking; see traced_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/traced_parts.h"

#include <math.h>

#include "baker/base/vec3.h"

int traced_scene_lit(const void *subject, const double point[3])
{
    const traced_scene *s = subject;
    return truth_lit(s->truth, point, s->shape);
}

static int lit_at(const traced_light *light, const eye_ray *ray, double x)
{
    double point[3];
    vec3_mad(ray->eye, x, ray->direction, point);
    return light->lit(light->user, point);
}

/* Sample n of light->samples, of which the first and the last are the ends of the ray. */
static double sample_at(const traced_light *light, const eye_ray *ray, size_t n)
{
    double share = (double)n / (double)(light->samples - 1), to_light[3], across[3];
    if (n == 0 || n == light->samples - 1) return n ? ray->end : ray->begin;
    if (light->shape.kind == LIGHT_DIRECTIONAL) return ray->begin + share * (ray->end - ray->begin);
    vec3_sub(light->shape.position_ws, ray->eye, to_light);
    vec3_cross(to_light, ray->direction, across);
    double along = vec3_dot(to_light, ray->direction), beside = sqrt(vec3_dot(across, across)) + 1e-6;
    double first = atan2(ray->begin - along, beside), last = atan2(ray->end - along, beside);
    return fmin(fmax(along + beside * tan(first + share * (last - first)), ray->begin), ray->end);
}

/* Where it changes between two places. */
static double change_between(const traced_light *light, const eye_ray *ray, double from, double to, int lit_from)
{
    double middle = 0.5 * (from + to);
    while (to - from > 1e-12 * (ray->end - ray->begin) && middle > from && middle < to) {
        if (lit_at(light, ray, middle) == lit_from)
            from = middle;
        else
            to = middle;
        middle = 0.5 * (from + to);
    }
    return middle;
}

void traced_parts(const void *subject, const eye_ray *ray, lit_parts *parts)
{
    const traced_light *light = subject;
    double              at = ray->begin, begin = at;
    int                 lit = lit_at(light, ray, at);
    lit_parts_clear(parts);
    for (size_t n = 1; n < light->samples; n++) {
        double next = sample_at(light, ray, n);
        if (lit_at(light, ray, next) != lit) {
            double change = change_between(light, ray, at, next, lit);
            if (lit) lit_parts_add(parts, begin, change);
            begin = change;
            lit   = !lit;
        }
        at = next;
    }
    if (lit) lit_parts_add(parts, begin, ray->end);
}
