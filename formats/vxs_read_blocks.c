/* Reading a light of palette blocks: every check of formats/vxs.md section 14 on its resident part and its pages, and its words as
 * section 13 has them.
 *
 * What both say of their sizes is added up, and held against the light's record and the limit, before anything is decoded. Decoding is
 * the check of the rest (vxs_page.h), but for pages that are packed fast, which are checked as words (vxs_page_fast.h). Once the resident part is known, pages are decoded by as many tasks as there are threads, and memory
 * for what each of them needs; what was wrong is told afterwards, in the order of pages.
 * SPDX-License-Identifier: MIT */
#include <string.h>
#include <xxhash.h>

#include "vxs_bytes.h"
#include "vxs_page_fast.h"
#include "vxs_reader.h"
#include "vxs_tasks.h"

enum { SCRATCH_ALIGN = 16, FIRST_PAGE_WORD = 8 };

int vxs_is_blocks_section(uint32_t kind)
{
    return kind == VXS_KIND_RESIDENT || kind == VXS_KIND_PAGES;
}

/* What a task opens pages by: small ones by the first, fast ones by the others. */
typedef struct page_tools {
    uint8_t        *scratch_memory;
    vxs_page_marks *marks;
    ZSTD_DCtx      *zstd; /* of the first task, the reader's */
} page_tools;

/* A light while it is decoded. */
typedef struct blocks_reader {
    vxs_reader        *r;
    vxs_baked_light   *baked;
    int                resident_section, pages_section;
    vxs_resident_sizes sizes;
    vxs_resident       resident;
    vxs_common_marks  *common; /* of a light that is fast, as the next; others have the patterns of the resident part */
    uint8_t           *inflated;
    uint32_t          *words; /* [word_count + VXS_BLOCKS_SPARE_WORDS] */
    page_tools         tools[VXS_TASKS_MAX];
    uint32_t           task_count; /* that have all their tools */
    uint16_t          *wrong;      /* [page_count] the number of what was found; 0: nothing */
    vxs_items          pages;
} blocks_reader;

/* A page, and where it is. */
typedef struct page_place {
    uint32_t page, start; /* start: of its words, among the light's */
    uint64_t at;          /* its bytes, in the section */
} page_place;

static const uint8_t *page_entry(const blocks_reader *b, uint32_t page)
{
    return vxs_stored_bytes(b->r, b->pages_section) + VXS_PAGES_PREFIX_BYTES + (size_t)page * VXS_PAGE_BYTES;
}

/* What the resident part and the pages are to take: whether their sizes fit each other, the sections and the light's record. */
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

    uint32_t count = b->sizes.page_count;
    uint64_t size = r->out.sections[b->pages_section].stored_bytes, at = VXS_PAGES_PREFIX_BYTES + (uint64_t)count * VXS_PAGE_BYTES;
    uint64_t words       = b->sizes.word_count;
    const uint8_t *table = vxs_stored_bytes(r, b->pages_section);
    if (size < at || vxs_load32(table) != count || vxs_load32(table + 4) != VXS_PAGE_BYTES)
        return vxs_found(r, 502, b->pages_section, 0), 0;
    for (uint32_t page = 0; page < count; page++) {
        at += vxs_load32(page_entry(b, page) + VXS_PAGE_STORED_BYTES);
        words += vxs_load32(page_entry(b, page) + VXS_PAGE_WORD_COUNT);
    }
    if (at != size) return vxs_found(r, 502, b->pages_section, 0), 0;
    if (words != b->baked->word_count) return vxs_found(r, 406, b->pages_section, 0), 0;
    return 1;
}

static size_t scratch_bytes(void)
{
    return vxs_page_scratch_bytes() + SCRATCH_ALIGN;
}

static vxs_page_scratch *scratch_of(const blocks_reader *b, uint32_t task)
{
    uint8_t *memory = b->tools[task].scratch_memory;
    return (vxs_page_scratch *)(memory + SCRATCH_ALIGN - (uintptr_t)memory % SCRATCH_ALIGN);
}

static int is_fast(const blocks_reader *b)
{
    return b->baked->packing == VXS_PACKING_FAST;
}

/* Without the first task's tools nothing is read; others only make it quicker. */
static void *take_tool(blocks_reader *b, uint32_t task, size_t size)
{
    return task ? vxs_take_spare(b->r, size, 1) : vxs_take(b->r, size, 1, b->resident_section);
}

