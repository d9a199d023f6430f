/* Lookups in a light's words, against a dense array of every voxel, on the CPU and in a compute shader.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup.h" /* first: it needs nothing before it */

#include "baker/columns/opengl/gl.h"

#include <GL/osmesa.h>
#include <stdio.h>

#include "dag_sample.h"
#include "random_lamp.h"
#include "runtime/vxs.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* A sample, and the words of its light. */
typedef struct subject {
    dag_sample sample;
    vxs_asset *asset;
} subject;

static subject subject_make(uint64_t seed, uint32_t levels, uint32_t count_max)
{
    subject s = {0};
    rng     r = {seed};
    dag_sample_init(&s.sample, &r, levels, count_max);
    vxs_bytes file = dag_sample_file(&s.sample);
    assert_int_equal(vxs_asset_open(&s.asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    return s;
}

static void subject_free(subject *s)
{
    vxs_asset_close(s->asset);
    dag_sample_free(&s->sample);
}

/* Shadowed taps of a box, one at a time; what is outside the map is lit. */
static uint32_t count_taps(const dag_sample *s, int32_t i, int32_t j, uint32_t k, int32_t filter_px)
{
    int32_t  side = 1 << s->levels, half_px = filter_px / 2;
    uint32_t count = 0;
    for (int32_t y = j - half_px; y <= j + half_px; y++)
        for (int32_t x = i - half_px; x <= i + half_px; x++)
            if (x >= 0 && y >= 0 && x < side && y < side) count += dag_sample_shadow(s, (uint32_t)x, (uint32_t)y, k);
    return count;
}

static void test_popcount(void **state)
{
    (void)state;
    rng r = {1};
    for (int n = 0; n < 100000; n++) {
        uint32_t x = rng_u32(&r) & rng_u32(&r), bits = 0;
        for (int bit = 0; bit < 32; bit++) bits += x >> bit & 1;
        assert_int_equal(vxs_popcount(x), bits);
    }
    assert_int_equal(vxs_popcount(0u), 0);
    assert_int_equal(vxs_popcount(0xffffffffu), 32);
}

/* Every range that starts or ends inside a word of a mask, or beyond it. */
static void test_cover(void **state)
{
    (void)state;
    for (int32_t x0 = -17; x0 <= 9; x0++)
        for (int32_t x1 = x0; x1 <= 25; x1++)
            for (int32_t y0 = -17; y0 <= 5; y0++)
                for (int32_t y1 = y0; y1 <= 21; y1++) {
                    uint32_t wanted = 0;
                    for (int32_t bit = 0; bit < 32; bit++)
                        if (bit % 8 >= x0 && bit % 8 < x1 && bit / 8 >= y0 && bit / 8 < y1) wanted |= 1u << bit;
                    assert_int_equal(vxs_cover(x0, x1, y0, y1), wanted);
                }
}

/* Every voxel, every filter, every centre near enough to touch a map of 32 x 32 texels: by a table of sums over the map. */
static void test_count_exhaustive(void **state)
{
    (void)state;
    enum { SIDE = 32, PAD = 20, TABLE = SIDE + 2 * PAD + 1 };
    subject                s     = subject_make(11, 5, 40);
    const vxs_baked_light *light = vxs_asset_light(s.asset, 0);
    for (uint32_t k = 0; k < SIDE; k++) {
        static uint32_t sum[TABLE][TABLE]; /* shadowed texels in front of (x, y), both counted from -PAD */
        for (int y = 1; y < TABLE; y++)
            for (int x = 1; x < TABLE; x++) {
                int      i = x - 1 - PAD, j = y - 1 - PAD;
                uint32_t shadow =
                    i >= 0 && j >= 0 && i < SIDE && j < SIDE && dag_sample_shadow(&s.sample, (uint32_t)i, (uint32_t)j, k);
                sum[y][x] = shadow + sum[y - 1][x] + sum[y][x - 1] - sum[y - 1][x - 1];
            }
        for (int filter_px = 1; filter_px <= VXS_FILTER_MAX; filter_px += 2)
            for (int j = -10; j < SIDE + 10; j++)
                for (int i = -10; i < SIDE + 10; i++) {
                    int      x0 = i - filter_px / 2 + PAD, x1 = x0 + filter_px, y0 = j - filter_px / 2 + PAD, y1 = y0 + filter_px;
                    uint32_t wanted = sum[y1][x1] - sum[y0][x1] - sum[y1][x0] + sum[y0][x0];
                    if (vxs_shadow_count(light->dag.words, 0, light->light.levels, i, j, k, filter_px) != wanted)
                        fail_msg("texel %d %d, depth %u, filter %d", i, j, k, filter_px);
                }
    }
    subject_free(&s);
}

/* A texel near what may go wrong: borders of tiles, corners of the map, just outside and far outside. */
static int32_t tricky_texel(rng *r, int32_t side)
{
    switch (rng_below(r, 8)) {
    case 0: return rng_between(r, -12, 12);
    case 1: return side + rng_between(r, -12, 12);
    case 2: return 8 * rng_between(r, 0, side / 8) + rng_between(r, -1, 1);
    case 3: return side / 2 + rng_between(r, -9, 9);
    case 4: return rng_below(r, 16) ? rng_between(r, -side, 2 * side) : rng_below(r, 2) ? -(1 << 30) : 1 << 30;
    default: return rng_between(r, 0, side - 1);
    }
}

static void test_lookups_random(void **state)
{
    (void)state;
    rng r = {3};
    for (uint32_t levels = 3; levels <= 8; levels++) {
        subject                s     = subject_make(20 + levels, levels, levels < 5 ? 12 : 200);
        const vxs_baked_light *light = vxs_asset_light(s.asset, 0);
        uint32_t               side  = 1u << levels;
        for (int n = 0; n < 10000; n++) {
            int32_t  i = tricky_texel(&r, (int32_t)side), j = tricky_texel(&r, (int32_t)side);
            uint32_t k         = rng_below(&r, side);
            int32_t  filter_px = 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2);
            assert_int_equal(vxs_shadow_count(light->dag.words, 0, levels, i, j, k, filter_px),
                             count_taps(&s.sample, i, j, k, filter_px));
            if (i < 0 || j < 0 || i >= (int32_t)side || j >= (int32_t)side) continue;
            assert_int_equal(vxs_shadow(light->dag.words, 0, levels, (uint32_t)i, (uint32_t)j, k),
                             dag_sample_shadow(&s.sample, (uint32_t)i, (uint32_t)j, k));
        }
        subject_free(&s);
    }
}

/* the same text as a shader ---------------------------------------------------------------------------------------------------- */

#define COMPUTE_FUNCTIONS(X)                                                                                                       \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                                                                     \
    X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                                                                                   \
    X(PFNGLGETBUFFERSUBDATAPROC, GetBufferSubData)                                                                                 \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                                           \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                                                                 \
    X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                                                                                       \
    X(PFNGLUNIFORM1FPROC, Uniform1f)                                                                                               \
    X(PFNGLUNIFORM1UIPROC, Uniform1ui)                                                                                             \
    X(PFNGLUNIFORMMATRIX4X3FVPROC, UniformMatrix4x3fv)

typedef struct compute {
    gl_context *gl;
#define COMPUTE_POINTER(type, name) type name;
    COMPUTE_FUNCTIONS(COMPUTE_POINTER)
#undef COMPUTE_POINTER
} compute;

/* As the shader declares it. */
typedef struct query {
    uint32_t dag, levels;
    int32_t  i, j;
    uint32_t k;
    int32_t  filter_px;
} query;

enum { GROUP = 64, QUERIES = 256 * GROUP };

static const char before_lookup[] = "#version 430 core\n"
                                    "layout(local_size_x = 64) in;\n"
                                    "layout(std430, binding = 0) readonly buffer words { uint vxs_words[]; };\n";
static const char after_lookup[]  = "struct query { uint dag, levels; int i, j; uint k; int filter_px; };\n"
                                    "layout(std430, binding = 1) readonly buffer queries { query q[]; };\n"
                                    "layout(std430, binding = 2) writeonly buffer answers { uvec2 answer[]; };\n"
                                    "void main() {\n"
                                    "    query a = q[gl_GlobalInvocationID.x];\n"
                                    "    uint last = (1u << a.levels) - 1u;\n"
                                    "    uint i = min(uint(max(a.i, 0)), last), j = min(uint(max(a.j, 0)), last);\n"
                                    "    answer[gl_GlobalInvocationID.x] =\n"
                                    "        uvec2(vxs_shadow_count(a.dag, 0u, a.levels, a.i, a.j, a.k, a.filter_px),\n"
                                    "              vxs_shadow(a.dag, 0u, a.levels, i, j, a.k));\n"
                                    "}\n";

static void read_text(const char *path, char *text, size_t size)
{
    FILE *file = fopen(path, "r");
    if (!file) {
        print_message("%s is not here: start this test in the root of the repository\n", path);
        skip();
    }
    text[fread(text, 1, size - 1, file)] = 0;
    fclose(file);
}

/* The text of vxs_lookup.h between two others, as the program in use. */
static void compile_shader(const compute *c, const char *body, const char *end)
{
    char        header[16384], log[4096] = "";
    const char *text[4] = {before_lookup, header, body, end};
    GLint       good;
    read_text("formats/vxs_lookup.h", header, sizeof header);
    GLuint shader = c->gl->CreateShader(GL_COMPUTE_SHADER);
    c->gl->ShaderSource(shader, 4, text, NULL);
    c->gl->CompileShader(shader);
    c->GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    c->GetShaderInfoLog(shader, sizeof log, NULL, log);
    if (!good) fail_msg("vxs_lookup.h as GLSL: %s", log);
    assert_string_equal(log, ""); /* no warning */
    GLuint program = c->gl->CreateProgram();
    c->gl->AttachShader(program, shader);
    c->gl->LinkProgram(program);
    c->gl->GetProgramiv(program, GL_LINK_STATUS, &good);
    assert_true(good);
    c->gl->UseProgram(program);
    c->gl->DeleteShader(shader);
}

static void bind_buffer(const compute *c, GLuint binding, size_t size, const void *data)
{
    GLuint buffer;
    c->gl->GenBuffers(1, &buffer);
    c->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    c->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_DYNAMIC_DRAW);
    c->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
}

