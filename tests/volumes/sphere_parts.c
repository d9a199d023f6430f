/* Lit parts among spheres; see sphere_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/sphere_parts.h"

#include <math.h>

#include "baker/base/vec3.h"

/* a x^2 + 2 b x + c along a ray, below 0 in what is bounded */
typedef struct square {
    double a, b, c;
} square;

/* Shadows of a ray: each is two places, where it begins and ends. */
static void add_shadow(places *shadows, double begin, double end)
{
    if (!(begin < end)) return;
    places_add(shadows, begin);
    places_add(shadows, end);
}

/* Whether the square has roots, and which, low <= high; one that opens downward has, but for rounding. */
static int roots_of(square s, double *low, double *high)
{
    double within = s.b * s.b - s.a * s.c;
    if (s.a > 0 && !(within > 0)) return 0;
    within     = sqrt(fmax(within, 0));
    double one = (-s.b - within) / s.a, other = (-s.b + within) / s.a;
    *low  = fmin(one, other);
    *high = fmax(one, other);
    return 1;
}

#define PARALLEL 1e-12 /* square of an angle: a ray along the sun's stays in its cylinder for a million radii */

/* The cylinder or double cone of light rays that graze the sphere.
 * rim  [out] at x the ray is rim[0] + x rim[1] behind the circle where they touch it, times some length */
static square grazing(const sphere *s, const light_shape *light, const eye_ray *ray, double rim[2])
{
    double from[3], centre[3];
    if (light->kind == LIGHT_DIRECTIONAL) {
        vec3_sub(ray->eye, s->centre, from);
        rim[0] = vec3_dot(from, light->direction_ws);
        rim[1] = vec3_dot(ray->direction, light->direction_ws);
        return (square){fmax(1 - rim[1] * rim[1], PARALLEL), vec3_dot(from, ray->direction) - rim[0] * rim[1],
                        vec3_dot(from, from) - rim[0] * rim[0] - s->radius * s->radius};
    }
    vec3_sub(ray->eye, light->position_ws, from);
    vec3_sub(s->centre, light->position_ws, centre);
    double tangent2 = vec3_dot(centre, centre) - s->radius * s->radius; /* |p|^2 tangent2 < (p . centre)^2 in the cone */
    double begin = vec3_dot(from, centre), way = vec3_dot(ray->direction, centre);
    rim[0] = begin - tangent2;
    rim[1] = way;
    return (square){tangent2 - way * way, tangent2 * vec3_dot(from, ray->direction) - begin * way,
                    tangent2 * vec3_dot(from, from) - begin * begin};
}

static void add_shadows(const sphere *s, const light_shape *light, const eye_ray *ray, places *shadows)
{
    double to[3], rim[2], low, high, begin = -INFINITY, end = INFINITY;
    vec3_sub(ray->eye, s->centre, to);
    if (roots_of((square){1, vec3_dot(to, ray->direction), vec3_dot(to, to) - s->radius * s->radius}, &low, &high))
        add_shadow(shadows, low, high);
    square around = grazing(s, light, ray, rim);
    if (rim[1] > 0) begin = -rim[0] / rim[1];
    if (rim[1] < 0) end = -rim[0] / rim[1];
    if (!roots_of(around, &low, &high)) return;
    if (around.a > 0)
        add_shadow(shadows, fmax(low, begin), fmin(high, end));
    else if (rim[1] > 0) /* steeper than the cone: behind the rim it stays in it, or was in it before */
        add_shadow(shadows, fmax(high, begin), INFINITY);
    else
        add_shadow(shadows, -INFINITY, fmin(low, end));
}

/* Behind all shadows that hold a place, one after the other. */
static double behind(const places *shadows, double x)
{
    for (int moved = 1; moved;) {
        moved = 0;
        for (size_t k = 0; k < shadows->count; k += 2)
            if (shadows->at[k] <= x && shadows->at[k + 1] > x) {
                x     = shadows->at[k + 1];
                moved = 1;
            }
    }
    return x;
}

void sphere_parts(const void *subject, const eye_ray *ray, lit_parts *parts)
{
    const lit_spheres *s       = subject;
    places             shadows = {0};
    lit_parts_clear(parts);
    for (size_t n = 0; n < s->count; n++) add_shadows(&s->at[n], &s->light, ray, &shadows);
    for (double at = behind(&shadows, ray->begin); at < ray->end;) {
        double next = ray->end;
        for (size_t k = 0; k < shadows.count; k += 2)
            if (shadows.at[k] > at) next = fmin(next, shadows.at[k]);
        lit_parts_add(parts, at, next);
        at = behind(&shadows, next);
    }
    places_free(&shadows);
}
