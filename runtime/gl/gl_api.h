/* The OpenGL functions and constants of libvxs_gl, under their own names, so that no OpenGL header is needed. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef GL_API_H
#define GL_API_H

#include <stddef.h>

#ifdef _WIN32
#define GL_CALL __stdcall
#else
#define GL_CALL
#endif

typedef unsigned  gl_enum, gl_name;
typedef ptrdiff_t gl_bytes;

enum {
    GL_ERROR_NONE                   = 0,
    GL_FORMAT_RED_INTEGER           = 0x8D94,
    GL_FORMAT_RGBA_INTEGER          = 0x8D99,
    GL_FORMAT_R32UI                 = 0x8236,
    GL_FORMAT_RGBA32UI              = 0x8D70,
    GL_FORMAT_DEPTH                 = 0x1902,
    GL_FORMAT_DEPTH16               = 0x81A5,
    GL_FORMAT_DEPTH32F              = 0x8CAC,
    GL_TYPE_UNSIGNED_SHORT          = 0x1403,
    GL_TYPE_UNSIGNED_INT            = 0x1405,
    GL_TYPE_FLOAT                   = 0x1406,
    GL_TARGET_TEXTURE_2D            = 0x0DE1,
    GL_TARGET_STORAGE_BUFFER        = 0x90D2,
    GL_TARGET_COPY_WRITE_BUFFER     = 0x8F37,
    GL_TARGET_PIXEL_UNPACK_BUFFER   = 0x88EC,
    GL_USAGE_DYNAMIC_DRAW           = 0x88E8,
    GL_UNIT_0                       = 0x84C0,
    GL_NAME_VERSION                 = 0x1F02,
    GL_IS_ACTIVE_TEXTURE            = 0x84E0,
    GL_IS_TEXTURE_2D                = 0x8069,
    GL_IS_PIXEL_UNPACK_BUFFER       = 0x88EF,
    GL_IS_PROGRAM                   = 0x8B8D,
    GL_IS_SAMPLER                   = 0x8919,
    GL_IS_UNPACK_ROW_LENGTH         = 0x0CF2,
    GL_IS_UNPACK_SKIP_ROWS          = 0x0CF3,
    GL_IS_UNPACK_SKIP_PIXELS        = 0x0CF4,
    GL_IS_UNPACK_ALIGNMENT          = 0x0CF5,
    GL_MOST_TEXTURE_SIZE            = 0x0D33,
    GL_MOST_STORAGE_BYTES           = 0x90DE,
    GL_MOST_FRAGMENT_STORAGE_BLOCKS = 0x90DA,
    GL_SET_MAG_FILTER               = 0x2800,
    GL_SET_MIN_FILTER               = 0x2801,
    GL_SET_MAX_LEVEL                = 0x813D,
    GL_SET_WRAP_S                   = 0x2802,
    GL_SET_WRAP_T                   = 0x2803,
    GL_SET_COMPARE_MODE             = 0x884C,
    GL_SET_COMPARE_FUNCTION         = 0x884D,
    GL_FILTER_NEAREST               = 0x2600,
    GL_FILTER_LINEAR                = 0x2601,
    GL_WRAP_CLAMP                   = 0x812F,
    GL_COMPARE_TO_TEXTURE           = 0x884E,
    GL_COMPARE_LEQUAL               = 0x0203,
    GL_MAP_READ                     = 0x0001,
    GL_KIND_COMPUTE_SHADER          = 0x91B9,
    GL_STATUS_LINK                  = 0x8B82,
    GL_BARRIER_PIXEL_BUFFER         = 0x0080,
    GL_BARRIER_BUFFER_UPDATE        = 0x0200,
    GL_BARRIER_SHADER_STORAGE       = 0x2000,
};

/* Result, name without "gl", arguments. The second list is for compute shaders: OpenGL 4.3, ES 3.1. */
/* clang-format off */
#define GL_API(X)                                                                                                        \
    X(const unsigned char *, GetString, (gl_enum))                                                                       \
    X(gl_enum, GetError, (void))                                                                                         \
    X(void, GetIntegerv, (gl_enum, int *))                                                                               \
    X(void, GenBuffers, (int, gl_name *))                                                                                \
    X(void, DeleteBuffers, (int, const gl_name *))                                                                       \
    X(void, BindBuffer, (gl_enum, gl_name))                                                                              \
    X(void, BindBufferBase, (gl_enum, gl_name, gl_name))                                                                 \
    X(void, BufferData, (gl_enum, gl_bytes, const void *, gl_enum))                                                      \
    X(void, BufferSubData, (gl_enum, gl_bytes, gl_bytes, const void *))                                                  \
    X(void *, MapBufferRange, (gl_enum, gl_bytes, gl_bytes, unsigned))                                                   \
    X(unsigned char, UnmapBuffer, (gl_enum))                                                                             \
    X(void, GenTextures, (int, gl_name *))                                                                               \
    X(void, DeleteTextures, (int, const gl_name *))                                                                      \
    X(void, ActiveTexture, (gl_enum))                                                                                    \
    X(void, BindTexture, (gl_enum, gl_name))                                                                             \
    X(void, BindSampler, (gl_name, gl_name))                                                                             \
    X(void, TexImage2D, (gl_enum, int, int, int, int, int, gl_enum, gl_enum, const void *))                              \
    X(void, TexSubImage2D, (gl_enum, int, int, int, int, int, gl_enum, gl_enum, const void *))                           \
    X(void, TexParameteri, (gl_enum, gl_enum, int))                                                                      \
    X(void, PixelStorei, (gl_enum, int))                                                                                 \
    X(int, GetUniformLocation, (gl_name, const char *))                                                                  \
    X(void, Uniform1i, (int, int))                                                                                       \
    X(void, UseProgram, (gl_name))

#define GL_COMPUTE_API(X)                                                                                                \
    X(gl_name, CreateShader, (gl_enum))                                                                                  \
    X(void, ShaderSource, (gl_name, int, const char *const *, const int *))                                              \
    X(void, CompileShader, (gl_name))                                                                                    \
    X(void, GetShaderInfoLog, (gl_name, int, int *, char *))                                                             \
    X(void, DeleteShader, (gl_name))                                                                                     \
    X(gl_name, CreateProgram, (void))                                                                                    \
    X(void, AttachShader, (gl_name, gl_name))                                                                            \
    X(void, LinkProgram, (gl_name))                                                                                      \
    X(void, GetProgramiv, (gl_name, gl_enum, int *))                                                                     \
    X(void, DeleteProgram, (gl_name))                                                                                    \
    X(void, UniformMatrix4fv, (int, int, unsigned char, const float *))                                                  \
    X(void, Uniform4f, (int, float, float, float, float))                                                                \
    X(void, Uniform2ui, (int, unsigned, unsigned))                                                                       \
    X(void, DispatchCompute, (unsigned, unsigned, unsigned))                                                             \
    X(void, MemoryBarrier, (unsigned))
/* clang-format on */

typedef struct gl_api {
#define GL_API_POINTER(result, name, arguments) result(GL_CALL *name) arguments;
    GL_API(GL_API_POINTER)
    GL_COMPUTE_API(GL_API_POINTER)
#undef GL_API_POINTER
} gl_api;

#endif
