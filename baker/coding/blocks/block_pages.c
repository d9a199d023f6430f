/* The pages of palette blocks; see block_layout.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_layout.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/parallel.h"
#include "baker/base/run_control.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/coding/blocks/patterns.h"
#include "formats/vxs_bytes.h"

enum {
    NODE_HALVES = 11, /* halves before the arrays of a node */
    PLANE_WORDS = 2,
    WRITERS_MAX = 8,   /* most threads that write pages: each needs scratch memory */
    FAR_BASE    = 8192 /* bases of private palettes from here on have words of their own */
};

#define NODE_WIDE 1u
#define BLOCK_FAR 0x400u
#define COMMON    0x20000u

/* nodes ----------------------------------------------------------------------------------------------------------------------- */

/* Number of depths of a node's record. */
static uint32_t depth_count(const node_shape *s)
{
    return s->mixed_count + s->fresh_count;
}

static int is_wide(const node_shape *s)
{
    int wide = 0;
    for (const uint32_t *d = s->parts + s->mixed_count, *end = d + depth_count(s); d < end; d++) wide |= *d != NEVER && *d > 0xfffe;
    return wide;
}

uint32_t layout_node_words(const node_shape *s)
{
    return (NODE_HALVES + s->mixed_count + depth_count(s) * (is_wide(s) ? 2 : 1) + 1) / 2;
}

/* blocks ---------------------------------------------------------------------------------------------------------------------- */

/* Whether a base of a private palette does not fit into the word of its tile. */
static int is_far(const block_parts *b)
{
    int far = 0;
    for (uint32_t n = 0; n < b->head.owns; n++) {
        int32_t base;
        memcpy(&base, b->base + 4 * n, sizeof base);
        far |= base < -FAR_BASE || base >= FAR_BASE;
    }
    return far;
}

