/* Writing lights of palette blocks: their resident parts and their pages; formats/vxs.md section 14.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "vxs_bytes.h"
#include "vxs_page_fast.h"
#include "vxs_page_layout.h"
#include "vxs_resident_layout.h"
#include "vxs_tasks.h"
#include "vxs_writer.h"

/* pages packed fast (vxs_page_fast.h) ------------------------------------------------------------------------------------------- */

enum { PAGE_HEAD_BYTES = 4 };

/* Append a head and the content as a frame. */
static vxs_result append_packed(vxs_bytes *out, const uint8_t *head, size_t head_bytes, const uint8_t *content,
                                size_t content_bytes, ZSTD_CCtx *zstd)
{
    size_t   before = out->size_bytes, bound = ZSTD_compressBound(content_bytes);
    uint8_t *to = vxs_append(out, head_bytes + bound);
    if (!to) return VXS_E_MEMORY;
    memcpy(to, head, head_bytes);
    size_t stored   = ZSTD_compress2(zstd, to + head_bytes, bound, content, content_bytes);
    out->size_bytes = before + (ZSTD_isError(stored) ? 0 : head_bytes + stored);
    return ZSTD_isError(stored) ? VXS_E_MEMORY : VXS_OK;
}

/* Convert words to bytes in place. */
static uint8_t *to_bytes(uint32_t *words, uint32_t word_count)
{
    uint8_t *bytes = (uint8_t *)words;
    for (uint32_t n = 0; n < word_count; n++) vxs_store32(bytes + 4 * (size_t)n, words[n]);
    return bytes;
}

vxs_result vxs_page_pack(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                         uint32_t node_count, vxs_page_marks *marks, ZSTD_CCtx *zstd)
{
    if (!word_count || word_count > VXS_PAGE_WORDS_MAX) return VXS_E_ARGUMENT;
    uint32_t  node_words = node_words_of(words, word_count, nodes, node_count);
    uint32_t *copy       = malloc(word_count * sizeof *copy);
    if (!copy) return VXS_E_MEMORY;
    memcpy(copy, words, word_count * sizeof *copy);
    vxs_result r = vxs_page_check(copy, word_count, node_words, nodes, node_count, marks, VXS_PAGE_PACK);
    uint8_t    head[PAGE_HEAD_BYTES];
    vxs_store16(head, (uint16_t)(word_count - 1));
    vxs_store16(head + 2, (uint16_t)(node_words - 1));
    r = r != VXS_OK ? VXS_E_ARGUMENT
                    : append_packed(out, head, sizeof head, to_bytes(copy, word_count), 4 * (size_t)word_count, zstd);
    free(copy);
    return r;
}

vxs_result vxs_resident_pack(vxs_bytes *out, const vxs_resident_sizes *sizes, const uint32_t *words, const uint8_t *kinds,
                             ZSTD_CCtx *zstd)
{
    const uint32_t numbers[] = {sizes->word_count, sizes->page_count, sizes->node_count, sizes->pattern_count};
    uint8_t        head[RESIDENT_HEAD_BYTES];
    size_t         size = vxs_resident_inflated_bytes(sizes);
    uint32_t      *copy = malloc(size);
    if (!copy) return VXS_E_MEMORY;
    for (int n = 0; n < 4; n++) vxs_store32(head + 4 * n, numbers[n]);
    memcpy(copy, words, 4 * (size_t)sizes->word_count);
    memset(copy + RESIDENT_WORDS, 0, 4 * (size_t)sizes->page_count);
    if (sizes->pattern_count) memcpy(copy + sizes->word_count, kinds, sizes->pattern_count);
    vxs_result r = append_packed(out, head, sizeof head, to_bytes(copy, sizes->word_count), size, zstd);
    free(copy);
    return r;
}

/* all of a light ---------------------------------------------------------------------------------------------------------------- */

enum { PAGE_COUNT_WORD = 0, COMMON_WORD = 1 };

/* Where page n starts in the words; for n = number of pages, the end of the last page. */
static uint32_t page_start(const vxs_blocks_view *view, uint32_t n)
{
    return n < view->words[PAGE_COUNT_WORD] ? view->words[VXS_BLOCKS_FIRST_PAGE + n] : view->word_count;
}

