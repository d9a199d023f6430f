/* Lookups of a frame's lights, and what a frame's drawing and its read-back have in common; see renderer_state.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/volumes/vxs_air_light.h" /* first: box.h defines a type with the name of one of its functions */

#include "baker/base/vec3.h"
#include "baker/lab/render/renderer_state.h"

EMBEDDED(vxs_air_light_h)
EMBEDDED(lit_glsl)

enum { COLOURS_BINDING = 3 };

void renderer_clip(const renderer *r, const double eye[3], float m[16])
{
    const camera_view *v      = &r->seen;
    const double      *row[3] = {v->right, v->up, v->forward};
    memset(m, 0, 16 * sizeof *m);
    for (int i = 0; i < 3; i++) {
        int    to     = i == 2 ? 3 : i;
        double square = vec3_dot(row[i], row[i]);
        for (int n = 0; n < 3; n++) m[4 * n + to] = (float)(row[i][n] / square);
        m[12 + to] = (float)(-vec3_dot(row[i], eye) / square);
    }
    m[14] = (float)r->near_metres;
}

int renderer_culls(const renderer *r)
{
    return r->options.cull == CULL_ON || (r->options.cull == CULL_AUTO && r->light_count > 1);
}

double renderer_day(const renderer *r)
{
    return r->sky ? 0 : r->day ? 1 : 0.07;
}

void renderer_fog_ambient(const renderer *r, double ambient[3])
{
    static const double horizon[3] = {0.070, 0.081, 0.095};
    for (int n = 0; n < 3; n++) ambient[n] = renderer_day(r) * horizon[n];
}

vxs_result renderer_lit_program(const renderer *r, GLuint *program, embedded fragment, vxs_filter filter, run_context *m)
{
    const char *texts[VXS_GL_TEXTS];
    char        knows[128], only[64];
    gl_text     parts[VXS_GL_TEXTS + 6];
    snprintf(knows, sizeof knows, "#define FILTER %s(%d)\n#define LIGHTS_AT_ONCE %uu\n%s%s%s",
             filter.is_smooth ? "vxs_smooth" : "vxs_box", filter.width_px, LIGHTS_AT_ONCE,
             r->options.stream ? "#define STREAMED\n" : "", r->moving ? "#define MOVING\n" : "", r->smoke ? "#define SMOKE\n" : "");
    const gl_text own[] = {{knows, -1}, gl_embedded(vxs_air_light_h), gl_embedded(lit_glsl), gl_embedded(fragment), {0}};
    vxs_gl_texts(r->shadows, texts);
    snprintf(only, sizeof only, "#define VXS_ONLY_WIDTH %d\n#define VXS_ONLY_SMOOTH %d\n", filter.width_px, filter.is_smooth);
    parts[0] = (gl_text){texts[0], -1};
    parts[1] = (gl_text){only, -1};
    for (int n = 1; n < VXS_GL_TEXTS; n++) parts[n + 1] = (gl_text){texts[n], -1};
    memcpy(parts + VXS_GL_TEXTS + 1, own, sizeof own);
    return gl_screen_program(r->gl, program, parts, m);
}

void renderer_begin_screen(const renderer *r, GLuint frame, GLuint program, GLuint textures, uint32_t width, uint32_t height)
{
    const gl_context *gl = r->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl->Viewport(0, 0, (GLsizei)width, (GLsizei)height);
    for (GLuint n = 0; n < textures; n++) gl->BindTextureUnit(n, r->target[n]);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "point_from_depth"), 1, GL_FALSE,
                                r->view.point_from_depth);
}

void renderer_bind_lights(const renderer *r)
{
    vxs_gl_bind(r->shadows);
    if (r->moving) moving_pass_bind(r->moving);
    if (r->smoke) smoke_pass_bind(r->smoke);
    r->gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, COLOURS_BINDING, r->colour_buffer);
}

void renderer_add_lights(const renderer *r, GLuint program, const char *uniform, int element, const GLint values[4])
{
    const gl_context *gl       = r->gl;
    const float       black[4] = {0};
    GLint             v[4]     = {values[0], values[1], values[2], values[3]};
    gl->ClearBufferfv(GL_COLOR, 0, black);
    gl->Enable(GL_BLEND);
    gl->BlendEquation(GL_FUNC_ADD);
    gl->BlendFunc(GL_ONE, GL_ONE);
    gl->UseProgram(program);
    gl->BindVertexArray(r->empty_array);

    /* the fog that dims lights on their way, relative to the eye */
    const fog_medium *f      = r->is_clear ? NULL : r->options.fog;
    float             fog[4] = {0, 0, 0, (float)VXS_AIR_EVERYWHERE};
    for (int n = 0; n < 3 && f; n++) fog[n] = (float)f->extinction[n];
    if (f && f->top_ws < INFINITY) fog[3] = (float)(f->top_ws - r->camera.eye_ws[1]);
    r->gl->ProgramUniform4f(program, r->gl->GetUniformLocation(program, "fog"), fog[0], fog[1], fog[2], fog[3]);

    for (uint32_t first = 0; first < r->light_count; first += LIGHTS_AT_ONCE) {
        v[element] = (GLint)first;
        gl->ProgramUniform4i(program, gl->GetUniformLocation(program, uniform), v[0], v[1], v[2], v[3]);
        gl->DrawArrays(GL_TRIANGLES, 0, 3);
    }
    gl->Disable(GL_BLEND);
}

void renderer_shade(const renderer *r, int show, uint32_t light)
{
    const gl_context *gl       = r->gl;
    GLuint            p        = r->shade_program;
    const GLint       asked[4] = {show, (GLint)light, renderer_culls(r), 0};
    gl->ProgramUniform4f(p, gl->GetUniformLocation(p, "sizes"), (float)r->width, (float)r->height, 0, 0);
    gl->BindTextureUnit(LIGHTS, 0); /* unbind the texture that is the target now */
    renderer_bind_lights(r);
    renderer_begin_screen(r, r->light_frame, p, LIGHTS, r->width, r->height);
    renderer_add_lights(r, p, "asked", 3, asked);
}
