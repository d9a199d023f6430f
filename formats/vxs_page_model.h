/* Symbols of a page, in their order: one text for encoder and decoder. Internal to vxs_page_*.c, which define
 * PAGE_ENCODING. Not installed.
 *
 * The walk goes from node to node, block to block, tile to tile, and writes each record to its place in `words`. The decoder
 * makes the page in this way. The encoder makes a second page, which must be equal to the given one; it reads the values to
 * code from `source`, which is unchecked.
 *
 * Values are predicted from the depths of the texels around the next record (vxs_page_borders.h).
 *
 *     node     slope; which blocks are mixed, four per nibble; depths of uniform blocks: that of the left, upper or last block,
 *              or another
 *     block    known (the last one in its row or column, or its rank in a list, where a used entry moves half the way to the
 *              front) or new. A new block: whether it has a plane, in the context of its neighbours; its slopes, equal or
 *              similar to those of a neighbour; and its depth, which continues or meets its neighbours. Base, from the plane,
 *              or from the least depth around the block. Then, unless all tiles are on the plane: the palette; for each row of
 *              four tiles which are on the plane, in the context of whether that fits, and which are mixed; for uniform tiles
 *              the palette index, as depths above
 *     tile     which palette entries are used, four per nibble, in the context of the borders; none: a private-palette pattern.
 *              Then the pattern: new, from the common pool, or known by its rank in the list of its kind; patterns of planes
 *              also as the last one in the row or column, or as one of those used last
 *     pattern  four texels per nibble: which differ from the texel above; then, with more than two depths, the indices of these
 *     depths   without a palette: a nibble each, the difference from left + above - (left of above)
 *     planes   of a tile: slopes, from the planes beside it; base of the tile, so that they meet their neighbours; a mask as a
 *              pattern
 *
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_MODEL_H
#define VXS_PAGE_MODEL_H

#include "vxs_page_tiles.h"

/* blocks: new ones, and known ones ---------------------------------------------------------------------------------------------- */

/* The last delta of a palette, if it leads to a depth beside the block: to the greatest one, the lowest one on the left, or the last
 * one above. 0: it does not.   last  the delta before;   value  the delta, for the encoder */
static uint32_t code_last_depth(walk *w, int32_t base, uint32_t shift, uint32_t last, uint32_t value, uint32_t end, uint32_t x0,
                                uint32_t y0)
{
    int32_t from[3] = {(int16_t)(greatest_border_depth(w, x0, y0) - base), (int16_t)(w->left[y0 + BLOCK_PX - 1] - base),
                       (int16_t)(w->above[8 + x0 + BLOCK_PX - 1] - base)}; /* the base */
    if (from[0] <= (int32_t)(last << shift)) return 0;
    uint32_t k = (uint32_t)(from[1] == from[0]) + 2 * (uint32_t)(from[2] == from[0]), place = 0;
    while (PAGE_ENCODING && place < 3 && from[place] != (int32_t)(value << shift)) place++;
    place = code_nibble(&w->c, &w->odds->last_depth[k], place < 3 ? place : 15);
    if (place >= 3) return 0;
    int32_t delta = from[place] >> shift;
    return delta > (int32_t)last && delta < (int32_t)end && delta * (1 << shift) == from[place] ? (uint32_t)delta : ~0u;
}

