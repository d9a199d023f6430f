/* An OpenGL 4.5 core context without a window, and its functions. Only this file depends on how the context is created.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GL_H
#define GL_H

#include <GL/glcorearb.h>
#include <stdint.h>

#include "baker/base/embedded.h"
#include "baker/columns/rendered_columns.h"

/* Functions are loaded at run time, because OSMesa and EGL each have their own. Type, name without "gl". */
/* clang-format off */
#define GL_FUNCTIONS(X)                                            \
    X(PFNGLATTACHSHADERPROC, AttachShader)                          \
    X(PFNGLBINDBUFFERPROC, BindBuffer)                              \
    X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                      \
    X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                    \
    X(PFNGLBINDTEXTUREUNITPROC, BindTextureUnit)                    \
    X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                    \
    X(PFNGLBLENDEQUATIONPROC, BlendEquation)                        \
    X(PFNGLBLENDFUNCPROC, BlendFunc)                                \
    X(PFNGLBUFFERDATAPROC, BufferData)                              \
    X(PFNGLCLEARBUFFERFVPROC, ClearBufferfv)                        \
    X(PFNGLCLIPCONTROLPROC, ClipControl)                            \
    X(PFNGLCOMPILESHADERPROC, CompileShader)                        \
    X(PFNGLCREATEPROGRAMPROC, CreateProgram)                        \
    X(PFNGLCREATESHADERPROC, CreateShader)                          \
    X(PFNGLCREATETEXTURESPROC, CreateTextures)                      \
    X(PFNGLCULLFACEPROC, CullFace)                                  \
    X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                        \
    X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)              \
    X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                        \
    X(PFNGLDELETESHADERPROC, DeleteShader)                          \
    X(PFNGLDELETETEXTURESPROC, DeleteTextures)                      \
    X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)              \
    X(PFNGLDEPTHFUNCPROC, DepthFunc)                                \
    X(PFNGLDEPTHMASKPROC, DepthMask)                                \
    X(PFNGLDISABLEPROC, Disable)                                    \
    X(PFNGLDRAWARRAYSPROC, DrawArrays)                              \
    X(PFNGLDRAWBUFFERSPROC, DrawBuffers)                            \
    X(PFNGLDRAWELEMENTSPROC, DrawElements)                          \
    X(PFNGLENABLEPROC, Enable)                                      \
    X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray)    \
    X(PFNGLFINISHPROC, Finish)                                      \
    X(PFNGLFLUSHPROC, Flush)                                        \
    X(PFNGLFRAMEBUFFERTEXTUREPROC, FramebufferTexture)              \
    X(PFNGLFRAMEBUFFERTEXTURELAYERPROC, FramebufferTextureLayer)    \
    X(PFNGLFRONTFACEPROC, FrontFace)                                \
    X(PFNGLGENBUFFERSPROC, GenBuffers)                              \
    X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers)                    \
    X(PFNGLGENTEXTURESPROC, GenTextures)                            \
    X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays)                    \
    X(PFNGLGETERRORPROC, GetError)                                  \
    X(PFNGLGETNAMEDBUFFERSUBDATAPROC, GetNamedBufferSubData)        \
    X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                \
    X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                          \
    X(PFNGLGETSTRINGPROC, GetString)                                \
    X(PFNGLGETTEXTUREIMAGEPROC, GetTextureImage)                    \
    X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)              \
    X(PFNGLLINKPROGRAMPROC, LinkProgram)                            \
    X(PFNGLNAMEDBUFFERSUBDATAPROC, NamedBufferSubData)              \
    X(PFNGLPIXELSTOREIPROC, PixelStorei)                            \
    X(PFNGLPROGRAMUNIFORM1FPROC, ProgramUniform1f)                  \
    X(PFNGLPROGRAMUNIFORM1IPROC, ProgramUniform1i)                  \
    X(PFNGLPROGRAMUNIFORM3FPROC, ProgramUniform3f)                  \
    X(PFNGLPROGRAMUNIFORM3IPROC, ProgramUniform3i)                  \
    X(PFNGLPROGRAMUNIFORM4FPROC, ProgramUniform4f)                  \
    X(PFNGLPROGRAMUNIFORM4IPROC, ProgramUniform4i)                  \
    X(PFNGLPROGRAMUNIFORMMATRIX4FVPROC, ProgramUniformMatrix4fv)    \
    X(PFNGLREADPIXELSPROC, ReadPixels)                              \
    X(PFNGLSCISSORPROC, Scissor)                                    \
    X(PFNGLSHADERSOURCEPROC, ShaderSource)                          \
    X(PFNGLTEXTUREPARAMETERIPROC, TextureParameteri)                \
    X(PFNGLTEXTURESTORAGE2DPROC, TextureStorage2D)                  \
    X(PFNGLTEXTURESTORAGE3DPROC, TextureStorage3D)                  \
    X(PFNGLTEXTURESUBIMAGE2DPROC, TextureSubImage2D)                \
    X(PFNGLTEXTUREVIEWPROC, TextureView)                            \
    X(PFNGLUSEPROGRAMPROC, UseProgram)                              \
    X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer)            \
    X(PFNGLVIEWPORTPROC, Viewport)
