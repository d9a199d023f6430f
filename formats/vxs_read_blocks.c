/* Reading a light of palette blocks: every check of formats/vxs.md section 14 on its resident part and its pages
 * (vxs_read_blocks.h), and its words in the layout of section 13.
 *
 * The sizes in both sections are compared with the memory limit before anything is decoded. After the resident part, pages
 * are decoded by up to as many tasks as there are threads and memory for their tools. Findings are reported afterwards, in
 * the order of pages.
 * SPDX-License-Identifier: MIT */
#include "vxs_read_blocks.h"

#include <string.h>
#include <xxhash.h>

#include "vxs_bytes.h"
#include "vxs_reader.h"
#include "vxs_tasks.h"

/* steps: the table of pages, the resident part, a page -------------------------------------------------------------------------- */

uint64_t vxs_page_table_bytes(uint32_t page_count)
{
    return VXS_PAGES_PREFIX_BYTES + (uint64_t)page_count * VXS_PAGE_BYTES;
}

int vxs_check_page_table(const uint8_t *table, uint64_t section_bytes, const vxs_resident_sizes *sizes, uint32_t word_count)
{
    uint64_t at = vxs_page_table_bytes(sizes->page_count), words = sizes->word_count;
    if (section_bytes < at || vxs_load32(table) != sizes->page_count || vxs_load32(table + 4) != VXS_PAGE_BYTES) return 502;
    for (uint32_t page = 0; page < sizes->page_count; page++) {
        at += vxs_load32(vxs_page_entry(table, page) + VXS_PAGE_STORED_BYTES);
        words += vxs_load32(vxs_page_entry(table, page) + VXS_PAGE_WORD_COUNT);
    }
    if (at != section_bytes) return 502;
    return words != word_count ? 406 : 0;
}

int vxs_read_resident(vxs_paged_light *light, const vxs_resident_sizes *sizes, const uint8_t *bytes, uint64_t size_bytes,
                      const vxs_page_tools *tools)
{
    vxs_resident_sizes now;
    if (vxs_resident_sizes_of(&now, bytes, size_bytes) != VXS_OK ||
        !(now.word_count == sizes->word_count && now.page_count == sizes->page_count && now.node_count == sizes->node_count &&
          now.pattern_count == sizes->pattern_count))
        return 501;
    vxs_result r = light->packing == VXS_PACKING_FAST
                       ? vxs_resident_unpack(&light->resident, &light->marks, light->levels, light->map_count, bytes, size_bytes,
                                             light->inflated, tools->zstd)
                       : vxs_resident_decode(&light->resident, light->levels, light->map_count, light->packing, bytes, size_bytes,
                                             tools->scratch);
    return r == VXS_OK ? 0 : 501;
}

int vxs_read_page(uint32_t *words, const vxs_page_content *p, const vxs_paged_light *light, const vxs_page_tools *tools)
{
    if (XXH64(p->bytes, p->size_bytes, 0) != p->hash) return 503;
    vxs_result r = VXS_E_CORRUPT;
    if (light->packing == VXS_PACKING_FAST) {
        if (vxs_page_inflate(words, p->word_count, p->bytes, p->size_bytes, tools->zstd) != VXS_OK) return 505;
        tools->marks->common = &light->marks;
        r = vxs_page_check(words, p->word_count, vxs_page_node_words(p->bytes), p->nodes, p->node_count, tools->marks,
                           VXS_PAGE_UNPACK);
    } else if (vxs_page_word_count(p->bytes, p->size_bytes) == p->word_count)
        r = vxs_page_decode(words, p->bytes, p->size_bytes, p->nodes, p->node_count, &light->resident.common, tools->scratch);
    return r == VXS_OK ? 0 : 504;
}

/* all of a light ---------------------------------------------------------------------------------------------------------------- */

enum { SCRATCH_ALIGN = 16 };

int vxs_is_blocks_section(uint32_t kind)
{
    return kind == VXS_KIND_RESIDENT || kind == VXS_KIND_PAGES;
}

/* State of decoding a light. */
typedef struct blocks_reader {
    vxs_reader        *r;
    vxs_baked_light   *baked;
    int                resident_section, pages_section;
    vxs_resident_sizes sizes;
    vxs_paged_light    light;
    uint32_t          *words;                /* [word_count + VXS_BLOCKS_SPARE_WORDS] */
    vxs_page_tools     tools[VXS_TASKS_MAX]; /* zstd of tools[0] belongs to the reader */
    uint8_t           *scratch_memory[VXS_TASKS_MAX];
    uint32_t           task_count; /* tasks that have all their tools */
    uint16_t          *wrong;      /* [page_count] number of the finding; 0: none */
    vxs_items          pages;
} blocks_reader;

