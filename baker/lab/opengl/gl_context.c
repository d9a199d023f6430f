/* The only file that depends on OSMesa and EGL; and helpers for programs and framebuffers; see gl.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h" /* first: its glcorearb.h must come before the older gl.h that osmesa.h brings */

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef gl_function (*gl_loader)(const char *name);

static vxs_result load_functions(gl_context *gl, gl_loader lookup, run_context *m)
{
#define GL_FUNCTION_LOAD(type, name)                                                                                               \
    gl->name = (type)lookup("gl" #name);                                                                                           \
    if (!gl->name) return fail(m, VXS_E_GL, "this OpenGL has no gl" #name ": version 4.5 is needed");
    GL_FUNCTIONS(GL_FUNCTION_LOAD)
#undef GL_FUNCTION_LOAD
    gl->lookup           = lookup;
    const char *renderer = (const char *)gl->GetString(GL_RENDERER);
    snprintf(gl->names.renderer, sizeof gl->names.renderer, "%s", renderer ? renderer : "unknown");
    return VXS_OK;
}

/* The instruction set that llvmpipe compiles for: the processor's, or a lesser one from GALLIUM_OVERRIDE_CPU_CAPS. */
static const char *cpu_class(void)
{
#if defined(__x86_64__)
    static const char *const names[] = {"sse2", "sse4.1", "avx", "avx2", "avx512"};
    const char              *most    = getenv("GALLIUM_OVERRIDE_CPU_CAPS");
    int                      found   = __builtin_cpu_supports("avx512f")  ? 4
                                       : __builtin_cpu_supports("avx2")   ? 3
                                       : __builtin_cpu_supports("avx")    ? 2
                                       : __builtin_cpu_supports("sse4.1") ? 1
                                                                          : 0;
    for (int n = 0; most && n < found; n++)
        if (!strcmp(most, names[n]) || (!n && !strncmp(most, "sse", 3) && strcmp(most, "sse4.1")) || !strcmp(most, "nosse"))
            return names[n];
    return names[found];
#else
    return "other";
#endif
}

/* OpenGL libraries are loaded when a context is made. OSMesa loads LLVM, which takes four times as long as the rest of the
 * command, and most commands draw nothing; EGL may not be installed. */
typedef struct osmesa {
    OSMesaContext (*CreateContextAttribs)(const int *attributes, OSMesaContext share);
    GLboolean (*MakeCurrent)(OSMesaContext context, void *pixels, GLenum type, GLsizei width, GLsizei height);
    gl_loader GetProcAddress;
    void (*DestroyContext)(OSMesaContext context);
} osmesa;

static int open_osmesa(osmesa *o, void *library)
{
    *(void **)&o->CreateContextAttribs = dlsym(library, "OSMesaCreateContextAttribs");
    *(void **)&o->MakeCurrent          = dlsym(library, "OSMesaMakeCurrent");
    *(void **)&o->GetProcAddress       = dlsym(library, "OSMesaGetProcAddress");
    *(void **)&o->DestroyContext       = dlsym(library, "OSMesaDestroyContext");
    return o->CreateContextAttribs && o->MakeCurrent && o->GetProcAddress && o->DestroyContext;
}

static vxs_result create_osmesa(gl_context *gl, run_context *m)
{
    static const int attributes[] = {OSMESA_FORMAT,
                                     OSMESA_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     0,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     4,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     5,
                                     0};
    osmesa           o;
    gl->library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (!gl->library || !open_osmesa(&o, gl->library))
        return fail(m, VXS_E_GL, "libOSMesa.so.8, which draws without a graphics processor, is not installed");
    gl->handle = o.CreateContextAttribs(attributes, NULL);
    if (!gl->handle) return fail(m, VXS_E_GL, "OSMesa cannot make an OpenGL 4.5 core context");
    if (!o.MakeCurrent(gl->handle, gl->pixels, GL_UNSIGNED_BYTE, 16, 16))
        return fail(m, VXS_E_GL, "OSMesa cannot make its context current");
    snprintf(gl->names.cpu_class, sizeof gl->names.cpu_class, "%s", cpu_class());
    return load_functions(gl, o.GetProcAddress, m);
}

typedef struct egl {
    PFNEGLGETPROCADDRESSPROC     GetProcAddress;
    PFNEGLGETPLATFORMDISPLAYPROC GetPlatformDisplay;
    PFNEGLINITIALIZEPROC         Initialize;
    PFNEGLBINDAPIPROC            BindAPI;
    PFNEGLCREATECONTEXTPROC      CreateContext;
    PFNEGLMAKECURRENTPROC        MakeCurrent;
    PFNEGLDESTROYCONTEXTPROC     DestroyContext;
    PFNEGLTERMINATEPROC          Terminate;
} egl;

static int open_egl(egl *e, void *library)
{
    *(void **)&e->GetProcAddress     = dlsym(library, "eglGetProcAddress");
    *(void **)&e->GetPlatformDisplay = dlsym(library, "eglGetPlatformDisplay");
    *(void **)&e->Initialize         = dlsym(library, "eglInitialize");
    *(void **)&e->BindAPI            = dlsym(library, "eglBindAPI");
    *(void **)&e->CreateContext      = dlsym(library, "eglCreateContext");
    *(void **)&e->MakeCurrent        = dlsym(library, "eglMakeCurrent");
    *(void **)&e->DestroyContext     = dlsym(library, "eglDestroyContext");
    *(void **)&e->Terminate          = dlsym(library, "eglTerminate");
    return e->GetProcAddress && e->GetPlatformDisplay && e->Initialize && e->BindAPI && e->CreateContext && e->MakeCurrent &&
           e->DestroyContext && e->Terminate;
}

/* Mesa's display, or that of the first device, which drivers other than Mesa have. */
static int open_display(gl_context *gl, const egl *e)
{
    PFNEGLQUERYDEVICESEXTPROC devices = (PFNEGLQUERYDEVICESEXTPROC)e->GetProcAddress("eglQueryDevicesEXT");
    EGLDeviceEXT              device;
    EGLint                    count = 0;
    gl->display                     = e->GetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
    if (gl->display && e->Initialize(gl->display, NULL, NULL)) return 1;
    if (!devices || !devices(1, &device, &count) || !count) return 0;
    gl->display = e->GetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, device, NULL);
    return gl->display && e->Initialize(gl->display, NULL, NULL);
}

static int is_debug(void)
{
    const char *value = getenv("VXS_GL_DEBUG");
    return value && !strcmp(value, "1");
}

static vxs_result create_egl(gl_context *gl, run_context *m)
{
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 is_debug() ? EGL_CONTEXT_FLAGS_KHR : EGL_NONE, /* EGL 1.4 has these flags, too */
                                 EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR,
                                 EGL_NONE};
    egl          e;
    gl->library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!gl->library || !open_egl(&e, gl->library))
        return fail(m, VXS_E_GL, "--gl egl needs libEGL.so.1 (version 1.5), which is not installed");
    if (!open_display(gl, &e)) return fail(m, VXS_E_GL, "EGL has no surfaceless display on this machine");
    if (!e.BindAPI(EGL_OPENGL_API) || !(gl->handle = e.CreateContext(gl->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes)) ||
        !e.MakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, gl->handle))
        return fail(m, VXS_E_GL, "EGL cannot make an OpenGL 4.5 core context");
    return load_functions(gl, (gl_loader)e.GetProcAddress, m);
}

