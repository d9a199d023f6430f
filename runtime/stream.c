/* Frames and queries of a stream; see vxs_stream.h.
 * SPDX-License-Identifier: MIT */
#include <float.h>
#include <string.h>

#include "stream.h"

enum { STATUS_FIRST_BYTES = sizeof(vxs_stream_status) };

/* Record and report that a page cannot be loaded, now or at all. */
static void fail(vxs_stream *s, uint32_t number, vxs_result result, int finding)
{
    stream_page *page = &s->pages[number];
    page->state       = PAGE_AWAY;
    page->next_at     = s->frame + (8u << page->attempts++);
    if (result == VXS_E_CORRUPT || page->attempts == VXS_STREAM_ATTEMPTS) page->state = PAGE_BROKEN;
    if (!s->desc.failed) return;
    s->desc.failed(s->desc.failed_user, page->light, number - s->lights[page->light].first_page, result, finding);
}

/* Process done requests: their pages appear, or on failure their places become free. */
static void collect(vxs_stream *s)
{
    for (vxs_stream_request *r; (r = vxs_stream_next_done(s)); vxs_stream_release(r)) {
        stream_page *page = &s->pages[r->page];
        s->status.reads++;
        s->status.decodes += (uint32_t)r->decoded;
        if (r->ok) s->source.bytes_read += page->stored_bytes;
        if (r->ok && !r->finding) {
            page->state    = PAGE_HERE;
            page->attempts = 0;
            s->status.appeared++;
            vxs_stream_show(s, r->page, 1);
            continue;
        }
        vxs_stream_room_free(s, r->page);
        fail(s, r->page, r->ok ? VXS_E_CORRUPT : VXS_E_READ, r->finding);
    }
}

/* status ---------------------------------------------------------------------------------------------------------------------- */

static void count_pages(vxs_stream *s)
{
    vxs_stream_status *t = &s->status;
    t->pages_resident = t->pages_missing = t->pages_coming = t->pages_failed = 0;
    t->bytes_resident                                                        = 4 * (uint64_t)s->room_first;
    for (uint32_t n = 0; n < s->page_count; n++) {
        const stream_page *page = &s->pages[n];
        t->pages_resident += page->state == PAGE_HERE;
        t->pages_coming += page->state == PAGE_COMING;
        t->pages_failed += page->state == PAGE_BROKEN || (page->state == PAGE_AWAY && page->attempts);
        t->pages_missing += page->rank < FLT_MAX && page->state != PAGE_HERE;
        if (page->state == PAGE_HERE) t->bytes_resident += 4 * (uint64_t)page->word_count;
    }
    t->bytes_held   = s->block_bytes;
    t->bytes_room   = 4 * (uint64_t)(s->room_end - s->room_first);
    t->bytes_read   = s->source.bytes_read;
    t->pages        = s->page_count;
    t->pages_wanted = s->wanted;
}

vxs_result vxs_stream_frame(vxs_stream *s, const vxs_stream_focus *foci, uint32_t count, vxs_stream_status *status)
{
    if (status && status->struct_size && status->struct_size < STATUS_FIRST_BYTES) return VXS_E_ARGUMENT;
    if (!foci && count) return VXS_E_ARGUMENT;
    s->frame++;
    s->change_count = 0;
    s->status       = (vxs_stream_status){.struct_size = sizeof s->status};
    collect(s);

    /* Mark the nearest pages that fit as kept, all of them before any page is evicted; then request those that are away, as far as
     * there are requests and places. */
    uint32_t room = s->room_end - s->room_first, number, kept = 0;
    vxs_stream_rank_pages(s, foci, count);
    while (vxs_stream_next_nearest(s, &number)) {
        stream_page *page  = &s->pages[number];
        uint32_t     words = vxs_stream_room_words(page);
        if (page->state == PAGE_BROKEN || words > s->room_end - s->room_first) continue;
        /* the page table may be hostile */
        if (!(page->word_count >= 1 && page->word_count <= VXS_PAGE_WORDS_MAX && page->stored_bytes <= STORED_MAX)) {
            fail(s, number, VXS_E_CORRUPT, 504);
            continue;
        }
        if (words > room) break;
        room -= words;
        page->kept                      = s->frame;
        s->heap[s->page_count - ++kept] = number; /* the heap does not use this end any more */
    }
    for (uint32_t n = 0; n < kept; n++) {
        stream_page *page = &s->pages[number = s->heap[s->page_count - 1 - n]];
        if (page->state != PAGE_AWAY || (page->attempts && (int32_t)(s->frame - page->next_at) < 0)) continue;
        if (!vxs_stream_can_ask(s) || !vxs_stream_room_alloc(s, number)) continue;
        page->state = PAGE_COMING;
        vxs_stream_ask(s, number);
    }

    if (!s->desc.submit && !s->desc.threads) {
        vxs_stream_work_here(s, s->desc.decodes_per_frame ? s->desc.decodes_per_frame : 1);
        collect(s);
    }
    count_pages(s);
    if (status) {
        /* only the part that the caller's struct has */
        size_t given = status->struct_size, known = given ? given : STATUS_FIRST_BYTES;
        memcpy(status, &s->status, known < sizeof *status ? known : sizeof *status);
        status->struct_size = given;
    }
    return VXS_OK;
}

void vxs_stream_retry(vxs_stream *s)
{
    for (uint32_t n = 0; n < s->page_count; n++) {
        s->pages[n].attempts = 0;
        if (s->pages[n].state == PAGE_BROKEN) s->pages[n].state = PAGE_AWAY;
    }
}

/* queries --------------------------------------------------------------------------------------------------------------------- */

uint32_t vxs_stream_light_count(const vxs_stream *s)
{
    return s->light_count;
}

const vxs_baked_light *vxs_stream_light(const vxs_stream *s, uint32_t index)
{
    return index < s->light_count ? &s->baked[index] : NULL;
}

const vxs_baked_light *vxs_stream_find_light(const vxs_stream *s, const char *name)
{
    for (uint32_t n = 0; name && n < s->light_count; n++)
        if (!strcmp(s->baked[n].light.name, name)) return &s->baked[n];
    return NULL;
}

const vxs_baked_smoke *vxs_stream_smoke(const vxs_stream *s, uint32_t index)
{
    return index < s->light_count && s->lights[index].smoke.words ? &s->lights[index].smoke : NULL;
}

const uint32_t *vxs_stream_words(const vxs_stream *s, uint32_t *count)
{
    *count = s->word_count;
    return s->words;
}

uint32_t vxs_stream_first_word(const vxs_stream *s, uint32_t light)
{
    return light < s->light_count ? s->lights[light].first_word : 0;
}

vxs_stream_range vxs_stream_names(const vxs_stream *s, uint32_t light)
{
    if (light >= s->light_count) return (vxs_stream_range){0, 0};
    return (vxs_stream_range){s->lights[light].first_word + VXS_BLOCKS_FIRST_PAGE, s->lights[light].page_count};
}

vxs_stream_range vxs_stream_page(const vxs_stream *s, uint32_t light, uint32_t page)
{
    if (light >= s->light_count || page >= s->lights[light].page_count) return (vxs_stream_range){0, 0};
    const stream_page *p = &s->pages[s->lights[light].first_page + page];
    return p->state == PAGE_HERE ? (vxs_stream_range){p->place, p->word_count} : (vxs_stream_range){0, 0};
}

const vxs_stream_range *vxs_stream_changes(const vxs_stream *s, uint32_t *count)
{
    *count = s->change_count;
    return s->changes;
}
