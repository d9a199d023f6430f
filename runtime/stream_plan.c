/* Sizes of a stream to be opened: header, directory, and the size of each wanted light.
 * SPDX-License-Identifier: MIT */
#include <string.h>
#include <xxhash.h>

#include "stream_opening.h"
#include "vxs_bytes.h"
#include "vxs_resident_layout.h"

enum { NODE_WORDS_MIN = 6 };

/* bytes ----------------------------------------------------------------------------------------------------------------------- */

int vxs_stream_read(opening *o, uint64_t offset, uint64_t size_bytes, void *to)
{
    if (size_bytes <= UINT32_MAX && vxs_stream_source_read(&o->source, offset, (uint32_t)size_bytes, to, NULL) == VXS_STREAM_READ) {
        o->source.bytes_read += size_bytes;
        return 1;
    }
    if (o->r.result == VXS_OK) o->r.result = VXS_E_READ;
    return 0;
}

void vxs_stream_forget_loaded(opening *o)
{
    vxs_reader_free(&o->r, o->loaded, o->loaded_bytes, 1);
    o->loaded = NULL;
}

const uint8_t *vxs_stream_load(vxs_reader *r, int section)
{
    opening           *o = r->load_user;
    const vxs_section *s = &r->out.sections[section];
    vxs_stream_forget_loaded(o);
    o->loaded_bytes = s->stored_bytes;
    o->loaded       = vxs_reader_alloc(r, s->stored_bytes, 1, section);
    if (!o->loaded || !vxs_stream_read(o, s->offset_bytes, s->stored_bytes, o->loaded)) return NULL;
    if (XXH64(o->loaded, s->stored_bytes, 0) == s->hash) return o->loaded;
    vxs_found(r, 206, section, s->offset_bytes);
    return NULL;
}

/* Read header and directory. The header gives the length of the directory, which is limited to VXS_SECTIONS_MAX entries and the
 * file size. */
int vxs_stream_read_head(opening *o)
{
    uint8_t  header[VXS_HEADER_BYTES] = {0}, *head;
    uint64_t size = o->source.size_bytes, first = size < sizeof header ? size : sizeof header;
    if (!vxs_stream_read(o, 0, first, header)) return 0;
    uint32_t count = vxs_load32(header + VXS_HEADER_SECTION_COUNT);
    uint64_t all   = VXS_HEADER_BYTES + (uint64_t)(count < VXS_SECTIONS_MAX ? count : VXS_SECTIONS_MAX) * VXS_ENTRY_BYTES;
    if (all > size) all = first;
    if (!(head = vxs_reader_alloc(&o->r, all, 1, -1))) return 0;
    memcpy(head, header, first);
    o->r.bytes = head;
    o->r.size  = size;
    int good   = vxs_stream_read(o, first, all - first, head + first) && vxs_read_head(&o->r);
    vxs_reader_free(&o->r, head, all, 1);
    return good;
}

/* wanted lights --------------------------------------------------------------------------------------------------------------- */

static int find_light(const opening *o, const char *name, uint32_t *number)
{
    for (*number = 0; *number < o->r.out.light_count; ++*number)
        if (name && !strcmp(o->r.out.lights[*number].light.name, name)) return 1;
    return 0;
}

static int plan_blocks(opening *o, light_plan *l)
{
    vxs_reader            *r     = &o->r;
    const vxs_baked_light *baked = &r->out.lights[l->number];
    vxs_resident_sizes    *sizes = &l->sizes;
    uint8_t                head[RESIDENT_HEAD_BYTES];
    if ((l->resident_section = vxs_find_section(r, VXS_KIND_RESIDENT, l->number, 0)) < 0) return 0;
    if ((l->pages_section = vxs_find_section(r, VXS_KIND_PAGES, l->number, 0)) < 0) return 0;
    const vxs_section *resident = &r->out.sections[l->resident_section], *pages = &r->out.sections[l->pages_section];
    if (resident->stored_bytes < sizeof head) return vxs_found(r, 501, l->resident_section, 0), 0;
    if (!vxs_stream_read(o, resident->offset_bytes, sizeof head, head)) return 0;
    if (vxs_resident_sizes_of(sizes, head, sizeof head) != VXS_OK) return vxs_found(r, 501, l->resident_section, 0), 0;
    if (sizes->word_count > baked->word_count) return vxs_found(r, 406, l->pages_section, 0), 0;

    int fast      = baked->packing == VXS_PACKING_FAST;
    l->word_count = sizes->word_count;
    l->work_bytes = sum_or_max(resident->stored_bytes, vxs_page_table_bytes(sizes->page_count)) + 256 +
                    sizes->node_count * sizeof(vxs_page_node) + 4 * (sizes->page_count + (uint64_t)1) +
                    (fast ? vxs_resident_inflated_bytes(sizes) : 0);
    o->small |= !fast;
    o->fast |= fast;
    o->page_count += sizes->page_count;
    if (sizes->node_count > o->node_count) o->node_count = sizes->node_count;
    if (pages->stored_bytes > o->buffer_bytes) o->buffer_bytes = pages->stored_bytes;
    o->all_words += baked->word_count - sizes->word_count + (uint64_t)sizes->page_count * 2 * ROOM_ALIGN;
    return 1;
}

