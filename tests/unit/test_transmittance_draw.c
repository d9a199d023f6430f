/* Segments that shaders of an engine add to maps of transmittance curves (vxs_transmittance_map_build_drawn): balls, drawn as boxes
 * about them, against the same balls as capsules, and against what they leave of light in double; a sun, a spot and a point light;
 * rubbish; misuse.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "transmittance_maps.h"

enum { AT_BALLS = 12 };

/* an engine -------------------------------------------------------------------------------------------------------------------- */

/* The far sides of a box about each ball, so that a texel has one fragment; wider than the ball by half a texel's share, which a
 * texel's centre may need. */
static const char vertex_body[] =
    "layout(std430, binding = 12) readonly buffer balls_buffer { vec4 balls[]; }; /* capsules, two each */\n"
    "uniform int layer;\n"
    "flat out vec4 ball;\n"
    "flat out float extinction;\n"
    "const int corners[36] = int[36](0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, "
    "3, 5, 3, 7, 5);\n"
    "void main()\n"
    "{\n"
    "    int n = corners[gl_VertexID % 36], of = gl_VertexID / 36;\n"
    "    ball = balls[2 * of];\n"
    "    extinction = balls[2 * of + 1].w;\n"
    "    vec3 corner = vec3(n & 1, n >> 1 & 1, n >> 2) * 2.0 - 1.0;\n"
    "    gl_Position = vxs_segment_position(ball.xyz + 1.1 * ball.w * corner, layer);\n"
    "}\n";

static const char fragment_body[] =
    "flat in vec4 ball;\n"
    "flat in float extinction;\n"
    "uniform int layer;\n"
    "void main()\n"
    "{\n"
    "    ivec3 texel = ivec3(ivec2(gl_FragCoord.xy), layer);\n"
    "    vec3  from, way = vxs_segment_ray(texel, from), middle = ball.xyz - from;\n"
    "    float along = dot(middle, way), half_of_it = ball.w * ball.w - dot(middle - along * way, middle - along * way);\n"
    "    if (half_of_it <= 0.0) return;\n"
    "    half_of_it = sqrt(half_of_it);\n"
    "    vxs_add_segment(texel, along - half_of_it, along + half_of_it, exp(-2.0 * extinction * half_of_it));\n"
    "}\n";

static const char screen_body[] = "void main()\n"
                                  "{\n"
                                  "    gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0.0, 1.0);\n"
                                  "}\n";

static const char rubbish_body[] = "uniform vec4 odd; /* no numbers, or too large */\n"
                                   "void main()\n"
                                   "{\n"
                                   "    if (any(greaterThan(gl_FragCoord.xy, vec2(1.0)))) return;\n"
                                   "    ivec3 end = vxs_segment_texels(), texel;\n"
                                   "    for (int n = 0; n < 4; n++) {\n"
                                   "        vxs_add_segment(ivec3(0), odd[n], 2.0, 0.5);\n"
                                   "        vxs_add_segment(ivec3(0), 1.0, odd[n], 0.5);\n"
                                   "        vxs_add_segment(ivec3(0), 1.0, 2.0, odd[n]);\n"
                                   "    }\n"
                                   "    for (int n = 0; n < 3; n++) {\n"
                                   "        texel = ivec3(0);\n"
                                   "        texel[n] = -1;\n"
                                   "        vxs_add_segment(texel, 1.0, 2.0, 0.5);\n"
                                   "        texel[n] = end[n];\n"
                                   "        vxs_add_segment(texel, 1.0, 2.0, 0.5);\n"
                                   "    }\n"
                                   "    vxs_add_segment(ivec3(0), 2.0, 1.0, 0.5);\n"
                                   "    vxs_add_segment(ivec3(0), 1.0, 2.0, 1.0);\n"
                                   "    vxs_add_segment(ivec3(1), -2.0, -1.0, 0.5);\n"
                                   "    vxs_add_segment(end - 1, -1.0, 1.0, 0.0625);\n"
                                   "}\n";

static GLuint program_of(const vxs_transmittance_map *map, const char *vertex, const char *fragment)
{
    const char *texts[VXS_SEGMENT_TEXTS + 2] = {"#version 450 core\n"};
    char        log[1024]                    = "";
    GLint       good                         = 0;
    GLuint      program                      = s.gl->CreateProgram();
    assert_int_equal(vxs_transmittance_map_texts(map, texts + 1), VXS_OK);
    for (int n = 0; n < 2; n++) {
        GLuint shader                = s.gl->CreateShader(n ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER);
        texts[VXS_SEGMENT_TEXTS + 1] = n ? fragment : vertex;
        s.gl->ShaderSource(shader, VXS_SEGMENT_TEXTS + 2, texts, NULL);
        s.gl->CompileShader(shader);
        s.gl->AttachShader(program, shader);
        s.gl->DeleteShader(shader);
    }
    s.gl->LinkProgram(program);
    s.gl->GetProgramInfoLog(program, sizeof log, NULL, log);
    s.gl->GetProgramiv(program, GL_LINK_STATUS, &good);
    if (!good) print_message("%s\n", log);
    assert_true(good);
    return program;
}

