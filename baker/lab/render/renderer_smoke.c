/* Smoke as the eye sees it: capsules over the picture, from back to front, each as dense as the ray's length in it. Their light
 * is looked up at four places each, and interpolated between these.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>

#include "baker/base/vec3.h"
#include "baker/lab/render/renderer_state.h"
#include "baker/lab/render/smoke_quads.h"

EMBEDDED(smoke_light_frag_glsl)
EMBEDDED(smoke_vert_glsl)
EMBEDDED(smoke_frag_glsl)
EMBEDDED(capsule_glsl)

/* Bindings; and the width of the texture with the lights of corners. */
enum {
    CAPSULES_BINDING = 5,
    CORNERS_BINDING  = 6,
    LEFT_BINDING     = 8,
    DEPTHS_UNIT      = 0,
    AIRLIGHT_UNIT    = 1,
    LIGHTS_UNIT      = 3,
    ROW              = 4096
};
enum { CAPSULES, CORNERS, PLACES, LEFT, BUFFERS };

/* Limit on samples that quads cover: they take a minute on two processors. */
static const double COVERED_MOST = 2e9;

struct smoke_cloud {
    const scene_smoke *smoke;
    smoke_quads        quads;
    GLuint             light_program, program, buffers[BUFFERS], lights, lights_frame;
    uint32_t           rows;
};

/* create ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result make_programs(const renderer *r, smoke_cloud *c, message *m)
{
    const text_part fragment[] = {{"#version 450 core\n", -1}, part_of(capsule_glsl), part_of(smoke_frag_glsl)};
    vxs_result      result     = renderer_lit_program(r, &c->light_program, smoke_light_frag_glsl, m);
    return result == VXS_OK ? renderer_program(r->gl, &c->program, smoke_vert_glsl, fragment, 3, m) : result;
}

static void take_buffer(const renderer *r, GLuint buffer, size_t size, const void *data)
{
    r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    r->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_DYNAMIC_DRAW);
}

vxs_result renderer_make_cloud(renderer *r, const scene_smoke *smoke, message *m)
{
    const gl_context *gl = r->gl;
    smoke_cloud      *c = r->cloud = calloc(1, sizeof *c);
    if (!c) return fail(m, VXS_E_MEMORY, "out of memory for smoke");
    size_t     corners = SMOKE_CORNERS * (size_t)smoke->count, layers = smoke_pass_layers(r->smoke);
    vxs_result result = smoke_quads_reserve(&c->quads, smoke, m);
    if (result == VXS_OK) result = make_programs(r, c, m);
    if (result != VXS_OK) return result;
    c->smoke = smoke;
    c->rows  = (uint32_t)((corners + ROW - 1) / ROW);
    gl->GenBuffers(BUFFERS, c->buffers);
    take_buffer(r, c->buffers[LEFT], (layers + !layers) * corners * sizeof(float), NULL);
    gl->CreateTextures(GL_TEXTURE_2D, 1, &c->lights);
    gl->TextureStorage2D(c->lights, 1, GL_RGBA32F, ROW, (GLsizei)c->rows);
    c->lights_frame = renderer_frame_of(gl, 0, &c->lights, 1);
    return gl->GetError() == GL_NO_ERROR ? VXS_OK
                                         : fail(m, VXS_E_MEMORY, "OpenGL has no room for %u capsules of smoke", smoke->count);
}

void renderer_free_cloud(renderer *r)
{
    smoke_cloud *c = r->cloud;
    if (!c) return;
    smoke_quads_free(&c->quads);
    r->gl->DeleteBuffers(BUFFERS, c->buffers);
    r->gl->DeleteTextures(1, &c->lights);
    r->gl->DeleteFramebuffers(1, &c->lights_frame);
    if (c->light_program) r->gl->DeleteProgram(c->light_program);
    if (c->program) r->gl->DeleteProgram(c->program);
    free(c);
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

static void upload(const renderer *r, smoke_cloud *c)
{
    smoke_eye eye     = {.seen         = r->seen,
                         .pixel_metres = 2 * sqrt(vec3_dot(r->seen.up, r->seen.up)) / r->height,
                         .all_px       = (double)r->width * r->height};
    size_t    corners = SMOKE_CORNERS * (size_t)c->quads.count;
    for (int n = 0; n < 3; n++) eye.at_ws[n] = r->camera.eye_ws[n];
    smoke_quads_make(&c->quads, c->smoke, &eye);
    take_buffer(r, c->buffers[CAPSULES], c->quads.count * sizeof *c->quads.capsules, c->quads.capsules);
    take_buffer(r, c->buffers[CORNERS], corners * sizeof *c->quads.corners, c->quads.corners);
    take_buffer(r, c->buffers[PLACES], corners * sizeof *c->quads.places, c->quads.places);
}

static vxs_result light_corners(const renderer *r, smoke_cloud *c)
{
    const gl_context *gl      = r->gl;
    uint32_t          corners = SMOKE_CORNERS * c->quads.count;
    vxs_result        result  = smoke_pass_ask(r->smoke, c->buffers[PLACES], corners, c->buffers[LEFT]);
    if (result != VXS_OK) return result;
    renderer_bind_lights(r);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, CAPSULES_BINDING, c->buffers[PLACES]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, LEFT_BINDING, c->buffers[LEFT]);
    gl->BindFramebuffer(GL_FRAMEBUFFER, c->lights_frame);
    gl->Viewport(0, 0, ROW, (GLsizei)c->rows);
    renderer_add_lights(r, c->light_program, "sizes", 2, (const GLint[4]){ROW, (GLint)corners, 0, 0});
    return VXS_OK;
}

static void set4(const renderer *r, const char *name, const double rgb[3], double last)
{
    GLuint p = r->cloud->program;
    r->gl->ProgramUniform4f(p, r->gl->GetUniformLocation(p, name), (float)rgb[0], (float)rgb[1], (float)rgb[2], (float)last);
}

/* Smoke gets the sky light of vertical surfaces; of a sky map, its mean. */
static void set_uniforms(const renderer *r)
{
    static const double sky[3] = {0.375, 0.4425, 0.5775}; /* between the ground and the sky of tone_frag.glsl */
    const fog_medium   *medium = r->options.fog;
    double              ambient[3], fog_ambient[3], extinction[3] = {0}, turned[3] = {0};
    renderer_fog_ambient(r, fog_ambient);
    if (r->sky) sky_pass_mean(r->sky, r->exposure, ambient);
    for (int n = 0; n < 3; n++) {
        if (!r->sky) ambient[n] = 0.30 * renderer_day(r) * sky[n];
        if (!medium) continue;
        extinction[n] = medium->extinction[n];
        if (extinction[n] > 0) turned[n] = fog_ambient[n] * medium->scattering[n] / extinction[n];
    }
    set4(r, "lights", (const double[3]){r->exposure, r->near_metres, 0}, 0);
    set4(r, "ambient", ambient, 0);
    set4(r, "extinction", extinction, medium ? fmin(medium->top_ws - r->camera.eye_ws[1], 1e30) : 1e30);
    set4(r, "turned", turned, fog_pass_far_metres(r->fog));
}

