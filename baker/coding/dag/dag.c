/* Storage of a DAG under construction; see dag.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/dag.h"

#define XXH_INLINE_ALL
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "baker/base/array.h"

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

/* Whether there is a reference for one more of `count` elements. */
static int has_room(dag *d, uint32_t count)
{
    uint32_t limit = d->limit ? d->limit : UINT32_MAX - REF_FIRST;
    if (count < limit) return 1;
    d->full = 1;
    return 0;
}

vxs_result dag_failure(const dag *d)
{
    return d->full ? VXS_E_REFERENCES : VXS_E_MEMORY;
}

uint32_t dag_add_mask(dag *d, uint64_t mask)
{
    if (!has_room(d, d->mask_count)) return 0;
    if (!array_reserve(&d->masks, &d->mask_capacity, (size_t)d->mask_count + 1, sizeof *d->masks)) return 0;
    d->masks[d->mask_count] = mask;
    return REF_FIRST + d->mask_count++;
}

/* The hash of a child of a node at `level`. */
static uint64_t child_hash(const dag *d, uint32_t level, uint32_t ref)
{
    if (ref < REF_FIRST) return ref;
    /* a mask is its own hash: its parent's hash mixes it */
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
    dag_level *l     = &d->level[level];
    size_t     count = (size_t)l->count + 1;
    if (!has_room(d, l->count)) return 0;
    if (!array_reserve(&l->nodes, &l->node_capacity, count, sizeof *l->nodes)) return 0;
    if (!array_reserve(&l->hash, &l->hash_capacity, count, sizeof *l->hash)) return 0;
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

vxs_write_light dag_to_write(const vxs_light *light, const dag *d)
{
    vxs_write_light w = {.light = *light, .dag = {.level_count = d->level_count, .masks = d->masks, .mask_count = d->mask_count}};
    w.light.coding    = VXS_CODING_DAG;
    for (uint32_t map = 0; map < d->root_count; map++) w.dag.roots[map] = d->roots[map] - REF_FIRST;
    for (uint32_t l = 0; l < d->level_count; l++) {
        w.dag.nodes[l] = d->level[l].nodes ? d->level[l].nodes[0].child : NULL;
        w.dag.count[l] = d->level[l].count;
    }
    return w;
}
