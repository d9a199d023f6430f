/* Symbols of a light's resident part, in their order: one text for encoder and decoder, like vxs_page_model.h.
 * Internal. Not installed.
 *
 *     top      entries in z order: a depth (that of the left or upper entry, or another), or a node (the next of its page, the
 *              first of the next page, or a known one) with its base and its least and greatest depth. From 15 levels on, cells
 *              first
 *     pool     number of patterns of each kind, then kind and pattern of each, in storage order
 *
 * SPDX-License-Identifier: MIT */
#ifndef VXS_RESIDENT_MODEL_H
#define VXS_RESIDENT_MODEL_H

#include "vxs_page_model.h"
#include "vxs_resident_layout.h"

enum { DEPTH_LOW = 4 /* low bits of a depth of a fine map, which are coded apart */ };

enum { TOP_LEFT, TOP_ABOVE, TOP_DEPTH, TOP_NEXT_NODE, TOP_NEXT_PAGE, TOP_OLD_NODE, TOP_CELL };

/* Consists only of nibble_odds, so that it can be used as one array. */
typedef struct top_odds {
    nibble_odds kind[2][9], pattern_kind;
    signed_odds depth, base, least, range;
    number_odds offset, old, count;
} top_odds;

typedef struct resident_walk {
    walk           w; /* its source and words are those of the light */
    top_odds      *odds;
    uint32_t       levels, map_count, page_count, node_count;
    vxs_page_node *nodes;      /* [node_count] out */
    uint32_t      *page_first; /* [page_count + 1] out */
    uint32_t      *patterns;   /* [pattern_count] out */
    uint32_t       pattern_count, first[VXS_PATTERN_KINDS + 1];
    uint32_t       met, pages; /* number of nodes and pages so far */
    vxs_page_node  last;
} resident_walk;

/* Base, least and greatest depth of an entry with a known node. */
static int code_range(resident_walk *r, uint32_t at, uint32_t like)
{
    uint32_t *words = r->w.words, source = source_word(&r->w, at + 1),
             like_base = words[like] & top_uniform ? 0 : words[like + 1] & 0xffff;
    uint32_t coarse = r->levels > 8 ? r->levels - 8 : 0, fine = r->levels > 16 ? r->levels - 16 : 0;
    int32_t  base = (int32_t)like_base + code_signed(&r->w.c, &r->odds->base, (int32_t)(source & 0xffff) - (int32_t)like_base);
    if (base < 0 || base > 0xffff) return 0;
    int32_t least = base << fine >> coarse;
    least += code_signed(&r->w.c, &r->odds->least, (int32_t)(source >> 16 & 255) - least);
    int32_t greatest = least + code_signed(&r->w.c, &r->odds->range, (int32_t)(source >> 24) - least);
    if (least < 0 || greatest < least || greatest > 255) return 0;
    words[at + 1] = (uint32_t)base | (uint32_t)least << 16 | (uint32_t)greatest << 24;
    r->last.base  = base << fine;
    return 1;
}

/* Index of the node that a word of the source refers to; r->met if it is not known yet. Encoder only. */
static uint32_t find_node(const resident_walk *r, uint32_t name)
{
    uint32_t page = name >> 16;
    if (page >= r->pages) return r->met;
    uint32_t end = page + 1 < r->pages ? r->page_first[page + 1] : r->met;
    return node_at(r->nodes, r->page_first[page], end, name & 0xffff, r->met);
}

/* Symbol for word `at` of the source.   left, above  words of the neighbours, or `at` if there is none */
static uint32_t find_symbol(const resident_walk *r, uint32_t at, uint32_t left, uint32_t above, int cell)
{
    uint32_t source = source_word(&r->w, at);
    if (source & top_uniform) {
        if (left != at && r->w.words[left] == source) return TOP_LEFT;
        return above != at && r->w.words[above] == source ? TOP_ABOVE : TOP_DEPTH;
    }
    if (cell) return TOP_CELL;
    if (find_node(r, source) < r->met) return TOP_OLD_NODE;
    return r->pages && source >> 16 == r->pages - 1 ? TOP_NEXT_NODE : TOP_NEXT_PAGE;
}

