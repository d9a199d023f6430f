/* State of the OpenGL context: set for a pass, and restored; see volumes_state.h.
 * SPDX-License-Identifier: MIT */
#include "volumes_state.h"

static const gl_enum tests[] = {GL_STATE_DEPTH_TEST,         GL_STATE_STENCIL_TEST, GL_STATE_SCISSOR_TEST,     GL_STATE_CULL_FACE,
                                GL_STATE_RASTERIZER_DISCARD, GL_STATE_DEPTH_CLAMP,  GL_STATE_PRIMITIVE_RESTART};
enum { TESTS = sizeof tests / sizeof *tests };
_Static_assert(sizeof((raster_kept *)0)->enabled == TESTS, "each is kept");

static const gl_enum image_state[] = {GL_IS_IMAGE_NAME,  GL_IS_IMAGE_LEVEL,  GL_IS_IMAGE_LAYERED,
                                      GL_IS_IMAGE_LAYER, GL_IS_IMAGE_ACCESS, GL_IS_IMAGE_FORMAT};
enum { IMAGE_STATE = sizeof image_state / sizeof *image_state };
_Static_assert(sizeof((volumes_kept *)0)->image == IMAGE_STATE * sizeof(int), "each is kept");

static const gl_enum blend_state[] = {GL_IS_BLEND_SRC_RGB,   GL_IS_BLEND_DST_RGB,      GL_IS_BLEND_SRC_ALPHA,
                                      GL_IS_BLEND_DST_ALPHA, GL_IS_BLEND_EQUATION_RGB, GL_IS_BLEND_EQUATION_ALPHA};
enum { BLEND_STATE = sizeof blend_state / sizeof *blend_state };
_Static_assert(sizeof((raster_kept *)0)->blend == BLEND_STATE * sizeof(int), "each is kept");

static const struct {
    gl_enum target, bound;
} unit_state[UNITS] = {
    [UNIT_DEPTHS] = {GL_TARGET_TEXTURE_2D, GL_IS_TEXTURE_2D},
    [UNIT_MAP]    = {GL_TARGET_TEXTURE_2D_ARRAY, GL_IS_TEXTURE_2D_ARRAY},
    [UNIT_OTHER]  = {GL_TARGET_TEXTURE_2D, GL_IS_TEXTURE_2D},
    [UNIT_MESH]   = {GL_TARGET_TEXTURE_BUFFER, GL_IS_TEXTURE_BUFFER},
};

/* Bind a texture to a unit, without a sampler; remember the previous bindings. */
static void bind_unit(const vxs_volumes *v, int unit, gl_name texture, volumes_kept *kept)
{
    v->api.ActiveTexture(GL_UNIT_0 + v->first_unit + (gl_enum)unit);
    v->api.GetIntegerv(unit_state[unit].bound, &kept->textures[unit]);
    v->api.GetIntegerv(GL_IS_SAMPLER, &kept->samplers[unit]);
    v->api.BindTexture(unit_state[unit].target, texture);
    v->api.BindSampler(v->first_unit + (gl_name)unit, 0);
}

/* Bind a part of a buffer; a size of 0: the whole buffer. */
static void bind_as_it_was(const vxs_volumes *v, gl_enum target, gl_name binding, int buffer, int64_t start, int64_t size)
{
    if (buffer && size)
        v->api.BindBufferRange(target, binding, (gl_name)buffer, (gl_bytes)start, (gl_bytes)size);
    else
        v->api.BindBufferBase(target, binding, (gl_name)buffer);
}

