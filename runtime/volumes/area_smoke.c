/* Smoke that dims the lamps of an area light: a layer of curves for each lamp; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "area_state.h"

enum { SIDE = 64, NODES = 4 };

static int make_programs(vxs_area_light *light, int takes_maps)
{
    const char *const uses[3]  = {AREA_READS, takes_maps ? AREA_TAKES_MAPS : AREA_GATHERS, AREA_TAKES_MAPS};
    const char *const texts[3] = {vxs_volumes_text_transmittance_stream_glsl, vxs_volumes_text_area_gather_glsl,
                                  vxs_volumes_text_area_exact_glsl};
    char              curves[TRANSMITTANCE_NAMES], names[sizeof AREA_TAKES_MAPS + TRANSMITTANCE_NAMES];
    vxs_transmittance_names(&light->curves, curves);
    for (int n = 0; n < (takes_maps ? 3 : 2); n++) {
        snprintf(names, sizeof names, "%s%s", uses[n], curves);
        if (!(light->programs[AREA_CURVES + n] = vxs_volumes_compute(light->volumes, names, texts[n]))) return 0;
    }
    return 1;
}

vxs_result vxs_area_light_take_smoke(vxs_area_light *light, const vxs_area_light_desc *desc)
{
    if (!vxs_transmittance_is_size(desc->smoke_side_px, desc->smoke_nodes, desc->capsules)) return VXS_E_ARGUMENT;
    light->curves     = (vxs_transmittance_map){.volumes      = light->volumes,
                                                .side_px      = desc->smoke_side_px ? desc->smoke_side_px : SIDE,
                                                .layers       = light->most,
                                                .nodes        = desc->smoke_nodes ? desc->smoke_nodes : NODES,
                                                .capsule_room = desc->capsules};
    vxs_result result = vxs_transmittance_take(&light->curves);
    if (result == VXS_OK && !make_programs(light, desc->takes_maps != 0)) result = VXS_E_GL;
    light->curves.build = light->programs[AREA_CURVES];
    return result;
}

void vxs_area_light_use_curves(const vxs_area_light *light)
{
    const vxs_volumes *v = light->volumes;
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage, light->curves.buffer);
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage + 2, light->buffer);
}

vxs_result vxs_area_light_smoke(vxs_area_light *light, const vxs_capsules *smoke)
{
    const vxs_volumes *v = light->volumes;
    if (!vxs_area_light_has_sides(light)) return VXS_E_ARGUMENT;
    light->smoke = AREA_CLEAR;
    if (!smoke->count) return VXS_OK;
    storage_kept kept    = vxs_volumes_keep_storage(v);
    light->curves.layers = light->count;
    vxs_area_light_put(light, 0);
    vxs_area_light_use_curves(light);
    vxs_result result = vxs_transmittance_map_build(&light->curves, smoke, NULL);
    if (result == VXS_OK) light->smoke = AREA_DIMMED;
    vxs_volumes_put_back_storage(v, &kept);
    return result;
}
