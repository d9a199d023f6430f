/* Marches, and exact intervals; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include "volumes_state.h"

vxs_result vxs_volumes_march(vxs_volumes *v, const vxs_volumes_light *light, const vxs_light_map *map, uint32_t steps,
                             vxs_steps which)
{
    enum { STEPS_MAX = 65536 };
    if (!steps || steps > STEPS_MAX || (which != VXS_STEPS_EVEN && which != VXS_STEPS_ANGLE)) return VXS_E_ARGUMENT;
    if (!map && light->constants) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    v->frame.knobs[0] = (float)steps;
    v->frame.knobs[1] = (float)which;
    vxs_volumes_add(v, v->programs[map ? PROGRAM_MARCH_MAP : PROGRAM_MARCH_ASSET], map ? vxs_light_map_texture(map) : 0);
    return VXS_OK;
}

vxs_result vxs_volumes_intervals(vxs_volumes *v, const vxs_volumes_light *light)
{
    if (light->constants) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, NULL);
    if (result == VXS_OK) vxs_volumes_add(v, v->programs[PROGRAM_INTERVALS], 0);
    return result;
}
