/* Programs and textures; see volumes_state.h.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>
#include <string.h>

#include "volumes_state.h"
#include "vxs_air_light.h"

enum { TEXTS = VXS_GL_TEXTS + 41, LOG_BYTES = 1024 };

/* Texts of one shader, in their order. */
typedef struct text_list {
    const char *texts[TEXTS];
    uint32_t    count;
} text_list;

static void add_text(text_list *to, const char *text)
{
    if (to->count < TEXTS) to->texts[to->count++] = text;
}

/* Add what a text needs, then the text, unless they are there. */
static void add(text_list *to, const volumes_text *t)
{
    for (uint32_t n = 0; n < to->count; n++)
        if (to->texts[n] == t->text) return;
    for (const volumes_text *const *need = t->needs; *need; need++) add(to, *need);
    add_text(to, t->text);
}

/* What a shader is compiled from. It begins with the texts of vxs_gl, for OpenGL 4.5 whatever language the caller uses. */
typedef struct shader_texts {
    gl_enum   kind;
    char      own[512];
    text_list all;
} shader_texts;

static void collect(const vxs_volumes *v, const program_texts *p, gl_enum kind, shader_texts *to)
{
    const char *shared[VXS_GL_TEXTS];
    text_list  *all = &to->all;
    to->kind        = kind;
    all->count      = 0;
    vxs_gl_texts(v->shadows, shared);
    snprintf(to->own, sizeof to->own,
             "#undef VXS_ONLY_KIND\n#undef VXS_ONLY_CUBE\n#undef VXS_ONLY_CODING\n#define VXS_AT_FRAME %u\n#define VXS_AT_OWN "
             "%u\n#define VXS_AT_CURVES %u\n#define VXS_AT_IMAGE "
             "%u\n#define VXS_AT_DEPTHS %u\n#define VXS_AT_MAP %u\n#define VXS_AT_OTHER %u\n#define VXS_AT_GRID %u\n#define "
             "VXS_AT_MESH %u\n#define VXS_NO_END 1e30\n#define VXS_FAR_MOST 1e15\n%s",
             BLOCK_FRAME, BLOCK_OWN, BLOCK_CURVES, IMAGE_BINDING, v->first_unit + UNIT_DEPTHS, v->first_unit + UNIT_MAP,
             v->first_unit + UNIT_OTHER, v->first_storage, v->first_unit + UNIT_MESH,
             kind == GL_KIND_COMPUTE_SHADER ? "#define VXS_COMPUTE\n" : "");
    add_text(all, "#version 450 core\n");
    add_text(all, strchr(shared[0], '\n') + 1);
    add_text(all, to->own);
    if (p->names) add_text(all, p->names);
    for (int n = 1; n < VXS_GL_TEXTS; n++) add_text(all, shared[n]);
    if (p->with) add(all, p->with);
    add(all, kind == GL_KIND_VERTEX_SHADER ? p->vertex : p->body);
}

/* Add a shader to a program. */
static void attach(const vxs_volumes *v, gl_name program, const shader_texts *texts)
{
    char    log[LOG_BYTES];
    int     good   = 0;
    gl_name shader = v->api.CreateShader(texts->kind);
    v->api.ShaderSource(shader, (int)texts->all.count, texts->all.texts, NULL);
    v->api.CompileShader(shader);
    if (v->log && !v->is_warming) {
        v->api.GetShaderiv(shader, GL_STATUS_COMPILE, &good);
        if (!good) v->api.GetShaderInfoLog(shader, sizeof log, NULL, log);
        if (!good) v->log(VXS_SEVERITY_ERROR, log, v->user);
    }
    v->api.AttachShader(program, shader);
    v->api.DeleteShader(shader);
}

/* A program that may still be compiling.   key  of its binary;   is_old  its binary came from the cache, so it is linked */
typedef struct started_program {
    gl_name     name;
    program_key key;
    int         is_old;
} started_program;

