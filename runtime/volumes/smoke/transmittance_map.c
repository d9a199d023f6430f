/* Maps of transmittance curves; see vxs_transmittance.h. One storage buffer has the counts, the curves, and, with lists, a
 * record for each texel and the segments (curves.glsl).
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "transmittance_map.h"
#include "vxs_desc.h"

enum {
    SIDE          = 256,
    SIDE_MAX      = 8192,
    NODES         = 8,
    CAPSULES_MAX  = 1 << 24,
    HEAD_BYTES    = 16,
    RECORD_BYTES  = 16,
    SEGMENT_BYTES = 16,
    GROUPS_ACROSS = 32768
};

static const vxs_light_constants *constants_of(const vxs_transmittance_map *map)
{
    return map->is_baked ? &vxs_gl_constants(map->volumes->shadows)[map->baked] : &map->constants;
}

static uint64_t texels_of(const vxs_transmittance_map *map)
{
    return (uint64_t)map->side_px * map->side_px * map->layers;
}

static uint64_t curve_bytes(const vxs_transmittance_map *map)
{
    return texels_of(map) * map->nodes * 2 * sizeof(float);
}

static uint64_t bytes_of(const vxs_transmittance_map *map)
{
    uint64_t lists = map->segment_room ? texels_of(map) * RECORD_BYTES + (uint64_t)map->segment_room * SEGMENT_BYTES : 0;
    return HEAD_BYTES + curve_bytes(map) + lists;
}

/* create ----------------------------------------------------------------------------------------------------------------------- */

gl_name vxs_transmittance_program(const vxs_transmittance_map *map, const char *names, const volumes_text *body)
{
    char all[PROGRAM_NAMES];
    snprintf(all, sizeof all, "%s#define VXS_USES_CURVES\n#define VXS_CURVE_MOST %u\n", names, map->nodes);
    return vxs_volumes_program(map->volumes, &(program_texts){.names = all, .with = map->layers_text, .body = body});
}

vxs_result vxs_transmittance_alloc(vxs_transmittance_map *map)
{
    vxs_volumes *v    = map->volumes;
    int          most = 0;
    v->api.GetIntegerv(GL_MOST_STORAGE_BYTES, &most);
    if (bytes_of(map) > (uint32_t)most || bytes_of(map) > INT32_MAX)
        return vxs_volumes_fail(
            v, VXS_E_GL, "curves are larger than a storage buffer of this context: use a smaller side_px, fewer nodes or segments");
    map->buffer   = vxs_volumes_buffer(v, bytes_of(map));
    map->capsules = vxs_volumes_buffer(v, (uint64_t)map->capsule_room * sizeof(vxs_capsule));
    if (map->segment_room) map->view = vxs_transmittance_view(v);
    return map->buffer && map->capsules && (map->view || !map->segment_room) ? VXS_OK : VXS_E_MEMORY;
}

void vxs_transmittance_free(vxs_transmittance_map *map)
{
    const gl_name buffers[] = {map->buffer, map->capsules, map->view};
    for (int n = 0; n < 3; n++)
        if (buffers[n]) map->volumes->api.DeleteBuffers(1, &buffers[n]);
}

int vxs_transmittance_is_size(uint32_t side_px, uint32_t nodes, uint32_t capsules)
{
    int is_nodes = nodes == 0 || nodes == 4 || nodes == 8 || nodes == 12 || nodes == 16;
    return is_nodes && side_px <= SIDE_MAX && capsules && capsules <= CAPSULES_MAX;
}

vxs_result vxs_transmittance_map_create(vxs_transmittance_map **out, vxs_volumes *v, const vxs_transmittance_desc *desc)
{
    vxs_transmittance_desc known  = {0};
    const size_t           first  = offsetof(vxs_transmittance_desc, unsorted) + sizeof known.unsorted;
    vxs_result             result = vxs_desc_take(&known, sizeof known, first, desc);
    *out                          = NULL;
    if (result != VXS_OK) return result;
    if (!known.constants && known.baked_number - 1 >= vxs_gl_light_count(v->shadows)) return VXS_E_ARGUMENT;
    if (!vxs_transmittance_is_size(known.side_px, known.nodes, known.capsules)) return VXS_E_ARGUMENT;
    vxs_transmittance_map *map = vxs_volumes_alloc(v, sizeof *map);
    if (!map) return VXS_E_MEMORY;
    *map = (vxs_transmittance_map){.volumes      = v,
                                   .baked        = known.baked_number - 1,
                                   .is_baked     = !known.constants,
                                   .side_px      = known.side_px ? known.side_px : SIDE,
                                   .nodes        = known.nodes ? known.nodes : NODES,
                                   .capsule_room = known.capsules,
                                   .segment_room = known.segments,
                                   .is_sorted    = !known.unsorted,
                                   .names        = "",
                                   .layers_text  = &vxs_volumes_text_transmittance_light_glsl};
    if (known.constants) map->constants = *known.constants;
    snprintf(map->binding_text, sizeof map->binding_text, "#define VXS_AT_GRID %u\n", v->first_storage);
    map->layers = constants_of(map)->flags & VXS_LIGHT_CUBE ? 6 : 1;
    result      = vxs_transmittance_alloc(map);
    if (result == VXS_OK)
        *out = map;
    else
        vxs_transmittance_map_destroy(map);
    return result;
}