/* The palette: number of entries, width of the deltas, and the deltas.   delta  [entries - 1] out, as stored */
static int code_palette(walk *w, block *b, uint32_t *form, uint32_t *delta, uint32_t x0, uint32_t y0)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   head = source_word(w, b->from + 1) >> 16, last = 0;
    uint32_t   many = w->fine ? changes_beside(w, x0, y0) : 0;
    b->entries      = code_nibble(c, &odds->entries[b->plane.tiles ? 4 : b->class][many], head & 15) + 1;
    if (b->entries > PALETTE_MAX) return 0;
    b->class       = b->entries <= 2 ? b->entries - 1 : b->entries < 5 ? 2 : b->entries < 9 ? 3 : 4;
    uint32_t shift = head >> 4 & 15, width = head >> 8 & 3, far = head >> 10 & 1;
    uint32_t like = w->fine ? b->class : 0, last_shift = !w->fine ? 0 : w->last_shift < 3 ? w->last_shift : 3;
    uint32_t simple =
        code_nibble(c, &odds->delta_form[b->entries == 1 ? 5 : like][last_shift], width || far || shift == 15 ? 15 : shift);
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
    if (b->entries > 1) w->last_shift = shift;
    b->far       = far;
    *form        = (b->entries - 1) | shift << 4 | width << 8 | far << 10;
    uint32_t end = width == 0 ? 1 << 8 : width == 1 ? 1 << 16 : DEPTH_END;
    b->depth[0]  = (int16_t)b->base;
    for (uint32_t n = 1; n < 16; n++) b->depth[n] = 0;
    uint32_t step = 0, deltas_at = b->from_tiles + count_bits(source_word(w, b->from) & 0xffff);
    b->entry_at = 8 * deltas_at + (2 * (b->entries - 1) << width);
    for (uint32_t n = 0; n + 1 < b->entries; n++) {
        uint32_t value = 0, is_last = n + 2 == b->entries;
        if (PAGE_ENCODING) {
            uint32_t byte = n << width;
            value = source_word(w, deltas_at + byte / 4) >> 8 * (byte & 3) & (width == 0 ? 0xff : width == 1 ? 0xffff : ~0u);
            if (value <= last || value >= end) return 0;
        }
        uint32_t kind = w->fine ? 7 * (2 * (shift < 3 ? shift : 3) + is_last) + (step < 6 ? step : 6) + 56 * (b->class - 1)
                                : 2 * shift + (n > 0);
        uint32_t met  = is_last && width < 2 && w->fine ? code_last_depth(w, b->base, shift, last, value, end, x0, y0) : 0;
        value         = met ? met - last - 1
                            : code_step(c, width == 2 ? &odds->delta_wide : &odds->delta[kind], odds->round, last, value - last - 1);
        step          = value + 1;
        if (value >= end - 1 - last || (uint64_t)(last + value + 1) << shift >= DEPTH_END) return 0;
        delta[n]        = last += value + 1;
        b->depth[n + 1] = (int16_t)(b->base + (int32_t)(last << shift));
    }
    return 1;
}

/* Which tiles of row y are on the plane, in the context of whether the plane fits the neighbours.   s  from texel (0, 0) of
 * the first tile */
static uint32_t code_on_plane(walk *w, sheet s, uint32_t y, uint32_t x0, uint32_t y0, uint32_t on)
{
    uint32_t k = (uint32_t)fits_left(w, s, x0, y0) << 4 | (uint32_t)(y > 0) << 5;
    for (uint32_t x = 0; x < 4; x++)
        k |= (uint32_t)fits_above(w, sheet_from(s, TILE_PX * (int32_t)x, 0), x0 + TILE_PX * x, y0) << x;
    return code_nibble(&w->c, &w->odds->row_on_plane[k], on);
}

/* Which tiles of a row are on the plane, and which are mixed. */
static int code_row(walk *w, block *b, uint32_t y, uint32_t x0, uint32_t y0, uint32_t *on, uint32_t *mixed)
{
    uint32_t shape = source_word(w, b->from), own = source_word(w, b->from + 1);
    *on = b->plane.tiles ? code_on_plane(w, sheet_from(b->sheet, 0, TILE_PX * (int32_t)y), y, x0, y0, (own & ~shape) >> 4 * y & 15)
                         : 0;
    if (*on == 15) return 1;
    const int16_t *above = w->above + 8 + x0;
    uint32_t       k     = varied(w->left + y0, TILE_PX) << 4 | (uint32_t)(w->left[y0] != above[0]) << 5;
    for (uint32_t x = 0; x < 4; x++) k |= varied(above + 8 * x, TILE_PX) << x;
    nibble_odds *odds = b->plane.tiles ? &w->odds->row_mixed[b->class][*on] : &w->odds->block_mixed[b->class][k];
    *mixed            = code_nibble(&w->c, odds, shape >> 4 * y & 15);
    return !(*on & *mixed);
}

/* All tiles of a block, unless all are on the plane. */
static int code_tiles(walk *w, block *b, uint32_t x0, uint32_t y0)
{
    const int16_t *left      = w->left + y0;
    int16_t        corner[4] = {w->corner, left[TILE_PX - 1], left[2 * TILE_PX - 1], left[3 * TILE_PX - 1]}; /* of rows */
    uint32_t       last      = 16;
    for (uint32_t y = 0; y < 4; y++) {
        uint32_t on, mixed = 0, y1 = y0 + 8 * y;
        if (!code_row(w, b, y, x0, y1, &on, &mixed)) return 0;
        b->on |= on << 4 * y;
        b->mixed |= mixed << 4 * y;
        if (count_bits(b->mixed) > w->node_words - b->tiles) return 0;
        for (uint32_t x = 0; x < 4; x++) {
            uint32_t t = x + 4 * y, x1 = x0 + 8 * x;
            w->corner = corner[y];
            corner[y] = w->above[8 + x1 + TILE_PX - 1];
            if (on >> x & 1)
                draw_sheet(w, sheet_from(b->sheet, 8 * (int32_t)x, 8 * (int32_t)y), x1, y1);
            else if (!(mixed >> x & 1 ? code_mixed_tile(w, b, t, x1, y1) : code_uniform_tile(w, b, t, x1, y1, &last)))
                return 0;
        }
    }
    return !b->plane.tiles || b->on;
}