/* Measure smoke. Its word count is known only from its content, which is read again later, when there is room for the words. */
static int plan_smoke(opening *o, light_plan *l)
{
    int section = vxs_find_smoke(&o->r, l->number);
    if (section < 0) return 1;
    const vxs_section *s     = &o->r.out.sections[section];
    uint64_t           bytes = sum_or_max(sum_or_max(s->stored_bytes, s->inflated_bytes), 256);
    vxs_measure_smoke(&o->r, section, &l->smoke);
    vxs_stream_forget_loaded(o);
    if (bytes > l->work_bytes) l->work_bytes = bytes;
    return o->r.result == VXS_OK;
}

int vxs_stream_plan(opening *o)
{
    o->light_count = o->desc->light_names ? o->desc->light_name_count : o->r.out.light_count;
    if (!o->light_count || o->light_count > VXS_LIGHTS_MAX) return o->r.result = VXS_E_ARGUMENT, 0;
    if (!(o->lights = vxs_reader_alloc(&o->r, o->light_count, sizeof *o->lights, -1))) return 0;
    memset(o->lights, 0, o->light_count * sizeof *o->lights);
    for (uint32_t n = 0; n < o->light_count; n++) {
        o->lights[n].number = n;
        if (o->desc->light_names && !find_light(o, o->desc->light_names[n], &o->lights[n].number))
            return o->r.result = VXS_E_ARGUMENT, 0;
    }

    for (uint32_t n = 0; n < o->light_count; n++) {
        light_plan *l = &o->lights[n];
        if (o->r.out.lights[l->number].light.coding != VXS_CODING_BLOCKS) {
            /* Plan a DAG. It has no pages. Temporary memory holds its inflated levels and masks, and a list of node starts. */
            l->word_count = o->r.out.lights[l->number].word_count;
            for (uint32_t k = 0; k < o->r.out.section_count; k++) {
                const vxs_section *s = &o->r.out.sections[k];
                if (s->light != l->number || !vxs_is_dag_section(s->kind)) continue;
                l->work_bytes = sum_or_max(l->work_bytes, sum_or_max(s->stored_bytes, s->inflated_bytes));
                l->work_bytes = sum_or_max(l->work_bytes, sum_or_max(s->inflated_bytes, sum_or_max(s->inflated_bytes, 256)));
            }
        } else if (!plan_blocks(o, l))
            return 0;
        if (!plan_smoke(o, l)) return 0;
        o->resident_words += l->word_count + (uint64_t)l->smoke.word_count;
        if (l->work_bytes > o->work_bytes) o->work_bytes = l->work_bytes;
    }
    o->resident_words = (o->resident_words + VXS_BLOCKS_SPARE_WORDS + ROOM_ALIGN - 1) / ROOM_ALIGN * ROOM_ALIGN;
    o->all_words += o->resident_words;
    if (o->node_count > VXS_PAGE_WORDS_MAX / NODE_WORDS_MIN) o->node_count = VXS_PAGE_WORDS_MAX / NODE_WORDS_MIN;
    if (o->buffer_bytes > STORED_MAX) o->buffer_bytes = STORED_MAX;
    if (o->source.bytes) o->buffer_bytes = 0;
    o->tool_count    = o->desc->threads ? o->desc->threads : 1;
    o->request_count = o->desc->requests ? o->desc->requests : o->desc->threads + 1;
    return 1;
}
