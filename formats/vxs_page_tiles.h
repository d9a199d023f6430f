/* Tiles of a block, and lists of the records that a page has so far: patterns by kind, and blocks. A record used again is coded as
 * its rank in the list.
 *
 * An entry of a list is the offset of a word of the page, 16 bits: for a block its first word, for a pattern the word of the first
 * tile that refers to it. So all entries are different, and all lists together have at most as many entries as the page has words.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_TILES_H
#define VXS_PAGE_TILES_H

#include "vxs_page_planes.h"
#include "vxs_page_private.h"

/* lists ------------------------------------------------------------------------------------------------------------------------- */

enum { LIST_OF_BLOCKS = 1 }; /* other lists are of patterns, by kind */

PAGE_INLINE uint16_t *list_at(const walk *w, uint32_t list, uint32_t rank)
{
    return w->s->listed + w->s->chunk[list][rank / LIST_CHUNK] * (uint32_t)LIST_CHUNK + rank % LIST_CHUNK;
}

/* Set the entry with this rank; the encoder also keeps the rank of each record. */
PAGE_INLINE void list_set(walk *w, uint32_t list, uint32_t rank, uint32_t word)
{
    *list_at(w, list, rank) = (uint16_t)word;
    if (PAGE_ENCODING) *(list == LIST_OF_BLOCKS ? &w->block_rank[word] : &w->pattern_rank[w->words[word] >> 14]) = (uint16_t)rank;
}

/* There is always room: see above. */
static void list_add(walk *w, uint32_t list, uint32_t word)
{
    uint32_t rank = w->listed[list]++;
    if (rank % LIST_CHUNK == 0) w->s->chunk[list][rank / LIST_CHUNK] = (uint16_t)w->chunks++;
    list_set(w, list, rank, word);
}

/* Move the used entry half the way to the front: exchange it with the entry there. Returns its word. */
static uint32_t list_use(walk *w, uint32_t list, uint32_t rank)
{
    uint32_t word = *list_at(w, list, rank), other = *list_at(w, list, rank / 2);
    list_set(w, list, rank, other);
    list_set(w, list, rank / 2, word);
    return word;
}

/* Add a pattern; the current tile is the first that refers to it. */
static void add_pattern(walk *w, uint32_t kind, uint32_t ref)
{
    w->words[w->tile] = ref << 14;
    list_add(w, kind, w->tile);
}

/* 0: new pattern; 1: from the common pool; else rank in its list + 2. */
static uint32_t find_pattern(const walk *w, uint32_t kind, uint32_t ref)
{
    uint32_t rank = w->pattern_rank[ref];
    if (rank < w->listed[kind] && w->words[*list_at(w, kind, rank)] >> 14 == ref) return rank + 2;
    return ref & REF_COMMON ? 1 : 0;
}

static uint32_t find_common(const vxs_common *common, uint32_t kind, uint32_t ref)
{
    const uint32_t *first = common->patterns + common->first[kind], *at = first, half = ref & (REF_COMMON - 1);
    for (uint32_t count = common->first[kind + 1] - common->first[kind]; count; count /= 2) {
        const uint32_t *next = at + (count + 1) / 2; /* without a branch on what is there, which is unpredictable */
        at                   = next[-1] < half ? next : at;
    }
    return (uint32_t)(at - first);
}

/* A pattern of the common pool, used for the first time. 0: invalid. */
static int code_from_common(walk *w, uint32_t kind, uint32_t *ref)
{
    uint32_t n = code_number(&w->c, &w->odds->common[kind], PAGE_ENCODING ? find_common(w->common, kind, *ref) : 0);
    if (n >= w->common->first[kind + 1] - w->common->first[kind]) return 0;
    *ref = REF_COMMON | w->common->patterns[w->common->first[kind] + n];
    add_pattern(w, kind, *ref);
    return 1;
}

