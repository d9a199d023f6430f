/* Serialization of a DAG; see dag_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/dag_file.h"

enum { NODE_BYTES = 32 };

int dag_put(const dag *d, vxs_bytes *out)
{
    int ok = put32(out, d->mask_count);
    for (uint32_t l = 0; l < d->level_count && ok; l++) ok = put32(out, d->level[l].count);
    for (uint32_t n = 0; n < d->mask_count && ok; n++) ok = put64(out, d->masks[n]);
    for (uint32_t l = 0; l < d->level_count; l++)
        for (uint32_t n = 0; n < d->level[l].count && ok; n++) ok = put32s(out, d->level[l].nodes[n].child, 8);
    return ok;
}

static vxs_result take_masks(dag *d, byte_reader *r, uint32_t count)
{
    if (!has(r, count, 8)) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < count; n++)
        if (!dag_add_mask(d, take64(r))) return dag_failure(d);
    return VXS_OK;
}

static vxs_result take_level(dag *d, byte_reader *r, uint32_t level, uint32_t count)
{
    uint32_t below = level ? d->level[level - 1].count : d->mask_count;
    if (!has(r, count, NODE_BYTES)) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < count; n++) {
        dag_node node;
        take32s(r, node.child, 8);
        for (int c = 0; c < 8; c++)
            if (node.child[c] >= REF_FIRST && node.child[c] - REF_FIRST >= below) return VXS_E_CORRUPT;
        if (!dag_add_node(d, level, &node)) return dag_failure(d);
    }
    return VXS_OK;
}

vxs_result dag_take(dag *d, byte_reader *r)
{
    uint32_t counts[DAG_LEVELS_MAX];
    if (!has(r, (uint64_t)d->level_count + 1, 4)) return VXS_E_CORRUPT;
    uint32_t masks = take32(r);
    take32s(r, counts, d->level_count);
    vxs_result result = take_masks(d, r, masks);
    for (uint32_t l = 0; l < d->level_count && result == VXS_OK; l++) result = take_level(d, r, l, counts[l]);
    return result;
}
