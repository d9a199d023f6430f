/* Columns that a renderer draws, with OpenGL for instance (baker/lab/opengl): what a bake needs of it. A program without a renderer bakes
 * straight from triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDERED_COLUMNS_H
#define RENDERED_COLUMNS_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

struct casters;
struct depth_maps;

typedef enum gl_backend { GL_BACKEND_OSMESA, GL_BACKEND_EGL } gl_backend;

/* How exit depths are found. */
typedef enum exit_mode {
    EXIT_AUTO, /* peel where solids meet, as casters_find_meeting knows them: the same depths as EXIT_PEEL */
    EXIT_PEEL, /* exit depth of the union of solids, by depth peeling */
    EXIT_BACK  /* the nearest back face: never behind the true exit, often before it */
} exit_mode;

/* What rendering took. */
typedef struct depth_stats {
    uint64_t blocks_rendered, blocks_empty; /* blocks are the squares that are rendered at once */
    uint64_t blocks_peeled;                 /* of those rendered */
    uint64_t blocks_not_peeled;             /* of those rendered: they have solids, and none that needs it */
    uint64_t triangles_drawn;               /* over all passes */
    uint64_t peel_passes;                   /* over all blocks */
    uint32_t peel_passes_max;               /* of the block that took most */
} depth_stats;

/* Sides of tiles; and of a tile, of the blocks that are drawn at once, and how many triangles a draw has at most: the plan counts on them. */
enum { TILE_MIN_PX = 512, TILE_MAX_PX = 4096, BLOCK_MAX_PX = 512, DRAW_MAX = 1 << 19 };

/* Gets the depth maps of each tile that is rendered: tile (i, j), counted in tiles, of map `map`.
 * Returns VXS_OK, or what ends the fetch. */
typedef vxs_result tile_watcher(void *user, uint32_t map, uint32_t i, uint32_t j, const struct depth_maps *tile, bake_context *ctx);

/* A light whose maps are rendered. Zero what is not set. */
typedef struct rendered_columns {
    void                 *device;       /* of column_renderer.create; borrowed, as is all that follows */
    const struct casters *casters;      /* that the light may reach */
    const vxs_light      *light;        /* fitted */
    exit_mode             exit;         /* how exit depths are found */
    int                   has_exit_map; /* 0: nothing is a solid, and x = e */
    uint32_t      tile_px; /* [TILE_MIN_PX, TILE_MAX_PX] a power of two: side of the squares that are rendered at once, at most */
    tile_watcher *watch;   /* NULL: none */
    void         *watch_user;

    depth_stats        stats; /* [out] of maps that were closed */
    struct depth_maps *spare; /* the renderer's: memory of the map that was closed last, for the next one */
} rendered_columns;

/* What draws, as reports name it. */
typedef struct device_names {
    char renderer[128];
    char cpu_class
        [16]; /* of a software renderer: the instructions that it draws with, by which depths may differ in a few texels; else "" */
} device_names;

typedef struct column_renderer {
    /* device  [out] used by the calling thread alone, until destroy. threads  of a software renderer
     * Returns VXS_OK, VXS_E_GL (the message says what is missing), or VXS_E_MEMORY. */
    vxs_result (*create)(void **device, device_names *names, gl_backend backend, uint32_t threads, message *m);
    void (*destroy)(void *device);

    /* The source; borrows the columns. Maps are closed before `free`. All calls on the thread that made the device. */
    column_source (*source)(rendered_columns *c);
    void (*free)(rendered_columns *c);
} column_renderer;

#endif
