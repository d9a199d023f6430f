/* Arrays of words on the GPU; see gl_state.h.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"

/* State that affects texture uploads. */
static const gl_enum unpacking[] = {GL_IS_UNPACK_ROW_LENGTH, GL_IS_UNPACK_SKIP_ROWS, GL_IS_UNPACK_SKIP_PIXELS,
                                    GL_IS_UNPACK_ALIGNMENT};
enum { UNPACKING = sizeof unpacking / sizeof *unpacking };

typedef struct texture_state {
    int texture, buffer, unpack[UNPACKING];
} texture_state;

static texture_state begin_texture(const gl_api *api, gl_name texture)
{
    texture_state s;
    api->GetIntegerv(GL_IS_TEXTURE_2D, &s.texture);
    api->GetIntegerv(GL_IS_PIXEL_UNPACK_BUFFER, &s.buffer);
    for (int n = 0; n < UNPACKING; n++) {
        api->GetIntegerv(unpacking[n], &s.unpack[n]);
        api->PixelStorei(unpacking[n], unpacking[n] == GL_IS_UNPACK_ALIGNMENT ? 4 : 0);
    }
    api->BindBuffer(GL_TARGET_PIXEL_UNPACK_BUFFER, 0);
    api->BindTexture(GL_TARGET_TEXTURE_2D, texture);
    return s;
}

static void end_texture(const gl_api *api, const texture_state *s)
{
    for (int n = 0; n < UNPACKING; n++) api->PixelStorei(unpacking[n], s->unpack[n]);
    api->BindBuffer(GL_TARGET_PIXEL_UNPACK_BUFFER, (gl_name)s->buffer);
    api->BindTexture(GL_TARGET_TEXTURE_2D, (gl_name)s->texture);
}

static void forget_error(const gl_api *api)
{
    for (int n = 0; n < 16 && api->GetError() != GL_ERROR_NONE; n++) continue; /* a lost context returns an error forever */
}

static int make_buffer(const vxs_gl *gl, gl_words *w)
{
    gl->api.GenBuffers(1, &w->name);
    gl->api.BindBuffer(GL_TARGET_COPY_WRITE_BUFFER, w->name);
    gl->api.BufferData(GL_TARGET_COPY_WRITE_BUFFER, (gl_bytes)((size_t)w->count * sizeof(uint32_t)), NULL, GL_USAGE_DYNAMIC_DRAW);
    gl->api.BindBuffer(GL_TARGET_COPY_WRITE_BUFFER, 0);
    return gl->api.GetError() == GL_ERROR_NONE;
}

static int make_texture(const vxs_gl *gl, gl_words *w)
{
    const gl_api *api    = &gl->api;
    uint64_t      texels = ((uint64_t)w->count + w->lanes - 1) / w->lanes, rows = (texels + w->wide - 1) / w->wide;
    int           most = 0;
    api->GetIntegerv(GL_MOST_TEXTURE_SIZE, &most);
    if (rows > (uint64_t)most || w->wide > (uint32_t)most) return 0;
    api->GenTextures(1, &w->name);
    texture_state s = begin_texture(api, w->name);
    api->TexImage2D(GL_TARGET_TEXTURE_2D, 0, w->lanes == 4 ? GL_FORMAT_RGBA32UI : GL_FORMAT_R32UI, (int)w->wide, (int)rows, 0,
                    w->lanes == 4 ? GL_FORMAT_RGBA_INTEGER : GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT, NULL);
    api->TexParameteri(GL_TARGET_TEXTURE_2D, GL_SET_MIN_FILTER, GL_FILTER_NEAREST);
    api->TexParameteri(GL_TARGET_TEXTURE_2D, GL_SET_MAG_FILTER, GL_FILTER_NEAREST);
    api->TexParameteri(GL_TARGET_TEXTURE_2D, GL_SET_MAX_LEVEL, 0);
    end_texture(api, &s);
    return api->GetError() == GL_ERROR_NONE;
}

int vxs_gl_words_make(const vxs_gl *gl, gl_words *w, uint64_t count, uint32_t lanes, uint32_t wide)
{
    *w = (gl_words){.count = (uint32_t)count, .lanes = lanes, .wide = wide};
    if (count > UINT32_MAX || count > PTRDIFF_MAX / sizeof(uint32_t)) return 0;
    forget_error(&gl->api);
    if (gl->is_texture ? make_texture(gl, w) : make_buffer(gl, w)) return 1;
    vxs_gl_words_delete(gl, w);
    return 0;
}

void vxs_gl_words_delete(const vxs_gl *gl, gl_words *w)
{
    if (w->name && gl->is_texture) gl->api.DeleteTextures(1, &w->name);
    if (w->name && !gl->is_texture) gl->api.DeleteBuffers(1, &w->name);
    *w = (gl_words){0};
}

/* Writes the rest of the first row, whole rows, and the start of the last row. */
static void write_texture(const vxs_gl *gl, const gl_words *w, const uint32_t *words, uint32_t first, uint32_t count)
{
    gl_enum       format = w->lanes == 4 ? GL_FORMAT_RGBA_INTEGER : GL_FORMAT_RED_INTEGER;
    uint32_t      at = first / w->lanes, end = at + (count + w->lanes - 1) / w->lanes;
    texture_state s = begin_texture(&gl->api, w->name);
    while (at < end) {
        uint32_t x = at % w->wide, rows = x ? 0 : (end - at) / w->wide, some = rows ? rows * w->wide : w->wide - x;
        if (some > end - at) some = end - at;
        gl->api.TexSubImage2D(GL_TARGET_TEXTURE_2D, 0, (int)x, (int)(at / w->wide), (int)(rows ? w->wide : some),
                              rows ? (int)rows : 1, format, GL_TYPE_UNSIGNED_INT, words);
        words += (size_t)some * w->lanes;
        at += some;
    }
    end_texture(&gl->api, &s);
}

