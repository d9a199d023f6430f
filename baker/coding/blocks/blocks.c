/* Sets of palette blocks; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/blocks.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/run_control.h"
#include "baker/coding/blocks/block_pack.h"

enum { BETWEEN_PASSES = 64 };

vxs_result block_set_add_uniform(block_set *s, const uniform_square *u)
{
    if (!array_reserve(&s->uniform, &s->uniform_capacity, s->uniform_count + 1, sizeof *s->uniform)) return VXS_E_MEMORY;
    s->uniform[s->uniform_count++] = *u;
    return VXS_OK;
}

vxs_result block_set_add_node(block_set *s, const block_node *n)
{
    if (!array_reserve(&s->nodes, &s->node_capacity, s->node_count + 1, sizeof *s->nodes)) return VXS_E_MEMORY;
    s->nodes[s->node_count++] = *n;
    return VXS_OK;
}

vxs_result block_set_find(block_set *s, const block *b, uint32_t *id)
{
    uint8_t bytes[BLOCK_PACKED_MAX];
    return intern_find(&s->blocks, bytes, block_pack(b, bytes), id);
}

block block_at(const block_set *s, uint32_t id)
{
    block b;
    block_unpack(&b, intern_at(&s->blocks, id));
    return b;
}

/* New ids in `s` for the patterns of `from`, of both kinds. */
typedef struct new_ids {
    uint32_t *pattern, *own;
    int32_t  *own_base; /* added to the bases of tiles */
} new_ids;

static vxs_result merge_patterns(block_set *s, const block_set *from, new_ids *ids)
{
    mask_need needs[PALETTE_MAX - 1];
    for (int depths = 2; depths <= PALETTE_MAX; depths++) {
        const pattern_class *c = &from->patterns.by_depths[depths];
        for (size_t n = 0; n < c->count; n++) {
            run_control_wait_each(BETWEEN_PASSES, n);
            pattern_needs(&from->patterns, depths, n, needs);
            vxs_result r = pattern_find(&s->patterns, depths, needs, &ids->pattern[c->ids[n]]);
            if (r != VXS_OK) return r;
        }
    }
    for (size_t n = 0; n < from->own.count; n++) {
        run_control_wait_each(BETWEEN_PASSES, n);
        vxs_result r = own_adopt(&s->own, &from->own.patterns[n], &ids->own[n], &ids->own_base[n]);
        if (r != VXS_OK) return r;
    }
    return VXS_OK;
}

/* Blocks are renumbered in place, some of them before the loop reaches them. */
static vxs_result merge_blocks(block_set *s, block_set *from, const new_ids *ids, uint32_t *block_ids)
{
    enum { AHEAD = 16 };
    uint64_t     hash[AHEAD];
    const size_t count = from->blocks.count;
    for (size_t n = 0; n < count + AHEAD; n++) {
        run_control_wait_each(BETWEEN_PASSES, n);
        if (n >= AHEAD) {
            const uint32_t found = (uint32_t)(n - AHEAD);
            vxs_result     r     = intern_find_asked(&s->blocks, hash[n % AHEAD], intern_at(&from->blocks, found),
                                                     intern_size(&from->blocks, found), &block_ids[found]);
            if (r != VXS_OK) return r;
        }
        if (n >= count) continue;
        block_renumber(intern_at(&from->blocks, (uint32_t)n), ids->pattern, ids->own, ids->own_base);
        hash[n % AHEAD] = intern_ask(&s->blocks, intern_at(&from->blocks, (uint32_t)n), intern_size(&from->blocks, (uint32_t)n));
    }
    return VXS_OK;
}

static vxs_result merge_nodes(block_set *s, block_set *from, const uint32_t *block_ids)
{
    vxs_result r = VXS_OK;
    for (size_t n = 0; n < from->uniform_count && r == VXS_OK; n++) r = block_set_add_uniform(s, &from->uniform[n]);
    for (size_t n = 0; n < from->node_count && r == VXS_OK; n++) {
        block_node *node = &from->nodes[n];
        for (int b = 0; b < NODE_BLOCKS; b++)
            if (node->mixed >> b & 1) node->block[b] = block_ids[node->block[b]];
        r = block_set_add_node(s, node);
    }
    s->tile_count += from->tile_count;
    return r;
}

vxs_result block_set_merge(block_set *s, block_set *from)
{
    new_ids    ids       = {.pattern  = malloc((from->patterns.count + 1) * sizeof *ids.pattern),
                            .own      = malloc((from->own.count + 1) * sizeof *ids.own),
                            .own_base = malloc((from->own.count + 1) * sizeof *ids.own_base)};
    uint32_t  *block_ids = malloc((from->blocks.count + 1) * sizeof *block_ids);
    vxs_result r         = ids.pattern && ids.own && ids.own_base && block_ids ? VXS_OK : VXS_E_MEMORY;
    if (r == VXS_OK) r = merge_patterns(s, from, &ids);
    if (r == VXS_OK) r = merge_blocks(s, from, &ids, block_ids);
    if (r == VXS_OK) r = merge_nodes(s, from, block_ids);
    free(ids.pattern);
    free(ids.own);
    free(ids.own_base);
    free(block_ids);
    block_set_free(from);
    return r;
}

void block_set_free(block_set *s)
{
    free(s->uniform);
    free(s->nodes);
    intern_free(&s->blocks);
    pattern_set_free(&s->patterns);
    own_set_free(&s->own);
    memset(s, 0, sizeof *s);
}
