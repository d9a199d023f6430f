/* Fog at half the width and height; see vxs_volumes.h. Techniques draw a view of half the size, with depths of its own, into an
 * airlight of its own.
 * SPDX-License-Identifier: MIT */
#include "volumes_state.h"

enum { GROUP = 8 };

static uint32_t half_of(uint32_t pixels)
{
    return (pixels + 1) / 2;
}

vxs_result vxs_volumes_half_create(vxs_volumes *v)
{
    volumes_view *half = &v->other;
    uint32_t      wide = half_of(v->width_px), high = half_of(v->height_px);
    v->half_depths = vxs_volumes_texture(v, GL_FORMAT_RG32F, wide, high, 1);
    half->airlight = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, wide, high, 0);
    if (!v->half_depths || !half->airlight) return VXS_E_MEMORY;
    v->api.GenTextures(1, &half->depth_texture); /* techniques read a texture, upsampling an array */
    v->api.TextureView(half->depth_texture, GL_TARGET_TEXTURE_2D, v->half_depths, GL_FORMAT_RG32F, 0, 1, 0, 1);
    v->api.CreateFramebuffers(1, &half->target);
    v->api.NamedFramebufferTexture(half->target, GL_ATTACHMENT_COLOUR, half->airlight, 0);
    return v->api.GetError() == GL_ERROR_NONE ? VXS_OK : VXS_E_GL;
}

static void exchange(vxs_volumes *v)
{
    volumes_view now = {v->depth_texture, v->airlight, v->target, v->frame.wide_px, v->frame.high_px};
    v->depth_texture = v->other.depth_texture;
    v->airlight      = v->other.airlight;
    v->target        = v->other.target;
    v->frame.wide_px = v->other.wide_px;
    v->frame.high_px = v->other.high_px;
    v->other         = now;
    v->is_half       = !v->is_half;
}

void vxs_volumes_show_full(vxs_volumes *v)
{
    if (v->is_half) exchange(v);
}

static void dispatch(vxs_volumes *v, gl_name program, gl_name map, gl_name sampled, gl_name image, gl_enum format, uint32_t wide,
                     uint32_t high)
{
    v->frame.pixels   = (vxs_pixels){0, 0, wide, high};
    saved_state saved = vxs_volumes_use(v, program, map, image, format);
    v->api.ActiveTexture(GL_UNIT_0 + v->first_unit + UNIT_OTHER);
    v->api.BindTexture(GL_TARGET_TEXTURE_2D, sampled);
    vxs_volumes_dispatch(v, (wide + GROUP - 1) / GROUP, (high + GROUP - 1) / GROUP, 1);
    vxs_volumes_restore(v, &saved);
}

vxs_result vxs_volumes_begin_half(vxs_volumes *v)
{
    if (!v->depth_texture || !v->half_depths || v->is_half) return VXS_E_ARGUMENT;
    uint32_t wide = half_of((uint32_t)v->frame.wide_px), high = half_of((uint32_t)v->frame.high_px);
    gl_name  program = vxs_volumes_program(v, &(program_texts){.body = &vxs_volumes_text_half_depths_glsl});
    dispatch(v, program, 0, 0, v->other.depth_texture, GL_FORMAT_RG32F, wide, high);
    v->other.wide_px = (float)wide;
    v->other.high_px = (float)high;
    exchange(v);
    v->api.ClearTexImage(v->airlight, 0, GL_FORMAT_RGBA, GL_TYPE_FLOAT, NULL);
    return vxs_volumes_done(v);
}

vxs_result vxs_volumes_end_half(vxs_volumes *v)
{
    if (!v->depth_texture || !v->is_half) return VXS_E_ARGUMENT;
    vxs_volumes_show_full(v);
    v->own.upsample = (upsample_block){(uint32_t)v->other.wide_px, (uint32_t)v->other.high_px};
    gl_name program = vxs_volumes_program(v, &(program_texts){.body = &vxs_volumes_text_upsample_glsl});
    dispatch(v, program, v->half_depths, v->other.airlight, v->airlight, GL_FORMAT_RGBA32F, (uint32_t)v->frame.wide_px,
             (uint32_t)v->frame.high_px);
    return vxs_volumes_done(v);
}