/* Whether the words are a resident part followed by pages without gaps. */
static int in_order(const vxs_blocks_view *view)
{
    if (view->word_count < VXS_BLOCKS_FIRST_PAGE || view->words[PAGE_COUNT_WORD] > VXS_PAGES_MAX) return 0;
    uint32_t count = view->words[PAGE_COUNT_WORD], head = VXS_BLOCKS_FIRST_PAGE + count;
    if (view->word_count < head || page_start(view, 0) < head) return 0;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t start = page_start(view, n), end = page_start(view, n + 1);
        if (end <= start || end > view->word_count || end - start > VXS_PAGE_WORDS_MAX) return 0;
    }
    return view->words[COMMON_WORD] >= head && view->words[COMMON_WORD] <= page_start(view, 0);
}

/* The bytes of a page, or the error. */
typedef struct encoded_page {
    vxs_bytes  bytes;
    vxs_result result;
} encoded_page;

/* A light of palette blocks, from its words to the bytes of its sections. */
struct vxs_encoded_light {
    const vxs_blocks_view *view; /* NULL: of another coding */
    uint32_t               first_page, page_count;
    uint32_t              *patterns; /* for the next */
    vxs_common             pool;
    vxs_common_marks       marks; /* only for packing fast */
    vxs_page_nodes         known;
    vxs_bytes              resident;
    encoded_page          *pages; /* [page_count] */
};

/* State of encoding the pages of all lights, which are counted on. */
typedef struct page_encoder {
    vxs_encoded_light *lights;
    int                zstd_level;
    vxs_items          pages;
} page_encoder;

static uint32_t page_words(const vxs_blocks_view *view, uint32_t page)
{
    return page_start(view, page + 1) - page_start(view, page);
}

/* Memory of a task, made when a page needs it. */
typedef struct page_tools {
    vxs_page_encoder *encoder;
    vxs_page_marks   *marks;
    ZSTD_CCtx        *zstd;
} page_tools;

static vxs_result encode_page(page_tools *t, const vxs_encoded_light *l, uint32_t page, int zstd_level)
{
    vxs_bytes           *to         = &l->pages[page].bytes;
    const uint32_t      *words      = l->view->words + page_start(l->view, page);
    uint32_t             count      = page_words(l->view, page);
    const vxs_page_node *nodes      = l->known.nodes + l->known.page_first[page];
    uint32_t             node_count = l->known.page_first[page + 1] - l->known.page_first[page];
    if (l->view->packing != VXS_PACKING_FAST) {
        if (!t->encoder) t->encoder = vxs_page_encoder_new();
        return t->encoder ? vxs_page_encode(t->encoder, to, words, count, nodes, node_count, &l->pool) : VXS_E_MEMORY;
    }
    if (!t->marks) t->marks = malloc(sizeof *t->marks);
    if (!t->zstd) t->zstd = vxs_compressor(zstd_level);
    if (!t->marks || !t->zstd) return VXS_E_MEMORY;
    t->marks->common = &l->marks;
    return vxs_page_pack(to, words, count, nodes, node_count, t->marks, t->zstd);
}

/* A task: encodes pages that no other task has taken. After an error no further page is taken; all pages before it are
 * encoded. */
static void encode_some_pages(void *work, uint32_t task)
{
    page_encoder            *e = work;
    page_tools               t = {0};
    const vxs_encoded_light *l = e->lights;
    uint32_t                 page;
    (void)task;
    while (vxs_items_next(&e->pages, &page)) {
        while (page - l->first_page >= l->page_count) l++;
        encoded_page *to = &l->pages[page - l->first_page];
        to->result       = encode_page(&t, l, page - l->first_page, e->zstd_level);
        if (to->result != VXS_OK) vxs_items_end(&e->pages);
    }
    vxs_page_encoder_free(t.encoder);
    ZSTD_freeCCtx(t.zstd);
    free(t.marks);
}

/* Join the content of the section of pages: table, then bytes of the pages. */
static vxs_result join_pages(vxs_bytes *content, const vxs_blocks_view *view, const encoded_page *pages, uint32_t count)
{
    size_t head = VXS_PAGES_PREFIX_BYTES + (size_t)count * VXS_PAGE_BYTES, size = head;
    for (uint32_t n = 0; n < count; n++) {
        if (pages[n].result != VXS_OK) return pages[n].result;
        size += pages[n].bytes.size_bytes;
    }
    uint8_t *table = vxs_append(content, size), *to = table + head;
    if (!table) return VXS_E_MEMORY;
    vxs_store32(table, count);
    vxs_store32(table + 4, VXS_PAGE_BYTES);
    for (uint32_t n = 0; n < count; n++) {
        const vxs_bytes *page  = &pages[n].bytes;
        uint8_t         *entry = table + VXS_PAGES_PREFIX_BYTES + (size_t)n * VXS_PAGE_BYTES;
        vxs_store32(entry + VXS_PAGE_STORED_BYTES, (uint32_t)page->size_bytes);
        vxs_store32(entry + VXS_PAGE_WORD_COUNT, page_words(view, n));
        vxs_store64(entry + VXS_PAGE_HASH, XXH64(page->data, page->size_bytes, 0));
        memcpy(to, page->data, page->size_bytes);
        to += page->size_bytes;
    }
    return VXS_OK;
}

