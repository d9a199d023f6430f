/* The DAG while it is being built: nodes of eight references, kept by level in flat arrays.
 *
 *     level l      octree nodes of (8 << l)^3 voxels, children at level l - 1 in the order x + 2y + 4z
 *     level 0      slice nodes of 8 x 8 x 8 voxels, children are masks in the order of depth
 *     masks        8 x 8 x 1 voxels, a bit a texel, 1 for shadow
 *
 * A reference is REF_LIT, REF_SHADOW or REF_FIRST + index into the level below: arrays and indices, so that a level can be
 * hashed, compared and written as it lies. How nodes lie in a file is not known here (formats/vxs.md).
 * Source: [CPVS16] 3, 4.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DAG_H
#define DAG_H

#include <stdint.h>

#include "baker/base/integer.h"
#include "baker/base/message.h"
#include "baker/dag/masks.h"
#include "formats/vxs_file.h"

enum { REF_LIT = VXS_REF_LIT, REF_SHADOW = VXS_REF_SHADOW, REF_FIRST = VXS_REF_FIRST, DAG_LEVELS_MAX = 16 };

typedef struct dag_node {
    uint32_t child[8];
} dag_node;

typedef struct dag_level {
    dag_node *nodes;
    uint64_t *hash; /* of the whole subtree under a node: equal subtrees have equal hashes, wherever they lie */
    uint32_t  count, capacity;
} dag_level;

typedef struct dag {
    dag_level level[DAG_LEVELS_MAX];
    uint32_t  level_count; /* the roots are at level_count - 1 */
    uint64_t *masks;
    uint32_t  mask_count, mask_capacity;
    uint32_t *roots; /* [root_count] references to nodes of the top level, near to far */
    uint32_t  root_count;
} dag;

/* Levels of the DAG of a square of side_px texels: one for 8, one more for each doubling. */
static inline uint32_t dag_levels(uint32_t side_px)
{
    return log2_u32(side_px) - 2;
}

void dag_free(dag *d);

/* Append; the reference, or 0 when memory (or 32 bits) ran out. A fresh node's hash is that of its subtree. */
uint32_t dag_add_mask(dag *d, uint64_t mask);
uint32_t dag_add_node(dag *d, uint32_t level, const dag_node *node);
uint32_t dag_add_node_hashed(dag *d, uint32_t level, const dag_node *node, uint64_t hash);

/* The hash of a node at `level`, from its children's. */
uint64_t dag_node_hash(const dag *d, uint32_t level, const dag_node *node);

/* Nodes of all levels, masks not counted. */
uint64_t dag_node_count(const dag *d);

/* A DAG whose roots are nodes, one for each map of a light, as it is written to a file; borrowed. */
vxs_dag_view dag_view_of(const dag *d);

/* Top-down insertion in z order ([CPVS16] 3, 3.2) of the square of 8 << (level_count - 1) texels at (i, j), counted in such
 * squares: one root for each slab of that depth, near to far.
 * masks  of the same square.   reuse  1: a volume that equals its neighbour nearer the light becomes a reference to it;
 *        0: every volume gets nodes of its own, for comparison.
 * d      [out] zeroed on failure; released with dag_free.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result dag_insert(dag *d, const column_source *source, uint32_t i, uint32_t j, uint32_t level_count, const tile_masks *masks,
                      int reuse);

typedef enum compress_order { COMPRESS_TOP_DOWN, COMPRESS_BOTTOM_UP } compress_order;

/* Keep one of each set of equal subtrees; the roots stay as many, equal ones refer to one node. Contents decide, never a hash alone.
 * COMPRESS_TOP_DOWN   by subtree hash from the roots down, so that what lies under a dropped node is only compared ([CPVS16] 4.2)
 * COMPRESS_BOTTOM_UP  by sorting each level's contents from the masks up ([CPVS16] 4.1); the baseline
 * Returns VXS_OK or VXS_E_MEMORY (d is then as it was). */
vxs_result dag_compress(dag *d, compress_order order);

/* Gathers sub-DAGs into the DAG of a whole map ([CPVS16] 4.3). */
typedef struct dag_merger dag_merger;

/* side_px   of each map and of its depth;   sub_side_px  of every sub-DAG;   map_count  of the light: each gets a root
 * unify     1: subtrees that are equal in several sub-DAGs are kept once; 0: sub-DAGs are only put side by side. */
vxs_result dag_merger_create(dag_merger **g, uint32_t side_px, uint32_t sub_side_px, uint32_t map_count, int unify);

/* Add the sub-DAG of square (i, j) of a map. The result depends on the order of calls only in how nodes are numbered. */
vxs_result dag_merger_add(dag_merger *g, const dag *sub, uint32_t map, uint32_t i, uint32_t j);

/* Build the levels above the sub-DAGs; squares that were never added are lit. *out has one root for each map, which is a node even
 * when the map is all lit; released with dag_free. */
vxs_result dag_merger_finish(dag_merger *g, dag *out);

void dag_merger_destroy(dag_merger *g);

#endif
