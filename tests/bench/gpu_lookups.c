/* Lookups of an asset, and of depth maps with the same depths, the ways that engines filter them; see gpu_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/gpu_bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/vxs_query.h"

const char *const gpu_filter_names[GPU_FILTERS] = {"1 tap", "3 x 3 box", "9 x 9 box", "9 x 9 smooth"};
const char *const gpu_filter_texts[GPU_FILTERS] = {"vxs_box(1)", "vxs_box(3)", "vxs_box(9)", "vxs_smooth(9)"};

/* the asset -------------------------------------------------------------------------------------------------------------------- */

static const char asset_body[] =
    "float answer_of(ivec2 pixel, vec3 at, vec3 normal) { return vxs_lit_by(0u, at, normal, FILTER); }\n";
static const char place_body[] = "float answer_of(ivec2 pixel, vec3 at, vec3 normal)\n"
                                 "{\n"
                                 "    vxs_place place = vxs_place_from_ws(vxs_light_at(0u), at, normal, vxs_box(9));\n"
                                 "    return float(place.map + place.voxel[0] + place.voxel[1] + place.voxel[2]);\n"
                                 "}\n";

void gpu_use(gpu_bench *b, vxs_gl *shadows, GLuint program, const gpu_view *view)
{
    const gl_context *gl = b->gl;
    vxs_gl_origin(shadows, view->eye_ws);
    gl->UseProgram(program);
    vxs_gl_link(shadows, program);
    vxs_gl_bind(shadows);
    gl->BindTextureUnit(8, view->positions);
    gl->BindTextureUnit(9, view->normals);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, b->answers);
}

static vxs_result measure_program(gpu_bench *b, vxs_gl *shadows, GLuint program, gpu_view *view, const gpu_row *row, run_context *m)
{
    gpu_dispatch d = {shadows, view, program};
    gpu_use(b, shadows, program, view);
    return gpu_measure(b, view, row, gpu_dispatch_frame, &d, m);
}

/* How shaders read an asset: tables, in a buffer or a texture; or the words of blocks alone. */
typedef enum gpu_form { FORM_BUFFER, FORM_WORDS, FORM_TEXTURE, FORMS } gpu_form;

static const char *const form_names[FORMS] = {"buffer", "words alone", "texture"};

/* One filter of one form, in all views. The first form of the first asset of a resolution keeps its answers. */
static vxs_result measure_filter(gpu_bench *b, vxs_gl *shadows, const vxs_baked_light *light, gpu_filter filter, gpu_form form,
                                 int is_first, run_context *m)
{
    char       name[64], defines[64];
    GLuint     program;
    vxs_result r;
    snprintf(defines, sizeof defines, "#define FILTER %s\n", gpu_filter_texts[filter]);
    snprintf(name, sizeof name, "%s, %s", light->light.coding == VXS_CODING_BLOCKS ? "blocks" : "DAG", form_names[form]);
    if ((r = gpu_program(b, shadows, defines, asset_body, &program, m)) != VXS_OK) return r;
    for (size_t n = 0; n < b->view_count && r == VXS_OK; n++) {
        gpu_view *v   = &b->views[n];
        gpu_row   row = {.group         = gpu_filter_names[filter],
                         .name          = name,
                         .resolution_px = 1u << light->light.levels,
                         .bytes  = vxs_gl_table_bytes(shadows) ? (double)vxs_gl_table_bytes(shadows) : 4.0 * light->word_count,
                         .wanted = is_first && form != FORM_BUFFER ? v->lit[filter] : NULL};
        r             = measure_program(b, shadows, program, v, &row, m);
        if (r != VXS_OK || !is_first || form != FORM_BUFFER) continue;
        if (!v->lit[filter]) v->lit[filter] = malloc(b->pixels * sizeof(float));
        if (!v->lit[filter])
            r = fail(m, VXS_E_MEMORY, "out of memory for answers");
        else
            gpu_answers(b, v->lit[filter]);
    }
    b->gl->UseProgram(0);
    b->gl->DeleteProgram(program);
    return r;
}