/* clang-format on */

typedef void (*gl_function)(void);

typedef struct gl_context {
#define GL_FUNCTION_POINTER(type, name) type name;
    GL_FUNCTIONS(GL_FUNCTION_POINTER)
#undef GL_FUNCTION_POINTER
    gl_function (*lookup)(const char *name); /* the loader of these functions */
    gl_backend   backend;
    void        *handle;            /* OSMesaContext, or EGLContext */
    void        *display;           /* EGLDisplay */
    void        *library;           /* libEGL, loaded when it is needed */
    uint32_t     pixels[16 * 16];   /* OSMesa requires a default framebuffer; maps are drawn elsewhere */
    GLuint       depth_programs[3]; /* of depth_gl.c, made when first needed, deleted with the context */
    device_names names;
} gl_context;

/* Make a context and make it current on the calling thread. Only that thread may use it until gl_context_destroy.
 * threads  rasterizer threads of a software renderer.
 * Returns VXS_OK, VXS_E_GL (the message names the missing function), or VXS_E_MEMORY. */
vxs_result gl_context_create(gl_context **out, gl_backend backend, uint32_t threads, run_context *m);

void gl_context_destroy(gl_context *gl);

/* For libraries that load functions of OpenGL: get_proc_address of vxs_gl_desc and vxs_volumes_desc.   user  the gl_context */
gl_function gl_lookup(const char *name, void *user);

/* A part of a shader's text; a list of parts ends with {0}. */
typedef struct gl_text {
    const char *text;
    GLint       size; /* -1: up to its end */
} gl_text;

static inline gl_text gl_embedded(embedded e)
{
    return (gl_text){e.begin, (GLint)(e.end - e.begin)};
}

/* Make a program of the parts of a vertex and of a fragment shader, at most GL_TEXTS_MAX each.
 * program  [out] deleted by the caller, whatever is returned
 * Returns VXS_OK or VXS_E_GL. */
enum { GL_TEXTS_MAX = 32 };
vxs_result gl_program(const gl_context *gl, GLuint *program, const gl_text *vertex, const gl_text *fragment, run_context *m);

/* The same of one text for both stages, which has no #version: its vertex shader is between #ifdef VERTEX and #else.
 * before  a text that comes first in the fragment shader; {0}: none */
vxs_result gl_program_of(const gl_context *gl, GLuint *program, embedded text, gl_text before, run_context *m);

/* The same of a fragment shader for a triangle over the whole screen, three vertices without attributes. */
vxs_result gl_screen_program(const gl_context *gl, GLuint *program, const gl_text *fragment, run_context *m);

/* A framebuffer of textures.   depth  0: none;   colours  [count] at most 2 */
GLuint gl_frame(const gl_context *gl, GLuint depth, const GLuint *colours, GLsizei count);

#endif
