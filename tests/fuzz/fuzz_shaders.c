/* Any bytes as a .vxs file: where it opens, shaders on llvmpipe give the answers of C, from the same texts
 * (formats/vxs_lookup_blocks.h, vxs_depths.h, vxs_intervals.h): to the bit how many taps of a filter are in shadow, whether pages
 * are missing for it, and where light first ends; of points, for the voxel that floats lead to; lit intervals but where rounding of
 * floats may lead to another voxel. Of each light they have all of the words, and those without pages. Nothing is queried where
 * there is no OSMesa.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"
#include "tests/gl_choice.h"

#include <string.h>

#include "formats/vxs_space.h"
#include "fuzz.h"
#include "fuzz_places.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/volumes_text.h"
#include "runtime/vxs_query.h"

enum {
    MEMORY_LIMIT_BYTES = 16 << 20,
    LIGHTS             = 8, /* of the file, each twice */
    PLACES             = 1024,
    RAYS               = 64,
    SPANS              = 120,
    PLACES_AT          = 10, /* bindings */
    ANSWERS_AT         = 11,
};

enum { ASK_VOXEL, ASK_POINT, ASK_DEPTH, ASKS };

/* As shaders read them. */
typedef struct place {
    int32_t light, map, ask, width_px, i, j, k, is_smooth;
    float   at[4];
} place;

/* What they answer: of a point, for the place that its floats lead to. */
typedef struct answer {
    uint32_t dark, is_full, across, down;
    int32_t  map, i, j, k;
} answer;

typedef struct ray {
    float   origin[3], begin, direction[3], end;
    int32_t light, unused[3];
} ray;

typedef struct spans {
    float count, unused[3];
    struct {
        float begin, end, state, coarse;
    } span[SPANS];
} spans;

static const char places_text[] =
    "layout(local_size_x = 64) in;\n"
    "struct asked { ivec4 of, voxel; vec4 at; };\n"
    "struct answer { uvec4 dark; ivec4 place; };\n"
    "layout(std430, binding = 10) readonly restrict buffer places_block { asked places[]; };\n"
    "layout(std430, binding = 11) restrict buffer answers_block { answer answers[]; };\n"
    "int first_shadow(vxs_light_constants light, uint map, int i, int j)\n"
    "{\n"
    "#ifdef VXS_TABLES\n"
    "    return vxs_table_depth(vxs_root_of(light.first_word, light, int(map)), light.levels, uint(i), uint(j));\n"
    "#else\n"
    "    uint words = light.first_word, levels = light.levels;\n"
    "    vxs_depths_square s = vxs_depths_square_at(words, map, levels, i, j);\n"
    "    if (s.least == s.greatest) return s.least;\n"
    "    vxs_blocks_node node = vxs_depths_node_of(words, map, levels, i, j, s.least);\n"
    "    vxs_blocks_block block = vxs_blocks_find_block(words, node, uint(((i >> 5) & 7) | (((j >> 5) & 7) << 3)));\n"
    "    int x = (i >> 3) & 31, y = (j >> 3) & 31;\n"
    "    if ((((block.mixed | block.own) >> uint((x & 3) | ((y & 3) << 2))) & 1u) == 0u)\n"
    "        return vxs_depths_whole(words, node, block, x, y, s.least, s.greatest);\n"
    "    vxs_depths_tile tile = vxs_depths_tile_of(words, node, block, x, y, s.least, s.greatest);\n"
    "    vxs_depths_bounds b = vxs_depths_bound(words, tile);\n"
    "    if (b.least == b.greatest) return b.least;\n"
    "    return vxs_depths_texel(words, tile, b.least, b.greatest, uint(i & 7), uint(j & 7));\n"
    "#endif\n"
    "}\n"
    "void main()\n"
    "{\n"
    "    asked a = places[gl_GlobalInvocationID.x];\n"
    "    vxs_light_constants light = vxs_light_at(uint(a.of.x));\n"
    "    vxs_place place;\n"
    "    vxs_filter pcf = vxs_filter(a.of.w, a.voxel.w);\n"
    "    uint dark = 0u, full = 1u;\n"
    "    if (a.of.z == 1)\n"
    "        place = vxs_place_from_ws(light, a.at.xyz, vec3(0.0, 1.0, 0.0), pcf);\n"
    "    else {\n"
    "        place.map = a.of.y;\n"
    "        place.voxel = a.voxel.xyz;\n"
    "        place.across = uint(7 * a.voxel.x) & 255u;\n"
    "        place.down = uint(5 * a.voxel.y) & 255u;\n"
    "    }\n"
    "    uint k = uint(min(place.voxel.z, (1 << light.levels) - 1));\n"
    "    if (a.of.z == 2)\n"
    "        dark = uint(first_shadow(light, uint(place.map), place.voxel.x, place.voxel.y));\n"
    "    else if (place.map >= 0 && place.voxel.z >= 0) {\n"
    "        full = uint(vxs_is_full_at_place(light.first_word, light, place, pcf));\n"
    "        if (pcf.is_smooth == 0)\n"
    "            dark = vxs_shadow_taps(light.first_word, light, place.map, place.voxel.x, place.voxel.y, k, pcf.width_px);\n"
    "        else\n"
    "            dark = vxs_shadow_part(light.first_word, light, place, k, pcf.width_px);\n"
    "    }\n"
    "    answers[gl_GlobalInvocationID.x].dark = uvec4(dark, full, place.across, place.down);\n"
    "    answers[gl_GlobalInvocationID.x].place = ivec4(place.map, place.voxel);\n"
    "}\n";

