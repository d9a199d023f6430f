/* Requests: pages that are read and decoded by the stream's threads, by those of the caller, or by the frame.
 *
 *     FREE --ask--> QUEUED --taken--> WORKING --> DONE --frame--> FREE
 *                      ^                 |
 *                      '--read_done-- PENDING
 *
 * A request's page has a place in the room from the start. Lookups do not see the words decoded there before a frame shows the
 * page.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "stream.h"
#include "vxs_resident_layout.h"

/* sources of bytes: a file read by position, memory, or the caller -------------------------------------------------------------- */

vxs_result vxs_stream_source_open(stream_source *source, const vxs_stream_desc *desc)
{
    if ((desc->path != NULL) + (desc->bytes != NULL) + (desc->read != NULL) != 1) return VXS_E_ARGUMENT;
    *source = (stream_source){.bytes = desc->bytes, .read = desc->read, .user = desc->read_user, .size_bytes = desc->size_bytes};
    if (!desc->path) return VXS_OK;
    vxs_result r = os_file_open(&source->file, desc->path);
    if (r != VXS_OK) return r;
    source->is_file    = 1;
    source->size_bytes = source->file.size_bytes;
    return VXS_OK;
}

void vxs_stream_source_close(stream_source *source)
{
    if (source->is_file) os_file_close(&source->file);
}

vxs_stream_answer vxs_stream_source_read(const stream_source *source, uint64_t offset, uint32_t size_bytes, void *buffer,
                                         vxs_stream_request *request)
{
    if (offset > source->size_bytes || size_bytes > source->size_bytes - offset) return VXS_STREAM_FAILED;
    if (source->read) return source->read(source->user, offset, size_bytes, buffer, request);
    if (source->is_file) return os_file_read(&source->file, offset, size_bytes, buffer) ? VXS_STREAM_READ : VXS_STREAM_FAILED;
    memcpy(buffer, source->bytes + offset, size_bytes);
    return VXS_STREAM_READ;
}

/* decoding -------------------------------------------------------------------------------------------------------------------- */

/* List the nodes of a page from its light's top level, in z order of squares: entries that name the page, with increasing offset.
 * A lower or equal offset repeats an earlier node. */
static uint32_t list_nodes(const vxs_stream *s, const stream_page *page, vxs_page_node *nodes)
{
    const vxs_paged_light *light = &s->lights[page->light].paged;
    const uint32_t        *words = light->resident.words;
    uint32_t side = squares_of(light->levels), number = (uint32_t)(page - s->pages) - s->lights[page->light].first_page;
    uint32_t count = 0;
    for (uint32_t square = page->first_square; count < page->node_count && square < light->map_count * side * side; square++) {
        uint32_t map = square / (side * side), z = square % (side * side), x = even_bits(z), y = even_bits(z >> 1);
        uint32_t at = top_at(words, words[2 + map], light->levels, x, y), name = words[at], offset = name & 0xffff;
        if (name >> 16 != number || (count && offset <= nodes[count - 1].offset)) continue;
        nodes[count++] = (vxs_page_node){offset, x, y, map, square_base(words[at + 1], light->levels)};
    }
    return count;
}

static int decode(stream_tools *tools, const vxs_stream_request *request)
{
    vxs_stream        *s    = tools->stream;
    const stream_page *page = &s->pages[request->page];
    vxs_page_content   c    = {.bytes      = request->buffer ? request->buffer : s->source.bytes + page->offset_bytes,
                               .size_bytes = page->stored_bytes,
                               .word_count = page->word_count,
                               .node_count = list_nodes(s, page, tools->nodes),
                               .hash       = page->hash,
                               .nodes      = tools->nodes};
    uint32_t          *to   = s->words + page->place;
    memset(to + page->word_count, 0, (vxs_stream_room_words(page) - page->word_count) * sizeof *to);
    return vxs_read_page(to, &c, &s->lights[page->light].paged, &tools->decode);
}

/* requests -------------------------------------------------------------------------------------------------------------------- */

static vxs_stream_request *oldest(vxs_stream *s, request_state state)
{
    vxs_stream_request *found = NULL;
    for (uint32_t n = 0; n < s->request_count; n++) {
        vxs_stream_request *r = &s->requests[n];
        if (r->state == state && (!found || (int32_t)(r->order - found->order) < 0)) found = r;
    }
    return found;
}

static void finish(vxs_stream_request *r, request_state state)
{
    r->state = state;
    os_wake_all(&r->stream->rest);
}

/* Process the oldest queued request as far as possible. Called and returns with the lock held. 0: none is queued; 1: its read was
 * started or has failed; 2: its page was decoded. */
static int work_once(stream_tools *tools)
{
    vxs_stream         *s = tools->stream;
    vxs_stream_request *r = oldest(s, REQUEST_QUEUED);
    if (!r) return 0;
    r->state = REQUEST_WORKING;
    if (!r->asked) {
        const stream_page *page   = &s->pages[r->page];
        vxs_stream_answer  answer = VXS_STREAM_READ;
        r->asked                  = 1;
        os_unlock(&s->lock);
        if (r->buffer) answer = vxs_stream_source_read(&s->source, page->offset_bytes, page->stored_bytes, r->buffer, r);
        os_lock(&s->lock);
        if (answer != VXS_STREAM_PENDING) {
            r->answered = 1;
            r->ok       = answer == VXS_STREAM_READ;
        }
        if (!r->answered) return finish(r, REQUEST_PENDING), 1;
    }
    int done = 1;
    if (r->ok) {
        done = 2;
        os_unlock(&s->lock);
        int finding = decode(tools, r);
        os_lock(&s->lock);
        r->decoded = 1;
        r->finding = finding;
    }
    finish(r, REQUEST_DONE);
    return done;
}

