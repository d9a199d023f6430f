/* Fog among spheres; see sphere_fog.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/sphere_fog.h"

#include <string.h>

#include "baker/lab/picture/fog_air.h"

void sphere_fog_add_airlight(const fog_medium *f, const fog_light *light, const lit_spheres *spheres, const double eye_ws[3],
                             const double direction[3], double metres, double airlight[3])
{
    vxs_medium    medium = fog_air_medium(f);
    vxs_air_light air    = fog_air_light(light);
    double        in_fog[2];
    vxs_air_path  path = vxs_air_path_of(&air, eye_ws, direction, metres, f->top_ws, in_fog);
    eye_ray       ray  = {.begin = path.begin, .end = path.end};
    lit_parts     lit  = {0};
    memcpy(ray.eye, eye_ws, sizeof ray.eye);
    memcpy(ray.direction, direction, sizeof ray.direction);
    sphere_parts(spheres, &ray, &lit);
    for (size_t n = 0; n < lit.count; n++) {
        double part[3];
        vxs_air_lit(&medium, &path, lit.at[n].begin, lit.at[n].end, part);
        for (int k = 0; k < 3; k++) airlight[k] += light->colour[k] * part[k];
    }
    lit_parts_free(&lit);
}