/* A new block at w->word, with known base and plane. */
static int code_block(walk *w, block *b, uint32_t x0, uint32_t y0)
{
    uint32_t form = 0, delta[PALETTE_MAX];
    b->class      = varied(w->left + y0, BLOCK_PX) | varied(w->above + 8 + x0, BLOCK_PX) << 1;
    b->entries    = 1;
    b->tiles      = b->word + (b->plane.tiles ? 4 : 2);
    b->from_tiles = b->from + (b->plane.tiles ? 4 : 2);
    if (b->tiles > w->node_words) return 0;
    if (b->plane.tiles == ON_ALL) {
        b->on = 0xffff;
        for (uint32_t t = 0; t < 16; t++)
            draw_sheet(w, sheet_from(b->sheet, 8 * (int32_t)(t & 3), 8 * (int32_t)(t >> 2)), x0 + 8 * (t & 3), y0 + 8 * (t >> 2));
    } else if (!code_palette(w, b, &form, delta, x0, y0) || !code_tiles(w, b, x0, y0))
        return 0;
    uint32_t width = form >> 8 & 3, at = b->tiles + b->mixed_count, byte = 4 * at, owns = b->far ? count_bits(b->own) : 0;
    uint32_t bytes = ((b->entries - 1) << width) + (b->fresh_count + 1) / 2;
    if (b->mixed_count + (bytes + 3) / 4 + owns > w->node_words - b->tiles) return 0;
    w->words[b->word]     = b->mixed | b->fresh << 16;
    w->words[b->word + 1] = b->own | b->on | form << 16;
    if (b->plane.tiles) {
        w->words[b->word + 2] = (uint16_t)b->plane.plane.a | (uint32_t)b->plane.plane.b << 16;
        w->words[b->word + 3] = b->plane.plane.shift | (uint32_t)b->plane.c << 4;
    }
    for (uint32_t n = 0; n + 1 < b->entries; n++)
        for (uint32_t k = 0; k < 1u << width; k++) put_byte(w->words, byte++, delta[n] >> 8 * k);
    for (uint32_t n = 0; n < b->fresh_count; n += 2) put_byte(w->words, byte++, b->index >> 4 * n & 0xff);
    at += (bytes + 3) / 4;
    for (uint32_t n = 0; n < owns; n++) w->words[at++] = (uint32_t)b->private_base[n];
    w->word = at;
    return 1;
}

/* Set the borders after a known block: from its last row and last column of tiles. */
static void draw_block(walk *w, uint32_t word, int32_t base, const sheet *whole, uint32_t x0, uint32_t y0)
{
    const uint32_t *words = w->words;
    uint32_t        shape = words[word], head = words[word + 1], mixed = shape & 0xffff, entries = (head >> 16 & 15) + 1;
    uint32_t        on = head & ~mixed & 0xffff, tiles = word + head_words(mixed, head);
    uint32_t        shift = head >> 20 & 15, width = head >> 24 & 3, byte = 4 * (tiles + count_bits(mixed)),
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
        if (on >> t & 1) {
            draw_sheet(w, sheet_from(*whole, (int32_t)(x - x0), (int32_t)(y - y0)), x, y);
            continue;
        }
        if (!(mixed >> t & 1)) {
            uint32_t nth = count_bits(shape >> 16 & ((2u << t) - 1)) - 1;
            draw_uniform(w, x, y, TILE_PX, depth[get_byte(words, index_byte + nth / 2) >> 4 * (nth & 1) & 15]);
            continue;
        }
        uint32_t tile = words[tiles + count_bits(mixed & ((1u << t) - 1))], ref = tile >> 14;
        if (!(head >> t & 1)) {
            int16_t  used[DEPTHS_MAX];
            uint32_t kind = 0;
            for (uint32_t bits = tile & 0x3fff; bits; bits &= bits - 1) used[kind++] = depth[page_first_bit(bits)];
            draw_pattern(w, border_of_ref(w, ref, ref & (REF_COMMON - 1), kind), used, x, y);
            continue;
        }
        int32_t own = (int32_t)(tile & 0x3fff) - PRIVATE_ZERO;
        if (head >> 26 & 1) {
            uint32_t bytes = ((entries - 1) << width) + (count_bits(shape >> 16) + 1) / 2;
            own            = (int32_t)words[byte / 4 + (bytes + 3) / 4 + count_bits(head & mixed & ((1u << t) - 1))];
        }
        draw_private(w, ref, base + own, x, y);
    }
}

