/* Questions to a shader, each a point that is drawn into a pixel of its own, so that versions without compute shaders are queried
 * the same way. Included behind cmocka.h, with baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GL_POINTS_H
#define GL_POINTS_H

#include "tests/gl_choice.h"

#define DRAW_FUNCTIONS(X)                                                                                                          \
    X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                                                           \
    X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)

enum { WIDTH_PX = 256, HEIGHT_PX = 64, QUERIES = WIDTH_PX * HEIGHT_PX };

/* What is drawn with. */
typedef struct drawing {
    gl_context *gl;
#define DRAW_POINTER(type, name) type name;
    DRAW_FUNCTIONS(DRAW_POINTER)
#undef DRAW_POINTER
    GLuint program, words_texture; /* the second is the test's own */
} drawing;

/* As the vertex shader reads it. */
typedef struct query {
    float position[3], normal[3];
} query;

static const char points_vertex_text[] = "layout(location = 0) in vec3 position;\n"
                                         "layout(location = 1) in vec3 normal;\n"
                                         "layout(location = 2) in float number;\n" /* softpipe: gl_VertexID % 4096 */
                                         "out vec3 position_ws;\n"
                                         "out vec3 normal_ws;\n"
                                         "flat out int vertex;\n"
                                         "void main() {\n"
                                         "    position_ws = position;\n"
                                         "    normal_ws = normal;\n"
                                         "    vertex = int(number);\n"
                                         "    vec2 pixel = vec2(vertex % 256, vertex / 256) + 0.5;\n"
                                         "    gl_Position = vec4(pixel / vec2(128.0, 32.0) - 1.0, 0.0, 1.0);\n"
                                         "    gl_PointSize = 1.0;\n"
                                         "}\n";

/* No warning, either. */
static inline void compile(const drawing *d, const char *name, GLuint shader)
{
    char  log[4096] = "";
    GLint good;
    d->gl->CompileShader(shader);
    d->GetShaderiv(shader, GL_COMPILE_STATUS, &good);
    d->GetShaderInfoLog(shader, sizeof log, NULL, log);
    if (!good || log[0]) fail_msg("%s: %s", name, log);
    d->gl->AttachShader(d->program, shader);
    d->gl->DeleteShader(shader);
}

/* Link and use a program: the version's line and the text above, and the texts of a fragment shader. */
static inline void use_texts(drawing *d, const char *name, const char *version, const char *const *texts, int count)
{
    GLuint vertex = d->gl->CreateShader(GL_VERTEX_SHADER), fragment = d->gl->CreateShader(GL_FRAGMENT_SHADER);
    GLint  good;
    d->gl->ShaderSource(vertex, 3, (const char *[3]){version, "\n", points_vertex_text}, NULL);
    d->gl->ShaderSource(fragment, count, texts, NULL);
    if (d->program) d->gl->DeleteProgram(d->program);
    d->program = d->gl->CreateProgram();
    compile(d, name, vertex);
    compile(d, name, fragment);
    d->gl->LinkProgram(d->program);
    d->gl->GetProgramiv(d->program, GL_LINK_STATUS, &good);
    assert_true(good);
    d->gl->UseProgram(d->program);
}

static inline drawing drawing_make(void)
{
    drawing     d = {0};
    run_context m = {0};
    GLuint      pixels, frame, array;
    if (gl_context_create(&d.gl, gl_choice(), 1, &m) != VXS_OK) {
        print_message("no OpenGL 4.5: %s\n", m.error);
        skip();
    }
#define DRAW_LOAD(type, name)                                                                                                      \
    d.name = (type)gl_choice_function("gl" #name);                                                                                 \
    assert_true(d.name != NULL);
    DRAW_FUNCTIONS(DRAW_LOAD)
#undef DRAW_LOAD
    d.gl->CreateTextures(GL_TEXTURE_2D, 1, &pixels);
    d.gl->TextureStorage2D(pixels, 1, GL_R32F, WIDTH_PX, HEIGHT_PX);
    d.gl->GenFramebuffers(1, &frame);
    d.gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    d.gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, pixels, 0);
    d.gl->Viewport(0, 0, WIDTH_PX, HEIGHT_PX);
    d.gl->GenVertexArrays(1, &array);
    d.gl->BindVertexArray(array);
    return d;
}

static inline GLuint bind_buffer(const drawing *d, GLenum target, size_t size, const void *data)
{
    GLuint buffer;
    d->gl->GenBuffers(1, &buffer);
    d->gl->BindBuffer(target, buffer);
    d->gl->BufferData(target, (GLsizeiptr)size, data, GL_STATIC_DRAW);
    if (target != GL_ARRAY_BUFFER) d->gl->BindBufferBase(target, 0, buffer);
    return buffer;
}

/* answers  [out] [QUERIES] */
static inline void draw(const drawing *d, const query *queries, float *answers)
{
    static float numbers[QUERIES];
    GLuint       buffers[2] = {bind_buffer(d, GL_ARRAY_BUFFER, QUERIES * sizeof *queries, queries)};
    for (GLuint n = 0; n < 2; n++)
        d->gl->VertexAttribPointer(n, 3, GL_FLOAT, GL_FALSE, sizeof *queries, (const void *)(n * sizeof queries->position));
    for (int n = 0; n < QUERIES; n++) numbers[n] = (float)n;
    buffers[1] = bind_buffer(d, GL_ARRAY_BUFFER, sizeof numbers, numbers);
    d->gl->VertexAttribPointer(2, 1, GL_FLOAT, GL_FALSE, 0, NULL);
    for (GLuint n = 0; n < 3; n++) d->gl->EnableVertexAttribArray(n);
    d->gl->ClearBufferfv(GL_COLOR, 0, (float[4]){-7, 0, 0, 0});
    d->gl->DrawArrays(GL_POINTS, 0, QUERIES);
    d->gl->ReadPixels(0, 0, WIDTH_PX, HEIGHT_PX, GL_RED, GL_FLOAT, answers);
    d->gl->DeleteBuffers(2, buffers);
    assert_int_equal(d->gl->GetError(), GL_NO_ERROR);
}

#endif