typedef struct engine {
    GLuint program, balls, array, image, target;
    int    vertices, layers;
    GLenum culled;
} engine;

static engine engine_make(const vxs_transmittance_map *map, int layers, const char *vertex, const char *fragment)
{
    engine e = {.layers = layers, .program = program_of(map, vertex, fragment)};
    s.gl->GenVertexArrays(1, &e.array);
    s.gl->GenBuffers(1, &e.balls);
    s.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, e.balls);
    s.gl->BufferData(GL_SHADER_STORAGE_BUFFER, CAPSULES * sizeof(vxs_capsule), NULL, GL_DYNAMIC_DRAW);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, &e.image);
    s.gl->TextureStorage2D(e.image, 1, GL_R8, SIDE, SIDE);
    s.gl->GenFramebuffers(1, &e.target);
    s.gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, e.target);
    s.gl->FramebufferTexture(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, e.image, 0);
    s.gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    return e;
}

static void engine_free(engine *e)
{
    s.gl->DeleteProgram(e->program);
    s.gl->DeleteBuffers(1, &e->balls);
    s.gl->DeleteTextures(1, &e->image);
    s.gl->DeleteVertexArrays(1, &e->array);
    s.gl->DeleteFramebuffers(1, &e->target);
}

static void engine_draw(void *user)
{
    const engine *e = user;
    s.gl->UseProgram(e->program);
    s.gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, e->target);
    s.gl->BindVertexArray(e->array);
    s.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, AT_BALLS, e->balls);
    s.gl->Viewport(0, 0, SIDE, SIDE);
    if (e->culled) s.gl->Enable(GL_CULL_FACE);
    if (e->culled) s.gl->CullFace(e->culled);
    for (int layer = 0; layer < e->layers; layer++) {
        s.gl->ProgramUniform1i(e->program, s.gl->GetUniformLocation(e->program, "layer"), layer);
        s.gl->DrawArrays(GL_TRIANGLES, 0, e->vertices);
    }
    s.gl->Disable(GL_CULL_FACE);
    s.gl->UseProgram(0);
    s.gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    s.gl->BindVertexArray(0);
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* Balls where the smoke's capsules begin; every tenth on the ground. */
static void make_balls(vxs_capsule *balls)
{
    make_smoke(balls);
    for (int n = 0; n < CAPSULES; n++) {
        if (n % 10 == 0) balls[n].begin[1] = 0;
        memcpy(balls[n].end, balls[n].begin, sizeof balls[n].end);
        balls[n].radius_metres = fmaxf(balls[n].radius_metres, 0.8F);
    }
}

static void build_drawn(vxs_transmittance_map *map, engine *e, const vxs_capsule *balls, uint32_t drawn,
                        const vxs_shadow_depth_map *opaque, texels *t)
{
    vxs_capsules rest = {.list = balls + drawn, .count = CAPSULES - drawn};
    e->vertices       = 36 * (int)drawn;
    s.gl->NamedBufferSubData(e->balls, 0, drawn * sizeof *balls, balls);
    assert_int_equal(vxs_transmittance_map_build_drawn(map, &rest, opaque, engine_draw, e), VXS_OK);
    read_curves(map, t);
}

static uint32_t texels_alike(const texels *a, const texels *b, double within)
{
    uint32_t alike = 0;
    for (size_t texel = 0; texel < a->count; texel++) {
        double off = 0;
        for (size_t n = 0; n < 2 * a->nodes; n++) {
            double x = (double)a->curves[2 * texel * a->nodes + n], y = (double)b->curves[2 * texel * a->nodes + n];
            off = fmax(off, fabs(x - y) / fmax(1, fabs(x)));
        }
        alike += off < within;
    }
    return alike;
}

/* All of them drawn, or half, beside capsules: the segments and curves that capsules alone make, and behind all of them what double
 * says. */
