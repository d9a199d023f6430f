/* Tiles of a block: with a single depth, with a pattern over the block palette, or with a private-palette pattern.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_TILES_H
#define VXS_PAGE_TILES_H

#include "vxs_page_block_planes.h"
#include "vxs_page_lists.h"

/* State of a block during coding. */
typedef struct block {
    _Alignas(16) int16_t depth[16];    /* of the palette entries, in the node */
    uint32_t    entries, class;        /* number of palette entries; class: a rough estimate of it, 0..4 */
    uint32_t    mixed, fresh, own, on; /* on: tiles on the plane */
    uint32_t    tiles, from_tiles;     /* where the words of tiles start: in the page, in the source */
    uint64_t    index;                 /* palette indices of fresh tiles, a nibble each */
    uint32_t    fresh_count, mixed_count, far;
    int32_t     base;
    int32_t     own_base[16];
    block_plane plane;
    sheet       sheet;    /* the plane, in the node */
    uint32_t    word;     /* where the block is in the page */
    uint32_t    from;     /* where the block is in the source */
    uint16_t    used[16]; /* palette entries used by each tile */
} block;

static int code_uniform_tile(walk *w, block *b, uint32_t t, uint32_t x0, uint32_t y0, uint32_t *last)
{
    uint32_t index = 0;
    if (b->entries > 1) {
        uint32_t in = (1u << b->entries) - 1, none = 16;
        uint32_t left = equal_depths(b->depth, w->left[y0]) & in, above = equal_depths(b->depth, w->above[8 + x0]) & in;
        left  = left ? page_first_bit(left) : none;
        above = above ? page_first_bit(above) : none;
        if (PAGE_ENCODING) {
            uint32_t shape = source_word(w, b->from), mixed = count_bits(shape & 0xffff),
                     nth  = count_bits(shape >> 16 & ((2u << t) - 1)) - 1;
            uint32_t byte = ((b->entries - 1) << (source_word(w, b->from + 1) >> 24 & 3)) + (nth & 15) / 2;
            index         = source_word(w, b->from_tiles + mixed + byte / 4) >> (8 * (byte & 3) + 4 * (nth & 1)) & 15;
            index         = index == left ? 0 : index == above ? 1 : index < b->entries ? index + 2 : 0;
        }
        uint32_t many = b->entries < 4 ? 0 : b->entries < 9 ? 1 : 2;
        index         = code_nibble(&w->c, &w->odds->index[likeness(left, above, none)][many], index);
        index         = index == 0 ? left : index == 1 ? above : index - 2;
        if (index >= b->entries) return 0;
    }
    if (index != *last) {
        b->fresh |= 1u << t;
        b->index |= (uint64_t)index << 4 * b->fresh_count++;
        *last = index;
    }
    b->used[t] = (uint16_t)(1u << index);
    draw_uniform(w, x0, y0, TILE_PX, b->depth[index]);
    return 1;
}

/* Which palette entries a tile uses; 0: none, it has a private-palette pattern. */
static uint32_t code_used(walk *w, const block *b, uint32_t t, uint32_t value, uint32_t x0, uint32_t y0)
{
    coder    c    = w->c;
    uint32_t left = depths_met(b->depth, b->entries, w->left + y0), above = depths_met(b->depth, b->entries, w->above + 8 + x0);
    uint32_t tiles = (t & 3 ? b->used[t - 1] : 0u) | (t > 3 ? b->used[t - 4] : 0u), either = left | above, used = 0;
    uint32_t span =
        /* from the first to the last entry in the borders */
        either ? (2u << page_last_bit(either)) - (1u << page_first_bit(either)) : 0;
    uint32_t low = (left & above) | ((tiles | span) & ~either);
    for (uint32_t n = 0; n < b->entries; n += 4) {
        uint32_t k = (low >> n & 15) | (either >> n & 15) << 4, more = b->entries - n;
        used |= code_nibble(&c, &w->odds->used[more < 4 ? more : 0][k], value >> n & 15) << n;
    }
    w->c = c;
    return used;
}

static int code_mixed_tile(walk *w, block *b, uint32_t t, uint32_t x0, uint32_t y0)
{
    uint32_t word = 0, used = 0, low;
    if (PAGE_ENCODING) {
        uint32_t before = count_bits(source_word(w, b->from) & ((1u << t) - 1));
        word            = source_word(w, b->from_tiles + before);
        if (!(source_word(w, b->from + 1) >> t & 1)) used = word & ((1u << b->entries) - 1);
    }
    if (b->entries > 1) used = code_used(w, b, t, used, x0, y0);
    if (used >> b->entries) return 0;
    uint32_t ref = word >> 14;
    w->tile      = b->tiles + b->mixed_count;
    if (used) {
        int16_t  depth[DEPTHS_MAX];
        uint32_t kind = 0;
        for (uint32_t bits = used; bits; bits &= bits - 1) depth[kind++] = b->depth[page_first_bit(bits)];
        if (kind < 2 || !code_pattern(w, kind, depth, &ref, x0, y0)) return 0;
        draw_pattern(w, border_of_ref(w, ref, kind), depth, x0, y0);
        low = used;
    } else {
        own_base base = {b->base, 0, b->far};
        if (PAGE_ENCODING) {
            if (b->far) {
                uint32_t shape = source_word(w, b->from), mixed = count_bits(shape & 0xffff);
                uint32_t bytes = ((b->entries - 1) << (source_word(w, b->from + 1) >> 24 & 3)) + (count_bits(shape >> 16) + 1) / 2;
                base.value     = (int32_t)source_word(w, b->from_tiles + mixed + (bytes + 3) / 4 + count_bits(b->own));
            } else
                base.value = (int32_t)(word & 0x3fff) - OWN_ZERO;
            if (base.value <= -DEPTH_END || base.value >= DEPTH_END) return 0;
        }
        if (!code_own_pattern(w, &ref, &base, x0, y0)) return 0;
        draw_own(w, ref, b->base + base.value, x0, y0);
        b->own_base[count_bits(b->own)] = base.value;
        b->own |= 1u << t;
        low = b->far ? 0 : (uint32_t)(base.value + OWN_ZERO);
    }
    b->used[t]        = (uint16_t)used;
    w->words[w->tile] = ref << 14 | low;
    b->mixed_count++;
    return 1;
}

#endif
