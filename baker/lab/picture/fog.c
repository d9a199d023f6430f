/* Fog along a ray; see fog.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/picture/fog.h"

#include <math.h>
#include <string.h>

#include "baker/lab/picture/fog_air.h"
#include "runtime/vxs_query.h"

vxs_medium fog_air_medium(const fog_medium *f)
{
    vxs_medium m = {.anisotropy = f->anisotropy};
    for (int i = 0; i < 3; i++) {
        m.scattering[i] = f->scattering[i];
        m.extinction[i] = f->extinction[i];
    }
    return m;
}

vxs_air_light fog_air_light(const fog_light *light)
{
    static const uint32_t kinds[] = {
        [LIGHT_DIRECTIONAL] = VXS_LIGHT_KIND_DIRECTIONAL, [LIGHT_SPOT] = VXS_LIGHT_KIND_SPOT, [LIGHT_POINT] = VXS_LIGHT_KIND_POINT};
    const light_shape *shape = &light->shape;
    vxs_air_light      air   = {.kind          = kinds[shape->kind],
                                .cos_inner     = light->cos_inner,
                                .cos_outer     = cos(shape->outer_rad),
                                .radius_metres = light->radius_metres,
                                .range_metres  = shape->range_metres < INFINITY ? shape->range_metres : 0};
    for (int i = 0; i < 3; i++) {
        air.place[i] = shape->kind == LIGHT_DIRECTIONAL ? -shape->direction_ws[i] : shape->position_ws[i];
        air.axis[i]  = shape->direction_ws[i];
    }
    return air;
}

enum { INTERVALS = 32 }; /* looked up at a time */

void fog_add_airlight(const fog_medium *f, const fog_light *lights, uint32_t light_count, const double eye_ws[3],
                      const double direction[3], double metres, double airlight[3])
{
    vxs_medium medium = fog_air_medium(f);
    double     in_fog[2];
    for (uint32_t n = 0; n < light_count; n++) {
        vxs_air_light light = fog_air_light(&lights[n]);
        vxs_air_path  path  = vxs_air_path_of(&light, eye_ws, direction, metres, f->top_ws, in_fog);
        if (path.end > path.begin) {
            vxs_ray      ray = {.t_begin = path.begin, .t_end = path.end};
            vxs_lit_walk walk;
            vxs_interval found[INTERVALS];
            size_t       count          = INTERVALS;
            int          outside_is_lit = lights[n].shape.kind == LIGHT_DIRECTIONAL; /* beyond its map */
            memcpy(ray.origin_ws, eye_ws, sizeof ray.origin_ws);
            memcpy(ray.direction_ws, direction, sizeof ray.direction_ws);
            if (vxs_lit_begin(&walk, lights[n].light, &ray) != VXS_OK) continue;
            while (count == INTERVALS) {
                count = vxs_lit_next(&walk, found, INTERVALS);
                for (size_t k = 0; k < count; k++) {
                    double lit[3];
                    if (found[k].state == VXS_INTERVAL_SHADOW || (found[k].state == VXS_INTERVAL_OUTSIDE && !outside_is_lit))
                        continue;
                    vxs_air_lit(&medium, &path, found[k].t_begin, found[k].t_end, lit);
                    for (int i = 0; i < 3; i++) airlight[i] += lights[n].colour[i] * lit[i];
                }
            }
        }
    }
}

void fog_reaches(const fog_medium *f, const fog_light *light, const double place_ws[3], double to_light[3], double reaches[3])
{
    vxs_medium    medium = fog_air_medium(f);
    vxs_air_light air    = fog_air_light(light);
    vxs_air_reaches(&medium, &air, place_ws, f->top_ws, to_light, reaches);
}

void fog_left(const fog_medium *f, const double eye_ws[3], const double direction[3], double metres, double left[3])
{
    vxs_medium medium    = fog_air_medium(f);
    double     in_fog[2] = {0, metres};
    if (f->top_ws < VXS_AIR_EVERYWHERE) vxs_air_in_fog(eye_ws[1], direction[1], f->top_ws, in_fog);
    vxs_air_left(&medium, fmax(0, in_fog[1] - in_fog[0]), left);
}
