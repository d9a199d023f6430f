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

/* Blocks that begin a new run of equal depths. */
static uint64_t fresh_blocks(const node_shape *s)
{
    uint64_t fresh = 0;
    int      last  = -1;
    for (int b = 0; b < NODE_BLOCKS; b++) {
        if (s->mixed >> b & 1) continue;
        if (last < 0 || s->depth[b] != s->depth[last]) fresh |= 1ull << b;
        last = b;
    }
    return fresh;
}

static int is_wide(const node_shape *s)
{
    int wide = 0;
    for (int b = 0; b < NODE_BLOCKS; b++) wide |= s->depth[b] != NEVER && s->depth[b] > 0xfffe;
    return wide;
}

uint32_t layout_node_words(const node_shape *s)
{
    uint32_t mixed = (uint32_t)__builtin_popcountll(s->mixed), fresh = (uint32_t)__builtin_popcountll(fresh_blocks(s));
    return (NODE_HALVES + mixed + (mixed + fresh) * (is_wide(s) ? 2 : 1) + 1) / 2;
}

/* blocks ---------------------------------------------------------------------------------------------------------------------- */

/* Sizes and kinds of a block's parts. */
typedef struct block_form {
    uint32_t mixed, own, plane, fresh; /* bit masks of tiles */
    uint32_t width, shift, far;        /* of deltas: 0 bytes, 1 halves, 2 words */
    uint32_t words;
} block_form;

static block_form form_of(const block_lists *b)
{
    const block_head *h    = &b->head;
    block_form        f    = {.mixed = h->patterned, .own = h->own, .plane = h->planar};
    uint32_t          bits = 0, last = NEVER, greatest = (uint32_t)b->depth[h->depths - 1];
    const uint32_t    uniform = ~(f.mixed | f.plane) & 0xffff, owns = (uint32_t)__builtin_popcount(f.own);
    for (uint32_t n = 1; n < h->depths; n++) bits |= (uint32_t)b->depth[n];
    f.shift = common_shift(bits);
    f.width = greatest >> f.shift <= 0xff ? 0 : greatest >> f.shift <= 0xffff ? 1 : 2;
    if (f.width == 2) f.shift = 0;
    for (uint32_t n = 0; n < owns; n++) f.far |= b->base[n] < -FAR_BASE || b->base[n] >= FAR_BASE;
    for (uint32_t rest = uniform; rest; rest &= rest - 1) {
        const uint32_t palette = b->palette[__builtin_ctz(rest)];
        if (palette != last) f.fresh |= rest & -rest;
        last = palette;
    }
    uint32_t bytes = ((h->depths - 1u) << f.width) + ((uint32_t)__builtin_popcount(f.fresh) + 1) / 2;
    f.words        = 2 + (f.plane ? PLANE_WORDS : 0) + (uint32_t)__builtin_popcount(f.mixed) + (bytes + 3) / 4 + (f.far ? owns : 0);
    return f;
}

