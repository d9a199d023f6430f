/* Random pages and resident parts in canonical order, and a check of words against the layout as a lookup meets it: both written
 * from the layout alone, they share nothing with the coder.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PAGE_SAMPLE_H
#define PAGE_SAMPLE_H

#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "formats/vxs_page.h"

enum { SAMPLE_NODES_MAX = 12000, SAMPLE_COMMON_MAX = 64, SAMPLE_HALVES = 1 << 17, SAMPLE_LONGEST = 128, REF_OF_COMMON = 0x20000 };

/* Halves of a pattern, and how many depths of a palette it parts; 0: it has its own. */
typedef struct sample_pattern {
    uint16_t half[SAMPLE_LONGEST];
    uint32_t halves, kind, ref;
} sample_pattern;

typedef struct sample_page {
    uint32_t       words[VXS_PAGE_WORDS_MAX], word_count, node_count;
    vxs_page_node  nodes[SAMPLE_NODES_MAX];
    uint16_t       pool[SAMPLE_HALVES];
    uint32_t       pool_halves;
    uint16_t       blocks[VXS_PAGE_WORDS_MAX]; /* where blocks start */
    uint32_t       block_count;
    sample_pattern known[256]; /* patterns that may be used again */
    uint32_t       known_count;
    uint32_t       fix[VXS_PAGE_WORDS_MAX], fix_count; /* words of tiles whose pattern is of this page */
    uint32_t       plane[2];                           /* of the last block that had one */
} sample_page;

typedef struct sample_common {
    uint32_t       words[SAMPLE_COMMON_MAX * SAMPLE_LONGEST / 2 + 1], count;
    sample_pattern pattern[SAMPLE_COMMON_MAX];
    uint32_t       patterns[SAMPLE_COMMON_MAX];
    vxs_common     common;
} sample_common;

static inline uint32_t count_ones(uint32_t x)
{
    uint32_t n = 0;
    for (; x; x &= x - 1) n++;
    return n;
}

/* Mostly small, at times any. */
static inline uint32_t sample_number(rng *r, uint32_t end)
{
    uint32_t least = end < 12 ? end : 12;
    return rng_below(r, 4) ? rng_below(r, least) : rng_below(r, end);
}

/* patterns --------------------------------------------------------------------------------------------------------------------- */

/* Indices of 64 texels: all alike, a slanted edge, or noise. */
static inline void sample_indices(rng *r, uint32_t depths, uint8_t *index)
{
    uint32_t style = rng_below(r, 3), dx = rng_below(r, 3), dy = rng_below(r, 3), start = rng_below(r, 8);
    for (uint32_t z = 0; z < 64; z++) {
        uint32_t c = z / 16, x = (c & 1) * 4 + z % 4, y = (c >> 1) * 4 + z / 4 % 4, n = (x * dx + y * dy + start) / 6;
        index[z] = (uint8_t)(style == 0 ? start % depths : style == 1 ? (n < depths ? n : depths - 1) : rng_below(r, depths));
    }
}

/* Masks, or the image where that is shorter. */
static inline void sample_masks(sample_pattern *p, const uint8_t *index, uint32_t depths)
{
    uint8_t  state[16] = {0};
    uint16_t own[64];
    uint32_t owns = 0, states = depths / 2;
    for (uint32_t c = 0; c < 4; c++) {
        int have = 0;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            uint32_t mask = 0, s = 2;
            for (uint32_t z = 0; z < 16; z++)
                if (index[16 * c + z] <= n) mask |= 1u << z;
            if (mask == 0) s = 0;
            if (mask == 0xffff) s = 1;
            if (s == 2 && have && own[owns - 1] == mask) s = 3;
            if (s == 2) own[owns++] = (uint16_t)mask, have = 1;
            state[n] |= (uint8_t)(s << 2 * c);
        }
    }
    uint16_t *to = p->half + p->halves;
    if (states + owns > 17) {
        to[0] = 0xff;
        for (uint32_t n = 0; n < 16; n++)
            to[1 + n] = (uint16_t)(index[2 * n] | index[2 * n + 32] << 4 | index[2 * n + 1] << 8 | index[2 * n + 33] << 12);
        p->halves += 17;
        return;
    }
    for (uint32_t n = 0; n < states; n++) to[n] = (uint16_t)(state[2 * n] | state[2 * n + 1] << 8);
    memcpy(to + states, own, owns * sizeof *own);
    p->halves += states + owns;
}

