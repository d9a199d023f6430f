/* Blocks: new ones, and those met before.
 * Internal to vxs_page_*.c, which say PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_BLOCKS_H
#define VXS_PAGE_BLOCKS_H

#include "vxs_page_tiles.h"

/* The palette: how many entries, what deltas are stored as, and how far they lie apart. Deltas go to delta[entries - 1], as stored. */
static int code_palette(walk *w, block *b, uint32_t *form, uint32_t *delta)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   head = source_word(w, b->from + 1) >> 16, last = 0;
    b->entries = code_nibble(c, &odds->entries[b->class], head & 15) + 1;
    if (b->entries > PALETTE_MAX) return 0;
    b->class       = b->entries <= 2 ? b->entries - 1 : b->entries < 5 ? 2 : b->entries < 9 ? 3 : 4;
    uint32_t shift = head >> 4 & 15, width = head >> 8 & 3, far = head >> 10 & 1;
    uint32_t simple = code_nibble(c, &odds->delta_form[b->entries == 1], width || far || shift == 15 ? 15 : shift);
    if (simple == 15) {
        shift = code_nibble(c, &odds->delta_shift, shift);
        width = code_nibble(c, &odds->delta_width, width | far << 2);
        if (width > 7 || (width & 3) > 2 || ((width & 3) == 2 && shift)) return 0;
        far = width >> 2;
        width &= 3;
    } else {
        shift = simple;
        width = far = 0;
    }
    b->far       = far;
    *form        = (b->entries - 1) | shift << 4 | width << 8 | far << 10;
    uint32_t end = width == 0 ? 1 << 8 : width == 1 ? 1 << 16 : DEPTH_END;
    b->depth[0]  = (int16_t)b->base;
    for (uint32_t n = 1; n < 16; n++) b->depth[n] = 0;
    for (uint32_t n = 0; n + 1 < b->entries; n++) {
        uint32_t value = 0;
        if (PAGE_ENCODING) {
            uint32_t at = b->from + 2 + count_bits(source_word(w, b->from) & 0xffff), byte = n << width;
            value = source_word(w, at + byte / 4) >> 8 * (byte & 3) & (width == 0 ? 0xff : width == 1 ? 0xffff : ~0u);
            if (value <= last || value >= end) return 0;
        }
        value = code_step(c, width == 2 ? &odds->delta_wide : &odds->delta[shift][n > 0], odds->round, last, value - last - 1);
        if (value >= end - 1 - last || (uint64_t)(last + value + 1) << shift >= DEPTH_END) return 0;
        delta[n]        = last += value + 1;
        b->depth[n + 1] = (int16_t)(b->base + (int32_t)(last << shift));
    }
    return 1;
}

/* A new block at w->word. base: in the node; from: word of the source. */
static int code_block(walk *w, int32_t base, uint32_t from, uint32_t x0, uint32_t y0)
{
    block    b = {.base  = base,
                  .word  = w->word,
                  .from  = from,
                  .class = varied(w->left + y0, BLOCK_PX) | varied(w->above + 8 + x0, BLOCK_PX) << 1};
    uint32_t form, delta[PALETTE_MAX], last = 16;
    if (!code_palette(w, &b, &form, delta)) return 0;
    for (uint32_t y = 0; y < 4; y++) {
        const int16_t *above = w->above + 8 + x0;
        uint32_t       k     = varied(w->left + y0 + 8 * y, TILE_PX) << 4 | (uint32_t)(w->left[y0 + 8 * y] != above[0]) << 5;
        for (uint32_t x = 0; x < 4; x++) k |= varied(above + 8 * x, TILE_PX) << x;
        uint32_t row = code_nibble(&w->c, &w->odds->block_mixed[b.class][k], source_word(w, from) >> 4 * y & 15);
        b.mixed |= row << 4 * y;
        if (2 + count_bits(b.mixed) > w->node_words - b.word) return 0;
        for (uint32_t x = 0; x < 4; x++) {
            uint32_t t = x + 4 * y;
            if (!(row >> x & 1 ? code_mixed_tile(w, &b, t, x0 + 8 * x, y0 + 8 * y)
                               : code_uniform_tile(w, &b, t, x0 + 8 * x, y0 + 8 * y, &last)))
                return 0;
        }
    }
    uint32_t width = form >> 8 & 3, at = b.word + 2 + b.mixed_count, byte = 4 * at, owns = b.far ? count_bits(b.own) : 0;
    uint32_t bytes = ((b.entries - 1) << width) + (b.fresh_count + 1) / 2;
    if (2 + b.mixed_count + (bytes + 3) / 4 + owns > w->node_words - b.word) return 0;
    w->words[b.word]     = b.mixed | b.fresh << 16;
    w->words[b.word + 1] = b.own | form << 16;
    for (uint32_t n = 0; n + 1 < b.entries; n++)
        for (uint32_t k = 0; k < 1u << width; k++) put_byte(w->words, byte++, delta[n] >> 8 * k);
    for (uint32_t n = 0; n < b.fresh_count; n += 2) put_byte(w->words, byte++, b.index >> 4 * n & 0xff);
    at += (bytes + 3) / 4;
    for (uint32_t n = 0; n < owns; n++) w->words[at++] = (uint32_t)b.own_base[n];
    w->word = at;
    return 1;
}

