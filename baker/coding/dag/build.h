/* Builds DAGs from columns: of one square, and of a whole map.
 *
 * The descent of a map begins with the whole map. If the bounds of a square decide it, it is added to the merger with these bounds.
 * Other squares are fetched, in squares as wide as the source allows, and split further. A square that is still undecided at the
 * side of a sub-DAG is built as a DAG: masks, insertion, compression. All threads build sub-DAGs; they are merged in z order.
 * Source: [CPVS16] 3 to 4.3, 6.1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BUILD_H
#define BUILD_H

#include "baker/coding/dag/dag.h"

enum { SUB_DAG_MAX_PX = 1024 };

/* Side of a sub-DAG of a map: a quarter of the map, so that threads can share the work, and at most SUB_DAG_MAX_PX. It does not
 * depend on the size of fetched squares, because the borders of sub-DAGs decide some don't-care voxels. */
uint32_t sub_dag_side(uint32_t map_side_px);

typedef struct build_options {
    mask_rule      rule;
    int            reuse;    /* see dag_insert */
    compress_order compress; /* of each square */
    int            share;    /* 1: if all columns are equal, one part stands for all four; 0: every part gets its own nodes */

    /* NULL, or called after each step of a square, on the building thread. It may change its arguments (tests do).
     * stage  STAGE_MASKS: tree is set; STAGE_INSERT, STAGE_COMPRESS: tree is empty
     * Returns VXS_OK, or an error that ends the build. */
    vxs_result (*after)(void *user, bake_stage stage, column_tree *tree, dag *d);
    void *user;
} build_options;

enum { SQUARE_STAGES = 3 }; /* STAGE_MASKS, STAGE_INSERT, STAGE_COMPRESS */

/* Statistics of the squares that were built. */
typedef struct build_stats {
    double   seconds[SQUARE_STAGES];         /* sum over all threads */
    uint64_t mask_tiles, mask_runs;          /* 8 x 8 tiles that need masks; their masks before merging */
    uint64_t inserted_nodes, inserted_masks; /* before compression */
    uint64_t squares_built, squares_fetched;
} build_stats;

/* Build the DAG of the square (i, j) of `level` of fetched columns: masks, insertion, compression.
 * d      [out] zeroed on failure; released with dag_free
 * stats  added to
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what columns or `after` return. Threads: no shared state. */
vxs_result dag_build_square(dag *d, const column_square *columns, uint32_t level, uint32_t i, uint32_t j, const build_options *o,
                            build_stats *stats);

/* Add map `map` of a light to a merger, from its open columns.
 * stats  added to
 * ctx    threads; stages MASKS to MERGE are timed here, and a step of progress is done for each square of fetch_px
 * Returns the same, or what the map's columns return; VXS_E_ARGUMENT if its fetch_px is less than sub_dag_side. */
vxs_result dag_build_map(dag_merger *g, uint32_t map, const column_map *columns, const build_options *o, build_stats *stats,
                         bake_context *ctx);

#endif
