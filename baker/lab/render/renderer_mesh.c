/* A picture of the mesh of a light in fog; see render.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "baker/base/embedded.h"
#include "baker/lab/render/renderer_state.h"

EMBEDDED(mesh_vert_glsl)
EMBEDDED(mesh_frag_glsl)

enum { MESH_BINDING = 5 };

/* The matrix from light space to clip space. Rows of the light's matrix are orthogonal, and positions are relative to the eye:
 * so its inverse has the rows as columns. */
static void clip_from_ls(const renderer *r, const vxs_light_constants *light, float out[16])
{
    const double eye[3] = {0};
    float        clip[16];
    renderer_clip(r, eye, clip);
    for (int n = 0; n < 16; n++) out[n] = n < 12 ? 0 : clip[n];
    for (int row = 0; row < 3; row++) {
        const float *ls = light->ls_from_ws + 4 * row, square = ls[0] * ls[0] + ls[1] * ls[1] + ls[2] * ls[2];
        for (int k = 0; k < 4; k++) {
            for (int n = 0; n < 3; n++) out[4 * row + k] += clip[4 * n + k] * ls[n] / square;
            out[12 + k] -= out[4 * row + k] * ls[3];
        }
    }
}

/* Whether counterclockwise in light space stays so in the picture: the sign of a determinant of x, y and w. */
static int turn_of(const float m[16])
{
    double sum = 0;
    for (int n = 0; n < 3; n++) {
        int a = (n + 1) % 3, b = (n + 2) % 3;
        sum += (double)m[4 * n] * ((double)m[4 * a + 1] * (double)m[4 * b + 3] - (double)m[4 * b + 1] * (double)m[4 * a + 3]);
    }
    return sum < 0 ? -1 : 1;
}

static void draw(const renderer *r, GLuint program, const vxs_light_mesh *mesh, const vxs_light_constants *light)
{
    const gl_context *gl      = r->gl;
    const float       none[4] = {0};
    GLsizei           corners = 3 * (GLsizei)vxs_light_mesh_triangles(mesh);
    float             matrix[16];
    clip_from_ls(r, light, matrix);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "clip_from_ls"), 1, GL_FALSE, matrix);
    gl->ProgramUniform1i(program, gl->GetUniformLocation(program, "first_place"), corners);
    gl->ProgramUniform1i(program, gl->GetUniformLocation(program, "turn"), turn_of(matrix));
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

vxs_result renderer_read_mesh(renderer *r, float *light, message *m)
{
    uint32_t              number;
    GLuint                program;
    const vxs_light_mesh *mesh     = fog_pass_mesh(r->fog, &number);
    const text_part       fragment = part_of(mesh_frag_glsl);
    vxs_result            result   = renderer_program(r->gl, &program, mesh_vert_glsl, &fragment, 1, m);
    if (result == VXS_OK) {
        draw(r, program, mesh, &vxs_gl_constants(r->shadows)[number]);
        renderer_read_target(r, LIGHTS, GL_RGB, GL_FLOAT, 3 * sizeof *light, light);
    }
    r->gl->DeleteProgram(program);
    return result;
}
