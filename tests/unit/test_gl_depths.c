/* Depth textures and depth pages (runtime/gl/vxs_gl_depths.h): the depths that C gives, texel by texel; and lookups by pages, by the
 * words of a coarser level, and by taps that are counted here one by one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>

#include "alloc_fail.h"
#include "repeats.h"
#include "runtime/gl/vxs_gl_depths.h"
#include "runtime/vxs_query.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_taps.h"
#include "stream_sample.h"

/* runtime/gl/view.glsl */
extern const char vxs_gl_text_view_glsl[];

enum { SUN, LAMP, SPOT, MOON };

typedef struct frame {
    drawing       d;
    rng           r;
    stream_sample s;
    vxs_gl       *gl;
} frame;

static char last_line[1024];

static void print_log(vxs_severity severity, const char *text, void *user)
{
    (void)severity;
    (void)user;
    snprintf(last_line, sizeof last_line, "%s", text);
    print_message("%s\n", text);
}

/* most_table_bytes  0: with tables; 1: words alone */
static frame frame_make(uint64_t most_table_bytes)
{
    frame f = {.d = drawing_make(), .r = {97}};
    stream_sample_init(&f.s, 2);
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_choice_proc,
                        .asset            = f.s.full,
                        .storage          = VXS_GL_BUFFER,
                        .log              = print_log,
                        .most_table_bytes = most_table_bytes};
    assert_int_equal(vxs_gl_create(&f.gl, &desc), VXS_OK);
    assert_int_equal(vxs_gl_upload(f.gl, SIZE_MAX), 0);
    return f;
}

static void frame_free(frame *f)
{
    vxs_gl_destroy(f->gl);
    stream_sample_free(&f->s);
    gl_context_destroy(f->d.gl);
}

static double uniform(rng *r, double low, double high)
{
    return low + (high - low) * (rng_u32(r) / 4294967296.0);
}

/* whole maps ------------------------------------------------------------------------------------------------------------------ */

/* Hardware comparisons at the middle of texels; position: texel and depth to compare with. */
static const char comparison_body[] = "in vec3 position_ws;\n"
                                      "in vec3 normal_ws;\n"
                                      "out float answer;\n"
                                      "layout(binding = 3) uniform sampler2DShadow map;\n"
                                      "void main() {\n"
                                      "    vec2 size = vec2(textureSize(map, 0));\n"
                                      "    answer = texture(map, vec3((position_ws.xy + 0.5) / size, position_ws.z));\n"
                                      "}\n";

static void check_texture(frame *f, const vxs_baked_light *baked, int map, uint32_t level, uint32_t bits)
{
    static query    queries[QUERIES];
    static float    answers[QUERIES];
    static uint32_t voxels[QUERIES];
    uint32_t        levels = baked->light.levels, side = 1u << (levels - level), lit = 0;
    GLuint          texture;
    int             coarse = 2;
    assert_int_equal(vxs_gl_depth_texture(f->gl, baked, map, level, bits, &texture, &coarse), VXS_OK);
    assert_int_equal(coarse, 0);
    f->d.gl->BindTextureUnit(3, texture);
    for (int n = 0; n < QUERIES; n++) {
        int32_t i = (int32_t)rng_below(&f->r, side), j = (int32_t)rng_below(&f->r, side), middle = 1 << level >> 1;
        int32_t depth = vxs_first_shadow(baked, map, (i << level) + middle, (j << level) + middle, NULL);
        int32_t k     = depth + rng_between(&f->r, -1, 1);
        k             = k < 0 ? 0 : k < 1 << levels ? k : (1 << levels) - 1;
        voxels[n]     = k >= depth; /* in shadow */
        float at   = bits == 16 ? ((float)k + 0.5F) * ldexpf(1, 16 - (int)levels) / 65535 : ldexpf((float)k + 0.5F, -(int)levels);
        queries[n] = (query){{(float)i, (float)j, at}, {0, 0, 0}};
    }
    draw(&f->d, queries, answers);
    for (int n = 0; n < QUERIES; n++) {
        if (answers[n] != (voxels[n] ? 0.0F : 1.0F))
            fail_msg("%s, map %d, level %u, %u bits, texel %g %g: %g", baked->light.name, map, level, bits,
                     (double)queries[n].position[0], (double)queries[n].position[1], (double)answers[n]);
        lit += !voxels[n];
    }
    assert_true(lit > QUERIES / 10 && lit < QUERIES - QUERIES / 10);
    f->d.gl->DeleteTextures(1, &texture);
}

