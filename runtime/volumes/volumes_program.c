/* Programs and textures; see volumes_state.h.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "volumes_state.h"
#include "vxs_air_light.h"

/* A program begins with the texts of vxs_gl, for OpenGL 4.5 whatever language the caller uses, and the texts common to this
 * library. */
enum { TEXTS = VXS_GL_TEXTS + 41, LOG_BYTES = 1024 };

static void texts_of(const vxs_volumes *v, gl_enum kind, char *own, size_t own_size, const char *names, const char *body,
                     const char *texts[TEXTS])
{
    const char *shared[VXS_GL_TEXTS];
    vxs_gl_texts(v->shadows, shared);
    snprintf(own, own_size,
             "#define VXS_AT_FRAME %u\n#define VXS_AT_IMAGE %u\n#define VXS_AT_DEPTHS %u\n#define VXS_AT_MAP %u\n"
             "#define VXS_AT_OTHER %u\n#define VXS_AT_GRID %u\n#define VXS_AT_MESH %u\n#define VXS_NO_END 1e30\n#define "
             "VXS_FAR_MOST 1e15\n%s",
             FRAME_BINDING, IMAGE_BINDING, v->first_unit + UNIT_DEPTHS, v->first_unit + UNIT_MAP, v->first_unit + UNIT_OTHER,
             v->first_storage, v->first_unit + UNIT_MESH, kind == GL_KIND_COMPUTE_SHADER ? "#define VXS_COMPUTE\n" : "");
    const char *const all[TEXTS] = {"#version 450 core\n",
                                    strchr(shared[0], '\n') + 1,
                                    "#undef VXS_ONLY_KIND\n#undef VXS_ONLY_CUBE\n#undef VXS_ONLY_CODING\n",
                                    own,
                                    names,
                                    shared[1],
                                    shared[2],
                                    shared[3],
                                    shared[4],
                                    shared[5],
                                    shared[6],
                                    vxs_volumes_text_vxs_depths_h,
                                    vxs_volumes_text_vxs_intervals_h,
                                    vxs_volumes_text_vxs_air_light_h,
                                    vxs_volumes_text_vxs_air_ray_h,
                                    vxs_volumes_text_vxs_air_h,
                                    vxs_volumes_text_vxs_air_path_h,
                                    vxs_volumes_text_vxs_light_mesh_h,
                                    vxs_volumes_text_frame_glsl,
                                    vxs_volumes_text_first_shadow_glsl,
                                    "#ifdef VXS_USES_GRID\n#define vxs_grid_word(words, i) vxs_grid.words[i]\n",
                                    vxs_volumes_text_vxs_epipolar_h,
                                    vxs_volumes_text_grid_glsl,
                                    vxs_volumes_text_area_glsl,
                                    vxs_volumes_text_area_map_glsl,
                                    vxs_volumes_text_vxs_shadow_grid_h,
                                    "#ifdef VXS_USES_AREA\n",
                                    vxs_volumes_text_vxs_area_grid_h,
                                    "#endif\n#endif\n",
                                    "#ifdef VXS_USES_CURVES\n#define vxs_curve_number(curves, i) "
                                    "uintBitsToFloat(vxs_curves.words[(curves) + uint(i)])\n",
                                    vxs_volumes_text_curves_glsl,
                                    vxs_volumes_text_vxs_curve_h,
                                    vxs_volumes_text_capsule_glsl,
                                    vxs_volumes_text_transmittance_glsl,
                                    "#ifdef VXS_USES_AREA\n",
                                    vxs_volumes_text_area_curves_glsl,
                                    "#else\n",
                                    vxs_volumes_text_transmittance_light_glsl,
                                    "#endif\n",
                                    vxs_volumes_text_transmittance_lists_glsl,
                                    "#endif\n",
                                    vxs_volumes_text_area_surface_glsl,
                                    vxs_volumes_text_mesh_glsl,
                                    "#ifdef VXS_USES_QUADS\n",
                                    vxs_volumes_text_mesh_quads_glsl,
                                    vxs_volumes_text_vxs_mesh_quads_h,
                                    "#endif\n",
                                    body};
    memcpy(texts, all, sizeof all);
}

static void attach(const vxs_volumes *v, gl_name program, gl_enum kind, const char *names, const char *body)
{
    char        own[512];
    char        log[LOG_BYTES];
    int         good = 0;
    const char *texts[TEXTS];
    gl_name     shader = v->api.CreateShader(kind);
    texts_of(v, kind, own, sizeof own, names, body, texts);
    v->api.ShaderSource(shader, TEXTS, texts, NULL);
    v->api.CompileShader(shader);
    v->api.GetShaderiv(shader, GL_STATUS_COMPILE, &good);
    if (!good && v->log) {
        v->api.GetShaderInfoLog(shader, sizeof log, NULL, log);
        v->log(VXS_SEVERITY_ERROR, log, v->user);
    }
    v->api.AttachShader(program, shader);
    v->api.DeleteShader(shader);
}