static vxs_result measure_place(gpu_bench *b, vxs_gl *shadows, uint32_t side_px, run_context *m)
{
    GLuint     program;
    vxs_result r = gpu_program(b, shadows, "", place_body, &program, m);
    for (size_t n = 0; n < b->view_count && r == VXS_OK; n++)
        r = measure_program(b, shadows, program, &b->views[n],
                            &(gpu_row){.group = "place", .name = "alone: in each figure", .resolution_px = side_px}, m);
    b->gl->UseProgram(0);
    b->gl->DeleteProgram(program);
    return r;
}

vxs_result gpu_measure_lookups(gpu_bench *b, const vxs_asset *asset, int is_first, run_context *m)
{
    const vxs_baked_light *light = vxs_asset_light(asset, 0);
    vxs_result             r     = VXS_OK;
    for (gpu_form form = 0; form < (b->storage ? FORM_TEXTURE : FORMS) && r == VXS_OK; form++) {
        vxs_gl *shadows = NULL;
        if (form == FORM_WORDS && light->light.coding != VXS_CODING_BLOCKS) continue;
        r = gpu_shadows(b, asset, form == FORM_TEXTURE ? VXS_GL_TEXTURE : VXS_GL_BUFFER, form == FORM_WORDS, &shadows, m);
        if (r == VXS_OK && is_first && form == FORM_BUFFER) r = measure_place(b, shadows, 1u << light->light.levels, m);
        for (int f = 0; f < GPU_FILTERS && r == VXS_OK; f++)
            r = measure_filter(b, shadows, light, (gpu_filter)f, form, is_first, m);
        vxs_gl_destroy(shadows);
    }
    return r;
}

/* rivals ----------------------------------------------------------------------------------------------------------------------- */

/* The same place as the asset's lookup; K: width of the filter. What they find differs from the asset's box nowhere. */
static const char rival_head[] = "layout(location = 0) uniform int shift;    /* of a voxel's depth */\n"
                                 "layout(location = 1) uniform float most;   /* depth 1, as the map's integers have it */\n"
                                 "layout(binding = 10) uniform usampler2D whole;\n"
                                 "layout(binding = 11) uniform MAP map;\n"
                                 "float filtered(vxs_place place, uint k, float depth);\n"
                                 "float answer_of(ivec2 pixel, vec3 at, vec3 normal)\n"
                                 "{\n"
                                 "    vxs_light_constants light = vxs_light_at(0u);\n"
                                 "    vxs_place place = vxs_place_from_ws(light, at, normal, FILTER);\n"
                                 "    if (place.map < 0) return -1.0;\n"
                                 "    if (place.voxel[2] < 0) return 1.0;\n"
                                 "    uint k = uint(min(place.voxel[2], (1 << light.levels) - 1)) << shift;\n"
                                 "    return filtered(place, k, (float(k) + 0.5) / most);\n"
                                 "}\n";

static const char fetches[] = "float filtered(vxs_place place, uint k, float depth)\n"
                              "{\n"
                              "    ivec2 size = textureSize(whole, 0);\n"
                              "    int   lit  = 0;\n"
                              "    for (int y = -K / 2; y <= K / 2; y++)\n"
                              "        for (int x = -K / 2; x <= K / 2; x++)\n"
                              "            lit += texelFetch(whole, clamp(ivec2(place.voxel[0], place.voxel[1]) + ivec2(x, y), "
                              "ivec2(0), size - 1), 0).r > k ? 1 : 0;\n"
                              "    return float(lit) / float(K * K);\n"
                              "}\n";

/* Comparisons between two or four texels: with K x K equal weights ceil(K / 2) of them a row. */
static const char comparisons[] = "float filtered(vxs_place place, uint k, float depth)\n"
                                  "{\n"
                                  "    vec2  first = vec2(place.voxel[0], place.voxel[1]) - float(K / 2);\n"
                                  "    float lit   = 0.0;\n"
                                  "    VIEWED\n"
                                  "    for (int y = 0; y <= K / 2; y++)\n"
                                  "        for (int x = 0; x <= K / 2; x++) {\n"
                                  "            vec2 weight = vec2(x == K / 2 ? 1.0 : 2.0, y == K / 2 ? 1.0 : 2.0);\n"
                                  "            lit += weight.x * weight.y * COMPARED(first + 2.0 * vec2(x, y) + 0.5 * weight);\n"
                                  "        }\n"
                                  "    return lit / float(K * K);\n"
                                  "}\n";