static void test_textures(void **state)
{
    frame  f = frame_make(0);
    GLuint texture;
    (void)state;
    use_texts(&f.d, "comparison", "#version 430 core\n", (const char *[]){"#version 430 core\n", comparison_body}, 2);
    for (uint32_t light = 0; light < f.s.light_count; light++) {
        const vxs_baked_light *baked = vxs_asset_light(f.s.full, light);
        for (uint32_t level = 0; level < 4; level++)
            check_texture(&f, baked, (int)rng_below(&f.r, vxs_map_count(&baked->light)), level, level & 1 ? 32 : 16);
    }
    const vxs_baked_light *sun = vxs_asset_light(f.s.full, SUN);
    for (uint32_t bits = 16; bits <= 32; bits += 16)
        assert_int_equal(vxs_gl_depth_texture(f.gl, sun, 0, sun->light.levels, bits, &texture, NULL), VXS_OK);
    assert_int_equal(vxs_gl_depth_texture(f.gl, sun, 1, 0, 16, &texture, NULL), VXS_E_ARGUMENT);
    assert_int_equal(vxs_gl_depth_texture(f.gl, sun, 0, sun->light.levels + 1, 16, &texture, NULL), VXS_E_ARGUMENT);
    assert_int_equal(vxs_gl_depth_texture(f.gl, sun, 0, 0, 24, &texture, NULL), VXS_E_ARGUMENT);
    vxs_baked_light large = *sun;
    large.light.levels    = 18;
    assert_int_equal(vxs_gl_depth_texture(f.gl, &large, 0, 0, 16, &texture, NULL), VXS_E_MEMORY);
    assert_non_null(strstr(last_line, "use a coarser level"));
    assert_int_equal(texture, 0);
    frame_free(&f);
}

/* pages ------------------------------------------------------------------------------------------------------------------------ */

/* One answer for the point of each pixel. */
typedef enum answer { BY_PAGES, BY_WORDS, LEVEL, MAP, ACROSS, DOWN, DEPTH, PART, ANSWERS, BY_PAGES_ALONE, OF_LEVEL } answer;

static const char triangle_text[] =
    "#version 430 core\n"
    "void main() { gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0.0, 1.0); }\n";

static const char paged_body[] =
    "out float answer;\n"
    "uniform ivec4 asked; /* light, filter, what */\n"
    "uniform vec3 normal;\n"
    "void main() {\n"
    "    vec3 at;\n"
    "#ifndef VXS_PAGES_ALONE\n"
    "    if (asked.z == 10) { /* by the words, at level asked.w */\n"
    "        vxs_place tap = vxs_place(0, ivec3(gl_FragCoord.xy, 0), uint(gl_FragCoord.x) * 5u & 255u, uint(gl_FragCoord.y) * 9u & "
    "255u);\n"
    "        vxs_light_constants of = vxs_light_at(uint(asked.x));\n"
    "        int k = int(gl_FragCoord.x + gl_FragCoord.y) % (1 << (of.levels - uint(asked.w)));\n"
    "        answer = vxs_lit_by_words(vxs_taps_of(tap, vxs_filter(asked.y & 255, asked.y >> 8)), of, uint(asked.w), 0, k);\n"
    "        return;\n"
    "    }\n"
    "#endif\n"
    "    answer = -3.0;\n"
    "    if (!vxs_pixel_point(ivec2(gl_FragCoord.xy), at)) return;\n"
    "    uint n = uint(asked.x), level = vxs_depth_level(n, at);\n"
    "    vxs_filter pcf = vxs_filter(asked.y & 255, asked.y >> 8);\n"
    "    if (asked.z == 0) answer = vxs_paged_lit_by(n, at, normal, pcf);\n"
    "    if (asked.z == 1) answer = vxs_lit_by(n, at, normal, pcf);\n"
    "    vxs_place place = vxs_place_from_ws(vxs_light_of_level(vxs_light_at(n), level), at, normal, pcf);\n"
    "    if (asked.z == 2) answer = float(level);\n"
    "    if (asked.z == 3) answer = float(place.map);\n"
    "    if (asked.z >= 4 && asked.z < 7) answer = float(place.voxel[asked.z - 4]);\n"
    "    if (asked.z == 7) answer = float(place.across + 256u * place.down);\n"
    "}\n";

typedef struct paged {
    frame               *f;
    vxs_gl_depth_pages  *pages;
    vxs_depth_pages_view view;
    GLuint               depths, with_words, alone; /* the last two: programs */
    uint32_t             light, level;              /* level: of OF_LEVEL */
    vxs_filter           filter;
    float                normal[3];
} paged;