volumes_kept vxs_volumes_use(const vxs_volumes *v, gl_name program, gl_name map, gl_name image, gl_enum format)
{
    const volumes_api *api = &v->api;
    volumes_kept       kept;
    api->GetIntegerv(GL_IS_PROGRAM, &kept.program);
    api->GetIntegerv(GL_IS_ACTIVE_TEXTURE, &kept.active);
    bind_unit(v, UNIT_DEPTHS, v->depth_texture, &kept);
    bind_unit(v, UNIT_MAP, map, &kept);
    bind_unit(v, UNIT_OTHER, v->airlight, &kept);
    bind_unit(v, UNIT_MESH, 0, &kept);
    api->ActiveTexture((gl_enum)kept.active);

    api->GetIntegerv(GL_IS_UNIFORM_BUFFER, &kept.buffer);
    api->GetIntegeri_v(GL_IS_UNIFORM_BUFFER, FRAME_BINDING, &kept.frame);
    api->GetInteger64i_v(GL_IS_UNIFORM_BUFFER_START, FRAME_BINDING, &kept.frame_start);
    api->GetInteger64i_v(GL_IS_UNIFORM_BUFFER_SIZE, FRAME_BINDING, &kept.frame_size);
    api->NamedBufferSubData(v->frame_buffer, 0, sizeof v->frame, &v->frame);
    api->BindBufferBase(GL_TARGET_UNIFORM_BUFFER, FRAME_BINDING, v->frame_buffer);

    for (int n = 0; n < IMAGE_STATE; n++) api->GetIntegeri_v(image_state[n], IMAGE_BINDING, &kept.image[n]);
    if (image) api->BindImageTexture(IMAGE_BINDING, image, 0, 1, 0, GL_ACCESS_READ_WRITE, format);
    vxs_gl_bind(v->shadows);
    api->UseProgram(program);
    return kept;
}

void vxs_volumes_put_back(const vxs_volumes *v, const volumes_kept *kept)
{
    const volumes_api *api = &v->api;
    api->MemoryBarrier(GL_BARRIER_TEXTURE_FETCH | GL_BARRIER_IMAGE | GL_BARRIER_FRAMEBUFFER | GL_BARRIER_SHADER_STORAGE |
                       GL_BARRIER_BUFFER_UPDATE | GL_BARRIER_COMMANDS);
    api->UseProgram((gl_name)kept->program);
    const int *i = kept->image;
    api->BindImageTexture(IMAGE_BINDING, (gl_name)i[0], i[1], (unsigned char)(i[2] != 0), i[3], (gl_enum)i[4], (gl_enum)i[5]);
    bind_as_it_was(v, GL_TARGET_UNIFORM_BUFFER, FRAME_BINDING, kept->frame, kept->frame_start, kept->frame_size);
    api->BindBuffer(GL_TARGET_UNIFORM_BUFFER, (gl_name)kept->buffer);
    for (int unit = 0; unit < UNITS; unit++) {
        api->ActiveTexture(GL_UNIT_0 + v->first_unit + (gl_enum)unit);
        api->BindTexture(unit_state[unit].target, (gl_name)kept->textures[unit]);
        api->BindSampler(v->first_unit + (gl_name)unit, (gl_name)kept->samplers[unit]);
    }
    api->ActiveTexture((gl_enum)kept->active);
}

void vxs_volumes_run(const vxs_volumes *v, gl_name program, gl_name map, gl_name image, uint32_t groups_across,
                     uint32_t groups_down)
{
    volumes_kept kept = vxs_volumes_use(v, program, map, image, GL_FORMAT_RGBA32F);
    v->api.DispatchCompute(groups_across, groups_down, 1);
    vxs_volumes_put_back(v, &kept);
}

storage_kept vxs_volumes_keep_storage(const vxs_volumes *v)
{
    storage_kept kept;
    v->api.GetIntegerv(GL_IS_STORAGE_BUFFER, &kept.buffer);
    for (gl_name n = 0; n < STORAGES; n++) {
        v->api.GetIntegeri_v(GL_IS_STORAGE_BUFFER, v->first_storage + n, &kept.buffers[n]);
        v->api.GetInteger64i_v(GL_IS_STORAGE_BUFFER_START, v->first_storage + n, &kept.starts[n]);
        v->api.GetInteger64i_v(GL_IS_STORAGE_BUFFER_SIZE, v->first_storage + n, &kept.sizes[n]);
    }
    return kept;
}

void vxs_volumes_use_storage(const vxs_volumes *v, gl_name first, gl_name second)
{
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage, first);
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage + 1, second);
}

void vxs_volumes_put_back_storage(const vxs_volumes *v, const storage_kept *kept)
{
    for (gl_name n = 0; n < STORAGES; n++)
        bind_as_it_was(v, GL_TARGET_STORAGE_BUFFER, v->first_storage + n, kept->buffers[n], kept->starts[n], kept->sizes[n]);
    v->api.BindBuffer(GL_TARGET_STORAGE_BUFFER, (gl_name)kept->buffer);
}

