/* Lays out palette blocks as words; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_layout.h"

#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "baker/base/array.h"
#include "baker/base/parallel.h"
#include "baker/base/ref_table.h"
#include "baker/base/system.h"
#include "baker/base/z_order.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/coding/blocks/patterns.h"

enum { CELL_SIDE = 8, CELL_WORDS = 2 * CELL_SIDE * CELL_SIDE };

/* Entries of all squares of a map, two words each, by rows of squares. */
typedef struct map_entries {
    uint32_t *words;
    uint32_t  side;
} map_entries;

/* Allocate the next words of the tops. NULL without memory. */
static uint32_t *more_top(layout *l, size_t count)
{
    if (!array_reserve(&l->top, &l->top_capacity, l->top_count + count, sizeof *l->top)) return NULL;
    l->top_count += count;
    return l->top + l->top_count - count;
}

/* Write the cells, then, in z order, the entries of cells without a single depth. */
static vxs_result put_cells(layout *l, const map_entries *e)
{
    uint32_t cells = e->side / CELL_SIDE, words[CELL_WORDS];
    size_t   start = l->top_count;
    if (!more_top(l, (size_t)cells * cells)) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < cells * cells; n++) {
        z_place  at   = z_order(n);
        uint32_t word = (uint32_t)(HEAD_WORDS + l->page_count + l->top_count);

        int same = 1; /* all entries of the cell have the same single depth */
        for (uint32_t row = 0; row < CELL_SIDE; row++)
            memcpy(words + 2 * CELL_SIDE * row, e->words + 2 * ((CELL_SIDE * at.j + row) * e->side + CELL_SIDE * at.i),
                   2 * CELL_SIDE * sizeof *words);
        for (uint32_t k = 0; k < CELL_WORDS; k += 2) same &= words[k] == words[0] && words[k] & ENTRY_UNIFORM;
        if (same) {
            word = words[0];
        } else {
            uint32_t *to = more_top(l, CELL_WORDS);
            if (!to) return VXS_E_MEMORY;
            memcpy(to, words, sizeof words);
        }
        l->top[start + at.j * cells + at.i] = word;
    }
    return VXS_OK;
}

static vxs_result put_map(layout *l, uint32_t map, map_entries *e)
{
    size_t   words  = 2 * (size_t)e->side * e->side;
    uint32_t coarse = l->levels > 8 ? l->levels - 8 : 0, node_level = square_level(NODE_PX);
    memset(e->words, 0, words * sizeof *e->words);
    for (const uniform_square *u = l->set->uniform; u < l->set->uniform + l->set->uniform_count; u++) {
        uint32_t side = u->level > node_level ? 1u << (u->level - node_level) : 1;
        if (u->map != map) continue;
        for (uint32_t y = u->y * side; y < (u->y + 1) * side; y++)
            for (uint32_t x = u->x * side; x < (u->x + 1) * side; x++)
                e->words[2 * (y * e->side + x)] = ENTRY_UNIFORM | min_u32(u->depth, l->never);
    }
    for (const node_place *n = l->nodes; n < l->nodes + l->set->node_count; n++) {
        const packed_node *from  = &l->set->nodes[n->node];
        uint32_t          *entry = e->words + 2 * (from->y * e->side + from->x);
        if (from->map != map) continue;
        entry[0] = n->page << 16 | n->word;
        entry[1] = n->base | min_u32(from->emin >> coarse, 255) << 16 | min_u32(from->xmax >> coarse, 255) << 24;
    }
    l->top_start[map] = (uint32_t)l->top_count;
    if (l->levels >= CELL_LEVELS) return put_cells(l, e);
    uint32_t *to = more_top(l, words);
    if (!to) return VXS_E_MEMORY;
    memcpy(to, e->words, words * sizeof *to);
    return VXS_OK;
}