/* How steep a plane is, along one side. */
static inline uint16_t sample_step(rng *r)
{
    return (uint16_t)(rng_below(r, 8) ? rng_below(r, 200) - 100 : rng_u32(r));
}

/* One plane, or two. */
static inline void sample_private_planes(rng *r, sample_pattern *p, uint32_t kind)
{
    p->half[0] =
        (uint16_t)(kind << 12 | rng_below(r, 9) << 8 | rng_below(r, kind == 7 ? 4 : 16) << 3 | (kind > 7 ? rng_below(r, 6) : 0));
    p->halves = kind == 7 ? 3 : kind < 10 ? 6 : 10;
    for (uint32_t n = 1; n < (kind == 7 ? 3 : 5); n++) p->half[n] = sample_step(r);
    if (kind == 7) return;
    p->half[5] = (uint16_t)sample_number(r, 1 << 16);
    for (uint32_t n = 6; n < p->halves; n++) p->half[n] = (uint16_t)(rng_below(r, 2) ? 0xff00 : rng_u32(r));
}

static inline void sample_private(rng *r, sample_pattern *p)
{
    uint32_t kind = rng_below(r, 11);
    if (kind >= 7) {
        sample_private_planes(r, p, kind);
        return;
    }
    uint32_t shift = rng_below(r, 3) ? 0 : rng_below(r, kind < 2 || kind == 3 || kind == 4 ? 8 : 1);
    uint8_t  index[64], *bytes = (uint8_t *)(p->half + 1);
    p->half[0] = (uint16_t)(kind << 12 | shift << 8);
    p->halves  = 1;
    if (kind < 3) {
        uint32_t depths = 2 + rng_below(r, 15), delta = 0, most = kind == 0 ? 16 : kind == 1 ? 4000 : 20000;
        p->half[0] |= (uint16_t)depths;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            delta += 1 + sample_number(r, most);
            if (kind == 0) bytes[n] = (uint8_t)delta;
            if (kind == 1) p->half[1 + n] = (uint16_t)delta;
            if (kind == 2) p->half[1 + 2 * n] = (uint16_t)delta, p->half[2 + 2 * n] = (uint16_t)(delta >> 16);
        }
        if (kind == 0 && depths % 2 == 0) bytes[depths - 1] = 0;
        p->halves += kind == 0 ? depths / 2 : (depths - 1) * kind;
        sample_indices(r, depths, index);
        sample_masks(p, index, depths);
        return;
    }
    if (kind == 3) {
        int lowest = rng_below(r, 4) != 0; /* a nibble of each quadrant is 0 */
        for (uint32_t c = 0; c < 4; c++) bytes[c] = (uint8_t)rng_below(r, 256);
        for (uint32_t n = 0; n < 32; n++) bytes[4 + n] = (uint8_t)rng_below(r, 256);
        for (uint32_t n = 0; n < 32 && lowest; n += 16) bytes[4 + n] = 0;
        p->halves += 18;
    } else {
        uint32_t size = kind - 3, start = rng_below(r, 200), noise = rng_below(r, 2);
        for (uint32_t z = 0; z < 64; z++) {
            uint32_t depth = noise ? rng_below(r, 1u << 8 * size) : start + z % 4 + z / 16;
            if (size == 3) depth &= (1 << 18) - 1;
            for (uint32_t b = 0; b < size; b++) bytes[z * size + b] = (uint8_t)(depth >> 8 * b);
        }
        p->halves += 32 * size;
    }
}

/* kind: 0, or how many depths of a palette. */
static inline void sample_pattern_make(rng *r, sample_pattern *p, uint32_t kind)
{
    uint8_t index[64];
    memset(p, 0, sizeof *p);
    p->kind = kind;
    if (!kind) {
        sample_private(r, p);
        return;
    }
    sample_indices(r, kind, index);
    sample_masks(p, index, kind);
}