/* Ten texels of a row, the first and the last in part, are five comparisons. */
static const char smooth_comparisons[] =
    "vec2 weight_of(int n, vec2 part)\n"
    "{\n"
    "    return n == 0 ? 2.0 - part : n == 4 ? 1.0 + part : vec2(2.0);\n"
    "}\n"
    "vec2 aside_of(int n, vec2 part)\n"
    "{\n"
    "    return 0.5 + (n == 0 ? 1.0 / (2.0 - part) : n == 4 ? part / (1.0 + part) : vec2(0.5));\n"
    "}\n"
    "float filtered(vxs_place place, uint k, float depth)\n"
    "{\n"
    "    vxs_smooth_box box = vxs_smooth_box_at(place.voxel[0], place.voxel[1], place.across, place.down, 9);\n"
    "    vec2  first = vec2(box.x, box.y), part = vec2(box.across, box.down) / 256.0;\n"
    "    float lit   = 0.0;\n"
    "    VIEWED\n"
    "    for (int y = 0; y < 5; y++)\n"
    "        for (int x = 0; x < 5; x++)\n"
    "            lit += weight_of(x, part).x * weight_of(y, part).y *\n"
    "                   COMPARED(first + 2.0 * vec2(x, y) + vec2(aside_of(x, part).x, aside_of(y, part).y));\n"
    "    return lit / 81.0;\n"
    "}\n";

/* 100 texels: engines that compare themselves, or have their own weights. */
static const char gathers[] =
    "float filtered(vxs_place place, uint k, float depth)\n"
    "{\n"
    "    vec2 size = vec2(textureSize(map, 0)), first = vec2(place.voxel[0], place.voxel[1]) - 3.0;\n"
    "    vec4 lit  = vec4(0.0);\n"
    "    for (int y = 0; y < 5; y++)\n"
    "        for (int x = 0; x < 5; x++) lit += textureGather(map, (first + 2.0 * vec2(x, y)) / size, depth);\n"
    "    return dot(lit, vec4(0.01));\n"
    "}\n";

#define WHOLE_MAP                                                                                                                  \
    "#define MAP sampler2DShadow\n#define VIEWED vec2 size = vec2(textureSize(map, 0));\n"                                         \
    "#define COMPARED(at) texture(map, vec3((at) / size, depth))\n"

/* Each cascade is twice as wide as the one before it, about the same place; the first one that holds the filter is read. */
#define CASCADES                                                                                                                   \
    "#define MAP sampler2DArrayShadow\n"                                                                                           \
    "layout(location = 2) uniform vec4 cascades[4];\n"                                                                             \
    "#define VIEWED vec2 size = vec2(textureSize(map, 0)); int layer = 0;\\\n"                                                     \
    "    for (; layer < 3; layer++) {\\\n"                                                                                         \
    "        vec2 near = (first - cascades[layer].xy) * cascades[layer].z;\\\n"                                                    \
    "        if (all(greaterThan(near, vec2(2.0))) && all(lessThan(near, size - 12.0))) break;\\\n"                                \
    "    }\\\n"                                                                                                                    \
    "    first = floor((first - cascades[layer].xy) * cascades[layer].z);\n"                                                       \
    "#define COMPARED(at) texture(map, vec4((at) / size, float(layer), depth))\n"

/* What a program reads. */
typedef enum map_kind { MAP_FETCHED, MAP_COMPARED, MAP_CASCADES, MAP_KINDS } map_kind;

typedef struct rival_lookup {
    gpu_filter  filter;
    map_kind    map;
    const char *name, *body, *defines;
    int         is_same; /* 1: it weighs texels as the asset's filter does */
} rival_lookup;