void vxs_transmittance_map_destroy(vxs_transmittance_map *map)
{
    if (!map) return;
    vxs_transmittance_free(map);
    vxs_volumes_free(map->volumes, map, sizeof *map);
}

/* build ------------------------------------------------------------------------------------------------------------------------ */

void vxs_transmittance_set(const vxs_transmittance_map *map, const vxs_shadow_depth_map *opaque, uint32_t capsule_count)
{
    enum { SORTED = 1, ENDS_AT_OPAQUE = 2 };
    map->volumes->frame.light = *constants_of(map);
    map->volumes->curves      = (curve_block){.capsules       = capsule_count,
                                              .segment_room   = map->segment_room,
                                              .flags          = (map->is_sorted ? SORTED : 0) | (opaque ? ENDS_AT_OPAQUE : 0U),
                                              .side_px        = map->side_px,
                                              .layers         = map->layers,
                                              .nodes          = map->nodes,
                                              .opaque_side_px = opaque ? opaque->side_px : 0};
}

static void dispatch(vxs_volumes *v, gl_name program, const vxs_shadow_depth_map *opaque, uint32_t x, uint32_t y, uint32_t z)
{
    saved_state saved = vxs_volumes_use(v, program, opaque ? vxs_shadow_depth_map_texture(opaque) : 0, 0, 0);
    vxs_volumes_dispatch(v, x, y, z);
    vxs_volumes_restore(v, &saved);
}

void vxs_transmittance_run(const vxs_transmittance_map *map, gl_name program, const vxs_shadow_depth_map *opaque)
{
    uint32_t groups = (map->side_px + 7) / 8;
    dispatch(map->volumes, program, opaque, groups, groups, map->layers);
}

/* Reset: no segments, and in each texel's record an empty list without merged segments. */
static void clear(const vxs_transmittance_map *map)
{
    static const uint32_t record[4] = {UINT32_MAX, UINT32_MAX, 0, 0x3f800000};
    const volumes_api    *api       = &map->volumes->api;
    api->ClearNamedBufferSubData(map->buffer, GL_FORMAT_R32UI, 0, HEAD_BYTES, GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT, NULL);
    if (!map->segment_room) return;
    api->ClearNamedBufferSubData(map->buffer, GL_FORMAT_RGBA32UI, (gl_bytes)(HEAD_BYTES + curve_bytes(map)),
                                 (gl_bytes)(texels_of(map) * RECORD_BYTES), GL_FORMAT_RGBA_INTEGER, GL_TYPE_UNSIGNED_INT, record);
}

/* Number of parts such that a workgroup of 64 needs at most 16384 iterations for its texels. */
static uint32_t capture_parts(const vxs_transmittance_map *map)
{
    enum { TEXELS = 64 * 16384 };
    return (uint32_t)(((uint64_t)map->side_px * map->side_px + TEXELS - 1) / TEXELS);
}

void vxs_transmittance_capture(const vxs_transmittance_map *map, const vxs_capsules *capsules, const vxs_shadow_depth_map *opaque)
{
    vxs_volumes *v     = map->volumes;
    uint32_t     count = capsules->count, across = count < GROUPS_ACROSS ? count : GROUPS_ACROSS;
    if (capsules->list && count)
        v->api.NamedBufferSubData(map->capsules, 0, (gl_bytes)(count * sizeof *capsules->list), capsules->list);
    vxs_transmittance_set(map, opaque, count);
    clear(map);
    vxs_volumes_use_storage(v, map->buffer, capsules->list ? map->capsules : capsules->buffer);
    if (map->segment_room && count)
        dispatch(v, vxs_transmittance_program(map, "", &vxs_volumes_text_transmittance_capture_glsl), opaque, across,
                 (count + across - 1) / across, map->layers * capture_parts(map));
}

static int is_of_its_light(const vxs_transmittance_map *map, const vxs_shadow_depth_map *opaque)
{
    return opaque->layers == map->layers && opaque->is_baked == map->is_baked && (!map->is_baked || opaque->baked == map->baked);
}

gl_name vxs_transmittance_builder(const vxs_transmittance_map *map)
{
    return vxs_transmittance_program(map, map->names,
                                     map->segment_room ? &vxs_volumes_text_transmittance_build_glsl
                                                       : &vxs_volumes_text_transmittance_stream_glsl);
}