static GLuint paged_program(frame *f, const vxs_gl_depth_pages *pages, const char *defines)
{
    enum { PAGED_TEXTS = VXS_GL_TEXTS + VXS_GL_DEPTH_PAGES_TEXTS + 4 };
    const gl_context *gl = f->d.gl;
    const char       *texts[PAGED_TEXTS], *triangle = triangle_text;
    GLuint            vertex = gl->CreateShader(GL_VERTEX_SHADER), fragment = gl->CreateShader(GL_FRAGMENT_SHADER);
    GLint             good;
    vxs_gl_texts(f->gl, texts);
    texts[VXS_GL_TEXTS] = defines;
    vxs_gl_depth_pages_texts(pages, texts + VXS_GL_TEXTS + 1);
    texts[PAGED_TEXTS - 3] = "#define VXS_VIEW_METRES 1e15\n";
    texts[PAGED_TEXTS - 2] = vxs_gl_text_view_glsl;
    texts[PAGED_TEXTS - 1] = paged_body;
    gl->ShaderSource(vertex, 1, &triangle, NULL);
    gl->ShaderSource(fragment, PAGED_TEXTS, texts, NULL);
    f->d.program = gl->CreateProgram();
    compile(&f->d, "triangle", vertex);
    compile(&f->d, "pages", fragment);
    gl->LinkProgram(f->d.program);
    gl->GetProgramiv(f->d.program, GL_LINK_STATUS, &good);
    assert_true(good);
    return f->d.program;
}

/* Points all over the volume of a light, and beyond it: (u, v, depth) of a pixel are coordinates in a box. */
static void look_at(paged *p, const vxs_light *of)
{
    static float depths[QUERIES];
    frame       *f      = p->f;
    double       side   = (double)(1u << of->levels), from[3], to[3];
    int          is_sun = of->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    p->view.view        = (vxs_view){.width_px = WIDTH_PX, .height_px = HEIGHT_PX, .empty_depth = 2};
    float *m            = p->view.view.point_from_depth;
    vxs_point(of, 0, (double[3]){-0.05 * side, -0.05 * side, is_sun ? -0.05 * side : 0}, from);
    for (int n = 0; n < 3; n++) {
        double box[3] = {-0.05 * side, -0.05 * side, is_sun ? -0.05 * side : 0};
        box[n]        = 1.05 * side;
        vxs_point(of, 0, box, to);
        for (int k = 0; k < 3; k++) m[4 * n + k] = is_sun ? (float)(to[k] - from[k]) : k == n ? 8 : 0;
    }
    for (int k = 0; k < 3; k++) m[12 + k] = is_sun ? (float)from[k] : k == 0 ? -3 : k == 1 ? -2 : -1; /* the lamp is at (1, 2, 3) */
    m[15] = 1;
    for (int n = 0; n < QUERIES; n++) depths[n] = rng_below(&f->r, 40) ? (float)uniform(&f->r, 0, 1) : 2;
    f->d.gl->TextureSubImage2D(p->depths, 0, 0, 0, WIDTH_PX, HEIGHT_PX, GL_RED, GL_FLOAT, depths);
    for (int k = 0; k < 3; k++) p->view.eye[k] = m[12 + k] + (float)uniform(&f->r, 0, 1) * (m[k] + m[4 + k] + m[8 + k]);
}

/* The same for a light of the sample. */
static void look_at_sample(paged *p, uint32_t light)
{
    p->light = light;
    look_at(p, &vxs_asset_light(p->f->s.full, light)->light);
}

static paged paged_make(frame *f, const vxs_gl_depth_pages_desc *desc)
{
    paged p = {.f = f};
    assert_int_equal(vxs_gl_depth_pages_create(&p.pages, f->gl, desc), VXS_OK);
    f->d.gl->CreateTextures(GL_TEXTURE_2D, 1, &p.depths);
    f->d.gl->TextureStorage2D(p.depths, 1, GL_R32F, WIDTH_PX, HEIGHT_PX);
    p.with_words = paged_program(f, p.pages, "");
    p.alone      = paged_program(f, p.pages, "#define VXS_PAGES_ALONE\n");
    return p;
}

static void paged_free(paged *p)
{
    vxs_gl_depth_pages_destroy(p->pages);
    p->f->d.gl->DeleteTextures(1, &p->depths);
}