/* The words of several lights in one buffer, each light's from a word of its own; returns how many there are. */
static uint32_t gather_words(const subject *s, uint32_t count, uint32_t *dag, uint32_t **all)
{
    uint32_t total = 5; /* no light starts at word 0 */
    for (uint32_t n = 0; n < count; n++) {
        dag[n] = total;
        total += vxs_asset_light(s[n].asset, 0)->dag.word_count;
    }
    *all = dag_sample_alloc(total, sizeof **all);
    for (uint32_t n = 0; n < count; n++) {
        const vxs_baked_light *light = vxs_asset_light(s[n].asset, 0);
        memcpy(*all + dag[n], light->dag.words, light->dag.word_count * sizeof **all);
    }
    return total;
}

static compute make_compute(void)
{
    compute c = {0};
    message m = {0};
    if (gl_context_create(&c.gl, GL_BACKEND_OSMESA, 1, &m) != VXS_OK) {
        print_message("no OpenGL 4.5: %s\n", m.error);
        skip();
    }
#define COMPUTE_LOAD(type, name)                                                                                                   \
    c.name = (type)OSMesaGetProcAddress("gl" #name);                                                                               \
    assert_true(c.name != NULL);
    COMPUTE_FUNCTIONS(COMPUTE_LOAD)
#undef COMPUTE_LOAD
    return c;
}

static void test_shader_answers_like_c(void **state)
{
    (void)state;
    compute c = make_compute();
    compile_shader(&c, after_lookup, "");

    subject   s[3] = {subject_make(31, 3, 12), subject_make(32, 6, 200), subject_make(33, 8, 300)};
    uint32_t  dag[3], *words;
    uint32_t  word_count = gather_words(s, 3, dag, &words);
    query    *queries    = dag_sample_alloc(QUERIES, sizeof *queries);
    uint32_t *answers    = dag_sample_alloc(QUERIES, 2 * sizeof *answers);
    rng       r          = {9};
    for (uint32_t n = 0; n < QUERIES; n++) {
        uint32_t levels = s[n % 3].sample.levels;
        int32_t  i = tricky_texel(&r, 1 << levels), j = tricky_texel(&r, 1 << levels);
        queries[n] = (query){dag[n % 3], levels, i, j, rng_below(&r, 1u << levels), 1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2)};
    }
    bind_buffer(&c, 0, word_count * sizeof *words, words);
    bind_buffer(&c, 1, QUERIES * sizeof *queries, queries);
    bind_buffer(&c, 2, QUERIES * 2 * sizeof *answers, NULL); /* stays bound, to be read back */
    c.DispatchCompute(QUERIES / GROUP, 1, 1);
    c.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    c.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, QUERIES * 2 * sizeof *answers, answers);
    assert_int_equal(c.gl->GetError(), GL_NO_ERROR);

    for (uint32_t n = 0; n < QUERIES; n++) {
        const query           *q     = &queries[n];
        const vxs_baked_light *light = vxs_asset_light(s[n % 3].asset, 0);
        int32_t                last  = (1 << q->levels) - 1;
        uint32_t i = (uint32_t)(q->i < 0 ? 0 : q->i < last ? q->i : last), j = (uint32_t)(q->j < 0 ? 0 : q->j < last ? q->j : last);
        assert_int_equal(answers[2 * n], vxs_shadow_count(light->dag.words, 0, q->levels, q->i, q->j, q->k, q->filter_px));
        assert_int_equal(answers[2 * n + 1], vxs_shadow(light->dag.words, 0, q->levels, i, j, q->k));
    }
    gl_context_destroy(c.gl);
    free(answers);
    free(queries);
    free(words);
    for (int n = 0; n < 3; n++) subject_free(&s[n]);
}