/* Source of a block. */
enum { BLOCK_NEW, BLOCK_LISTED, BLOCK_LEFT, BLOCK_ABOVE };

/* Encoder only. */
static uint32_t find_block(const walk *w, uint32_t ref, uint32_t left, uint32_t above)
{
    uint32_t rank = w->block_rank[ref];
    if (rank >= w->listed[LIST_OF_BLOCKS] || *list_at(w, LIST_OF_BLOCKS, rank) != ref) return BLOCK_NEW;
    return left == ref + 1 ? BLOCK_LEFT : above == ref + 1 ? BLOCK_ABOVE : BLOCK_LISTED;
}

/* The word of a known block, + 1. 0: invalid.   place  in the list */
static uint32_t code_met_block(walk *w, uint32_t found, uint32_t place, uint32_t left, uint32_t above)
{
    if (found == BLOCK_LEFT) return left;
    if (found == BLOCK_ABOVE) return above;
    place = code_number(&w->c, &w->odds->block, place);
    return found == BLOCK_LISTED && place < w->listed[LIST_OF_BLOCKS] ? list_use(w, LIST_OF_BLOCKS, place) + 1 : 0;
}

/* A mixed block of a node: its base and its word. */
static int code_block_of(walk *w, int wide, uint32_t x0, uint32_t y0, uint32_t *ref, uint32_t *base)
{
    uint32_t *left = &w->block_left[y0 / BLOCK_PX], *above = &w->block_above[x0 / BLOCK_PX], word = w->word;
    uint32_t  found = PAGE_ENCODING ? find_block(w, *ref, *left, *above) : 0, place = PAGE_ENCODING ? w->block_rank[*ref] : 0;
    block     b = {.from = *ref, .word = word};
    found       = code_nibble(&w->c, &w->odds->block_found[likeness(*left, *above, 0)], found);
    if (found != BLOCK_NEW) {
        if (!(word = code_met_block(w, found, place, *left, *above))) return 0;
        read_block_plane(&b.plane, w->words + --word);
    } else {
        if (word + 2 > w->node_words) return 0;
        list_add(w, LIST_OF_BLOCKS, word);
        if (!code_block_plane(w, &b.plane, b.from, *base, x0, y0)) return 0;
    }
    *ref  = word;
    *left = *above = word + 1;

    /* Base of a block, predicted from the plane (if all tiles are on it, or if the block is known), else from the least depth
     * beside the block. */
    int      met      = found != BLOCK_NEW;
    uint32_t by_plane = b.plane.tiles == ON_NONE ? 0 : met ? 2 : b.plane.tiles == ON_ALL, high = 0;
    int32_t  least = least_border_depth(w, x0, y0, BLOCK_PX), like = least == INT16_MAX ? 0 : least;
    if (by_plane) like = met ? base_by_plane(w, &b.plane, x0, y0) : (int32_t)b.plane.least >> 8;
    uint32_t k   = w->fine ? varied(w->left + y0, BLOCK_PX) + 2 * varied(w->above + 8 + x0, BLOCK_PX) : 0;
    uint32_t off = (uint32_t)code_signed(&w->c, &w->odds->base[by_plane][k], (int16_t)(*base - (uint32_t)like));
    if (wide) high = code_number(&w->c, &w->odds->high, *base >> 16);
    *base = (((uint32_t)like + off) & 0xffff) | high << 16;
    if (!(high < DEPTH_END >> 16)) return 0;

    if (found == BLOCK_NEW) b.plane.c = signed_28(b.plane.least - (*base << 8));
    b.base  = (int32_t)*base;
    b.sheet = sheet_of(&b.plane.plane, (*base << 8) + (uint32_t)b.plane.c, BLOCK_PX, OF_BLOCK);
    if (b.plane.tiles != ON_NONE) w->last_plane = b.sheet;
    if (found == BLOCK_NEW) return code_block(w, &b, x0, y0);
    draw_block(w, word, b.base, &b.sheet, x0, y0);
    return 1;
}

