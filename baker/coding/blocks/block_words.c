/* Writes the words of pages; see block_layout.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_layout.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/run_control.h"
#include "baker/base/threads.h"
#include "baker/coding/blocks/blocks.h"
#include "formats/vxs_bytes.h"

enum { WRITERS_MAX = 8 /* most threads that write pages: each needs scratch memory */ };

#define NODE_WIDE 1u
#define BLOCK_FAR 0x400u
#define COMMON    0x20000u

/* The last page that has a block or pattern, counted from 1, and where it is there: page << PLACE_BITS | place. */
typedef uint32_t place_in_page;

enum { PLACE_BITS = 17 };

/* A thread that writes pages. */
typedef struct page_writer {
    const layout  *l;
    place_in_page *block, *code[2]; /* words of blocks; halves of patterns, from the first pattern of the page on */
    block_counts   counts;
} page_writer;

/* Whether it is not in the page yet; then it gets this place. */
static int gets_place(place_in_page *last, size_t page, uint32_t place)
{
    if (*last >> PLACE_BITS == page + 1) return 0;
    *last = (uint32_t)(page + 1) << PLACE_BITS | place;
    return 1;
}

static uint32_t place_of(place_in_page last)
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
static uint32_t write_node(const place_in_page *block_at, uint32_t *to, const node_shape *s)
{
    const uint32_t *part = s->parts, *depths = part + s->mixed_count, *end = depths + shape_depths(s);
    const int       wide = shape_is_wide(s);
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
    for (uint32_t rest = b->head.mixed; rest; rest &= rest - 1, pattern += 4) {
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
    const int         far  = block_is_far(b);
    uint32_t         *from = s->words + s->word, *to = from + 2;
    from[0] = h->mixed | (uint32_t)h->fresh << 16;
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
        memcpy(to, b->base, h->own_count * sizeof *to);
        to += h->own_count;
    }
    const uint32_t words = (uint32_t)(to - from);
    s->word += words;
    w->counts.blocks++;
    w->counts.block_words += words;
    w->counts.tiles += h->mixed_count;
    w->counts.private_tiles += h->own_count;
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
        layout_prefetch(l, n + 1);
        if (n->word != s.word) continue;
        run_control_wait();
        write_record(w, &s, n);
    }
    w->counts.pattern_words += (s.half + 1) / 2;
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

/* Pages that are cut on one thread, and written on the others. */
typedef struct page_queue {
    layout     *l;
    uint32_t   *to;   /* of the first page */
    size_t      room; /* for all pages, in words */
    page_writer writers[WRITERS_MAX];
    os_mutex    lock;
    os_signal   more;
    size_t      cut, taken; /* pages that can be written; that are */
    int         ended;      /* no page will be cut */
    vxs_result  result;     /* of cutting */
} page_queue;

/* Pages behind the room are written later. */
static void page_is_cut(void *user, size_t page_count)
{
    page_queue *q = user;
    os_lock(&q->lock);
    if (page_place(q->l, page_count) <= q->room) q->cut = page_count;
    os_wake_all(&q->more);
    os_unlock(&q->lock);
}

static void cut_pages(page_queue *q)
{
    const vxs_result r = layout_cut_pages(q->l, page_is_cut, q);
    os_lock(&q->lock);
    q->result = r;
    q->ended  = 1;
    os_wake_all(&q->more);
    os_unlock(&q->lock);
}

/* The next page to write. 0: there is none. */
static int next_page(page_queue *q, size_t *page)
{
    run_control *run = run_control_current();
    for (;;) {
        os_lock(&q->lock);
        const int is_there = q->taken < q->cut, waits = !is_there && !q->ended;
        if (is_there) *page = q->taken++;
        if (waits) {
            run_control_leave(run);
            os_wait(&q->more, &q->lock);
        }
        os_unlock(&q->lock);
        if (!waits) return is_there;
        run_control_enter(run);
    }
}

/* The first piece of work is to cut the pages; the others are the writers. */
static void work_on_pages(void *user, size_t begin, size_t end, uint32_t worker)
{
    page_queue *q = user;
    (void)worker;
    for (size_t n = begin, page; n < end; n++) {
        if (!n)
            cut_pages(q);
        else
            while (next_page(q, &page)) write_page(&q->writers[n - 1], page, q->to + page_place(q->l, page));
    }
}

static void add_counts(block_counts *sum, const block_counts *from)
{
    sum->nodes += from->nodes;
    sum->blocks += from->blocks;
    sum->tiles += from->tiles;
    sum->private_tiles += from->private_tiles;
    sum->patterns += from->patterns;
    sum->private_patterns += from->private_patterns;
    sum->node_words += from->node_words;
    sum->block_words += from->block_words;
    sum->pattern_words += from->pattern_words;
}

static void write_on(void *user, size_t begin, size_t end, uint32_t worker)
{
    work_on_pages(user, begin + 1, end + 1, worker);
}

/* Make room for all pages, which are cut, and write those that had none. */
static vxs_result write_rest(page_queue *q, size_t before, uint32_t count, uint32_t **memory)
{
    const size_t was = before + q->room, all = before + page_place(q->l, q->l->page_count);
    uint32_t    *grown = realloc(*memory, (all + VXS_BLOCKS_SPARE_WORDS) * sizeof *grown);
    if (!grown) return VXS_E_MEMORY;
    memset(grown + was, 0, (all + VXS_BLOCKS_SPARE_WORDS - was) * sizeof *grown);
    *memory = grown;
    q->to   = grown + before;
    q->cut  = q->l->page_count;
    parallel_for(q->l->threads, count, 1, write_on, q);
    return VXS_OK;
}

vxs_result layout_write_pages(layout *l, size_t before, uint32_t **memory)
{
    page_queue q     = {.l = l, .room = page_place(l, l->page_count)};
    uint32_t   count = min_u32(min_u32(max_u32(l->threads, 1), WRITERS_MAX), (uint32_t)l->page_count), made = 0;
    vxs_result r = VXS_OK;
    *memory      = calloc(before + q.room + VXS_BLOCKS_SPARE_WORDS, sizeof **memory);
    if (!*memory) return VXS_E_MEMORY;
    q.to = *memory + before;
    os_mutex_init(&q.lock);
    os_signal_init(&q.more);
    for (; made < count && r == VXS_OK; made++) {
        q.writers[made].l = l;
        r                 = writer_init(&q.writers[made]);
    }
    if (r == VXS_OK) parallel_for(l->threads, 1 + count, 1, work_on_pages, &q);
    if (r == VXS_OK) r = q.result;
    if (r == VXS_OK && q.cut < l->page_count) r = write_rest(&q, before, count, memory);
    for (uint32_t n = 0; n < made; n++) {
        add_counts(&l->out->counts, &q.writers[n].counts);
        writer_free(&q.writers[n]);
    }
    os_signal_free(&q.more);
    os_mutex_free(&q.lock);
    if (r != VXS_OK) {
        free(*memory);
        *memory = NULL;
    }
    return r;
}

void layout_write_common(const layout *l, uint32_t *to)
{
    for (int is_private = 0; is_private < 2; is_private++)
        for (uint32_t code = 0; code < l->codes[is_private].count; code++)
            if (l->common[is_private][code]) write_pattern(l, to, l->common[is_private][code] - 1, is_private, code);
}