static const char rays_text[] =
    "layout(local_size_x = 64) in;\n"
    "struct asked { vec4 origin, direction; ivec4 light; };\n"
    "layout(std430, binding = 10) readonly restrict buffer rays_block { asked rays[]; };\n"
    "layout(std430, binding = 11) restrict buffer spans_block { vec4 spans[]; };\n"
    "void main()\n"
    "{\n"
    "    asked ray = rays[gl_GlobalInvocationID.x];\n"
    "    int at = int(gl_GlobalInvocationID.x) * 121, count = 0;\n"
    "    vxs_light_constants light = vxs_light_at(uint(ray.light.x));\n"
    "    vxs_walk w = vxs_walk_of(light, ray.origin.xyz, ray.direction.xyz, ray.origin.w, ray.direction.w);\n"
    "    vxs_span span;\n"
    "    while (count < 120 && vxs_walk_next(light.first_word, light, w, span) != 0) {\n"
    "        count++;\n"
    "        spans[at + count] = vec4(span.begin, span.end, float(span.state), float(span.coarse));\n"
    "    }\n"
    "    spans[at] = vec4(float(count));\n"
    "}\n";

/* drawing ------------------------------------------------------------------------------------------------------------------------ */

/* A context, and programs that are the same for all files. */
static struct {
    gl_context               *gl;
    GLuint                    places, table_places, rays, table_rays, asked, answers;
    PFNGLDISPATCHCOMPUTEPROC  dispatch;
    PFNGLGETSHADERINFOLOGPROC info_log;
    PFNGLMEMORYBARRIERPROC    barrier;
    PFNGLGETBUFFERSUBDATAPROC read;
} on;

/* 0: there is no OSMesa. */
static int start(void)
{
    run_context m = {0};
    if (gl_context_create(&on.gl, gl_choice(), 1, &m) != VXS_OK) {
        printf("# no OpenGL 4.5: %s\n", m.error);
        return 0;
    }
    on.dispatch = (PFNGLDISPATCHCOMPUTEPROC)gl_choice_proc("glDispatchCompute", NULL);
    on.info_log = (PFNGLGETSHADERINFOLOGPROC)gl_choice_proc("glGetShaderInfoLog", NULL);
    on.barrier  = (PFNGLMEMORYBARRIERPROC)gl_choice_proc("glMemoryBarrier", NULL);
    on.read     = (PFNGLGETBUFFERSUBDATAPROC)gl_choice_proc("glGetBufferSubData", NULL);
    on.gl->GenBuffers(1, &on.asked);
    on.gl->GenBuffers(1, &on.answers);
    return 1;
}

