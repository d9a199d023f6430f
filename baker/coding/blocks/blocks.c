/* Sets of palette blocks; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/blocks.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/run_control.h"
#include "formats/vxs_bytes.h"

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

/* The fewest bytes for deltas: without the zero bits that all of them end in. */
static void choose_width(block_head *h, const block *b)
{
    uint32_t       bits     = 0;
    const uint32_t greatest = (uint32_t)b->depth[b->depths - 1];
    for (uint32_t n = 1; n < b->depths; n++) bits |= (uint32_t)b->depth[n];
    h->shift = (uint8_t)common_shift(bits);
    h->width = greatest >> h->shift <= 0xff ? 0 : greatest >> h->shift <= 0xffff ? 1 : 2;
    if (h->width == 2) h->shift = 0;
}

/* Which tiles have which fields.   entries  [out] of fresh tiles, a nibble each. Returns their number */
static uint32_t head_of(block_head *h, const block *b, uint64_t *entries)
{
    uint32_t fresh = 0, last = PALETTE_MAX;
    for (uint32_t n = 0; n < BLOCK_TILES; n++) {
        const block_tile *t = &b->tile[n];
        h->mixed |= (uint16_t)(tile_has_pattern(t) << n);
        h->own |= (uint16_t)((t->kind == TILE_PRIVATE) << n);
        h->planar |= (uint16_t)((t->kind == TILE_PLANE) << n);
        h->mixed_count += (uint8_t)tile_has_pattern(t);
        h->own_count += t->kind == TILE_PRIVATE;
        if (t->kind != TILE_UNIFORM || t->palette == last) continue;
        last = t->palette;
        h->fresh |= (uint16_t)(1u << n);
        *entries |= (uint64_t)last << 4 * fresh++;
    }
    return fresh;
}

size_t block_pack(const block *b, uint8_t bytes[BLOCK_PACKED_MAX])
{
    block_head     h       = {.depths = (uint8_t)b->depths, .has_plane = b->plane.across || b->plane.down || b->plane.least};
    uint64_t       entries = 0;
    const uint32_t fresh   = head_of(&h, b, &entries);
    choose_width(&h, b);
    const size_t tail = ((b->depths - 1) << h.width) + (fresh + 1) / 2, spare = -tail & 3;
    h.tail_words = (uint8_t)((tail + spare) / 4);

    uint8_t *to = put(bytes, &h, sizeof h);
    for (uint32_t rest = h.mixed; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].pattern, 4);
    for (uint32_t rest = h.own; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].base, 4);
    if (h.has_plane) to = put(to, &b->plane, sizeof b->plane);
    for (uint32_t rest = h.mixed & ~h.own; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].palette, 2);
    for (uint32_t n = 1; n < b->depths; n++, to += 1u << h.width) vxs_store32(to, (uint32_t)b->depth[n] >> h.shift);
    vxs_store64(to, entries);
    to += (fresh + 1) / 2;
    memset(to, 0, 3 + 7);
    to += spare;
    return (size_t)(to - bytes + 7) & ~(size_t)7;
}

block_parts block_parts_of(const uint8_t *bytes)
{
    block_parts p;
    p.pattern = take(&p.head, bytes, sizeof p.head);
    p.base    = p.pattern + 4 * p.head.mixed_count;
    p.plane   = p.base + 4 * p.head.own_count;
    p.used    = p.plane + (p.head.has_plane ? sizeof(plane) : 0);
    p.tail    = p.used + 2 * (p.head.mixed_count - p.head.own_count);
    return p;
}

void block_unpack(block *b, const uint8_t *bytes)
{
    block_parts       p = block_parts_of(bytes);
    const block_head *h = &p.head;
    memset(b, 0, sizeof *b);
    b->depths = h->depths;
    if (h->has_plane) take(&b->plane, p.plane, sizeof b->plane);
    for (uint32_t n = 1; n < b->depths; n++) {
        uint32_t delta = 0;
        for (uint32_t k = 0; k < 1u << h->width; k++) delta |= (uint32_t)*p.tail++ << 8 * k;
        b->depth[n] = (int32_t)(delta << h->shift);
    }
    for (uint32_t n = 0, fresh = 0, last = 0; n < BLOCK_TILES; n++) {
        block_tile *t = &b->tile[n];
        if (h->planar >> n & 1) {
            t->kind = TILE_PLANE;
        } else if (!(h->mixed >> n & 1)) {
            if (h->fresh >> n & 1) last = p.tail[fresh / 2] >> 4 * (fresh & 1) & 15, fresh++;
            t->palette = (uint16_t)last;
        } else {
            t->kind   = h->own >> n & 1 ? TILE_PRIVATE : TILE_PATTERN;
            p.pattern = take(&t->pattern, p.pattern, 4);
            if (t->kind == TILE_PRIVATE)
                p.base = take(&t->base, p.base, 4);
            else
                p.used = take(&t->palette, p.used, 2);
        }
    }
}

