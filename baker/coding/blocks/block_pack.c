/* Packing blocks; see block_pack.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_pack.h"

#include <string.h>

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

static block_head head_of(const block *b)
{
    block_head h = {.depths = (uint8_t)b->depths, .has_plane = b->plane.across || b->plane.down || b->plane.least};
    for (uint32_t n = 0; n < BLOCK_TILES; n++) {
        const block_tile *t = &b->tile[n];
        h.patterned |= (uint16_t)(tile_has_pattern(t) << n);
        h.own |= (uint16_t)((t->kind == TILE_OWN) << n);
        h.planar |= (uint16_t)((t->kind == TILE_PLANE) << n);
        h.palette |= (uint16_t)((t->palette != 0) << n);
    }
    return h;
}

size_t block_pack(const block *b, uint8_t bytes[BLOCK_PACKED_MAX])
{
    const block_head h  = head_of(b);
    uint8_t         *to = put(bytes, &h, sizeof h);
    for (uint32_t rest = h.patterned; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].pattern, 4);
    for (uint32_t rest = h.own; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].base, 4);
    for (uint32_t rest = h.palette; rest; rest &= rest - 1) to = put(to, &b->tile[__builtin_ctz(rest)].palette, 2);
    to = put(to, b->depth + 1, (b->depths - 1) * sizeof *b->depth);
    if (h.has_plane) to = put(to, &b->plane, sizeof b->plane);
    const size_t size_bytes = (size_t)(to - bytes), spare = -size_bytes & 7;
    memset(to, 0, spare);
    return size_bytes + spare;
}

void block_unpack(block *b, const uint8_t *bytes)
{
    block_head     h;
    const uint8_t *from = take(&h, bytes, sizeof h);
    memset(b, 0, sizeof *b);
    b->depths = h.depths;
    for (uint32_t n = 0; n < BLOCK_TILES; n++)
        b->tile[n].kind = h.own >> n & 1         ? TILE_OWN
                          : h.patterned >> n & 1 ? TILE_PATTERN
                          : h.planar >> n & 1    ? TILE_PLANE
                                                 : TILE_UNIFORM;
    for (uint32_t rest = h.patterned; rest; rest &= rest - 1) from = take(&b->tile[__builtin_ctz(rest)].pattern, from, 4);
    for (uint32_t rest = h.own; rest; rest &= rest - 1) from = take(&b->tile[__builtin_ctz(rest)].base, from, 4);
    for (uint32_t rest = h.palette; rest; rest &= rest - 1) from = take(&b->tile[__builtin_ctz(rest)].palette, from, 2);
    from = take(b->depth + 1, from, (b->depths - 1) * sizeof *b->depth);
    if (h.has_plane) take(&b->plane, from, sizeof b->plane);
}

void block_renumber(uint8_t *bytes, const uint32_t *shared, const uint32_t *own, const int32_t *own_base)
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
        depth += own_base[was];
        base = put(base, &depth, sizeof depth);
        memcpy(pattern, &own[was], sizeof was);
    }
}

int block_patterns(const uint8_t *bytes, block_head *head, uint32_t patterns[BLOCK_TILES])
{
    const uint8_t *from  = take(head, bytes, sizeof *head);
    const int      count = __builtin_popcount(head->patterned);
    memcpy(patterns, from, (size_t)count * sizeof *patterns);
    return count;
}