/* A common pool of `count` patterns. Returns what vxs_common_index says of it. */
static inline vxs_result sample_common_make(rng *r, sample_common *c, uint32_t count)
{
    uint8_t  kinds[SAMPLE_COMMON_MAX];
    uint32_t halves = 0;
    memset(c, 0, sizeof *c);
    for (c->count = 0; c->count < count; c->count++) {
        sample_pattern *p = &c->pattern[c->count];
        uint32_t        n = rng_below(r, 14);
        sample_pattern_make(r, p, n ? n + 1 : 0);
        p->ref = REF_OF_COMMON | halves;
        memcpy((uint16_t *)c->words + halves, p->half, 2 * p->halves);
        halves += p->halves;
        kinds[c->count] = (uint8_t)p->kind;
    }
    vxs_result result = vxs_common_index(&c->common, c->patterns, kinds, count, c->words, halves);
    c->common.packing = count & 1 ? VXS_PACKING_SMALL : VXS_PACKING_FINE;
    return result;
}

/* pages ------------------------------------------------------------------------------------------------------------------------ */

/* Words of a page being made. */
static inline uint32_t sample_used(const sample_page *p)
{
    return p->word_count + (p->pool_halves + 1) / 2;
}

/* A pattern of a kind: of the common pool, known in this page, or new. */
static inline uint32_t sample_ref(rng *r, sample_page *p, const sample_common *c, uint32_t kind)
{
    if (rng_below(r, 2))
        for (uint32_t n = 0; n < c->count; n++)
            if (c->pattern[n].kind == kind && rng_below(r, 2)) return c->pattern[n].ref;
    if (rng_below(r, 2))
        for (uint32_t n = 0; n < p->known_count; n++)
            if (p->known[n].kind == kind) return p->known[n].ref;
    sample_pattern new;
    sample_pattern_make(r, &new, kind);
    new.ref = p->pool_halves;
    memcpy(p->pool + p->pool_halves, new.half, 2 * new.halves);
    p->pool_halves += new.halves;
    p->known[p->known_count < 256 ? p->known_count++ : rng_below(r, 256)] = new;
    return new.ref;
}

/* The plane of a block: any, or as the last one of the page, or as steep. */
static inline void sample_plane(rng *r, sample_page *p, uint32_t *words)
{
    if (rng_below(r, 4)) p->plane[1] = rng_below(r, 9) | (rng_below(r, 2) ? rng_below(r, 256) << 4 : rng_u32(r) & ~15u);
    if (rng_below(r, 2)) p->plane[0] = sample_step(r) | (uint32_t)sample_step(r) << 16;
    words[0] = p->plane[0];
    words[1] = p->plane[1];
}

static inline void sample_block(rng *r, sample_page *p, const sample_common *c)
{
    uint32_t *w = p->words + p->word_count, q = 1 + rng_below(r, 14), shift = rng_below(r, 2) ? 0 : rng_below(r, 6);
    uint32_t width = rng_below(r, 4) ? 0 : rng_below(r, 3), far = !rng_below(r, 8), mixed = rng_u32(r) & 0xffff, own = 0, fresh = 0;
    uint32_t at = 2, on = rng_below(r, 3) ? 0 : rng_u32(r) & 0xffff; /* where words of tiles are; which tiles are on a plane */
    uint32_t delta = 0, last = 16, count = 0, tiles = 0;
    uint8_t  nibbles[16];
    int32_t  base[16];
    if (width == 2) shift = 0;
    if (!rng_below(r, 8)) mixed = 0;
    if (!rng_below(r, 8)) mixed = 0, on = 0xffff;
    if (on == 0xffff && rng_below(r, 2)) q = 1, shift = width = far = 0; /* nothing but the plane */
    on &= ~mixed;
    if (on) sample_plane(r, p, w + at), at += 2;
    p->blocks[p->block_count++] = (uint16_t)p->word_count;
    for (uint32_t t = 0; t < 16; t++) {
        if (on >> t & 1) continue;
        if (!(mixed >> t & 1)) {
            uint32_t n = rng_below(r, 2) && last < 16 ? last : rng_below(r, q);
            if (n != last) fresh |= 1u << t, nibbles[count++] = (uint8_t)(last = n);
            continue;
        }
        uint32_t used = 0, depths = 0, low;
        for (uint32_t n = 0; n < q; n++)
            if (rng_below(r, 2)) used |= 1u << n, depths++;
        if (depths < 2) depths = 0;
        uint32_t ref = sample_ref(r, p, c, depths);
        if (depths)
            low = used;
        else {
            int32_t b = (int32_t)sample_number(r, far ? 500000 : 16384) - (far ? 250000 : 8192);
            if (rng_below(r, 2)) b = (int32_t)rng_below(r, 20) - 10;
            base[count_ones(own)] = b;
            own |= 1u << t;
            low = far ? 0 : (uint32_t)(b + 8192);
        }
        if (!(ref & REF_OF_COMMON)) p->fix[p->fix_count++] = p->word_count + at + tiles;
        w[at + tiles++] = ref << 14 | low;
    }
    w[0]           = mixed | fresh << 16;
    w[1]           = own | on | (q - 1) << 16 | shift << 20 | width << 24 | far << 26;
    uint8_t *bytes = (uint8_t *)(w + at + tiles);
    for (uint32_t n = 0; n + 1 < q; n++) {
        delta += 1 + sample_number(r, width == 0 ? 18 : width == 1 ? 4000 : 18000);
        for (uint32_t b = 0; b < 1u << width; b++) *bytes++ = (uint8_t)(delta >> 8 * b);
    }
    for (uint32_t n = 0; n < count; n += 2) *bytes++ = (uint8_t)(nibbles[n] | (n + 1 < count ? nibbles[n + 1] << 4 : 0));
    p->word_count += at + tiles + (((q - 1) << width) + (count + 1) / 2 + 3) / 4;
    for (uint32_t n = 0; far && n < count_ones(own); n++) p->words[p->word_count++] = (uint32_t)base[n];
}

