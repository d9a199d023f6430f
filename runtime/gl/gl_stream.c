/* The words of a stream on a GPU: resident words once, then pages as they appear and leave.
 *
 * Shaders find a page by its name, or its tables by the top (gl_stream_tables.c). This file keeps the names of the pages that
 * the GPU has, beside the stream's own names. Where they differ, the page has left, moved or appeared:
 *
 *     stream         name   0      name   p       name   q
 *     uploaded       name   p      name   0       name   p
 *                    hidden        uploaded       hidden, then uploaded
 *
 * An upload never overwrites a page that shaders find: a place belongs to one page at a time, and pages whose names differ
 * from the stream's are hidden before any upload. This holds even if calls for some frames were left out, so no list of changes is
 * needed.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"

enum { TABLE_WORDS_FOR_ONE = 5 }; /* words of tables for a word of a page: 4.2 to 5.5 in the scenes that were measured */

/* lights and resident parts --------------------------------------------------------------------------------------------------- */

uint32_t vxs_gl_stream_lights(vxs_gl *gl)
{
    uint32_t words;
    for (uint32_t n = 0; n < gl->light_count; n++)
        gl->lights[n] = (vxs_gl_light){&vxs_stream_light(gl->stream, n)->light, vxs_stream_first_word(gl->stream, n)};
    vxs_stream_words(gl->stream, &words);
    return words;
}

static int list_pages(vxs_gl *gl)
{
    uint32_t count = 0;
    for (uint32_t n = 0; n < gl->light_count; n++) count += vxs_stream_names(gl->stream, n).word_count;
    gl->page_count = count;
    gl->pages      = vxs_gl_alloc(gl, count, sizeof *gl->pages);
    gl->names      = vxs_gl_alloc(gl, count, sizeof *gl->names);
    if (count && (!gl->pages || !gl->names)) return 0;
    for (uint32_t n = 0, at = 0; n < gl->light_count; n++)
        for (uint32_t page = 0; page < vxs_stream_names(gl->stream, n).word_count; page++)
            gl->pages[at++] = (gl_page){.light = n, .page = page};
    if (count) memset(gl->names, 0, count * sizeof *gl->names);
    return 1;
}

/* Queue a light's resident part, with names of 0 until pages are uploaded. */
static vxs_result put_light(vxs_gl *gl, uint32_t light, uint32_t first_page)
{
    uint32_t         count, first = gl->lights[light].first_word;
    uint32_t         end   = first + vxs_stream_light(gl->stream, light)->word_count;
    vxs_stream_range names = vxs_stream_names(gl->stream, light);
    const uint32_t  *words = vxs_stream_words(gl->stream, &count);
    if (!names.word_count) return vxs_gl_put(gl, words + first, first, end - first);
    uint32_t   behind = names.first_word + names.word_count;
    vxs_result r      = vxs_gl_put(gl, words + first, first, names.first_word - first);
    if (r == VXS_OK) r = vxs_gl_put(gl, gl->names + first_page, names.first_word, names.word_count);
    return r == VXS_OK ? vxs_gl_put(gl, words + behind, behind, end - behind) : r;
}

vxs_result vxs_gl_stream_put(vxs_gl *gl)
{
    vxs_result r = list_pages(gl) ? VXS_OK : VXS_E_MEMORY;
    if (r == VXS_OK && gl->table_count) return vxs_gl_stream_tables_put(gl);
    for (uint32_t n = 0, first_page = 0; r == VXS_OK && n < gl->light_count; n++) {
        r = put_light(gl, n, first_page);
        first_page += vxs_stream_names(gl->stream, n).word_count;
    }
    return r;
}

/* pages ----------------------------------------------------------------------------------------------------------------------- */

/* Returns the stream's name of a page. at  [out] index of that name in the array of all words */
static uint32_t name_of(const vxs_gl *gl, uint32_t number, uint32_t *at)
{
    uint32_t count;
    *at = vxs_stream_names(gl->stream, gl->pages[number].light).first_word + gl->pages[number].page;
    return vxs_stream_words(gl->stream, &count)[*at];
}