static GLuint program_of(const vxs_gl *shadows, const char *body)
{
    /* one program for lights of all kinds, because it is kept for all inputs */
    static const char any_light[] = "#undef VXS_ONLY_KIND\n#undef VXS_ONLY_CUBE\n#undef VXS_ONLY_CODING\n";
    const char       *texts[VXS_GL_TEXTS + 4];
    char              log[4096] = "";
    GLint             good;
    GLuint            shader = on.gl->CreateShader(GL_COMPUTE_SHADER), program = on.gl->CreateProgram();
    vxs_gl_texts(shadows, texts + 1);
    texts[0]                = texts[1];
    texts[1]                = any_light;
    texts[VXS_GL_TEXTS + 1] = vxs_volumes_text_vxs_depths_h.text;
    texts[VXS_GL_TEXTS + 2] = vxs_volumes_text_vxs_intervals_h.text;
    texts[VXS_GL_TEXTS + 3] = body;
    on.gl->ShaderSource(shader, VXS_GL_TEXTS + 4, texts, NULL);
    on.gl->CompileShader(shader);
    on.info_log(shader, sizeof log, NULL, log);
    if (log[0]) fprintf(stderr, "%s\n", log);
    on.gl->AttachShader(program, shader);
    on.gl->LinkProgram(program);
    on.gl->GetProgramiv(program, GL_LINK_STATUS, &good);
    FUZZ_CHECK(good);
    on.gl->DeleteShader(shader);
    return program;
}

static void put_buffer(GLuint buffer, GLuint binding, size_t size, const void *data)
{
    on.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    on.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_STATIC_DRAW);
    on.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
}

static void ask(const vxs_gl *shadows, GLuint *program, const char *body, GLuint count, const void *asked, size_t asked_bytes,
                void *answers, size_t answer_bytes)
{
    if (!*program) *program = program_of(shadows, body);
    on.gl->UseProgram(*program);
    vxs_gl_bind(shadows);
    put_buffer(on.asked, PLACES_AT, asked_bytes, asked);
    put_buffer(on.answers, ANSWERS_AT, answer_bytes, NULL);
    on.dispatch(count / 64, 1, 1);
    on.barrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    on.read(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)answer_bytes, answers);
    FUZZ_CHECK(on.gl->GetError() == GL_NO_ERROR);
}

/* places ------------------------------------------------------------------------------------------------------------------------- */

/* Lights as shaders have them, and as C has. */
typedef struct lights {
    const vxs_baked_light *baked[2 * LIGHTS];
    vxs_baked_light        rough[LIGHTS];
    uint32_t               count;
} lights;

static float as_float(double x)
{
    return fabs(x) < 1e30 ? (float)x : x < 0 ? -1e30F : 1e30F;
}

/* Anywhere; half of them at the voxel where light first ends, or beside it. */
static place random_place(const lights *l, uint64_t *random)
{
    place                  p = {.light = (int32_t)random_below_of(random, l->count), .ask = (int32_t)random_below_of(random, ASKS)};
    const vxs_baked_light *baked = l->baked[p.light];
    int32_t                side  = 1 << baked->light.levels, out;
    double                 ws[3];
    if (p.ask == ASK_DEPTH && baked->light.coding != VXS_CODING_BLOCKS) p.ask = ASK_VOXEL;
    p.map       = (int32_t)random_below_of(random, vxs_map_count(&baked->light));
    p.width_px  = 1 + 2 * (int32_t)random_below_of(random, VXS_FILTER_MAX / 2 + 1);
    p.is_smooth = (int32_t)random_below_of(random, 2);
    if (p.is_smooth) p.width_px = 1 + (int32_t)random_below_of(random, VXS_FILTER_MAX);
    out = p.ask == ASK_VOXEL && (p.is_smooth || p.width_px > 1) ? 12 : 0;
    p.i = (int32_t)random_below_of(random, (uint32_t)(side + 2 * out)) - out;
    p.j = (int32_t)random_below_of(random, (uint32_t)(side + 2 * out)) - out;
    p.k = (int32_t)random_below_of(random, (uint32_t)side);
    if (p.i >= 0 && p.j >= 0 && p.i < side && p.j < side && random_below_of(random, 2)) {
        int32_t near = vxs_first_shadow(baked, p.map, p.i, p.j, NULL) + (int32_t)random_below_of(random, 3) - 1;
        if (near >= 0 && near < side) p.k = near;
    }
    point_ws(&baked->light, random, ws);
    for (int n = 0; n < 3; n++) p.at[n] = as_float(ws[n]);
    return p;
}