/* A pattern that is already in the list, by its rank. Returns the word of the first tile with it; 0: invalid. */
static uint32_t use_pattern(walk *w, uint32_t kind, uint32_t place, uint32_t *ref)
{
    if (place >= w->listed[kind]) return 0;
    uint32_t word = list_use(w, kind, place);
    *ref          = w->words[word] >> 14;
    return word;
}

/* sets: what tiles had last in a context, the last one first; then zeros ------------------------------------------------------------ */

/* The number of the context of two numbers. */
PAGE_INLINE uint32_t set_of(uint64_t a, uint64_t b, uint32_t bits)
{
    return (uint32_t)((a * 0x9e3779b97f4a7c15u + b * 0xc2b2ae3d27d4eb4fu) >> (64 - bits));
}

/* Both functions are without branches on what is in the set, because it is hard to predict.   lanes  USED_LANES or PATTERN_LANES */
PAGE_INLINE uint32_t set_size(const uint16_t *set, uint32_t lanes)
{
#ifdef PAGE_SSE2
    const __m128i *from = (const __m128i *)set, none = _mm_setzero_si128();
    if (lanes == USED_LANES) return page_first_bit((uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi16(_mm_loadl_epi64(from), none))) / 2;
    __m128i zeros = _mm_packs_epi16(_mm_cmpeq_epi16(_mm_load_si128(from), none), _mm_cmpeq_epi16(_mm_load_si128(from + 1), none));
    return page_first_bit((uint32_t)_mm_movemask_epi8(zeros));
#else
    uint32_t size = 0;
    for (uint32_t n = 0; n < lanes; n++) size += set[n] != 0;
    return size;
#endif
}

/* The place of a value, which is not 0; 15: it is not in the set. Encoder only. */
PAGE_INLINE uint32_t set_find(const uint16_t *set, uint32_t lanes, uint32_t value)
{
#ifdef PAGE_SSE2
    const __m128i *from = (const __m128i *)set, all = _mm_set1_epi16((int16_t)value);
    __m128i        low = lanes == USED_LANES ? _mm_loadl_epi64(from) : _mm_load_si128(from), high = _mm_setzero_si128();
    if (lanes != USED_LANES) high = _mm_cmpeq_epi16(_mm_load_si128(from + 1), all);
    return page_first_bit((uint32_t)_mm_movemask_epi8(_mm_packs_epi16(_mm_cmpeq_epi16(low, all), high)) | 1 << 15);
#else
    uint32_t place = 0;
    while (place < lanes && set[place] != value) place++;
    return place < lanes ? place : 15;
#endif
}

/* Put a value in front; those before this place move by one. */
PAGE_INLINE void set_first(uint16_t *set, uint32_t lanes, uint32_t place, uint32_t value)
{
#ifdef PAGE_SSE2
    __m128i *at = (__m128i *)set, last = _mm_set1_epi16((int16_t)place), lane = _mm_set_epi16(7, 6, 5, 4, 3, 2, 1, 0);
    __m128i  a = lanes == USED_LANES ? _mm_loadl_epi64(at) : _mm_load_si128(at), stays = _mm_cmpgt_epi16(lane, last);
    __m128i  moved = _mm_or_si128(_mm_slli_si128(a, 2), _mm_cvtsi32_si128((int)value));
    moved          = _mm_or_si128(_mm_and_si128(stays, a), _mm_andnot_si128(stays, moved));
    if (lanes == USED_LANES) {
        _mm_storel_epi64(at, moved);
        return;
    }
    __m128i b = _mm_load_si128(at + 1), stays_b = _mm_cmpgt_epi16(_mm_add_epi16(lane, _mm_set1_epi16(8)), last);
    __m128i moved_b = _mm_or_si128(_mm_slli_si128(b, 2), _mm_srli_si128(a, 14));
    _mm_store_si128(at, moved);
    _mm_store_si128(at + 1, _mm_or_si128(_mm_and_si128(stays_b, b), _mm_andnot_si128(stays_b, moved_b)));
#else
    (void)lanes;
    for (; place; place--) set[place] = set[place - 1];
    set[0] = (uint16_t)value;
#endif
}