static void answer_of(const paged *p, answer what, float *answers)
{
    const gl_context *gl      = p->f->d.gl;
    GLuint            program = what == BY_PAGES_ALONE ? p->alone : p->with_words;
    gl->UseProgram(program);
    vxs_gl_bind(p->f->gl);
    vxs_gl_depth_pages_bind(p->pages);
    gl->BindTextureUnit(5, p->depths);
    gl->ProgramUniform1i(program, gl->GetUniformLocation(program, "vxs_depths"), 5);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "vxs_point_from_depth"), 1, GL_FALSE,
                                p->view.view.point_from_depth);
    gl->ProgramUniform4f(program, gl->GetUniformLocation(program, "vxs_sizes"), WIDTH_PX, HEIGHT_PX, p->view.view.empty_depth, 0);
    gl->ProgramUniform4i(program, gl->GetUniformLocation(program, "asked"), (GLint)p->light, (GLint)filter_code(p->filter),
                         what == BY_PAGES_ALONE ? BY_PAGES : what, (GLint)p->level);
    gl->ProgramUniform3f(program, gl->GetUniformLocation(program, "normal"), p->normal[0], p->normal[1], p->normal[2]);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->ReadPixels(0, 0, WIDTH_PX, HEIGHT_PX, GL_RED, GL_FLOAT, answers);
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

/* Ends as a frame ends: zink of Mesa 22.3 runs the second of two dispatches of a program with the buffers of the first, if nothing is
 * flushed between them. */
static void mark(paged *p)
{
    assert_int_equal(vxs_gl_depth_pages_mark(p->pages, &p->view, p->depths), VXS_OK);
    p->f->d.gl->Flush();
}

/* Mark a view, and decode all that it needs. Returns the updates that it took. */
static uint32_t fill(paged *p, uint32_t max_pages)
{
    uint32_t rounds = 0, missing;
    mark(p);
    do {
        mark(p);
        missing = vxs_gl_depth_pages_update(p->pages, max_pages);
        assert_true(++rounds < 1000);
    } while (missing);
    return rounds;
}

/* Lit part of the taps around a place of a level, counted in a depth map of that level. */
static double count_taps(const uint32_t *depths, int32_t side, vxs_filter filter, int32_t x, int32_t y, int32_t k, uint32_t part)
{
    int32_t  width = filter.width_px, half = width / 2;
    uint64_t lit = 0, all = 0;
    for (int32_t v = y - half - 1; v <= y + half + 1; v++)
        for (int32_t u = x - half - 1; u <= x + half + 1; u++) {
            /* in 1/256 texel, the box begins at 256 x + across - 128 width */
            int32_t across = (int32_t)(part & 255), down = (int32_t)(part >> 8), first[2], weight[2];
            int32_t begin[2] = {256 * x + across - 128 * width, 256 * y + down - 128 * width}, texel[2] = {u, v};
            for (int n = 0; n < 2; n++) {
                if (!filter.is_smooth) begin[n] = 256 * ((n ? y : x) - half);
                first[n]  = 256 * texel[n];
                int32_t a = first[n] > begin[n] ? first[n] : begin[n], b = first[n] + 256, end = begin[n] + 256 * width;
                b         = b < end ? b : end;
                weight[n] = b > a ? b - a : 0;
            }
            uint64_t area    = (uint64_t)weight[0] * (uint64_t)weight[1];
            int      outside = u < 0 || v < 0 || u >= side || v >= side;
            all += area;
            lit += outside || (uint32_t)k < depths[(size_t)v * (size_t)side + (size_t)u] ? area : 0;
        }
    return (double)lit / (double)all;
}

/* Where shadow begins in a map of a level.   Returns [side][side] depths, to be freed */
static uint32_t *depths_of_level(const vxs_baked_light *baked, int map, uint32_t level)
{
    size_t             side = (size_t)1 << (baked->light.levels - level);
    vxs_depth_map_desc desc = {
        .struct_size = sizeof desc, .map = map, .wide_px = (uint32_t)side, .high_px = (uint32_t)side, .shift = level};
    desc.voxels = malloc(side * side * sizeof *desc.voxels);
    assert_int_equal(vxs_depth_map(baked, &desc, NULL), VXS_OK);
    for (size_t t = 0; t < side * side; t++) desc.voxels[t] >>= level;
    return desc.voxels;
}

