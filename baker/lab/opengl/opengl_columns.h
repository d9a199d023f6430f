/* The maps of a light rendered with OpenGL: a column source.
 *
 * Squares are fetched by rendering depth maps of a tile and reducing them to a pyramid. Before, it is known only where no caster is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPENGL_COLUMNS_H
#define OPENGL_COLUMNS_H

#include "baker/lab/opengl/depth_gl.h"

/* Shown the depth maps of each tile that is rendered: tile (i, j), counted in tiles, of map `map`.
 * Returns VXS_OK, or what ends the fetch. */
typedef vxs_result tile_watcher(void *user, uint32_t map, uint32_t i, uint32_t j, const depth_maps *tile, bake_context *ctx);

typedef struct opengl_columns {
    gl_context      *gl;           /* borrowed, as is all that follows */
    const casters   *casters;      /* that the light may reach */
    const vxs_light *light;        /* fitted */
    exit_mode        exit;         /* how exit depths are found */
    int              has_exit_map; /* 0: nothing is a solid, and x = e */
    uint32_t      tile_px; /* [TILE_MIN_PX, TILE_MAX_PX] a power of two: side of the squares that are rendered at once, at most */
    tile_watcher *watch;   /* NULL: nobody watches */
    void         *watch_user;

    depth_stats stats; /* [out] of maps that were closed */
    depth_maps  spare; /* of the map that was closed last, for the next one; zero it */
} opengl_columns;

enum { TILE_MIN_PX = 512, TILE_MAX_PX = 4096 };

/* The source; borrowed. Maps are closed before opengl_columns_free. All calls on the thread that owns the OpenGL context. */
column_source opengl_columns_source(opengl_columns *o);

void opengl_columns_free(opengl_columns *o);

/* All of OpenGL that a bake asks for, as a value: a program that has no such value is linked without OpenGL. */
typedef struct opengl_rendering {
    vxs_result (*create)(gl_context **gl, gl_backend backend, uint32_t threads, message *m); /* gl_context_create, and so on */
    void (*destroy)(gl_context *gl);
    column_source (*source)(opengl_columns *o);
    void (*free)(opengl_columns *o);
} opengl_rendering;

extern const opengl_rendering opengl_rendered;

#endif
