/* The reference; see reference.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/reference.h"

#include <math.h>

#include "baker/base/vec3.h"
#include "tests/volumes/airlight.h"

/* The part of the ray below the top. */
static void keep_fog(double top, const eye_ray *ray, double part[2])
{
    double height = ray->eye[1], up = ray->direction[1];
    if (top >= VXS_AIR_EVERYWHERE) return;
    if (up > 0) part[1] = fmin(part[1], (top - height) / up);
    if (up < 0) part[0] = fmax(part[0], (top - height) / up);
    if (up == 0 && height > top) part[1] = part[0];
}

/* And in a punctual light's range, by the roots of a square. */
static void keep_range(const vxs_air_light *light, const double to_light[3], double along, double part[2])
{
    double within = light->range_metres * light->range_metres - vec3_dot(to_light, to_light) + along * along;
    if (!(light->range_metres > 0)) return;
    within  = within > 0 ? sqrt(within) : 0;
    part[0] = fmax(part[0], along - within);
    part[1] = fmin(part[1], along + within);
}

typedef struct passage {
    int         is_sun;
    air_passing passing;            /* of a punctual light */
    double      cosine, way, slope; /* of the sun: way at the eye */
} passage;

static double channel_of(const vxs_medium *medium, const passage *p, int channel, double begin, double end)
{
    double extinction = medium->extinction[channel], g = medium->anisotropy;
    if (p->is_sun) return air_of_sun(p->cosine, g, extinction, p->way, p->slope, begin, end - begin);
    return air_of_punctual(&p->passing, g, extinction, begin, end - begin);
}

void reference_airlight(const vxs_medium *medium, double top, const reference_light *of, const eye_ray *ray, double airlight[3])
{
    const vxs_air_light *light   = &of->light;
    double               part[2] = {ray->begin, ray->end}, to_light[3], fog[2] = {0, INFINITY};
    lit_parts            lit = {0};
    passage              p   = {.is_sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL, .slope = 1};
    airlight[0] = airlight[1] = airlight[2] = 0;
    keep_fog(top, ray, part);
    if (p.is_sun) {
        p.cosine = vec3_dot(ray->direction, light->place);
        if (top < VXS_AIR_EVERYWHERE) {
            if (!(light->place[1] > 0)) return; /* through fog without end */
            keep_fog(top, ray, fog);
            p.way   = (top - ray->eye[1]) / light->place[1] - fog[0];
            p.slope = 1 - ray->direction[1] / light->place[1];
        }
    } else {
        int is_spot = light->kind != VXS_LIGHT_KIND_POINT;
        vec3_sub(light->place, ray->eye, to_light);
        p.passing = air_passing_of(ray->direction, to_light, light->radius_metres, is_spot ? light->axis : NULL, light->cos_inner,
                                   light->cos_outer);
        p.passing.has_top  = top < VXS_AIR_EVERYWHERE;
        p.passing.top      = top - ray->eye[1];
        p.passing.punctual = to_light[1];
        p.passing.up       = ray->direction[1];
        p.passing.range    = light->range_metres;
        keep_range(light, to_light, p.passing.along, part);
    }
    if (!(part[1] > part[0])) return;
    eye_ray asked = *ray;
    asked.begin   = part[0];
    asked.end     = part[1];
    of->oracle(of->subject, &asked, &lit);
    for (int n = 0; n < 3; n++) {
        double sum = 0;
        for (size_t k = 0; k < lit.count; k++) sum += channel_of(medium, &p, n, lit.at[k].begin, lit.at[k].end);
        airlight[n] = sum * medium->scattering[n] * of->colour[n];
    }
    lit_parts_free(&lit);
}