/* Answers against taps that are counted one by one.   Returns how many are neither lit nor dark */
static uint32_t check_counted(const paged *p, const float *lit)
{
    static float           told[ANSWERS][QUERIES];
    const vxs_baked_light *baked  = vxs_asset_light(p->f->s.full, p->light);
    uint32_t               levels = baked->light.levels, partly = 0, *maps[6][VXS_LEVELS_MAX] = {{0}};
    for (answer what = LEVEL; what < ANSWERS; what++) answer_of(p, what, told[what]);
    for (int n = 0; n < QUERIES; n += 4) {
        int map = (int)told[MAP][n], k = (int)told[DEPTH][n], level = (int)told[LEVEL][n], side = 1 << (levels - (uint32_t)level);
        double wanted = map < 0 ? (double)VXS_OUTSIDE : 1;
        if (told[MAP][n] < -2) continue; /* nothing is seen there */
        if (map >= 0 && k >= 0) {
            uint32_t **depths = &maps[map][level];
            if (!*depths) *depths = depths_of_level(baked, map, (uint32_t)level);
            wanted = count_taps(*depths, side, p->filter, (int)told[ACROSS][n], (int)told[DOWN][n], k < side ? k : side - 1,
                                (uint32_t)told[PART][n]);
        }
        if (!(fabs((double)lit[n] - wanted) <= 1e-6))
            fail_msg("light %u, filter %d %d, level %d, map %d, voxel %g %g %d: %.9g, expected %.9g", p->light, p->filter.width_px,
                     p->filter.is_smooth, level, map, (double)told[ACROSS][n], (double)told[DOWN][n], k, (double)lit[n], wanted);
        partly += wanted > 0 && wanted < 1;
    }
    for (uint32_t n = 0; n < 6 * VXS_LEVELS_MAX; n++) free(maps[n / VXS_LEVELS_MAX][n % VXS_LEVELS_MAX]);
    return partly;
}

static uint32_t differences(const float *a, const float *b)
{
    uint32_t count = 0;
    for (int n = 0; n < QUERIES; n++) count += !(fabsf(a[n] - b[n]) <= (gl_choice() == GL_BACKEND_EGL ? 0x1p-22F : 0));
    return count;
}

enum { FILTERS = 4 };

/* Filters, in a view: by words alone, by counting, by pages, and by pages alone. The border of pages is
 * 6 texels, so that boxes of more than 13 texels are answered by words.   Returns how many answers are neither lit nor dark */
static uint32_t check_view(paged *p, const vxs_filter filters[FILTERS])
{
    static float by_words[FILTERS][QUERIES], plain[QUERIES];
    uint32_t     partly = 0;
    vxs_gl_depth_pages_forget(p->pages);
    assert_int_equal(vxs_gl_depth_pages_held(p->pages), 0);
    mark(p); /* the eye */
    for (int n = 0; n < FILTERS; n++) {
        p->filter = filters[n];
        answer_of(p, BY_PAGES, by_words[n]);
        partly += check_counted(p, by_words[n]);
        answer_of(p, BY_WORDS, plain);
        if (p->view.px_width == 0) assert_int_equal(differences(by_words[n], plain), 0);
    }
    fill(p, 23);
    assert_true(vxs_gl_depth_pages_held(p->pages) > 0);
    for (int n = 0; n < FILTERS; n++) {
        p->filter = filters[n];
        answer_of(p, BY_PAGES, plain);
        assert_int_equal(differences(by_words[n], plain), 0);
        answer_of(p, BY_PAGES_ALONE, plain);
        assert_true((differences(by_words[n], plain) > 0) == (filters[n].width_px + filters[n].is_smooth > 13));
    }
    for (int k = 0; k < 3; k++) p->normal[k] = (float)uniform(&p->f->r, -1, 1);
    p->filter = filters[rng_below(&p->f->r, FILTERS)];
    answer_of(p, BY_PAGES, plain);
    check_counted(p, plain);
    memset(p->normal, 0, sizeof p->normal);
    return partly;
}

/* Kinds of lights, and levels.   most_table_bytes  as for frame_make */
static void check_pages(uint64_t most_table_bytes)
{
    static const vxs_filter filters[2][FILTERS] = {{{9, 0}, {9, 1}, {13, 0}, {17, 1}}, {{1, 0}, {3, 0}, {6, 1}, {1, 1}}};
    frame                   f                   = frame_make(most_table_bytes);
    uint32_t                rounds = repeats(1, 12), partly = 0;
    paged                   p = paged_make(&f, &(vxs_gl_depth_pages_desc){.unit = 4});
    for (uint32_t round = 0; round < rounds; round++)
        for (uint32_t light = 0; light <= SPOT; light++) {
            look_at_sample(&p, light);
            p.view.px_width = (light + round) & 1 ? 0 : (float)uniform(&f.r, 0.03, light == SUN ? 0.2 : 0.1);
            partly += check_view(&p, filters[(light / 2 + round) & 1]);
        }
    assert_true(partly > rounds * QUERIES / 4);
    paged_free(&p);
    frame_free(&f);
}