/* A node with some mixed blocks. x, y: where it is. */
static inline void sample_node(rng *r, sample_page *p, const sample_common *c, uint64_t mixed, int wide, uint32_t x, uint32_t y)
{
    uint16_t head[16] = {0}, ref[64], tail[256];
    uint32_t start = p->word_count, refs = 0, tails = 0, last = 0, depths = 0, values[64];
    uint64_t fresh = 0;
    for (uint32_t n = 0; n < 64; n++) {
        if (mixed >> n & 1) {
            uint32_t base = sample_number(r, wide ? 400000 : 65535);
            tail[tails++] = (uint16_t)base;
            if (wide) tail[tails++] = (uint16_t)(base >> 16);
            refs++;
            continue;
        }
        uint32_t depth = rng_below(r, 3) && fresh ? last
                         : rng_below(r, 8)        ? sample_number(r, wide ? 400000 : 65535)
                         : wide                   ? ~0u
                                                  : 0xffff;
        if (fresh && depth == last) continue;
        fresh |= (uint64_t)1 << n;
        values[depths++] = last = depth;
    }
    for (uint32_t n = 0; n < depths; n++) {
        tail[tails++] = (uint16_t)values[n];
        if (wide) tail[tails++] = (uint16_t)(values[n] >> 16);
    }
    for (uint32_t n = 0; n < 4; n++) head[n] = (uint16_t)(mixed >> 16 * n), head[4 + n] = (uint16_t)(fresh >> 16 * n);
    if (rng_below(r, 2)) head[8] = (uint16_t)rng_below(r, 300), head[9] = (uint16_t) - (int32_t)rng_below(r, 300);
    head[10]                  = (uint16_t)wide;
    p->nodes[p->node_count++] = (vxs_page_node){start, x, y, 0, (int32_t)rng_below(r, 1000)};
    p->word_count += (11 + refs + tails + 1) / 2;
    for (uint32_t n = 0; n < refs; n++) {
        int again = p->block_count && !rng_below(r, 4);
        ref[n]    = again ? p->blocks[rng_below(r, p->block_count)] : (uint16_t)p->word_count;
        if (!again) sample_block(r, p, c);
    }
    uint16_t *to = (uint16_t *)(p->words + start);
    memcpy(to, head, 22);
    memcpy(to + 11, ref, 2 * refs);
    memcpy(to + 11 + refs, tail, 2 * tails);
}

/* Put the pool behind nodes and blocks. */
static inline void sample_close(sample_page *p)
{
    for (uint32_t n = 0; n < p->fix_count; n++) p->words[p->fix[n]] += 2 * p->word_count << 14;
    memcpy(p->words + p->word_count, p->pool, 2 * p->pool_halves);
    p->word_count += (p->pool_halves + 1) / 2;
}