vxs_result vxs_transmittance_map_build_drawn(vxs_transmittance_map *map, const vxs_capsules *capsules,
                                             const vxs_shadow_depth_map *opaque, void (*draw)(void *user), void *user)
{
    if (capsules->count > map->capsule_room || (capsules->count && !capsules->list && !capsules->buffer)) return VXS_E_ARGUMENT;
    if ((opaque && !is_of_its_light(map, opaque)) || (draw && !map->segment_room)) return VXS_E_ARGUMENT;
    gl_name       build = vxs_transmittance_builder(map);
    saved_storage saved = vxs_volumes_save_storage(map->volumes);
    vxs_transmittance_capture(map, capsules, opaque);
    if (draw) {
        vxs_transmittance_draw(map, constants_of(map), draw, user);
        vxs_transmittance_set(map, opaque, 0);
    }
    vxs_transmittance_run(map, build, opaque);
    vxs_volumes_restore_storage(map->volumes, &saved);
    return vxs_volumes_done(map->volumes);
}

vxs_result vxs_transmittance_map_build(vxs_transmittance_map *map, const vxs_capsules *capsules, const vxs_shadow_depth_map *opaque)
{
    return vxs_transmittance_map_build_drawn(map, capsules, opaque, NULL, NULL);
}

vxs_transmittance_counts vxs_transmittance_map_counts(const vxs_transmittance_map *map)
{
    vxs_transmittance_counts counts = {0};
    map->volumes->api.GetNamedBufferSubData(map->buffer, 0, sizeof counts, &counts);
    return counts;
}

unsigned vxs_transmittance_map_buffer(const vxs_transmittance_map *map)
{
    return map->buffer;
}

/* look up ---------------------------------------------------------------------------------------------------------------------- */

static int is_lookup(vxs_curve_lookup how)
{
    return how == VXS_CURVE_LINES || how == VXS_CURVE_EXPONENTIALS;
}

void vxs_transmittance_pass(const vxs_transmittance_map *map, gl_name program, gl_name other, gl_name texture)
{
    enum { GROUP = 8 };
    vxs_volumes  *v    = map->volumes;
    uint32_t      wide = (uint32_t)v->frame.wide_px, high = (uint32_t)v->frame.high_px;
    saved_storage saved = vxs_volumes_save_storage(v);
    v->frame.pixels     = (vxs_pixels){0, 0, wide, high};
    vxs_volumes_use_storage(v, map->buffer, other);
    saved_state state = vxs_volumes_use(v, program, 0, texture, GL_FORMAT_R32F);
    vxs_volumes_dispatch(v, (wide + GROUP - 1) / GROUP, (high + GROUP - 1) / GROUP, 1);
    vxs_volumes_restore(v, &state);
    vxs_volumes_restore_storage(v, &saved);
}

vxs_result vxs_volumes_transmittance(vxs_volumes *v, const vxs_transmittance_map *map, unsigned texture, vxs_curve_lookup how)
{
    if (!v->depth_texture || v->is_half || !texture || !is_lookup(how)) return VXS_E_ARGUMENT;
    vxs_transmittance_set(map, NULL, 0);
    v->curves.lookup = (int32_t)how;
    vxs_transmittance_pass(map, vxs_transmittance_program(map, "", &vxs_volumes_text_transmittance_pass_glsl), 0, texture);
    return vxs_volumes_done(v);
}

void vxs_transmittance_set_reader(const vxs_transmittance_map *map, vxs_curve_lookup how)
{
    map->volumes->curves = (curve_block){.side_px      = map->side_px,
                                         .layers       = map->layers,
                                         .nodes        = map->nodes,
                                         .segment_room = map->segment_room,
                                         .lookup       = (int32_t)how};
}

vxs_result vxs_volumes_transmittance_at(vxs_volumes *v, const vxs_transmittance_map *map, unsigned places, uint32_t count,
                                        unsigned left, uint32_t first, vxs_curve_lookup how)
{
    enum { GROUP = 64 };
    if (!places || !left || count > UINT32_MAX - first || !is_lookup(how)) return VXS_E_ARGUMENT;
    uint32_t      groups = count / GROUP + (count % GROUP != 0), across = groups < GROUPS_ACROSS ? groups : GROUPS_ACROSS;
    saved_storage saved = vxs_volumes_save_storage(v);
    vxs_transmittance_set(map, NULL, 0);
    vxs_transmittance_set_reader(map, how);
    v->own.places = (places_block){count, first};
    vxs_volumes_use_storage(v, map->buffer, places);
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage + 2, left);
    gl_name program =
        vxs_volumes_program(v, &(program_texts){.names = VXS_SMOKE_NAMES, .body = &vxs_volumes_text_transmittance_places_glsl});
    if (count) dispatch(v, program, NULL, across, (groups + across - 1) / across, 1);
    vxs_volumes_restore_storage(v, &saved);
    return vxs_volumes_done(v);
}

int vxs_transmittance_is_of(const vxs_transmittance_map *map, const vxs_volumes *v, const vxs_volumes_light *light)
{
    return map->volumes == v && map->is_baked == !light->constants && (!map->is_baked || map->baked == light->baked_number - 1) &&
           is_lookup((vxs_curve_lookup)light->smoke_lookup);
}