/* Everything of a light but its pages. */
static vxs_result begin_light(vxs_encoded_light *l, const vxs_write_light *light)
{
    const vxs_blocks_view *view = &light->blocks;
    if (!in_order(view) || view->packing > VXS_PACKING_FINE) return VXS_E_ARGUMENT;
    l->view       = view;
    l->page_count = view->words[PAGE_COUNT_WORD];
    l->pages      = calloc((size_t)l->page_count + 1, sizeof *l->pages);
    l->patterns   = malloc(((size_t)view->common_count + 1) * sizeof *l->patterns);
    if (!l->pages || !l->patterns) return VXS_E_MEMORY;

    /* the common pool ends at the first page; its last half may be padding */
    const uint32_t *pool   = view->words + view->words[COMMON_WORD];
    uint32_t        halves = 2 * (page_start(view, 0) - view->words[COMMON_WORD]);
    vxs_result      r      = VXS_E_ARGUMENT;
    for (uint32_t padding = 0; padding < 2 && padding <= halves && r == VXS_E_ARGUMENT; padding++)
        r = vxs_common_index(&l->pool, l->patterns, view->common_kinds, view->common_count, pool, halves - padding);
    l->pool.packing = view->packing;
    if (r != VXS_OK) return r;
    if (view->packing == VXS_PACKING_FAST) {
        if (!(l->marks.at = malloc((size_t)l->pool.half_count + 1))) return VXS_E_MEMORY;
        vxs_common_mark(&l->marks, &l->pool);
    }
    return vxs_resident_encode(&l->resident, &l->known, view->words, page_start(view, 0), light->light.levels,
                               vxs_map_count(&light->light), &l->pool);
}

static void end_light(vxs_encoded_light *l)
{
    for (uint32_t n = 0; n < l->page_count && l->pages; n++) free(l->pages[n].bytes.data);
    free(l->pages);
    free(l->patterns);
    free(l->marks.at);
    free(l->known.nodes);
    free(l->known.page_first);
    free(l->resident.data);
    *l = (vxs_encoded_light){0};
}

vxs_result vxs_encode_blocks(vxs_encoded_light **out, const vxs_sections *s, const vxs_write_light *lights, uint32_t count)
{
    vxs_result   r = VXS_OK;
    page_encoder e = {
        .lights = *out = calloc(count, sizeof **out), .zstd_level = s->zstd_level, .pages = {.parallel = s->parallel}};
    if (!e.lights) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        e.lights[n].first_page = e.pages.count;
        if (lights[n].light.coding == VXS_CODING_BLOCKS) r = begin_light(&e.lights[n], &lights[n]);
        e.pages.count += e.lights[n].page_count;
    }
    if (r == VXS_OK && e.pages.count) vxs_tasks_run(s->parallel, vxs_task_count(s->parallel, e.pages.count), encode_some_pages, &e);
    return r;
}

void vxs_encoded_free(vxs_encoded_light *lights, uint32_t count)
{
    for (uint32_t n = 0; n < count && lights; n++) end_light(&lights[n]);
    free(lights);
}

vxs_result vxs_write_blocks(vxs_sections *s, vxs_encoded_light *lights, uint32_t number)
{
    vxs_encoded_light *l     = &lights[number];
    vxs_bytes          pages = {0};
    vxs_result         r     = join_pages(&pages, l->view, l->pages, l->page_count);
    if (r == VXS_OK && l->view->packing == VXS_PACKING_FAST) {
        /* The bytes so far were needed to check that the resident part keeps every rule. */
        vxs_resident_sizes sizes = {page_start(l->view, 0), l->page_count, l->known.node_count, l->view->common_count};
        l->resident.size_bytes   = 0;
        r                        = vxs_resident_pack(&l->resident, &sizes, l->view->words, l->view->common_kinds, s->zstd);
    }
    if (r == VXS_OK) r = vxs_add_stored(s, VXS_KIND_RESIDENT, number, &l->resident);
    if (r == VXS_OK) r = vxs_add_stored(s, VXS_KIND_PAGES, number, &pages);
    free(pages.data);
    end_light(l);
    return r;
}
