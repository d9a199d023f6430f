/* Shadow depth maps: where shadow begins on each light ray; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "volumes_state.h"
#include "vxs_desc.h"

static const float no_end = 1e30F;

const vxs_light_constants *vxs_shadow_depth_map_constants(const vxs_shadow_depth_map *map)
{
    return map->is_baked ? &vxs_gl_constants(map->volumes->shadows)[map->baked] : &map->constants;
}

static uint64_t texels_of(const vxs_shadow_depth_map *map)
{
    return (uint64_t)map->side_px * map->side_px * map->layers;
}

static int is_power_of_two(uint32_t n)
{
    return n && !(n & (n - 1));
}

vxs_result vxs_shadow_depth_map_create(vxs_shadow_depth_map **out, vxs_volumes *v, const vxs_shadow_depth_map_desc *desc)
{
    vxs_shadow_depth_map_desc known = {0};
    const size_t              first = offsetof(vxs_shadow_depth_map_desc, moves) + sizeof known.moves;
    int                       most  = 0;
    *out                            = NULL;
    if (vxs_desc_take(&known, sizeof known, first, desc) != VXS_OK) return VXS_E_ARGUMENT;
    if (known.side_px && !is_power_of_two(known.side_px)) return VXS_E_ARGUMENT;
    if (!known.constants && known.baked_number - 1 >= vxs_gl_light_count(v->shadows)) return VXS_E_ARGUMENT;
    vxs_shadow_depth_map *map = vxs_volumes_alloc(v, sizeof *map);
    if (!map) return VXS_E_MEMORY;
    *map = (vxs_shadow_depth_map){.volumes = v, .baked = known.baked_number - 1, .is_baked = !known.constants};
    if (known.constants) map->constants = *known.constants;
    const vxs_light_constants *light = vxs_shadow_depth_map_constants(map);
    uint32_t                   side  = light->levels < 31 ? 1U << light->levels : 0;
    map->side_px                     = known.side_px && known.side_px < side ? known.side_px : side;
    map->layers                      = light->flags & VXS_LIGHT_CUBE ? 6 : 1;
    v->api.GetIntegerv(GL_MOST_TEXTURE_SIZE, &most);
    vxs_result result =
        map->side_px && map->side_px <= (uint32_t)most
            ? VXS_OK
            : vxs_volumes_fail(v, VXS_E_GL, "a shadow depth map is larger than a texture of this context: set a smaller side_px");
    if (result == VXS_OK) {
        map->first = vxs_volumes_texture(v, GL_FORMAT_R32F, map->side_px, map->side_px, map->layers);
        if (known.moves) map->joined = vxs_volumes_texture(v, GL_FORMAT_R32F, map->side_px, map->side_px, map->layers);
        if (!map->first || (known.moves && !map->joined)) result = VXS_E_MEMORY;
    }
    if (result != VXS_OK) {
        vxs_shadow_depth_map_destroy(map);
        return result;
    }
    v->api.ClearTexImage(map->first, 0, GL_FORMAT_RED, GL_TYPE_FLOAT, &no_end);
    if (!map->is_baked) map->filled = texels_of(map);
    *out = map;
    return VXS_OK;
}

void vxs_shadow_depth_map_destroy(vxs_shadow_depth_map *map)
{
    if (!map) return;
    const vxs_volumes *v = map->volumes;
    if (map->first) v->api.DeleteTextures(1, &map->first);
    if (map->joined) v->api.DeleteTextures(1, &map->joined);
    vxs_volumes_free(v, map, sizeof *map);
}

static void set_map(vxs_shadow_depth_map *map)
{
    frame_block *to = &map->volumes->frame;
    to->light       = *vxs_shadow_depth_map_constants(map);
    to->map_side_px = map->side_px;
    to->map_layers  = map->layers;
}

uint64_t vxs_shadow_depth_map_fill(vxs_shadow_depth_map *map, uint64_t max_texels)
{
    enum { GROUP = 64, GROUPS_MAX = 65535 };
    vxs_volumes *v          = map->volumes;
    uint32_t     is_warming = v->is_warming;
    uint64_t     left = texels_of(map) - map->filled, some = left < max_texels ? left : max_texels;
    v->is_warming = 0; /* callers repeat this until nothing is left */
    while (some) {
        uint32_t now = some < (uint64_t)GROUP * GROUPS_MAX ? (uint32_t)some : GROUP * GROUPS_MAX;
        set_map(map);
        gl_name program   = vxs_volumes_light_program(v, &(program_texts){.body = &vxs_volumes_text_map_fill_glsl});
        v->own.map_fill   = (map_fill_block){(uint32_t)map->filled, (uint32_t)map->filled + now};
        saved_state saved = vxs_volumes_use(v, program, 0, map->first, GL_FORMAT_R32F);
        vxs_volumes_dispatch(v, (now + GROUP - 1) / GROUP, 1, 1);
        vxs_volumes_restore(v, &saved);
        map->filled += now;
        some -= now;
    }
    v->is_warming = is_warming;
    return texels_of(map) - map->filled;
}

void vxs_shadow_depth_map_refill(vxs_shadow_depth_map *map)
{
    if (map->is_baked) map->filled = 0;
}

/* While a depth map of the caller is joined, the block has its matrix and sizes. */
static void join(vxs_shadow_depth_map *map, const vxs_moving_casters *casters)
{
    vxs_volumes *v      = map->volumes;
    frame_block  frame  = v->frame;
    gl_name      depths = v->depth_texture;
    uint32_t     groups = (map->side_px + 7) / 8;
    set_map(map);
    memcpy(v->frame.point_from_depth, casters->depth_from_point, sizeof v->frame.point_from_depth);
    v->frame.wide_px     = (float)casters->width_px;
    v->frame.high_px     = (float)casters->height_px;
    v->frame.empty_depth = casters->empty_depth;
    v->depth_texture     = casters->depth_texture;
    saved_state saved = vxs_volumes_use(v, vxs_volumes_light_program(v, &(program_texts){.body = &vxs_volumes_text_map_join_glsl}),
                                        0, map->joined, GL_FORMAT_R32F);
    vxs_volumes_dispatch(v, groups, groups, map->layers);
    vxs_volumes_restore(v, &saved);
    v->frame         = frame;
    v->depth_texture = depths;
}

vxs_result vxs_shadow_depth_map_join(vxs_shadow_depth_map *map, const vxs_moving_casters *casters, uint32_t count)
{
    if (!map->joined)
        return vxs_volumes_fail(map->volumes, VXS_E_ARGUMENT, "vxs_shadow_depth_map_join: create the map with moves 1");
    for (uint32_t n = 0; n < count; n++)
        if (!casters[n].depth_texture || !casters[n].width_px || !casters[n].height_px) return VXS_E_ARGUMENT;
    int side = (int)map->side_px;
    map->volumes->api.CopyImageSubData(map->first, GL_TARGET_TEXTURE_2D_ARRAY, 0, 0, 0, 0, map->joined, GL_TARGET_TEXTURE_2D_ARRAY,
                                       0, 0, 0, 0, side, side, (int)map->layers);
    for (uint32_t n = 0; n < count; n++) join(map, &casters[n]);
    return vxs_volumes_done(map->volumes);
}

unsigned vxs_shadow_depth_map_texture(const vxs_shadow_depth_map *map)
{
    return map->joined ? map->joined : map->first;
}

uint32_t vxs_shadow_depth_map_side_px(const vxs_shadow_depth_map *map)
{
    return map->side_px;
}

uint32_t vxs_shadow_depth_map_layers(const vxs_shadow_depth_map *map)
{
    return map->layers;
}