/* Take a program from the cache, or compile and link it, without waiting for either. */
static started_program start(const vxs_volumes *v, const program_texts *texts)
{
    started_program p = {.key = v->driver};
    shader_texts    shaders[2];
    uint32_t        count = 0;
    if (texts->vertex) collect(v, texts, GL_KIND_VERTEX_SHADER, &shaders[count++]);
    collect(v, texts, texts->vertex ? GL_KIND_FRAGMENT_SHADER : GL_KIND_COMPUTE_SHADER, &shaders[count++]);
    for (uint32_t s = 0; s < count && v->binary_format_count; s++) {
        const text_list *all = &shaders[s].all;
        for (uint32_t n = 0; n < all->count; n++) vxs_volumes_key_add(&p.key, all->texts[n], strlen(all->texts[n]));
        vxs_volumes_key_add(&p.key, &shaders[s].kind, sizeof shaders[s].kind);
    }
    p.name   = vxs_volumes_cache_get(v, &p.key);
    p.is_old = p.name != 0;
    if (p.is_old) return p;
    p.name = v->api.CreateProgram();
    for (uint32_t s = 0; s < count; s++) attach(v, p.name, &shaders[s]);
    if (v->cache.put) v->api.ProgramParameteri(p.name, GL_SET_BINARY_RETRIEVABLE, 1);
    v->api.LinkProgram(p.name);
    return p;
}

/* Wait for a program.   Returns it; 0 if it does not compile: it is deleted */
static gl_name finish(const vxs_volumes *v, const started_program *p)
{
    int good = p->is_old;
    if (!p->is_old) v->api.GetProgramiv(p->name, GL_STATUS_LINK, &good);
    if (good) {
        if (!p->is_old) vxs_volumes_cache_put(v, &p->key, p->name);
        vxs_gl_link(v->shadows, p->name);
        return p->name;
    }
    v->api.DeleteProgram(p->name);
    return 0;
}

gl_name vxs_volumes_compile(const vxs_volumes *v, const program_texts *texts)
{
    started_program p = start(v, texts);
    return finish(v, &p);
}

gl_name vxs_volumes_program(vxs_volumes *v, const program_texts *texts)
{
    const char *names = texts->names ? texts->names : "";
    uint32_t    n     = 0;
    for (; n < v->program_count; n++) {
        const program_texts *t = &v->programs[n].texts;
        if (t->body == texts->body && t->vertex == texts->vertex && t->with == texts->with && !strcmp(t->names, names)) break;
    }
    if (n == PROGRAMS_MOST) {
        v->result = vxs_volumes_fail(v, VXS_E_GL, "too many programs: use another vxs_volumes for some techniques");
        return 0;
    }
    volumes_program *p = &v->programs[n];
    if (n == v->program_count) {
        p->texts       = *texts;
        p->texts.names = p->names;
        snprintf(p->names, sizeof p->names, "%s", names);
        started_program begun = start(v, &p->texts);
        p->key                = begun.key;
        p->is_pending         = v->is_warming && !begun.is_old;
        p->name               = p->is_pending ? begun.name : finish(v, &begun);
        v->program_count++;
    }
    if (p->is_pending && !v->is_warming) {
        p->name = finish(v, &(started_program){.name = p->name, .key = p->key});
        if (!p->name) p->name = vxs_volumes_compile(v, &p->texts); /* once more, for its log */
        p->is_pending = 0;
    }
    if (!p->name) v->result = VXS_E_GL;
    return p->name;
}

gl_name vxs_volumes_light_program(vxs_volumes *v, const program_texts *texts)
{
    const vxs_light_constants *c     = &v->frame.light;
    program_texts              light = *texts;
    char                       names[PROGRAM_NAMES];
    snprintf(names, sizeof names, "#define VXS_ONLY_KIND %u\n#define VXS_ONLY_CUBE %d\n#define VXS_ONLY_CODING %u\n%s%s", c->kind,
             (c->flags & VXS_LIGHT_CUBE) != 0, c->coding,
             v->depth_texture && v->frame.top_metres < (float)VXS_AIR_EVERYWHERE ? "" : "#define VXS_ONLY_EVERYWHERE\n",
             texts->names ? texts->names : "");
    light.names = names;
    return vxs_volumes_program(v, &light);
}

vxs_result vxs_volumes_done(vxs_volumes *v)
{
    vxs_result result = v->result;
    v->result         = VXS_OK;
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
