/* The patterns that a page has met, in lists by their kinds: a tile that has one again says its place in the list.
 * Internal to vxs_page_*.c, which say PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_LISTS_H
#define VXS_PAGE_LISTS_H

#include "vxs_page_own.h"

PAGE_INLINE vxs_pattern *pattern_at(walk *w, uint32_t kind, uint32_t rank)
{
    return w->s->pattern + w->s->chunk[kind][rank / LIST_CHUNK] * (uint32_t)LIST_CHUNK + rank % LIST_CHUNK;
}

/* Append to its list. There is room: each comes with a tile, and a tile is a word. */
static vxs_pattern *add_pattern(walk *w, vxs_pattern pattern)
{
    uint32_t kind = pattern.kind, rank = w->patterns[kind]++;
    if (rank % LIST_CHUNK == 0) w->s->chunk[kind][rank / LIST_CHUNK] = (uint16_t)w->chunks++;
    if (PAGE_ENCODING) w->pattern_rank[pattern.ref] = rank + 1;
    vxs_pattern *at = pattern_at(w, kind, rank);
    *at             = pattern;
    return at;
}

/* Of a list, what is used moves half the way to the front, and changes places with what is there. */
static vxs_pattern *use_pattern(walk *w, uint32_t kind, uint32_t rank)
{
    vxs_pattern *from = pattern_at(w, kind, rank), *to = pattern_at(w, kind, rank / 2), other = *to;
    *to   = *from;
    *from = other;
    if (PAGE_ENCODING) {
        w->pattern_rank[from->ref] = rank + 1;
        w->pattern_rank[to->ref]   = rank / 2 + 1;
    }
    return to;
}

/* 0: a new one; 1: the common pool's; else rank in its list + 2. */
static uint32_t find_pattern(walk *w, uint32_t kind, uint32_t ref)
{
    uint32_t rank = w->pattern_rank[ref];
    if (rank && rank <= w->patterns[kind] && pattern_at(w, kind, rank - 1)->ref == ref) return rank + 1;
    return ref & REF_COMMON ? 1 : 0;
}

static uint32_t find_common(const vxs_common *common, uint32_t kind, uint32_t ref)
{
    uint32_t low = common->first[kind], high = common->first[kind + 1];
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (common->patterns[middle].ref < ref)
            low = middle + 1;
        else
            high = middle;
    }
    return low - common->first[kind];
}

/* Words of the pool that a pattern lies in. */
PAGE_INLINE const uint32_t *pool_of(const walk *w, const vxs_pattern *pattern)
{
    return pattern->ref & REF_COMMON ? w->common->words : w->words;
}

/* A pattern that is known: of the common pool, or met before. NULL: there is none.
 * place  as of find_pattern, above 0 */
static const vxs_pattern *code_known(walk *w, uint32_t kind, uint32_t place, uint32_t ref)
{
    if (place >= 2) return place - 2 < w->patterns[kind] ? use_pattern(w, kind, place - 2) : NULL;
    uint32_t n = code_number(&w->c, &w->odds->common[kind], PAGE_ENCODING ? find_common(w->common, kind, ref) : 0);
    if (n >= w->common->first[kind + 1] - w->common->first[kind]) return NULL;
    return add_pattern(w, w->common->patterns[w->common->first[kind] + n]);
}

/* The pattern of a tile; NULL: not a page.
 * depth  [kind] of a pattern over the palette; NULL: it has depths of its own
 * ref    of the source
 * base   of a pattern with depths of its own, which is coded, too */
static const vxs_pattern *code_pattern(walk *w, uint32_t kind, const int16_t *depth, uint32_t ref, own_base *base, uint32_t x0,
                                       uint32_t y0)
{
    uint32_t place = code_number(&w->c, &w->odds->pattern[kind], PAGE_ENCODING ? find_pattern(w, kind, ref) : 0);
    if (place) {
        const vxs_pattern *known = code_known(w, kind, place, ref);
        return known && (kind != KIND_OWN || code_base_of(w, base, pool_of(w, known), known->ref & (REF_COMMON - 1), x0, y0))
                   ? known
                   : NULL;
    }
    vxs_pattern new = {.ref = w->half, .kind = kind};
    if (kind == KIND_OWN) return code_own(w, ref, base, x0, y0, &new.border) ? add_pattern(w, new) : NULL;
    _Alignas(16) uint8_t index[64];
    if (PAGE_ENCODING && !read_source(w, ref, kind, index)) return NULL;
    if (!code_image(w, depth, kind, x0, y0, index) || !put_pattern(w, index, kind)) return NULL;
    new.border = border_of(index);
    return add_pattern(w, new);
}

#endif