static const rival_lookup lookups[] = {
    {GPU_TAP, MAP_FETCHED, "1 fetch", fetches, WHOLE_MAP "#define K 1\n", 1},
    {GPU_BOX_3, MAP_FETCHED, "9 fetches", fetches, WHOLE_MAP "#define K 3\n", 1},
    {GPU_BOX_9, MAP_FETCHED, "81 fetches", fetches, WHOLE_MAP "#define K 9\n", 1},
    {GPU_TAP, MAP_COMPARED, "1 comparison", comparisons, WHOLE_MAP "#define K 1\n", 1},
    {GPU_BOX_3, MAP_COMPARED, "4 comparisons", comparisons, WHOLE_MAP "#define K 3\n", 1},
    {GPU_BOX_9, MAP_COMPARED, "25 comparisons", comparisons, WHOLE_MAP "#define K 9\n", 1},
    {GPU_BOX_9, MAP_COMPARED, "25 gathers", gathers, WHOLE_MAP "#define K 9\n", 0},
    {GPU_SMOOTH_9, MAP_COMPARED, "25 comparisons", smooth_comparisons, WHOLE_MAP, 1},
    {GPU_BOX_9, MAP_CASCADES, "cascades, 25 comparisons", comparisons, CASCADES "#define K 9\n", 0},
    {GPU_SMOOTH_9, MAP_CASCADES, "cascades, 25 comparisons", smooth_comparisons, CASCADES, 0},
};
enum { LOOKUPS = sizeof lookups / sizeof *lookups, CASCADE_COUNT = 4, CASCADE_PX = 2048 };

/* The depths of the asset, and what is made of them. */
typedef struct rival_maps {
    uint32_t  side_px, levels;
    uint32_t *voxels; /* [side_px][side_px] */
} rival_maps;

/* Depths as a map of 16 or 32 bits has them: integers for fetches and 16 bits, floats else.   Returns NULL: out of memory */
static void *depths_of(const uint32_t *voxels, size_t count, uint32_t levels, uint32_t bits, map_kind kind)
{
    if (bits == 32 && kind == MAP_FETCHED) {
        void *copy = malloc(count * sizeof *voxels);
        return copy ? memcpy(copy, voxels, count * sizeof *voxels) : NULL;
    }
    uint16_t *whole = NULL;
    float    *parts = NULL;
    if (bits == 16 && !(whole = malloc(count * sizeof *whole))) return NULL;
    if (bits == 32 && !(parts = malloc(count * sizeof *parts))) return NULL;
    for (size_t n = 0; n < count; n++) {
        uint64_t depth = (uint64_t)voxels[n] << (16 - levels);
        if (whole) whole[n] = depth > 65535 ? 65535 : (uint16_t)depth;
        if (parts) parts[n] = (float)voxels[n] / (float)(1u << levels);
    }
    return whole ? (void *)whole : parts;
}

static GLuint map_texture(const gpu_bench *b, uint32_t side_px, uint32_t layers, uint32_t bits, map_kind kind, const void *texels)
{
    static const GLenum formats[2][2] = {{GL_R16UI, GL_R32UI}, {GL_DEPTH_COMPONENT16, GL_DEPTH_COMPONENT32F}};
    const gl_context   *gl            = b->gl;
    int                 compared      = kind != MAP_FETCHED;
    GLenum              channels      = compared ? GL_DEPTH_COMPONENT : GL_RED_INTEGER;
    GLenum              type          = bits == 16 ? GL_UNSIGNED_SHORT : compared ? GL_FLOAT : GL_UNSIGNED_INT;
    GLsizei             side          = (GLsizei)side_px;
    GLuint              texture;
    gl->CreateTextures(layers ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, 1, &texture);
    if (layers) {
        PFNGLTEXTURESUBIMAGE3DPROC put = (PFNGLTEXTURESUBIMAGE3DPROC)gl->lookup("glTextureSubImage3D");
        gl->TextureStorage3D(texture, 1, formats[compared][bits == 32], side, side, (GLsizei)layers);
        put(texture, 0, 0, 0, 0, side, side, (GLsizei)layers, channels, type, texels);
    } else {
        gl->TextureStorage2D(texture, 1, formats[compared][bits == 32], side, side);
        gl->TextureSubImage2D(texture, 0, 0, 0, side, side, channels, type, texels);
    }
    gl->TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, compared ? GL_LINEAR : GL_NEAREST);
    gl->TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, compared ? GL_LINEAR : GL_NEAREST);
    gl->TextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    if (compared) gl->TextureParameteri(texture, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    if (compared) gl->TextureParameteri(texture, GL_TEXTURE_COMPARE_FUNC, GL_LESS);
    return texture;
}

/* Voxels of four cascades, about the place of the view's target; the last one is the whole map.
 * at  [out] [4] first texel of each in the map, texels of it in one of the map, 0 */