/* A page and its place. */
typedef struct page_place {
    uint32_t page, start; /* start: of its words, in the words of the light */
    uint64_t at;          /* of its bytes, in the section */
} page_place;

static const uint8_t *page_entry(const blocks_reader *b, uint32_t page)
{
    return vxs_page_entry(vxs_stored_bytes(b->r, b->pages_section), page);
}

/* Whether the sizes of the resident part and the pages match each other, the sections and the light's record. 0: a finding. */
static int check_sizes(blocks_reader *b)
{
    vxs_reader *r       = b->r;
    uint32_t    light   = (uint32_t)(b->baked - r->out.lights);
    b->resident_section = vxs_find_section(r, VXS_KIND_RESIDENT, light, 0);
    if (b->resident_section < 0) return 0;
    b->pages_section = vxs_find_section(r, VXS_KIND_PAGES, light, 0);
    if (b->pages_section < 0) return 0;
    if (vxs_resident_sizes_of(&b->sizes, vxs_stored_bytes(r, b->resident_section),
                              r->out.sections[b->resident_section].stored_bytes))
        return vxs_found(r, 501, b->resident_section, 0), 0;

    int wrong = vxs_check_page_table(vxs_stored_bytes(r, b->pages_section), r->out.sections[b->pages_section].stored_bytes,
                                     &b->sizes, b->baked->word_count);
    if (wrong) return vxs_found(r, wrong, b->pages_section, 0), 0;
    return 1;
}

static size_t scratch_bytes(void)
{
    return vxs_page_scratch_bytes() + SCRATCH_ALIGN;
}

static int is_fast(const blocks_reader *b)
{
    return b->baked->packing == VXS_PACKING_FAST;
}

/* Nothing can be read without the tools of task 0; other tasks are optional. */
static void *take_tool(blocks_reader *b, uint32_t task, size_t size)
{
    return task ? vxs_reader_try_alloc(b->r, size, 1) : vxs_reader_alloc(b->r, size, 1, b->resident_section);
}

/* 0: no memory for one of the tools. */
static int take_tools(blocks_reader *b, uint32_t task)
{
    vxs_page_tools *t = &b->tools[task];
    if (!is_fast(b)) {
        uint8_t *memory = b->scratch_memory[task] = take_tool(b, task, scratch_bytes());
        if (memory) t->scratch = (vxs_page_scratch *)(memory + SCRATCH_ALIGN - (uintptr_t)memory % SCRATCH_ALIGN);
        return memory != NULL;
    }
    if (!(t->marks = take_tool(b, task, sizeof *t->marks))) return 0;
    return (t->zstd = task ? ZSTD_createDCtx() : b->r->zstd) != NULL;
}

static int take_memory(blocks_reader *b)
{
    vxs_reader               *r       = b->r;
    const vxs_resident_sizes *s       = &b->sizes;
    vxs_resident             *to      = &b->light.resident;
    vxs_common_marks         *marks   = &b->light.marks;
    int                       section = b->resident_section;
    uint32_t                  wanted  = vxs_task_count(r->desc.parallel, s->page_count);
    b->words = vxs_reader_alloc(r, b->baked->word_count + (uint64_t)VXS_BLOCKS_SPARE_WORDS, sizeof *b->words, b->pages_section);
    if (!b->words) return 0;
    b->baked->words = b->words; /* set at once, so that they are freed with the light in any case */
    if (!(to->nodes = vxs_reader_alloc(r, s->node_count, sizeof *to->nodes, section))) return 0;
    if (!(to->page_first = vxs_reader_alloc(r, s->page_count + (uint64_t)1, sizeof *to->page_first, section))) return 0;
    if (is_fast(b)) {
        if (!(marks->at = vxs_reader_alloc(r, vxs_resident_common_halves(s), 1, section))) return 0;
        if (!(b->light.inflated = vxs_reader_alloc(r, vxs_resident_inflated_bytes(s), 1, section))) return 0;
    } else if (!(to->patterns = vxs_reader_alloc(r, s->pattern_count, sizeof *to->patterns, section)))
        return 0;
    if (!(b->wrong = vxs_reader_alloc(r, s->page_count, sizeof *b->wrong, section))) return 0;
    while (b->task_count < wanted && take_tools(b, b->task_count)) b->task_count++;
    to->words = b->words;
    return b->task_count > 0;
}

static page_place first_page(const blocks_reader *b)
{
    return (page_place){0, b->sizes.word_count, vxs_page_table_bytes(b->sizes.page_count)};
}

static void next_page(const blocks_reader *b, page_place *p)
{
    p->at += vxs_load32(page_entry(b, p->page) + VXS_PAGE_STORED_BYTES);
    p->start += vxs_load32(page_entry(b, p->page) + VXS_PAGE_WORD_COUNT);
    p->page++;
}

