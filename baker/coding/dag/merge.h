/* Gathers the DAGs of squares into the DAG of a light ([CPVS16] 4.3).
 *
 * A square that was added is a stack: what lies over it from near to far, one reference for each slab as deep as the square is wide.
 * Equal neighbours in a stack are one run. As soon as four squares make up a larger one, their stacks become one stack of nodes; what
 * is held is the stacks of squares whose neighbours are missing. Squares that were never added are lit.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MERGE_H
#define MERGE_H

#include "baker/base/ref_table.h"
#include "baker/coding/dag/dag.h"

typedef struct stack_run {
    uint32_t ref; /* to a node of the square's level */
    uint32_t end; /* (0, slabs of the stack]: the run holds slabs up to here */
} stack_run;

typedef struct dag_stack {
    stack_run *runs; /* [count], owned; NULL: none */
    uint32_t   count;
} dag_stack;

/* A square of a map: nothing, four parts, or a stack. */
typedef struct merge_square {
    uint32_t  parts; /* index of the first of four squares; 0: none */
    dag_stack stack; /* of a square that is complete */
} merge_square;

typedef struct dag_merger {
    dag           merged; /* no roots yet */
    ref_table     table[DAG_LEVELS_MAX];
    ref_table     mask_table;
    uint32_t      map_count; /* 1 or 6 */
    int           unify;
    merge_square *squares; /* [square_count]; the whole of map m is squares[m] */
    size_t        square_count, square_capacity;
    uint32_t      spare; /* squares to be used again: parts of the first of a list; 0: none */
} dag_merger;

/* side_px    [8, 2^18] of each map and of its depth, a power of two
 * map_count  of the light: each map gets a root
 * unify      1: subtrees that are equal are kept once, wherever they come from; 0: what is added is only put side by side
 * g          [out] zeroed on failure; released with dag_merger_free.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result dag_merger_init(dag_merger *g, uint32_t side_px, uint32_t map_count, int unify);

/* Accepts a zeroed object. */
void dag_merger_free(dag_merger *g);

/* Add the DAG of a square: (i, j) of `level`, at least the DAG's own. Where the square is larger than the DAG, each of its parts is as
 * the DAG is. The result depends on the order of calls only in how nodes are numbered.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES; VXS_E_ARGUMENT when something was added there already. */
vxs_result dag_merger_add(dag_merger *g, const dag *sub, uint32_t map, uint32_t level, uint32_t i, uint32_t j);

/* Add a square without a DAG: of its slabs as deep as a square of `slab_level` (at most `level`) is wide, the first `lit_slabs` are lit, the
 * rest is in shadow. The same results. */
vxs_result dag_merger_add_split(dag_merger *g, uint32_t map, uint32_t level, uint32_t i, uint32_t j, uint32_t slab_level,
                                uint32_t lit_slabs);

/* Build what is missing above the squares. *out has one root for each map, which is a node even when the map is all lit; released with
 * dag_free. The merger is used up. */
vxs_result dag_merger_finish(dag_merger *g, dag *out);

#endif