static uint32_t *cascade_voxels(const rival_maps *maps, const vxs_light *light, const gpu_view *view, float at[CASCADE_COUNT][4])
{
    size_t    layer = (size_t)CASCADE_PX * CASCADE_PX;
    uint32_t *out   = malloc(CASCADE_COUNT * layer * sizeof *out);
    int32_t   voxel[3], side = (int32_t)maps->side_px;
    vxs_voxel(light, view->target_ws, NULL, vxs_box(1), voxel);
    for (int c = 0; c < CASCADE_COUNT && out; c++) {
        int32_t wide = side >> (CASCADE_COUNT - 1 - c), first[2];
        for (int n = 0; n < 2; n++) {
            first[n] = voxel[n] - wide / 2;
            first[n] = first[n] < 0 ? 0 : first[n] > side - wide ? side - wide : first[n];
            at[c][n] = (float)first[n];
        }
        at[c][2] = (float)CASCADE_PX / (float)wide;
        at[c][3] = 0;
        for (size_t j = 0; j < CASCADE_PX; j++)
            for (size_t i = 0; i < CASCADE_PX; i++)
                out[(size_t)c * layer + j * CASCADE_PX + i] =
                    maps->voxels[((size_t)first[1] + j * (size_t)wide / CASCADE_PX) * maps->side_px + (size_t)first[0] +
                                 i * (size_t)wide / CASCADE_PX];
    }
    return out;
}

/* Bind the map of a lookup, made of voxels. A map that does not fit is left out, and said.   texture  [out] 0: it does not fit */
static vxs_result make_map(gpu_bench *b, const uint32_t *voxels, uint32_t side_px, uint32_t layers, uint32_t levels, uint32_t bits,
                           map_kind kind, GLuint *texture, run_context *m)
{
    void *texels = depths_of(voxels, (size_t)side_px * side_px * (layers ? layers : 1), levels, bits, kind);
    *texture     = 0;
    if (!texels) return fail(m, VXS_E_MEMORY, "out of memory for a depth map");
    while (b->gl->GetError() != GL_NO_ERROR) continue;
    *texture = map_texture(b, side_px, layers, bits, kind, texels);
    b->gl->Finish();
    free(texels);
    if (b->gl->GetError() == GL_NO_ERROR) return VXS_OK;
    warn(m, "left out: a depth map of %u x %u texels of %u bits, which this OpenGL does not hold", side_px, side_px, bits);
    b->gl->DeleteTextures(1, texture);
    *texture = 0;
    return VXS_OK;
}

static vxs_result measure_rival(gpu_bench *b, vxs_gl *shadows, const rival_maps *maps, const rival_lookup *l, uint32_t bits,
                                gpu_view *view, GLuint program, run_context *m)
{
    static const float tolerances[GPU_FILTERS] = {0.01f, 0.02f, 0.5f / 81, 0.02f};
    char               name[64];
    double             texels =
        l->map == MAP_CASCADES ? (double)CASCADE_COUNT * CASCADE_PX * CASCADE_PX : (double)maps->side_px * maps->side_px;
    int is_rival = bits == 16 && l->map != MAP_CASCADES &&
                   (l->filter == GPU_TAP ? l->map == MAP_FETCHED : l->map == MAP_COMPARED && l->is_same);
    if (!program) return VXS_OK; /* it has failed, and that is said */
    snprintf(name, sizeof name, "%u bits, %s%s", bits, l->name, is_rival ? " (rival)" : "");
    gpu_row row = {.group         = gpu_filter_names[l->filter],
                   .name          = name,
                   .resolution_px = maps->side_px,
                   .bytes         = texels * bits / 8,
                   .wanted        = l->is_same ? view->lit[l->filter] : NULL,
                   .tolerance     = tolerances[l->filter]};
    b->gl->ProgramUniform1i(program, 0, bits == 16 ? 16 - (GLint)maps->levels : 0);
    b->gl->ProgramUniform1f(program, 1, bits == 16 ? 65535.0f : (float)maps->side_px);
    return measure_program(b, shadows, program, view, &row, m);
}