/* Build the tops of all maps, after nodes are placed. Cells count from the first word of all tops. */
static vxs_result layout_build_top(layout *l)
{
    uint32_t    side    = l->levels > 8 ? 1u << (l->levels - 8) : 1;
    map_entries entries = {malloc(2 * (size_t)side * side * sizeof *entries.words), side};
    vxs_result  r       = entries.words ? VXS_OK : VXS_E_MEMORY;
    for (uint32_t map = 0; map < l->map_count && r == VXS_OK; map++) r = put_map(l, map, &entries);
    free(entries.words);
    return r;
}

/* patterns -------------------------------------------------------------------------------------------------------------------- */

enum { PRIVATE_KIND = PALETTE_MAX + 1 }; /* kind behind those of 2 to PALETTE_MAX depths */

/* All patterns during their encoding, sorted by kind. */
typedef struct pattern_coder {
    const block_set *set;
    size_t           first[PRIVATE_KIND + 2]; /* patterns of kind k are first[k]..first[k + 1] - 1 */

    /* codes: number of halves | depths << 8 (0: private palette); then the halves */
    uint16_t (*shared)[PATTERN_HALVES_MAX + 1];   /* [first[PRIVATE_KIND]] */
    uint16_t (*privates)[PRIVATE_HALVES_MAX + 1]; /* [set->privates.count] */
} pattern_coder;

static uint16_t *code_of_pattern(const pattern_coder *c, size_t n)
{
    return n < c->first[PRIVATE_KIND] ? c->shared[n] : c->privates[n - c->first[PRIVATE_KIND]];
}

static void encode_some_patterns(void *user, size_t begin, size_t end, uint32_t worker)
{
    const pattern_coder *c    = user;
    int                  kind = 2;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        uint16_t *code = code_of_pattern(c, n);
        while (n >= c->first[kind + 1]) kind++;
        if (kind == PRIVATE_KIND) {
            code[0] = (uint16_t)private_pattern_encode(&c->set->privates.patterns[n - c->first[kind]], code + 1);
            continue;
        }
        mask_need needs[PALETTE_MAX - 1];
        uint8_t   index[64];
        pattern_needs(&c->set->patterns, kind, n - c->first[kind], needs);
        pattern_choose(needs, kind, index);
        code[0] = (uint16_t)(pattern_encode(index, kind, code + 1) | (uint32_t)kind << 8);
    }
}

static vxs_result measure_codes(layout *l, int is_private)
{
    const size_t count       = l->codes[is_private].count;
    l->common[is_private]    = calloc(count + 1, sizeof *l->common[is_private]);
    l->code_size[is_private] = malloc(count + 1);
    if (!l->common[is_private] || !l->code_size[is_private]) return VXS_E_MEMORY;
    for (uint32_t code = 0; code < count; code++) l->code_size[is_private][code] = code_halves(l, is_private, code)[-1] & 0xff;
    return VXS_OK;
}

/* Choose and encode depths on all threads, then unify equal codes in order. */
static vxs_result encode_patterns(layout *l)
{
    pattern_coder c = {.set = l->set};
    vxs_result    r = VXS_E_MEMORY;
    for (int kind = 2; kind < PRIVATE_KIND; kind++) c.first[kind + 1] = c.first[kind] + l->set->patterns.by_depths[kind].count;
    c.first[PRIVATE_KIND + 1] = c.first[PRIVATE_KIND] + l->set->privates.count;
    c.shared                  = malloc((c.first[PRIVATE_KIND] + 1) * sizeof *c.shared);
    c.privates                = malloc((l->set->privates.count + 1) * sizeof *c.privates);
    l->code_of[0]             = malloc((l->set->patterns.count + 1) * sizeof *l->code_of[0]);
    l->code_of[1]             = malloc((l->set->privates.count + 1) * sizeof *l->code_of[1]);
    if (c.shared && c.privates && l->code_of[0] && l->code_of[1]) {
        parallel_for(l->threads, c.first[PRIVATE_KIND + 1], 256, encode_some_patterns, &c);

        r = VXS_OK;
        for (size_t n = 0, kind = 2; n < c.first[PRIVATE_KIND + 1] && r == VXS_OK; n++) {
            const uint16_t *code = code_of_pattern(&c, n);
            while (n >= c.first[kind + 1]) kind++;
            size_t   at = n - c.first[kind], bytes = ((code[0] & 0xffu) + 1) * sizeof *code;
            int      is_private = kind == PRIVATE_KIND;
            uint32_t id         = is_private ? (uint32_t)at : l->set->patterns.by_depths[kind].ids[at];
            r                   = intern_find(&l->codes[is_private], code, bytes, &l->code_of[is_private][id]);
        }
        for (int n = 0; n < 2 && r == VXS_OK; n++) r = measure_codes(l, n);
    }
    free(c.shared);
    free(c.privates);
    pattern_set_free(&l->set->patterns);
    private_set_free(&l->set->privates);
    return r;
}

