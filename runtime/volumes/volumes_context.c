/* State of the OpenGL context: set for a pass, and restored; see volumes_state.h.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "volumes_state.h"

static const gl_enum tests[] = {GL_STATE_DEPTH_TEST,         GL_STATE_STENCIL_TEST, GL_STATE_SCISSOR_TEST,     GL_STATE_CULL_FACE,
                                GL_STATE_RASTERIZER_DISCARD, GL_STATE_DEPTH_CLAMP,  GL_STATE_PRIMITIVE_RESTART};
enum { TESTS = sizeof tests / sizeof *tests };
_Static_assert(sizeof((saved_raster *)0)->enabled == TESTS, "each is saved");

static const gl_enum image_state[] = {GL_IS_IMAGE_NAME,  GL_IS_IMAGE_LEVEL,  GL_IS_IMAGE_LAYERED,
                                      GL_IS_IMAGE_LAYER, GL_IS_IMAGE_ACCESS, GL_IS_IMAGE_FORMAT};
enum { IMAGE_STATE = sizeof image_state / sizeof *image_state };
_Static_assert(sizeof((saved_state *)0)->image == IMAGE_STATE * sizeof(int), "each is saved");

static const gl_enum blend_state[] = {GL_IS_BLEND_SRC_RGB,   GL_IS_BLEND_DST_RGB,      GL_IS_BLEND_SRC_ALPHA,
                                      GL_IS_BLEND_DST_ALPHA, GL_IS_BLEND_EQUATION_RGB, GL_IS_BLEND_EQUATION_ALPHA};
enum { BLEND_STATE = sizeof blend_state / sizeof *blend_state };
_Static_assert(sizeof((saved_raster *)0)->blend == BLEND_STATE * sizeof(int), "each is saved");

static const struct {
    gl_enum target, bound;
} unit_state[UNITS] = {
    [UNIT_DEPTHS] = {GL_TARGET_TEXTURE_2D, GL_IS_TEXTURE_2D},
    [UNIT_MAP]    = {GL_TARGET_TEXTURE_2D_ARRAY, GL_IS_TEXTURE_2D_ARRAY},
    [UNIT_OTHER]  = {GL_TARGET_TEXTURE_2D, GL_IS_TEXTURE_2D},
    [UNIT_MESH]   = {GL_TARGET_TEXTURE_BUFFER, GL_IS_TEXTURE_BUFFER},
};

/* Bind a texture to a unit, without a sampler; remember the previous bindings. */
static void bind_unit(const vxs_volumes *v, int unit, gl_name texture, saved_state *saved)
{
    v->api.ActiveTexture(GL_UNIT_0 + v->first_unit + (gl_enum)unit);
    v->api.GetIntegerv(unit_state[unit].bound, &saved->textures[unit]);
    v->api.GetIntegerv(GL_IS_SAMPLER, &saved->samplers[unit]);
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

/* Upload the block of the frame, and those of the technique and of its curves that have changed; bind all. The frame's is uploaded for
 * each pass: with Mesa's zink 22.3, a pass without any upload reads blocks of the passes after it. */
static void put_blocks(vxs_volumes *v)
{
    uploaded_blocks *to = &v->uploaded;
    const struct {
        const void *data;
        void       *uploaded;
        size_t      size;
    } blocks[BLOCKS] = {[BLOCK_FRAME]  = {&v->frame, &to->frame, sizeof v->frame},
                        [BLOCK_OWN]    = {&v->own, &to->own, sizeof v->own},
                        [BLOCK_CURVES] = {&v->curves, &to->curves, sizeof v->curves}};
    for (gl_name n = 0; n < BLOCKS; n++) {
        if (n == BLOCK_FRAME || !to->is_there[n] || memcmp(blocks[n].uploaded, blocks[n].data, blocks[n].size)) {
            v->api.NamedBufferSubData(v->blocks[n], 0, (gl_bytes)blocks[n].size, blocks[n].data);
            memcpy(blocks[n].uploaded, blocks[n].data, blocks[n].size);
            to->is_there[n] = 1;
        }
        v->api.BindBufferBase(GL_TARGET_UNIFORM_BUFFER, n, v->blocks[n]);
    }
}

saved_state vxs_volumes_use(vxs_volumes *v, gl_name program, gl_name map, gl_name image, gl_enum format)
{
    const volumes_api *api = &v->api;
    saved_state        saved;
    api->GetIntegerv(GL_IS_PROGRAM, &saved.program);
    api->GetIntegerv(GL_IS_ACTIVE_TEXTURE, &saved.active);
    bind_unit(v, UNIT_DEPTHS, v->depth_texture, &saved);
    bind_unit(v, UNIT_MAP, map, &saved);
    bind_unit(v, UNIT_OTHER, v->airlight, &saved);
    bind_unit(v, UNIT_MESH, 0, &saved);
    api->ActiveTexture((gl_enum)saved.active);

    api->GetIntegerv(GL_IS_UNIFORM_BUFFER, &saved.buffer);
    for (gl_name n = 0; n < BLOCKS; n++) {
        api->GetIntegeri_v(GL_IS_UNIFORM_BUFFER, n, &saved.blocks[n]);
        api->GetInteger64i_v(GL_IS_UNIFORM_BUFFER_START, n, &saved.block_starts[n]);
        api->GetInteger64i_v(GL_IS_UNIFORM_BUFFER_SIZE, n, &saved.block_sizes[n]);
    }
    put_blocks(v);

    for (int n = 0; n < IMAGE_STATE; n++) api->GetIntegeri_v(image_state[n], IMAGE_BINDING, &saved.image[n]);
    if (image) api->BindImageTexture(IMAGE_BINDING, image, 0, 1, 0, GL_ACCESS_READ_WRITE, format);
    vxs_gl_bind(v->shadows);
    api->UseProgram(program);
    return saved;
}

void vxs_volumes_restore(const vxs_volumes *v, const saved_state *saved)
{
    const volumes_api *api = &v->api;
    api->MemoryBarrier(GL_BARRIER_TEXTURE_FETCH | GL_BARRIER_IMAGE | GL_BARRIER_FRAMEBUFFER | GL_BARRIER_SHADER_STORAGE |
                       GL_BARRIER_BUFFER_UPDATE | GL_BARRIER_COMMANDS);
    api->UseProgram((gl_name)saved->program);
    const int *i = saved->image;
    api->BindImageTexture(IMAGE_BINDING, (gl_name)i[0], i[1], (unsigned char)(i[2] != 0), i[3], (gl_enum)i[4], (gl_enum)i[5]);
    for (gl_name n = 0; n < BLOCKS; n++)
        bind_as_it_was(v, GL_TARGET_UNIFORM_BUFFER, n, saved->blocks[n], saved->block_starts[n], saved->block_sizes[n]);
    api->BindBuffer(GL_TARGET_UNIFORM_BUFFER, (gl_name)saved->buffer);
    for (int unit = 0; unit < UNITS; unit++) {
        api->ActiveTexture(GL_UNIT_0 + v->first_unit + (gl_enum)unit);
        api->BindTexture(unit_state[unit].target, (gl_name)saved->textures[unit]);
        api->BindSampler(v->first_unit + (gl_name)unit, (gl_name)saved->samplers[unit]);
    }
    api->ActiveTexture((gl_enum)saved->active);
}

int vxs_volumes_can_draw(const vxs_volumes *v)
{
    return v->result == VXS_OK && !v->is_warming;
}

void vxs_volumes_dispatch(const vxs_volumes *v, uint32_t x, uint32_t y, uint32_t z)
{
    if (vxs_volumes_can_draw(v)) v->api.DispatchCompute(x, y, z);
}

void vxs_volumes_run(vxs_volumes *v, gl_name program, gl_name map, gl_name image, uint32_t groups_across, uint32_t groups_down)
{
    saved_state saved = vxs_volumes_use(v, program, map, image, GL_FORMAT_RGBA32F);
    vxs_volumes_dispatch(v, groups_across, groups_down, 1);
    vxs_volumes_restore(v, &saved);
}

saved_storage vxs_volumes_save_storage(const vxs_volumes *v)
{
    saved_storage saved;
    v->api.GetIntegerv(GL_IS_STORAGE_BUFFER, &saved.buffer);
    for (gl_name n = 0; n < STORAGES; n++) {
        v->api.GetIntegeri_v(GL_IS_STORAGE_BUFFER, v->first_storage + n, &saved.buffers[n]);
        v->api.GetInteger64i_v(GL_IS_STORAGE_BUFFER_START, v->first_storage + n, &saved.starts[n]);
        v->api.GetInteger64i_v(GL_IS_STORAGE_BUFFER_SIZE, v->first_storage + n, &saved.sizes[n]);
    }
    return saved;
}

void vxs_volumes_use_storage(const vxs_volumes *v, gl_name first, gl_name second)
{
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage, first);
    v->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, v->first_storage + 1, second);
}

