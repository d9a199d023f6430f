/* The OpenGL that tests and benches draw with: VXS_GL=osmesa (llvmpipe, without a variable) or VXS_GL=egl (what EGL finds, for
 * instance a graphics processor).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GL_CHOICE_H
#define GL_CHOICE_H

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/columns/rendered_columns.h"

static inline gl_backend gl_choice(void)
{
    const char *name = getenv("VXS_GL");
    if (!name || !strcmp(name, "osmesa")) return GL_BACKEND_OSMESA;
    if (!strcmp(name, "egl")) return GL_BACKEND_EGL;
    fprintf(stderr, "VXS_GL is %s: osmesa or egl\n", name);
    exit(2);
}

/* A function of OpenGL of the context that gl_choice made; "gl" begins its name.   Returns NULL where there is none */
static inline void (*gl_choice_function(const char *name))(void)
{
    static void (*(*lookup)(const char *))(void);
    if (!lookup) {
        int   is_egl  = gl_choice() == GL_BACKEND_EGL;
        void *library = dlopen(is_egl ? "libEGL.so.1" : "libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
        if (library) *(void **)&lookup = dlsym(library, is_egl ? "eglGetProcAddress" : "OSMesaGetProcAddress");
    }
    return lookup ? lookup(name) : NULL;
}

/* The same, as vxs_gl_desc and vxs_volumes_desc take it. */
static inline void (*gl_choice_proc(const char *name, void *user))(void)
{
    (void)user;
    return gl_choice_function(name);
}

#endif
