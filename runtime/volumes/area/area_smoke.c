/* Smoke that dims the VPLs of an area light: a layer of curves for each VPL; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include "area_state.h"

enum { SIDE = 64, NODES = 4 };

vxs_result vxs_area_light_take_smoke(vxs_area_light *light, const vxs_area_light_desc *desc)
{
    if (!vxs_transmittance_is_size(desc->smoke_side_px, desc->smoke_nodes, desc->capsules)) return VXS_E_ARGUMENT;
    light->curves = (vxs_transmittance_map){.volumes      = light->volumes,
                                            .side_px      = desc->smoke_side_px ? desc->smoke_side_px : SIDE,
                                            .layers       = light->most,
                                            .nodes        = desc->smoke_nodes ? desc->smoke_nodes : NODES,
                                            .capsule_room = desc->capsules,
                                            .names        = AREA_READS,
                                            .layers_text  = &vxs_volumes_text_area_curves_glsl};
    return vxs_transmittance_alloc(&light->curves);
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
    saved_storage saved  = vxs_volumes_save_storage(v);
    light->curves.layers = light->count;
    vxs_area_light_put(light, 0);
    vxs_area_light_use_curves(light);
    vxs_result result = vxs_transmittance_map_build(&light->curves, smoke, NULL);
    if (result == VXS_OK) light->smoke = v->is_warming ? AREA_DIMMED_BEFORE : AREA_DIMMED;
    vxs_volumes_restore_storage(v, &saved);
    return result;
}
