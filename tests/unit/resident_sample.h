/* Random resident parts of lights in canonical order, written from the layout alone.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RESIDENT_SAMPLE_H
#define RESIDENT_SAMPLE_H

#include "page_sample.h"

typedef struct light_sample {
    uint32_t      *words, word_count, page_count, node_count;
    uint32_t       levels, map_count;
    vxs_page_node *nodes;
    uint32_t      *page_first;
} light_sample;

static inline uint32_t of_even_bits(uint32_t n)
{
    uint32_t x = 0;
    for (uint32_t b = 0; b < 16; b++) x |= (n >> 2 * b & 1) << b;
    return x;
}

/* A random entry at words[at]: a depth, a new node, or one met before. */
static inline void random_entry(rng *r, light_sample *l, uint32_t at, uint32_t map, uint32_t x, uint32_t y)
{
    uint32_t *w = l->words + at, kind = rng_below(r, 4);
    if (kind == 0 || (kind == 3 && !l->node_count)) {
        w[0] = 0x80000000u | (rng_below(r, 2) ? rng_below(r, 4) : rng_below(r, (1 << 18) + 1));
        return;
    }
    if (kind == 3)
        w[0] = l->words[l->nodes[rng_below(r, l->node_count)].base]; /* the word that named it, for now */
    else {
        int      first  = !l->page_count || !rng_below(r, 40) || (l->words[l->nodes[l->node_count - 1].base] & 0xffff) > 60000;
        uint32_t offset = first ? 0 : (l->words[l->nodes[l->node_count - 1].base] & 0xffff) + 1 + rng_below(r, 500);
        if (first) l->page_first[l->page_count++] = l->node_count;
        l->nodes[l->node_count++] = (vxs_page_node){offset, x, y, map, (int32_t)at};
        w[0]                      = (l->page_count - 1) << 16 | offset;
    }
    w[1] = rng_below(r, 2) ? rng_u32(r) : rng_below(r, 100) | 0x40200000;
    if (w[1] >> 24 < (w[1] >> 16 & 255))
        w[1] = (w[1] & 0xffff) | w[1] >> 24 << 16 | (w[1] >> 16 & 255) << 24; /* min is not above max */
}

/* A light whose common pool is c; page words are put in when their number is known: tops are made in words of their own first. */
static inline void light_make(rng *r, light_sample *l, const sample_common *c, uint32_t levels, uint32_t map_count)
{
    uint32_t side = levels <= 8 ? 1 : 1u << (levels - 8), cells = side / 8, at = 0, top[6];
    *l            = (light_sample){.levels = levels, .map_count = map_count};
    uint32_t most = map_count * (levels < 15 ? 2 * side * side : cells * cells * 129);
    l->words      = calloc(most + 1, 4);
    l->nodes      = calloc(most + 1, sizeof *l->nodes);
    l->page_first = calloc(most + 1, 4);
    for (uint32_t map = 0; map < map_count; map++) {
        top[map] = at;
        at += levels < 15 ? 2 * side * side : cells * cells;
        for (uint32_t n = 0; levels < 15 && n < side * side; n++) {
            uint32_t x = of_even_bits(n), y = of_even_bits(n >> 1);
            random_entry(r, l, top[map] + 2 * (y * side + x), map, x, y);
        }
        for (uint32_t n = 0; levels >= 15 && n < cells * cells; n++) {
            uint32_t x = of_even_bits(n), y = of_even_bits(n >> 1), cell = top[map] + y * cells + x;
            if (rng_below(r, 3)) {
                l->words[cell] = 0x80000000u | rng_below(r, 5);
                continue;
            }
            l->words[cell] = at;
            for (uint32_t k = 0; k < 64; k++) {
                uint32_t ex = of_even_bits(k), ey = of_even_bits(k >> 1);
                random_entry(r, l, at + 2 * (8 * ey + ex), map, 8 * x + ex, 8 * y + ey);
            }
            at += 128;
        }
    }
    /* lay it out */
    uint32_t  head = 8 + l->page_count, pool = (c->common.half_count + 1) / 2;
    uint32_t *all = calloc(head + at + pool, 4);
    memcpy(all + head, l->words, 4 * at);
    memcpy(all + head + at, c->words, 4 * pool);
    for (uint32_t map = 0; map < map_count; map++) {
        all[2 + map] = head + top[map];
        for (uint32_t n = 0; levels >= 15 && n < cells * cells; n++)
            if (!(all[head + top[map] + n] & 0x80000000u)) all[head + top[map] + n] += head;
    }
    for (uint32_t n = 0; n < l->node_count; n++)
        l->nodes[n].base = (int32_t)(l->words[l->nodes[n].base + 1] & 0xffff) << (levels > 16 ? levels - 16 : 0);
    all[0] = l->page_count;
    all[1] = head + at;
    free(l->words);
    l->words                     = all;
    l->word_count                = head + at + pool;
    l->page_first[l->page_count] = l->node_count;
}

static inline void light_free(light_sample *l)
{
    free(l->words);
    free(l->nodes);
    free(l->page_first);
}

#endif