void vxs_volumes_restore_storage(const vxs_volumes *v, const saved_storage *saved)
{
    for (gl_name n = 0; n < STORAGES; n++)
        bind_as_it_was(v, GL_TARGET_STORAGE_BUFFER, v->first_storage + n, saved->buffers[n], saved->starts[n], saved->sizes[n]);
    v->api.BindBuffer(GL_TARGET_STORAGE_BUFFER, (gl_name)saved->buffer);
}

/* drawing ---------------------------------------------------------------------------------------------------------------------- */

static void enable(const vxs_volumes *v, gl_enum what, int on)
{
    if (on)
        v->api.Enable(what);
    else
        v->api.Disable(what);
}

saved_raster vxs_volumes_draw(const vxs_volumes *v, gl_enum source, gl_enum destination, gl_enum destination_alpha)
{
    const volumes_api *api = &v->api;
    saved_raster       saved;
    api->GetIntegerv(GL_IS_VERTEX_ARRAY, &saved.array);
    api->GetIntegerv(GL_IS_VIEWPORT, saved.viewport);
    api->GetIntegerv(GL_IS_SCISSOR_BOX, saved.scissor);
    api->GetIntegerv(GL_IS_DRAW_FRAMEBUFFER, &saved.framebuffer);
    api->GetIntegerv(GL_IS_POLYGON_MODE, saved.polygon);
    api->GetIntegerv(GL_IS_FRONT_FACE, &saved.front);
    api->GetIntegerv(GL_IS_CLIP_ORIGIN, &saved.clip[0]);
    api->GetIntegerv(GL_IS_CLIP_DEPTHS, &saved.clip[1]);
    api->GetBooleani_v(GL_IS_COLOUR_MASK, 0, saved.mask);
    for (int n = 0; n < BLEND_STATE; n++) api->GetIntegeri_v(blend_state[n], 0, &saved.blend[n]);
    saved.blends = api->IsEnabledi(GL_STATE_BLEND, 0);
    for (int n = 0; n < TESTS; n++) {
        saved.enabled[n] = api->IsEnabled(tests[n]);
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
    return saved;
}

void vxs_volumes_restore_raster(const vxs_volumes *v, const saved_raster *saved)
{
    const volumes_api *api = &v->api;
    const int         *b = saved->blend, *p = saved->viewport, *s = saved->scissor;
    api->BlendFuncSeparatei(0, (gl_enum)b[0], (gl_enum)b[1], (gl_enum)b[2], (gl_enum)b[3]);
    api->BlendEquationSeparatei(0, (gl_enum)b[4], (gl_enum)b[5]);
    if (!saved->blends) api->Disablei(GL_STATE_BLEND, 0);
    api->ColorMaski(0, saved->mask[0], saved->mask[1], saved->mask[2], saved->mask[3]);
    api->PolygonMode(GL_FACES_FRONT_AND_BACK, (gl_enum)saved->polygon[0]);
    api->FrontFace((gl_enum)saved->front);
    api->ClipControl((gl_enum)saved->clip[0], (gl_enum)saved->clip[1]);
    for (int n = 0; n < TESTS; n++) enable(v, tests[n], saved->enabled[n]);
    api->BindFramebuffer(GL_TARGET_DRAW_FRAMEBUFFER, (gl_name)saved->framebuffer);
    api->Viewport(p[0], p[1], p[2], p[3]);
    api->Scissor(s[0], s[1], s[2], s[3]);
    api->BindVertexArray((gl_name)saved->array);
}
