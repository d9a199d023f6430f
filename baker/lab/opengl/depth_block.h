/* One block of a depth map while it is rendered: a square of texels small enough for a processor's cache.
 *
 * Rendering is split where the processor would wait: `issue` submits work to OpenGL and returns, `read` waits for it, `resolve`
 * examines the result and prepares the next pass. So with two blocks in turn, the rasterizer works on one while the other is
 * resolved. Source: [CPVS16] 3.3; depth_block.c has a drawing of how exit depths are found.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DEPTH_BLOCK_H
#define DEPTH_BLOCK_H

#include "baker/columns/rendered_columns.h"
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
vxs_result hole_images_init(hole_images *x, gl_context *gl, const casters *c, run_context *m);

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
vxs_result holed_triangles_init(holed_triangles *t, const hole_images *images, const projection *p, run_context *m);

/* Accepts a zeroed object. */
void holed_triangles_free(holed_triangles *t);

/* Draw them into the bound framebuffer with the current depth test. */
void holed_triangles_draw(const holed_triangles *t);

enum { CELL_PX = 32 };

/* The maximum number of passes for a block: a texel counts no more front faces than this, and every pass removes one. */
enum { PEEL_PASSES_MAX = 255 };

/* Conversion of OpenGL's depths to depths that increase away from the light. Where OpenGL's decrease, they are negated. */
typedef struct depth_order {
    float  sign;                    /* 1, or -1 */
    float  far_gl, near_gl;         /* clear values: no caster; a depth nearer than all casters */
    GLenum nearer, nearer_or_equal; /* depth tests */
} depth_order;

/* Data shared by all blocks of a map. */
typedef struct block_context {
    gl_context *gl;
    projection  casters; /* in the map */
    hole_images images;
    depth_order order;
    exit_mode   mode;
    uint32_t    block_px;
    uint32_t    cell_side;  /* cells a side of a block */
    texel_box  *boxes;      /* [casters.triangle_count] */
    uint32_t   *candidates; /* [candidate_count] triangles that may touch the current tile, in the casters' order */
    size_t      candidate_count;
    uint32_t   *vertex_slot; /* [casters.vertex_count] slots in the block gathered last: valid if vertex_gather is its number */
    uint32_t   *vertex_gather;
    uint32_t    gather;
    GLuint      framebuffer;
    GLuint      program_depth, program_count, program_next;
    depth_stats stats;
} block_context;

/* Cells: squares of a block, skipped when they have no open texel. */
typedef enum cell_state {
    CELL_OPEN,   /* some texel's exit is not yet found */
    CELL_CLOSED, /* closed in the last pass: its texels still have to be reset */
    CELL_CLEAN   /* closed before the last pass: nothing to do */
} cell_state;

/* A rectangle of a block's texels. */
typedef struct block_rect {
    uint32_t u, v, width, height;
} block_rect;

typedef struct depth_block {
    block_context *context;
    int32_t        u0, v0;       /* texel of the map where the block starts */
    float         *enter, *exit; /* the block's corner in the map, rows of row_px texels */
    uint32_t       row_px;
    uint32_t       pass; /* of peeling */

    float    *positions; /* [3 * vertex_count] clip space */
    uint32_t *indices;   /* [3 * triangle_count] into positions */
    uint32_t *triangles; /* [triangle_count] of the projection: solids first */
    uint32_t  solid_count, triangle_count, vertex_count;
    int       has_sheets;
    int       peels; /* some solids intersect: the nearest back face may not be the exit of their union */

    holed_triangles masked; /* of the sheets, those with holes: not in triangles */

    /* [block_px * block_px] each */
    float     *sheet;    /* enter depth of sheets */
    float     *layer[2]; /* back layers of this pass and the last; before a pass, far_gl for open texels, near_gl for done ones */
    uint8_t   *count;    /* solids that are open behind the layer */
    uint8_t   *cell;     /* [cell_side^2] CELL_* */
    block_rect open;     /* holds all open cells */

    GLuint vertex_array, buffers[2];
    GLuint texture_solid, texture_sheet, texture_layer[2], texture_count;
} depth_block;

/* Returns VXS_OK, VXS_E_MEMORY, VXS_E_GL; released with depth_block_free either way. */
vxs_result depth_block_init(depth_block *b, block_context *context, run_context *m);

/* Accepts a zeroed object. */
void depth_block_free(depth_block *b);

/* Begin the block at texel (u0, v0), whose corner in the maps is at enter and exit, and gather its triangles. Returns 0 when
 * there are none: the block is filled already. exit may be enter when there are no solids. */
int depth_block_start(depth_block *b, float *enter, float *exit, uint32_t row_px, int32_t u0, int32_t v0);

/* issue: submit the next pass to OpenGL. read: wait for it and fetch its results. */
void depth_block_issue(depth_block *b);
void depth_block_read(depth_block *b);

/* Examine the results. Returns 0 when the block is done: its part of the maps is complete. */
int depth_block_resolve(depth_block *b);

#endif