/* A new node for the entry at word `at`.   next  1: it is the first node of the next page */
static int code_new_node(resident_walk *r, uint32_t at, int next, uint32_t like)
{
    uint32_t offset = 0;
    if (r->met == r->node_count) return 0;
    if (next) {
        if (r->pages == r->page_count) return 0;
        r->page_first[r->pages++] = r->met;
    } else {
        if (!r->pages) return 0;
        uint32_t least = r->last.offset + 1;
        offset         = least + code_number(&r->w.c, &r->odds->offset, (source_word(&r->w, at) & 0xffff) - least);
        if (offset < least || offset >= VXS_PAGE_WORDS_MAX) return 0;
    }
    r->w.words[at] = (r->pages - 1) << 16 | offset;
    r->last.offset = offset;
    if (!code_range(r, at, like)) return 0;
    r->nodes[r->met++] = r->last;
    return 1;
}

static int code_old_node(resident_walk *r, uint32_t at, uint32_t like)
{
    uint32_t back = PAGE_ENCODING ? r->met - 1 - find_node(r, source_word(&r->w, at)) : 0;
    back          = code_number(&r->w.c, &r->odds->old, back);
    if (back >= r->met) return 0;

    uint32_t node = r->met - 1 - back, page = 0;
    for (uint32_t end = r->pages; end - page > 1;) { /* find the page of the node */
        uint32_t middle = page + (end - page) / 2;
        if (r->page_first[middle] <= node)
            page = middle;
        else
            end = middle;
    }
    r->w.words[at] = page << 16 | r->nodes[node].offset;
    return code_range(r, at, like);
}

/* A cell, or an entry, at word `at`.   left, above  words of the neighbours, already coded, or `at` if there is none
 * Returns 1: done; 2: a cell with entries; 0: invalid. */
static int code_square(resident_walk *r, uint32_t at, uint32_t left, uint32_t above, int cell)
{
    coder    *c     = &r->w.c;
    uint32_t *words = r->w.words, depth;
    uint32_t  k     = (left == at                  ? 0
                       : words[left] & top_uniform ? 1u
                                                   : 2u) +
                 3 * (above == at                  ? 0
                      : words[above] & top_uniform ? 1u
                                                   : 2u);
    uint32_t like = left != at && !(words[left] & top_uniform) ? left : above, beside = 0;
    uint32_t symbol = code_nibble(c, &r->odds->kind[cell][k], PAGE_ENCODING ? find_symbol(r, at, left, above, cell) : 0);
    switch (symbol) {
    case TOP_LEFT:
    case TOP_ABOVE: depth = words[symbol == TOP_LEFT ? left : above]; break;
    case TOP_DEPTH:
        if (above != at && words[above] & top_uniform) beside = words[above] & ~top_uniform;
        if (left != at && words[left] & top_uniform) beside = words[left] & ~top_uniform;
        depth = source_word(&r->w, at) & ~top_uniform;
        if (r->w.fine) {
            int32_t from = (int32_t)(beside >> DEPTH_LOW), high;
            high         = from + code_signed(c, &r->odds->depth, (int32_t)(depth >> DEPTH_LOW) - from);
            if (high < 0 || high > SQUARE_DEPTH_END >> DEPTH_LOW) return 0;
            depth = (uint32_t)high << DEPTH_LOW | code_plain(c, DEPTH_LOW, depth & ((1 << DEPTH_LOW) - 1));
        } else
            depth = beside + (uint32_t)code_signed(c, &r->odds->depth, (int32_t)depth - (int32_t)beside);
        if (depth >= SQUARE_DEPTH_END) return 0;
        depth |= top_uniform;
        break;
    case TOP_NEXT_NODE:
    case TOP_NEXT_PAGE: return !cell && code_new_node(r, at, symbol == TOP_NEXT_PAGE, like);
    case TOP_OLD_NODE: return !cell && code_old_node(r, at, like);
    case TOP_CELL: return cell ? 2 : 0;
    default: return 0;
    }
    words[at] = depth;
    return (depth & top_uniform) != 0;
}

/* Entries of a square of `side` entries a side, in z order. */
static int code_entries(resident_walk *r, uint32_t top, uint32_t x0, uint32_t y0, uint32_t side)
{
    for (uint32_t n = 0; n < side * side; n++) {
        uint32_t x = x0 + even_bits(n), y = y0 + even_bits(n >> 1), at = top_at(r->w.words, top, r->levels, x, y);
        uint32_t left  = x ? top_at(r->w.words, top, r->levels, x - 1, y) : at;
        uint32_t above = y ? top_at(r->w.words, top, r->levels, x, y - 1) : at;
        r->last.x      = x;
        r->last.y      = y;
        if (!code_square(r, at, left, above, 0)) return 0;
    }
    return 1;
}

