/* Shaders that look up what other rivals made, on OSMesa's llvmpipe; see rival.h. Their answers are checked as those of all rivals
 * are.
 *
 * Voxels go to a buffer, a compute shader counts what is dark about each of them, and the counts come back, which takes 6 to 9 ns a
 * lookup and is part of the times. Neighbours in the list are neighbours in a shader's group. A filter has 9 x 9 taps, a smooth one
 * weighs 10 x 10.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"
#include "tests/gl_choice.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/embedded.h"
#include "runtime/vxs.h"
#include "tests/bench/rival.h"

EMBEDDED(vxs_lookup_h)
EMBEDDED(vxs_lookup_blocks_h)

#define SHADER_FUNCTIONS(X)                                                                                                        \
    X(PFNGLBUFFERSUBDATAPROC, BufferSubData)                                                                                       \
    X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                                                                                   \
    X(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData)                                                                                 \
    X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                                                                                       \
    X(PFNGLPROGRAMUNIFORM1UIPROC, ProgramUniform1ui)

enum { GROUP = 64, GROUPS_MAX = 16384, VOXELS_MAX = GROUP * GROUPS_MAX };

/* One context is current on a thread: the rivals that are open share it. */
static struct {
    gl_context *gl;
    size_t      users;
#define SHADER_POINTER(type, name) type name;
    SHADER_FUNCTIONS(SHADER_POINTER)
#undef SHADER_POINTER
} shared;

typedef struct shader_options {
    const rival *made_by;          /* the file */
    int          is_texture;       /* the file is a map of 16-bit depths, not an asset */
    int          clamps;           /* indices of words are clamped to the array, as by libvxs_gl */
    const char  *of[LOOKUP_KINDS]; /* what is dark about voxel (i, j, k): the body of a function */
} shader_options;

typedef struct shader {
    GLuint   programs[LOOKUP_KINDS];
    GLuint   words, voxels, answers; /* buffers, bound to what they are numbered by */
    GLuint   depths;
    uint32_t levels;
} shader;

/* text ------------------------------------------------------------------------------------------------------------------------- */

static const char head[] = "#version 430 core\n"
                           "layout(local_size_x = 64) in;\n"
                           "layout(std430, binding = 0) readonly restrict buffer shadow_words { uint words[]; };\n"
                           "layout(std430, binding = 1) readonly restrict buffer asked_voxels { ivec4 voxels[]; };\n"
                           "layout(std430, binding = 2) writeonly restrict buffer dark_counts { uint answers[]; };\n"
                           "layout(binding = 0) uniform usampler2D depths;\n"
                           "layout(location = 0) uniform ivec4 asked;\n"; /* levels, voxels */

static const char *const fetch[2] = {"#define vxs_word(dag, i) words[(dag) + (i)]\n",
                                     "layout(location = 1) uniform uint last_word;\n"
                                     "#define vxs_word(dag, i) words[min((dag) + (i), last_word)]\n"};

static const char function[] = "uint dark_taps(uint levels, int i, int j, uint k, uint across, uint down)\n{\n";

static const char end[] = "}\n"
                          "void main()\n"
                          "{\n"
                          "    uint n = gl_GlobalInvocationID.x;\n"
                          "    if (n >= uint(asked.y)) return;\n"
                          "    ivec4 at = voxels[n];\n"
                          "    answers[n] = dark_taps(uint(asked.x), at.x, at.y, uint(at.z), uint(at.w) & 255u, uint(at.w) >> 8);\n"
                          "}\n";

static const char texture_filter[] =
    "    int  last = (1 << levels) - 1, x0 = max(i - 4, 0), x1 = min(i + 4, last), y0 = max(j - 4, 0), y1 = min(j + 4, last);\n"
    "    uint dark = 0u, depth = k << (16u - levels);\n"
    "    for (int y = y0; y <= y1; y++)\n"
    "        for (int x = x0; x <= x1; x++) dark += texelFetch(depths, ivec2(x, y), 0).r <= depth ? 1u : 0u;\n"
    "    return dark;\n";

