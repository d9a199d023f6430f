/* Drawing alpha-tested triangles; see depth_block.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/depth_block.h"

#include <stddef.h>
#include <stdlib.h>

static const char vertex_text[] = "#version 450 core\n"
                                  "layout(location = 0) in vec3 position;\n"
                                  "layout(location = 1) in vec3 place;\n"
                                  "invariant gl_Position;\n"
                                  "out vec3 uvq;\n"
                                  "void main()\n"
                                  "{\n"
                                  "    gl_Position = vec4(position, 1.0);\n"
                                  "    uvq = place;\n"
                                  "}\n";

/* scene.c, in float. how: wrap modes of u and v, nearest. */
static const char fragment_text[] =
    "#version 450 core\n"
    "layout(binding = 0) uniform sampler2D image;\n"
    "layout(location = 0) uniform ivec4 how;\n"
    "layout(location = 1) uniform float threshold;\n"
    "in vec3 uvq;\n"
    "float reduced(float u, int wrap)\n"
    "{\n"
    "    return wrap == 1 ? clamp(u, -1.0, 2.0) : u - 2.0 * floor(0.5 * u);\n"
    "}\n"
    "int wrapped(int pixel, int width, int wrap)\n"
    "{\n"
    "    if (wrap == 1) return clamp(pixel, 0, width - 1);\n"
    "    int period = wrap == 2 ? 2 * width : width;\n"
    "    pixel = (pixel + period) % period;\n" /* reduced() returns no less than -1 */
    "    return pixel < width ? pixel : period - 1 - pixel;\n"
    "}\n"
    "float alpha(ivec2 at, ivec2 size)\n"
    "{\n"
    "    return texelFetch(image, ivec2(wrapped(at.x, size.x, how.x), wrapped(at.y, size.y, how.y)), 0).r;\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    ivec2 size = textureSize(image, 0);\n"
    "    vec2 uv = uvq.xy / uvq.z;\n"
    "    vec2 at = vec2(reduced(uv.x, how.x), reduced(uv.y, how.y)) * vec2(size);\n"
    "    float here;\n"
    "    if (how.z != 0) {\n"
    "        here = alpha(ivec2(floor(at)), size);\n"
    "    } else {\n"
    "        ivec2 p = ivec2(floor(at - 0.5));\n"
    "        vec2 share = at - 0.5 - vec2(p);\n"
    "        float a = alpha(p, size), b = alpha(p + ivec2(1, 0), size);\n"
    "        float c = alpha(p + ivec2(0, 1), size), d = alpha(p + ivec2(1, 1), size);\n"
    "        float above = a + share.x * (b - a), below = c + share.x * (d - c);\n"
    "        here = above + share.y * (below - above);\n"
    "    }\n"
    "    if (!(here >= threshold)) discard;\n"
    "}\n";

/* images ----------------------------------------------------------------------------------------------------------------------- */

vxs_result hole_images_init(hole_images *x, gl_context *gl, const casters *c, run_context *m)
{
    *x = (hole_images){.gl = gl, .casters = c};
    if (!c->alpha_mask_count) return VXS_OK;
    x->textures = calloc(c->alpha_mask_count, sizeof *x->textures);
    if (!x->textures) return fail(m, VXS_E_MEMORY, "out of memory for %zu masks", c->alpha_mask_count);
    for (size_t n = 0; n < c->alpha_mask_count; n++) {
        if (c->alpha_mask_first[n] == c->alpha_mask_first[n + 1]) continue;
        for (size_t same = 0; same < n && !x->textures[n]; same++)
            if (c->alpha_masks[same].image == c->alpha_masks[n].image) x->textures[n] = x->textures[same];
        if (!x->textures[n]) {
            const alpha_image *image = &c->images[c->alpha_masks[n].image];
            GLsizei            width = (GLsizei)image->width_px, height = (GLsizei)image->height_px;
            gl->CreateTextures(GL_TEXTURE_2D, 1, &x->textures[n]);
            gl->TextureStorage2D(x->textures[n], 1, GL_R8, width, height);
            gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
            gl->PixelStorei(GL_UNPACK_ROW_LENGTH, 0);
            gl->TextureSubImage2D(x->textures[n], 0, 0, 0, width, height, GL_RED, GL_UNSIGNED_BYTE, image->alpha);
            gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
        }
    }
    vxs_result r =
        gl_program(gl, &x->program, (const gl_text[]){{vertex_text, -1}, {0}}, (const gl_text[]){{fragment_text, -1}, {0}}, m);
    if (r == VXS_OK && gl->GetError() != GL_NO_ERROR) r = fail(m, VXS_E_GL, "OpenGL cannot take the images of alpha masks");
    return r;
}

void hole_images_free(hole_images *x)
{
    if (x->textures) {
        /* masks may share a texture: OpenGL ignores names that are already deleted */
        x->gl->DeleteTextures((GLsizei)x->casters->alpha_mask_count, x->textures);
        x->gl->DeleteProgram(x->program);
    }
    free(x->textures);
    *x = (hole_images){0};
}

/* triangles -------------------------------------------------------------------------------------------------------------------- */

vxs_result holed_triangles_init(holed_triangles *t, const hole_images *images, const projection *p, run_context *m)
{
    size_t count = p->triangle_count - p->holed_first;
    *t           = (holed_triangles){.images = images, .projection = p};
    if (!count) return VXS_OK;
    t->corners  = malloc(count * sizeof *t->corners);
    t->triangle = malloc(count * sizeof *t->triangle);
    if (!t->corners || !t->triangle) return fail(m, VXS_E_MEMORY, "out of memory for %zu alpha-tested triangles", count);

    gl_context *gl = images->gl;
    gl->GenVertexArrays(1, &t->vertex_array);
    gl->BindVertexArray(t->vertex_array);
    gl->GenBuffers(1, &t->buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, t->buffer);
    gl->EnableVertexAttribArray(0);
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(hole_corner), NULL);
    gl->VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(hole_corner), (const void *)offsetof(hole_corner, at));
    return VXS_OK;
}

void holed_triangles_free(holed_triangles *t)
{
    if (t->vertex_array) t->images->gl->DeleteVertexArrays(1, &t->vertex_array);
    if (t->buffer) t->images->gl->DeleteBuffers(1, &t->buffer);
    free(t->corners);
    free(t->triangle);
    *t = (holed_triangles){0};
}

void holed_triangles_draw(const holed_triangles *t)
{
    if (!t->count) return;
    gl_context   *gl    = t->images->gl;
    const size_t *first = t->projection->alpha_mask_first;
    gl->BindVertexArray(t->vertex_array);
    gl->BindBuffer(GL_ARRAY_BUFFER, t->buffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(t->count * sizeof *t->corners), t->corners, GL_STREAM_DRAW);
    gl->UseProgram(t->images->program);
    uint32_t begin = 0;
    for (size_t mask = 0; mask < t->images->casters->alpha_mask_count; mask++) {
        uint32_t end = begin;
        while (end < t->count && t->triangle[end] < first[mask + 1]) end++;
        if (end == begin) continue;

        const hole_images *x = t->images;
        const alpha_mask  *a = &x->casters->alpha_masks[mask];
        x->gl->BindTextureUnit(0, x->textures[mask]);
        x->gl->ProgramUniform4i(x->program, 0, (GLint)a->wrap_u, (GLint)a->wrap_v, a->nearest, 0);
        x->gl->ProgramUniform1f(x->program, 1, a->threshold);

        gl->DrawArrays(GL_TRIANGLES, (GLint)(begin * 3), (GLsizei)((end - begin) * 3));
        begin = end;
    }
}
