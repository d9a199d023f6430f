/* What a program has that draws with OpenGL: a context, textures, what was drawn, a program, a picture. Here of OSMesa, without a
 * window.
 * SPDX-License-Identifier: MIT */
#ifndef GL_PICTURE_H
#define GL_PICTURE_H

#define GL_GLEXT_PROTOTYPES
#include <GL/osmesa.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDE = 480, HIGH = 270 };
static unsigned char gl_picture[HIGH][WIDE][4];

/* Returns 0 where there is none. */
static int gl_begin(void)
{
    const int     wanted[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              4,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              5,
                              0,
                              0};
    OSMesaContext context  = OSMesaCreateContextAttribs(wanted, NULL);
    return context && OSMesaMakeCurrent(context, gl_picture, GL_UNSIGNED_BYTE, WIDE, HIGH);
}

static void (*gl_function(const char *name, void *user))(void)
{
    (void)user;
    return OSMesaGetProcAddress(name);
}

/* texels  NULL: none yet */
static GLuint gl_texture(GLsizei wide, GLsizei high, const float *texels)
{
    GLuint name;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_R32F, wide, high);
    if (texels) glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, wide, high, GL_RED, GL_FLOAT, texels);
    return name;
}

/* From pixels and depths, near / z, to places from the eye, that looks along z: by columns. */
static const float gl_point_from_depth[16] = {1.6F, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, -0.8F, -0.5F, 1, 0};

/* Depths of the ground, below the eye: what was drawn. */
static GLuint gl_ground(float metres)
{
    static float depths[HIGH * WIDE];
    for (int n = 0; n < WIDE * HIGH; n++) depths[n] = n / WIDE < HIGH / 2 ? (0.5F - (n / WIDE + 0.5F) / HIGH) / metres : 0;
    return gl_texture(WIDE, HIGH, depths);
}

static GLuint gl_normals_up(void)
{
    static const float up[4] = {0, 1, 0, 0};
    GLuint             name;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, WIDE, HIGH);
    glClearTexImage(name, 0, GL_RGBA, GL_FLOAT, up);
    return name;
}

static GLuint gl_buffer(const void *data, size_t size_bytes)
{
    GLuint name;
    glGenBuffers(1, &name);
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, name);
    glBufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size_bytes, data, GL_STATIC_DRAW);
    return name;
}

/* Draw all pixels with a fragment shader of several texts. */
static void gl_draw(const char *const *texts, int count)
{
    const char *triangle =
        "#version 450\nvoid main() { gl_Position = vec4(gl_VertexID / 2 * 4 - 1, gl_VertexID % 2 * 4 - 1, 0, 1); }";
    GLuint program = glCreateProgram(), shaders[2] = {glCreateShader(GL_VERTEX_SHADER), glCreateShader(GL_FRAGMENT_SHADER)}, array;
    glShaderSource(shaders[0], 1, &triangle, NULL);
    glShaderSource(shaders[1], count, texts, NULL);
    for (int n = 0; n < 2; n++) {
        glCompileShader(shaders[n]);
        glAttachShader(program, shaders[n]);
    }
    glLinkProgram(program);
    glProgramUniformMatrix4fv(program, glGetUniformLocation(program, "point_from_depth"), 1, GL_FALSE, gl_point_from_depth);
    glUseProgram(program);
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* Returns 0 where it cannot be written. */
static int gl_write(const char *path)
{
    FILE *to = fopen(path, "wb");
    glFinish();
    if (!to) return perror(path), 0;
    fprintf(to, "P6 %d %d 255\n", WIDE, HIGH);
    for (int n = 0; n < WIDE * HIGH; n++) fwrite(gl_picture[HIGH - 1 - n / WIDE][n % WIDE], 1, 3, to);
    return fclose(to) == 0 || (perror(path), 0);
}

#endif
