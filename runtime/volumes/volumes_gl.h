/* The OpenGL 4.5 functions that libvxs_volumes calls, under its own names, so that no OpenGL header is needed to build it. Not
 * installed.
 * SPDX-License-Identifier: MIT */
#ifndef VOLUMES_GL_H
#define VOLUMES_GL_H

#include <stdint.h>

#include "runtime/gl/gl_api.h"

enum {
    GL_FORMAT_R32F              = 0x822E,
    GL_FORMAT_RG32F             = 0x8230,
    GL_FORMAT_RGBA32F           = 0x8814,
    GL_FORMAT_RED               = 0x1903,
    GL_FORMAT_RGBA              = 0x1908,
    GL_TARGET_TEXTURE_2D_ARRAY  = 0x8C1A,
    GL_TARGET_TEXTURE_BUFFER    = 0x8C2A,
    GL_TARGET_UNIFORM_BUFFER    = 0x8A11,
    GL_TARGET_DRAW_FRAMEBUFFER  = 0x8CA9,
    GL_TARGET_DRAW_COMMANDS     = 0x8F3F,
    GL_KIND_VERTEX_SHADER       = 0x8B31,
    GL_KIND_FRAGMENT_SHADER     = 0x8B30,
    GL_STATUS_COMPILE           = 0x8B81,
    GL_NAME_VENDOR              = 0x1F00,
    GL_NAME_RENDERER            = 0x1F01,
    GL_BINARY_FORMAT_COUNT      = 0x87FE,
    GL_BINARY_FORMATS           = 0x87FF,
    GL_BINARY_LENGTH            = 0x8741,
    GL_SET_BINARY_RETRIEVABLE   = 0x8257,
    GL_STORAGE_DYNAMIC          = 0x0100,
    GL_ACCESS_READ_WRITE        = 0x88BA,
    GL_MODE_TRIANGLES           = 0x0004,
    GL_IS_TEXTURE_2D_ARRAY      = 0x8C1D,
    GL_IS_TEXTURE_BUFFER        = 0x8C2C,
    GL_IS_UNIFORM_BUFFER        = 0x8A28,
    GL_IS_UNIFORM_BUFFER_START  = 0x8A29,
    GL_IS_UNIFORM_BUFFER_SIZE   = 0x8A2A,
    GL_IS_STORAGE_BUFFER        = 0x90D3,
    GL_IS_STORAGE_BUFFER_START  = 0x90D4,
    GL_IS_STORAGE_BUFFER_SIZE   = 0x90D5,
    GL_IS_IMAGE_NAME            = 0x8F3A,
    GL_IS_IMAGE_LEVEL           = 0x8F3B,
    GL_IS_IMAGE_LAYERED         = 0x8F3C,
    GL_IS_IMAGE_LAYER           = 0x8F3D,
    GL_IS_IMAGE_ACCESS          = 0x8F3E,
    GL_IS_IMAGE_FORMAT          = 0x906E,
    GL_IS_DRAW_COMMANDS         = 0x8F43,
    GL_IS_VERTEX_ARRAY          = 0x85B5,
    GL_IS_VIEWPORT              = 0x0BA2,
    GL_IS_DRAW_FRAMEBUFFER      = 0x8CA6,
    GL_IS_BLEND_SRC_RGB         = 0x80C9,
    GL_IS_BLEND_DST_RGB         = 0x80C8,
    GL_IS_BLEND_SRC_ALPHA       = 0x80CB,
    GL_IS_BLEND_DST_ALPHA       = 0x80CA,
    GL_IS_BLEND_EQUATION_RGB    = 0x8009,
    GL_IS_BLEND_EQUATION_ALPHA  = 0x883D,
    GL_IS_COLOUR_MASK           = 0x0C23,
    GL_IS_POLYGON_MODE          = 0x0B40,
    GL_IS_FRONT_FACE            = 0x0B46,
    GL_IS_SCISSOR_BOX           = 0x0C10,
    GL_IS_CLIP_ORIGIN           = 0x935C,
    GL_IS_CLIP_DEPTHS           = 0x935D,
    GL_STATE_BLEND              = 0x0BE2,
    GL_STATE_DEPTH_TEST         = 0x0B71,
    GL_STATE_STENCIL_TEST       = 0x0B90,
    GL_STATE_SCISSOR_TEST       = 0x0C11,
    GL_STATE_CULL_FACE          = 0x0B44,
    GL_STATE_DEPTH_CLAMP        = 0x864F,
    GL_STATE_RASTERIZER_DISCARD = 0x8C89,
    GL_STATE_PRIMITIVE_RESTART  = 0x8F9D,
    GL_BLEND_ADD                = 0x8006,
    GL_BLEND_ONE                = 1,
    GL_BLEND_SRC1_COLOUR        = 0x88F9,
    GL_FACES_FRONT_AND_BACK     = 0x0408,
    GL_POLYGON_FILL             = 0x1B02,
    GL_FACE_COUNTERCLOCKWISE    = 0x0901,
    GL_CLIP_LOWER_LEFT          = 0x8CA1,
    GL_CLIP_NEGATIVE_ONE_TO_ONE = 0x935E,
    GL_ATTACHMENT_COLOUR        = 0x8CE0,
    GL_BUFFER_COLOUR            = 0x1800,
    GL_BARRIER_TEXTURE_FETCH    = 0x0008,
    GL_BARRIER_COMMANDS         = 0x0040,
    GL_BARRIER_IMAGE            = 0x0020,
    GL_BARRIER_FRAMEBUFFER      = 0x0400,
    GL_MOST_BUFFER_TEXELS       = 0x8C2B,
};

