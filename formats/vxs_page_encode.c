/* Encoding pages and the resident part: words to bytes; vxs_page.h.
 * SPDX-License-Identifier: MIT */
#define PAGE_ENCODING 1
#include "vxs_resident_model.h"

/* Reserve `more` bytes at the end. 0: no memory. */
static int reserve(vxs_bytes *b, size_t more)
{
    if (b->capacity_bytes - b->size_bytes >= more) return 1;
    size_t   capacity = b->size_bytes + more + b->capacity_bytes / 2;
    uint8_t *grown    = realloc(b->data, capacity);
    if (!grown) return 0;
    b->data           = grown;
    b->capacity_bytes = capacity;
    return 1;
}

/* Append the coded words and the two states. Symbols use the two states alternately. The last symbol is coded first, so that
 * the decoder gets the first symbol first. */
static int append_coded(vxs_bytes *out, const coder *c)
{
    uint16_t *words    = malloc((c->count + 1) * sizeof *words);
    uint32_t  state[2] = {STATE_LEAST, STATE_LEAST};
    size_t    count    = 0;
    int       done     = words && reserve(out, 2 * c->count + 8);
    if (!done) goto done;
    for (size_t n = c->count; n-- > 0;) {
        uint32_t from = c->parts[n] >> 16, size = c->parts[n] & 0xffff, *s = &state[n & 1];
        if (*s >> 16 >= size << 1) {
            words[count++] = (uint16_t)*s;
            *s >>= 16;
        }
        *s = (*s / size << ODDS_BITS) + *s % size + from;
    }
    uint8_t *to = out->data + out->size_bytes;
    for (size_t n = count; n-- > 0; to += 2) vxs_store16(to, words[n]);
    vxs_store32(to, state[0]);
    vxs_store32(to + 4, state[1]);
    out->size_bytes += 2 * count + 8;
done:
    free(words);
    return done;
}

vxs_result vxs_page_encode(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                           uint32_t node_count, const vxs_common *common)
{
    if (!node_count || !word_count || word_count > VXS_PAGE_WORDS_MAX) return VXS_E_ARGUMENT;
    walk w         = {.source = words, .word_count = word_count, .common = common};
    w.node_words   = node_words_of(words, word_count, nodes, node_count);
    w.s            = malloc(sizeof *w.s);
    w.words        = calloc(word_count, sizeof *w.words);
    w.pattern_rank = calloc((size_t)1 << 18, sizeof *w.pattern_rank);
    w.block_rank   = calloc(VXS_PAGE_WORDS_MAX, sizeof *w.block_rank);
    vxs_result r   = VXS_E_MEMORY;
    if (w.s && w.words && w.pattern_rank && w.block_rank && reserve(out, 4)) {
        w.odds   = &w.s->odds;
        int same = w.node_words && code_page(&w, nodes, node_count) && !memcmp(w.words, words, word_count * sizeof *words);
        if (!w.c.no_memory) r = same ? VXS_OK : VXS_E_ARGUMENT;
    }
    if (r == VXS_OK) {
        size_t before = out->size_bytes;
        vxs_store16(out->data + before, (uint16_t)(word_count - 1));
        vxs_store16(out->data + before + 2, (uint16_t)(w.node_words - 1));
        out->size_bytes += 4;
        if (!append_coded(out, &w.c)) {
            out->size_bytes = before;
            r               = VXS_E_MEMORY;
        }
    }
    free(w.c.parts);
    free(w.s);
    free(w.words);
    free(w.pattern_rank);
    free(w.block_rank);
    return r;
}