/* Words of a block without its patterns. */
static uint32_t words_of(const block_parts *b)
{
    const block_head *h = &b->head;
    return 2 + (h->planar ? PLANE_WORDS : 0) + h->patterns + h->tail_words + (is_far(b) ? h->owns : 0);
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

/* What pages have, while they are cut: the last page that has a thing, counted from 1. */
typedef struct cutter {
    uint16_t *block, *code[2];
    uint32_t  fresh_count; /* patterns that no node of the page before the last one uses */
    tile_code fresh[NODE_BLOCKS * BLOCK_TILES];
} cutter;

/* Whether a thing is not in the page yet. Marks it as in the page. */
static int is_new(uint16_t *last, uint32_t page)
{
    if (*last >= page) return 0;
    *last = (uint16_t)page;
    return 1;
}

/* Add to a page the patterns of a block that are not in it yet. */
static void add_patterns(const layout *l, cutter *c, uint32_t page, page_size *size, uint32_t id)
{
    const uint8_t *from = intern_at(&l->set->blocks, id);
    block_head     head;
    memcpy(&head, from, sizeof head);
    from += sizeof head;
    for (uint32_t rest = head.patterned; rest; rest &= rest - 1, from += sizeof rest) {
        const int is_private = (head.own & rest & -rest) != 0;
        uint32_t  code;
        memcpy(&code, from, sizeof code);
        if (!is_new(&c->code[is_private][code], page)) continue;
        size->halves += l->code_size[is_private][code];
        c->fresh[c->fresh_count++] = (tile_code){is_private, code};
    }
}

/* Blocks are scattered in memory: ask for those of a node early. */
static void prefetch_blocks(const layout *l, const node_place *n)
{
    const packed_node *node = &l->set->nodes[n->node];
    const uint32_t    *ids  = node_parts(l->set, node);
    for (uint32_t k = 0; k < node->mixed_count; k++) __builtin_prefetch(intern_at(&l->set->blocks, ids[k]));
}

/* Add to the last page the words of a node, and of its blocks and patterns that are not in the page yet. */
static void add_to_page(layout *l, cutter *c, page_size *size, uint32_t n)
{
    node_place        *to = &l->nodes[n], *first = &l->nodes[to->shape];
    const packed_node *node = &l->set->nodes[to->node];
    const uint32_t    *ids  = node_parts(l->set, node);
    const uint32_t     page = (uint32_t)l->page_count + 1;
    c->fresh_count          = 0;
    prefetch_blocks(l, to + 1);
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
static vxs_result end_page(layout *l, uint32_t n, const page_size *size)
{
    if (!array_reserve(&l->page_end, &l->page_capacity, l->page_count + 1, sizeof *l->page_end)) return VXS_E_MEMORY;
    uint64_t end = (uint64_t)page_place(l, l->page_count) + page_words(size);
    if (end > UINT32_MAX / 2 || l->page_count == VXS_PAGES_MAX) return VXS_E_REFERENCES;
    l->page_end[l->page_count++] = (page_end){n, (uint32_t)end, size->words};
    return VXS_OK;
}

/* End pages where they are full, or where the words so far are nearest to a multiple of `share`.
 * pages  [is_private][code] zeroed; [out] number of pages with each pattern; NULL: not wanted */
static vxs_result cut(layout *l, cutter *c, uint64_t share, uint32_t *const *pages)
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
        if (n > first && (page_words(&page) > VXS_PAGE_WORDS_MAX || middle >= share * (l->page_count + 1))) {
            /* this node begins the next page */
            r     = end_page(l, n, &before);
            first = n;
            page  = (page_size){0, 0};
            add_to_page(l, c, &page, n);
        }
        for (const tile_code *t = c->fresh; pages && t < c->fresh + c->fresh_count; t++) pages[t->is_private][t->code]++;
    }
    return r == VXS_OK && count ? end_page(l, count, &page) : r;
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

/* First fill each page, which gives the least number of pages. Then cut again into this number of equal pages, so that threads
 * get equal work. */
static vxs_result cut_twice(layout *l, cutter *c, uint32_t *const *pages)
{
    vxs_result r = cut(l, c, VXS_PAGE_WORDS_MAX, pages);
    if (r != VXS_OK || l->page_count < 2) return r;

    /* store patterns of several pages once, as many as there is space for */
    size_t       all = l->codes[0].count + l->codes[1].count, count = 0;
    shared_code *shared = malloc((all + 1) * sizeof *shared);
    r                   = shared ? VXS_OK : VXS_E_MEMORY;
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
    return r == VXS_OK ? cut(l, c, page_place(l, l->page_count) / l->page_count + 1, NULL) : r;
}

vxs_result layout_cut_pages(layout *l)
{
    uint32_t  *pages[2] = {calloc(l->codes[0].count + 1, sizeof **pages), calloc(l->codes[1].count + 1, sizeof **pages)};
    cutter    *c        = calloc(1, sizeof *c);
    vxs_result r        = c && pages[0] && pages[1] ? cutter_init(c, l) : VXS_E_MEMORY;
    if (r == VXS_OK) r = cut_twice(l, c, pages);
    if (c) cutter_free(c);
    free(c);
    free(pages[0]);
    free(pages[1]);
    return r;
}

/* words ----------------------------------------------------------------------------------------------------------------------- */

/* The last page that has a thing, counted from 1, and where it is there: page << PLACE_BITS | place. */
typedef uint32_t page_place_of;

enum { PLACE_BITS = 17 };

/* A thread that writes pages. */
typedef struct page_writer {
    const layout  *l;
    uint32_t      *to;
    size_t         first, step;     /* its pages: first, first + step, ... */
    page_place_of *block, *code[2]; /* words of blocks; halves of patterns, from the first pattern of the page on */
    block_counts   counts;
} page_writer;

/* Whether a thing is not in the page yet; it gets this place. */
static int gets_place(page_place_of *last, size_t page, uint32_t place)
{
    if (*last >> PLACE_BITS == page + 1) return 0;
    *last = (uint32_t)(page + 1) << PLACE_BITS | place;
    return 1;
}

static uint32_t place_of(page_place_of last)
{
    return last & ((1u << PLACE_BITS) - 1);
}

/* Writes halves and bytes into words, from a place on. */
typedef struct half_writer {
    uint32_t *words;
    uint32_t  at;
} half_writer;

static void put_half(half_writer *w, uint32_t half)
{
    w->words[w->at / 2] |= (half & 0xffff) << 16 * (w->at & 1);
    w->at++;
}

static void put_wide(half_writer *w, uint32_t value, int wide)
{
    put_half(w, value);
    if (wide) put_half(w, value >> 16);
}

/* Returns the number of words. */
static uint32_t write_node(const page_place_of *block_at, uint32_t *to, const node_shape *s)
{
    const uint32_t *part = s->parts, *depths = part + s->mixed_count, *end = depths + depth_count(s);
    const int       wide = is_wide(s);
    half_writer     w    = {to, 0};
    for (int n = 0; n < 4; n++) put_half(&w, (uint32_t)(s->mixed >> 16 * n));
    for (int n = 0; n < 4; n++) put_half(&w, (uint32_t)(s->fresh >> 16 * n));
    put_half(&w, (uint32_t)s->slope.x);
    put_half(&w, (uint32_t)s->slope.y);
    put_half(&w, wide ? NODE_WIDE : 0);
    for (; part < depths; part++) put_half(&w, place_of(block_at[*part]));
    for (; part < end; part++) put_wide(&w, *part, wide);
    return (w.at + 1) / 2;
}

static void write_pattern(const layout *l, uint32_t *to, uint32_t half, int is_private, uint32_t code)
{
    const uint16_t *halves = code_halves(l, is_private, code), *end = halves + l->code_size[is_private][code];
    if (half & 1) to[half / 2] |= (uint32_t)*halves++ << 16;
    to += (half + 1) / 2;
    for (; halves + 1 < end; halves += 2) *to++ = halves[0] | (uint32_t)halves[1] << 16;
    if (halves < end) *to |= *halves;
}

/* A page that is being written. */
typedef struct page_sink {
    size_t    page;
    uint32_t *words;
    uint32_t  word, half; /* where the next record and the next pattern go; halves from the first pattern on */
    uint32_t  pool;       /* half of the page where its patterns begin */
} page_sink;

/* The name of a pattern, which is written if it is new in the page. */
static uint32_t pattern_ref(page_writer *w, page_sink *s, int is_private, uint32_t code)
{
    const layout  *l      = w->l;
    const uint32_t common = l->common[is_private][code];
    if (common) return COMMON | (common - 1);
    if (gets_place(&w->code[is_private][code], s->page, s->half)) {
        write_pattern(l, s->words, s->pool + s->half, is_private, code);
        s->half += l->code_size[is_private][code];
        is_private ? w->counts.private_patterns++ : w->counts.patterns++;
    }
    return s->pool + place_of(w->code[is_private][code]);
}

/* The words of tiles with a pattern. */
static uint32_t *write_tiles(page_writer *w, page_sink *s, uint32_t *to, const block_parts *b, int far)
{
    const uint8_t *pattern = b->pattern, *base = b->base, *used = b->used;
    for (uint32_t rest = b->head.patterned; rest; rest &= rest - 1, pattern += 4) {
        const int is_private = (b->head.own & rest & -rest) != 0;
        uint32_t  code, low = 0;
        memcpy(&code, pattern, sizeof code);
        if (!is_private) {
            uint16_t entries;
            memcpy(&entries, used, sizeof entries);
            low = entries;
            used += sizeof entries;
        } else if (!far) {
            memcpy(&low, base, sizeof low);
            low += FAR_BASE;
            base += sizeof low;
        }
        *to++ = pattern_ref(w, s, is_private, code) << 14 | low;
    }
    return to;
}

static void write_block(page_writer *w, page_sink *s, const block_parts *b)
{
    const block_head *h    = &b->head;
    const int         far  = is_far(b);
    uint32_t         *from = s->words + s->word, *to = from + 2;
    from[0] = h->patterned | (uint32_t)h->fresh << 16;
    from[1] = h->own | h->planar | (uint32_t)((h->depths - 1) | h->shift << 4 | h->width << 8 | (far ? (int)BLOCK_FAR : 0)) << 16;
    if (h->planar) {
        plane p = {0};
        if (h->has_plane) memcpy(&p, b->plane, sizeof p);
        const int shift = plane_shift(&p);
        *to++           = ((uint32_t)(p.across >> shift) & 0xffff) | (uint32_t)(p.down >> shift) << 16;
        *to++           = (uint32_t)shift | (uint32_t)p.least << 4;
    }
    to = write_tiles(w, s, to, b, far);
    for (uint32_t n = 0; n < h->tail_words; n++) *to++ = vxs_load32(b->tail + 4 * n);
    if (far) {
        memcpy(to, b->base, h->owns * sizeof *to);
        to += h->owns;
    }
    const uint32_t words = (uint32_t)(to - from);
    s->word += words;
    w->counts.blocks++;
    w->counts.block_words += words;
    w->counts.tiles += h->patterns;
    w->counts.private_tiles += h->owns;
}

/* Write a node that is new in the page, and behind it its blocks that are. */
static void write_record(page_writer *w, page_sink *s, const node_place *place)
{
    const layout *l    = w->l;
    uint32_t      word = s->word + place->words, fresh[NODE_BLOCKS], count = 0;
    node_shape    shape;
    shape_of(&shape, l, place);
    for (uint32_t k = 0; k < shape.mixed_count; k++) {
        const uint32_t id = shape.parts[k];
        if (!gets_place(&w->block[id], s->page, word)) continue;
        word += l->block_words[id];
        fresh[count++] = id;
    }
    s->word += write_node(w->block, s->words + s->word, &shape);
    w->counts.nodes++;
    w->counts.node_words += place->words;
    for (uint32_t k = 0; k < count; k++) {
        const block_parts b = block_parts_of(intern_at(&l->set->blocks, fresh[k]));
        write_block(w, s, &b);
    }
}

/* Write the contents of a page.   words  zeroed */
static void write_page(page_writer *w, size_t page, uint32_t *words)
{
    const layout     *l   = w->l;
    const page_end   *end = &l->page_end[page];
    page_sink         s   = {.page = page, .words = words, .pool = 2 * end->node_words};
    const node_place *n   = l->nodes + (page ? end[-1].node : 0);
    for (; n < l->nodes + end->node; n++) {
        prefetch_blocks(l, n + 1);
        if (n->word != s.word) continue;
        run_control_wait();
        write_record(w, &s, n);
    }
    w->counts.pattern_words += (s.half + 1) / 2;
}

/* Each writer takes every step-th page: its scratch is as large as all that pages can contain, so there are few writers. */
static void write_some_pages(void *user, size_t begin, size_t end, uint32_t worker)
{
    page_writer *w = user;
    (void)worker;
    for (size_t n = begin; n < end; n++)
        for (size_t page = w[n].first; page < w[n].l->page_count; page += w[n].step)
            write_page(&w[n], page, w[n].to + page_place(w[n].l, page));
}

static vxs_result writer_init(page_writer *w)
{
    w->block = calloc(w->l->set->blocks.count + 1, sizeof *w->block);
    for (int k = 0; k < 2; k++) w->code[k] = calloc(w->l->codes[k].count + 1, sizeof **w->code);
    return w->block && w->code[0] && w->code[1] ? VXS_OK : VXS_E_MEMORY;
}

static void writer_free(page_writer *w)
{
    free(w->block);
    free(w->code[0]);
    free(w->code[1]);
}

vxs_result layout_write_pages(layout *l, uint32_t *to)
{
    page_writer writers[WRITERS_MAX];
    uint32_t    count = min_u32(min_u32(max_u32(l->threads, 1), WRITERS_MAX), (uint32_t)l->page_count), made = 0;
    vxs_result  r = VXS_OK;
    for (; made < count && r == VXS_OK; made++) {
        writers[made] = (page_writer){.l = l, .to = to, .first = made, .step = count};
        r             = writer_init(&writers[made]);
    }
    if (r == VXS_OK) parallel_for(count, count, 1, write_some_pages, writers);
    for (uint32_t n = 0; n < made; n++) {
        const block_counts *from = &writers[n].counts;
        block_counts       *sum  = &l->out->counts;
        sum->nodes += from->nodes;
        sum->blocks += from->blocks;
        sum->tiles += from->tiles;
        sum->private_tiles += from->private_tiles;
        sum->patterns += from->patterns;
        sum->private_patterns += from->private_patterns;
        sum->node_words += from->node_words;
        sum->block_words += from->block_words;
        sum->pattern_words += from->pattern_words;
        writer_free(&writers[n]);
    }
    return r;
}

void layout_write_common(const layout *l, uint32_t *to)
{
    for (int is_private = 0; is_private < 2; is_private++)
        for (uint32_t code = 0; code < l->codes[is_private].count; code++)
            if (l->common[is_private][code]) write_pattern(l, to, l->common[is_private][code] - 1, is_private, code);
}