/* nodes ------------------------------------------------------------------------------------------------------------------------- */

static void code_slope(walk *w, int32_t *nx, int32_t *ny)
{
    page_odds *odds = w->odds;
    if (!code_flag(&w->c, &odds->same_slope, *nx == w->slope_x && *ny == w->slope_y)) {
        if (code_flag(&w->c, &odds->no_slope, !*nx && !*ny))
            *nx = *ny = 0;
        else {
            *nx = (int16_t)code_signed(&w->c, &odds->slope, *nx);
            *ny = (int16_t)code_signed(&w->c, &odds->slope, *ny);
        }
        w->slope_x = *nx;
        w->slope_y = *ny;
    }
    *nx = w->slope_x;
    *ny = w->slope_y;
}

/* A bit for each block: whether it is mixed. The context is whether the blocks above and on the left are mixed; at the
 * border of the node, whether the depths vary there. */
static uint64_t code_node_mixed(walk *w, uint64_t source)
{
    uint64_t mixed = 0;
    for (uint32_t n = 0; n < 16; n++) {
        uint32_t k = 0, x0 = n & 1 ? NODE_PX / 2 : 0, y0 = n / 2 * BLOCK_PX;
        if (n > 1) k = mixed >> (4 * n - 8) & 15;
        for (uint32_t x = 0; x < 4 && n < 2; x++) k |= varied(w->above + 8 + x0 + x * BLOCK_PX, BLOCK_PX) << x;
        k |= (n & 1 ? (uint32_t)(mixed >> (4 * n - 1) & 1) : varied(w->left + y0, BLOCK_PX)) << 4 | (n & 1) << 5;
        mixed |= (uint64_t)code_nibble(&w->c, &w->odds->node_mixed[k], source >> 4 * n & 15) << 4 * n;
    }
    return mixed;
}

/* How many of a node's uniform blocks to come have a fresh depth: all, half, an eighth, fewer. */
PAGE_INLINE uint32_t fresh_share(uint32_t fresh, uint32_t blocks)
{
    return (uint32_t)(fresh < blocks) + (uint32_t)(2 * fresh < blocks) + (uint32_t)(8 * fresh < blocks);
}

/* Depth of a uniform block.   last  depth of the previous uniform block;   share  fresh_share */
static uint32_t code_uniform_block(walk *w, int wide, uint32_t last, uint32_t depth, uint32_t share, uint32_t x0, uint32_t y0)
{
    uint32_t left = (uint16_t)w->left[y0], above = (uint16_t)w->above[8 + x0], low = depth & 0xffff, high = 0, symbol = 0;
    uint32_t k =
        (left == above) | (uint32_t)((last & 0xffff) == left || (last & 0xffff) == above) << 1 | (uint32_t)(left == NEVER) << 2;
    if (PAGE_ENCODING) symbol = low == left ? 0 : low == above ? 1 : low == (last & 0xffff) ? 2 : low == NEVER ? 3 : 4;
    if (w->fine) k += 8 * (uint32_t)((last & 0xffff) == left);
    symbol = code_nibble(&w->c, &w->odds->depth_like[share][k][corner_context(w, x0, y0, BLOCK_PX)], symbol);
    if (symbol >= 4) {
        uint32_t like = left != NEVER ? left : above != NEVER ? above : 0;
        low           = (like + (uint32_t)code_signed(&w->c, &w->odds->depth, (int16_t)(low - like))) & 0xffff;
    } else
        low = symbol == 0 ? left : symbol == 1 ? above : symbol == 2 ? last & 0xffff : NEVER;
    if (wide) high = code_number(&w->c, &w->odds->high, depth >> 16);
    return low | high << 16;
}

