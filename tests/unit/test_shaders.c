/* The shaders of tests/shaders/, and others on the same headers, run by OpenGL and held against C: from integer voxels bit for bit,
 * from positions but for where float rounding decides between two voxels. A query is a point that is drawn into a pixel of its own,
 * so that versions without compute shaders are queried the same way.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <stdio.h>

#include "blocks_sample.h"
#include "dag_sample.h"
#include "formats/vxs_lookup.h"
#include "formats/vxs_lookup_blocks.h"
#include "random_light.h"
#include "runtime/vxs.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_points.h"

enum { WORDS_WIDE = 2048, FIRST_WORD = 5 };

static const char *const dialects[] = {"lit_430.frag", "lit_330.frag", "lit_310es.frag", "lit_300es.frag"};
enum { DIALECTS = sizeof dialects / sizeof *dialects };

/* text ------------------------------------------------------------------------------------------------------------------------- */

static char *read_text(const char *folder, const char *name)
{
    char path[64], *text = dag_sample_alloc(1, 1 << 16);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    if (!file) {
        print_message("%s is not here: start this test in the root of the repository\n", path);
        skip();
    }
    size_t size = fread(text, 1, (1 << 16) - 1, file);
    assert_true(size > 0 && size < (1 << 16) - 1);
    fclose(file);
    return text;
}

/* Cut a text at a line, which is left out; returns what follows. */
static char *cut(char *text, const char *line)
{
    char *at = strstr(text, line);
    assert_non_null(at);
    *at = 0;
    return at + strlen(line);
}

/* A shader of tests/shaders with the texts that it includes.
 * body    NULL, or what takes the place of its own
 * filter  in the place of its vxs_box(9) */
static void use_program(drawing *d, const char *dialect, const char *body, const char *filter)
{
    char *version = read_text("tests/shaders", dialect);
    char *head = read_text("tests/shaders", dialect), *rest = cut(head, "#include \"vxs_lookup.h\"\n");
    char *own    = cut(cut(rest, "#include \"vxs_lookup_blocks.h\"\n"), "#include \"vxs_space.h\"\n"),
         *end    = cut(own, "normal_ws, vxs_box(9));");
    char *lookup = read_text("formats", "vxs_lookup.h"), *blocks = read_text("formats", "vxs_lookup_blocks.h");
    char *space = read_text("formats", "vxs_space.h");

    const char *all[9] = {head, lookup, blocks, space, own, "normal_ws, ", filter, ");", end};
    if (body) all[4] = body;
    cut(version, "\n");
    use_texts(d, dialect, version, all, body ? 5 : 9);
    free(version);
    free(head);
    free(lookup);
    free(blocks);
    free(space);
}

/* The words of a light. */
typedef struct light_words {
    const uint32_t *words;
    size_t          count;
} light_words;

static light_words words_of(const vxs_baked_light *light)
{
    return (light_words){light->words, light->word_count};
}

/* The words of several lights behind each other, as a storage buffer and as a texture.
 * first  [out] [count] where each light's begin */