/* threads --------------------------------------------------------------------------------------------------------------------- */

static void *run_thread(void *work)
{
    stream_tools *tools = work;
    vxs_stream   *s     = tools->stream;
    os_lock(&s->lock);
    while (!s->closing)
        if (!work_once(tools)) os_wait(&s->work, &s->lock);
    os_unlock(&s->lock);
    return NULL;
}

static void run_job(void *job)
{
    stream_tools *tools = job;
    vxs_stream   *s     = tools->stream;
    os_lock(&s->lock);
    tools->busy = 2;
    while (!s->closing && work_once(tools)) {}
    tools->busy = 0;
    os_wake_all(&s->rest);
    os_unlock(&s->lock);
}

/* Wake or submit threads for queued requests. Called and returns with the lock held. */
static void call_for_work(vxs_stream *s)
{
    os_wake_all(&s->work);
    if (s->desc.submit) {
        /* Submit jobs to the caller's threads, as many as there are queued requests and idle tools. Called and returns with the
         * lock held. */
        uint32_t queued = 0;
        for (uint32_t n = 0; n < s->request_count; n++) queued += s->requests[n].state == REQUEST_QUEUED;
        for (uint32_t n = 0; n < s->tool_count; n++) queued -= s->tools[n].busy == 1 && queued;
        for (uint32_t n = 0; n < s->tool_count && queued; n++) {
            if (s->tools[n].busy) continue;
            s->tools[n].busy = 1;
            queued--;
            os_unlock(&s->lock);
            s->desc.submit(s->desc.submit_user, run_job, &s->tools[n]);
            os_lock(&s->lock);
        }
    }
}

void vxs_stream_read_done(vxs_stream_request *r, int ok)
{
    vxs_stream *s = r->stream;
    os_lock(&s->lock);
    r->answered = 1;
    r->ok       = ok;
    if (r->state == REQUEST_PENDING) { /* else the thread that read it continues with it */
        r->state = REQUEST_QUEUED;
        if (!s->closing) call_for_work(s);
    }
    os_wake_all(&s->rest);
    os_unlock(&s->lock);
}

/* calls of the frame ---------------------------------------------------------------------------------------------------------- */

int vxs_stream_can_ask(vxs_stream *s)
{
    os_lock(&s->lock);
    int can = oldest(s, REQUEST_FREE) != NULL;
    os_unlock(&s->lock);
    return can;
}

void vxs_stream_ask(vxs_stream *s, uint32_t page)
{
    os_lock(&s->lock);
    vxs_stream_request *r = oldest(s, REQUEST_FREE);
    *r                    = (vxs_stream_request){s, REQUEST_QUEUED, page, s->order++, r->buffer, 0, 0, 0, 0, 0};
    call_for_work(s);
    os_unlock(&s->lock);
}

void vxs_stream_work_here(vxs_stream *s, uint32_t count)
{
    os_lock(&s->lock);
    for (int done = 1; count && done; count -= done == 2) done = work_once(&s->tools[0]);
    os_unlock(&s->lock);
}

vxs_stream_request *vxs_stream_next_done(vxs_stream *s)
{
    os_lock(&s->lock);
    vxs_stream_request *r = oldest(s, REQUEST_DONE);
    os_unlock(&s->lock);
    return r;
}

void vxs_stream_release(vxs_stream_request *r)
{
    os_lock(&r->stream->lock);
    r->state = REQUEST_FREE;
    os_unlock(&r->stream->lock);
}

/* start, wait, end ------------------------------------------------------------------------------------------------------------ */

/* Whether a job or request will end by itself; queued: 1: count queued requests too. */
static int is_busy(const vxs_stream *s, int queued)
{
    for (uint32_t n = 0; n < s->tool_count; n++)
        if (s->tools[n].busy) return 1;
    for (uint32_t n = 0; n < s->request_count; n++) {
        request_state state = s->requests[n].state;
        if (state == REQUEST_WORKING || state == REQUEST_PENDING || (queued && state == REQUEST_QUEUED)) return 1;
    }
    return 0;
}

void vxs_stream_wait(vxs_stream *s)
{
    if (!(s->thread_count || s->desc.submit)) return;
    os_lock(&s->lock);
    while (is_busy(s, 1)) os_wait(&s->rest, &s->lock);
    os_unlock(&s->lock);
}

int vxs_stream_work_start(vxs_stream *s)
{
    if (!os_mutex_init(&s->lock)) return 0;
    if (!os_signal_init(&s->work)) return os_mutex_free(&s->lock), 0;
    if (!os_signal_init(&s->rest)) return os_signal_free(&s->work), os_mutex_free(&s->lock), 0;
    s->can_work = 1;
    for (; !s->desc.submit && s->thread_count < s->desc.threads; s->thread_count++)
        if (!os_thread_start(&s->tools[s->thread_count].thread, run_thread, &s->tools[s->thread_count])) return 0;
    return 1;
}

void vxs_stream_work_end(vxs_stream *s)
{
    if (!s->can_work) return;
    os_lock(&s->lock);
    s->closing = 1;
    os_wake_all(&s->work);
    while (is_busy(s, 0)) os_wait(&s->rest, &s->lock);
    os_unlock(&s->lock);
    for (uint32_t n = 0; n < s->thread_count; n++) os_thread_join(s->tools[n].thread);
    os_signal_free(&s->rest);
    os_signal_free(&s->work);
    os_mutex_free(&s->lock);
}
