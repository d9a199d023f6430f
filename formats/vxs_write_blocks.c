/* Writing a light of palette blocks: its resident part and its pages; formats/vxs.md section 14.
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

/* State of encoding pages. */
typedef struct page_encoder {
    const vxs_blocks_view *view;
    const vxs_page_nodes  *known;
    const vxs_common      *pool;
    vxs_common_marks       common; /* only for packing fast, like the next */
    int                    zstd_level;
    encoded_page          *out; /* [pages.count] */
    vxs_items              pages;
} page_encoder;

static uint32_t page_words(const vxs_blocks_view *view, uint32_t page)
{
    return page_start(view, page + 1) - page_start(view, page);
}

/* A task: encodes pages that no other task has taken. After an error no further page is taken; all pages before it are
 * encoded. */
static void encode_some_pages(void *work, uint32_t task)
{
    page_encoder         *e       = work;
    const vxs_page_nodes *k       = e->known;
    int                   is_fast = e->view->packing == VXS_PACKING_FAST;
    vxs_page_encoder     *encoder = is_fast ? NULL : vxs_page_encoder_new();
    vxs_page_marks       *marks   = is_fast ? malloc(sizeof *marks) : NULL;
    ZSTD_CCtx            *zstd    = is_fast ? vxs_compressor(e->zstd_level) : NULL;
    uint32_t              page;
    (void)task;
    if (marks) marks->common = &e->common;
    while (vxs_items_next(&e->pages, &page)) {
        encoded_page        *to         = &e->out[page];
        const uint32_t      *words      = e->view->words + page_start(e->view, page);
        uint32_t             count      = page_words(e->view, page);
        const vxs_page_node *nodes      = k->nodes + k->page_first[page];
        uint32_t             node_count = k->page_first[page + 1] - k->page_first[page];
        if (encoder)
            to->result = vxs_page_encode(encoder, &to->bytes, words, count, nodes, node_count, e->pool);
        else if (marks && zstd)
            to->result = vxs_page_pack(&to->bytes, words, count, nodes, node_count, marks, zstd);
        else
            to->result = VXS_E_MEMORY;
        if (to->result != VXS_OK) vxs_items_end(&e->pages);
    }
    vxs_page_encoder_free(encoder);
    ZSTD_freeCCtx(zstd);
    free(marks);
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

/* Encode all pages, on the threads that the caller lends. */
static vxs_result encode_pages(vxs_bytes *content, const vxs_sections *s, const vxs_blocks_view *view, const vxs_page_nodes *known,
                               const vxs_common *common)
{
    uint32_t     count = view->words[PAGE_COUNT_WORD];
    vxs_result   r     = VXS_E_MEMORY;
    page_encoder e     = {.view       = view,
                          .known      = known,
                          .pool       = common,
                          .zstd_level = s->zstd_level,
                          .pages      = {.count = count, .parallel = s->parallel}};
    e.out              = calloc((size_t)count + 1, sizeof *e.out);
    e.common.at        = malloc((size_t)common->half_count + 1);
    if (e.out && e.common.at) {
        vxs_common_mark(&e.common, common);
        vxs_tasks_run(s->parallel, vxs_task_count(s->parallel, count), encode_some_pages, &e);
        r = join_pages(content, view, e.out, count);
        for (uint32_t n = 0; n < count; n++) free(e.out[n].bytes.data);
    }
    free(e.out);
    free(e.common.at);
    return r;
}

vxs_result vxs_write_blocks(vxs_sections *s, const vxs_blocks_view *view, const vxs_light *light, uint32_t number)
{
    if (!in_order(view) || view->packing > VXS_PACKING_FINE) return VXS_E_ARGUMENT;
    vxs_bytes      resident = {0}, pages = {0};
    vxs_page_nodes known = {0};
    vxs_common     common;
    uint32_t      *patterns = malloc(((size_t)view->common_count + 1) * sizeof *patterns);
    vxs_result     r        = patterns ? VXS_E_ARGUMENT : VXS_E_MEMORY;

    /* the common pool ends at the first page; its last half may be padding */
    const uint32_t *pool   = view->words + view->words[COMMON_WORD];
    uint32_t        halves = 2 * (page_start(view, 0) - view->words[COMMON_WORD]);
    for (uint32_t padding = 0; padding < 2 && padding <= halves && r == VXS_E_ARGUMENT; padding++)
        r = vxs_common_index(&common, patterns, view->common_kinds, view->common_count, pool, halves - padding);
    common.packing = view->packing;
    if (r == VXS_OK)
        r = vxs_resident_encode(&resident, &known, view->words, page_start(view, 0), light->levels, vxs_map_count(light), &common);
    if (r == VXS_OK) r = encode_pages(&pages, s, view, &known, &common);
    if (r == VXS_OK && view->packing == VXS_PACKING_FAST) {
        /* The bytes so far were needed to check that the resident part keeps every rule. */
        vxs_resident_sizes sizes = {page_start(view, 0), view->words[PAGE_COUNT_WORD], known.node_count, view->common_count};
        resident.size_bytes      = 0;
        r                        = vxs_resident_pack(&resident, &sizes, view->words, view->common_kinds, s->zstd);
    }
    if (r == VXS_OK) r = vxs_add_stored(s, VXS_KIND_RESIDENT, number, &resident);
    if (r == VXS_OK) r = vxs_add_stored(s, VXS_KIND_PAGES, number, &pages);

    free(known.nodes);
    free(known.page_first);
    free(patterns);
    free(resident.data);
    free(pages.data);
    return r;
}