static gl_name linked(const vxs_volumes *v, gl_name program)
{
    int good = 0;
    v->api.LinkProgram(program);
    v->api.GetProgramiv(program, GL_STATUS_LINK, &good);
    if (good) {
        vxs_gl_link(v->shadows, program);
        return program;
    }
    v->api.DeleteProgram(program);
    return 0;
}

gl_name vxs_volumes_compile(const vxs_volumes *v, const char *names, const char *vertex, const char *body)
{
    gl_name program = v->api.CreateProgram();
    if (vertex) attach(v, program, GL_KIND_VERTEX_SHADER, names, vertex);
    attach(v, program, vertex ? GL_KIND_FRAGMENT_SHADER : GL_KIND_COMPUTE_SHADER, names, body);
    return linked(v, program);
}

static int is_program(const volumes_program *p, const char *names, const char *vertex, const char *body)
{
    return p->body == body && p->vertex == vertex && !strcmp(p->names, names);
}

gl_name vxs_volumes_raster(vxs_volumes *v, const char *names, const char *vertex, const char *body)
{
    uint32_t n = 0;
    while (n < v->program_count && !is_program(&v->programs[n], names, vertex, body)) n++;
    if (n == PROGRAMS_MOST) {
        v->result = VXS_E_GL;
        return 0;
    }
    volumes_program *p = &v->programs[n];
    if (n == v->program_count) {
        *p = (volumes_program){.vertex = vertex, .body = body};
        snprintf(p->names, sizeof p->names, "%s", names);
        p->name = vxs_volumes_compile(v, p->names, vertex, body);
        v->program_count++;
    }
    if (!p->name) v->result = VXS_E_GL;
    return p->name;
}

gl_name vxs_volumes_compute(vxs_volumes *v, const char *names, const char *body)
{
    return vxs_volumes_raster(v, names, NULL, body);
}

gl_name vxs_volumes_light_program(vxs_volumes *v, const char *names, const char *vertex, const char *body)
{
    const vxs_light_constants *c = &v->frame.light;
    char                       all[PROGRAM_NAMES];
    snprintf(all, sizeof all, "#define VXS_ONLY_KIND %u\n#define VXS_ONLY_CUBE %d\n#define VXS_ONLY_CODING %u\n%s%s", c->kind,
             (c->flags & VXS_LIGHT_CUBE) != 0, c->coding,
             v->depth_texture && v->frame.top_metres < (float)VXS_AIR_EVERYWHERE ? "" : "#define VXS_ONLY_EVERYWHERE\n", names);
    return vxs_volumes_raster(v, all, vertex, body);
}

vxs_result vxs_volumes_done(vxs_volumes *v)
{
    vxs_result result = v->result;
    v->result         = VXS_OK;
    if (result != VXS_OK) vxs_volumes_forget_error(v); /* of drawing without a program */
    return result;
}

void vxs_volumes_forget_error(const vxs_volumes *v)
{
    for (int n = 0; n < 16 && v->api.GetError() != GL_ERROR_NONE; n++) continue; /* a lost context returns errors for ever */
}

gl_name vxs_volumes_texture(const vxs_volumes *v, gl_enum format, uint32_t wide, uint32_t high, uint32_t layers)
{
    gl_name texture = 0;
    vxs_volumes_forget_error(v);
    v->api.CreateTextures(layers ? GL_TARGET_TEXTURE_2D_ARRAY : GL_TARGET_TEXTURE_2D, 1, &texture);
    if (layers)
        v->api.TextureStorage3D(texture, 1, format, (int)wide, (int)high, (int)layers);
    else
        v->api.TextureStorage2D(texture, 1, format, (int)wide, (int)high);
    v->api.TextureParameteri(texture, GL_SET_MIN_FILTER, GL_FILTER_NEAREST);
    v->api.TextureParameteri(texture, GL_SET_MAG_FILTER, GL_FILTER_NEAREST);
    if (v->api.GetError() == GL_ERROR_NONE) return texture;
    v->api.DeleteTextures(1, &texture);
    return 0;
}

gl_name vxs_volumes_buffer(const vxs_volumes *v, uint64_t size_bytes)
{
    gl_name buffer = 0;
    vxs_volumes_forget_error(v);
    v->api.CreateBuffers(1, &buffer);
    v->api.NamedBufferStorage(buffer, (gl_bytes)size_bytes, NULL, GL_STORAGE_DYNAMIC);
    if (v->api.GetError() == GL_ERROR_NONE) return buffer;
    v->api.DeleteBuffers(1, &buffer);
    return 0;
}

/* By a copy, because glNamedBufferSubData does not arrive there with NVIDIA's driver 580 (GL 4.5, H100 and H200): a dispatch
 * that follows reads the old bytes, with any barriers, until something flushes. */
void vxs_volumes_put(const vxs_volumes *v, gl_name buffer, uint64_t start_bytes, uint64_t size_bytes, const void *data)
{
    gl_name from = 0;
    v->api.CreateBuffers(1, &from);
    v->api.NamedBufferStorage(from, (gl_bytes)size_bytes, data, 0);
    v->api.CopyNamedBufferSubData(from, buffer, 0, (gl_bytes)start_bytes, (gl_bytes)size_bytes);
    v->api.DeleteBuffers(1, &from);
}