/* 0: there is no memory for one of them. */
static int take_tools(blocks_reader *b, uint32_t task)
{
    page_tools *t = &b->tools[task];
    if (!is_fast(b)) return (t->scratch_memory = take_tool(b, task, scratch_bytes())) != NULL;
    if (!(t->marks = take_tool(b, task, sizeof *t->marks))) return 0;
    return (t->zstd = task ? ZSTD_createDCtx() : b->r->zstd) != NULL;
}

static void give_tools_back(blocks_reader *b, uint32_t task)
{
    page_tools *t = &b->tools[task];
    vxs_give_back(b->r, t->scratch_memory, scratch_bytes(), 1);
    vxs_give_back(b->r, t->marks, sizeof *t->marks, 1);
    if (task) ZSTD_freeDCtx(t->zstd);
}

static int take_memory(blocks_reader *b)
{
    vxs_reader               *r       = b->r;
    const vxs_resident_sizes *s       = &b->sizes;
    vxs_resident             *to      = &b->resident;
    int                       section = b->resident_section;
    uint32_t                  wanted  = vxs_task_count(r->desc.parallel, s->page_count);
    b->words = vxs_take(r, b->baked->word_count + (uint64_t)VXS_BLOCKS_SPARE_WORDS, sizeof *b->words, b->pages_section);
    if (!b->words) return 0;
    b->baked->words = b->words; /* given back with the light, whatever happens */
    if (!(to->nodes = vxs_take(r, s->node_count, sizeof *to->nodes, section))) return 0;
    if (!(to->page_first = vxs_take(r, s->page_count + (uint64_t)1, sizeof *to->page_first, section))) return 0;
    if (is_fast(b)) {
        if (!(b->common = vxs_take(r, 1, sizeof *b->common, section))) return 0;
        if (!(b->inflated = vxs_take(r, vxs_resident_inflated_bytes(s), 1, section))) return 0;
    } else if (!(to->patterns = vxs_take(r, s->pattern_count, sizeof *to->patterns, section)))
        return 0;
    if (!(b->wrong = vxs_take(r, s->page_count, sizeof *b->wrong, section))) return 0;
    while (b->task_count < wanted && take_tools(b, b->task_count)) b->task_count++;
    to->words = b->words;
    return b->task_count > 0;
}

static void give_memory_back(blocks_reader *b)
{
    vxs_resident *from = &b->resident;
    vxs_give_back(b->r, from->nodes, b->sizes.node_count, sizeof *from->nodes);
    vxs_give_back(b->r, from->page_first, b->sizes.page_count + (uint64_t)1, sizeof *from->page_first);
    vxs_give_back(b->r, from->patterns, b->sizes.pattern_count, sizeof *from->patterns);
    vxs_give_back(b->r, b->common, 1, sizeof *b->common);
    vxs_give_back(b->r, b->inflated, vxs_resident_inflated_bytes(&b->sizes), 1);
    vxs_give_back(b->r, b->wrong, b->sizes.page_count, sizeof *b->wrong);
    for (uint32_t n = 0; n < VXS_TASKS_MAX; n++) give_tools_back(b, n);
}

static page_place first_page(const blocks_reader *b)
{
    return (page_place){0, b->sizes.word_count, VXS_PAGES_PREFIX_BYTES + (uint64_t)b->sizes.page_count * VXS_PAGE_BYTES};
}

static void next_page(const blocks_reader *b, page_place *p)
{
    p->at += vxs_load32(page_entry(b, p->page) + VXS_PAGE_STORED_BYTES);
    p->start += vxs_load32(page_entry(b, p->page) + VXS_PAGE_WORD_COUNT);
    p->page++;
}

/* A page's bytes, and what its words are to be. */
typedef struct page_content {
    const uint8_t       *bytes;
    uint32_t             size_bytes, word_count, node_count;
    const vxs_page_node *nodes;
} page_content;

static page_content content_of(const blocks_reader *b, const page_place *p)
{
    const uint8_t *entry = page_entry(b, p->page);
    uint32_t       first = b->resident.page_first[p->page];
    return (page_content){.bytes      = vxs_stored_bytes(b->r, b->pages_section) + p->at,
                          .size_bytes = vxs_load32(entry + VXS_PAGE_STORED_BYTES),
                          .word_count = vxs_load32(entry + VXS_PAGE_WORD_COUNT),
                          .node_count = b->resident.page_first[p->page + 1] - first,
                          .nodes      = b->resident.nodes + first};
}