/* The borders of a block that was met before: of its last row and its last column of tiles. */
static void draw_block(walk *w, uint32_t word, int32_t base, uint32_t x0, uint32_t y0)
{
    const uint32_t *words = w->words;
    uint32_t        shape = words[word], head = words[word + 1], mixed = shape & 0xffff, entries = (head >> 16 & 15) + 1;
    uint32_t        shift = head >> 20 & 15, width = head >> 24 & 3, byte = 4 * (word + 2 + count_bits(mixed)),
             index_byte = byte + ((entries - 1) << width);
    int16_t depth[16]   = {(int16_t)base};
    for (uint32_t n = 0; n + 1 < entries; n++) {
        uint32_t delta = 0;
        for (uint32_t k = 0; k < 1u << width; k++) delta |= get_byte(words, byte + (n << width) + k) << 8 * k;
        depth[n + 1] = (int16_t)(base + (int32_t)(delta << shift));
    }
    for (uint32_t t = 0; t < 16; t++) {
        uint32_t x = x0 + 8 * (t & 3), y = y0 + 8 * (t >> 2);
        if ((t & 3) != 3 && t < 12) continue;
        if (!(mixed >> t & 1)) {
            uint32_t nth = count_bits(shape >> 16 & ((2u << t) - 1)) - 1;
            draw_uniform(w, x, y, TILE_PX, depth[get_byte(words, index_byte + nth / 2) >> 4 * (nth & 1) & 15]);
            continue;
        }
        uint32_t tile = words[word + 2 + count_bits(mixed & ((1u << t) - 1))], ref = tile >> 14, half = ref & (REF_COMMON - 1);
        const uint32_t      *pool = ref & REF_COMMON ? w->common->words : words;
        _Alignas(16) uint8_t index[64];
        vxs_pattern          pattern = {0};
        if (!(head >> t & 1)) {
            int16_t  used[DEPTHS_MAX];
            uint32_t kind = 0;
            for (uint32_t bits = tile & 0x3fff; bits; bits &= bits - 1) used[kind++] = depth[page_first_bit(bits)];
            read_pattern(pool, half, kind, index);
            draw_pattern(w, border_of(index), used, x, y);
            continue;
        }
        int32_t own = (int32_t)(tile & 0x3fff) - OWN_ZERO;
        if (head >> 26 & 1) {
            uint32_t bytes = ((entries - 1) << width) + (count_bits(shape >> 16) + 1) / 2;
            own            = (int32_t)words[byte / 4 + (bytes + 3) / 4 + count_bits(head & ((1u << t) - 1))];
        }
        uint32_t first = get_half(pool, half), depths = first & 0xff;
        if (first >> 12 <= OWN_WORDS) {
            read_pattern(pool, half + 1 + own_delta_halves(first >> 12, depths - 1), depths, index);
            pattern.border = border_of(index);
        }
        draw_own(w, pool, &pattern, half, base + own, x, y);
    }
}

/* A mixed block of a node: its base, and where it is. */
static int code_block_of(walk *w, int wide, uint32_t x0, uint32_t y0, uint32_t *ref, uint32_t *base)
{
    int32_t  like  = least_border_depth(w, x0, y0, BLOCK_PX), off;
    uint32_t place = 0, high = 0;
    if (like == INT16_MAX) like = 0;
    if (PAGE_ENCODING) place = w->block_rank[*ref];
    place = code_number(&w->c, &w->odds->block, place);
    off   = code_signed(&w->c, &w->odds->base, (int16_t)(*base - (uint32_t)like));
    if (wide) high = code_number(&w->c, &w->odds->high, *base >> 16);
    if (high >= DEPTH_END >> 16) return 0;
    *base = ((uint32_t)(like + off) & 0xffff) | high << 16;
    if (!place) {
        uint32_t word = w->word, from = *ref;
        *ref = word;
        if (w->blocks == VXS_PAGE_WORDS_MAX / 2 || word + 2 > w->node_words) return 0;
        w->s->block[w->blocks++] = (uint16_t)word;
        if (PAGE_ENCODING) w->block_rank[word] = w->blocks;
        return code_block(w, (int32_t)*base, from, x0, y0);
    }
    if (place > w->blocks) return 0;
    uint16_t *list = w->s->block, *from = list + place - 1, *to = list + (place - 1) / 2, other = *to;
    *to   = *from;
    *from = other;
    if (PAGE_ENCODING) {
        w->block_rank[*from] = (uint32_t)(from - list) + 1;
        w->block_rank[*to]   = (uint32_t)(to - list) + 1;
    }
    draw_block(w, *ref = *to, (int32_t)*base, x0, y0);
    return 1;
}

#endif
