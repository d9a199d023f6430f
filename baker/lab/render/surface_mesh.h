/* Triangles of a scene as OpenGL draws them here.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SURFACE_MESH_H
#define SURFACE_MESH_H

#include "baker/lab/opengl/gl.h"
#include "baker/scene/scene.h"

typedef struct surface_mesh {
    GLuint  array, vertices;
    GLuint *masks;      /* [mask_count] textures of alpha */
    float  *thresholds; /* [mask_count] */
    size_t *first;      /* [mask_count + 2] triangles without a mask are before first[1], those of mask n before first[n + 2] */
    size_t  mask_count;
    double  middle_ws[3]; /* origin of positions */
    double  size_metres;  /* diagonal of the box around them */
} surface_mesh;

/* mesh  [out] released with surface_mesh_free, whatever is returned
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result surface_mesh_make(surface_mesh *mesh, gl_context *gl, const scene *s, run_context *m);

/* Draw all of it with a program that has the uniform `threshold`. */
void surface_mesh_draw(const surface_mesh *mesh, const gl_context *gl, GLuint program);

void surface_mesh_free(surface_mesh *mesh, const gl_context *gl);

#endif