/* VXS_GL_DEBUG=1: the first error or undefined behaviour that OpenGL reports ends the program. Running out of memory is not an
 * error of the caller, and compilers' messages are returned where programs are compiled. */
static void APIENTRY end_at_error(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length, const GLchar *text,
                                  const void *user)
{
    (void)id, (void)severity, (void)length, (void)user;
    if ((type != GL_DEBUG_TYPE_ERROR && type != GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR) || source == GL_DEBUG_SOURCE_SHADER_COMPILER ||
        strstr(text, "OUT_OF_MEMORY"))
        return;
    fprintf(stderr, "VXS_GL_DEBUG: %s\n", text);
    abort();
}

static void debug(const gl_context *gl)
{
    PFNGLDEBUGMESSAGECALLBACKPROC callback = (PFNGLDEBUGMESSAGECALLBACKPROC)gl->lookup("glDebugMessageCallback");
    if (!callback) return;
    callback(end_at_error, NULL);
    gl->Enable(GL_DEBUG_OUTPUT);
    gl->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
}

vxs_result gl_context_create(gl_context **out, gl_backend backend, uint32_t threads, run_context *m)
{
    *out           = NULL;
    gl_context *gl = calloc(1, sizeof *gl);
    if (!gl) return fail(m, VXS_E_MEMORY, "out of memory for an OpenGL context");
    gl->backend = backend;

    /* llvmpipe reads this once; 0 rasterizes on the calling thread */
    char count[16];
    snprintf(count, sizeof count, "%u", threads > 1 ? threads : 0);
    setenv("LP_NUM_THREADS", count, 1);

    vxs_result r = backend == GL_BACKEND_EGL ? create_egl(gl, m) : create_osmesa(gl, m);
    if (r != VXS_OK) {
        gl_context_destroy(gl);
        return r;
    }
    if (is_debug()) debug(gl);
    *out = gl;
    return VXS_OK;
}

