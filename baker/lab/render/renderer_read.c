/* Reads back a renderer's results and properties; see render.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>

#include "baker/base/vec3.h"
#include "baker/files/png_encode.h"
#include "baker/lab/render/renderer_state.h"

EMBEDDED(light_mesh_glsl)

/* Reverse the order of rows: OpenGL has the bottom row first. */
static void turn_over(void *pixels, size_t row_bytes, uint32_t height)
{
    char *p = pixels;
    for (uint32_t y = 0; y < height / 2; y++) {
        char *a = p + y * row_bytes, *b = p + (height - 1 - y) * row_bytes;
        for (size_t n = 0; n < row_bytes; n++) {
            char c = a[n];
            a[n]   = b[n];
            b[n]   = c;
        }
    }
}

/* Read a target's pixels, top row first.   out  [width * height] of pixel_bytes each */
static void renderer_read_target(const renderer *r, int target, GLenum format, GLenum type, size_t pixel_bytes, void *out)
{
    int      small = target == SCREEN || target == LINEAR;
    uint32_t width = small ? r->options.width_px : r->width, height = small ? r->options.height_px : r->height;
    r->gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    r->gl->GetTextureImage(r->target[target], 0, format, type, (GLsizei)(width * height * pixel_bytes), out);
    turn_over(out, width * pixel_bytes, height);
}

vxs_result renderer_read_screen(const renderer *r, uint8_t *rgb, run_context *m)
{
    uint32_t width = r->options.width_px, height = r->options.height_px;
    float   *screen = malloc(3 * sizeof *screen * width * height);
    if (!screen) return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u pixels", width, height);
    renderer_read_target(r, SCREEN, GL_RGB, GL_FLOAT, 3 * sizeof *screen, screen);
    for (uint32_t n = 0; n < width * height; n++)
        for (size_t k = 0; k < 3; k++)
            rgb[3 * (size_t)n + k] = png_dithered((double)screen[3 * (size_t)n + k], n % width, n / width);
    free(screen);
    return VXS_OK;
}

vxs_result renderer_read_linear(renderer *r, float *rgb, run_context *m)
{
    renderer_read_target(r, LINEAR, GL_RGB, GL_FLOAT, 3 * sizeof *rgb, rgb);
    return r->gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot give back a picture");
}

vxs_result renderer_read(renderer *r, float *depths, float *normals, float *albedos, float *light, run_context *m)
{
    size_t count = (size_t)r->width * r->height;
    if (depths) {
        renderer_read_target(r, DEPTHS, GL_DEPTH_COMPONENT, GL_FLOAT, sizeof(float), depths);
        for (size_t n = 0; n < count; n++) depths[n] = depths[n] > 0 ? (float)r->near_metres / depths[n] : 0;
    }
    if (normals) renderer_read_target(r, NORMALS, GL_RGB, GL_FLOAT, 3 * sizeof(float), normals);
    if (albedos) renderer_read_target(r, ALBEDOS, GL_RGB, GL_FLOAT, 3 * sizeof(float), albedos);
    if (light) renderer_read_target(r, LIGHTS, GL_RGBA, GL_FLOAT, 4 * sizeof(float), light);
    return r->gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot give back a picture");
}

vxs_result renderer_read_lit(renderer *r, uint32_t n, float *lit, run_context *m)
{
    size_t count = (size_t)r->width * r->height;
    float *light = malloc(4 * count * sizeof *light);
    if (!light) return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    renderer_shade(r, SHOW_LIT, n);
    vxs_result result = renderer_read(r, NULL, NULL, NULL, light, m);
    for (size_t i = 0; result == VXS_OK && i < count; i++) lit[i] = light[4 * i + 3] > 0 ? light[4 * i] : -1;
    free(light);
    return result;
}

/* Read a texture with all samples of a pass.   out  [channels * count] */
static vxs_result read_texture(const renderer *r, GLuint texture, GLenum format, size_t channels, float *out, run_context *m)
{
    size_t row = channels * sizeof *out * r->width;
    r->gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    r->gl->GetTextureImage(texture, 0, format, GL_FLOAT, (GLsizei)(row * r->height), out);
    turn_over(out, row, r->height);
    return r->gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot give back a picture");
}

vxs_result renderer_read_texture(renderer *r, render_texture which, float *rgb, run_context *m)
{
    GLuint texture = which == TEXTURE_AREAS ? vxs_area_light_irradiance(r->areas->vpls->light)
                     : which == TEXTURE_SKY ? vxs_area_light_irradiance(r->sky->vpls->light)
                                            : vxs_volumes_airlight(r->fog->volumes);
    return read_texture(r, texture, GL_RGB, 3, rgb, m);
}

vxs_result renderer_read_full(renderer *r, float *full, run_context *m)
{
    size_t count = (size_t)r->width * r->height;
    float *found = malloc(4 * count * sizeof *found); /* channels: lookups, those in full, unused, whether there is a surface */
    if (!found) return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    renderer_shade(r, SHOW_FULL, 0);
    vxs_result result = renderer_read(r, NULL, NULL, NULL, found, m);
    for (size_t n = 0; result == VXS_OK && n < count; n++) {
        const float *f = found + 4 * n;
        full[n]        = !(f[3] > 0) ? -1 : f[0] > 0 ? f[1] / f[0] : RENDER_NOT_ASKED;
    }
    free(found);
    return result;
}

void renderer_place(const renderer *r, uint32_t x, uint32_t y, float depth, double place_ws[3])
{
    double across = 2 * (x + 0.5) / r->width - 1, up = 1 - 2 * (y + 0.5) / r->height;
    for (int n = 0; n < 3; n++)
        place_ws[n] = r->camera.eye_ws[n] + (double)depth * (r->seen.forward[n] + across * r->seen.right[n] + up * r->seen.up[n]);
}

