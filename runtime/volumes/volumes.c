/* Create, a frame, destroy; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "volumes_state.h"
#include "vxs_air_path.h"
#include "vxs_desc.h"

enum { FIRST_UNIT = 8, FIRST_STORAGE = 5 };

vxs_result vxs_volumes_fail(const vxs_volumes *v, vxs_result r, const char *text)
{
    if (v->log) v->log(VXS_SEVERITY_ERROR, text, v->user);
    return r;
}

void *vxs_volumes_alloc(const vxs_volumes *v, size_t size)
{
    return v->memory.alloc(size, v->memory.user);
}

void vxs_volumes_free(const vxs_volumes *v, void *memory, size_t size)
{
    if (memory) v->memory.free(memory, size, v->memory.user);
}

static vxs_result load(vxs_volumes *v, const vxs_volumes_desc *desc)
{
#define LOAD(result, name, arguments) v->api.name = (result(GL_CALL *) arguments)desc->get_proc_address("gl" #name, desc->user);
#define LOADED(result, name, arguments)                                                                                            \
    if (!v->api.name) return vxs_volumes_fail(v, VXS_E_GL, "the OpenGL context has no function gl" #name);
    VOLUMES_API(LOAD)
    VOLUMES_API(LOADED)
#undef LOADED
#undef LOAD
    const char *text  = (const char *)v->api.GetString(GL_NAME_VERSION);
    int         major = 0, minor = 0;
    if (text && sscanf(text, "%d.%d", &major, &minor) == 2 && 10 * major + minor >= 45) return VXS_OK;
    return vxs_volumes_fail(v, VXS_E_GL, "expected an OpenGL context of version 4.5 or later");
}

static vxs_result make(vxs_volumes *v, const vxs_volumes_desc *desc)
{
    int        most = 0;
    vxs_result r    = load(v, desc);
    if (r != VXS_OK) return r;
    v->api.GetIntegerv(GL_MOST_TEXTURE_SIZE, &most);
    if (v->width_px > (uint32_t)most || v->height_px > (uint32_t)most)
        return vxs_volumes_fail(v, VXS_E_GL, "width_px x height_px is larger than a texture of this context");
    vxs_volumes_cache_begin(v, desc->program_cache);
    vxs_volumes_forget_error(v);
    v->airlight = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, v->width_px, v->height_px, 0);
    v->api.CreateBuffers(BLOCKS, v->blocks);
    v->api.NamedBufferStorage(v->blocks[BLOCK_FRAME], sizeof v->frame, NULL, GL_STORAGE_DYNAMIC);
    v->api.NamedBufferStorage(v->blocks[BLOCK_OWN], sizeof v->own, NULL, GL_STORAGE_DYNAMIC);
    v->api.NamedBufferStorage(v->blocks[BLOCK_CURVES], sizeof v->curves, NULL, GL_STORAGE_DYNAMIC);
    v->cut_buffer = vxs_volumes_buffer(v, sizeof(uint32_t));
    v->api.CreateVertexArrays(1, &v->vertex_array);
    v->api.CreateFramebuffers(1, &v->target);
    v->api.NamedFramebufferTexture(v->target, GL_ATTACHMENT_COLOUR, v->airlight, 0);
    if (!v->airlight || !v->cut_buffer || v->api.GetError() != GL_ERROR_NONE) return VXS_E_MEMORY;
    return desc->has_half ? vxs_volumes_half_create(v) : VXS_OK;
}

vxs_result vxs_volumes_create(vxs_volumes **out, const vxs_volumes_desc *desc)
{
    vxs_volumes_desc known  = {0};
    const size_t     first  = offsetof(vxs_volumes_desc, log) + sizeof known.log;
    vxs_result       result = vxs_desc_take(&known, sizeof known, first, desc);
    *out                    = NULL;
    if (result != VXS_OK) return result;
    if (!known.get_proc_address || !known.shadows || !known.width_px || !known.height_px) return VXS_E_ARGUMENT;
    vxs_allocator memory = vxs_allocator_of(&(vxs_read_desc){.allocator = known.allocator});
    vxs_volumes  *v      = memory.alloc(sizeof *v, memory.user);
    if (!v) return VXS_E_MEMORY;
    *v     = (vxs_volumes){.memory        = memory,
                           .log           = known.log,
                           .user          = known.user,
                           .shadows       = known.shadows,
                           .width_px      = known.width_px,
                           .height_px     = known.height_px,
                           .first_unit    = known.first_unit ? known.first_unit : FIRST_UNIT,
                           .first_storage = known.first_storage ? known.first_storage : FIRST_STORAGE};
    result = make(v, &known);
    if (result == VXS_OK)
        *out = v;
    else
        vxs_volumes_destroy(v);
    return result;
}

void vxs_volumes_destroy(vxs_volumes *v)
{
    if (!v) return;
    vxs_allocator memory = v->memory;
    vxs_volumes_show_full(v);
    if (v->airlight) v->api.DeleteTextures(1, &v->airlight);
    if (v->blocks[0]) v->api.DeleteBuffers(BLOCKS, v->blocks);
    if (v->cut_buffer) v->api.DeleteBuffers(1, &v->cut_buffer);
    if (v->vertex_array) v->api.DeleteVertexArrays(1, &v->vertex_array);
    if (v->target) v->api.DeleteFramebuffers(1, &v->target);
    if (v->half_depths) v->api.DeleteTextures(1, &v->half_depths);
    if (v->other.depth_texture) v->api.DeleteTextures(1, &v->other.depth_texture);
    if (v->other.airlight) v->api.DeleteTextures(1, &v->other.airlight);
    if (v->other.target) v->api.DeleteFramebuffers(1, &v->other.target);
    for (uint32_t n = 0; n < v->program_count; n++)
        if (v->programs[n].name) v->api.DeleteProgram(v->programs[n].name);
    memory.free(v, sizeof *v, memory.user);
}

unsigned vxs_volumes_airlight(const vxs_volumes *v)
{
    return v->is_half ? v->other.airlight : v->airlight;
}

/* a frame ---------------------------------------------------------------------------------------------------------------------- */

