/* Segments that shaders of the caller add; see vxs_transmittance.h. The map and its light are described in a separate storage
 * buffer, so that these shaders need no other texts.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "transmittance_map.h"
#include "vxs_space.h"

/* As in the text below (std430). */
typedef struct segment_view {
    float    metres_from_ws[6][3][4]; /* for each layer: along its axes */
    uint32_t side_px, layers, nodes, segment_room;
    float    texel_metres, is_sun, reserved[2];
} segment_view;

static const char view_text[] = "#define VXS_CURVE_SHAPE vxs_view.shape\n"
                                "layout(std430, binding = VXS_AT_GRID + 1) readonly restrict buffer vxs_view_buffer {\n"
                                "    vec4  metres_from_ws[18];\n"
                                "    uvec4 shape; /* texels a side, layers, nodes, segments that lists have room for */\n"
                                "    float texel_metres; /* how wide one is: of punctual lights at one metre along the axis */\n"
                                "    float is_sun;\n"
                                "} vxs_view;\n";

gl_name vxs_transmittance_view(const vxs_volumes *v)
{
    return vxs_volumes_buffer(v, sizeof(segment_view));
}

vxs_result vxs_transmittance_map_texts(const vxs_transmittance_map *map, const char *texts[VXS_SEGMENT_TEXTS])
{
    if (!map->segment_room) return VXS_E_ARGUMENT;
    texts[0] = map->binding_text;
    texts[1] = view_text;
    texts[2] = vxs_volumes_text_curves_glsl.text;
    texts[3] = vxs_volumes_text_transmittance_lists_glsl.text;
    texts[4] = vxs_volumes_text_transmittance_segments_glsl.text;
    return VXS_OK;
}

/* Rows from world to the light space of a layer, in metres. A map that is not a cube uses the axes of light space. */
static void set_rows(const vxs_light_constants *light, uint32_t layer, float rows[3][4])
{
    int is_sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    for (int axis = 0; axis < 3; axis++) {
        int   from  = light->flags & VXS_LIGHT_CUBE ? vxs_ls_axis_from_face((int)layer, axis) : axis;
        float scale = !is_sun ? 1 : axis < 2 ? light->texel_metres : light->voxel_metres;
        if (!is_sun && axis == 2 && light->flags & VXS_LIGHT_CUBE) scale = (float)vxs_face_sign((int)layer);
        for (int n = 0; n < 4; n++) rows[axis][n] = scale * light->ls_from_ws[4 * from + n];
    }
}

void vxs_transmittance_draw(const vxs_transmittance_map *map, const vxs_light_constants *light, void (*draw)(void *user),
                            void *user)
{
    const vxs_volumes *v    = map->volumes;
    segment_view       view = {.side_px      = map->side_px,
                               .layers       = map->layers,
                               .nodes        = map->nodes,
                               .segment_room = map->segment_room,
                               .texel_metres = light->texel_metres * (float)(1U << light->levels) / (float)map->side_px,
                               .is_sun       = light->kind == VXS_LIGHT_KIND_DIRECTIONAL};
    for (uint32_t layer = 0; layer < map->layers; layer++) set_rows(light, layer, view.metres_from_ws[layer]);
    v->api.NamedBufferSubData(map->view, 0, sizeof view, &view);
    vxs_volumes_use_storage(v, map->buffer, map->view);
    draw(user);
    v->api.MemoryBarrier(GL_BARRIER_SHADER_STORAGE);
    vxs_volumes_use_storage(v, map->buffer, 0);
}