/* These return the number of what is wrong with a page; 0: nothing. */
static uint16_t decode_small(const blocks_reader *b, const page_content *c, uint32_t *words, uint32_t task)
{
    if (vxs_page_word_count(c->bytes, c->size_bytes) != c->word_count) return 504;
    return vxs_page_decode(words, c->bytes, c->size_bytes, c->nodes, c->node_count, &b->resident.common, scratch_of(b, task)) ? 504
                                                                                                                              : 0;
}

static uint16_t decode_fast(const blocks_reader *b, const page_content *c, uint32_t *words, uint32_t task)
{
    const page_tools *t = &b->tools[task];
    if (vxs_page_inflate(words, c->word_count, c->bytes, c->size_bytes, t->zstd)) return 505;
    return vxs_page_check(words, c->word_count, vxs_page_node_words(c->bytes), c->nodes, c->node_count, t->marks, VXS_PAGE_UNPACK)
               ? 504
               : 0;
}

static uint16_t decode_page(const blocks_reader *b, const page_place *p, uint32_t task)
{
    page_content c = content_of(b, p);
    if (XXH64(c.bytes, c.size_bytes, 0) != vxs_load64(page_entry(b, p->page) + VXS_PAGE_HASH)) return 503;
    uint32_t *words = b->words + p->start;
    uint16_t  wrong = is_fast(b) ? decode_fast(b, &c, words, task) : decode_small(b, &c, words, task);
    if (!wrong) b->words[FIRST_PAGE_WORD + p->page] = p->start;
    return wrong;
}

/* What the resident part says is known to all tasks, and the first has decoded it. */
static void ready_tools(blocks_reader *b, uint32_t task)
{
    if (is_fast(b))
        b->tools[task].marks->common = b->common;
    else if (task)
        vxs_page_scratch_init(scratch_of(b, task));
}

/* A task: pages that no other has taken. Behind one that is wrong none is wanted, but where everything is; all before it are taken. */
static void decode_some_pages(void *work, uint32_t task)
{
    blocks_reader *b = work;
    page_place     p = first_page(b);
    uint32_t       page;
    ready_tools(b, task);
    while (vxs_items_take(&b->pages, &page)) {
        while (p.page < page) next_page(b, &p);
        b->wrong[page] = decode_page(b, &p, task);
        if (b->wrong[page] && !b->r->desc.find_all) vxs_items_end(&b->pages);
    }
}

static void decode_pages(blocks_reader *b)
{
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

static void list_parts(blocks_reader *b)
{
    uint32_t resident = b->sizes.word_count, common = resident - b->words[1], side = 1u << b->baked->light.levels;
    b->baked->parts[0] = (vxs_part){"tops", side, vxs_light_map_count(&b->baked->light), 4 * (uint64_t)(resident - common),
                                    (uint32_t)b->resident_section};
    b->baked->parts[1] = (vxs_part){"patterns", 8, b->sizes.pattern_count, 4 * (uint64_t)common, (uint32_t)b->resident_section};
    b->baked->parts[2] =
        (vxs_part){"pages", 0, b->sizes.page_count, 4 * (uint64_t)(b->baked->word_count - resident), (uint32_t)b->pages_section};
    b->baked->part_count = 3;
}

static vxs_result decode_resident(blocks_reader *b)
{
    const vxs_light *light = &b->baked->light;
    uint32_t         maps  = vxs_light_map_count(light);
    const uint8_t   *bytes = vxs_stored_bytes(b->r, b->resident_section);
    uint64_t         size  = b->r->out.sections[b->resident_section].stored_bytes;
    if (is_fast(b)) return vxs_resident_unpack(&b->resident, b->common, light->levels, maps, bytes, size, b->inflated, b->r->zstd);
    vxs_page_scratch_init(scratch_of(b, 0));
    return vxs_resident_decode(&b->resident, light->levels, maps, bytes, size, scratch_of(b, 0));
}

static void decode_light(blocks_reader *b)
{
    memset(b->words + b->baked->word_count, 0, VXS_BLOCKS_SPARE_WORDS * sizeof *b->words);
    if (decode_resident(b) != VXS_OK) {
        vxs_found(b->r, 501, b->resident_section, 0);
        return;
    }
    list_parts(b);
    decode_pages(b);
}

void vxs_read_blocks(vxs_reader *r, vxs_baked_light *baked)
{
    blocks_reader b = {.r = r, .baked = baked};
    if (!check_sizes(&b)) return;
    if (take_memory(&b)) decode_light(&b);
    give_memory_back(&b);
}