/* Whether the medium is valid, as vxs_medium requires. */
static int is_medium(const vxs_volumes_frame *f)
{
    for (int n = 0; n < 3; n++)
        if (!(f->scattering[n] >= 0 && f->extinction[n] >= f->scattering[n] && isfinite(f->extinction[n]) && f->ambient[n] >= 0 &&
              isfinite(f->ambient[n])))
            return 0;
    return fabsf(f->anisotropy) <= 0.99F && !isnan(f->top_metres);
}

static int is_view(const vxs_volumes *v, const vxs_volumes_frame *f)
{
    for (int n = 0; n < 16; n++)
        if (!isfinite(f->view.point_from_depth[n])) return 0;
    for (int n = 0; n < 3; n++)
        if (!isfinite(f->eye[n])) return 0;
    return f->view.width_px && f->view.height_px && f->view.width_px <= v->width_px && f->view.height_px <= v->height_px &&
           f->far_metres > 0 && isfinite(f->far_metres) && f->min_radiance >= 0 && f->depth_texture;
}

vxs_result vxs_volumes_begin(vxs_volumes *v, const vxs_volumes_frame *frame)
{
    frame_block             *to    = &v->frame;
    vxs_volumes_frame        known = {0};
    const vxs_volumes_frame *f     = &known;
    const size_t             first = offsetof(vxs_volumes_frame, depth_texture) + sizeof known.depth_texture;
    vxs_volumes_show_full(v);
    v->depth_texture = 0;
    if (vxs_desc_take(&known, sizeof known, first, frame) != VXS_OK) return VXS_E_ARGUMENT;
    if (!is_medium(f))
        return vxs_volumes_fail(v, VXS_E_ARGUMENT,
                                "frame: expected 0 <= scattering <= extinction, ambient >= 0, anisotropy from -0.99 to 0.99");
    if (!is_view(v, f))
        return vxs_volumes_fail(
            v, VXS_E_ARGUMENT,
            "frame: expected finite numbers, far_metres > 0, depth_texture, and a view no larger than at create");
    *to              = (frame_block){.far_metres  = f->far_metres,
                                     .wide_px     = (float)f->view.width_px,
                                     .high_px     = (float)f->view.height_px,
                                     .empty_depth = f->view.empty_depth,
                                     .top_metres  = f->top_metres < (float)VXS_AIR_EVERYWHERE ? f->top_metres : 1e38F,
                                     .anisotropy  = f->anisotropy,
                                     .two         = 2};
    v->depth_texture = f->depth_texture;
    v->is_warming    = f->is_warming;
    v->least = v->frame_least = f->min_radiance;
    memcpy(to->point_from_depth, f->view.point_from_depth, sizeof to->point_from_depth);
    memcpy(to->eye, f->eye, sizeof to->eye);
    memcpy(to->scattering, f->scattering, sizeof to->scattering);
    memcpy(to->extinction, f->extinction, sizeof to->extinction);
    memcpy(to->ambient, f->ambient, sizeof to->ambient);
    v->api.ClearTexImage(v->airlight, 0, GL_FORMAT_RGBA, GL_TYPE_FLOAT, NULL);
    v->api.ClearNamedBufferSubData(v->cut_buffer, GL_FORMAT_R32UI, 0, sizeof(uint32_t), GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT,
                                   NULL);
    return VXS_OK;
}