/* In addition to those of libvxs_gl: result, name without "gl", arguments. */
/* clang-format off */
#define VOLUMES_API(X)                                                                                                   \
    GL_API(X)                                                                                                            \
    GL_COMPUTE_API(X)                                                                                                    \
    X(void, GetIntegeri_v, (gl_enum, gl_name, int *))                                                                    \
    X(void, GetInteger64i_v, (gl_enum, gl_name, int64_t *))                                                              \
    X(void, GetBooleani_v, (gl_enum, gl_name, unsigned char *))                                                          \
    X(unsigned char, IsEnabled, (gl_enum))                                                                               \
    X(unsigned char, IsEnabledi, (gl_enum, gl_name))                                                                     \
    X(void, Enable, (gl_enum))                                                                                           \
    X(void, Disable, (gl_enum))                                                                                          \
    X(void, Enablei, (gl_enum, gl_name))                                                                                 \
    X(void, Disablei, (gl_enum, gl_name))                                                                                \
    X(void, BlendFuncSeparatei, (gl_name, gl_enum, gl_enum, gl_enum, gl_enum))                                           \
    X(void, BlendEquationSeparatei, (gl_name, gl_enum, gl_enum))                                                         \
    X(void, ColorMaski, (gl_name, unsigned char, unsigned char, unsigned char, unsigned char))                           \
    X(void, PolygonMode, (gl_enum, gl_enum))                                                                             \
    X(void, Viewport, (int, int, int, int))                                                                              \
    X(void, BindImageTexture, (gl_name, gl_name, int, unsigned char, int, gl_enum, gl_enum))                             \
    X(void, CreateTextures, (gl_enum, int, gl_name *))                                                                   \
    X(void, TextureStorage2D, (gl_name, int, gl_enum, int, int))                                                         \
    X(void, TextureStorage3D, (gl_name, int, gl_enum, int, int, int))                                                    \
    X(void, TextureView, (gl_name, gl_enum, gl_name, gl_enum, gl_name, gl_name, gl_name, gl_name))                       \
    X(void, TextureParameteri, (gl_name, gl_enum, int))                                                                  \
    X(void, ClearTexImage, (gl_name, int, gl_enum, gl_enum, const void *))                                               \
    X(void, CopyImageSubData, (gl_name, gl_enum, int, int, int, int, gl_name, gl_enum, int, int, int, int, int, int, int)) \
    X(void, CreateBuffers, (int, gl_name *))                                                                             \
    X(void, NamedBufferStorage, (gl_name, gl_bytes, const void *, gl_enum))                                              \
    X(void, NamedBufferSubData, (gl_name, gl_bytes, gl_bytes, const void *))                                             \
    X(void, ClearNamedBufferSubData, (gl_name, gl_enum, gl_bytes, gl_bytes, gl_enum, gl_enum, const void *))             \
    X(void, CopyNamedBufferSubData, (gl_name, gl_name, gl_bytes, gl_bytes, gl_bytes))                                    \
    X(void, GetNamedBufferSubData, (gl_name, gl_bytes, gl_bytes, void *))                                                \
    X(void, BindBufferRange, (gl_enum, gl_name, gl_name, gl_bytes, gl_bytes))                                            \
    X(void, CreateFramebuffers, (int, gl_name *))                                                                        \
    X(void, DeleteFramebuffers, (int, const gl_name *))                                                                  \
    X(void, NamedFramebufferTexture, (gl_name, gl_enum, gl_name, int))                                                   \
    X(void, ClearNamedFramebufferfv, (gl_name, gl_enum, int, const float *))                                             \
    X(void, BindFramebuffer, (gl_enum, gl_name))                                                                         \
    X(void, CreateVertexArrays, (int, gl_name *))                                                                        \
    X(void, DeleteVertexArrays, (int, const gl_name *))                                                                  \
    X(void, BindVertexArray, (gl_name))                                                                                  \
    X(void, GetShaderiv, (gl_name, gl_enum, int *))                                                                      \
    X(void, ProgramParameteri, (gl_name, gl_enum, int))                                                                  \
    X(void, GetProgramBinary, (gl_name, int, int *, gl_enum *, void *))                                                  \
    X(void, ProgramBinary, (gl_name, gl_enum, const void *, int))                                                        \
    X(void, Scissor, (int, int, int, int))                                                                               \
    X(void, FrontFace, (gl_enum))                                                                                        \
    X(void, ClipControl, (gl_enum, gl_enum))                                                                             \
    X(void, TextureBuffer, (gl_name, gl_enum, gl_name))                                                                  \
    X(void, EnableVertexArrayAttrib, (gl_name, gl_name))                                                                 \
    X(void, VertexArrayAttribFormat, (gl_name, gl_name, int, gl_enum, unsigned char, gl_name))                           \
    X(void, VertexArrayAttribBinding, (gl_name, gl_name, gl_name))                                                       \
    X(void, VertexArrayVertexBuffer, (gl_name, gl_name, gl_name, gl_bytes, int))                                         \
    X(void, VertexArrayElementBuffer, (gl_name, gl_name))                                                                \
    X(void, DrawElements, (gl_enum, int, gl_enum, const void *))                                                         \
    X(void, DrawArrays, (gl_enum, int, int))                                                                             \
    X(void, DrawArraysIndirect, (gl_enum, const void *))
/* clang-format on */

typedef struct volumes_api {
#define VOLUMES_POINTER(result, name, arguments) result(GL_CALL *name) arguments;
    VOLUMES_API(VOLUMES_POINTER)
#undef VOLUMES_POINTER
} volumes_api;

#endif