/* the shader of the guide ------------------------------------------------------------------------------------------------------ */

static const char after_guide[] = "struct query { vec4 position, normal; };\n"
                                  "layout(std430, binding = 1) readonly buffer queries { query q[]; };\n"
                                  "layout(std430, binding = 2) writeonly buffer answers { float answer[]; };\n"
                                  "void main() {\n"
                                  "    query a = q[gl_GlobalInvocationID.x];\n"
                                  "    answer[gl_GlobalInvocationID.x] = lamp_lit(a.position.xyz, a.normal.xyz, int(a.normal.w));\n"
                                  "}\n";

/* What the guide's second shader has between the lookup's text and its main. */
static void read_guide(char *text, size_t size)
{
    read_text("docs/runtime.md", text, size);
    char *shader = text;
    for (int n = 0; n < 2; n++) {
        shader = strstr(shader + 1, "```glsl\n");
        assert_non_null(shader);
    }
    char *body = strstr(shader, "#include \"vxs_lookup.h\"\n");
    assert_non_null(body);
    char *end = strstr(body, "void main()");
    assert_non_null(end);
    body += strlen("#include \"vxs_lookup.h\"\n");
    *end = 0;
    memmove(text, body, (size_t)(end - body) + 1);
}

/* Locations as the guide has them. */
static void set_lamp(const compute *c, const vxs_light *l)
{
    float matrix[12];
    for (int n = 0; n < 12; n++) matrix[n] = (float)l->ls_from_ws[n];
    c->UniformMatrix4x3fv(0, 1, GL_TRUE, matrix);
    c->Uniform1ui(4, l->levels);
    c->Uniform1ui(5, (l->flags & VXS_LIGHT_CUBE) != 0);
    c->Uniform1f(6, (float)l->texel_metres);
    c->Uniform1f(7, (float)l->voxel_metres);
    c->Uniform1f(8, (float)l->near_metres);
    c->Uniform1f(9, l->kind == VXS_LIGHT_KIND_POINT ? -2 : (float)l->cos_outer);
    c->Uniform1f(10, (float)l->range_metres);
}