/* The positions come from the matrix; its inverse is that of a rotation, except for a sun's scale. */
vxs_result vxs_volumes_set_light(vxs_volumes *v, const vxs_volumes_light *given, const vxs_shadow_depth_map *map)
{
    frame_block             *to    = &v->frame;
    vxs_volumes_light        known = {0};
    const vxs_volumes_light *light = &known;
    const size_t             first = offsetof(vxs_volumes_light, min_radiance) + sizeof known.min_radiance;
    if (vxs_desc_take(&known, sizeof known, first, given) != VXS_OK) return VXS_E_ARGUMENT;
    if (!v->depth_texture || (!light->constants && light->baked_number - 1 >= vxs_gl_light_count(v->shadows)))
        return VXS_E_ARGUMENT;
    for (int n = 0; n < 3; n++)
        if (!(light->colour[n] >= 0 && isfinite(light->colour[n]))) return VXS_E_ARGUMENT;
    to->light                    = light->constants ? *light->constants : vxs_gl_constants(v->shadows)[light->baked_number - 1];
    const vxs_light_constants *c = &to->light;
    int                        is_sun = c->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    if (!is_sun && !(light->radius_metres > 0 && isfinite(light->radius_metres))) return VXS_E_ARGUMENT;
    memcpy(to->colour, light->colour, sizeof to->colour);
    to->radius_metres = light->radius_metres;
    v->least          = light->min_radiance > 0 ? light->min_radiance : v->frame_least;
    to->cos_inner     = light->cos_inner > c->cos_outer ? light->cos_inner : c->cos_outer;
    const float *z = c->ls_from_ws + 8, length = sqrtf(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
    for (int n = 0; n < 3; n++) {
        to->axis[n]  = z[n] / length;
        to->place[n] = is_sun ? -to->axis[n]
                              : -(c->ls_from_ws[n] * c->ls_from_ws[3] + c->ls_from_ws[4 + n] * c->ls_from_ws[7] +
                                  c->ls_from_ws[8 + n] * c->ls_from_ws[11]);
    }
    to->map_side_px = map ? map->side_px : 0;
    to->map_layers  = map ? map->layers : 0;
    return VXS_OK;
}

float vxs_volumes_most(vxs_volumes *v, const vxs_volumes_light *light)
{
    return vxs_volumes_set_light(v, light, NULL) == VXS_OK ? (float)vxs_volumes_find_most(v) : 0;
}

vxs_cull_result vxs_volumes_cull(vxs_volumes *v, const vxs_volumes_light *light, vxs_pixels *pixels)
{
    *pixels = (vxs_pixels){0};
    return vxs_volumes_set_light(v, light, NULL) == VXS_OK ? vxs_volumes_find_cull_result(v, pixels) : VXS_CULLED_OFFSCREEN;
}

void vxs_volumes_add(vxs_volumes *v, gl_name program, gl_name map)
{
    enum { GROUP = 8 };
    vxs_pixels *p = &v->frame.pixels;
    if (vxs_volumes_find_cull_result(v, p) != VXS_NOT_CULLED) return;
    saved_state saved = vxs_volumes_use(v, program, map, v->airlight, GL_FORMAT_RGBA32F);
    vxs_volumes_dispatch(v, (p->wide_px + GROUP - 1) / GROUP, (p->high_px + GROUP - 1) / GROUP, 1);
    vxs_volumes_restore(v, &saved);
}
