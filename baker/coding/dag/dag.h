/* A DAG during the build: nodes of eight references, in one flat array for each level.
 *
 *     level l      octree nodes of (8 << l)^3 voxels, children at level l - 1 in the order x + 2y + 4z
 *     level 0      slice nodes of 8 x 8 x 8 voxels, children are masks in the order of depth
 *     masks        8 x 8 x 1 voxels, one bit per texel, 1 for shadow
 *
 * A reference is REF_LIT, REF_SHADOW, or REF_FIRST + index into the level below. References are indices, not pointers, so that a
 * level can be hashed, compared and written as an array. The layout in a file is separate (formats/vxs.md).
 * Source: [CPVS16] 3, 4.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DAG_H
#define DAG_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/byte_stream.h"
#include "baker/base/ref_table.h"
#include "baker/coding/dag/column_tree.h"
#include "formats/vxs_write_file.h"

enum { REF_LIT = VXS_REF_LIT, REF_SHADOW = VXS_REF_SHADOW, REF_FIRST = VXS_REF_FIRST, DAG_LEVELS_MAX = 16 };

typedef struct dag_node {
    uint32_t child[8];
} dag_node;

typedef struct dag_level {
    dag_node *nodes; /* [count] */
    uint64_t *hash;  /* [count] of the whole subtree under a node: equal subtrees have equal hashes */
    uint32_t  count; /* [0, 2^32 - 3] */
    size_t    node_capacity, hash_capacity;
} dag_level;

typedef struct dag {
    dag_level level[DAG_LEVELS_MAX];
    uint32_t  level_count; /* [1, DAG_LEVELS_MAX] the roots are at level_count - 1 */
    uint64_t *masks;       /* [mask_count] */
    uint32_t  mask_count;  /* [0, 2^32 - 3] */
    size_t    mask_capacity;
    uint32_t *roots; /* [root_count] references to nodes of the top level, near to far */
    uint32_t  root_count;
    uint32_t  limit; /* most nodes of a level, and most masks; 0: what 32-bit references can address. For tests */
    int       full;  /* 1: something was not added, because references ran out */
} dag;

/* Levels of the DAG of a square of side_px texels: one for 8, one more for each doubling. */
static inline uint32_t dag_levels(uint32_t side_px)
{
    return square_level(side_px) + 1;
}

void dag_free(dag *d);

/* Append a mask or a node. Return its reference; 0 on failure: see dag_failure. dag_add_node computes the hash of the subtree. */
uint32_t dag_add_mask(dag *d, uint64_t mask);
uint32_t dag_add_node(dag *d, uint32_t level, const dag_node *node);
uint32_t dag_add_node_hashed(dag *d, uint32_t level, const dag_node *node, uint64_t hash);

/* Error of a failed dag_add_mask or dag_add_node: VXS_E_REFERENCES if 32-bit references ran out, else VXS_E_MEMORY. */
vxs_result dag_failure(const dag *d);

/* Hash of a node at `level`, from the hashes of its children. */
uint64_t dag_node_hash(const dag *d, uint32_t level, const dag_node *node);

/* Nodes of all levels, without masks. */
uint64_t dag_node_count(const dag *d);

/* A light for the file writer. The DAG has one root for each map, all of them nodes; it is borrowed. */
vxs_write_light dag_to_write(const vxs_light *light, const dag *d);

/* Top-down insertion in z order ([CPVS16] 3, 3.2) of a tree's square: one root for each slab as deep as the square is wide, near
 * to far.
 * tree   used up: build it again before another insertion
 * reuse  1: a volume equal to its neighbour nearer to the light becomes a reference to it; 0: every volume gets its own nodes
 * d      [out] zeroed on failure; released with dag_free
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the columns return. */
vxs_result dag_insert(dag *d, column_tree *tree, int reuse);

typedef enum compress_order { COMPRESS_NONE, COMPRESS_TOP_DOWN, COMPRESS_BOTTOM_UP } compress_order;

/* Keep one of each set of equal subtrees. The number of roots does not change; equal roots refer to one node. Contents are always
 * compared, never only hashes.
 * COMPRESS_NONE       does nothing
 * COMPRESS_TOP_DOWN   by subtree hash from the roots down; the subtree of a dropped node is only compared ([CPVS16] 4.2)
 * COMPRESS_BOTTOM_UP  by sorting the contents of each level from the masks up ([CPVS16] 4.1); the baseline
 * Returns VXS_OK or VXS_E_MEMORY (d is then unchanged). */
vxs_result dag_compress(dag *d, compress_order order);

/* Serialization of the masks and nodes of a DAG.
 *
 *     counts of masks, and of the nodes of each level, 4 bytes each
 *     masks, 8 bytes each; nodes of each level, slice nodes first, 8 references of 4 bytes each
 * */

/* Append the masks and nodes of a DAG. The caller stores its roots and level_count. Returns 0 without memory. */
int dag_put(const dag *d, vxs_bytes *out);

/* Read masks and nodes into an empty DAG whose level_count is set. Checks that all references are in range.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result dag_take(dag *d, byte_reader *r);

/* Merges the DAGs of squares into the DAG of a light ([CPVS16] 4.3).
 *
 * An added square is stored as a stack from near to far: one reference for each slab as deep as the square is wide. Equal
 * neighbours in a stack form a run. As soon as four squares complete a larger one, their stacks become one stack of nodes. So only
 * the stacks of squares whose neighbours are missing are in memory. Squares that were never added are lit. */

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