void vxs_gl_words_write(const vxs_gl *gl, const gl_words *w, const uint32_t *words, uint32_t first, uint32_t count)
{
    if (!count) return;
    if (gl->is_texture) {
        write_texture(gl, w, words, first, count);
        return;
    }
    gl->api.BindBuffer(GL_TARGET_COPY_WRITE_BUFFER, w->name);
    gl->api.BufferSubData(GL_TARGET_COPY_WRITE_BUFFER, (gl_bytes)((size_t)first * sizeof *words),
                          (gl_bytes)((size_t)count * sizeof *words), words);
    gl->api.BindBuffer(GL_TARGET_COPY_WRITE_BUFFER, 0);
}

void vxs_gl_words_bind_at(const vxs_gl *gl, const gl_words *w, uint32_t binding)
{
    gl->api.BindBufferBase(GL_TARGET_STORAGE_BUFFER, binding, w->name);
}

void vxs_gl_words_bind(const vxs_gl *gl, const gl_words *w, uint32_t place)
{
    if (!w->name) return;
    if (!gl->is_texture) {
        vxs_gl_words_bind_at(gl, w, gl->first_binding + place);
        return;
    }
    int active;
    gl->api.GetIntegerv(GL_IS_ACTIVE_TEXTURE, &active);
    gl->api.ActiveTexture(GL_UNIT_0 + gl->first_binding + place);
    gl->api.BindTexture(GL_TARGET_TEXTURE_2D, w->name);
    gl->api.ActiveTexture((gl_enum)active);
}

const uint32_t *vxs_gl_words_map(const vxs_gl *gl, const gl_words *w, uint32_t count)
{
    gl->api.BindBuffer(GL_TARGET_COPY_WRITE_BUFFER, w->name);
    return gl->api.MapBufferRange(GL_TARGET_COPY_WRITE_BUFFER, 0, (gl_bytes)(count * sizeof(uint32_t)), GL_MAP_READ);
}

void vxs_gl_words_unmap(const vxs_gl *gl)
{
    gl->api.UnmapBuffer(GL_TARGET_COPY_WRITE_BUFFER);
    gl->api.BindBuffer(GL_TARGET_COPY_WRITE_BUFFER, 0);
}

gl_name vxs_gl_depths_make(const vxs_gl *gl, uint32_t side_px, uint32_t bits)
{
    static const int parameters[][2] = {{GL_SET_MIN_FILTER, GL_FILTER_LINEAR},
                                        {GL_SET_MAG_FILTER, GL_FILTER_LINEAR},
                                        {GL_SET_WRAP_S, GL_WRAP_CLAMP},
                                        {GL_SET_WRAP_T, GL_WRAP_CLAMP},
                                        {GL_SET_COMPARE_MODE, GL_COMPARE_TO_TEXTURE},
                                        {GL_SET_COMPARE_FUNCTION, GL_COMPARE_LEQUAL},
                                        {GL_SET_MAX_LEVEL, 0}};
    const gl_api    *api             = &gl->api;
    int              most            = 0;
    gl_name          texture         = 0;
    api->GetIntegerv(GL_MOST_TEXTURE_SIZE, &most);
    if (side_px > (uint32_t)most) {
        vxs_gl_fail(gl, VXS_E_MEMORY, "a depth texture would be larger than this context holds: use a coarser level");
        return 0;
    }
    forget_error(api);
    api->GenTextures(1, &texture);
    texture_state s = begin_texture(api, texture);
    api->TexImage2D(GL_TARGET_TEXTURE_2D, 0, bits == 16 ? GL_FORMAT_DEPTH16 : GL_FORMAT_DEPTH32F, (int)side_px, (int)side_px, 0,
                    GL_FORMAT_DEPTH, bits == 16 ? GL_TYPE_UNSIGNED_SHORT : GL_TYPE_FLOAT, NULL);
    for (size_t n = 0; n < sizeof parameters / sizeof *parameters; n++)
        api->TexParameteri(GL_TARGET_TEXTURE_2D, (gl_enum)parameters[n][0], parameters[n][1]);
    end_texture(api, &s);
    if (api->GetError() == GL_ERROR_NONE) return texture;
    api->DeleteTextures(1, &texture);
    return 0;
}

void vxs_gl_depths_write(const vxs_gl *gl, gl_name texture, uint32_t bits, gl_rectangle to, gl_name buffer, const void *depths)
{
    texture_state s = begin_texture(&gl->api, texture);
    gl->api.BindBuffer(GL_TARGET_PIXEL_UNPACK_BUFFER, buffer);
    gl->api.TexSubImage2D(GL_TARGET_TEXTURE_2D, 0, to.x, to.y, to.wide, to.high, GL_FORMAT_DEPTH,
                          bits == 16 ? GL_TYPE_UNSIGNED_SHORT : GL_TYPE_FLOAT, depths);
    end_texture(&gl->api, &s);
}
