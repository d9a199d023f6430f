/* Storage of a DAG under construction; see dag.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/dag/dag.h"

#define XXH_INLINE_ALL
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

void dag_free(dag *d)
{
    for (uint32_t l = 0; l < DAG_LEVELS_MAX; l++) {
        free(d->level[l].nodes);
        free(d->level[l].hash);
    }
    free(d->masks);
    free(d->roots);
    memset(d, 0, sizeof *d);
}

/* Twice the capacity, at most 2^32 - 2 elements since references must reach them; 0 when that cannot be had. */
static uint32_t grown(uint32_t capacity)
{
    if (!capacity) return 1024;
    return capacity > UINT32_MAX / 2 - 1 ? 0 : capacity * 2;
}

uint32_t dag_add_mask(dag *d, uint64_t mask)
{
    if (d->mask_count == d->mask_capacity) {
        uint32_t  capacity = grown(d->mask_capacity);
        uint64_t *masks    = capacity ? realloc(d->masks, capacity * sizeof *masks) : NULL;
        if (!masks) return 0;
        d->masks         = masks;
        d->mask_capacity = capacity;
    }
    d->masks[d->mask_count] = mask;
    return REF_FIRST + d->mask_count++;
}

/* The hash of a subtree as its parent at `level` refers to it. */
static uint64_t child_hash(const dag *d, uint32_t level, uint32_t ref)
{
    if (ref < REF_FIRST) return ref;
    /* a mask is hashed as it is: its parent's hash mixes it */
    return level ? d->level[level - 1].hash[ref - REF_FIRST] : d->masks[ref - REF_FIRST];
}

uint64_t dag_node_hash(const dag *d, uint32_t level, const dag_node *node)
{
    uint64_t children[8];
    for (int c = 0; c < 8; c++) children[c] = child_hash(d, level, node->child[c]);
    return XXH3_64bits(children, sizeof children);
}

uint32_t dag_add_node(dag *d, uint32_t level, const dag_node *node)
{
    return dag_add_node_hashed(d, level, node, dag_node_hash(d, level, node));
}

uint32_t dag_add_node_hashed(dag *d, uint32_t level, const dag_node *node, uint64_t hash)
{
    dag_level *l = &d->level[level];
    if (l->count == l->capacity) {
        uint32_t  capacity = grown(l->capacity);
        dag_node *nodes    = capacity ? realloc(l->nodes, capacity * sizeof *nodes) : NULL;
        if (nodes) l->nodes = nodes;
        uint64_t *hashes = capacity ? realloc(l->hash, capacity * sizeof *hashes) : NULL;
        if (hashes) l->hash = hashes;
        if (!nodes || !hashes) return 0;
        l->capacity = capacity;
    }
    l->nodes[l->count] = *node;
    l->hash[l->count]  = hash;
    return REF_FIRST + l->count++;
}

uint64_t dag_node_count(const dag *d)
{
    uint64_t count = 0;
    for (uint32_t l = 0; l < d->level_count; l++) count += d->level[l].count;
    return count;
}

vxs_dag_view dag_view_of(const dag *d)
{
    vxs_dag_view v = {.level_count = d->level_count, .masks = d->masks, .mask_count = d->mask_count};
    for (uint32_t map = 0; map < d->root_count; map++) v.roots[map] = d->roots[map] - REF_FIRST;
    for (uint32_t l = 0; l < d->level_count; l++) {
        v.nodes[l] = d->level[l].nodes ? d->level[l].nodes[0].child : NULL;
        v.count[l] = d->level[l].count;
    }
    return v;
}
