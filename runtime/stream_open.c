/* Opening a stream: from a file to one block of memory.
 *
 * First stream_plan.c reads what determines sizes: header, directory, table of lights, the first bytes of the resident part of
 * each light of palette blocks, and smoke. Then the block is allocated, laid out, and filled light by light. Temporary data of
 * this is in the room for pages, so that nothing else is allocated.
 * SPDX-License-Identifier: MIT */
#include <float.h>
#include <stddef.h>
#include <string.h>

#include "stream_opening.h"
#include "vxs_bytes.h"
#include "vxs_desc.h"
#include "vxs_resident_layout.h"

enum { BLOCK_ALIGN = 64 };

/* the block ------------------------------------------------------------------------------------------------------------------- */

/* Layout of the block; with block NULL, only its size is computed. */
typedef struct layout {
    uint8_t *block;
    uint64_t used;
} layout;

static void *lay(layout *l, uint64_t count, size_t size)
{
    uint64_t at = (l->used + BLOCK_ALIGN - 1) / BLOCK_ALIGN * BLOCK_ALIGN;
    l->used     = at + count * size;
    return l->block ? l->block + at : NULL;
}

/* Lay out everything except words and what lay_out_packings adds. */
static void lay_out(const opening *o, layout *l, vxs_stream *s)
{
    s->baked    = lay(l, o->light_count, sizeof *s->baked);
    s->lights   = lay(l, o->light_count, sizeof *s->lights);
    s->pages    = lay(l, o->page_count, sizeof *s->pages);
    s->in_room  = lay(l, o->page_count, sizeof *s->in_room);
    s->heap     = lay(l, o->page_count, sizeof *s->heap);
    s->changes  = lay(l, o->page_count + 4 * (uint64_t)o->request_count, sizeof *s->changes);
    s->requests = lay(l, o->request_count, sizeof *s->requests);
    s->tools    = lay(l, o->tool_count, sizeof *s->tools);
}

/* Lay out what depends on the packing of lights. */
static void lay_out_packings(const opening *o, layout *l, vxs_stream *s)
{
    for (uint32_t n = 0; n < o->light_count; n++) {
        const light_plan *plan = &o->lights[n];
        int               fast = o->r.out.lights[plan->number].packing == VXS_PACKING_FAST;
        void *to = fast ? lay(l, vxs_resident_common_halves(&plan->sizes), 1) : lay(l, plan->sizes.pattern_count, sizeof(uint32_t));
        if (!l->block) continue;
        if (fast)
            s->lights[n].paged.marks.at = to;
        else
            s->lights[n].paged.resident.patterns = to;
    }
    for (uint32_t n = 0; n < o->tool_count; n++) {
        vxs_page_scratch *scratch = o->small ? lay(l, 1, vxs_page_scratch_bytes()) : NULL;
        vxs_page_marks   *marks   = o->fast ? lay(l, 1, sizeof *marks) : NULL;
        if (l->block) s->tools[n].decode = (vxs_page_tools){scratch, marks, NULL};
    }
}

/* Allocate the block: the required data, and as much room for pages as the budget leaves, at most that for all pages. */
static int take_block(opening *o)
{
    vxs_stream none;
    layout     l = {NULL, 0};
    lay(&l, 1, sizeof none);
    lay_out(o, &l, &none);
    lay_out_packings(o, &l, &none);
    lay(&l, 0, 1);
    uint64_t tail =
        o->tool_count * (o->node_count * sizeof(vxs_page_node) + BLOCK_ALIGN) + o->request_count * (o->buffer_bytes + BLOCK_ALIGN);
    uint64_t least = sum_or_max(l.used + 4 * o->resident_words, o->work_bytes);
    uint64_t most  = sum_or_max(l.used + 4 * o->all_words, tail + BLOCK_ALIGN);
    if (most < least) most = least + BLOCK_ALIGN;
    if (most > 4 * (uint64_t)UINT32_MAX) most = 4 * (uint64_t)UINT32_MAX; /* word indices have 32 bits */
    uint64_t size = (most < o->r.memory_left ? most : o->r.memory_left) / BLOCK_ALIGN * BLOCK_ALIGN;
    if (size < least) return vxs_found(&o->r, 211, -1, 0), 0;
    uint8_t *block = vxs_reader_alloc(&o->r, size, 1, -1);
    if (!block) return 0;

    l     = (layout){block, 0};
    o->s  = lay(&l, 1, sizeof *o->s);
    *o->s = (vxs_stream){.desc = *o->desc, .allocator = o->allocator, .block_bytes = size};
    lay_out(o, &l, o->s);
    memset(block + sizeof *o->s, 0, l.used - sizeof *o->s);
    lay_out_packings(o, &l, o->s);
    o->s->words         = lay(&l, 0, 1);
    o->s->room_end      = (uint32_t)((size - l.used) / 4);
    o->s->light_count   = o->light_count;
    o->s->page_count    = o->page_count;
    o->s->tool_count    = o->tool_count;
    o->s->request_count = o->request_count;
    o->s->room_first    = (uint32_t)o->resident_words;
    return 1;
}

