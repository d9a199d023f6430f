/* Cuts palette blocks into pages; see block_layout.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_layout.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/parallel.h"
#include "baker/coding/blocks/blocks.h"

enum {
    NODE_HALVES = 11, /* halves before the arrays of a node */
    PLANE_WORDS = 2
};

/* nodes ----------------------------------------------------------------------------------------------------------------------- */

uint32_t layout_node_words(const node_shape *s)
{
    return (NODE_HALVES + s->mixed_count + shape_depths(s) * (shape_is_wide(s) ? 2 : 1) + 1) / 2;
}

/* blocks ---------------------------------------------------------------------------------------------------------------------- */

/* Words of a block without its patterns. */
static uint32_t words_of(const block_parts *b)
{
    const block_head *h = &b->head;
    return 2 + (h->planar ? PLANE_WORDS : 0) + h->mixed_count + h->tail_words + (block_is_far(b) ? h->own_count : 0);
}

static void measure_some_blocks(void *user, size_t begin, size_t end, uint32_t worker)
{
    const layout *l = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        uint8_t          *bytes = intern_at(&l->set->blocks, (uint32_t)n);
        const block_parts b     = block_parts_of(bytes);
        l->block_words[n]       = (uint16_t)words_of(&b);
        block_renumber(bytes, l->code_of[0], l->code_of[1], NULL);
    }
}

vxs_result layout_measure_blocks(layout *l)
{
    l->block_words = malloc((l->set->blocks.count + 1) * sizeof *l->block_words);
    if (!l->block_words) return VXS_E_MEMORY;
    parallel_for(l->threads, l->set->blocks.count, 4096, measure_some_blocks, l);
    return VXS_OK;
}

/* pages ----------------------------------------------------------------------------------------------------------------------- */

/* Size of a page, with a node added. */
typedef struct page_size {
    uint32_t words, halves;
} page_size;

/* The pattern of a tile in the layout. */
typedef struct tile_code {
    int      is_private;
    uint32_t code;
} tile_code;

/* Mark of the common patterns, which are never new in a page. */
#define IN_COMMON UINT16_MAX

/* While pages are cut: for each block and each pattern the last page that has it, counted from 1. */
typedef struct cutter {
    uint16_t *block, *code[2];
    void (*ended)(void *user, size_t page_count); /* called after each page; NULL: it is not called */
    void     *user;
    uint32_t  fresh_count; /* patterns that no node of the page before the last one uses */
    tile_code fresh[NODE_BLOCKS * BLOCK_TILES];
} cutter;

/* Whether it is not in the page yet. Marks it as in the page. */
static int is_new(uint16_t *last, uint32_t page)
{
    if (*last >= page) return 0;
    *last = (uint16_t)page;
    return 1;
}

/* Add to a page the patterns of a block that are not in it yet. */
static void add_patterns(const layout *l, cutter *c, uint32_t page, page_size *size, uint32_t id)
{
    const block_parts b       = block_parts_of(intern_at(&l->set->blocks, id));
    const uint8_t    *pattern = b.pattern;
    for (uint32_t rest = b.head.mixed; rest; rest &= rest - 1, pattern += 4) {
        const int is_private = (b.head.own & rest & -rest) != 0;
        uint32_t  code;
        memcpy(&code, pattern, sizeof code);
        if (!is_new(&c->code[is_private][code], page)) continue;
        size->halves += l->code_size[is_private][code];
        c->fresh[c->fresh_count++] = (tile_code){is_private, code};
    }
}

/* Add to the last page the words of a node, and of its blocks and patterns that are not in the page yet. */
static void add_to_page(layout *l, cutter *c, page_size *size, uint32_t n)
{
    node_place        *to = &l->nodes[n], *first = &l->nodes[to->shape];
    const packed_node *node = &l->set->nodes[to->node];
    const uint32_t    *ids  = node_parts(l->set, node);
    const uint32_t     page = (uint32_t)l->page_count + 1;
    c->fresh_count          = 0;
    layout_prefetch(l, to + 1);
    to->page = page - 1;
    if (first->last != NEVER && first->last != n && l->nodes[first->last].page == to->page) {
        to->word = l->nodes[first->last].word;
        return;
    }
    first->last = n;
    to->word    = size->words;
    size->words += to->words;
    for (uint32_t k = 0; k < node->mixed_count; k++) {
        const uint32_t id = ids[k];
        if (!is_new(&c->block[id], page)) continue;
        size->words += l->block_words[id];
        add_patterns(l, c, page, size, id);
    }
}

static uint32_t page_words(const page_size *p)
{
    return p->words + (p->halves + 1) / 2;
}

static vxs_result cutter_init(cutter *c, const layout *l)
{
    c->block = malloc((l->set->blocks.count + 1) * sizeof *c->block);
    for (int k = 0; k < 2; k++) c->code[k] = malloc((l->codes[k].count + 1) * sizeof **c->code);
    return c->block && c->code[0] && c->code[1] ? VXS_OK : VXS_E_MEMORY;
}

static void cutter_free(cutter *c)
{
    free(c->block);
    free(c->code[0]);
    free(c->code[1]);
}

/* No page has anything yet. */
static void cutter_begin(cutter *c, layout *l)
{
    l->page_count = 0;
    memset(c->block, 0, l->set->blocks.count * sizeof *c->block);
    for (int k = 0; k < 2; k++)
        for (uint32_t code = 0; code < l->codes[k].count; code++) c->code[k][code] = l->common[k][code] ? IN_COMMON : 0;
    for (size_t n = 0; n < l->set->node_count; n++) l->nodes[n].last = NEVER;
}