static void check_place(const lights *l, const place *p, const answer *a)
{
    const vxs_baked_light *baked  = l->baked[p->light];
    const vxs_light       *light  = &baked->light;
    vxs_filter             filter = {p->width_px, p->is_smooth};
    int32_t                last = (1 << light->levels) - 1, is_point = p->ask == ASK_POINT;
    vxs_place              at = {p->map, {p->i, p->j, p->k}, (uint32_t)(7 * p->i) & 255, (uint32_t)(5 * p->j) & 255};
    if (is_point) at = (vxs_place){a->map, {a->i, a->j, a->k}, a->across, a->down};
    FUZZ_CHECK(at.map >= -1 && at.map < (int32_t)vxs_map_count(light));
    if (at.map < 0) return;
    uint32_t k = (uint32_t)(at.voxel[2] < last ? at.voxel[2] : last), dark = 0;
    if (p->ask == ASK_DEPTH)
        dark = (uint32_t)vxs_first_shadow(baked, p->map, p->i, p->j, NULL);
    else if (at.voxel[2] >= 0)
        dark = p->is_smooth ? vxs_shadow_part(baked->words, light, at, k, p->width_px)
                            : vxs_shadow_taps(baked->words, light, at.map, at.voxel[0], at.voxel[1], k, p->width_px);
    FUZZ_CHECK(a->dark == dark);
    FUZZ_CHECK(p->ask == ASK_DEPTH || (int32_t)a->is_full == vxs_is_full_at_place(baked->words, light, at, filter));
}

static void check_places(const vxs_gl *shadows, const lights *l, uint64_t *random)
{
    static place  places[PLACES];
    static answer answers[PLACES];
    for (int n = 0; n < PLACES; n++) places[n] = random_place(l, random);
    ask(shadows, vxs_gl_table_bytes(shadows) ? &on.table_places : &on.places, places_text, PLACES, places, sizeof places, answers,
        sizeof answers);
    for (int n = 0; n < PLACES; n++) check_place(l, &places[n], &answers[n]);
}

/* rays --------------------------------------------------------------------------------------------------------------------------- */

/* 1: nothing that a shader has of a light and of a ray, sums up, or multiplies, is more or less than floats hold. */
static int is_moderate(const vxs_light *l, const ray *r)
{
    double most = fmax(fmax(l->texel_metres, l->voxel_metres), fmax(l->range_metres, l->near_metres));
    for (int row = 0; row < 3; row++)
        for (int n = 0; n < 4; n++) {
            double sum = n < 3 ? 1 + fabs((double)r->origin[n]) + fabs((double)r->direction[n]) : 1;
            most       = fmax(most, fabs(l->ls_from_ws[4 * row + n]) * sum);
        }
    double least = fmin(fmin(l->texel_metres, l->voxel_metres), l->range_metres > 0 ? l->range_metres : 1);
    return most < 1e9 && fmin(least, l->near_metres > 0 ? l->near_metres : 1) > 1e-9;
}

static void check_ray(const vxs_baked_light *baked, const ray *r, const spans *found)
{
    uint32_t count = (uint32_t)found->count;
    FUZZ_CHECK(count <= SPANS);
    if (!is_moderate(&baked->light, r)) return;
    vxs_ray in_double = {.t_end = 1};
    for (int n = 0; n < 3; n++) {
        in_double.origin_ws[n]    = (double)r->origin[n];
        in_double.direction_ws[n] = (double)r->direction[n];
    }
    for (uint32_t n = 0; n < count; n++) {
        double  begin = (double)found->span[n].begin, end = (double)found->span[n].end;
        int32_t state = (int32_t)found->span[n].state, clear = clear_state(baked, &in_double, begin, end, in_floats);
        FUZZ_CHECK(begin < end && begin == (double)(n ? found->span[n - 1].end : r->begin));
        FUZZ_CHECK(clear < 0 || clear == state);
    }
}

static void check_rays(const vxs_gl *shadows, const lights *l, uint64_t *random)
{
    static ray   rays[RAYS];
    static spans found[RAYS];
    for (int n = 0; n < RAYS; n++) {
        ray   *r = &rays[n];
        double from[3], to[3];
        *r                     = (ray){.end = 1, .light = (int32_t)random_below_of(random, l->count)};
        const vxs_light *light = &l->baked[r->light]->light;
        point_ws(light, random, from);
        point_ws(light, random, to);
        for (int k = 0; k < 3; k++) {
            r->origin[k]    = as_float(from[k]);
            r->direction[k] = as_float(to[k] - from[k]);
        }
    }
    ask(shadows, vxs_gl_table_bytes(shadows) ? &on.table_rays : &on.rays, rays_text, RAYS, rays, sizeof rays, found, sizeof found);
    for (int n = 0; n < RAYS; n++) check_ray(l->baked[rays[n].light], &rays[n], &found[n]);
}