/* A page of some nodes; or, if nodes is 0, of as many as there is room for, to the last word. */
static inline void sample_page_make(rng *r, sample_page *p, const sample_common *c, uint32_t nodes)
{
    memset(p, 0, sizeof *p);
    uint32_t n = 0;
    for (; nodes ? n < nodes : sample_used(p) + 8000 < VXS_PAGE_WORDS_MAX;
         n++) { /* 8 blocks of 16 patterns of 49 words each, and more */
        uint64_t mixed = 0;
        for (uint32_t k = rng_below(r, nodes ? 4 : 9); k > 0; k--) mixed |= (uint64_t)1 << rng_below(r, 64);
        if (!nodes && n == 0) mixed = 0xff;
        sample_node(r, p, c, mixed, !rng_below(r, 4), n % 9, n / 9);
    }
    while (!nodes && sample_used(p) < VXS_PAGE_WORDS_MAX) { /* nodes of uniform blocks: 6 words with one depth, 12 with 12 */
        uint32_t room = VXS_PAGE_WORDS_MAX - sample_used(p), depths = room < 12 ? 2 * room - 11 : 1;
        uint64_t fresh            = 1;
        p->nodes[p->node_count++] = (vxs_page_node){p->word_count, n % 9, n / 9, 0, 0};
        for (uint32_t d = 1; d < depths; d++) fresh |= (uint64_t)1 << d;
        uint16_t *to = (uint16_t *)(p->words + p->word_count);
        for (uint32_t k = 0; k < 4; k++) to[4 + k] = (uint16_t)(fresh >> 16 * k);
        for (uint32_t d = 0; d < depths; d++) to[11 + d] = (uint16_t)(d & 1 ? n : n + 1 + d);
        p->word_count += (11 + depths + 1) / 2;
        n++;
    }
    sample_close(p);
}

/* the layout, as a lookup meets it --------------------------------------------------------------------------------------------- */

typedef struct checked_words {
    const uint32_t *words;
    uint32_t        halves; /* that may be read */
} checked_words;

static inline uint32_t checked_half(checked_words w, uint32_t half, int *good)
{
    if (half >= w.halves) *good = 0;
    return half < w.halves ? w.words[half / 2] >> 16 * (half & 1) & 0xffff : 0;
}

static inline uint32_t checked_byte(checked_words w, uint32_t byte, int *good)
{
    return checked_half(w, byte / 2, good) >> 8 * (byte & 1) & 0xff;
}

/* A pattern of `depths` depths. */
static inline void check_masks(checked_words w, uint32_t half, uint32_t depths, int *good)
{
    if (checked_byte(w, 2 * half, good) == 0xff) {
        for (uint32_t n = 0; n < 32; n++) {
            uint32_t both = checked_byte(w, 2 * half + 2 + n, good);
            if ((both & 15) >= depths || both >> 4 >= depths) *good = 0;
        }
        return;
    }
    uint32_t own = half + depths / 2;
    for (uint32_t c = 0; c < 4; c++) {
        uint32_t before = 0, have = 0, last = 0;
        for (uint32_t n = 0; n + 1 < depths; n++) {
            uint32_t state = checked_byte(w, 2 * half + n, good) >> 2 * c & 3;
            if (state == 3 && !have) *good = 0;
            if (state == 2) last = checked_half(w, own++, good), have = 1;
            uint32_t mask = state == 0 ? 0 : state == 1 ? 0xffff : last;
            if (before & ~mask) *good = 0; /* nested */
            before = mask;
        }
    }
}

static inline void check_private(checked_words w, uint32_t half, int *good)
{
    uint32_t head = checked_half(w, half, good), kind = head >> 12, depths = head & 0xff, last = 0;
    if (kind >= 3) {
        static const uint32_t ends[] = {18, 32, 64, 96, 2, 5, 5, 9};
        if (kind > 10 || (kind < 7 && depths) || (kind == 7 && depths & 0xe7)) *good = 0;
        if (kind > 7 && (depths >> 7 || (depths & 7) > 5)) *good = 0;
        if (kind > 6 && (head >> 8 & 15) > 8)
            *good = 0;
        else
            checked_half(w, half + ends[kind - 3], good);
        return;
    }
    if (depths < 2 || depths > 16) {
        *good = 0;
        return;
    }
    for (uint32_t n = 0; n + 1 < depths; n++) {
        uint32_t delta = kind == 0   ? checked_byte(w, 2 * half + 2 + n, good)
                         : kind == 1 ? checked_half(w, half + 1 + n, good)
                                     : checked_half(w, half + 1 + 2 * n, good) | checked_half(w, half + 2 + 2 * n, good) << 16;
        if (delta <= last || (uint64_t)delta << (head >> 8 & 15) > INT32_MAX) *good = 0;
        last = delta;
    }
    check_masks(w, half + 1 + (kind == 0 ? depths / 2 : (depths - 1) * kind), depths, good);
}

