/* Sets of palette blocks; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/blocks.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/run_control.h"

static uint8_t *put(uint8_t *to, const void *from, size_t size_bytes)
{
    memcpy(to, from, size_bytes);
    return to + size_bytes;
}

static const uint8_t *take(void *to, const uint8_t *from, size_t size_bytes)
{
    memcpy(to, from, size_bytes);
    return from + size_bytes;
}

size_t block_pack(const block *b, uint8_t bytes[BLOCK_PACKED_MAX])
{
    block_head h = {.depths = (uint8_t)b->depths, .has_plane = b->plane.across || b->plane.down || b->plane.least};
    for (uint32_t n = 0; n < BLOCK_TILES; n++) {
        const block_tile *t = &b->tile[n];
        h.patterned |= (uint16_t)(tile_has_pattern(t) << n);
        h.own |= (uint16_t)((t->kind == TILE_PRIVATE) << n);
        h.planar |= (uint16_t)((t->kind == TILE_PLANE) << n);
        h.palette |= (uint16_t)((t->palette != 0) << n);
    }
    uint8_t *to = put(bytes, &h, sizeof h);
    for (uint32_t rest = h.patterned; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].pattern, 4);
    for (uint32_t rest = h.own; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].base, 4);
    for (uint32_t rest = h.palette; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].palette, 2);
    to = put(to, b->depth + 1, (b->depths - 1) * sizeof *b->depth);
    if (h.has_plane) to = put(to, &b->plane, sizeof b->plane);
    const size_t size_bytes = (size_t)(to - bytes), spare = -size_bytes & 7;
    memset(to, 0, spare);
    return size_bytes + spare;
}

void block_read(block_lists *b, const uint8_t *bytes)
{
    uint16_t       palette[BLOCK_TILES];
    const uint8_t *from = take(&b->head, bytes, sizeof b->head);
    from                = take(b->pattern, from, (size_t)__builtin_popcount(b->head.patterned) * sizeof *b->pattern);
    from                = take(b->base, from, (size_t)__builtin_popcount(b->head.own) * sizeof *b->base);
    from                = take(palette, from, (size_t)__builtin_popcount(b->head.palette) * sizeof *palette);
    b->depth[0]         = 0;
    from                = take(b->depth + 1, from, (b->head.depths - 1u) * sizeof *b->depth);
    memset(&b->plane, 0, sizeof b->plane);
    if (b->head.has_plane) take(&b->plane, from, sizeof b->plane);
    memset(b->palette, 0, sizeof b->palette);
    for (uint32_t n = 0, rest = b->head.palette; rest; rest &= rest - 1) b->palette[__builtin_ctz(rest)] = palette[n++];
}

void block_unpack(block *b, const uint8_t *bytes)
{
    block_lists       l;
    const block_head *h = &l.head;
    block_read(&l, bytes);
    memset(b, 0, sizeof *b);
    b->depths = h->depths;
    memcpy(b->depth, l.depth, h->depths * sizeof *b->depth);
    b->plane = l.plane;
    for (uint32_t n = 0, pattern = 0, base = 0; n < BLOCK_TILES; n++) {
        block_tile *t = &b->tile[n];
        t->palette    = l.palette[n];
        if (h->planar >> n & 1) t->kind = TILE_PLANE;
        if (!(h->patterned >> n & 1)) continue;
        t->kind    = h->own >> n & 1 ? TILE_PRIVATE : TILE_PATTERN;
        t->pattern = l.pattern[pattern++];
        if (t->kind == TILE_PRIVATE) t->base = l.base[base++];
    }
}

void block_renumber(uint8_t *bytes, const uint32_t *shared, const uint32_t *privates, const int32_t *private_base)
{
    block_head head;
    uint8_t   *pattern = bytes + sizeof head, *base;
    memcpy(&head, bytes, sizeof head);
    base = pattern + 4 * __builtin_popcount(head.patterned);
    for (uint32_t rest = head.patterned; rest; rest &= rest - 1, pattern += 4) {
        uint32_t was;
        int32_t  depth;
        memcpy(&was, pattern, sizeof was);
        if (!(head.own & rest & -rest)) {
            memcpy(pattern, &shared[was], sizeof was);
            continue;
        }
        memcpy(&depth, base, sizeof depth);
        if (private_base) depth += private_base[was];
        base = put(base, &depth, sizeof depth);
        memcpy(pattern, &privates[was], sizeof was);
    }
}

int block_patterns(const uint8_t *bytes, block_head *head, uint32_t patterns[BLOCK_TILES])
{
    const uint8_t *from  = take(head, bytes, sizeof *head);
    const int      count = __builtin_popcount(head->patterned);
    memcpy(patterns, from, (size_t)count * sizeof *patterns);
    return count;
}

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
    uint32_t *pattern, *privates;
    int32_t  *private_base; /* added to the bases of tiles */
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
    for (size_t n = 0; n < from->privates.count; n++) {
        run_control_wait_each(BETWEEN_PASSES, n);
        vxs_result r = private_adopt(&s->privates, &from->privates.patterns[n], &ids->privates[n], &ids->private_base[n]);
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
        block_renumber(intern_at(&from->blocks, (uint32_t)n), ids->pattern, ids->privates, ids->private_base);
        hash[n % AHEAD] = intern_ask(&s->blocks, intern_at(&from->blocks, (uint32_t)n), intern_size(&from->blocks, (uint32_t)n));
    }
    return VXS_OK;
}

vxs_result block_set_merge(block_set *s, block_set *from)
{
    new_ids    ids       = {.pattern      = malloc((from->patterns.count + 1) * sizeof *ids.pattern),
                            .privates     = malloc((from->privates.count + 1) * sizeof *ids.privates),
                            .private_base = malloc((from->privates.count + 1) * sizeof *ids.private_base)};
    uint32_t  *block_ids = malloc((from->blocks.count + 1) * sizeof *block_ids);
    vxs_result r         = ids.pattern && ids.privates && ids.private_base && block_ids ? VXS_OK : VXS_E_MEMORY;
    if (r == VXS_OK) r = merge_patterns(s, from, &ids);
    if (r == VXS_OK) r = merge_blocks(s, from, &ids, block_ids);
    if (r == VXS_OK) {
        for (size_t n = 0; n < from->uniform_count && r == VXS_OK; n++) r = block_set_add_uniform(s, &from->uniform[n]);
        for (size_t n = 0; n < from->node_count && r == VXS_OK; n++) {
            block_node *node = &from->nodes[n];
            for (int b = 0; b < NODE_BLOCKS; b++)
                if (node->mixed >> b & 1) node->block[b] = block_ids[node->block[b]];
            r = block_set_add_node(s, node);
        }
        s->tile_count += from->tile_count;
    }
    free(ids.pattern);
    free(ids.privates);
    free(ids.private_base);
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
    private_set_free(&s->privates);
    memset(s, 0, sizeof *s);
}
