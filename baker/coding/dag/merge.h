/* Merges the DAGs of squares into the DAG of a light ([CPVS16] 4.3).
 *
 * An added square is stored as a stack from near to far: one reference for each slab as deep as the square is wide. Equal
 * neighbours in a stack form a run. As soon as four squares complete a larger one, their stacks become one stack of nodes. So only
 * the stacks of squares whose neighbours are missing are in memory. Squares that were never added are lit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MERGE_H
#define MERGE_H

#include "baker/base/ref_table.h"
#include "baker/coding/dag/dag.h"

typedef struct stack_run {
    uint32_t ref; /* to a node of the square's level */
    uint32_t end; /* (0, slabs of the stack]: the run ends before this slab */
} stack_run;

typedef struct dag_stack {
    stack_run *runs; /* [count], owned; NULL: none */
    uint32_t   count;
} dag_stack;

/* A square of a map: empty, four parts, or a stack. */
typedef struct merge_square {
    uint32_t  parts; /* index of the first of four squares; 0: none */
    dag_stack stack; /* of a complete square */
} merge_square;

typedef struct dag_merger {
    dag           merged; /* no roots yet */
    ref_table     table[DAG_LEVELS_MAX];
    ref_table     mask_table;
    uint32_t      map_count; /* 1 or 6 */
    int           unify;
    merge_square *squares; /* [square_count]; the whole of map m is squares[m] */
    size_t        square_count, square_capacity;
    uint32_t      spare; /* free list of squares, linked by `parts`; 0: none */
} dag_merger;

/* side_px    [8, 2^18] of each map and of its depth, a power of two
 * map_count  of the light: each map gets a root
 * unify      1: equal subtrees are stored once; 0: added DAGs are only put side by side
 * g          [out] zeroed on failure; released with dag_merger_free.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result dag_merger_init(dag_merger *g, uint32_t side_px, uint32_t map_count, int unify);

/* Accepts a zeroed object. */
void dag_merger_free(dag_merger *g);

/* Add the DAG of a square: (i, j) of `level`, at least the level of the DAG. If the square is larger than the DAG, the DAG stands
 * for each of its parts. The order of calls changes only the numbers of nodes.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES; VXS_E_ARGUMENT if the place is not empty. */
vxs_result dag_merger_add(dag_merger *g, const dag *sub, uint32_t map, uint32_t level, uint32_t i, uint32_t j);

/* Add a square without a DAG. Its slabs are as deep as a square of `slab_level` (at most `level`) is wide. The first `lit_slabs`
 * are lit, the others are in shadow. Returns the same. */
vxs_result dag_merger_add_split(dag_merger *g, uint32_t map, uint32_t level, uint32_t i, uint32_t j, uint32_t slab_level,
                                uint32_t lit_slabs);

/* Build the levels above the added squares. *out has one root for each map, which is a node even if the whole map is lit; released
 * with dag_free. The merger is empty afterwards. */
vxs_result dag_merger_finish(dag_merger *g, dag *out);

#endif