static inline void check_block(checked_words page, checked_words common, uint32_t word, int *good)
{
    uint32_t half = 2 * word, mixed = checked_half(page, half, good), fresh = checked_half(page, half + 1, good);
    uint32_t own = checked_half(page, half + 2, good), head = checked_half(page, half + 3, good), on = own & ~mixed;
    uint32_t q = (head & 15) + 1, shift = head >> 4 & 15, width = head >> 8 & 3, far = head >> 10 & 1, last = 0,
             tiles = count_ones(mixed);
    if (((mixed | on) & fresh) || q > 14 || width > 2 || (width == 2 && shift) || head >> 11) *good = 0;
    if ((mixed | on) != 0xffff && !(fresh & (~(mixed | on) & ((mixed | on) + 1)))) *good = 0; /* the first uniform tile is fresh */
    if (on && (checked_half(page, half + 6, good) & 15) > 8) *good = 0;
    if (!*good) return;
    uint32_t at = on ? 4 : 2, byte = 4 * (word + at + tiles), indices = byte + ((q - 1) << width);
    for (uint32_t n = 0; n + 1 < q; n++) {
        uint32_t delta = 0;
        for (uint32_t b = 0; b < 1u << width; b++) delta |= checked_byte(page, byte + (n << width) + b, good) << 8 * b;
        if (delta <= last || (uint64_t)delta << shift > INT32_MAX) *good = 0;
        last = delta;
    }
    for (uint32_t n = 0; n < count_ones(fresh); n++)
        if ((checked_byte(page, indices + n / 2, good) >> 4 * (n & 1) & 15) >= q) *good = 0;
    uint32_t nth = 0, end = (indices + (count_ones(fresh) + 1) / 2 + 3) / 4;
    if (on) checked_half(page, half + 2 * at - 1, good);
    if (far && own & mixed) checked_half(page, 2 * (end + count_ones(own & mixed)) - 1, good);
    for (uint32_t t = 0; t < 16; t++) {
        if (!(mixed >> t & 1)) continue;
        uint32_t tile = checked_half(page, half + 2 * (at + nth), good) | checked_half(page, half + 2 * (at + nth) + 1, good) << 16;
        uint32_t ref = tile >> 14, low = tile & 0x3fff;
        checked_words w = ref & REF_OF_COMMON ? common : page;
        nth++;
        if (own >> t & 1)
            check_private(w, ref & (REF_OF_COMMON - 1), good);
        else if (low >> q || count_ones(low) < 2)
            *good = 0;
        else
            check_masks(w, ref & (REF_OF_COMMON - 1), count_ones(low), good);
    }
}

/* Whether lookups through these nodes stay within the page and the common pool, and meet what the layout allows. */
static inline int check_page(const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes, uint32_t node_count,
                             const vxs_common *pool)
{
    checked_words page = {words, 2 * word_count}, common = {pool->words, pool->half_count};
    int           good = 1;
    for (uint32_t n = 0; n < node_count && good; n++) {
        uint32_t half = 2 * nodes[n].offset, wide = checked_half(page, half + 10, &good), size = wide ? 2 : 1, all = 0, depths = 0,
                 first = 1;
        if (wide > 1) good = 0;
        for (uint32_t c = 0; c < 64; c++) {
            uint32_t mixed = checked_half(page, half + c / 16, &good) >> c % 16 & 1,
                     fresh = checked_half(page, half + 4 + c / 16, &good) >> c % 16 & 1;
            if ((mixed && fresh) || (!mixed && !fresh && first)) good = 0;
            first &= (int)mixed;
            all += mixed;
            depths += fresh;
        }
        for (uint32_t m = 0; m < all && good; m++) check_block(page, common, checked_half(page, half + 11 + m, &good), &good);
        checked_half(page, half + 11 + all + size * (all + depths) - 1, &good);
    }
    return good;
}

#endif