vxs_result renderer_draw_cloud(renderer *r, message *m)
{
    const gl_context *gl     = r->gl;
    smoke_cloud      *c      = r->cloud;
    const double      eye[3] = {0};
    float             matrix[16];
    upload(r, c);
    if (c->quads.covered_px > COVERED_MOST)
        warn(m,
             "smoke: %u capsules cover the picture %.0f times, which takes long to draw: a smaller picture, or --samples 1, takes "
             "less",
             c->quads.count, c->quads.covered_px / ((double)r->width * r->height));
    vxs_result result = light_corners(r, c);
    if (result != VXS_OK) return fail(m, result, "smoke cannot be drawn: %s", vxs_result_text(result));
    set_uniforms(r);
    renderer_clip(r, eye, matrix);
    gl->ProgramUniformMatrix4fv(c->program, gl->GetUniformLocation(c->program, "clip_from_eye"), 1, GL_FALSE, matrix);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, CAPSULES_BINDING, c->buffers[CAPSULES]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, CORNERS_BINDING, c->buffers[CORNERS]);
    gl->BindTextureUnit(DEPTHS_UNIT, r->target[DEPTHS]);
    gl->BindTextureUnit(AIRLIGHT_UNIT, fog_pass_airlight(r->fog));
    gl->BindTextureUnit(LIGHTS_UNIT, c->lights);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->picture_frame);
    gl->Viewport(0, 0, (GLsizei)r->width, (GLsizei)r->height);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl->UseProgram(c->program);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)(6 * c->quads.count));
    gl->Disable(GL_BLEND);
    return VXS_OK;
}