/* nodes ----------------------------------------------------------------------------------------------------------------------- */

static int by_place(const void *a, const void *b, void *user)
{
    const packed_node *nodes = user, *x = &nodes[((const node_place *)a)->node], *y = &nodes[((const node_place *)b)->node];
    if (x->map != y->map) return x->map < y->map ? -1 : 1;
    uint32_t xz = z_number((z_place){x->x, x->y}), yz = z_number((z_place){y->x, y->y});
    return (xz > yz) - (xz < yz);
}

/* Base of a node, in steps: no depth may be below it. The slope can move depths of uniform blocks behind the end of the map; if all
 * depths are there, the base is 0. */
static uint32_t base_of(const layout *l, const packed_node *n)
{
    const uint32_t  never = l->never + (uint32_t)slope_shift_max(n->slope), mixed_count = n->mixed_count;
    const uint32_t *depth = node_parts(l->set, n) + mixed_count, *fresh = depth + mixed_count;
    uint32_t        least  = NEVER;
    int             inside = mixed_count != 0;
    for (uint32_t k = 0; k < mixed_count; k++) least = min_u32(least, depth[k]);
    for (uint32_t k = 0; k < n->fresh_count; k++) {
        if (fresh[k] < never) least = min_u32(least, fresh[k]);
        inside |= fresh[k] < l->never;
    }
    return inside ? min_u32(least >> l->base_shift, 0xffff) : 0;
}

typedef struct node_shaper {
    layout   *l;
    uint64_t *hash; /* [node_count] of shapes */
} node_shaper;

static void shape_some_nodes(void *user, size_t begin, size_t end, uint32_t worker)
{
    const node_shaper *s = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        node_place *to = &s->l->nodes[n];
        node_shape  shape;
        to->base = base_of(s->l, &s->l->set->nodes[to->node]);
        shape_of(&shape, s->l, to);
        to->words  = layout_node_words(&shape);
        s->hash[n] = XXH64(&shape, shape_bytes(&shape), 0);
    }
}

static int same_shape(const layout *l, uint32_t a, uint32_t b)
{
    node_shape x, y;
    shape_of(&x, l, &l->nodes[a]);
    shape_of(&y, l, &l->nodes[b]);
    return shape_bytes(&x) == shape_bytes(&y) && !memcmp(&x, &y, shape_bytes(&x));
}

/* Give each place the first place of equal shape. */
static vxs_result unify_shapes(layout *l, const uint64_t *hash)
{
    const uint32_t count = (uint32_t)l->set->node_count;
    ref_table      table = {0};
    if (!ref_table_reserve(&table, count)) return VXS_E_MEMORY;
    for (uint32_t n = 0, ref; n < count; n++) {
        uint64_t at = ref_table_first(&table, hash[n]);
        while ((ref = ref_table_match(&table, hash[n], &at)) && !same_shape(l, ref - 1, n)) at = ref_table_next(&table, at);
        if (!ref) ref_table_put(&table, hash[n], at, n + 1);
        l->nodes[n].shape = ref ? ref - 1 : n;
    }
    ref_table_free(&table);
    return VXS_OK;
}