/* A task: decodes pages that no other task has taken. After an invalid page no further page is taken, unless all findings
 * are wanted; all pages before it are decoded. */
static void decode_some_pages(void *work, uint32_t task)
{
    blocks_reader *b = work;
    page_place     p = first_page(b);
    uint32_t       page;
    while (vxs_items_next(&b->pages, &page)) {
        while (p.page < page) next_page(b, &p);
        const uint8_t   *entry   = page_entry(b, page);
        uint32_t         first   = b->light.resident.page_first[page];
        vxs_page_content content = {.bytes      = vxs_stored_bytes(b->r, b->pages_section) + p.at,
                                    .size_bytes = vxs_load32(entry + VXS_PAGE_STORED_BYTES),
                                    .word_count = vxs_load32(entry + VXS_PAGE_WORD_COUNT),
                                    .node_count = b->light.resident.page_first[page + 1] - first,
                                    .hash       = vxs_load64(entry + VXS_PAGE_HASH),
                                    .nodes      = b->light.resident.nodes + first};
        b->wrong[page]           = (uint16_t)vxs_read_page(b->words + p.start, &content, &b->light, &b->tools[task]);
        if (!b->wrong[page])
            b->words[VXS_BLOCKS_FIRST_PAGE + page] = p.start;
        else if (!b->r->desc.find_all)
            vxs_items_end(&b->pages);
    }
}

static void decode_blocks(blocks_reader *b)
{
    memset(b->words + b->baked->word_count, 0, VXS_BLOCKS_SPARE_WORDS * sizeof *b->words);

    b->light.packing   = b->baked->packing;
    b->light.levels    = b->baked->light.levels;
    b->light.map_count = vxs_map_count(&b->baked->light);
    int wrong          = vxs_read_resident(&b->light, &b->sizes, vxs_stored_bytes(b->r, b->resident_section),
                                           b->r->out.sections[b->resident_section].stored_bytes, &b->tools[0]);

    if (wrong) {
        vxs_found(b->r, wrong, b->resident_section, 0);
        return;
    }

    uint32_t resident = b->sizes.word_count, common = resident - b->words[1], side = 1u << b->baked->light.levels;
    b->baked->parts[0] =
        (vxs_part){"tops", side, vxs_map_count(&b->baked->light), 4 * (uint64_t)(resident - common), (uint32_t)b->resident_section};
    b->baked->parts[1] = (vxs_part){"patterns", 8, b->sizes.pattern_count, 4 * (uint64_t)common, (uint32_t)b->resident_section};
    b->baked->parts[2] =
        (vxs_part){"pages", 0, b->sizes.page_count, 4 * (uint64_t)(b->baked->word_count - resident), (uint32_t)b->pages_section};
    b->baked->part_count = 3;
    if (b->r->is_written && !is_fast(b)) return;

    memset(b->wrong, 0, b->sizes.page_count * sizeof *b->wrong);
    b->pages.count    = b->sizes.page_count;
    b->pages.parallel = b->r->desc.parallel;
    vxs_tasks_run(b->r->desc.parallel, b->task_count, decode_some_pages, b);
    for (page_place p = first_page(b); p.page < b->sizes.page_count; next_page(b, &p)) {
        if (!b->wrong[p.page]) continue;
        vxs_found(b->r, b->wrong[p.page], b->pages_section, p.at);
        if (!b->r->desc.find_all) return;
    }
}

void vxs_read_blocks(vxs_reader *r, vxs_baked_light *baked)
{
    blocks_reader b = {.r = r, .baked = baked};
    if (!check_sizes(&b)) return;
    if (take_memory(&b)) decode_blocks(&b);

    vxs_resident *from = &b.light.resident;
    vxs_reader_free(b.r, from->nodes, b.sizes.node_count, sizeof *from->nodes);
    vxs_reader_free(b.r, from->page_first, b.sizes.page_count + (uint64_t)1, sizeof *from->page_first);
    vxs_reader_free(b.r, from->patterns, b.sizes.pattern_count, sizeof *from->patterns);
    vxs_reader_free(b.r, b.light.marks.at, vxs_resident_common_halves(&b.sizes), 1);
    vxs_reader_free(b.r, b.light.inflated, vxs_resident_inflated_bytes(&b.sizes), 1);
    vxs_reader_free(b.r, b.wrong, b.sizes.page_count, sizeof *b.wrong);
    for (uint32_t n = 0; n < VXS_TASKS_MAX; n++) {
        const vxs_page_tools *t = &b.tools[n];
        vxs_reader_free(b.r, b.scratch_memory[n], scratch_bytes(), 1);
        vxs_reader_free(b.r, t->marks, sizeof *t->marks, 1);
        if (n) ZSTD_freeDCtx(t->zstd);
    }
}