static void put_words(drawing *d, const light_words *lights, uint32_t count, uint32_t *first)
{
    uint32_t total = FIRST_WORD;
    for (uint32_t n = 0; n < count; n++) {
        first[n] = total;
        total += (uint32_t)lights[n].count;
    }
    uint32_t  rows  = total / WORDS_WIDE + 1;
    uint32_t *words = dag_sample_alloc((size_t)rows * WORDS_WIDE, sizeof *words);
    for (uint32_t n = 0; n < count; n++) memcpy(words + first[n], lights[n].words, lights[n].count * sizeof *words);
    bind_buffer(d, GL_SHADER_STORAGE_BUFFER, total * sizeof *words, words);
    if (d->words_texture) d->gl->DeleteTextures(1, &d->words_texture);
    d->gl->CreateTextures(GL_TEXTURE_2D, 1, &d->words_texture);
    d->gl->TextureStorage2D(d->words_texture, 1, GL_R32UI, WORDS_WIDE, (GLsizei)rows);
    d->gl->TextureSubImage2D(d->words_texture, 0, 0, 0, WORDS_WIDE, (GLsizei)rows, GL_RED_INTEGER, GL_UNSIGNED_INT, words);
    d->gl->TextureParameteri(d->words_texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    d->gl->TextureParameteri(d->words_texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    d->gl->BindTextureUnit(0, d->words_texture);
    free(words);
}

/* subjects --------------------------------------------------------------------------------------------------------------------- */

static vxs_asset *open_light(const vxs_write_light *light)
{
    vxs_write_desc desc = {.lights = light, .light_count = 1, .zstd_level = 1};
    vxs_bytes      file = {0};
    vxs_asset     *asset;
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    return asset;
}

typedef enum light_kind { SUN, BOUNDED_SUN, PUNCTUAL_FIRST, KINDS = PUNCTUAL_FIRST + PUNCTUAL_SHAPES } light_kind;

/* A light of a sample, turned at random and about `at`, which is the place of a punctual light and the middle of a sun's map. */
static vxs_write_light turned_light(rng *r, const dag_sample *s, light_kind kind, const double at[3])
{
    punctual        of = random_punctual(r, kind < PUNCTUAL_FIRST ? POINT : (punctual_shape)(kind - PUNCTUAL_FIRST));
    vxs_write_light light =
        kind < PUNCTUAL_FIRST ? dag_sample_light(s, "sun") : dag_sample_punctual(s, "lamp", of.light.kind, of.light.flags);
    if (kind == BOUNDED_SUN) light.light.flags = VXS_LIGHT_BOUNDED;
    for (int row = 0; row < 3; row++) {
        double *m = light.light.ls_from_ws + 4 * row, scale = kind >= PUNCTUAL_FIRST ? 1
                                                              : row < 2              ? 1 / light.light.texel_metres
                                                                                     : 1;
        for (int n = 0; n < 3; n++) m[n] = of.axis[row][n] * scale;
        m[3] = (kind < PUNCTUAL_FIRST ? ldexp(0.5, (int)s->levels) : 0) - dot(m, at);
    }
    memcpy(light.light.direction_ws, of.axis[2], sizeof of.axis[2]);
    return light;
}

/* How far a number is from where rounding to whole ones decides. */
static double clear_of_whole(double x)
{
    return fabs(x - rint(x));
}

static double clear_of_step(double step)
{
    return fabs(step) < 1e-9 ? 1 : clear_of_whole(step);
}

static int clamped_width(vxs_filter filter)
{
    return filter.width_px < 1 ? 1 : filter.width_px < VXS_FILTER_MAX ? filter.width_px : VXS_FILTER_MAX;
}

/* How far a point is from where rounding decides: a voxel's side, an edge of cone, range or cube, a step that is whole. */
static double clear_by(const vxs_light *l, const double *point, const double *normal, vxs_filter filter)
{
    double ls[3], n[3], by = 1, size[3], half = 0.5 * (clamped_width(filter) | 1);
    for (int row = 0; row < 3; row++) {
        const double *m = l->ls_from_ws + 4 * row;
        n[row]          = dot(m, normal);
        ls[row]         = dot(m, point) + m[3];
        size[row]       = fabs(ls[row]);
    }
    if (l->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        for (int c = 0; c < 3; c++) by = fmin(by, fmin(clear_of_whole(ls[c]), clear_of_step(n[c] * l->texel_metres * half)));
        return by;
    }
    double metres = sqrt(dot(ls, ls)), side = ldexp(1, (int)l->levels);
    if (l->kind == VXS_LIGHT_KIND_SPOT) by = fmin(by, 100 * fabs(ls[2] / metres - l->cos_outer));
    if (l->range_metres > 0) by = fmin(by, 100 * fabs(metres / l->range_metres - 1));
    int along = l->flags & VXS_LIGHT_CUBE ? size[1] > size[0] ? 1 : 0 : 2;
    if (size[2] > size[along]) along = 2;
    for (int c = 0; c < 3; c++) {
        if (c == along) continue;
        double slope = ls[c] / ls[along], step = half * (n[c] - n[along] * slope);
        if (l->flags & VXS_LIGHT_CUBE) by = fmin(by, 100 * fabs(size[c] / size[along] - 1));
        by = fmin(by, fmin(clear_of_whole(side / 2 + slope / l->texel_metres), clear_of_step(step)));
    }
    double depth = log(size[along] / l->near_metres) / l->voxel_metres;
    return fmin(by, fmin(clear_of_whole(depth), clear_of_step(half * n[along] * l->texel_metres / l->voxel_metres)));
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* A texel near what may go wrong: the corners and sides of the map, just outside and far outside. */
static float tricky_texel(rng *r, int32_t side)
{
    switch (rng_below(r, 8)) {
    case 0: return (float)rng_between(r, -12, 12);
    case 1: return (float)(side + rng_between(r, -12, 12));
    case 2: return (float)(8 * rng_between(r, 0, side / 8) + rng_between(r, -1, 1));
    case 3: return ldexpf(rng_below(r, 2) ? 1 : -1, rng_between(r, 8, 30));
    default: return (float)rng_between(r, 0, side - 1);
    }
}

static int32_t held(int32_t x, int32_t last)
{
    return x < 0 ? 0 : x < last ? x : last;
}

/* A sum of a smooth box has more bits than a float; a remainder by this has not, and distinguishes sums that do not differ by all
 * of it. */
#define SUM_MODULUS 16777213u

enum { SMOOTH = 256 }; /* added to the width of a smooth filter */

/* A random filter, and of a smooth one where in the texel it is about: the texts of all shaders take both from numbers that have
 * room.
 * y  levels and more, below 256: across, times 256, is added;   z  [out] the filter, and down times 512 */
static void add_filter(rng *r, float *y, float *z)
{
    int smooth = (int)rng_below(r, 2);
    *y += smooth ? (float)(256 * rng_below(r, 256)) : 0;
    *z = (float)(smooth ? SMOOTH + rng_between(r, 1, VXS_FILTER_MAX) + 512 * rng_between(r, 0, 255)
                        : 1 + 2 * rng_between(r, 0, VXS_FILTER_MAX / 2));
}

/* Position: texels and depth; normal: the word of the light, its levels, the filter (add_filter). */
static const char voxel_body[] =
    "in vec3 position_ws;\n"
    "in vec3 normal_ws;\n"
    "out float answer;\n"
    "void main() {\n"
    "    uint dag = uint(normal_ws.x), levels = uint(normal_ws.y) & 31u, last = (1u << levels) - 1u;\n"
    "    uint across = uint(normal_ws.y) >> 8, down = uint(normal_ws.z) >> 9;\n"
    "    int wide = int(normal_ws.z) & 511;\n"
    "    int i = int(position_ws.x), j = int(position_ws.y);\n"
    "    uint k = uint(position_ws.z), x = min(uint(max(i, 0)), last), y = min(uint(max(j, 0)), last);\n"
    "    if (wide < 256)\n"
    "        answer = float(2u * vxs_shadow_count(dag, 0u, levels, i, j, k, wide) + vxs_shadow(dag, 0u, levels, x, y, k));\n"
    "    else\n"
    "        answer = float(vxs_shadow_weight(dag, 0u, levels, i, j, across, down, k, wide - 256) % 16777213u);\n"
    "}\n";

/* The same in C. */
static float voxel_answer(const uint32_t *words, const query *q)
{
    uint32_t y = (uint32_t)q->normal[1], z = (uint32_t)q->normal[2], levels = y & 31, k = (uint32_t)q->position[2];
    int32_t  last = (1 << levels) - 1, i = (int32_t)q->position[0], j = (int32_t)q->position[1], wide = (int32_t)(z & 511);
    if (wide >= SMOOTH) return (float)(vxs_shadow_weight(words, 0, levels, i, j, y >> 8, z >> 9, k, wide - SMOOTH) % SUM_MODULUS);
    uint32_t tap = vxs_shadow(words, 0, levels, (uint32_t)held(i, last), (uint32_t)held(j, last), k);
    return (float)(2 * vxs_shadow_count(words, 0, levels, i, j, k, wide) + tap);
}

static void test_voxels(void **state)
{
    static query           queries[QUERIES];
    static float           answers[QUERIES];
    dag_sample             samples[3];
    vxs_asset             *assets[3];
    const vxs_baked_light *lights[3];
    light_words            words_of_all[3];
    uint32_t               first[3];
    drawing                d = drawing_make();
    rng                    r = {9};
    (void)state;
    for (uint32_t n = 0; n < 3; n++) {
        dag_sample_init(&samples[n], &(rng){31 + n}, (uint32_t[]){3, 6, 8}[n], 12 + 150 * n);
        vxs_write_light light = dag_sample_light(&samples[n], "sun");
        assets[n]             = open_light(&light);
        lights[n]             = vxs_asset_light(assets[n], 0);
        words_of_all[n]       = words_of(lights[n]);
    }
    put_words(&d, words_of_all, 3, first);
    for (uint32_t n = 0; n < QUERIES; n++) {
        uint32_t levels = samples[n % 3].levels;
        int32_t  side   = 1 << levels;
        queries[n]      = (query){{tricky_texel(&r, side), tricky_texel(&r, side), (float)rng_below(&r, 1u << levels)},
                                  {(float)first[n % 3], (float)levels, 0}};
        add_filter(&r, &queries[n].normal[1], &queries[n].normal[2]);
    }
    for (int dialect = 0; dialect < DIALECTS; dialect++) {
        use_program(&d, dialects[dialect], voxel_body, NULL);
        draw(&d, queries, answers);
        for (uint32_t n = 0; n < QUERIES; n++)
            if (answers[n] != voxel_answer(lights[n % 3]->words, &queries[n]))
                fail_msg("%s, query %u: %g", dialects[dialect], n, (double)answers[n]);
    }
    gl_context_destroy(d.gl);
    for (int n = 0; n < 3; n++) {
        vxs_asset_close(assets[n]);
        dag_sample_free(&samples[n]);
    }
}

/* As voxel_body; the number of the map is added to the levels, 32 for each. */
static const char blocks_body[] =
    "in vec3 position_ws;\n"
    "in vec3 normal_ws;\n"
    "out float answer;\n"
    "void main() {\n"
    "    uint light = uint(normal_ws.x), levels = uint(normal_ws.y) & 31u, map = (uint(normal_ws.y) >> 5) & 7u, last = (1u << "
    "levels) - 1u;\n"
    "    uint across = uint(normal_ws.y) >> 8, down = uint(normal_ws.z) >> 9;\n"
    "    int wide = int(normal_ws.z) & 511;\n"
    "    int i = int(position_ws.x), j = int(position_ws.y);\n"
    "    uint k = uint(position_ws.z), x = min(uint(max(i, 0)), last), y = min(uint(max(j, 0)), last);\n"
    "    if (wide < 256)\n"
    "        answer = float(4u * vxs_blocks_shadow_count(light, map, levels, i, j, k, wide) + 2u * vxs_blocks_shadow(light, map, "
    "levels, x, y, k) + vxs_blocks_is_full(light, map, levels, i, j, k, wide));\n"
    "    else\n"
    "        answer = float(vxs_blocks_shadow_weight(light, map, levels, i, j, across, down, k, wide - 256) % 16777213u);\n"
    "}\n";

/* The same in C.
 * partly, coarse  [in, out] counts boxes that are neither lit nor dark, and those that need a page that is missing */
static float blocks_answer(const blocks_sample *s, const query *q, uint32_t *partly, uint32_t *coarse)
{
    uint32_t y = (uint32_t)q->normal[1], z = (uint32_t)q->normal[2], k = (uint32_t)q->position[2], map = (y >> 5) & 7;
    int32_t  last = (1 << s->levels) - 1, i = (int32_t)q->position[0], j = (int32_t)q->position[1], wide = (int32_t)(z & 511);
    if (wide >= SMOOTH) {
        uint32_t width = (uint32_t)wide - SMOOTH;
        uint32_t dark  = vxs_blocks_shadow_weight(s->words, map, s->levels, i, j, y >> 8, z >> 9, k, (int32_t)width);
        *partly += dark > 0 && dark < 65536 * width * width;
        return (float)(dark % SUM_MODULUS);
    }
    uint32_t dark = vxs_blocks_shadow_count(s->words, map, s->levels, i, j, k, wide);
    uint32_t tap  = vxs_blocks_shadow(s->words, map, s->levels, (uint32_t)held(i, last), (uint32_t)held(j, last), k);
    *partly += dark > 0 && dark < (uint32_t)(wide * wide);
    uint32_t full = vxs_blocks_is_full(s->words, map, s->levels, i, j, k, wide);
    *coarse += !full;
    return (float)(4 * dark + 2 * tap + full);
}

/* A texel of a sample of blocks near squares with depths of their own, or anywhere; a depth near the texel's, or any. */
static query blocks_query(rng *r, const blocks_sample *s, uint32_t first)
{
    int32_t  side = 1 << s->levels, last = side - 1, middle = s->levels > 8 && rng_below(r, 4);
    uint32_t map = rng_below(r, s->map_count);
    float    i   = middle ? (float)(side / 2 + rng_between(r, -280, 280)) : tricky_texel(r, side);
    float    j   = middle ? (float)(side / 2 + rng_between(r, -280, 280)) : tricky_texel(r, side);
    int32_t  k =
        blocks_sample_depth(s, map, (uint32_t)held((int32_t)i, last), (uint32_t)held((int32_t)j, last)) + rng_between(r, -2, 1);
    if (!rng_below(r, 4)) k = rng_between(r, 0, last);
    query q = {{i, j, (float)held(k, last)}, {(float)first, (float)(s->levels + 32 * map), 0}};
    add_filter(r, &q.normal[1], &q.normal[2]);
    return q;
}

static void test_blocks(void **state)
{
    enum { SAMPLES = 5 };
    static const uint32_t levels[SAMPLES] = {3, 6, 8, 10, 15}, maps[SAMPLES] = {2, 6, 1, 1, 1}, squares[SAMPLES] = {2, 6, 1, 12, 6};
    static query          queries[QUERIES];
    static float          answers[QUERIES];
    blocks_sample         samples[SAMPLES];
    light_words           lights[SAMPLES];
    uint32_t              first[SAMPLES], partly = 0, coarse = 0;
    drawing               d = drawing_make();
    rng                   r = {10};
    (void)state;
    for (uint32_t n = 0; n < SAMPLES; n++) {
        blocks_sample_init(&samples[n], &r, levels[n], maps[n], squares[n]);
        for (uint32_t page = 0; page < samples[n].page_count && levels[n] == 10; page += 2)
            samples[n].words[8 + page] = 0; /* pages that are not there */
        lights[n] = (light_words){samples[n].words, samples[n].word_count + BLOCKS_SPARE_WORDS};
    }
    put_words(&d, lights, SAMPLES, first);
    for (uint32_t n = 0; n < QUERIES; n++) queries[n] = blocks_query(&r, &samples[n % SAMPLES], first[n % SAMPLES]);
    for (int dialect = 0; dialect < DIALECTS; dialect++) {
        use_program(&d, dialects[dialect], blocks_body, NULL);
        draw(&d, queries, answers);
        for (uint32_t n = 0; n < QUERIES; n++)
            if (answers[n] != blocks_answer(&samples[n % SAMPLES], &queries[n], &partly, &coarse))
                fail_msg("%s, query %u: %g", dialects[dialect], n, (double)answers[n]);
    }
    assert_in_range(partly, DIALECTS * QUERIES / 10, DIALECTS * QUERIES);
    assert_in_range(coarse, DIALECTS * QUERIES / 1000, DIALECTS * QUERIES);
    gl_context_destroy(d.gl);
    for (int n = 0; n < SAMPLES; n++) blocks_sample_free(&samples[n]);
}

/* Positions and normals about a light, most of them in its volume. */
static void fill_queries(rng *r, const vxs_light *l, const double at[3], const double origin[3], query *queries)
{
    int    sun = l->kind == VXS_LIGHT_KIND_DIRECTIONAL, one_map = !sun && !(l->flags & VXS_LIGHT_CUBE);
    double side = ldexp(1, (int)l->levels);
    for (int n = 0; n < QUERIES; n++) {
        double way[3], normal[3], metres = sun ? side * uniform(r, 0, 0.6) : 0.4 * pow(25, uniform(r, 0, 1));
        random_direction(r, way);
        random_direction(r, normal);
        for (int k = 0; k < 3; k++) {
            double towards         = one_map ? 0.7 * metres * l->direction_ws[k] : 0;
            queries[n].position[k] = (float)(at[k] + metres * way[k] + towards - origin[k]);
            queries[n].normal[k]   = n % 3 ? (float)normal[k] : 0;
        }
    }
}

typedef struct tally {
    int asked, outside, partly;
} tally;

/* Of every `stride`-th query, from `from` on. */
static void check_every(const vxs_baked_light *baked, const double origin[3], const query *queries, vxs_filter filter, int from,
                        int stride, const float *answers, const char *dialect, tally *sum)
{
    for (int n = from; n < QUERIES; n += stride) {
        double point[3], normal[3];
        for (int k = 0; k < 3; k++) {
            point[k]  = origin[k] + (double)queries[n].position[k];
            normal[k] = (double)queries[n].normal[k];
        }
        if (clear_by(&baked->light, point, normal, filter) < 0.005) continue;
        /* of a smooth box, a part of a texel may be another 1/256, along both axes: its border counts as much more, or less */
        float wanted = vxs_lookup(baked, point, normal, filter);
        float slack  = 1e-6f + (filter.is_smooth ? 2.0f / 256 / (float)clamped_width(filter) : 0);
        if (fabsf(answers[n] - wanted) > slack)
            fail_msg("%s, %s, filter %d, smooth %d, query %d: %g, expected %g", dialect, baked->light.name, filter.width_px,
                     filter.is_smooth, n, (double)answers[n], (double)wanted);
        sum->asked++;
        sum->outside += wanted < 0;
        sum->partly += wanted > 0 && wanted < 1;
    }
}

/* The shaders as they stand in tests/shaders, for all kinds of lights, some of them a thousand kilometres from the world's origin;
 * and each with another width in the place of theirs, no two that fetch words alike with the same: a compiler takes longer than all
 * else here. */
static void test_positions(void **state)
{
    enum { WIDTHS = 4 };
    static const char *const texts[WIDTHS]         = {"vxs_box(1)", "vxs_box(9)", "vxs_box(17)", "vxs_smooth(8)"};
    static const vxs_filter  filters[WIDTHS]       = {{1, 0}, {9, 0}, {17, 0}, {8, 1}};
    static const uint32_t    map_levels[WIDTHS]    = {4, 6, 8, 6};
    static const int         other_width[DIALECTS] = {3, 0, 2, 3};
    static query             queries[QUERIES];
    static float             answers[QUERIES];
    drawing                  d = drawing_make();
    (void)state;
    for (int dialect = 0; dialect < DIALECTS; dialect++)
        for (int width = 0; width < WIDTHS; width++) {
            if (width != 1 && width != other_width[dialect]) continue;
            use_program(&d, dialects[dialect], NULL, texts[width]);
            for (int kind = 0; kind < KINDS; kind++) {
                rng        r      = {(uint64_t)(61 + 3 * kind + width)};
                vxs_filter filter = filters[width];
                double     far = (kind + width) % 2 ? 1e6 : 0, at[3] = {far + 3, 5 - far, far - 2}, origin[3] = {far, -far, far};
                dag_sample sample;
                uint32_t   first, levels = map_levels[width];
                tally      sum = {0};
                dag_sample_init(&sample, &r, levels, 200);
                vxs_write_light light = turned_light(&r, &sample, (light_kind)kind, at);
                if (kind >= PUNCTUAL_FIRST && (kind + width) % 3) light.light.range_metres = 6;
                vxs_asset             *asset   = open_light(&light);
                const vxs_baked_light *baked   = vxs_asset_light(asset, 0);
                blocks_sample          blocks  = {0};
                vxs_baked_light        blocked = {.light = baked->light};
                if ((dialect + kind + width) % 2) { /* the same light of other words */
                    blocks_sample_init(&blocks, &r, levels, vxs_map_count(&baked->light), vxs_map_count(&baked->light));
                    blocked.light.coding = VXS_CODING_BLOCKS;
                    blocked.words        = blocks.words;
                    blocked.word_count   = (uint32_t)blocks.word_count + BLOCKS_SPARE_WORDS;
                    baked                = &blocked;
                }
                put_words(&d, (light_words[1]){words_of(baked)}, 1, &first);
                vxs_light_constants c = vxs_light_constants_of(&baked->light, far > 0 ? origin : NULL, first);
                bind_buffer(&d, GL_UNIFORM_BUFFER, sizeof c, &c);
                fill_queries(&r, &baked->light, at, origin, queries);
                draw(&d, queries, answers);
                check_every(baked, origin, queries, filter, 0, 1, answers, dialects[dialect], &sum);
                assert_true(sum.asked > QUERIES * 6 / 10);
                assert_true(sum.outside > QUERIES / 50 || (kind == PUNCTUAL_FIRST + POINT && light.light.range_metres == 0));
                assert_true(sum.partly > (width ? QUERIES / 40 : -1));
                vxs_asset_close(asset);
                dag_sample_free(&sample);
                blocks_sample_free(&blocks);
            }
        }
    gl_context_destroy(d.gl);
}

/* Normal: the width of the filter, and whether it is smooth. */
static const char filter_body[] =
    "layout(std140) uniform shadow_light { vxs_light_constants light; };\n"
    "in vec3 position_ws;\n"
    "in vec3 normal_ws;\n"
    "out float answer;\n"
    "void main() {\n"
    "    answer = vxs_lit(light.first_word, light, position_ws, vec3(0.0), vxs_filter(int(normal_ws.x), int(normal_ws.y)));\n"
    "}\n";

/* Filters of any number, which the compiler of the shader does not know. */
static void test_any_filter(void **state)
{
    static const vxs_filter filters[] = {{1, 0}, {2, 0},  {8, 0},         {9, 0},   {16, 0},       {17, 0}, {18, 0},
                                         {0, 0}, {-1, 0}, {-16777216, 0}, {255, 0}, {0, 1},        {1, 1},  {2, 1},
                                         {9, 1}, {17, 1}, {18, 1},        {256, 1}, {16777216, -1}};
    enum { FILTERS = sizeof filters / sizeof *filters };
    static const double origin[3] = {0, 0, 0}, at[3] = {3, 5, -2};
    static query        queries[QUERIES];
    static float        answers[QUERIES];
    drawing             d = drawing_make();
    (void)state;
    for (int dialect = 0; dialect < DIALECTS; dialect += DIALECTS - 1) { /* of two: it takes long to compile */
        use_program(&d, dialects[dialect], filter_body, NULL);
        for (int kind = 0; kind < KINDS; kind++) {
            rng        r = {(uint64_t)(90 + kind)};
            dag_sample sample;
            uint32_t   first;
            tally      sum = {0};
            dag_sample_init(&sample, &r, 6, 200);
            vxs_write_light        light = turned_light(&r, &sample, (light_kind)kind, at);
            vxs_asset             *asset = open_light(&light);
            const vxs_baked_light *baked = vxs_asset_light(asset, 0);
            put_words(&d, (light_words[1]){words_of(baked)}, 1, &first);
            vxs_light_constants c = vxs_light_constants_of(&baked->light, NULL, first);
            bind_buffer(&d, GL_UNIFORM_BUFFER, sizeof c, &c);
            fill_queries(&r, &baked->light, at, origin, queries);
            for (int n = 0; n < QUERIES; n++) {
                queries[n].normal[0] = (float)filters[n % FILTERS].width_px;
                queries[n].normal[1] = (float)filters[n % FILTERS].is_smooth;
            }
            draw(&d, queries, answers);
            for (int n = 0; n < QUERIES; n++) queries[n].normal[0] = queries[n].normal[1] = queries[n].normal[2] = 0;
            for (int f = 0; f < FILTERS; f++)
                check_every(baked, origin, queries, filters[f], f, FILTERS, answers, dialects[dialect], &sum);
            assert_true(sum.partly > QUERIES / 40);
            vxs_asset_close(asset);
            dag_sample_free(&sample);
        }
    }
    gl_context_destroy(d.gl);
}

/* Position: coordinates of a map; normal: its number. */
static const char back_body[] = "layout(std140) uniform shadow_light { vxs_light_constants light; };\n"
                                "in vec3 position_ws;\n"
                                "in vec3 normal_ws;\n"
                                "out float answer;\n"
                                "void main() {\n"
                                "    vec3 point_ws;\n"
                                "    ivec3 voxel;\n"
                                "    vxs_ws_from_voxel(light, int(normal_ws.x), position_ws, point_ws);\n"
                                "    int map = vxs_voxel_from_ws(light, point_ws, vec3(0.0), vxs_box(1), voxel);\n"
                                "    answer = map == int(normal_ws.x) && voxel == ivec3(floor(position_ws)) ? 1.0 : 0.0;\n"
                                "}\n";

/* From the middle of each voxel to the world and back. */
static void test_there_and_back(void **state)
{
    static query queries[QUERIES];
    static float answers[QUERIES];
    drawing      d = drawing_make();
    (void)state;
    for (int dialect = 0; dialect < DIALECTS; dialect++) {
        use_program(&d, dialects[dialect], back_body, NULL);
        for (int kind = 0; kind < KINDS; kind++) {
            if (kind == PUNCTUAL_FIRST + WIDE_SPOT) continue; /* maps as a point light's, some of them behind it */
            rng                 r     = {(uint64_t)(81 + kind)};
            dag_sample          none  = {.levels = 6};
            vxs_light           light = turned_light(&r, &none, (light_kind)kind, (double[3]){30, -20, 50}).light;
            vxs_light_constants c     = vxs_light_constants_of(&light, NULL, 0);
            double              edge  = kind < PUNCTUAL_FIRST ? 0 : 1; /* no texel is on an edge of the cube */
            c.cos_outer               = 0;
            bind_buffer(&d, GL_UNIFORM_BUFFER, sizeof c, &c);
            for (int n = 0; n < QUERIES; n++) {
                for (int k = 0; k < 3; k++) queries[n].position[k] = (float)(floor(uniform(&r, edge, 64 - edge)) + 0.5);
                queries[n].normal[0] = kind == PUNCTUAL_FIRST + POINT ? (float)rng_below(&r, 6) : 0;
            }
            draw(&d, queries, answers);
            for (int n = 0; n < QUERIES; n++)
                if (answers[n] != 1) fail_msg("%s, light %d, query %d: %g", dialects[dialect], kind, n, (double)answers[n]);
        }
    }
    gl_context_destroy(d.gl);
}

/* The offsets that vxs.h and vxs_space.h name. */
static void test_constants(void **state)
{
    const double        origin[3] = {1e6, -2e6, 3e6};
    dag_sample          none      = {.levels = 6};
    const vxs_light     l = dag_sample_punctual(&none, "lamp", VXS_LIGHT_KIND_SPOT, 0).light, *light = &l;
    vxs_light_constants c = vxs_light_constants_of(light, NULL, 77), moved = vxs_light_constants_of(light, origin, 77);
    (void)state;
    assert_int_equal(offsetof(vxs_light_constants, ls_from_ws), 0);
    assert_int_equal(offsetof(vxs_light_constants, texel_metres), 48);
    assert_int_equal(offsetof(vxs_light_constants, voxel_metres), 52);
    assert_int_equal(offsetof(vxs_light_constants, near_metres), 56);
    assert_int_equal(offsetof(vxs_light_constants, range_metres), 60);
    assert_int_equal(offsetof(vxs_light_constants, cos_outer), 64);
    assert_int_equal(offsetof(vxs_light_constants, kind), 68);
    assert_int_equal(offsetof(vxs_light_constants, flags), 72);
    assert_int_equal(offsetof(vxs_light_constants, levels), 76);
    assert_int_equal(offsetof(vxs_light_constants, first_word), 80);
    assert_int_equal(offsetof(vxs_light_constants, coding), 84);
    assert_int_equal(offsetof(vxs_light_constants, origin_fraction_ij), 88);
    assert_int_equal(offsetof(vxs_light_constants, origin_fraction_k), 92);
    assert_int_equal(sizeof(vxs_light_constants), 96);
    for (int n = 0; n < 12; n++) assert_true(c.ls_from_ws[n] == (float)light->ls_from_ws[n]);
    assert_true(c.texel_metres == (float)light->texel_metres && c.voxel_metres == (float)light->voxel_metres);
    assert_true(c.near_metres == (float)light->near_metres && c.range_metres == 0 && c.cos_outer == 0.75f);
    assert_true(c.kind == VXS_LIGHT_KIND_SPOT && c.flags == 0 && c.levels == 6 && c.first_word == 77 && c.coding == VXS_CODING_DAG);
    assert_true(!c.origin_fraction_ij && !c.origin_fraction_k);
    for (int row = 0; row < 3; row++) {
        const double *m = light->ls_from_ws + 4 * row;
        assert_memory_equal(moved.ls_from_ws + 4 * row, c.ls_from_ws + 4 * row, 3 * sizeof(float));
        assert_true(moved.ls_from_ws[4 * row + 3] == (float)(dot(m, origin) + m[3]));
    }
}

/* Of a sun, the last column and its rest are where the origin is in light space, to 2^-21 of a voxel in any map. */
static void test_rest(void **state)
{
    dag_sample none = {.levels = 18};
    vxs_light  sun  = dag_sample_light(&none, "sun").light;
    rng        r    = {77};
    (void)state;
    for (int n = 0; n < 1000; n++) {
        for (int row = 0; row < 3; row++) sun.ls_from_ws[4 * row + 3] = ldexp(uniform(&r, -1, 1), (int)rng_below(&r, 20));
        vxs_light_constants c        = vxs_light_constants_of(&sun, NULL, 0);
        const uint32_t      rests[3] = {c.origin_fraction_ij & 0xffffu, c.origin_fraction_ij >> 16, c.origin_fraction_k};
        for (int row = 0; row < 3; row++) {
            double rest = ldexp((int16_t)rests[row], -20), is = sun.ls_from_ws[4 * row + 3];
            assert_true(fabs((double)c.ls_from_ws[4 * row + 3] + rest - is) <= 0x1p-21);
        }
    }
    sun.ls_from_ws[3] = 1e9 + 0.4; /* a float does not know the voxel: held */
    assert_int_equal(vxs_light_constants_of(&sun, NULL, 0).origin_fraction_ij & 0xffffu, 0x7fff);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_voxels),     cmocka_unit_test(test_blocks),         cmocka_unit_test(test_positions),
        cmocka_unit_test(test_any_filter), cmocka_unit_test(test_there_and_back), cmocka_unit_test(test_constants),
        cmocka_unit_test(test_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