static vxs_result shape_nodes(layout *l)
{
    const size_t count = l->set->node_count;
    node_shaper  s     = {l, malloc((count + 1) * sizeof *s.hash)};
    vxs_result   r     = VXS_E_MEMORY;
    int          order = 0;
    l->nodes           = calloc(count + 1, sizeof *l->nodes);
    if (s.hash && l->nodes) {
        for (uint32_t n = 0; n < count; n++) {
            l->nodes[n].node = n;
            if (n) order |= by_place(&l->nodes[n - 1], &l->nodes[n], l->set->nodes) > 0;
        }
        if (order) system_sort(l->nodes, count, sizeof *l->nodes, by_place, l->set->nodes);
        parallel_for(l->threads, count, 256, shape_some_nodes, &s);
        r = unify_shapes(l, s.hash);
    }
    free(s.hash);
    return r;
}

/* words ----------------------------------------------------------------------------------------------------------------------- */

/* Most words before the pages. A page has a node, and a cell at most all of its entries. */
static size_t most_before(const layout *l)
{
    const size_t side = l->levels > 8 ? (size_t)1 << (l->levels - 8) : 1;
    return HEAD_WORDS + l->set->node_count + l->map_count * 3 * side * side + (l->common_halves + 1) / 2;
}

/* Write pages, and before them the head, the table of pages, tops, common patterns. */
static vxs_result assemble(layout *l)
{
    const size_t before = most_before(l), common_words = (l->common_halves + 1) / 2;
    uint32_t    *memory;
    vxs_result   r = layout_write_pages(l, before, &memory);
    if (r == VXS_OK) r = layout_build_top(l);
    const size_t top = HEAD_WORDS + l->page_count, common = top + l->top_count, page_start = common + common_words,
                 all = page_start + page_place(l, l->page_count);
    if (r == VXS_OK && all > UINT32_MAX / 2) r = VXS_E_REFERENCES;
    if (r != VXS_OK) {
        free(memory);
        return r;
    }
    uint32_t *w = memory + before - page_start;
    w[0]        = (uint32_t)l->page_count;
    w[1]        = (uint32_t)common;
    for (uint32_t map = 0; map < l->map_count; map++) w[2 + map] = (uint32_t)top + l->top_start[map];
    for (size_t p = 0; p < l->page_count; p++) w[HEAD_WORDS + p] = (uint32_t)page_start + page_place(l, p);
    memcpy(w + top, l->top, l->top_count * sizeof *w);
    layout_write_common(l, w + common);
    l->out->memory              = memory;
    l->out->words               = w;
    l->out->count               = (uint32_t)all;
    l->out->common_kinds        = l->common_kinds;
    l->out->common_count        = (uint32_t)l->common_count;
    l->out->common_halves       = l->common_halves;
    l->common_kinds             = NULL;
    l->out->counts.pages        = (uint32_t)l->page_count;
    l->out->counts.top_words    = (uint32_t)common;
    l->out->counts.common_words = (uint32_t)common_words;
    return VXS_OK;
}

vxs_result block_words_lay_out(block_words *out, block_set *s, uint32_t levels, uint32_t map_count, uint32_t threads)
{
    layout     l = {.set        = s,
                    .threads    = threads,
                    .levels     = levels,
                    .map_count  = map_count,
                    .never      = 1u << levels,
                    .base_shift = levels > 16 ? levels - 16 : 0,
                    .out        = out};
    vxs_result r;
    memset(out, 0, sizeof *out);
    if ((r = encode_patterns(&l)) == VXS_OK && (r = layout_measure_blocks(&l)) == VXS_OK && (r = shape_nodes(&l)) == VXS_OK &&
        (r = layout_share_pages(&l)) == VXS_OK)
        r = assemble(&l);

    for (int is_private = 0; is_private < 2; is_private++) {
        intern_free(&l.codes[is_private]);
        free(l.code_size[is_private]);
        free(l.code_of[is_private]);
        free(l.common[is_private]);
    }
    free(l.nodes);
    free(l.common_kinds);
    free(l.block_words);
    free(l.page_end);
    free(l.top);

    if (r != VXS_OK) memset(out, 0, sizeof *out);
    return r;
}

void block_words_free(block_words *w)
{
    free(w->memory);
    free(w->common_kinds);
    memset(w, 0, sizeof *w);
}
