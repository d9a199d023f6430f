/* Reading a light of palette blocks: every check of formats/vxs.md section 14 on its resident part and its pages, and its words as
 * section 13 has them.
 *
 * What both say of their sizes is added up, and held against the light's record and the limit, before anything is decoded. Decoding is
 * the check of the rest (vxs_page.h). Once the resident part is known, pages are decoded by as many tasks as there are threads, and memory
 * for what each of them needs; what was wrong is told afterwards, in the order of pages.
 * SPDX-License-Identifier: MIT */
#include <string.h>
#include <xxhash.h>

#include "vxs_bytes.h"
#include "vxs_page.h"
#include "vxs_reader.h"
#include "vxs_tasks.h"

enum { SCRATCH_ALIGN = 16, FIRST_PAGE_WORD = 8 };

int vxs_is_blocks_section(uint32_t kind)
{
    return kind == VXS_KIND_RESIDENT || kind == VXS_KIND_PAGES;
}

/* A light while it is decoded. */
typedef struct blocks_reader {
    vxs_reader        *r;
    vxs_baked_light   *baked;
    int                resident_section, pages_section;
    vxs_resident_sizes sizes;
    vxs_resident       resident;
    uint32_t          *words;                         /* [word_count + VXS_BLOCKS_SPARE_WORDS] */
    uint8_t           *scratch_memory[VXS_TASKS_MAX]; /* [task_count] */
    uint32_t           task_count;
    uint16_t          *wrong; /* [page_count] the number of what was found; 0: nothing */
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
    uint8_t *memory = b->scratch_memory[task];
    return (vxs_page_scratch *)(memory + SCRATCH_ALIGN - (uintptr_t)memory % SCRATCH_ALIGN);
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
    if (!(to->patterns = vxs_take(r, s->pattern_count, sizeof *to->patterns, section))) return 0;
    if (!(b->wrong = vxs_take(r, s->page_count, sizeof *b->wrong, section))) return 0;
    if (!(b->scratch_memory[b->task_count++] = vxs_take(r, scratch_bytes(), 1, section))) return 0;
    while (b->task_count < wanted && (b->scratch_memory[b->task_count] = vxs_take_spare(r, scratch_bytes(), 1))) b->task_count++;
    to->words = b->words;
    return 1;
}

static void give_memory_back(blocks_reader *b)
{
    vxs_resident *from = &b->resident;
    vxs_give_back(b->r, from->nodes, b->sizes.node_count, sizeof *from->nodes);
    vxs_give_back(b->r, from->page_first, b->sizes.page_count + (uint64_t)1, sizeof *from->page_first);
    vxs_give_back(b->r, from->patterns, b->sizes.pattern_count, sizeof *from->patterns);
    vxs_give_back(b->r, b->wrong, b->sizes.page_count, sizeof *b->wrong);
    for (uint32_t n = 0; n < b->task_count; n++) vxs_give_back(b->r, b->scratch_memory[n], scratch_bytes(), 1);
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

/* Returns the number of what is wrong with a page; 0: nothing. */
static uint16_t decode_page(const blocks_reader *b, const page_place *p, vxs_page_scratch *scratch)
{
    const uint8_t       *entry = page_entry(b, p->page), *bytes = vxs_stored_bytes(b->r, b->pages_section) + p->at;
    uint32_t             size = vxs_load32(entry + VXS_PAGE_STORED_BYTES), first = b->resident.page_first[p->page];
    const vxs_page_node *nodes = b->resident.nodes + first;
    if (XXH64(bytes, size, 0) != vxs_load64(entry + VXS_PAGE_HASH)) return 503;
    if (vxs_page_word_count(bytes, size) != vxs_load32(entry + VXS_PAGE_WORD_COUNT) ||
        vxs_page_decode(b->words + p->start, bytes, size, nodes, b->resident.page_first[p->page + 1] - first, &b->resident.common,
                        scratch))
        return 504;
    b->words[FIRST_PAGE_WORD + p->page] = p->start;
    return 0;
}

/* A task: pages that no other has taken. Behind one that is wrong none is wanted, but where everything is; all before it are taken. */
static void decode_some_pages(void *work, uint32_t task)
{
    blocks_reader    *b       = work;
    vxs_page_scratch *scratch = scratch_of(b, task);
    page_place        p       = first_page(b);
    uint32_t          page;
    if (task) vxs_page_scratch_init(scratch); /* the first has decoded the resident part */
    while (vxs_items_take(&b->pages, &page)) {
        while (p.page < page) next_page(b, &p);
        b->wrong[page] = decode_page(b, &p, scratch);
        if (b->wrong[page] && !b->r->desc.find_all) vxs_items_end(&b->pages);
    }
}

static void decode_pages(blocks_reader *b)
{
    memset(b->wrong, 0, b->sizes.page_count * sizeof *b->wrong);
    b->pages.count = b->sizes.page_count;
    vxs_tasks_run(b->r->desc.parallel, b->task_count, decode_some_pages, b);
    for (page_place p = first_page(b); p.page < b->sizes.page_count; next_page(b, &p)) {
        if (!b->wrong[p.page]) continue;
        vxs_found(b->r, b->wrong[p.page], b->pages_section, p.at);
        if (!b->r->desc.find_all) return;
    }
}

static void list_parts(blocks_reader *b)
{
    uint32_t resident = b->sizes.word_count, common = (b->resident.common.half_count + 1) / 2, side = 1u << b->baked->light.levels;
    b->baked->parts[0] = (vxs_part){"tops", side, vxs_light_map_count(&b->baked->light), 4 * (uint64_t)(resident - common),
                                    (uint32_t)b->resident_section};
    b->baked->parts[1] = (vxs_part){"patterns", 8, b->sizes.pattern_count, 4 * (uint64_t)common, (uint32_t)b->resident_section};
    b->baked->parts[2] =
        (vxs_part){"pages", 0, b->sizes.page_count, 4 * (uint64_t)(b->baked->word_count - resident), (uint32_t)b->pages_section};
    b->baked->part_count = 3;
}

static void decode_light(blocks_reader *b)
{
    const vxs_light *light = &b->baked->light;
    const uint8_t   *bytes = vxs_stored_bytes(b->r, b->resident_section);
    uint64_t         size  = b->r->out.sections[b->resident_section].stored_bytes;
    memset(b->words + b->baked->word_count, 0, VXS_BLOCKS_SPARE_WORDS * sizeof *b->words);
    vxs_page_scratch_init(scratch_of(b, 0));
    if (vxs_resident_decode(&b->resident, light->levels, vxs_light_map_count(light), bytes, size, scratch_of(b, 0))) {
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