static void test_balls_are_drawn(void **state)
{
    (void)state;
    static vxs_capsule balls[CAPSULES];
    static texel_ray   ray;
    make_balls(balls);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_transmittance_map *map    = map_of(light, SORTED);
        vxs_shadow_depth_map  *opaque = opaque_map(light);
        texels                 wanted = texels_of(light, NODES), got = texels_of(light, NODES);
        engine                 e = engine_make(map, wanted.map.layers, vertex_body, fragment_body);
        e.culled                 = GL_BACK;
        for (int way = 0; way < 3; way++) {
            double most = 0;
            build(map, balls, CAPSULES, way == 2 ? opaque : NULL, &wanted);
            vxs_transmittance_counts counts = vxs_transmittance_map_counts(map), drawn;
            build_drawn(map, &e, balls, way == 1 ? CAPSULES / 2 : CAPSULES, way == 2 ? opaque : NULL, &got);
            drawn          = vxs_transmittance_map_counts(map);
            uint32_t alike = texels_alike(&wanted, &got, 1e-3);
            for (size_t texel = 0; texel < got.count && way < 2; texel++) {
                trace(&got, texel, balls, CAPSULES, &ray);
                most = fmax(most, fabs(curve_end(&got, texel) - left_at(&ray, 1e3)));
            }
            print_message("light %d, way %d: %u segments of capsules, %u drawn; %u of %zu curves alike; t_last %.1e at most\n",
                          light, way, counts.segments, drawn.segments, alike, got.count, most);
            assert_true(counts.segments > 150 && drawn.merged == 0 && most < 5e-3);
            if (way < 2) assert_true(fabs((double)drawn.segments - (double)counts.segments) <= 2e-3 * (double)counts.segments + 2);
            assert_true(alike > 0.97 * (double)got.count);
        }
        engine_free(&e);
        vxs_shadow_depth_map_destroy(opaque);
        free(wanted.curves);
        free(got.curves);
    }
}

/* Of what is no segment nothing is added; of one about the light, of the last texel, the half before it. */
static void test_rubbish_is_left_out(void **state)
{
    (void)state;
    vxs_transmittance_map *map  = map_of(SCENE_POINT, SORTED);
    vxs_capsules           none = {.count = 0};
    texels                 t    = texels_of(SCENE_POINT, NODES);
    engine                 e    = engine_make(map, 1, screen_body, rubbish_body);
    e.vertices                  = 3;
    s.gl->ProgramUniform4f(e.program, s.gl->GetUniformLocation(e.program, "odd"), NAN, INFINITY, -INFINITY, 1e13F);
    assert_int_equal(vxs_transmittance_map_build_drawn(map, &none, NULL, engine_draw, &e), VXS_OK);
    read_curves(map, &t);
    assert_int_equal(vxs_transmittance_map_counts(map).segments, 1);
    for (size_t texel = 0; texel < t.count; texel++) assert_true(curve_end(&t, texel) == (texel + 1 == t.count ? 0.25 : 1));
    engine_free(&e);
    free(t.curves);
}

/* Tiles have no lists to add to. Bindings are as they were. */
static void test_misuse(void **state)
{
    (void)state;
    PFNGLGETINTEGERI_VPROC get_i = (PFNGLGETINTEGERI_VPROC)gl_choice_function("glGetIntegeri_v");
    const char            *texts[VXS_SEGMENT_TEXTS];
    vxs_transmittance_map *tiles = map_of(SCENE_SUN, STREAMED), *lists = map_of(SCENE_SUN, SORTED);
    vxs_capsules           none = {.count = 0};
    engine                 e    = engine_make(lists, 1, vertex_body, fragment_body);
    assert_int_equal(vxs_transmittance_map_texts(tiles, texts), VXS_E_ARGUMENT);
    assert_int_equal(vxs_transmittance_map_build_drawn(tiles, &none, NULL, engine_draw, &e), VXS_E_ARGUMENT);
    assert_int_equal(vxs_transmittance_map_build_drawn(tiles, &none, NULL, NULL, NULL), VXS_OK);
    assert_int_equal(vxs_transmittance_map_texts(lists, texts), VXS_OK);
    GLuint first = (GLuint)atoi(strrchr(texts[0], ' '));
    for (GLuint n = 0; n < 2; n++) s.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, first + n, e.balls);
    assert_int_equal(vxs_transmittance_map_build_drawn(lists, &none, NULL, engine_draw, &e), VXS_OK);
    for (GLuint n = 0; n < 2; n++) {
        GLint bound;
        get_i(GL_SHADER_STORAGE_BUFFER_BINDING, first + n, &bound);
        assert_int_equal(bound, e.balls);
    }
    engine_free(&e);
    assert_int_equal(s.gl->GetError(), GL_NO_ERROR);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_balls_are_drawn), cmocka_unit_test(test_rubbish_is_left_out),
                                       cmocka_unit_test(test_misuse)};
    return cmocka_run_group_tests(tests, open_scene, close_scene);
}