static const char texture_smooth[] =
    "    vxs_smooth_box box = vxs_smooth_box_at(i, j, across, down, 9);\n"
    "    int  last = (1 << levels) - 1, x0 = max(box.x, 0), x1 = min(box.x + 9, last), y0 = max(box.y, 0), y1 = min(box.y + 9, "
    "last);\n"
    "    uint dark = 0u, depth = k << (16u - levels);\n"
    "    for (int y = y0; y <= y1; y++) {\n"
    "        uint row = y == box.y ? 256u - box.down : y == box.y + 9 ? box.down : 256u;\n"
    "        for (int x = x0; x <= x1; x++) {\n"
    "            uint column = x == box.x ? 256u - box.across : x == box.x + 9 ? box.across : 256u;\n"
    "            dark += texelFetch(depths, ivec2(x, y), 0).r <= depth ? row * column : 0u;\n"
    "        }\n"
    "    }\n"
    "    return dark;\n";

static GLuint program_of(const char *body, int clamps, uint32_t words)
{
    const embedded lookup = vxs_lookup_h, blocks = vxs_lookup_blocks_h;
    const char    *texts[] = {head, fetch[clamps], lookup.begin, blocks.begin, function, body, end};
    const GLint    sizes[] = {-1, -1, (GLint)(lookup.end - lookup.begin), (GLint)(blocks.end - blocks.begin), -1, -1, -1};
    GLuint         compute = shared.gl->CreateShader(GL_COMPUTE_SHADER), program = shared.gl->CreateProgram();
    shared.gl->ShaderSource(compute, sizeof texts / sizeof *texts, texts, sizes);
    shared.gl->CompileShader(compute);
    shared.gl->AttachShader(program, compute);
    shared.gl->DeleteShader(compute);
    shared.gl->LinkProgram(program);
    if (clamps) shared.ProgramUniform1ui(program, 1, words - 1);
    return program;
}

/* opening ---------------------------------------------------------------------------------------------------------------------- */

static vxs_result share_context(void)
{
    run_context m = {0};
    vxs_result  r = shared.users++ ? VXS_OK : gl_context_create(&shared.gl, gl_choice(), 1, &m);
    run_free(&m);
#define SHADER_LOAD(type, name) shared.name = (type)gl_choice_function("gl" #name);
    SHADER_FUNCTIONS(SHADER_LOAD)
#undef SHADER_LOAD
    return r;
}

static void leave_context(void)
{
    if (--shared.users) return;
    gl_context_destroy(shared.gl);
    shared.gl = NULL;
}

static GLuint buffer_of(size_t size, const void *data)
{
    GLuint buffer;
    shared.gl->GenBuffers(1, &buffer);
    shared.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    shared.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_STATIC_DRAW);
    return buffer;
}

static GLuint depths_of(const uint8_t *map, GLsizei side)
{
    GLuint texture;
    shared.gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    shared.gl->TextureStorage2D(texture, 1, GL_R16UI, side, side);
    shared.gl->TextureSubImage2D(texture, 0, 0, 0, side, side, GL_RED_INTEGER, GL_UNSIGNED_SHORT, map);
    shared.gl->TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    shared.gl->TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

static vxs_result put_words(shader *s, const vxs_bytes *file, uint64_t *memory_bytes)
{
    vxs_asset *opened = NULL;
    vxs_result r      = vxs_asset_open(&opened, file->data, file->size_bytes, NULL);
    if (r != VXS_OK) return r;
    *memory_bytes = (uint64_t)vxs_asset_light(opened, 0)->word_count * sizeof(uint32_t);
    s->words      = buffer_of(*memory_bytes, vxs_asset_light(opened, 0)->words);
    vxs_asset_close(opened);
    return VXS_OK;
}

static void shader_close(void *state)
{
    shader *s = state;
    if (shared.gl) {
        for (int n = 0; n < LOOKUP_KINDS; n++) shared.gl->DeleteProgram(s->programs[n]);
        shared.gl->DeleteBuffers(3, (const GLuint[3]){s->words, s->voxels, s->answers});
        shared.gl->DeleteTextures(1, &s->depths);
    }
    leave_context();
    free(s);
}

static void shader_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark);