/* Bump allocator in the room for pages, for temporary data. */
static void *take_work(size_t size_bytes, void *user)
{
    opening *o    = user;
    size_t   size = (size_bytes + 15) / 16 * 16;
    if (size_bytes > SIZE_MAX - 15 || size > (size_t)(o->work_end - o->work)) return NULL;
    o->work += size;
    return o->work - size;
}

static void free_work(void *memory, size_t size_bytes, void *user)
{
    (void)memory;
    (void)size_bytes;
    (void)user;
}

/* filling the block ----------------------------------------------------------------------------------------------------------- */

/* Fill the page data of a light from its page table, and find the first node of each page. */
static int fill_pages(opening *o, stream_light *light, const light_plan *plan)
{
    vxs_reader        *r       = &o->r;
    const vxs_section *section = &r->out.sections[plan->pages_section];
    uint64_t           bytes   = vxs_page_table_bytes(plan->sizes.page_count);
    if (bytes > section->stored_bytes) return vxs_found(r, 502, plan->pages_section, 0), 0;
    uint8_t *table = vxs_reader_alloc(r, bytes, 1, plan->pages_section);
    if (!table || !vxs_stream_read(o, section->offset_bytes, bytes, table)) return 0;
    int wrong = vxs_check_page_table(table, section->stored_bytes, &plan->sizes, r->out.lights[plan->number].word_count);
    if (wrong) return vxs_found(r, wrong, plan->pages_section, 0), 0;

    uint64_t            at       = section->offset_bytes + bytes;
    const vxs_resident *resident = &light->paged.resident;
    uint32_t            side     = squares_of(light->paged.levels);
    for (uint32_t n = 0; n < plan->sizes.page_count; n++) {
        const uint8_t       *entry = vxs_page_entry(table, n);
        const vxs_page_node *first = &resident->nodes[resident->page_first[n]];
        stream_page         *page  = &o->s->pages[light->first_page + n];
        uint32_t             z     = 0; /* the bits of x and y in turn */
        for (uint32_t b = 0; b < 16; b++) z |= (first->x >> b & 1) << 2 * b | (first->y >> b & 1) << (2 * b + 1);
        *page = (stream_page){.offset_bytes = at,
                              .hash         = vxs_load64(entry + VXS_PAGE_HASH),
                              .stored_bytes = vxs_load32(entry + VXS_PAGE_STORED_BYTES),
                              .word_count   = vxs_load32(entry + VXS_PAGE_WORD_COUNT),
                              .light        = (uint32_t)(light - o->s->lights),
                              .first_square = first->map * side * side + z,
                              .node_count   = resident->page_first[n + 1] - resident->page_first[n],
                              .min          = {FLT_MAX, FLT_MAX, FLT_MAX},
                              .max          = {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
        at += page->stored_bytes;
        if (page->node_count > o->s->nodes_max) o->s->nodes_max = page->node_count;
        if (page->stored_bytes > o->s->buffer_bytes) o->s->buffer_bytes = page->stored_bytes;
    }
    return 1;
}

static int fill_blocks(opening *o, stream_light *light, const light_plan *plan)
{
    vxs_reader               *r       = &o->r;
    const vxs_baked_light    *baked   = &r->out.lights[plan->number];
    const vxs_resident_sizes *sizes   = &plan->sizes;
    vxs_paged_light          *paged   = &light->paged;
    int                       section = plan->resident_section;
    paged->packing                    = baked->packing;
    paged->levels                     = baked->light.levels;
    paged->map_count                  = vxs_map_count(&baked->light);
    paged->resident.words             = o->s->words + light->first_word;
    const uint8_t *bytes              = vxs_stream_load(r, section);
    if (!bytes) return 0;
    if (!(paged->resident.nodes = vxs_reader_alloc(r, sizes->node_count, sizeof *paged->resident.nodes, section))) return 0;
    if (!(paged->resident.page_first = vxs_reader_alloc(r, sizes->page_count + (uint64_t)1, 4, section))) return 0;
    if (paged->packing == VXS_PACKING_FAST &&
        !(paged->inflated = vxs_reader_alloc(r, vxs_resident_inflated_bytes(sizes), 1, section)))
        return 0;
    int wrong = vxs_read_resident(paged, sizes, bytes, r->out.sections[section].stored_bytes, &o->s->tools[0].decode);
    if (wrong) return vxs_found(r, wrong, section, 0), 0;
    if (!fill_pages(o, light, plan)) return 0;

    /* Compute the volumes of pages from all squares that have a node in them; several squares may share a node. */
    vxs_stream     *s     = o->s;
    const uint32_t *words = light->paged.resident.words;
    uint32_t        side  = squares_of(baked->light.levels);
    for (uint32_t map = 0; map < light->paged.map_count; map++)
        for (uint32_t y = 0; y < side; y++)
            for (uint32_t x = 0; x < side; x++) {
                uint32_t at = top_at(words, words[2 + map], baked->light.levels, x, y), name = words[at];
                if (name < top_uniform)
                    vxs_stream_page_add_square(&s->pages[light->first_page + (name >> 16)], &baked->light, map, x, y,
                                               words[at + 1]);
            }

    paged->resident.nodes      = NULL;
    paged->resident.page_first = NULL;
    paged->inflated            = NULL;
    return 1;
}

/* Start to use the whole room for pages for temporary data. */
static void begin_work(opening *o)
{
    o->work          = (uint8_t *)(o->s->words + o->s->room_first);
    o->work_end      = (uint8_t *)(o->s->words + o->s->room_end);
    o->r.memory_left = (uint64_t)(o->work_end - o->work);
    o->loaded        = NULL;
}

static int fill_light(opening *o, uint32_t n)
{
    vxs_stream       *s     = o->s;
    const light_plan *plan  = &o->lights[n];
    stream_light     *light = &s->lights[n];
    vxs_baked_light  *baked = &o->r.out.lights[plan->number];
    begin_work(o);
    light->first_word = n ? s->lights[n - 1].first_word + o->lights[n - 1].word_count : 0;
    light->first_page = n ? s->lights[n - 1].first_page + s->lights[n - 1].page_count : 0;
    light->page_count = plan->sizes.page_count;
    if (baked->light.coding == VXS_CODING_BLOCKS) {
        if (!fill_blocks(o, light, plan)) return 0;
    } else {
        baked->words = s->words + light->first_word;
        vxs_read_dag(&o->r, baked);
        baked->words = NULL;
        if (o->r.result != VXS_OK) return 0;
    }
    s->baked[n]            = *baked;
    s->baked[n].words      = s->words + light->first_word;
    s->baked[n].word_count = plan->word_count;
    s->baked[n].part_count = 0;
    return 1;
}

/* Read the smoke of each light that has some, behind the words of all lights. */
static int fill_smoke(opening *o)
{
    vxs_stream *s  = o->s;
    uint32_t   *at = s->words + s->lights[s->light_count - 1].first_word + o->lights[s->light_count - 1].word_count;
    for (uint32_t n = 0; n < s->light_count; n++) {
        const vxs_baked_smoke *measured = &o->lights[n].smoke;
        if (!measured->word_count) continue;
        begin_work(o);
        vxs_read_smoke_words(&o->r, measured, at);
        if (o->r.result != VXS_OK) return 0;
        s->lights[n].smoke       = *measured;
        s->lights[n].smoke.words = at;
        at += measured->word_count;
    }
    return 1;
}

/* Place the nodes of tools and the buffers of requests, whose sizes are now known, at the end of the room. */
static int take_tail(opening *o)
{
    vxs_stream *s     = o->s;
    uint64_t    nodes = (s->nodes_max * sizeof(vxs_page_node) + BLOCK_ALIGN - 1) / BLOCK_ALIGN * BLOCK_ALIGN;
    uint64_t    room  = 4 * (uint64_t)(s->room_end - s->room_first);
    if (s->buffer_bytes > STORED_MAX) s->buffer_bytes = STORED_MAX;
    uint64_t buffer = s->source.bytes ? 0 : (s->buffer_bytes + BLOCK_ALIGN - 1) / BLOCK_ALIGN * BLOCK_ALIGN;
    uint64_t tail   = s->tool_count * nodes + s->request_count * buffer;
    if (tail > room) return vxs_found(&o->r, 211, -1, 0), 0;
    s->room_end = s->room_first + (uint32_t)((room - tail) / 4 / ROOM_ALIGN * ROOM_ALIGN);
    uint8_t *at = (uint8_t *)(s->words + s->room_end);
    for (uint32_t n = 0; n < s->tool_count; n++, at += nodes) s->tools[n].nodes = (vxs_page_node *)at;
    for (uint32_t n = 0; n < s->request_count; n++, at += buffer)
        s->requests[n] = (vxs_stream_request){.stream = s, .buffer = buffer ? at : NULL};
    s->word_count = s->room_end;
    memset(s->words + s->room_first, 0, 4 * (size_t)(s->room_end - s->room_first));
    return 1;
}

/* Pass metadata and points to the caller. They are valid during the calls, and count towards the budget during them. */
static int pass_extras(opening *o)
{
    vxs_contents     *c = &o->r.out;
    vxs_baked_points *p = &o->r.points;
    if (o->desc->metadata) {
        o->r.desc.metadata = 1;
        if (!vxs_read_metadata(&o->r)) return 0;
        if (c->metadata) o->desc->metadata(o->desc->metadata_user, c->metadata, c->metadata_bytes);
        vxs_reader_free(&o->r, c->metadata, (uint64_t)c->metadata_bytes + 1, 1);
        c->metadata = NULL;
    }
    if (o->desc->points) {
        vxs_read_points(&o->r);
        if (o->r.result == VXS_OK && p->coordinates) o->desc->points(o->desc->points_user, p);
        vxs_reader_free(&o->r, (void *)p->coordinates, p->count, 3 * sizeof *p->coordinates);
    }
    return o->r.result == VXS_OK;
}

static int fill_block(opening *o)
{
    vxs_allocator real = o->r.allocator;
    uint64_t      left = o->r.memory_left;
    int           good = 1;
    o->s->source       = o->source;
    o->r.allocator     = (vxs_allocator){take_work, free_work, o};
    for (uint32_t n = 0; n < o->light_count && good; n++) good = fill_light(o, n);
    good             = good && fill_smoke(o);
    o->loaded        = NULL;
    o->r.allocator   = real;
    o->r.memory_left = left;
    return good && take_tail(o);
}

/* open and close -------------------------------------------------------------------------------------------------------------- */

static int open_all(opening *o)
{
    if (!vxs_stream_read_head(o)) return 0;
    if (!(o->r.zstd = ZSTD_createDCtx())) return o->r.result = VXS_E_MEMORY, 0;
    if (!vxs_read_light_table(&o->r) || !pass_extras(o)) return 0;
    vxs_stream_forget_loaded(o);
    if (!vxs_stream_plan(o) || !take_block(o)) return 0;
    for (uint32_t n = 0; n < o->tool_count; n++) {
        stream_tools *t = &o->s->tools[n];
        t->stream       = o->s;
        if (o->fast && !(t->decode.zstd = ZSTD_createDCtx())) return o->r.result = VXS_E_MEMORY, 0;
    }
    if (!fill_block(o)) return 0;
    return vxs_stream_work_start(o->s) || (o->r.result = VXS_E_MEMORY, 0);
}

void vxs_stream_close(vxs_stream *s)
{
    if (!s) return;
    vxs_stream_work_end(s);
    for (uint32_t n = 0; n < s->tool_count; n++) ZSTD_freeDCtx(s->tools[n].decode.zstd);
    vxs_stream_source_close(&s->source);
    s->allocator.free(s, s->block_bytes, s->allocator.user);
}

vxs_result vxs_stream_open(vxs_stream **stream, const vxs_stream_desc *desc)
{
    *stream                = NULL;
    vxs_stream_desc known  = {0};
    const size_t    first  = offsetof(vxs_stream_desc, failed_user) + sizeof known.failed_user;
    vxs_result      result = vxs_desc_take(&known, sizeof known, first, desc);
    if (result != VXS_OK) return result;
    if (!(known.threads <= VXS_STREAM_THREADS_MAX && known.requests <= VXS_STREAM_REQUESTS_MAX &&
          (!known.bytes || known.size_bytes <= SIZE_MAX)))
        return VXS_E_ARGUMENT;
    desc      = &known;
    opening o = {.desc = desc};
    if ((result = vxs_stream_source_open(&o.source, desc)) != VXS_OK) return result;

    const vxs_read_desc read = {.allocator = desc->allocator, .finding = desc->finding, .finding_user = desc->finding_user};
    o.allocator              = vxs_allocator_of(&read);
    o.r                      = (vxs_reader){
                             .desc = read, .allocator = o.allocator, .memory_left = desc->budget_bytes, .load = vxs_stream_load, .load_user = &o};
    o.r.out.allocator = o.allocator;
    int good          = open_all(&o);

    vxs_stream_forget_loaded(&o);
    vxs_reader_free(&o.r, o.lights, o.light_count, sizeof *o.lights);
    ZSTD_freeDCtx(o.r.zstd);
    vxs_contents_free(&o.r.out);
    if (good) {
        o.s->source.bytes_read = o.source.bytes_read;
        *stream                = o.s;
        return VXS_OK;
    }
    if (o.s) {
        o.s->source = o.source;
        vxs_stream_close(o.s);
    } else
        vxs_stream_source_close(&o.source);
    return o.r.result != VXS_OK ? o.r.result : VXS_E_MEMORY;
}