static int code_top(resident_walk *r, uint32_t map)
{
    uint32_t side = squares_of(r->levels), top = r->w.word, cells = side / CELL_SQUARES;
    uint32_t size = r->levels < CELL_LEVELS ? 2 * side * side : cells * cells;
    if (size > r->w.word_count - top) return 0;
    r->w.words[2 + map] = top;
    r->last.map         = map;
    r->w.word += size;
    if (r->levels < CELL_LEVELS) return code_entries(r, top, 0, 0, side);
    for (uint32_t n = 0; n < cells * cells; n++) {
        uint32_t x = even_bits(n), y = even_bits(n >> 1), at = top + y * cells + x;
        int      done = code_square(r, at, x ? at - 1 : at, y ? at - cells : at, 1);
        if (done == 1) continue;
        if (!done || 2 * CELL_SQUARES * CELL_SQUARES > r->w.word_count - r->w.word) return 0;
        r->w.words[at] = r->w.word;
        r->w.word += 2 * CELL_SQUARES * CELL_SQUARES;
        if (!code_entries(r, top, x * CELL_SQUARES, y * CELL_SQUARES, CELL_SQUARES)) return 0;
    }
    return 1;
}

/* The pattern at w->half of the common pool. */
static int code_common_pattern(walk *w, uint32_t kind)
{
    static const int16_t depth[DEPTHS_MAX] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    _Alignas(16) uint8_t index[64];
    if (kind == KIND_PRIVATE) return code_private(w, w->half, NULL, 0, 0);
    if (PAGE_ENCODING && !read_source(w, w->half, kind, index)) return 0;
    return code_image(w, depth, kind, 0, 0, index) && put_pattern(w, index, kind);
}

/* source  patterns to code; used only by the encoder */
static int code_common(resident_walk *r, const vxs_common *source)
{
    walk    *w     = &r->w;
    uint32_t start = 2 * w->word, next[VXS_PATTERN_KINDS], all = 0;
    memset(w->above, 0, sizeof w->above);
    memset(w->left, 0, sizeof w->left);
    w->words[1] = w->word;
    w->half     = start;
    for (uint32_t k = 0; k < VXS_PATTERN_KINDS; k++) {
        r->first[k] = next[k] = all;
        uint32_t count        = code_number(&w->c, &r->odds->count, PAGE_ENCODING ? source->first[k + 1] - source->first[k] : 0);
        if (count > r->pattern_count - all || (k == 1 && count)) return 0;
        all += count;
    }
    r->first[VXS_PATTERN_KINDS] = all;
    if (all != r->pattern_count) return 0;
    for (uint32_t n = 0; n < all; n++) {
        uint32_t kind = 0, half = w->half - start;
        if (PAGE_ENCODING)
            while (kind < VXS_PATTERN_KINDS && (next[kind] == r->first[kind + 1] || source->patterns[next[kind]] != half)) kind++;
        if (half >= VXS_COMMON_HALVES_MAX || kind == VXS_PATTERN_KINDS) return 0;
        kind = code_nibble(&w->c, &r->odds->pattern_kind, kind);
        if (kind >= VXS_PATTERN_KINDS || next[kind] == r->first[kind + 1]) return 0;
        r->patterns[next[kind]++] = half;
        if (!code_common_pattern(w, kind)) return 0;
    }
    return (w->half + 1) / 2 == w->word_count && w->half - start <= VXS_COMMON_HALVES_MAX;
}

/* A whole resident part: r has its sizes, and its words are zeros. 0: invalid. */
static int code_resident(resident_walk *r, const vxs_common *source)
{
    uint32_t *words = r->w.words;
    if (r->page_count > VXS_PAGES_MAX || RESIDENT_WORDS + r->page_count > r->w.word_count) return 0;
    start_patterns(r->w.odds);
    for (size_t n = 0; n < sizeof *r->odds / sizeof(nibble_odds); n++) ((nibble_odds *)r->odds)[n] = r->w.odds->far;
    words[0]  = r->page_count;
    r->w.word = RESIDENT_WORDS + r->page_count;
    for (uint32_t map = 0; map < r->map_count; map++)
        if (!code_top(r, map)) return 0;
    if ((r->met != r->node_count && !PAGE_ENCODING) || r->pages != r->page_count) return 0;
    r->page_first[r->page_count] = r->met;
    return code_common(r, source);
}

#endif
