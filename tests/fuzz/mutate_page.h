/* Changes to words of lights: a page is decoded, a number of a plane or any other word becomes another, and it is coded again: a
 * good page, with planes that no bake makes. Words of the resident part change in the same way: entries of tops, and patterns that
 * pages share. What breaks a rule cannot be coded, and stays as it was.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MUTATE_PAGE_H
#define MUTATE_PAGE_H

#include "formats/vxs_page_encode.c" /* no part of the runtime, on which fuzz_vxs stands */
#include "fuzz.h"
#include "tests/unit/page_encoded.h"

enum { PLACES_MAX = 4096, LIGHT_WORDS_MAX = 1 << 18 };

/* The resident part of a light, and what decodes its pages. */
typedef struct light_pages {
    vxs_resident_sizes sizes;
    vxs_resident       resident;
    vxs_page_scratch  *scratch;
} light_pages;

static void light_pages_free(light_pages *l)
{
    free(l->resident.words);
    free(l->resident.nodes);
    free(l->resident.page_first);
    free(l->resident.patterns);
    free(l->scratch);
}

/* 0: it is no resident part. */
static int light_pages_read(light_pages *l, uint32_t levels, uint32_t map_count, uint32_t packing, const uint8_t *bytes,
                            size_t size)
{
    *l = (light_pages){0};
    if (levels < 3 || levels > 18) return 0;
    if (vxs_resident_sizes_of(&l->sizes, bytes, size) != VXS_OK || l->sizes.word_count > LIGHT_WORDS_MAX) return 0;
    l->scratch  = malloc(vxs_page_scratch_bytes());
    l->resident = (vxs_resident){.words      = malloc(l->sizes.word_count * sizeof(uint32_t)),
                                 .nodes      = malloc((l->sizes.node_count + 1) * sizeof(vxs_page_node)),
                                 .page_first = malloc((l->sizes.page_count + 1) * sizeof(uint32_t)),
                                 .patterns   = malloc((l->sizes.pattern_count + 1) * sizeof(uint32_t))};
    FUZZ_CHECK(l->scratch && l->resident.words && l->resident.nodes && l->resident.page_first && l->resident.patterns);
    return vxs_resident_decode(&l->resident, levels, map_count, packing, bytes, size, l->scratch) == VXS_OK;
}

/* Halves of a page that are numbers of planes. */
typedef struct plane_places {
    uint32_t half[PLACES_MAX], count;
} plane_places;

static void add_places(plane_places *p, uint32_t half, uint32_t count)
{
    while (count-- && p->count < PLACES_MAX) p->half[p->count++] = half++;
}

static void find_planes_of_block(plane_places *p, const uint32_t *words, uint32_t at)
{
    uint32_t mixed = words[at] & 0xffff, own = words[at + 1] & 0xffff, tile = at + head_words(mixed, own);
    if (own & ~mixed) add_places(p, 2 * at + 4, 4);
    for (uint32_t t = 0; t < 16; t++) {
        if (!(mixed >> t & 1)) continue;
        uint32_t ref = words[tile++] >> 14;
        if (own >> t & 1 && !(ref & REF_COMMON) && get_half(words, ref) >> 12 >= PRIVATE_PLANE)
            add_places(p, ref, private_halves[get_half(words, ref) >> 12]);
    }
}

static void find_planes(plane_places *p, const uint32_t *words, const vxs_page_node *nodes, uint32_t node_count)
{
    p->count = 0;
    for (uint32_t n = 0; n < node_count; n++) {
        uint32_t half = 2 * nodes[n].offset, blocks = 0;
        for (uint32_t k = 0; k < 4; k++) blocks += count_bits(get_half(words, half + k));
        for (uint32_t b = 0; b < blocks; b++) find_planes_of_block(p, words, get_half(words, half + NODE_HALVES + b));
    }
}

/* One half or one byte of words[first .. first + count - 1], which `place` says, becomes another, or more or less by one. */
static void change_some_word(uint32_t *words, uint32_t first, uint32_t count, uint32_t place, uint32_t number)
{
    uint32_t *word = words + first + place % count, low = 8 * (place >> 16 & 3),
             mask = number & 0x10000 ? 0xffu << low : 0xffffu << (low & 16);
    uint32_t one = mask & -mask, more = *word + (number & 2 ? one : -one);
    *word = (*word & ~mask) | ((number & 1 ? more : number * one) & mask);
}

/* Code the resident part of a light again, with one of its words changed.
 * out  what it is coded to; of no bytes when it cannot be */
static void change_resident(vxs_bytes *out, light_pages *l, uint32_t levels, uint32_t map_count, uint32_t place, uint32_t number)
{
    vxs_resident *r     = &l->resident;
    uint32_t      first = RESIDENT_WORDS + l->sizes.page_count, count = l->sizes.word_count - first, kept = 0, at = 0;
    *out = (vxs_bytes){0};
    if (!count) return;
    at   = first + place % count;
    kept = r->words[at];
    change_some_word(r->words, first, count, place, number);
    (void)resident_encoded(out, r->words, l->sizes.word_count, levels, map_count, &r->common);
    r->words[at] = kept;
}

/* Code a page of a light again, with one number of a plane changed: `place` of them becomes `number`; or, any: with any of its
 * words changed.
 * out  what it is coded to; of no bytes when it cannot be */
static void change_plane(vxs_bytes *out, const light_pages *l, uint32_t page, const uint8_t *bytes, size_t size, int any,
                         uint32_t place, uint32_t number)
{
    const vxs_resident  *r     = &l->resident;
    const vxs_page_node *nodes = r->nodes + r->page_first[page];
    uint32_t             count = vxs_page_word_count(bytes, size), node_count = r->page_first[page + 1] - r->page_first[page];
    uint32_t            *words = malloc((count + 1) * sizeof *words);
    plane_places         places;
    FUZZ_CHECK(words);
    *out = (vxs_bytes){0};
    if (vxs_page_decode(words, bytes, size, nodes, node_count, &r->common, l->scratch) == VXS_OK) {
        find_planes(&places, words, nodes, node_count);
        uint32_t half = places.count ? places.half[place % places.count] : 0;
        if (any)
            change_some_word(words, 0, count, place, number);
        else if (places.count)
            words[half / 2] ^= ((get_half(words, half) ^ number) & 0xffff) << 16 * (half & 1);
        if (any || places.count) (void)page_encoded(out, words, count, nodes, node_count, &r->common);
    }
    free(words);
}

#endif