static vxs_result measure_cascades(gpu_bench *b, vxs_gl *shadows, const rival_maps *maps, const vxs_light *light,
                                   const GLuint *programs, gpu_view *view, run_context *m)
{
    float      at[CASCADE_COUNT][4];
    uint32_t  *voxels = cascade_voxels(maps, light, view, at);
    vxs_result r      = voxels ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for cascades");
    for (uint32_t bits = 16; bits <= 32 && r == VXS_OK; bits += 16) {
        GLuint texture = 0;
        r              = make_map(b, voxels, CASCADE_PX, CASCADE_COUNT, maps->levels, bits, MAP_CASCADES, &texture, m);
        b->gl->BindTextureUnit(11, texture);
        for (int n = 0; n < LOOKUPS && r == VXS_OK && texture; n++) {
            if (lookups[n].map != MAP_CASCADES) continue;
            for (int c = 0; c < CASCADE_COUNT; c++) b->gl->ProgramUniform4f(programs[n], 2 + c, at[c][0], at[c][1], at[c][2], 0);
            r = measure_rival(b, shadows, maps, &lookups[n], bits, view, programs[n], m);
        }
        b->gl->DeleteTextures(1, &texture);
    }
    free(voxels);
    return r;
}

vxs_result gpu_measure_rivals(gpu_bench *b, const vxs_asset *asset, run_context *m)
{
    const vxs_baked_light *light             = vxs_asset_light(asset, 0);
    rival_maps             maps              = {.side_px = 1u << light->light.levels, .levels = light->light.levels};
    GLuint                 programs[LOOKUPS] = {0};
    vxs_gl                *shadows           = NULL;
    vxs_result             r = VXS_OK, failed = VXS_OK;
    if (maps.levels > 15 || light->light.kind != VXS_LIGHT_KIND_DIRECTIONAL)
        return fail(m, VXS_E_ARGUMENT, "rivals are measured with a directional light of at most 32768 texels a side");
    maps.voxels             = malloc((size_t)maps.side_px * maps.side_px * sizeof *maps.voxels);
    vxs_depth_map_desc desc = {.struct_size = sizeof desc, .wide_px = maps.side_px, .high_px = maps.side_px, .voxels = maps.voxels};
    if (!maps.voxels) return fail(m, VXS_E_MEMORY, "out of memory for a depth map");
    if ((r = vxs_depth_map(light, &desc, NULL)) != VXS_OK) r = fail(m, r, "no depth map: %s", vxs_result_text(r));
    if (r == VXS_OK) r = gpu_shadows(b, asset, VXS_GL_BUFFER, 0, &shadows, m);
    for (int n = 0; n < LOOKUPS && r == VXS_OK; n++) {
        char text[6000], defines[2000];
        snprintf(text, sizeof text, "%s%s", rival_head, lookups[n].body);
        snprintf(defines, sizeof defines, "%s#define FILTER %s\n", lookups[n].defines, gpu_filter_texts[lookups[n].filter]);
        vxs_result made = gpu_program(b, shadows, defines, text, &programs[n], m);
        if (failed == VXS_OK) failed = made; /* the others are measured */
    }
    for (uint32_t bits = 16; bits <= 32 && r == VXS_OK; bits += 16)
        for (int kind = MAP_FETCHED; kind <= MAP_COMPARED && r == VXS_OK; kind++) {
            GLuint texture = 0;
            r              = make_map(b, maps.voxels, maps.side_px, 0, maps.levels, bits, (map_kind)kind, &texture, m);
            b->gl->BindTextureUnit(kind == MAP_FETCHED ? 10 : 11, texture);
            for (int n = 0; n < LOOKUPS && texture; n++)
                for (size_t v = 0; v < b->view_count && r == VXS_OK && lookups[n].map == (map_kind)kind; v++)
                    r = measure_rival(b, shadows, &maps, &lookups[n], bits, &b->views[v], programs[n], m);
            b->gl->DeleteTextures(1, &texture);
        }
    for (size_t v = 0; v < b->view_count && r == VXS_OK; v++)
        r = measure_cascades(b, shadows, &maps, &light->light, programs, &b->views[v], m);
    for (int n = 0; n < LOOKUPS; n++) b->gl->DeleteProgram(programs[n]);
    vxs_gl_destroy(shadows);
    free(maps.voxels);
    return r == VXS_OK ? failed : r;
}