static void test_pages(void **state)
{
    (void)state;
    check_pages(0);
}

static void test_pages_of_words(void **state)
{
    (void)state;
    check_pages(1);
}

/* Levels by the words alone, up to maps of eight texels: more than views of the sample have. */
static void test_levels_of_words(void **state)
{
    static const vxs_filter filters[] = {{9, 0}, {9, 1}, {1, 0}};
    static float            lit[QUERIES];
    (void)state;
    for (uint64_t most_table_bytes = 0; most_table_bytes < 2; most_table_bytes++) {
        frame    f      = frame_make(most_table_bytes);
        paged    p      = paged_make(&f, NULL);
        uint32_t partly = 0;
        for (p.light = SUN; p.light <= SPOT; p.light++)
            for (p.level = 0; p.level <= 6; p.level++) {
                const vxs_baked_light *baked  = vxs_asset_light(f.s.full, p.light);
                int32_t                side   = 1 << (baked->light.levels - p.level);
                uint32_t              *depths = depths_of_level(baked, 0, p.level);
                p.filter                      = filters[(p.light + p.level) % 3];
                answer_of(&p, OF_LEVEL, lit);
                for (int32_t n = 0; n < QUERIES; n++) {
                    int32_t  x = n % WIDTH_PX, y = n / WIDTH_PX;
                    uint32_t part   = ((uint32_t)x * 5 & 255) | ((uint32_t)y * 9 & 255) << 8;
                    double   wanted = count_taps(depths, side, p.filter, x, y, (x + y + 1) % side, part);
                    if (!(fabs((double)lit[n] - wanted) <= 1e-6))
                        fail_msg("light %u, level %u, %d %d: %.9g, expected %.9g", p.light, p.level, x, y, (double)lit[n], wanted);
                    partly += wanted > 0 && wanted < 1;
                }
                free(depths);
            }
        assert_true(partly > QUERIES / 4);
        paged_free(&p);
        frame_free(&f);
    }
}

/* An atlas that is too small for any view: pages come and go, and answers stay. */
static void test_small_atlas(void **state)
{
    static float by_pages[QUERIES], plain[QUERIES];
    frame        f = frame_make(0);
    paged        p = paged_make(&f, &(vxs_gl_depth_pages_desc){.budget_bytes = 1900000, .filter = {3, 0}, .binding = 6, .unit = 1});
    uint32_t     room = vxs_gl_depth_pages_room(p.pages), left = 0, most = 0;
    (void)state;
    assert_int_equal(room, 4);
    p.filter = vxs_box(3);
    for (uint32_t round = 0; round < repeats(16, 200); round++) {
        if (round % 4 == 0) look_at_sample(&p, rng_below(&f.r, 3));
        mark(&p);
        uint32_t missing = vxs_gl_depth_pages_update(p.pages, rng_below(&f.r, 4));
        left += missing != 0;
        most = vxs_gl_depth_pages_held(p.pages) > most ? vxs_gl_depth_pages_held(p.pages) : most;
        answer_of(&p, BY_PAGES, by_pages);
        answer_of(&p, BY_WORDS, plain);
        assert_int_equal(differences(by_pages, plain), 0);
    }
    assert_int_equal(most, room);
    assert_true(left > 4);
    paged_free(&p);
    frame_free(&f);
}

/* A map with more pages than a level of the page table has places: squares of 256 x 256 texels of one depth each. */
static void test_large_map(void **state)
{
    enum { LEVELS = 14, TOP = 8, ENTRIES = 64 * 64 };
    static float    by_pages[QUERIES], plain[QUERIES];
    static uint32_t words[TOP + 2 * ENTRIES + 4];
    frame           f   = frame_make(0);
    vxs_light       sun = {
              .kind = VXS_LIGHT_KIND_DIRECTIONAL, .coding = VXS_CODING_BLOCKS, .levels = LEVELS, .texel_metres = 1, .voxel_metres = 1};
    (void)state;
    for (int n = 0; n < 3; n++) sun.ls_from_ws[5 * n] = 1;
    words[1] = TOP + 2 * ENTRIES;
    words[2] = TOP;
    for (int n = 0; n < ENTRIES; n++) words[TOP + 2 * n] = 0x80000000u | rng_below(&f.r, 1 << LEVELS);
    vxs_baked_light        baked = {.light = sun, .words = words, .word_count = TOP + 2 * ENTRIES};
    const vxs_baked_light *list  = &baked;
    vxs_gl_destroy(f.gl);
    vxs_gl_desc desc = {
        .struct_size = sizeof desc, .get_proc_address = gl_choice_proc, .storage = VXS_GL_BUFFER, .baked = &list, .light_count = 1};
    assert_int_equal(vxs_gl_create(&f.gl, &desc), VXS_OK);
    assert_int_equal(vxs_gl_upload(f.gl, SIZE_MAX), 0);
    paged p  = paged_make(&f, &(vxs_gl_depth_pages_desc){.unit = 4});
    p.filter = vxs_box(9);
    for (int n = 0; n < 3; n++) {
        look_at(&p, &sun);
        p.view.view.point_from_depth[5]  = 200; /* two rows of 128 pages, each of which has a twin 64 pages beside it */
        p.view.view.point_from_depth[13] = 0;
        mark(&p);
        mark(&p);
        assert_true(vxs_gl_depth_pages_update(p.pages, 400) > 0);
        answer_of(&p, BY_PAGES, by_pages);
        answer_of(&p, BY_WORDS, plain);
        assert_int_equal(differences(by_pages, plain), 0);
    }
    assert_true(vxs_gl_depth_pages_held(p.pages) > 100);
    paged_free(&p);
    frame_free(&f);
}

