/* Alpha-tested triangles in depth maps: holes in the alpha image leave no depth.
 * Source: alpha_mask.h defines where the surface is; the shader here computes the same in float.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOLES_PASS_H
#define HOLES_PASS_H

#include "baker/lab/opengl/gl.h"
#include "baker/light/projection.h"

/* Data shared by all blocks of a map: the program and the images. */
typedef struct hole_images {
    gl_context    *gl;
    const casters *casters;
    GLuint         program;
    GLuint        *textures; /* [casters->alpha_mask_count] 0 where the mask has no triangle */
} hole_images;

/* Upload the images of the casters' masks; no effect without masks. Returns VXS_OK, VXS_E_MEMORY, VXS_E_GL; released with
 * hole_images_free either way. */
vxs_result hole_images_init(hole_images *x, gl_context *gl, const casters *c, message *m);

/* Accepts a zeroed object. */
void hole_images_free(hole_images *x);

/* A corner as it is drawn. */
typedef struct hole_corner {
    float    clip[3];
    hole_uvq at;
} hole_corner;

/* The alpha-tested triangles of a block. */
typedef struct holed_triangles {
    const hole_images *images;
    const projection  *projection;
    hole_corner (*corners)[3]; /* [count] in the projection's order: those of a mask are adjacent */
    uint32_t *triangle;        /* [count] of the projection */
    uint32_t  count;
    GLuint    vertex_array, buffer;
} holed_triangles;

/* Allocate room for all triangles of a projection. images and p are borrowed. Returns VXS_OK or VXS_E_MEMORY; released with
 * holed_triangles_free either way. */
vxs_result holed_triangles_init(holed_triangles *t, const hole_images *images, const projection *p, message *m);

/* Accepts a zeroed object. */
void holed_triangles_free(holed_triangles *t);

/* Draw them into the bound framebuffer with the current depth test. */
void holed_triangles_draw(const holed_triangles *t);

/* Shared by the programs of this folder: compile and link one. Returns VXS_OK or VXS_E_GL. */
vxs_result make_program(gl_context *gl, GLuint *program, const char *vertex_text, const char *fragment_text, message *m);

#endif