/* A value that is in the set; it becomes the first one. 0: another value, which set_add then adds.
 * odds  by the number of values in the set - 1 */
PAGE_INLINE uint32_t code_again(coder *c, uint16_t *set, uint32_t lanes, nibble_odds *odds, uint32_t value)
{
    uint32_t size = set_size(set, lanes), place = 0;
    if (!size) return 0;
    if (PAGE_ENCODING) place = set_find(set, lanes, value);
    place = code_nibble_here(c, odds + size - 1, place);
    if (place >= size) return 0;
    value = set[place];
    set_first(set, lanes, place, value);
    return value;
}

/* A full set loses its last value.   most  number of values that it may have */
PAGE_INLINE void set_add(uint16_t *set, uint32_t lanes, uint32_t most, uint32_t value)
{
    uint32_t size = set_size(set, lanes);
    set_first(set, lanes, size < most ? size : most - 1, value);
}

/* The word of the first tile with a pattern that is in the list; else that of this tile. Encoder only. */
static uint32_t find_word(const walk *w, uint32_t kind, uint32_t ref)
{
    uint32_t place = find_pattern(w, kind, ref);
    return place > 1 ? *list_at(w, kind, place - 2) : w->tile;
}

/* The pattern of a tile over the block palette. 0: invalid page.
 * depth  [kind]
 * ref    in: in the source */
static int code_pattern(walk *w, uint32_t kind, const int16_t *depth, uint32_t *ref, uint32_t x0, uint32_t y0)
{
    _Alignas(16) uint8_t index[64];
    around               o   = indices_around(w, depth, kind, x0, y0);
    uint16_t            *set = w->s->pattern_set[set_of(o.above, o.left + kind, 12)];
    if (w->fine) {
        nibble_odds *odds = w->odds->pattern_again[kind < 5 ? kind - 2 : 3];
        uint32_t     word = code_again(&w->c, set, PATTERN_LANES, odds, PAGE_ENCODING ? find_word(w, kind, *ref) : 0);
        if (word) {
            *ref = w->words[word] >> 14;
            return count_bits(w->words[word] & 0x3fff) == kind;
        }
    }
    uint32_t place = code_number(&w->c, &w->odds->pattern[kind], PAGE_ENCODING ? find_pattern(w, kind, *ref) : 0), word = w->tile;
    if (place == 1) {
        if (!code_from_common(w, kind, ref)) return 0;
    } else if (place) {
        if (!(word = use_pattern(w, kind, place - 2, ref))) return 0;
    } else {
        uint32_t half = w->half;
        if (PAGE_ENCODING && !read_source(w, *ref, kind, index)) return 0;
        if (!code_indices(w, o, kind, index) || !put_pattern(w, index, kind)) return 0;
        add_pattern(w, kind, *ref = half);
        keep_border(w, half, index);
    }
    if (w->fine) set_add(set, PATTERN_LANES, PATTERN_LANES - 1, word);
    return 1;
}

/* patterns with depths of their own -------------------------------------------------------------------------------------------- */

/* Source of a pattern. Patterns of planes can also be found in the row and the column of the tile, and among those used
 * last. */
enum { FOUND_NEW, FOUND_COMMON, FOUND_LISTED, FOUND_LEFT, FOUND_ABOVE, FOUND_LATELY };

/* Its place among those used last; their number if it is not there. */
static uint32_t find_lately(const walk *w, uint32_t ref)
{
    uint32_t n = 0;
    while (n < w->private_lately_count && w->private_lately[n] != ref + 1) n++;
    return n;
}

/* Encoder only.   place  [out] in the list, or among those used last */
static uint32_t find_private(const walk *w, uint32_t ref, uint32_t left, uint32_t above, uint32_t *place)
{
    uint32_t listed = find_pattern(w, KIND_PRIVATE, ref);
    if (listed < 2) return listed;
    if (left == ref + 1) return FOUND_LEFT;
    if (above == ref + 1) return FOUND_ABOVE;
    *place = find_lately(w, ref);
    if (*place < w->private_lately_count) return FOUND_LATELY;
    *place = listed - 2;
    return FOUND_LISTED;
}