/* files -------------------------------------------------------------------------------------------------------------------------- */

/* The light without pages; a copy is the caller's. */
static vxs_baked_light without_pages(const vxs_baked_light *l)
{
    vxs_baked_light rough = *l;
    uint32_t        count = l->word_count + VXS_BLOCKS_SPARE_WORDS, *words = malloc(count * sizeof *words);
    FUZZ_CHECK(words);
    memcpy(words, l->words, count * sizeof *words);
    memset(words + 8, 0, words[0] * sizeof *words);
    rough.words = words;
    return rough;
}

static uint32_t words_of(const vxs_baked_light *l)
{
    return l->word_count + (l->light.coding == VXS_CODING_BLOCKS ? VXS_BLOCKS_SPARE_WORDS : 0);
}

static void add_light(lights *l, vxs_gl_light *list, const vxs_baked_light *baked, uint32_t *words)
{
    l->baked[l->count] = baked;
    list[l->count++]   = (vxs_gl_light){&baked->light, *words};
    *words += words_of(baked);
}

static void check_lights(const lights *l, const vxs_gl_light *list, uint32_t word_count, uint64_t random)
{
    vxs_gl     *shadows;
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_choice_proc,
                        .lights           = list,
                        .light_count      = l->count,
                        .word_count       = word_count,
                        .storage          = VXS_GL_BUFFER};
    if (vxs_gl_create(&shadows, &desc) != VXS_OK) return;
    for (uint32_t n = 0; n < l->count; n++)
        FUZZ_CHECK(vxs_gl_put(shadows, l->baked[n]->words, list[n].first_word, words_of(l->baked[n])) == VXS_OK);
    FUZZ_CHECK(vxs_gl_upload(shadows, SIZE_MAX) == 0);
    check_places(shadows, l, &random);
    check_rays(shadows, l, &random);
    vxs_gl_destroy(shadows);
}

/* The lights as the asset has them, by their tables. */
static void check_tables(const vxs_asset *asset, uint64_t random)
{
    vxs_gl     *shadows;
    vxs_gl_desc desc  = {.struct_size = sizeof desc, .get_proc_address = gl_choice_proc, .storage = VXS_GL_BUFFER};
    lights      whole = {0};
    for (; whole.count < vxs_asset_light_count(asset) && whole.count < LIGHTS; whole.count++)
        whole.baked[whole.count] = vxs_asset_light(asset, whole.count);
    desc.baked       = whole.baked;
    desc.light_count = whole.count;
    if (vxs_gl_create(&shadows, &desc) != VXS_OK) return;
    FUZZ_CHECK(vxs_gl_upload(shadows, SIZE_MAX) == 0);
    if (vxs_gl_table_bytes(shadows)) {
        check_places(shadows, &whole, &random);
        check_rays(shadows, &whole, &random);
    }
    vxs_gl_destroy(shadows);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static int    started;
    vxs_read_desc desc  = {.memory_limit_bytes = MEMORY_LIMIT_BYTES};
    vxs_asset    *asset = NULL;
    vxs_gl_light  list[2 * LIGHTS];
    lights        l     = {0};
    uint32_t      words = 0, copies = 0;
    if (!started) started = start() ? 1 : -1;
    if (started < 0 || vxs_asset_open(&asset, data, size, &desc) != VXS_OK) return 0;
    for (uint32_t n = 0; n < vxs_asset_light_count(asset) && n < LIGHTS; n++) {
        const vxs_baked_light *baked = vxs_asset_light(asset, n);
        add_light(&l, list, baked, &words);
        if (baked->light.coding != VXS_CODING_BLOCKS) continue;
        l.rough[copies] = without_pages(baked);
        add_light(&l, list, &l.rough[copies++], &words);
    }
    if (l.count) check_lights(&l, list, words, size);
    if (l.count) check_tables(asset, size);
    while (copies) free((uint32_t *)l.rough[--copies].words);
    vxs_asset_close(asset);
    return 0;
}
