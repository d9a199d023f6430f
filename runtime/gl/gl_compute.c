/* Compute programs, and the state of the context around their passes; see gl_state.h.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"

#define TEXT_OF(number)    TEXT_OF_IT(number)
#define TEXT_OF_IT(number) #number

enum { TEXTS_MAX = VXS_GL_TEXTS + 8 };

int vxs_gl_can_compute(const vxs_gl *gl)
{
#define THERE(result, name, arguments)                                                                                             \
    if (!gl->api.name) return 0;
    GL_COMPUTE_API(THERE)
#undef THERE
    return !gl->is_texture;
}

gl_name vxs_gl_compute(const vxs_gl *gl, const char *head, const char *const *texts, int count)
{
    static const char names[] = "#define VXS_VIEW_METRES " TEXT_OF(VXS_VIEW_METRES) "\n";
    const gl_api     *api     = &gl->api;
    const char       *common[VXS_GL_TEXTS], *all[TEXTS_MAX] = {gl->head, head, names};
    int               good = 0;
    vxs_gl_texts(gl, common);
    memcpy(all + 3, common + 1, (VXS_GL_TEXTS - 1) * sizeof *all);
    for (int n = 0; n < count; n++) all[VXS_GL_TEXTS + 2 + n] = texts[n];

    gl_name shader = api->CreateShader(GL_KIND_COMPUTE_SHADER), program = api->CreateProgram();
    api->ShaderSource(shader, VXS_GL_TEXTS + 2 + count, all, NULL);
    api->CompileShader(shader);
    api->AttachShader(program, shader);
    api->DeleteShader(shader);
    api->LinkProgram(program);
    api->GetProgramiv(program, GL_STATUS_LINK, &good);
    if (good) return program;
    char log[1024] = "";
    api->GetShaderInfoLog(shader, sizeof log, NULL, log); /* the program still holds the shader */
    api->DeleteProgram(program);
    vxs_gl_fail(gl, VXS_E_GL, log);
    return 0;
}

gl_pass vxs_gl_begin_pass(const vxs_gl *gl, gl_name program, gl_name depths)
{
    const gl_api *api = &gl->api;
    gl_pass       pass;
    api->GetIntegerv(GL_IS_PROGRAM, &pass.program);
    api->GetIntegerv(GL_IS_ACTIVE_TEXTURE, &pass.unit);
    api->ActiveTexture(GL_UNIT_0);
    api->GetIntegerv(GL_IS_TEXTURE_2D, &pass.texture);
    api->GetIntegerv(GL_IS_SAMPLER, &pass.sampler);
    api->BindTexture(GL_TARGET_TEXTURE_2D, depths);
    api->BindSampler(0, 0);
    api->UseProgram(program);
    return pass;
}

void vxs_gl_set_view(const vxs_gl *gl, gl_name program, const vxs_view *v)
{
    const gl_api *api = &gl->api;
    api->Uniform1i(api->GetUniformLocation(program, "vxs_depths"), 0);
    api->UniformMatrix4fv(api->GetUniformLocation(program, "vxs_point_from_depth"), 1, 0, v->point_from_depth);
    api->Uniform4f(api->GetUniformLocation(program, "vxs_sizes"), (float)v->width_px, (float)v->height_px, v->empty_depth, 0);
}

void vxs_gl_end_pass(const vxs_gl *gl, const gl_pass *pass)
{
    const gl_api *api = &gl->api;
    api->UseProgram((gl_name)pass->program);
    api->BindTexture(GL_TARGET_TEXTURE_2D, (gl_name)pass->texture);
    api->BindSampler(0, (gl_name)pass->sampler);
    api->ActiveTexture((gl_enum)pass->unit);
}
