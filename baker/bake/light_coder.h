/* The seam between columns and words: a coding turns the maps of a light into words. The bake uses codings only through this
 * interface. With the two codings, the one that the options choose, and the file that coded lights become.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_CODER_H
#define LIGHT_CODER_H

#include "baker/bake/bake_options.h"
#include "baker/bake/light_picture.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/coding/dag/build.h"
#include "baker/columns/columns.h"
#include "formats/vxs_write_file.h"

/* A light in its coding. */
typedef struct coded_light {
    vxs_write_light written;      /* borrows from `owned` */
    uint64_t        memory_bytes; /* approximate memory that lookups read, enough to rank lights by size before they are encoded */
    void           *owned;
    void (*free)(void *owned);
} coded_light;

/* Accepts a zeroed object. */
static inline void coded_light_free(coded_light *c)
{
    if (c->free) c->free(c->owned);
    *c = (coded_light){0};
}

/* A coding that works on one light: begin, add_map once for each map, finish. All return VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
typedef struct light_coder {
    void *data; /* of the coding; released by its creator */

    /* light  fitted; borrowed until the coder has finished */
    vxs_result (*begin)(void *data, const vxs_light *light);

    /* columns  of map `map`, open
     * ctx      threads; stages MASKS to MERGE are timed here, and a step of progress is done for each square of fetch_px
     * Returns also what the columns return. */
    vxs_result (*add_map)(void *data, uint32_t map, const column_map *columns, bake_context *ctx);

    /* out  [out] written only if VXS_OK is returned; released with coded_light_free */
    vxs_result (*finish)(void *data, coded_light *out);
} light_coder;

/* A light's maps as palette blocks: baker/coding/blocks/ behind the seam of light_coder.h. */

/* Contents of a light's words; equal things in a page are counted once. */
typedef struct palette_counts {
    uint64_t pages, nodes, blocks;
    uint64_t tiles, private_tiles; /* with patterns; those of them with a private palette */
    uint64_t patterns;             /* of both kinds, in pages and common ones */
} palette_counts;

typedef struct blocks_coder {
    const vxs_light *light; /* NULL: not begun */
    block_set        set;
    build_stats      stats;  /* tiles and squares */
    palette_counts   counts; /* set by finish */
    uint32_t         threads;
    uint32_t         packing; /* VXS_PACKING_* */
} blocks_coder;

/* A light's maps as a DAG: baker/coding/dag/ behind the seam of light_coder.h. */

typedef struct dag_coder {
    build_options    build;
    int              unify;   /* 1: one DAG without equal subtrees; 0: sub-DAGs side by side */
    light_picture   *picture; /* NULL, or where masks are drawn; borrowed */
    const vxs_light *light;   /* NULL: not begun */
    dag_merger       merger;
    build_stats      stats; /* of all maps so far */

    uint32_t            map; /* map in work */
    const bake_context *ctx; /* run context during add_map */
} dag_coder;

/* The coding that the options choose, behind the seam of light_coder.h. */

typedef struct chosen_coder {
    dag_coder          dags;
    blocks_coder       blocks;
    light_coder        coder;
    const build_stats *stats; /* of the chosen coding */
} chosen_coder;

/* compress  order of compression from the plan, for DAGs
 * picture   NULL, or where masks of DAGs are drawn; borrowed
 * c         [out] must not move until chosen_coder_free */
void chosen_coder_init(chosen_coder *c, const bake_options *o, compress_order compress, light_picture *picture);

void chosen_coder_free(chosen_coder *c);

#endif