/* End the page before node n. */
static vxs_result end_page(layout *l, const cutter *c, uint32_t n, const page_size *size)
{
    if (!array_reserve(&l->page_end, &l->page_capacity, l->page_count + 1, sizeof *l->page_end)) return VXS_E_MEMORY;
    uint64_t end = (uint64_t)page_place(l, l->page_count) + page_words(size);
    if (end > UINT32_MAX / 2 || l->page_count == VXS_PAGES_MAX) return VXS_E_REFERENCES;
    l->page_end[l->page_count++] = (page_end){n, (uint32_t)end, size->words};
    if (c->ended) c->ended(c->user, l->page_count);
    return VXS_OK;
}

/* End pages where they are full, or where the words so far are nearest to a multiple of l->share.
 * pages  [is_private][code] zeroed; [out] number of pages with each pattern; NULL: not wanted */
static vxs_result cut(layout *l, cutter *c, uint32_t *const *pages)
{
    uint32_t   count = (uint32_t)l->set->node_count;
    page_size  page  = {0, 0};
    vxs_result r     = VXS_OK;
    cutter_begin(c, l);
    for (uint32_t n = 0, first = 0; n < count && r == VXS_OK; n++) {
        const page_size before = page;
        add_to_page(l, c, &page, n);
        uint64_t middle = page_place(l, l->page_count) +
                          ((uint64_t)page_words(&before) + page_words(&page)) / 2; /* middle of this node among all words */
        if (n > first && (page_words(&page) > VXS_PAGE_WORDS_MAX || middle >= l->share * (l->page_count + 1))) {
            /* this node begins the next page */
            r     = end_page(l, c, n, &before);
            first = n;
            page  = (page_size){0, 0};
            add_to_page(l, c, &page, n);
        }
        for (const tile_code *t = c->fresh; pages && t < c->fresh + c->fresh_count; t++) pages[t->is_private][t->code]++;
    }
    return r == VXS_OK && count ? end_page(l, c, count, &page) : r;
}

/* common patterns ------------------------------------------------------------------------------------------------------------- */

typedef struct shared_code {
    uint32_t pages, is_private, code;
} shared_code;

/* Most used first. */
static int by_use(const void *a, const void *b)
{
    const shared_code *x = a, *y = b;
    if (x->pages != y->pages) return x->pages > y->pages ? -1 : 1;
    if (x->is_private != y->is_private) return x->is_private < y->is_private ? -1 : 1;
    return (x->code > y->code) - (x->code < y->code);
}

/* Store patterns of several pages once, as many as there is space for. */
static vxs_result share_patterns(layout *l, uint32_t *const *pages)
{
    size_t       all = l->codes[0].count + l->codes[1].count, count = 0;
    shared_code *shared = malloc((all + 1) * sizeof *shared);
    vxs_result   r      = shared ? VXS_OK : VXS_E_MEMORY;
    for (uint32_t is_private = 0; is_private < 2 && r == VXS_OK; is_private++)
        for (uint32_t code = 0; code < l->codes[is_private].count; code++)
            if (pages[is_private][code] > 1) shared[count++] = (shared_code){pages[is_private][code], is_private, code};
    if (count) qsort(shared, count, sizeof *shared, by_use);
    for (const shared_code *p = shared; p < shared + count && r == VXS_OK; p++) {
        const uint32_t size = l->code_size[p->is_private][p->code];
        if (l->common_halves + size > VXS_COMMON_HALVES_MAX) continue;
        if (!array_reserve(&l->common_kinds, &l->common_capacity, l->common_count + 1, sizeof *l->common_kinds)) {
            r = VXS_E_MEMORY;
            break;
        }
        l->common_kinds[l->common_count++] = (uint8_t)(code_halves(l, (int)p->is_private, p->code)[-1] >> 8);
        l->common[p->is_private][p->code]  = 1 + l->common_halves;
        l->common_halves += size;
    }
    free(shared);
    return r;
}

/* Fill each page, which gives the least number of pages. */
vxs_result layout_share_pages(layout *l)
{
    uint32_t  *pages[2] = {calloc(l->codes[0].count + 1, sizeof **pages), calloc(l->codes[1].count + 1, sizeof **pages)};
    cutter    *c        = calloc(1, sizeof *c);
    vxs_result r        = c && pages[0] && pages[1] ? cutter_init(c, l) : VXS_E_MEMORY;
    l->share            = VXS_PAGE_WORDS_MAX;
    if (r == VXS_OK) r = cut(l, c, pages);
    if (r == VXS_OK && l->page_count > 1) {
        l->share = page_place(l, l->page_count) / l->page_count + 1;
        r        = share_patterns(l, pages);
    }
    if (c) cutter_free(c);
    free(c);
    free(pages[0]);
    free(pages[1]);
    return r;
}

/* Into this number of equal pages, so that threads get equal work. */
vxs_result layout_cut_pages(layout *l, void (*ended)(void *user, size_t page_count), void *user)
{
    if (l->page_count < 2) {
        if (l->page_count) ended(user, 1);
        return VXS_OK;
    }
    if (!array_reserve(&l->page_end, &l->page_capacity, VXS_PAGES_MAX, sizeof *l->page_end)) return VXS_E_MEMORY;
    cutter    *c = calloc(1, sizeof *c);
    vxs_result r = c ? cutter_init(c, l) : VXS_E_MEMORY;
    if (r == VXS_OK) {
        c->ended = ended;
        c->user  = user;
        r        = cut(l, c, NULL);
    }
    if (c) cutter_free(c);
    free(c);
    return r;
}