vxs_result vxs_resident_encode(vxs_bytes *out, const uint32_t *words, uint32_t word_count, uint32_t levels, uint32_t map_count,
                               const vxs_common *common)
{
    if (word_count < RESIDENT_WORDS || words[0] > VXS_PAGES_MAX) return VXS_E_ARGUMENT;
    top_odds      odds;
    resident_walk r   = {.w             = {.source = words, .word_count = word_count},
                         .odds          = &odds,
                         .levels        = levels,
                         .map_count     = map_count,
                         .page_count    = words[0],
                         .node_count    = word_count / 2, /* upper bound; the exact number is known afterwards */
                         .pattern_count = common->first[VXS_PATTERN_KINDS]};
    r.w.s             = malloc(sizeof *r.w.s);
    r.w.words         = calloc(word_count, sizeof *r.w.words);
    r.nodes           = malloc((r.node_count + 1) * sizeof *r.nodes);
    r.page_first      = malloc((r.page_count + 1) * sizeof *r.page_first);
    r.patterns        = malloc((r.pattern_count + 1) * sizeof *r.patterns);
    vxs_result result = VXS_E_MEMORY;
    if (r.w.s && r.w.words && r.nodes && r.page_first && r.patterns && reserve(out, 16)) {
        r.w.odds = &r.w.s->odds;
        int same = code_resident(&r, common);
        for (uint32_t n = 0; n < word_count; n++)
            same &= r.w.words[n] == words[n] || (n >= RESIDENT_WORDS && n < RESIDENT_WORDS + r.page_count);
        if (!r.w.c.no_memory) result = same ? VXS_OK : VXS_E_ARGUMENT;
    }
    if (result == VXS_OK) {
        size_t         before  = out->size_bytes;
        const uint32_t sizes[] = {word_count, r.page_count, r.met, r.pattern_count};
        for (int n = 0; n < 4; n++) vxs_store32(out->data + before + 4 * n, sizes[n]);
        out->size_bytes += 16;
        if (!append_coded(out, &r.w.c)) {
            out->size_bytes = before;
            result          = VXS_E_MEMORY;
        }
    }
    free(r.w.c.parts);
    free(r.w.s);
    free(r.w.words);
    free(r.nodes);
    free(r.page_first);
    free(r.patterns);
    return result;
}

/* Number of halves of a pattern over `depths` depths at a half of the source; the pattern is valid (read_source). */
static uint32_t pattern_halves(const walk *w, uint32_t half, uint32_t depths)
{
    uint32_t size = depths / 2;
    if ((source_half(w, half) & 0xff) == 0xff) return INDEX_HALVES;
    for (uint32_t n = 0; n + 1 < depths; n++)
        for (uint32_t c = 0; c < 4; c++) size += (source_half(w, half + n / 2) >> (8 * (n & 1) + 2 * c) & 3) == 2;
    return size;
}

vxs_result vxs_common_index(vxs_common *common, uint32_t *patterns, const uint8_t *kinds, uint32_t pattern_count,
                            const uint32_t *words, uint32_t half_count)
{
    walk     w                           = {.source = words, .word_count = (half_count + 1) / 2};
    uint32_t next[VXS_PATTERN_KINDS + 1] = {0}, half = 0;
    *common = (vxs_common){words, half_count, patterns, {0}};
    for (uint32_t n = 0; n < pattern_count; n++) {
        if (kinds[n] >= VXS_PATTERN_KINDS || kinds[n] == 1) return VXS_E_ARGUMENT;
        for (uint32_t k = kinds[n] + 1u; k <= VXS_PATTERN_KINDS; k++) common->first[k]++;
    }
    memcpy(next, common->first, sizeof next);
    for (uint32_t n = 0; n < pattern_count; n++) {
        uint32_t head = source_half(&w, half), depths = kinds[n], size = 0;
        uint8_t  index[64];
        if (kinds[n] == KIND_PRIVATE) {
            if (head >> 12 >= PRIVATE_KINDS) return VXS_E_ARGUMENT;
            depths = head >> 12 <= PRIVATE_WORDS ? head & 0xff : 0;
            size   = head >> 12 <= PRIVATE_WORDS ? 1 + private_delta_halves(head >> 12, depths - 1) : private_halves[head >> 12];
        }
        if (depths > DEPTHS_MAX || depths == 1) return VXS_E_ARGUMENT;
        if (depths) {
            if (!read_source(&w, half + size, depths, index)) return VXS_E_ARGUMENT;
            size += pattern_halves(&w, half + size, depths);
        }
        if (half >= VXS_COMMON_HALVES_MAX || size > half_count - half) return VXS_E_ARGUMENT;
        patterns[next[kinds[n]]++] = half;
        half += size;
    }
    return half == half_count ? VXS_OK : VXS_E_ARGUMENT;
}