void block_renumber(uint8_t *bytes, const uint32_t *shared, const uint32_t *privates, const int32_t *private_base)
{
    block_head head;
    uint8_t   *pattern = bytes + sizeof head, *base;
    memcpy(&head, bytes, sizeof head);
    base = pattern + 4 * head.mixed_count;
    for (uint32_t rest = head.mixed; rest; rest &= rest - 1, pattern += 4) {
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

enum { BETWEEN_PASSES = 64 /* patterns or blocks between calls of run_control_wait */ };

vxs_result block_set_add_uniform(block_set *s, const uniform_square *u)
{
    if (!array_reserve(&s->uniform, &s->uniform_capacity, s->uniform_count + 1, sizeof *s->uniform)) return VXS_E_MEMORY;
    s->uniform[s->uniform_count++] = *u;
    return VXS_OK;
}

vxs_result block_set_add_node(block_set *s, const block_node *n)
{
    uint32_t    fresh[NODE_BLOCKS], *to;
    int         last   = -1;
    packed_node packed = {.map   = n->map,
                          .x     = n->x,
                          .y     = n->y,
                          .emin  = n->emin,
                          .xmax  = n->xmax,
                          .slope = n->slope,
                          .mixed = n->mixed,
                          .first = s->part_count};
    if (!array_reserve(&s->nodes, &s->node_capacity, s->node_count + 1, sizeof *s->nodes) ||
        !array_reserve(&s->parts, &s->part_capacity, s->part_count + 2 * NODE_BLOCKS, sizeof *s->parts))
        return VXS_E_MEMORY;
    to = s->parts + s->part_count;
    for (uint64_t rest = n->mixed; rest; rest &= rest - 1, packed.mixed_count++) *to++ = n->block[__builtin_ctzll(rest)];
    for (uint64_t rest = n->mixed; rest; rest &= rest - 1) *to++ = (uint32_t)n->depth[__builtin_ctzll(rest)];
    for (uint64_t rest = ~n->mixed; rest; rest &= rest - 1) {
        const int b = __builtin_ctzll(rest);
        if (last >= 0 && n->depth[b] == n->depth[last]) continue;
        last = b;
        packed.fresh |= rest & -rest;
        fresh[packed.fresh_count++] = (uint32_t)n->depth[b];
    }
    memcpy(to, fresh, packed.fresh_count * sizeof *to);
    s->part_count += 2u * packed.mixed_count + packed.fresh_count;
    s->nodes[s->node_count++] = packed;
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

/* Whether many tiles are on planes of their blocks: patterns of planes may then be found that are far back. */
static int is_slanted(const block_set *s)
{
    uint64_t planar = 0;
    for (size_t n = 0; n < s->blocks.count; n++) {
        block_head h;
        memcpy(&h, intern_at(&s->blocks, (uint32_t)n), sizeof h);
        planar += (uint32_t)__builtin_popcount(h.planar);
    }
    return 4 * planar > BLOCK_TILES * s->blocks.count;
}

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
    s->privates.thorough = is_slanted(from);
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
            vxs_result     r     = intern_find_prefetched(&s->blocks, hash[n % AHEAD], intern_at(&from->blocks, found),
                                                          intern_size(&from->blocks, found), &block_ids[found]);
            if (r != VXS_OK) return r;
        }
        if (n >= count) continue;
        block_renumber(intern_at(&from->blocks, (uint32_t)n), ids->pattern, ids->privates, ids->private_base);
        hash[n % AHEAD] =
            intern_prefetch(&s->blocks, intern_at(&from->blocks, (uint32_t)n), intern_size(&from->blocks, (uint32_t)n));
    }
    return VXS_OK;
}

static vxs_result merge_nodes(block_set *s, const block_set *from, const uint32_t *block_ids)
{
    if (!from->node_count) return VXS_OK;
    if (!array_reserve(&s->nodes, &s->node_capacity, s->node_count + from->node_count, sizeof *s->nodes) ||
        !array_reserve(&s->parts, &s->part_capacity, s->part_count + from->part_count, sizeof *s->parts))
        return VXS_E_MEMORY;
    memcpy(s->parts + s->part_count, from->parts, from->part_count * sizeof *s->parts);
    for (size_t n = 0; n < from->node_count; n++) {
        packed_node *to = &s->nodes[s->node_count++];
        *to             = from->nodes[n];
        to->first += s->part_count;
        uint32_t *ids = node_parts(s, to);
        for (uint32_t k = 0; k < to->mixed_count; k++) ids[k] = block_ids[ids[k]];
    }
    s->part_count += from->part_count;
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
        if (r == VXS_OK) r = merge_nodes(s, from, block_ids);
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
    free(s->parts);
    intern_free(&s->blocks);
    pattern_set_free(&s->patterns);
    private_set_free(&s->privates);
    memset(s, 0, sizeof *s);
}