/* How far a point is from where rounding decides: a voxel's side, an edge of cone, range or cube, a step that is whole. */
static double clear_by(const vxs_light *l, const float *position, const float *normal, int filter_px)
{
    double ls[3], n[3], by = 1, size[3];
    for (int row = 0; row < 3; row++) {
        const double *m = l->ls_from_ws + 4 * row;
        n[row]          = m[0] * (double)normal[0] + m[1] * (double)normal[1] + m[2] * (double)normal[2];
        ls[row]         = m[0] * (double)position[0] + m[1] * (double)position[1] + m[2] * (double)position[2] + m[3];
        size[row]       = fabs(ls[row]);
    }
    double metres = sqrt(dot(ls, ls)), side = ldexp(1, (int)l->levels);
    if (l->kind == VXS_LIGHT_KIND_SPOT) by = fmin(by, 100 * fabs(ls[2] / metres - l->cos_outer));
    if (l->range_metres > 0) by = fmin(by, 100 * fabs(metres / l->range_metres - 1));
    int along = l->flags & VXS_LIGHT_CUBE ? size[1] > size[0] ? 1 : 0 : 2;
    if (size[2] > size[along]) along = 2;
    for (int c = 0; c < 3; c++) {
        if (c == along) continue;
        double slope = ls[c] / ls[along], step = 0.5 * filter_px * (n[c] - n[along] * slope);
        double texel = side / 2 + slope / l->texel_metres;
        if (l->flags & VXS_LIGHT_CUBE) by = fmin(by, 100 * fabs(size[c] / size[along] - 1));
        by = fmin(by, fmin(fabs(texel - rint(texel)), fabs(step) < 1e-9 ? 1 : fabs(step - rint(step))));
    }
    double step  = 0.5 * filter_px * n[along] * l->texel_metres / l->voxel_metres,
           depth = log(size[along] / l->near_metres) / l->voxel_metres;
    return fmin(by, fmin(fabs(depth - rint(depth)), fabs(step) < 1e-9 ? 1 : fabs(step - rint(step))));
}

