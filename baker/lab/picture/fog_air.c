/* Media and lights of fog for airlight; see fog_air.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/picture/fog_air.h"

#include <math.h>

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
                                .range_metres  = shape->range_m < INFINITY ? shape->range_m : 0};
    for (int i = 0; i < 3; i++) {
        air.place[i] = shape->kind == LIGHT_DIRECTIONAL ? -shape->direction_ws[i] : shape->position_ws[i];
        air.axis[i]  = shape->direction_ws[i];
    }
    return air;
}
