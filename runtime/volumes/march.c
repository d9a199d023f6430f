/* Marches, and exact intervals; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include "transmittance_map.h"
#include "volumes_state.h"

/* In smoke. */
static void march_dimmed(vxs_volumes *v, const vxs_volumes_light *light, const vxs_light_map *map)
{
    storage_kept kept = vxs_volumes_keep_storage(v);
    vxs_transmittance_set_reader(light->smoke, (vxs_curve_lookup)light->smoke_lookup);
    vxs_volumes_use_storage(v, light->smoke->buffer, 0);
    vxs_volumes_add(v, v->curves[map ? PROGRAM_SMOKE_MARCH_MAP : PROGRAM_SMOKE_MARCH_ASSET], map ? vxs_light_map_texture(map) : 0);
    vxs_volumes_put_back_storage(v, &kept);
}

vxs_result vxs_volumes_march(vxs_volumes *v, const vxs_volumes_light *light, const vxs_light_map *map, uint32_t steps,
                             vxs_steps which)
{
    enum { STEPS_MAX = 65536 };
    if (!steps || steps > STEPS_MAX || (which != VXS_STEPS_EVEN && which != VXS_STEPS_ANGLE)) return VXS_E_ARGUMENT;
    if (!map && light->constants) return VXS_E_ARGUMENT;
    if (light->smoke && !vxs_transmittance_is_of(light->smoke, v, light)) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    v->frame.knobs[0] = (float)steps;
    v->frame.knobs[1] = (float)which;
    v->frame.knobs[3] = light->constants ? 0 : (float)(light->baked + 1); /* whose baked smoke dims it */
    if (light->smoke)
        march_dimmed(v, light, map);
    else
        vxs_volumes_add(v, v->programs[map ? PROGRAM_MARCH_MAP : PROGRAM_MARCH_ASSET], map ? vxs_light_map_texture(map) : 0);
    return VXS_OK;
}

vxs_result vxs_volumes_intervals(vxs_volumes *v, const vxs_volumes_light *light)
{
    if (light->constants || light->smoke) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, NULL);
    if (result == VXS_OK) vxs_volumes_add(v, v->programs[PROGRAM_INTERVALS], 0);
    return result;
}
