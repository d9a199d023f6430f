/* The words of a stream on a GPU: resident words once, then pages as they appear and leave.
 *
 * Lookups find a page by its name. This file keeps the names that the GPU has, beside the stream's own names. Where they differ,
 * the page has left, moved or appeared:
 *
 *     stream         name   0      name   p       name   q
 *     uploaded       name   p      name   0       name   p
 *                    set to 0      uploaded       set to 0, then uploaded
 *
 * An upload never overwrites a page that a name on the GPU refers to: the stream gives a place to one page at a time, and names
 * that differ from the stream's are set to 0 before any upload. This holds even if calls for some frames were left out, so no
 * list of changes is needed.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"

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
        for (uint32_t page = 0; page < vxs_stream_names(gl->stream, n).word_count; page++) gl->pages[at++] = (gl_page){n, page};
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

static void write_name(vxs_gl *gl, uint32_t number, uint32_t name, uint32_t at)
{
    gl->names[number] = name;
    vxs_gl_words_write(gl, &gl->words, &name, at, 1);
    gl->bytes_uploaded += sizeof name;
}

void vxs_gl_stream_detach(vxs_gl *gl)
{
    uint32_t at;
    for (uint32_t n = 0; n < gl->page_count; n++)
        if (gl->names[n] && gl->names[n] != name_of(gl, n, &at)) write_name(gl, n, 0, at);
}

/* Upload at most room_words more words of a page, and its name when the page is complete. Returns the number of words. */
static size_t upload_page(vxs_gl *gl, uint32_t number, uint32_t name, uint32_t at, size_t room_words)
{
    uint32_t         count;
    const uint32_t  *words = vxs_stream_words(gl->stream, &count);
    vxs_stream_range range = vxs_stream_page(gl->stream, gl->pages[number].light, gl->pages[number].page);
    uint32_t         left = range.word_count - gl->coming_done, some = left < room_words ? left : (uint32_t)room_words;
    uint32_t         first = range.first_word + gl->coming_done;
    vxs_gl_words_write(gl, &gl->words, words + first, first, some);
    gl->bytes_uploaded += (uint64_t)some * sizeof *words;
    gl->coming_name = name;
    gl->coming_done += some;
    if (some == room_words) return some;
    write_name(gl, number, name, at);
    gl->coming_name = gl->coming_done = 0;
    return (size_t)some + 1;
}

/* Pages are uploaded in turn, starting with the one that is partly uploaded: with small slices every page is still uploaded in
 * the end. */
uint64_t vxs_gl_stream_upload(vxs_gl *gl, size_t room_words)
{
    uint64_t left = 0;
    uint32_t at, turn = gl->coming;
    for (uint32_t n = 0; n < gl->page_count; n++, turn = turn + 1 < gl->page_count ? turn + 1 : 0) {
        uint32_t name = name_of(gl, turn, &at);
        if (turn == gl->coming && gl->coming_name && gl->coming_name != name) gl->coming_name = gl->coming_done = 0;
        if (!name || name == gl->names[turn]) continue;
        if (room_words) {
            gl->coming = turn;
            room_words -= upload_page(gl, turn, name, at, room_words);
            if (gl->names[turn]) continue;
        }
        uint64_t words = vxs_stream_page(gl->stream, gl->pages[turn].light, gl->pages[turn].page).word_count + (uint64_t)1;
        left += (words - (turn == gl->coming ? gl->coming_done : 0)) * sizeof(uint32_t);
    }
    return left;
}