/* drawing ---------------------------------------------------------------------------------------------------------------------- */

static void enable(const vxs_volumes *v, gl_enum what, int on)
{
    if (on)
        v->api.Enable(what);
    else
        v->api.Disable(what);
}

raster_kept vxs_volumes_draw(const vxs_volumes *v, gl_enum source, gl_enum destination, gl_enum destination_alpha)
{
    const volumes_api *api = &v->api;
    raster_kept        kept;
    api->GetIntegerv(GL_IS_VERTEX_ARRAY, &kept.array);
    api->GetIntegerv(GL_IS_VIEWPORT, kept.viewport);
    api->GetIntegerv(GL_IS_SCISSOR_BOX, kept.scissor);
    api->GetIntegerv(GL_IS_DRAW_FRAMEBUFFER, &kept.framebuffer);
    api->GetIntegerv(GL_IS_POLYGON_MODE, kept.polygon);
    api->GetIntegerv(GL_IS_FRONT_FACE, &kept.front);
    api->GetIntegerv(GL_IS_CLIP_ORIGIN, &kept.clip[0]);
    api->GetIntegerv(GL_IS_CLIP_DEPTHS, &kept.clip[1]);
    api->GetBooleani_v(GL_IS_COLOUR_MASK, 0, kept.mask);
    for (int n = 0; n < BLEND_STATE; n++) api->GetIntegeri_v(blend_state[n], 0, &kept.blend[n]);
    kept.blends = api->IsEnabledi(GL_STATE_BLEND, 0);
    for (int n = 0; n < TESTS; n++) {
        kept.enabled[n] = api->IsEnabled(tests[n]);
        enable(v, tests[n], tests[n] == GL_STATE_DEPTH_CLAMP);
    }
    api->BindVertexArray(v->vertex_array);
    api->Viewport(0, 0, (int)v->frame.wide_px, (int)v->frame.high_px);
    api->PolygonMode(GL_FACES_FRONT_AND_BACK, GL_POLYGON_FILL);
    api->FrontFace(GL_FACE_COUNTERCLOCKWISE);
    api->ClipControl(GL_CLIP_LOWER_LEFT, GL_CLIP_NEGATIVE_ONE_TO_ONE);
    api->ColorMaski(0, 1, 1, 1, 1);
    api->Enablei(GL_STATE_BLEND, 0);
    api->BlendEquationSeparatei(0, GL_BLEND_ADD, GL_BLEND_ADD);
    api->BlendFuncSeparatei(0, source, destination, GL_BLEND_ONE, destination_alpha);
    return kept;
}

void vxs_volumes_put_back_raster(const vxs_volumes *v, const raster_kept *kept)
{
    const volumes_api *api = &v->api;
    const int         *b = kept->blend, *p = kept->viewport, *s = kept->scissor;
    api->BlendFuncSeparatei(0, (gl_enum)b[0], (gl_enum)b[1], (gl_enum)b[2], (gl_enum)b[3]);
    api->BlendEquationSeparatei(0, (gl_enum)b[4], (gl_enum)b[5]);
    if (!kept->blends) api->Disablei(GL_STATE_BLEND, 0);
    api->ColorMaski(0, kept->mask[0], kept->mask[1], kept->mask[2], kept->mask[3]);
    api->PolygonMode(GL_FACES_FRONT_AND_BACK, (gl_enum)kept->polygon[0]);
    api->FrontFace((gl_enum)kept->front);
    api->ClipControl((gl_enum)kept->clip[0], (gl_enum)kept->clip[1]);
    for (int n = 0; n < TESTS; n++) enable(v, tests[n], kept->enabled[n]);
    api->BindFramebuffer(GL_TARGET_DRAW_FRAMEBUFFER, (gl_name)kept->framebuffer);
    api->Viewport(p[0], p[1], p[2], p[3]);
    api->Scissor(s[0], s[1], s[2], s[3]);
    api->BindVertexArray((gl_name)kept->array);
}