static void test_shader_of_the_guide(void **state)
{
    enum { POINTS = 64 * GROUP };
    static char  guide[1 << 16];
    static float queries[POINTS][8], answers[POINTS];
    (void)state;
    compute c = make_compute();
    read_guide(guide, sizeof guide);
    compile_shader(&c, guide, after_guide);
    rng r     = {61};
    int asked = 0, outside = 0, partly = 0;
    for (int shape = 0; shape < 9; shape++) {
        static const uint32_t kinds[3] = {VXS_LIGHT_KIND_SPOT, VXS_LIGHT_KIND_SPOT, VXS_LIGHT_KIND_POINT};
        dag_sample            sample;
        uint32_t              levels = 4 + (uint32_t)shape / 3 * 2;
        lamp                  of     = random_lamp(&r, (lamp_shape)(shape % 3));
        vxs_asset            *asset;
        vxs_bytes             file = {0};
        dag_sample_init(&sample, &r, levels, 200);
        vxs_write_light light = dag_sample_lamp(&sample, "lamp", kinds[shape % 3], shape % 3 ? VXS_LIGHT_CUBE : 0);
        for (int n = 0; n < 3; n++) {
            memcpy(light.light.ls_from_ws + 4 * n, of.axis[n], sizeof of.axis[n]);
            of.at[n] /= 10;
        }
        for (int n = 0; n < 3; n++) light.light.ls_from_ws[4 * n + 3] = -dot(of.axis[n], of.at);
        memcpy(light.light.direction_ws, of.axis[2], sizeof of.axis[2]);
        if (shape % 2) light.light.range_metres = 6;
        vxs_write_desc desc = {.lights = &light, .light_count = 1, .zstd_level = 1};
        assert_int_equal(vxs_write(&file, &desc), VXS_OK);
        assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
        const vxs_baked_light *baked = vxs_asset_light(asset, 0);
        const vxs_light       *l     = &baked->light;

        for (int n = 0; n < POINTS; n++) {
            double way[3], normal[3], metres = 0.4 * pow(25, uniform(&r, 0, 1));
            random_direction(&r, way);
            random_direction(&r, normal);
            for (int k = 0; k < 3; k++) {
                queries[n][k]     = (float)(of.at[k] + metres * way[k] + (shape % 3 == 0 ? 0.7 * metres * of.axis[2][k] : 0));
                queries[n][4 + k] = n % 3 ? (float)normal[k] : 0;
            }
            queries[n][7] = (float)(1 + 2 * rng_between(&r, 0, VXS_FILTER_MAX / 2));
        }
        set_lamp(&c, l);
        bind_buffer(&c, 0, baked->dag.word_count * sizeof *baked->dag.words, baked->dag.words);
        bind_buffer(&c, 1, sizeof queries, queries);
        bind_buffer(&c, 2, sizeof answers, NULL);
        c.DispatchCompute(POINTS / GROUP, 1, 1);
        c.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        c.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof answers, answers);
        assert_int_equal(c.gl->GetError(), GL_NO_ERROR);
        for (int n = 0; n < POINTS; n++) {
            int    filter_px = (int)queries[n][7];
            double point[3], normal[3];
            for (int k = 0; k < 3; k++) point[k] = (double)queries[n][k], normal[k] = (double)queries[n][4 + k];
            if (clear_by(l, queries[n], queries[n] + 4, filter_px) < 0.005) continue;
            float wanted = vxs_lookup(baked, point, normal, filter_px);
            if (fabsf(answers[n] - wanted) > 1e-6f)
                fail_msg("light %d, point %d: %g, expected %g", shape, n, (double)answers[n], (double)wanted);
            asked++;
            outside += wanted < 0;
            partly += wanted > 0 && wanted < 1;
        }
        vxs_asset_close(asset);
        free(file.data);
        dag_sample_free(&sample);
    }
    assert_true(asked > 9 * POINTS * 8 / 10 && outside > POINTS / 2 && partly > POINTS);
    gl_context_destroy(c.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_popcount),
        cmocka_unit_test(test_cover),
        cmocka_unit_test(test_count_exhaustive),
        cmocka_unit_test(test_lookups_random),
        cmocka_unit_test(test_shader_answers_like_c),
        cmocka_unit_test(test_shader_of_the_guide),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