void renderer_fog_left(const renderer *r, const float *depths, float *left)
{
    for (uint32_t n = 0; n < r->width * r->height; n++) {
        double way[3], direction[3], part[3];
        renderer_place(r, n % r->width, n / r->width, depths[n] > 0 ? depths[n] : 1, way);
        vec3_sub(way, r->camera.eye_ws, way);
        double metres = sqrt(vec3_dot(way, way));
        for (int k = 0; k < 3; k++) direction[k] = way[k] / metres;
        fog_pass_left(r->fog, r->camera.eye_ws, direction, depths[n] > 0 ? metres : INFINITY, part);
        for (size_t k = 0; k < 3; k++) left[3 * (size_t)n + k] = (float)part[k];
    }
}

render_facts renderer_facts(const renderer *r)
{
    uint32_t light;
    return (render_facts){.name         = r->gl->names.renderer,
                          .width        = r->width,
                          .height       = r->height,
                          .exposure     = r->exposure,
                          .white        = 1 / (3.14159265358979324 * r->scale * r->exposure),
                          .culls        = renderer_culls(r),
                          .is_in_fog    = r->options.fog != NULL,
                          .fog_grid     = r->fog ? r->fog->options.grid : 0,
                          .has_mesh     = r->fog && fog_pass_mesh(r->fog, &light),
                          .fog_lights   = r->options.fog ? r->fog->lights : NULL,
                          .smoke_lights = r->smoke ? r->smoke->lights : NULL,
                          .areas        = r->areas,
                          .sky          = r->sky};
}

vxs_result renderer_read_grid(const renderer *r, float *dark, run_context *m)
{
    return fog_pass_read_grid(r->fog, dark, m);
}

vxs_result renderer_read_smoke(renderer *r, uint32_t n, float *left, run_context *m)
{
    return read_texture(r, r->smoke->pictures[r->smoke->layer_of[n]], GL_RED, 1, left, m);
}

vxs_result renderer_read_through(renderer *r, float *left, run_context *m)
{
    size_t count = (size_t)r->width * r->height;
    renderer_read_target(r, PICTURE, GL_ALPHA, GL_FLOAT, sizeof *left, left);
    for (size_t n = 0; n < count; n++) left[n] = 1 - left[n];
    return r->gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot give back a picture");
}

/* the mesh of a light ---------------------------------------------------------------------------------------------------------- */

enum { MESH_BINDING = 5 };

static void draw_mesh(const renderer *r, GLuint program, const vxs_light_mesh *mesh, const vxs_light_constants *light)
{
    const gl_context *gl      = r->gl;
    const float       none[4] = {0};
    GLsizei           corners = 3 * (GLsizei)vxs_light_mesh_triangles(mesh);
    float             matrix[16];

    /* from light space to clip space: rows of the light's matrix are orthogonal, and positions are relative to the eye, so its
     * inverse has the rows as columns */
    const double eye[3] = {0};
    float        clip[16];
    renderer_clip(r, eye, clip);
    for (int n = 0; n < 16; n++) matrix[n] = n < 12 ? 0 : clip[n];
    for (int row = 0; row < 3; row++) {
        const float *ls = light->ls_from_ws + 4 * row, square = ls[0] * ls[0] + ls[1] * ls[1] + ls[2] * ls[2];
        for (int k = 0; k < 4; k++) {
            for (int n = 0; n < 3; n++) matrix[4 * row + k] += clip[4 * n + k] * ls[n] / square;
            matrix[12 + k] -= matrix[4 * row + k] * ls[3];
        }
    }

    /* whether counterclockwise in light space stays so in the picture: the sign of a determinant of x, y and w */
    double turn = 0;
    for (int n = 0; n < 3; n++) {
        const float *x = matrix + 4 * n, *a = matrix + 4 * ((n + 1) % 3), *b = matrix + 4 * ((n + 2) % 3);
        turn += (double)x[0] * ((double)a[1] * (double)b[3] - (double)b[1] * (double)a[3]);
    }

    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "clip_from_ls"), 1, GL_FALSE, matrix);
    gl->ProgramUniform1i(program, gl->GetUniformLocation(program, "first_place"), corners);
    gl->ProgramUniform1i(program, gl->GetUniformLocation(program, "turn"), turn < 0 ? -1 : 1);
    gl->ProgramUniform1f(program, gl->GetUniformLocation(program, "farthest"),
                         (float)(r->near_metres / fog_pass_far_metres(r->fog)));
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->light_frame);
    gl->Viewport(0, 0, (GLsizei)r->width, (GLsizei)r->height);
    gl->ClearBufferfv(GL_COLOR, 0, none);
    gl->BindTextureUnit(0, r->target[DEPTHS]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, MESH_BINDING, vxs_light_mesh_buffer(mesh));
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_ONE, GL_ONE);
    gl->UseProgram(program);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, corners);
    gl->Disable(GL_BLEND);
}

vxs_result renderer_read_mesh(renderer *r, float *light, run_context *m)
{
    uint32_t              number;
    GLuint                program;
    const vxs_light_mesh *mesh   = fog_pass_mesh(r->fog, &number);
    vxs_result            result = gl_program_of(r->gl, &program, light_mesh_glsl, (gl_text){0}, m);
    if (result == VXS_OK) {
        draw_mesh(r, program, mesh, &vxs_gl_constants(r->shadows)[number]);
        renderer_read_target(r, LIGHTS, GL_RGB, GL_FLOAT, 3 * sizeof *light, light);
    }
    r->gl->DeleteProgram(program);
    return result;
}
