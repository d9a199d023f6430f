/* A baked light's mesh; see baked_mesh.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/baked_mesh.h"

#include <stdlib.h>

/* Read the first shadow depths of the light's rays from the asset.   first  [out] released with free */
static vxs_result read_map(const baked_mesh_options *o, const gl_context *gl, vxs_volumes *volumes, float **first,
                           uint32_t *side_px, message *m)
{
    vxs_shadow_depth_map *map = NULL;
    vxs_result            result =
        vxs_shadow_depth_map_create(&map, volumes, &(vxs_shadow_depth_map_desc){.baked = o->light, .side_px = o->side_px});
    if (result != VXS_OK) return fail(m, result, "OpenGL has no room for a light map: %s", vxs_result_text(result));
    while (vxs_shadow_depth_map_fill(map, UINT64_MAX)) continue;
    *side_px    = vxs_shadow_depth_map_side_px(map);
    size_t size = sizeof **first * *side_px * *side_px * vxs_shadow_depth_map_layers(map);
    *first      = malloc(size);
    if (*first)
        gl->GetTextureImage(vxs_shadow_depth_map_texture(map), 0, GL_RED, GL_FLOAT, (GLsizei)size, *first);
    else
        result = fail(m, VXS_E_MEMORY, "out of memory for a light map of %u texels a side", *side_px);
    vxs_shadow_depth_map_destroy(map);
    return result;
}

static vxs_result upload_mesh(vxs_light_mesh **mesh, vxs_volumes *volumes, const vxs_light_mesh_desc *desc, void *room)
{
    vxs_light_mesh_size size;
    vxs_result          result  = vxs_light_mesh_plan(desc, room, &size);
    float              *places  = NULL;
    uint32_t           *corners = NULL;
    if (result != VXS_OK) return result;
    places  = malloc(3 * sizeof *places * size.vertex_count);
    corners = malloc(3 * sizeof *corners * size.triangle_count);
    result  = VXS_E_MEMORY;
    if (places && corners) {
        vxs_light_mesh_fill(desc, room, places, corners);
        result = vxs_light_mesh_create(mesh, volumes, places, corners, &size);
    }
    free(places);
    free(corners);
    return result;
}

vxs_result baked_mesh_make(vxs_light_mesh **mesh, const baked_mesh_options *o, const gl_context *gl, const vxs_gl *shadows,
                           vxs_volumes *volumes, message *m)
{
    vxs_light_mesh_desc desc   = {.struct_size  = sizeof desc,
                                  .light        = &vxs_gl_constants(shadows)[o->light],
                                  .far_metres   = (float)o->far_metres,
                                  .error_texels = (float)o->error_texels};
    float              *first  = NULL;
    vxs_result          result = read_map(o, gl, volumes, &first, &desc.side_px, m);
    if (result != VXS_OK) return result;
    desc.first = first;
    void *room = malloc(vxs_light_mesh_room(&desc) + 1);
    result     = room ? upload_mesh(mesh, volumes, &desc, room) : VXS_E_MEMORY;
    free(room);
    free(first);
    return result == VXS_OK ? VXS_OK : fail(m, result, "no mesh can be made of light %u: %s", o->light, vxs_result_text(result));
}
