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

/* Put a symbol into a state. A state that is too large for it first gives a word, before `to`. Whether it does is unpredictable, so
 * there is no branch on it.
 * wrong  [out] highest bit: the symbol has no odds, or some beyond all. Without this a decoder gets the state back: its quotient by
 *        `size` is at least 2, as a state is at least 2 * size before and after the word; the remainder and `from` are below ODDS_ONE
 *        together; and a state is below STATE_LEAST only after a word. */
PAGE_INLINE uint32_t put_part(uint32_t state, uint32_t part, uint8_t **to, uint32_t *wrong)
{
    uint32_t from = part & 0xffff, size = (part >> 16) - from, large = state >> 16 >= size << 1;
    vxs_store16(*to - 2, (uint16_t)state);
    *to -= 2 * large;
    state >>= 16 * large;
    *wrong |= (size - 1) | (ODDS_ONE - (part >> 16));
    /* exact, as state < size << 17 and size <= ODDS_ONE; the long division does not wait for the state */
    uint32_t quotient = (uint32_t)(state * (((uint64_t)1 << 47) / (size ? size : 1) + 1) >> 47);
    return quotient * (ODDS_ONE - size) + state + from;
}

/* Append the coded words and the two states. Symbols use the two states alternately. The last symbol is coded first, so that
 * the decoder gets the first symbol first. The words take the place of the symbols, from the end: a word is shorter than a symbol.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT after a fault of the odds. */
static vxs_result append_coded(vxs_bytes *out, const coder *c)
{
    uint8_t  *end = (uint8_t *)c->at, *to = end;
    uint32_t *first = c->parts, *at = c->at, even = STATE_LEAST, odd = STATE_LEAST, wrong = 0;
    if ((at - first) & 1) even = put_part(even, *--at, &to, &wrong);
    while (at > first) {
        odd  = put_part(odd, *--at, &to, &wrong);
        even = put_part(even, *--at, &to, &wrong);
    }
    size_t size_bytes = (size_t)(end - to);
    if (wrong >> 31) return VXS_E_ARGUMENT;
    if (!reserve(out, size_bytes + 8)) return VXS_E_MEMORY;
    if (size_bytes) memcpy(out->data + out->size_bytes, to, size_bytes);
    out->size_bytes += size_bytes + 8;
    vxs_store32(out->data + out->size_bytes - 8, even);
    vxs_store32(out->data + out->size_bytes - 4, odd);
    return VXS_OK;
}

struct vxs_page_encoder {
    vxs_page_scratch scratch;
    uint32_t         words[VXS_PAGE_WORDS_MAX];
    uint16_t         pattern_rank[1 << 18], block_rank[VXS_PAGE_WORDS_MAX];
    coder            symbols; /* grow with pages */
};

vxs_page_encoder *vxs_page_encoder_new(void)
{
    vxs_page_encoder *e = calloc(1, sizeof *e);
    if (e && !coder_begin(&e->symbols)) {
        free(e);
        return NULL;
    }
    return e;
}

void vxs_page_encoder_free(vxs_page_encoder *e)
{
    if (e) free(e->symbols.parts);
    free(e);
}

vxs_result vxs_page_encode(vxs_page_encoder *e, vxs_bytes *out, const uint32_t *words, uint32_t word_count,
                           const vxs_page_node *nodes, uint32_t node_count, const vxs_common *common)
{
    if (!node_count || !word_count || word_count > VXS_PAGE_WORDS_MAX) return VXS_E_ARGUMENT;
    walk   w      = {.c            = {.parts = e->symbols.parts, .at = e->symbols.parts, .end = e->symbols.end},
                     .odds         = &e->scratch.odds,
                     .s            = &e->scratch,
                     .words        = e->words,
                     .word_count   = word_count,
                     .node_words   = node_words_of(words, word_count, nodes, node_count),
                     .common       = common,
                     .source       = words,
                     .pattern_rank = e->pattern_rank,
                     .block_rank   = e->block_rank};
    size_t before = out->size_bytes;
    memset(e->words, 0, word_count * sizeof *e->words);
    int same   = w.node_words && code_page(&w, nodes, node_count) && !memcmp(e->words, words, word_count * sizeof *words);
    e->symbols = w.c;
    if (w.c.no_memory || (same && !reserve(out, 4))) return VXS_E_MEMORY;
    if (!same) return VXS_E_ARGUMENT;
    vxs_store16(out->data + before, (uint16_t)(word_count - 1));
    vxs_store16(out->data + before + 2, (uint16_t)(w.node_words - 1));
    out->size_bytes += 4;
    vxs_result r = append_coded(out, &w.c);
    if (r != VXS_OK) out->size_bytes = before;
    return r;
}

vxs_result vxs_resident_encode(vxs_bytes *out, vxs_page_nodes *nodes, const uint32_t *words, uint32_t word_count, uint32_t levels,
                               uint32_t map_count, const vxs_common *common)
{
    *nodes = (vxs_page_nodes){0};
    if (word_count < RESIDENT_WORDS || words[0] > VXS_PAGES_MAX) return VXS_E_ARGUMENT;
    top_odds      odds;
    resident_walk r   = {.w             = {.source = words, .word_count = word_count, .fine = common->packing == VXS_PACKING_FINE},
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
    if (coder_begin(&r.w.c) && r.w.s && r.w.words && r.nodes && r.page_first && r.patterns && reserve(out, 16)) {
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
        result = append_coded(out, &r.w.c);
        if (result != VXS_OK) out->size_bytes = before;
    }
    free(r.w.c.parts);
    free(r.w.s);
    free(r.w.words);
    free(r.patterns);
    if (result == VXS_OK) {
        *nodes = (vxs_page_nodes){r.nodes, r.page_first, r.met};
        return result;
    }
    free(r.nodes);
    free(r.page_first);
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
    *common = (vxs_common){words, half_count, patterns, {0}, 0};
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