static int code_node(walk *w, const vxs_page_node *node)
{
    uint32_t start = w->word, from = 2 * node->offset;
    int32_t  nx = (int16_t)source_half(w, from + 8), ny = (int16_t)source_half(w, from + 9);
    uint64_t mixed = 0, fresh = 0;
    if (start != node->offset) return 0;
    if (PAGE_ENCODING) {
        for (uint32_t n = 0; n < 4; n++) {
            mixed |= (uint64_t)source_half(w, from + n) << 16 * n;
            fresh |= (uint64_t)source_half(w, from + 4 + n) << 16 * n;
        }
    }
    int wide = (int)code_flag(&w->c, &w->odds->wide, source_half(w, from + 10) & 1);
    code_slope(w, &nx, &ny);
    open_borders(w, node, nx, ny);
    mixed                = code_node_mixed(w, mixed);
    uint32_t mixed_count = count_bits((uint32_t)mixed) + count_bits((uint32_t)(mixed >> 32));
    uint32_t uniform = 64 - mixed_count, fresh_count = count_bits((uint32_t)fresh) + count_bits((uint32_t)(fresh >> 32));
    fresh_count   = code_number(&w->c, &w->odds->fresh_count, fresh_count);
    uint32_t size = wide ? 2 : 1;
    if (mixed_count + fresh_count > 64) return 0;
    uint32_t halves = NODE_HALVES + mixed_count + size * (mixed_count + fresh_count);
    if ((halves + 1) / 2 > w->node_words - start) return 0;
    w->word += (halves + 1) / 2;

    uint32_t ref_at = 2 * start + NODE_HALVES, base_at = ref_at + mixed_count, depth_at = base_at + size * mixed_count;
    uint32_t depth_end = depth_at + size * fresh_count, last = 0, met = 0;
    int16_t  next_corner = 0;
    fresh                = 0;
    for (uint32_t n = 0; n < 64; n++) {
        uint32_t x0 = n % 8 * BLOCK_PX, y0 = n / 8 * BLOCK_PX;
        w->corner   = n % 8 ? next_corner : w->left[y0];
        next_corner = w->above[8 + x0 + BLOCK_PX - 1];
        if (mixed >> n & 1) {
            uint32_t at = from + (ref_at - 2 * start), ref = source_half(w, at), base_half = from + (base_at - 2 * start);
            uint32_t base = source_half(w, base_half) | (wide ? source_half(w, base_half + 1) << 16 : 0);
            if (!code_block_of(w, wide, x0, y0, &ref, &base)) return 0;
            put_half(w->words, ref_at++, ref);
            for (uint32_t k = 0; k < size; k++) put_half(w->words, base_at++, base >> 16 * k);
            continue;
        }
        uint32_t depth = 0;
        if (PAGE_ENCODING) {
            uint32_t fresh_here = source_half(w, from + 4 + n / 16) >> n % 16 & 1, at = from + (depth_at - 2 * start);
            depth = fresh_here ? source_half(w, at) | (wide ? source_half(w, at + 1) << 16 : 0) : last;
        }
        uint32_t rest = (depth_end - depth_at) / size; /* fresh depths to come */
        if (w->fine && !rest)
            depth = last;
        else
            depth = code_uniform_block(w, wide, last, depth, w->fine ? fresh_share(rest, uniform) : 0, x0, y0);
        uniform--;
        draw_uniform(w, x0, y0, BLOCK_PX, (int16_t)depth);
        if (met && depth == last) continue;
        if (wide && depth >= DEPTH_END && depth != ~0u) return 0;
        if (depth_at == depth_end) return 0;
        for (uint32_t k = 0; k < size; k++) put_half(w->words, depth_at++, depth >> 16 * k);
        fresh |= (uint64_t)1 << n;
        last = depth;
        met  = 1;
    }
    if (depth_at != depth_end) return 0;
    for (uint32_t n = 0; n < 2; n++) {
        w->words[start + n]     = (uint32_t)(mixed >> 32 * n);
        w->words[start + 2 + n] = (uint32_t)(fresh >> 32 * n);
    }
    w->words[start + 4] = (uint16_t)nx | (uint32_t)(uint16_t)ny << 16;
    put_half(w->words, 2 * start + 10, (uint32_t)wide);
    close_borders(w, node, nx, ny);
    return 1;
}

/* Start without any known records. */
static void start_page(walk *w)
{
    w->fine = w->common->packing == VXS_PACKING_FINE;
    start_odds(w->odds, w->fine);
    memset(w->s->below_of, 0, sizeof w->s->below_of);
    memset(w->s->right_of, 0, sizeof w->s->right_of);
    memset(w->s->border_ref, 0, sizeof w->s->border_ref);
    memset(w->s->pattern_set, 0, sizeof w->s->pattern_set);
    memset(w->s->used_set, 0, sizeof w->s->used_set);
    w->half = 2 * w->node_words;
}

/* A whole page: w has its size and context, and its words are zeros. 0: invalid page. */
static int code_page(walk *w, const vxs_page_node *nodes, uint32_t node_count)
{
    start_page(w);
    for (uint32_t n = 0; n < node_count; n++)
        if (!code_node(w, &nodes[n])) return 0;
    return w->word == w->node_words && (w->half + 1) / 2 == w->word_count;
}

#endif