/* Pages that are decoded while words are missing give the coarse answer, and the full one once the words are there. */
static void test_stream(void **state)
{
    static float    coarse[QUERIES], full[QUERIES], plain[QUERIES];
    frame           f = frame_make(0);
    vxs_stream     *stream;
    vxs_stream_desc asked = stream_desc_of(&f.s, 64 << 20);
    (void)state;
    vxs_gl_destroy(f.gl);
    assert_int_equal(vxs_stream_open(&stream, &asked), VXS_OK);
    vxs_gl_desc desc = {.struct_size = sizeof desc, .get_proc_address = gl_choice_proc, .storage = VXS_GL_BUFFER, .stream = stream};
    assert_int_equal(vxs_gl_create(&f.gl, &desc), VXS_OK);
    assert_int_equal(vxs_gl_upload(f.gl, SIZE_MAX), 0);
    paged p  = paged_make(&f, &(vxs_gl_depth_pages_desc){.unit = 4});
    p.filter = vxs_box(9);
    look_at_sample(&p, SUN);
    for (int n = 0; n < 3; n++) {
        mark(&p);
        vxs_gl_depth_pages_update(p.pages, 1000);
    }
    assert_true(vxs_gl_depth_pages_held(p.pages) > 10);
    answer_of(&p, BY_PAGES, coarse);
    answer_of(&p, BY_WORDS, plain);
    assert_int_equal(differences(coarse, plain), 0);
    stream_fill(stream, &stream_all);
    assert_int_equal(vxs_gl_upload(f.gl, SIZE_MAX), 0);
    fill(&p, 1000);
    answer_of(&p, BY_PAGES, full);
    answer_of(&p, BY_WORDS, plain);
    assert_int_equal(differences(full, plain), 0);
    assert_true(differences(full, coarse) > QUERIES / 10);
    check_counted(&p, full);
    paged_free(&p);
    vxs_stream_close(stream);
    frame_free(&f);
}

/* By lists of lights: those alone are marked. */
static void test_lists(void **state)
{
    frame f = frame_make(0);
    paged p = paged_make(&f, &(vxs_gl_depth_pages_desc){.unit = 4});
    (void)state;
    look_at_sample(&p, LAMP);
    p.view.view.filter = vxs_box(1);
    fill(&p, 1000);
    uint32_t all = vxs_gl_depth_pages_held(p.pages);
    vxs_gl_depth_pages_forget(p.pages);
    p.view.by_lists = 1;
    assert_int_equal(vxs_gl_cull(f.gl, &p.view.view, p.depths, 8), VXS_OK);
    fill(&p, 1000);
    assert_int_equal(vxs_gl_depth_pages_held(p.pages), all);
    vxs_gl_depth_pages_forget(p.pages);
    vxs_view empty             = p.view.view; /* of which no pixel has a light */
    empty.empty_depth          = 2;
    empty.point_from_depth[15] = 0;
    assert_int_equal(vxs_gl_cull(f.gl, &empty, p.depths, 8), VXS_OK);
    for (int n = 0; n < 3; n++) {
        mark(&p);
        assert_int_equal(vxs_gl_depth_pages_update(p.pages, 1000), 0);
    }
    assert_int_equal(vxs_gl_depth_pages_held(p.pages), 0);
    paged_free(&p);
    frame_free(&f);
}