/* Remember the pattern of planes that a tile uses. */
static void remember_planes(walk *w, uint32_t ref, uint32_t x0, uint32_t y0)
{
    uint32_t place = find_lately(w, ref);
    if (place == LATELY_KEPT) place--;
    if (place == w->private_lately_count) w->private_lately_count++;
    memmove(w->private_lately + 1, w->private_lately, place * sizeof *w->private_lately);
    w->private_lately[0] = w->private_left[y0 / TILE_PX] = w->private_above[x0 / TILE_PX] = ref + 1;
}

/* A known pattern. 0: invalid. */
static int code_found(walk *w, uint32_t *ref, uint32_t found, uint32_t place, uint32_t left, uint32_t above)
{
    if (found == FOUND_COMMON) return code_from_common(w, KIND_PRIVATE, ref);
    if (found == FOUND_LISTED)
        return use_pattern(w, KIND_PRIVATE, code_number(&w->c, &w->odds->pattern[KIND_PRIVATE], place), ref) != 0;
    uint32_t name = found == FOUND_LEFT ? left : above;
    if (found == FOUND_LATELY) {
        place = code_number(&w->c, &w->odds->private_lately, place);
        name  = place < w->private_lately_count ? w->private_lately[place] : 0;
    }
    *ref = name - 1;
    return found <= FOUND_LATELY && name;
}

/* The private-palette pattern of a tile, and the base of the tile. 0: invalid page.
 * ref  in: in the source */
static int code_private_pattern(walk *w, uint32_t *ref, private_base *base, uint32_t x0, uint32_t y0)
{
    uint32_t left = w->private_left[y0 / TILE_PX], above = w->private_above[x0 / TILE_PX], place = 0;
    uint32_t found = PAGE_ENCODING ? find_private(w, *ref, left, above, &place) : 0;
    found          = code_nibble(&w->c, &w->odds->private_found[likeness(left, above, 0)], found);
    if (found == FOUND_NEW) {
        uint32_t half = w->half;
        if (!code_private(w, *ref, base, x0, y0)) return 0;
        add_pattern(w, KIND_PRIVATE, *ref = half);
    } else if (!code_found(w, ref, found, place, left, above) || !code_base_of(w, base, *ref, x0, y0))
        return 0;
    if (get_half(pool_of(w, *ref), *ref & (REF_COMMON - 1)) >> 12 >= PRIVATE_PLANE) remember_planes(w, *ref, x0, y0);
    return 1;
}

/* tiles: with a single depth, with a pattern over the block palette, or with a private-palette pattern -------------------------- */

/* State of a block during coding. */
typedef struct block {
    _Alignas(16) int16_t depth[16];    /* of the palette entries, in the node */
    uint32_t    entries, class;        /* number of palette entries; class: a rough estimate of it, 0..4 */
    uint32_t    mixed, fresh, own, on; /* on: tiles on the plane */
    uint32_t    tiles, from_tiles;     /* where the words of tiles start: in the page, in the source */
    uint64_t    index;                 /* palette indices of fresh tiles, a nibble each */
    uint32_t    fresh_count, mixed_count, far;
    int32_t     base;
    int32_t     private_base[16];
    block_plane plane;
    sheet       sheet; /* the plane, in the node */
    uint32_t    word;  /* where the block is in the page */
    uint32_t    from;  /* where the block is in the source */
    /* encoder only: the entry of the last uniform tile in the source, and the nibble where that of the next fresh one is */
    uint32_t    entry, entry_at;
    uint16_t    used[16]; /* palette entries used by each tile */
} block;