/* Let shaders find a page.   name  of the stream; 0: they no longer find it */
static void show(vxs_gl *gl, uint32_t number, uint32_t name, uint32_t at)
{
    gl->names[number] = name;
    if (gl->table_count) {
        vxs_gl_stream_tables_show(gl, number, name != 0);
        return;
    }
    vxs_gl_words_write(gl, &gl->words, &name, at, 1);
    gl->bytes_uploaded += sizeof name;
}

static void forget_coming(vxs_gl *gl)
{
    gl->coming_name = gl->coming_done = 0;
}

void vxs_gl_stream_detach(vxs_gl *gl)
{
    uint32_t at, hidden = 0;
    if (gl->coming_name && gl->coming_name != name_of(gl, gl->coming, &at)) {
        if (gl->table_count) vxs_gl_stream_tables_show(gl, gl->coming, 0);
        forget_coming(gl);
        hidden++;
    }
    for (uint32_t n = 0; n < gl->page_count; n++) {
        if (!gl->names[n] || gl->names[n] == name_of(gl, n, &at)) continue;
        show(gl, n, 0, at);
        hidden++;
    }
    if (gl->table_count && hidden) vxs_gl_stream_tables_hidden(gl);
}

/* What of a page can be uploaded now, and its place on the GPU. */
static gl_range words_of(const vxs_gl *gl, uint32_t number)
{
    const gl_page   *page = &gl->pages[number];
    uint32_t         count;
    const uint32_t  *words = vxs_stream_words(gl->stream, &count);
    vxs_stream_range range = vxs_stream_page(gl->stream, page->light, page->page);
    if (gl->table_count) return (gl_range){gl->tables.words, page->first_word, gl->tables.count};
    return (gl_range){words + range.first_word, range.first_word, range.word_count};
}

/* Upload at most room_words more words of a page; when it is complete, shaders find it. Returns the number of words. */
static size_t upload_page(vxs_gl *gl, uint32_t number, uint32_t name, uint32_t at, size_t room_words)
{
    size_t      done = 0;
    gl_progress made = GL_READY;
    if (!gl->coming_name && gl->table_count) vxs_gl_stream_tables_begin(gl, number);
    gl->coming_name = name;
    do {
        gl_range range = words_of(gl, number);
        size_t   left = range.count - gl->coming_done, some = left < room_words - done ? left : room_words - done;
        vxs_gl_words_write(gl, &gl->words, range.words + gl->coming_done, range.first + gl->coming_done, (uint32_t)some);
        gl->coming_done += (uint32_t)some;
        done += some;
        if (done < room_words && gl->table_count) made = vxs_gl_stream_tables_make(gl, number);
    } while (done < room_words && made == GL_MORE);
    gl->bytes_uploaded += done * sizeof(uint32_t);
    if (done == room_words) return done;
    if (made == GL_READY) show(gl, number, name, at);
    if (made == GL_NO_ROOM) gl->names[number] = name; /* it stays coarse */
    forget_coming(gl);
    return done + (made == GL_READY);
}

/* Bytes of a page that are not yet uploaded, about: how large tables are is known when they are made. */
static uint64_t bytes_left(const vxs_gl *gl, uint32_t number)
{
    uint64_t words = vxs_stream_page(gl->stream, gl->pages[number].light, gl->pages[number].page).word_count;
    uint64_t done  = number == gl->coming ? gl->coming_done : 0;
    words          = gl->table_count ? words * TABLE_WORDS_FOR_ONE + 1 : words + 1;
    return (words > done ? words - done : 1) * sizeof(uint32_t);
}

/* Pages are uploaded in turn, starting with the one that is partly uploaded: with small slices every page is still uploaded in
 * the end. */
uint64_t vxs_gl_stream_upload(vxs_gl *gl, size_t room_words)
{
    uint64_t left = 0;
    uint32_t at, turn = gl->coming;
    for (uint32_t n = 0; n < gl->page_count; n++, turn = turn + 1 < gl->page_count ? turn + 1 : 0) {
        uint32_t name = name_of(gl, turn, &at);
        if (!name || name == gl->names[turn]) continue;
        if (room_words) {
            gl->coming = turn;
            room_words -= upload_page(gl, turn, name, at, room_words);
            if (gl->names[turn]) continue;
        }
        left += bytes_left(gl, turn);
    }
    if (gl->table_count) vxs_gl_stream_tables_write(gl);
    return left;
}