/* The state of the context, before and after. */
static void test_state(void **state)
{
    static const GLenum what[] = {
        GL_CURRENT_PROGRAM,   GL_ACTIVE_TEXTURE,   GL_TEXTURE_BINDING_2D,      GL_SAMPLER_BINDING, GL_PIXEL_UNPACK_BUFFER_BINDING,
        GL_UNPACK_ROW_LENGTH, GL_UNPACK_ALIGNMENT, GL_DRAW_FRAMEBUFFER_BINDING};
    void(APIENTRY * get)(GLenum, GLint *) = (void(APIENTRY *)(GLenum, GLint *))gl_choice_function("glGetIntegerv");
    void(APIENTRY * active)(GLenum)       = (void(APIENTRY *)(GLenum))gl_choice_function("glActiveTexture");
    PFNGLGENSAMPLERSPROC gen              = (PFNGLGENSAMPLERSPROC)gl_choice_function("glGenSamplers");
    PFNGLBINDSAMPLERPROC bind             = (PFNGLBINDSAMPLERPROC)gl_choice_function("glBindSampler");
    frame                f                = frame_make(0);
    paged                p                = paged_make(&f, &(vxs_gl_depth_pages_desc){.unit = 4});
    GLint                before[8], after[8];
    GLuint               sampler, texture, buffer;
    (void)state;
    look_at_sample(&p, SUN);
    gen(1, &sampler);
    bind(0, sampler);
    f.d.gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    f.d.gl->BindTextureUnit(0, texture);
    f.d.gl->GenBuffers(1, &buffer);
    f.d.gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer);
    f.d.gl->PixelStorei(GL_UNPACK_ROW_LENGTH, 77);
    f.d.gl->PixelStorei(GL_UNPACK_ALIGNMENT, 8);
    active(GL_TEXTURE0);
    for (int n = 0; n < 8; n++) get(what[n], &before[n]);
    for (int n = 0; n < 3; n++) {
        mark(&p);
        vxs_gl_depth_pages_update(p.pages, 20);
    }
    for (int n = 0; n < 8; n++) {
        get(what[n], &after[n]);
        assert_int_equal(after[n], before[n]);
    }
    f.d.gl->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    assert_int_equal(vxs_gl_depth_pages_held(p.pages) > 0, 1);
    paged_free(&p);
    frame_free(&f);
}

static void test_refused(void **state)
{
    frame               f = frame_make(0);
    vxs_gl_depth_pages *pages;
    (void)state;
    assert_int_equal(vxs_gl_depth_pages_create(&pages, f.gl, &(vxs_gl_depth_pages_desc){.budget_bytes = 50000}), VXS_E_ARGUMENT);
    assert_non_null(strstr(last_line, "budget_bytes"));
    assert_int_equal(vxs_gl_depth_pages_create(&pages, f.gl, &(vxs_gl_depth_pages_desc){.struct_size = 4}), VXS_E_ARGUMENT);
    assert_null(pages);
    vxs_gl_destroy(f.gl);
    vxs_gl_desc desc = {.get_proc_address = gl_choice_proc, .asset = f.s.full, .storage = VXS_GL_TEXTURE};
    assert_int_equal(vxs_gl_create(&f.gl, &desc), VXS_OK);
    assert_int_equal(vxs_gl_depth_pages_create(&pages, f.gl, &(vxs_gl_depth_pages_desc){0}), VXS_E_GL);
    for (uint64_t fail_at = 1, good = 0; !good; fail_at++) {
        alloc_fail    a      = {.fail_at = fail_at};
        vxs_allocator memory = alloc_fail_allocator(&a);
        vxs_gl       *gl;
        desc.storage          = VXS_GL_BUFFER;
        desc.most_table_bytes = 1;
        desc.allocator        = &memory;
        vxs_result r          = vxs_gl_create(&gl, &desc);
        if (r == VXS_OK) r = vxs_gl_depth_pages_create(&pages, gl, &(vxs_gl_depth_pages_desc){.budget_bytes = 4 << 20});
        assert_int_equal(r, a.calls >= fail_at ? VXS_E_MEMORY : VXS_OK);
        good = r == VXS_OK;
        if (good) vxs_gl_depth_pages_destroy(pages);
        vxs_gl_destroy(gl);
        assert_true(a.live_bytes == 0 && a.wrong_sizes == 0 && fail_at < 40);
    }
    frame_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_textures),        cmocka_unit_test(test_pages),       cmocka_unit_test(test_pages_of_words),
        cmocka_unit_test(test_levels_of_words), cmocka_unit_test(test_small_atlas), cmocka_unit_test(test_large_map),
        cmocka_unit_test(test_stream),          cmocka_unit_test(test_lists),       cmocka_unit_test(test_state),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