static int code_uniform_tile(walk *w, block *b, uint32_t t, uint32_t x0, uint32_t y0, uint32_t *last)
{
    uint32_t index = 0;
    if (b->entries > 1) {
        uint32_t in = (1u << b->entries) - 1, none = 16;
        uint32_t left  = page_first_bit((equal_depths(b->depth, w->left[y0]) & in) | 1 << none);
        uint32_t above = page_first_bit((equal_depths(b->depth, w->above[8 + x0]) & in) | 1 << none);
        if (PAGE_ENCODING) {
            if (source_word(w, b->from) >> (16 + t) & 1) {
                b->entry = source_word(w, b->entry_at / 8) >> 4 * (b->entry_at % 8) & 15;
                b->entry_at++;
            }
            index = b->entry == left ? 0 : b->entry == above ? 1 : b->entry < b->entries ? b->entry + 2 : 0;
        }
        uint32_t many = (uint32_t)(b->entries > 3) + (uint32_t)(b->entries > 8);
        index =
            code_nibble_here(&w->c, &w->odds->index[likeness(left, above, none)][many][corner_context(w, x0, y0, TILE_PX)], index);
        index = index == 0 ? left : index == 1 ? above : index - 2;
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
    coder     c    = w->c;
    uint32_t  left = depths_met(b->depth, b->entries, w->left + y0), above = depths_met(b->depth, b->entries, w->above + 8 + x0);
    uint16_t *set = w->fine && b->entries > 4 ? w->s->used_set[set_of(left, above + (b->entries << 16), 13)] : NULL;
    if (set) {
        uint32_t again = code_again(&c, set, USED_LANES, w->odds->used_again[b->entries > 8], value + 1);
        if (again) {
            w->c = c;
            return again - 1;
        }
    }
    uint32_t tiles = (t & 3 ? b->used[t - 1] : 0u) | (t > 3 ? b->used[t - 4] : 0u), either = left | above, used = 0;
    /* span: from the first to the last entry in the borders */
    uint32_t span = either ? (2u << page_last_bit(either)) - (1u << page_first_bit(either)) : 0;
    uint32_t low  = (left & above) | ((tiles | span) & ~either);
    for (uint32_t n = 0; n < b->entries; n += 4) {
        uint32_t k = (low >> n & 15) | (either >> n & 15) << 4, more = b->entries - n;
        used |= code_nibble_here(&c, &w->odds->used[more < 4 ? more : 0][k], value >> n & 15) << n;
    }
    w->c = c;
    if (set) set_add(set, USED_LANES, USED_LANES, used + 1);
    return used;
}

static int code_mixed_tile(walk *w, block *b, uint32_t t, uint32_t x0, uint32_t y0)
{
    uint32_t word = 0, used = 0, low;
    if (PAGE_ENCODING) {
        word = source_word(w, b->from_tiles + b->mixed_count);
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
        draw_pattern(w, border_of_ref(w, ref, ref & (REF_COMMON - 1), kind), depth, x0, y0);
        low = used;
    } else {
        private_base base = {b->base, 0, b->far};
        if (PAGE_ENCODING) {
            if (b->far) {
                uint32_t shape = source_word(w, b->from), mixed = count_bits(shape & 0xffff);
                uint32_t bytes = ((b->entries - 1) << (source_word(w, b->from + 1) >> 24 & 3)) + (count_bits(shape >> 16) + 1) / 2;
                base.value     = (int32_t)source_word(w, b->from_tiles + mixed + (bytes + 3) / 4 + count_bits(b->own));
            } else
                base.value = (int32_t)(word & 0x3fff) - PRIVATE_ZERO;
            if (base.value <= -DEPTH_END || base.value >= DEPTH_END) return 0;
        }
        if (!code_private_pattern(w, &ref, &base, x0, y0)) return 0;
        draw_private(w, ref, b->base + base.value, x0, y0);
        b->private_base[count_bits(b->own)] = base.value;
        b->own |= 1u << t;
        low = b->far ? 0 : (uint32_t)(base.value + PRIVATE_ZERO);
    }
    b->used[t]        = (uint16_t)used;
    w->words[w->tile] = ref << 14 | low;
    b->mixed_count++;
    return 1;
}

#endif