static void measure_some_blocks(void *user, size_t begin, size_t end, uint32_t worker)
{
    const layout *l = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        block_lists b;
        block_read(&b, intern_at(&l->set->blocks, (uint32_t)n));
        l->block_words[n] = (uint16_t)form_of(&b).words;
        block_renumber(intern_at(&l->set->blocks, (uint32_t)n), l->code_of[0], l->code_of[1], NULL);
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

/* Stamp of the common patterns, which are never new in a page. */
#define IN_COMMON UINT32_MAX

/* Whether a thing is not in the page yet. Marks it as in the page, at `at`. */
static int is_new(in_page *p, uint32_t stamp, uint32_t at)
{
    if (p->stamp >= stamp) return 0;
    *p = (in_page){stamp, at};
    return 1;
}

/* Add to a page the patterns of a block that are not in it yet. */
static void add_patterns(const layout *l, page_scratch *s, page_size *page, uint32_t id)
{
    block_head head;
    uint32_t   codes[BLOCK_TILES];
    block_patterns(intern_at(&l->set->blocks, id), &head, codes);
    for (uint32_t n = 0, rest = head.patterned; rest; n++, rest &= rest - 1) {
        const int is_private = head.own >> __builtin_ctz(rest) & 1;
        if (!is_new(&s->code_at[is_private][codes[n]], s->stamp, page->halves)) continue;
        page->halves += l->code_size[is_private][codes[n]];
        s->fresh[s->fresh_count++] = (tile_code){is_private, codes[n]};
    }
}

/* Blocks are scattered in memory: ask for those of a node early. */
static void prefetch_blocks(const layout *l, const page_scratch *s, const node_place *n)
{
    const block_node *node = &l->set->nodes[n->node];
    for (uint64_t rest = node->mixed; rest; rest &= rest - 1) {
        const uint32_t id = node->block[__builtin_ctzll(rest)];
        __builtin_prefetch(&s->block_at[id]);
        __builtin_prefetch(intern_at(&l->set->blocks, id));
    }
}

/* Add to a page the words of a node, and of its blocks and patterns that are not in the page yet; give them places. Patterns
 * count from half 0. */
static void add_to_page(const layout *l, page_scratch *s, page_size *page, const node_place *n)
{
    const block_node *node = &l->set->nodes[n->node];
    s->fresh_count         = 0;
    prefetch_blocks(l, s, n + 1);
    if (!is_new(&s->shape_at[n->shape], s->stamp, page->words)) return;
    page->words += n->words;
    for (uint64_t rest = node->mixed; rest; rest &= rest - 1) {
        const uint32_t id = node->block[__builtin_ctzll(rest)];
        if (!is_new(&s->block_at[id], s->stamp, page->words)) continue;
        page->words += l->block_words[id];
        add_patterns(l, s, page, id);
    }
}

static uint32_t page_words(const page_size *p)
{
    return p->words + (p->halves + 1) / 2;
}

static void mark_common(page_scratch *s, const layout *l)
{
    for (int is_private = 0; is_private < 2; is_private++)
        for (uint32_t code = 0; code < l->codes[is_private].count; code++)
            if (l->common[is_private][code]) s->code_at[is_private][code].stamp = IN_COMMON;
}

static vxs_result scratch_init(page_scratch *s, const layout *l)
{
    *s = (page_scratch){
        .shape_at = calloc(l->set->node_count + 1, sizeof *s->shape_at),
        .block_at = calloc(l->set->blocks.count + 1, sizeof *s->block_at),
        .code_at  = {calloc(l->codes[0].count + 1, sizeof **s->code_at), calloc(l->codes[1].count + 1, sizeof **s->code_at)}};
    if (!s->shape_at || !s->block_at || !s->code_at[0] || !s->code_at[1]) return VXS_E_MEMORY;
    mark_common(s, l);
    return VXS_OK;
}

static void scratch_free(page_scratch *s)
{
    free(s->shape_at);
    free(s->block_at);
    free(s->code_at[0]);
    free(s->code_at[1]);
}

/* End the page before node n. */
static vxs_result end_page(layout *l, uint32_t n, uint32_t words)
{
    if (!array_reserve(&l->page_end, &l->page_capacity, l->page_count + 1, sizeof *l->page_end)) return VXS_E_MEMORY;
    uint64_t end = (uint64_t)page_place(l, l->page_count) + words;
    if (end > UINT32_MAX / 2) return VXS_E_REFERENCES;
    l->page_end[l->page_count++] = (page_end){n, (uint32_t)end};
    l->scratch.stamp++;
    return VXS_OK;
}

/* End pages where they are full, or where the words so far are nearest to a multiple of `share`.
 * pages  [is_private][code] zeroed; [out] number of pages with each pattern; NULL: not wanted */
static vxs_result cut(layout *l, uint64_t share, uint32_t *const *pages)
{
    page_scratch *s     = &l->scratch;
    uint32_t      count = (uint32_t)l->set->node_count;
    page_size     page  = {0, 0};
    vxs_result    r     = VXS_OK;
    l->page_count       = 0;
    s->stamp++;
    for (uint32_t n = 0, first = 0; n < count && r == VXS_OK; n++) {
        node_place *node   = &l->nodes[n];
        uint32_t    before = page_words(&page);
        add_to_page(l, s, &page, node);
        uint64_t middle =
            page_place(l, l->page_count) + ((uint64_t)before + page_words(&page)) / 2; /* middle of this node among all words */
        if (n > first && (page_words(&page) > VXS_PAGE_WORDS_MAX || middle >= share * (l->page_count + 1))) {
            /* this node begins the next page */
            r     = end_page(l, n, before);
            first = n;
            page  = (page_size){0, 0};
            add_to_page(l, s, &page, node);
        }
        node->page = (uint32_t)l->page_count;
        node->word = s->shape_at[node->shape].at;
        for (const tile_code *t = s->fresh; pages && t < s->fresh + s->fresh_count; t++) pages[t->is_private][t->code]++;
    }
    return r == VXS_OK && count ? end_page(l, count, page_words(&page)) : r;
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
static vxs_result cut_twice(layout *l, uint32_t *const *pages)
{
    vxs_result r = cut(l, VXS_PAGE_WORDS_MAX, pages);
    if (r != VXS_OK || l->page_count < 2) return r;

    /* store patterns of several pages once, as many as there is space for */
    size_t       all = l->codes[0].count + l->codes[1].count, count = 0;
    shared_code *shared = malloc((all + 1) * sizeof *shared);
    r                   = shared ? VXS_OK : VXS_E_MEMORY;
    for (uint32_t is_private = 0; is_private < 2 && r == VXS_OK; is_private++)
        for (uint32_t code = 0; code < l->codes[is_private].count; code++)
            if (pages[is_private][code] > 1) shared[count++] = (shared_code){pages[is_private][code], is_private, code};
    if (count) qsort(shared, count, sizeof *shared, by_use);
    for (const shared_code *c = shared; c < shared + count && r == VXS_OK; c++) {
        const uint32_t size = l->code_size[c->is_private][c->code];
        if (l->common_halves + size > VXS_COMMON_HALVES_MAX) continue;
        if (!array_reserve(&l->common_kinds, &l->common_capacity, l->common_count + 1, sizeof *l->common_kinds)) {
            r = VXS_E_MEMORY;
            break;
        }
        l->common_kinds[l->common_count++] = (uint8_t)(code_halves(l, (int)c->is_private, c->code)[-1] >> 8);
        l->common[c->is_private][c->code]  = 1 + l->common_halves;
        l->common_halves += size;
    }
    free(shared);
    mark_common(&l->scratch, l);

    return r == VXS_OK ? cut(l, page_place(l, l->page_count) / l->page_count + 1, NULL) : r;
}

vxs_result layout_cut_pages(layout *l)
{
    uint32_t  *pages[2] = {calloc(l->codes[0].count + 1, sizeof **pages), calloc(l->codes[1].count + 1, sizeof **pages)};
    vxs_result r        = scratch_init(&l->scratch, l);
    if (!pages[0] || !pages[1]) r = VXS_E_MEMORY;
    if (r == VXS_OK) r = cut_twice(l, pages);
    free(pages[0]);
    free(pages[1]);
    scratch_free(&l->scratch);
    return r == VXS_OK && l->page_count > VXS_PAGES_MAX ? VXS_E_REFERENCES : r;
}

/* words ----------------------------------------------------------------------------------------------------------------------- */

/* Scratch of a thread that writes pages. */
typedef struct page_writer {
    const layout *l;
    uint32_t     *to;
    size_t        first, step; /* its pages: first, first + step, ... */
    page_scratch  scratch;
    block_counts  counts;
} page_writer;

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

static void put_bytes(uint32_t *words, uint32_t at, uint32_t value, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++, at++) words[at / 4] |= (value >> 8 * n & 0xff) << 8 * (at & 3);
}

/* Returns the number of words. */
static uint32_t write_node(const page_scratch *places, uint32_t *to, const node_shape *s)
{
    uint64_t    fresh = fresh_blocks(s);
    int         wide  = is_wide(s);
    half_writer w     = {to, 0};
    for (int n = 0; n < 4; n++) put_half(&w, (uint32_t)(s->mixed >> 16 * n));
    for (int n = 0; n < 4; n++) put_half(&w, (uint32_t)(fresh >> 16 * n));
    put_half(&w, (uint32_t)s->slope.x);
    put_half(&w, (uint32_t)s->slope.y);
    put_half(&w, wide ? NODE_WIDE : 0);
    for (int b = 0; b < NODE_BLOCKS; b++)
        if (s->mixed >> b & 1) put_half(&w, places->block_at[s->block[b]].at);
    for (int b = 0; b < NODE_BLOCKS; b++)
        if (s->mixed >> b & 1) put_wide(&w, s->depth[b], wide);
    for (int b = 0; b < NODE_BLOCKS; b++)
        if (fresh >> b & 1) put_wide(&w, s->depth[b], wide);
    return (w.at + 1) / 2;
}

/* pool  half of the page where its patterns begin */
static void write_block(const layout *l, const page_scratch *s, uint32_t *to, const block_lists *b, block_form f, uint32_t pool)
{
    uint32_t word = 2, byte, nibbles = 0;
    to[0] = f.mixed | f.fresh << 16;
    to[1] = f.own | f.plane | ((b->head.depths - 1u) | f.shift << 4 | f.width << 8 | (f.far ? BLOCK_FAR : 0)) << 16;
    if (f.plane) {
        int shift  = plane_shift(&b->plane);
        to[word++] = ((uint32_t)(b->plane.across >> shift) & 0xffff) | (uint32_t)(b->plane.down >> shift) << 16;
        to[word++] = (uint32_t)shift | (uint32_t)b->plane.least << 4;
    }
    for (uint32_t n = 0, own = 0, rest = f.mixed; rest; n++, rest &= rest - 1) {
        const int      tile = __builtin_ctz(rest), is_private = f.own >> tile & 1;
        const uint32_t code = b->pattern[n], common = l->common[is_private][code];
        const uint32_t ref = common ? COMMON | (common - 1) : pool + s->code_at[is_private][code].at;
        uint32_t       low = b->palette[tile];
        if (is_private) low = f.far ? 0 : (uint32_t)(b->base[own++] + FAR_BASE);
        to[word++] = ref << 14 | low;
    }
    byte = 4 * word;
    for (uint32_t n = 1; n < b->head.depths; n++, byte += 1u << f.width)
        put_bytes(to, byte, (uint32_t)b->depth[n] >> f.shift, 1u << f.width);
    for (uint32_t rest = f.fresh; rest; rest &= rest - 1, nibbles++)
        put_bytes(to, byte + nibbles / 2, (uint32_t)b->palette[__builtin_ctz(rest)] << 4 * (nibbles & 1), 1);
    word = (byte + (nibbles + 1) / 2 + 3) / 4;
    if (f.far) memcpy(to + word, b->base, (size_t)__builtin_popcount(f.own) * sizeof *to);
}

static void write_pattern(const layout *l, uint32_t *to, uint32_t half, int is_private, uint32_t code)
{
    const uint16_t *halves = code_halves(l, is_private, code), *end = halves + l->code_size[is_private][code];
    if (half & 1) to[half / 2] |= (uint32_t)*halves++ << 16;
    to += (half + 1) / 2;
    for (; halves + 1 < end; halves += 2) *to++ = halves[0] | (uint32_t)halves[1] << 16;
    if (halves < end) *to |= *halves;
}

/* Write the contents of a page.   words  zeroed */
static void write_page(page_writer *w, size_t page, uint32_t *words)
{
    const layout *l     = w->l;
    uint32_t      first = page ? l->page_end[page - 1].node : 0, end = l->page_end[page].node, next_word = 0, next_half = 0;
    page_size     size = {0, 0};
    block_counts *c    = &w->counts;
    w->scratch.stamp++;
    for (uint32_t n = first; n < end; n++) add_to_page(l, &w->scratch, &size, &l->nodes[n]);
    uint32_t pool = 2 * size.words;
    for (uint32_t n = first; n < end; n++) {
        if (l->nodes[n].word != next_word) continue;
        node_shape shape;
        shape_of(&shape, l, &l->nodes[n]);
        run_control_wait();
        uint32_t node_words = write_node(&w->scratch, words + next_word, &shape);
        next_word += node_words;
        c->nodes++;
        c->node_words += node_words;
        for (int b = 0; b < NODE_BLOCKS; b++) {
            if (!(shape.mixed >> b & 1) || w->scratch.block_at[shape.block[b]].at != next_word) continue;
            block_lists of;
            block_read(&of, intern_at(&l->set->blocks, shape.block[b]));
            block_form form = form_of(&of);
            write_block(l, &w->scratch, words + next_word, &of, form, pool);

            /* the patterns that no earlier block of the page uses */
            for (uint32_t k = 0, rest = form.mixed; rest; k++, rest &= rest - 1) {
                const int      is_private = form.own >> __builtin_ctz(rest) & 1;
                const uint32_t code       = of.pattern[k];
                if (l->common[is_private][code] || w->scratch.code_at[is_private][code].at != next_half) continue;
                write_pattern(l, words, pool + next_half, is_private, code);
                next_half += l->code_size[is_private][code];
                is_private ? w->counts.private_patterns++ : w->counts.patterns++;
            }

            next_word += form.words;
            c->blocks++;
            c->block_words += form.words;
            c->tiles += (uint32_t)__builtin_popcount(form.mixed);
            c->private_tiles += (uint32_t)__builtin_popcount(form.own);
        }
    }
    c->pattern_words += (size.halves + 1) / 2;
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

vxs_result layout_write_pages(layout *l, uint32_t *to)
{
    page_writer writers[WRITERS_MAX];
    uint32_t    count = min_u32(min_u32(max_u32(l->threads, 1), WRITERS_MAX), (uint32_t)l->page_count), made = 0;
    vxs_result  r = VXS_OK;
    for (; made < count && r == VXS_OK; made++) {
        writers[made] = (page_writer){.l = l, .to = to, .first = made, .step = count};
        r             = scratch_init(&writers[made].scratch, l);
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
        scratch_free(&writers[n].scratch);
    }
    return r;
}

void layout_write_common(const layout *l, uint32_t *to)
{
    for (int is_private = 0; is_private < 2; is_private++)
        for (uint32_t code = 0; code < l->codes[is_private].count; code++)
            if (l->common[is_private][code]) write_pattern(l, to, l->common[is_private][code] - 1, is_private, code);
}
