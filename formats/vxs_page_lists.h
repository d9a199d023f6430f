/* The patterns that a page has met, in lists by their kinds: a tile that has one again says its place in the list.
 * Internal to vxs_page_*.c, which say PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_LISTS_H
#define VXS_PAGE_LISTS_H

#include "vxs_page_own.h"

PAGE_INLINE vxs_pattern *pattern_at(const walk *w, uint32_t kind, uint32_t rank)
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
static uint32_t find_pattern(const walk *w, uint32_t kind, uint32_t ref)
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

/* A pattern of the common pool that was not yet met. 0: there is none. */
static int code_from_common(walk *w, vxs_pattern *p, uint32_t kind, uint32_t ref)
{
    uint32_t n = code_number(&w->c, &w->odds->common[kind], PAGE_ENCODING ? find_common(w->common, kind, ref) : 0);
    if (n >= w->common->first[kind + 1] - w->common->first[kind]) return 0;
    *p = *add_pattern(w, w->common->patterns[w->common->first[kind] + n]);
    return 1;
}

/* The pattern of a tile over the palette. 0: this is no page.
 * depth  [kind]
 * ref    of the source */
static int code_pattern(walk *w, vxs_pattern *p, uint32_t kind, const int16_t *depth, uint32_t ref, uint32_t x0, uint32_t y0)
{
    uint32_t place = code_number(&w->c, &w->odds->pattern[kind], PAGE_ENCODING ? find_pattern(w, kind, ref) : 0);
    if (place == 1) return code_from_common(w, p, kind, ref);
    if (place) {
        if (place - 2 >= w->patterns[kind]) return 0;
        *p = *use_pattern(w, kind, place - 2);
        return 1;
    }
    *p = (vxs_pattern){.ref = w->half, .kind = kind};
    _Alignas(16) uint8_t index[64];
    if (PAGE_ENCODING && !read_source(w, ref, kind, index)) return 0;
    if (!code_image(w, depth, kind, x0, y0, index) || !put_pattern(w, index, kind)) return 0;
    p->border = border_of(index);
    add_pattern(w, *p);
    return 1;
}

/* patterns with depths of their own -------------------------------------------------------------------------------------------- */

/* Where the pattern of a tile is found: those of planes also in the row and the column of the tile, and among those used last. */
enum { FOUND_NEW, FOUND_COMMON, FOUND_LISTED, FOUND_LEFT, FOUND_ABOVE, FOUND_LATELY };

/* Its place among those used last, or their number. */
static uint32_t find_lately(const walk *w, uint32_t ref)
{
    uint32_t n = 0;
    while (n < w->own_lately_count && w->own_lately[n] != ref + 1) n++;
    return n;
}

/* Only the encoder asks. place: in the list, or among those used last. */
static uint32_t find_own(const walk *w, uint32_t ref, uint32_t left, uint32_t above, uint32_t *place)
{
    uint32_t listed = find_pattern(w, KIND_OWN, ref);
    if (listed < 2) return listed;
    if (left == ref + 1) return FOUND_LEFT;
    if (above == ref + 1) return FOUND_ABOVE;
    *place = find_lately(w, ref);
    if (*place < w->own_lately_count) return FOUND_LATELY;
    *place = listed - 2;
    return FOUND_LISTED;
}

/* A tile has this pattern of planes. */
static void remember_planes(walk *w, uint32_t ref, uint32_t x0, uint32_t y0)
{
    uint32_t place = find_lately(w, ref);
    if (place == LATELY_KEPT) place--;
    if (place == w->own_lately_count) w->own_lately_count++;
    memmove(w->own_lately + 1, w->own_lately, place * sizeof *w->own_lately);
    w->own_lately[0] = w->own_left[y0 / TILE_PX] = w->own_above[x0 / TILE_PX] = ref + 1;
}

/* A pattern that is known. 0: there is none. */
static int code_found(walk *w, vxs_pattern *p, uint32_t found, uint32_t place, uint32_t ref, uint32_t left, uint32_t above)
{
    if (found == FOUND_COMMON) return code_from_common(w, p, KIND_OWN, ref);
    if (found == FOUND_LISTED) {
        place = code_number(&w->c, &w->odds->pattern[KIND_OWN], place);
        if (place >= w->patterns[KIND_OWN]) return 0;
        *p = *use_pattern(w, KIND_OWN, place);
        return 1;
    }
    uint32_t name = found == FOUND_LEFT ? left : above;
    if (found == FOUND_LATELY) {
        place = code_number(&w->c, &w->odds->own_lately, place);
        name  = place < w->own_lately_count ? w->own_lately[place] : 0;
    }
    *p = (vxs_pattern){.ref = name - 1, .kind = KIND_OWN}; /* of planes there is no border */
    return found <= FOUND_LATELY && name;
}

/* The pattern of a tile that has depths of its own, and the tile's base. 0: this is no page. */
static int code_own_pattern(walk *w, vxs_pattern *p, uint32_t ref, own_base *base, uint32_t x0, uint32_t y0)
{
    uint32_t left = w->own_left[y0 / TILE_PX], above = w->own_above[x0 / TILE_PX], place = 0;
    uint32_t found = PAGE_ENCODING ? find_own(w, ref, left, above, &place) : 0;
    found          = code_nibble(&w->c, &w->odds->own_found[likeness(left, above, 0)], found);
    if (found == FOUND_NEW) {
        *p = (vxs_pattern){.ref = w->half, .kind = KIND_OWN};
        if (!code_own(w, ref, base, x0, y0, &p->border)) return 0;
        add_pattern(w, *p);
    } else if (!code_found(w, p, found, place, ref, left, above) || !code_base_of(w, base, p->ref, x0, y0))
        return 0;
    if (get_half(pool_of(w, p->ref), p->ref & (REF_COMMON - 1)) >> 12 >= OWN_PLANE) remember_planes(w, p->ref, x0, y0);
    return 1;
}

#endif