void gl_context_destroy(gl_context *gl)
{
    if (!gl) return;
    osmesa o;
    egl    e;
    if (gl->backend == GL_BACKEND_EGL && gl->display && open_egl(&e, gl->library)) {
        e.MakeCurrent(gl->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (gl->handle) e.DestroyContext(gl->display, gl->handle);
        e.Terminate(gl->display);
    } else if (gl->backend != GL_BACKEND_EGL && gl->handle && open_osmesa(&o, gl->library))
        o.DestroyContext(gl->handle);
    free(gl); /* the library stays loaded: drivers may fail when unloaded */
}

gl_function gl_lookup(const char *name, void *user)
{
    return ((const gl_context *)user)->lookup(name);
}

/* programs and framebuffers ---------------------------------------------------------------------------------------------------- */

vxs_result gl_program(const gl_context *gl, GLuint *program, const gl_text *vertex, const gl_text *fragment, run_context *m)
{
    const gl_text *parts[2] = {vertex, fragment};
    GLint          linked   = 0;
    char           log[256] = "";
    *program                = gl->CreateProgram();
    for (int stage = 0; stage < 2; stage++) {
        const char *texts[GL_TEXTS_MAX];
        GLint       sizes[GL_TEXTS_MAX];
        GLsizei     count  = 0;
        GLuint      shader = gl->CreateShader(stage ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER);
        for (; parts[stage][count].text; count++) {
            texts[count] = parts[stage][count].text;
            sizes[count] = parts[stage][count].size;
        }
        gl->ShaderSource(shader, count, texts, sizes);
        gl->CompileShader(shader);
        gl->AttachShader(*program, shader);
        gl->DeleteShader(shader);
    }
    gl->LinkProgram(*program);
    gl->GetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked) return VXS_OK;
    gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
    return fail(m, VXS_E_GL, "OpenGL cannot link a shader: %s", log);
}

vxs_result gl_program_of(const gl_context *gl, GLuint *program, embedded text, gl_text before, run_context *m)
{
    return gl_program(
        gl, program, (const gl_text[]){{"#version 450 core\n#define VERTEX\n", -1}, gl_embedded(text), {0}},
        (const gl_text[]){{"#version 450 core\n", -1}, before.text ? before : (gl_text){"", 0}, gl_embedded(text), {0}}, m);
}

vxs_result gl_screen_program(const gl_context *gl, GLuint *program, const gl_text *fragment, run_context *m)
{
    static const char vertex[] =
        "#version 450 core\n"
        "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }\n";
    return gl_program(gl, program, (const gl_text[]){{vertex, -1}, {0}}, fragment, m);
}

GLuint gl_frame(const gl_context *gl, GLuint depth, const GLuint *colours, GLsizei count)
{
    static const GLenum attached[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    GLuint              frame;
    gl->GenFramebuffers(1, &frame);
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    if (depth) gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth, 0);
    for (GLsizei n = 0; n < count; n++) gl->FramebufferTexture(GL_FRAMEBUFFER, attached[n], colours[n], 0);
    gl->DrawBuffers(count, attached);
    return frame;
}
