/* What is coded of a page, and in what order: one text for encoder and decoder. Internal to vxs_page_*.c, which define
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

#include "vxs_page_blocks.h"

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

/* Depth of a uniform block.   last  depth of the previous uniform block */
static uint32_t code_uniform_block(walk *w, int wide, uint32_t last, uint32_t depth, uint32_t x0, uint32_t y0)
{
    uint32_t left = (uint16_t)w->left[y0], above = (uint16_t)w->above[8 + x0], low = depth & 0xffff, high = 0, symbol = 0;
    uint32_t k =
        (left == above) | (uint32_t)((last & 0xffff) == left || (last & 0xffff) == above) << 1 | (uint32_t)(left == NEVER) << 2;
    if (PAGE_ENCODING) symbol = low == left ? 0 : low == above ? 1 : low == (last & 0xffff) ? 2 : low == NEVER ? 3 : 4;
    symbol = code_nibble(&w->c, &w->odds->depth_like[k], symbol);
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
    uint32_t fresh_count =
        code_number(&w->c, &w->odds->fresh_count, count_bits((uint32_t)fresh) + count_bits((uint32_t)(fresh >> 32)));
    uint32_t size = wide ? 2 : 1;
    if (mixed_count + fresh_count > 64) return 0;
    uint32_t halves = NODE_HALVES + mixed_count + size * (mixed_count + fresh_count);
    if ((halves + 1) / 2 > w->node_words - start) return 0;
    w->word += (halves + 1) / 2;

    uint32_t ref_at = 2 * start + NODE_HALVES, base_at = ref_at + mixed_count, depth_at = base_at + size * mixed_count;
    uint32_t depth_end = depth_at + size * fresh_count, last = 0, met = 0;
    fresh = 0;
    for (uint32_t n = 0; n < 64; n++) {
        uint32_t x0 = n % 8 * BLOCK_PX, y0 = n / 8 * BLOCK_PX;
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
        depth = code_uniform_block(w, wide, last, depth, x0, y0);
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
    start_odds(w->odds);
    memset(w->s->below_of, 0, sizeof w->s->below_of);
    memset(w->s->right_of, 0, sizeof w->s->right_of);
    memset(w->s->border_ref, 0, sizeof w->s->border_ref);
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
