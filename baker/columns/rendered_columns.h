/* Columns from a renderer, for instance OpenGL (baker/lab/opengl): the interface that a bake needs. A program without a renderer
 * bakes straight from triangles.
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
    EXIT_AUTO, /* peel where solids meet (casters_find_meeting): the same depths as EXIT_PEEL */
    EXIT_PEEL, /* exit depth of the union of solids, by depth peeling */
    EXIT_BACK  /* the nearest back face: never behind the true exit, often before it */
} exit_mode;

/* Statistics of the rendering. */
typedef struct depth_stats {
    uint64_t blocks_rendered, blocks_empty; /* a block is a square that is rendered at once */
    uint64_t blocks_peeled;                 /* of those rendered */
    uint64_t blocks_not_peeled;             /* of those rendered: they have solids, but none that needs peeling */
    uint64_t triangles_drawn;               /* over all passes */
    uint64_t peel_passes;                   /* over all blocks */
    uint32_t peel_passes_max;               /* of the block with the most passes */
} depth_stats;

/* Least and greatest side of a tile; greatest side of a block, which is drawn at once; most triangles of a draw. The plan uses
 * them too. */
enum { TILE_MIN_PX = 512, TILE_MAX_PX = 4096, BLOCK_MAX_PX = 512, DRAW_MAX = 1 << 19 };

/* Enter depths of a rendered tile. */
typedef struct rendered_tile {
    uint32_t     side_px;
    depth_scale  scale; /* of the depths */
    const float *enter; /* [side_px^2] rows */
} rendered_tile;

/* Called with the depths of each rendered tile: tile (i, j), counted in tiles, of map `map`.
 * Returns VXS_OK, or an error that ends the fetch. */
typedef vxs_result tile_watcher(void *user, uint32_t map, uint32_t i, uint32_t j, const rendered_tile *tile, bake_context *ctx);

/* A light whose maps are rendered. Zero other fields. */
typedef struct rendered_columns {
    void                 *device;  /* from column_renderer.create; borrowed, like all that follows */
    const struct casters *casters; /* that the light may reach */
    const vxs_light      *light;   /* fitted */
    exit_mode             exit;
    int                   has_exit_map; /* 0: nothing is a solid, and x = e */
    uint32_t      tile_px; /* [TILE_MIN_PX, TILE_MAX_PX] a power of two: greatest side of a square that is rendered at once */
    tile_watcher *watch;   /* NULL: none */
    void         *watch_user;

    depth_stats        stats; /* [out] of closed maps */
    struct depth_maps *spare; /* owned by the renderer: memory of the map closed last, for the next one */
} rendered_columns;

/* The renderer, as reports name it. */
typedef struct device_names {
    char renderer[128];
    char cpu_class[16]; /* software renderers: instruction set, which may change a few depths; else "" */
} device_names;

typedef struct column_renderer {
    /* device  [out] used by the calling thread alone, until destroy.   threads  for a software renderer
     * Returns VXS_OK, VXS_E_GL (the message names what is missing), or VXS_E_MEMORY. */
    vxs_result (*create)(void **device, device_names *names, gl_backend backend, uint32_t threads, run_context *m);
    void (*destroy)(void *device);

    /* The source; borrows c. Close its maps before `free`. Call all functions on the thread that created the device. */
    column_source (*source)(rendered_columns *c);
    void (*free)(rendered_columns *c);
} column_renderer;

#endif
