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

#include <stddef.h>
#include <stdint.h>

#include "baker/coding/dag/column_tree.h"
#include "formats/vxs_file.h"

enum { REF_LIT = VXS_REF_LIT, REF_SHADOW = VXS_REF_SHADOW, REF_FIRST = VXS_REF_FIRST, DAG_LEVELS_MAX = 16 };

typedef struct dag_node {
    uint32_t child[8];
} dag_node;

typedef struct dag_level {
    dag_node *nodes; /* [count] */
    uint64_t *hash;  /* [count] of the whole subtree under a node: equal subtrees have equal hashes, wherever they lie */
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
    uint32_t  limit; /* most nodes of a level, and masks; 0: as many as 32-bit references reach. For tests */
    int       full;  /* 1: something was not added because references had run out */
} dag;

/* Levels of the DAG of a square of side_px texels: one for 8, one more for each doubling. */
static inline uint32_t dag_levels(uint32_t side_px)
{
    return square_level(side_px) + 1;
}

void dag_free(dag *d);

/* Append; the reference, or 0 when it cannot be had: dag_failure says why. A fresh node's hash is that of its subtree. */
uint32_t dag_add_mask(dag *d, uint64_t mask);
uint32_t dag_add_node(dag *d, uint32_t level, const dag_node *node);
uint32_t dag_add_node_hashed(dag *d, uint32_t level, const dag_node *node, uint64_t hash);

/* Why something could not be added: VXS_E_REFERENCES when 32-bit references have run out, else VXS_E_MEMORY. */
vxs_result dag_failure(const dag *d);

/* The hash of a node at `level`, from its children's. */
uint64_t dag_node_hash(const dag *d, uint32_t level, const dag_node *node);

/* Nodes of all levels, masks not counted. */
uint64_t dag_node_count(const dag *d);

/* A light as it is written to a file, by a DAG whose roots are nodes, one for each of its maps; the DAG is borrowed. */
vxs_write_light dag_to_write(const vxs_light *light, const dag *d);

/* Top-down insertion in z order ([CPVS16] 3, 3.2) of a tree's square: one root for each slab as deep as the square is wide, near to far.
 * tree   is used up: built anew before it is inserted again
 * reuse  1: a volume that equals its neighbour nearer the light becomes a reference to it; 0: every volume gets nodes of its own
 * d      [out] zeroed on failure; released with dag_free
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES, or what the columns return. */
vxs_result dag_insert(dag *d, column_tree *tree, int reuse);

typedef enum compress_order { COMPRESS_NONE, COMPRESS_TOP_DOWN, COMPRESS_BOTTOM_UP } compress_order;

/* Keep one of each set of equal subtrees; the roots stay as many, equal ones refer to one node. Contents decide, never a hash alone.
 * COMPRESS_NONE       nothing is done
 * COMPRESS_TOP_DOWN   by subtree hash from the roots down, so that what lies under a dropped node is only compared ([CPVS16] 4.2)
 * COMPRESS_BOTTOM_UP  by sorting each level's contents from the masks up ([CPVS16] 4.1); the baseline
 * Returns VXS_OK or VXS_E_MEMORY (d is then as it was). */
vxs_result dag_compress(dag *d, compress_order order);

#endif