static vxs_result shader_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    const shader_options *o      = options;
    shader               *s      = calloc(1, sizeof *s);
    uint64_t              memory = file->size_bytes;
    vxs_result            r;
    if (!s) return VXS_E_MEMORY;
    s->levels = maps->levels;
    if ((r = share_context()) != VXS_OK) goto failed;
    if (!o->is_texture && (r = put_words(s, file, &memory)) != VXS_OK) goto failed;
    if (o->is_texture) s->depths = depths_of(file->data, (GLsizei)1 << maps->levels);
    s->voxels  = buffer_of(VOXELS_MAX * sizeof(voxel_at), NULL);
    s->answers = buffer_of(VOXELS_MAX * sizeof(uint32_t), NULL);
    for (int n = 0; n < LOOKUP_KINDS; n++) {
        uint32_t dark;
        s->programs[n] = program_of(o->of[n], o->clamps, (uint32_t)(memory / sizeof(uint32_t)));
        shader_count_dark(s, &(voxel_at){0}, 1, lookup_filters[n], &dark); /* llvmpipe compiles when it is first queried */
    }
    *asset = (rival_asset){s, memory};
    if (shared.gl->GetError() == GL_NO_ERROR) return VXS_OK;
    r = VXS_E_GL;
failed:
    shader_close(s);
    return r;
}

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

static void count_some(const shader *s, const voxel_at *at, size_t count, uint32_t *dark)
{
    shared.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, s->voxels);
    shared.BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(count * sizeof *at), at);
    shared.DispatchCompute((GLuint)((count + GROUP - 1) / GROUP), 1, 1);
    shared.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    shared.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, s->answers);
    shared.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(count * sizeof *dark), dark);
}

static void shader_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const shader *s       = state;
    GLuint        program = s->programs[filter.is_smooth ? LOOKUP_SMOOTH : filter.width_px == 1 ? LOOKUP_TAP : LOOKUP_BOX];
    shared.gl->UseProgram(program);
    shared.gl->BindTextureUnit(0, s->depths);
    for (GLuint n = 0; n < 3; n++)
        shared.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, n, (const GLuint[3]){s->words, s->voxels, s->answers}[n]);
    for (size_t first = 0; first < count; first += VOXELS_MAX) {
        size_t some = count - first < VOXELS_MAX ? count - first : VOXELS_MAX;
        shared.gl->ProgramUniform4i(program, 0, (GLint)s->levels, (GLint)some, 0, 0);
        count_some(s, at + first, some, dark + first);
    }
}

static vxs_result shader_build(rival_maps *maps, const void *options, vxs_bytes *file)
{
    const rival *one = ((const shader_options *)options)->made_by;
    return one->build(maps, one->options, file);
}

#define SHADER_RIVAL(name, what, ...)                                                                                              \
    {                                                                                                                              \
        name, what, &(const shader_options){__VA_ARGS__}, RIVAL_SMOOTH, shader_build, shader_open, shader_count_dark, shader_close \
    }

static const char dag_tap[]       = "    return vxs_shadow(0u, 0u, levels, uint(i), uint(j), k);\n";
static const char dag_filter[]    = "    return vxs_shadow_count(0u, 0u, levels, i, j, k, 9);\n";
static const char dag_smooth[]    = "    return vxs_shadow_weight(0u, 0u, levels, i, j, across, down, k, 9);\n";
static const char blocks_tap[]    = "    return vxs_blocks_shadow(0u, 0u, levels, uint(i), uint(j), k);\n";
static const char blocks_filter[] = "    return vxs_blocks_shadow_count(0u, 0u, levels, i, j, k, 9);\n";
static const char blocks_smooth[] = "    return vxs_blocks_shadow_weight(0u, 0u, levels, i, j, across, down, k, 9);\n";
static const char texture_tap[]   = "    return texelFetch(depths, ivec2(i, j), 0).r <= k << (16u - levels) ? 1u : 0u;\n";

const rival shader_rivals[] = {
    SHADER_RIVAL("DAG, GLSL", "formats/vxs_lookup.h on llvmpipe", dag_rivals, 0, 0, {dag_tap, dag_filter, dag_smooth}),
    SHADER_RIVAL("palette blocks, GLSL", "formats/vxs_lookup_blocks.h on llvmpipe", block_rivals, 0, 0,
                 {blocks_tap, blocks_filter, blocks_smooth}),
    SHADER_RIVAL("palette blocks, GLSL, clamped", "the same with indices held in the array, as by libvxs_gl", block_rivals, 0, 1,
                 {blocks_tap, blocks_filter, blocks_smooth}),
    SHADER_RIVAL("16-bit texture, GLSL", "texelFetch on llvmpipe, of each tap", depth_rivals, 1, 0,
                 {texture_tap, texture_filter, texture_smooth}),
    {.name = NULL},
};
