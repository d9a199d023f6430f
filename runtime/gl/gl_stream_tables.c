/* Tables of the pages of a stream (gl_tables.h): made when a page is uploaded. Its words stay on the processor.
 *
 *     all words   words of DAGs | smoke | tops of all lights | room for tables of pages
 *
 * A page takes the largest gap in the room. If the room has none that holds it, its squares keep their coarse answer until other
 * pages leave.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "gl_state.h"

/* creation -------------------------------------------------------------------------------------------------------------------- */

static int has_blocks(const vxs_gl *gl, uint32_t light)
{
    return gl->lights[light].light->coding == VXS_CODING_BLOCKS;
}

uint64_t vxs_gl_stream_tables_lights(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t words)
{
    uint64_t dags = 0, tops = 0, room = words;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        const vxs_baked_light *baked = vxs_stream_light(gl->stream, n);
        const vxs_baked_smoke *smoke = vxs_stream_smoke(gl->stream, n);
        room -= baked->word_count + (smoke ? smoke->word_count : 0);
        tops += has_blocks(gl, n) ? vxs_gl_tables_square_count(&baked->light) : 0;
    }
    uint64_t others = words - room + tops + vxs_gl_smoke_words(gl, desc) + VXS_BLOCKS_SPARE_WORDS;
    uint32_t most   = vxs_gl_most_table_words(gl, desc, TABLES_PER_WORD * room, others);
    if (!tops || most < room) return words;
    gl->top_count   = (uint32_t)tops;
    gl->room_count  = most;
    gl->table_count = gl->top_count + gl->room_count;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        if (has_blocks(gl, n)) continue;
        gl->lights[n].first_word = (uint32_t)dags;
        dags += vxs_stream_light(gl->stream, n)->word_count;
    }
    return dags;
}

uint64_t vxs_gl_stream_tables_place(vxs_gl *gl, uint64_t words)
{
    uint32_t at    = (uint32_t)words;
    gl->top_word   = at;
    gl->room_first = gl->top_word + gl->top_count;
    for (uint32_t n = 0; n < gl->light_count; n++) {
        if (!has_blocks(gl, n)) continue;
        gl->lights[n].first_word = at;
        at += vxs_gl_tables_square_count(gl->lights[n].light);
    }
    return words + gl->table_count;
}

/* Fill the tops; count the squares of each page, and list them if there is an array for that. */
static void list_squares(vxs_gl *gl)
{
    uint32_t page, at = 0;
    gl_page *first = gl->pages; /* of the light */
    for (uint32_t n = 0; n < gl->light_count; n++) {
        const vxs_baked_light *baked = vxs_stream_light(gl->stream, n);
        for (uint32_t s = 0; has_blocks(gl, n) && s < vxs_gl_tables_square_count(&baked->light); s++) {
            gl->tops[at++] = vxs_gl_tables_missing(baked, s, &page);
            if (page == UINT32_MAX) continue;
            if (gl->squares) gl->squares[first[page].first_square + first[page].square_count].number = s;
            first[page].square_count++;
        }
        first += vxs_stream_names(gl->stream, n).word_count;
    }
}

static int make_lists(vxs_gl *gl)
{
    gl->tops   = vxs_gl_alloc(gl, gl->top_count, sizeof *gl->tops);
    gl->placed = vxs_gl_alloc(gl, gl->page_count, sizeof *gl->placed);
    if (!gl->tops || (gl->page_count && !gl->placed)) return 0;
    list_squares(gl);
    for (uint32_t n = 0; n < gl->page_count; n++) {
        gl->pages[n].first_square = gl->square_count;
        gl->square_count += gl->pages[n].square_count;
        gl->pages[n].square_count = 0;
    }
    if (!gl->square_count) return 1;
    if (!(gl->squares = vxs_gl_alloc(gl, gl->square_count, sizeof *gl->squares))) return 0;
    list_squares(gl);
    return 1;
}

vxs_result vxs_gl_stream_tables_put(vxs_gl *gl)
{
    if (!make_lists(gl)) return VXS_E_MEMORY;
    gl->tables   = (gl_tables){.memory = gl->memory};
    vxs_result r = vxs_gl_put_words(gl, gl->tops, gl->top_word, gl->top_count);
    for (uint32_t n = 0; r == VXS_OK && n < gl->light_count; n++) {
        const vxs_baked_light *baked = vxs_stream_light(gl->stream, n);
        if (!has_blocks(gl, n)) r = vxs_gl_put_words(gl, baked->words, gl->lights[n].first_word, baked->word_count);
    }
    return r;
}

/* room ------------------------------------------------------------------------------------------------------------------------ */

/* Find the largest gap between placed pages.
 * first  [out] its first word
 * Returns the number of the placed page behind it. */
static uint32_t largest_gap(const vxs_gl *gl, uint32_t *first, uint32_t *count)
{
    uint32_t end = gl->room_first, found = 0;
    *count = 0;
    for (uint32_t n = 0; n <= gl->placed_count; n++) {
        const gl_page *page = n < gl->placed_count ? &gl->pages[gl->placed[n]] : NULL;
        uint32_t       next = page ? page->first_word : gl->room_first + gl->room_count;
        if (next - end > *count) {
            *count = next - end;
            *first = end;
            found  = n;
        }
        if (page) end = page->first_word + page->word_count;
    }
    return found;
}

static void leave_room(vxs_gl *gl, uint32_t number)
{
    uint32_t n = 0;
    while (n < gl->placed_count && gl->placed[n] != number) n++;
    if (n < gl->placed_count) memmove(gl->placed + n, gl->placed + n + 1, (--gl->placed_count - n) * sizeof *gl->placed);
    gl->pages[number].first_word = 0;
}

/* pages ----------------------------------------------------------------------------------------------------------------------- */

static void set_top(vxs_gl *gl, uint32_t at, uint32_t word)
{
    gl->tops[at] = word;
    if (gl->tops_first == gl->tops_end) gl->tops_first = gl->tops_end = at;
    if (at < gl->tops_first) gl->tops_first = at;
    if (at >= gl->tops_end) gl->tops_end = at + 1;
}

void vxs_gl_stream_tables_write(vxs_gl *gl)
{
    uint32_t count = gl->tops_end - gl->tops_first;
    vxs_gl_words_write(gl, &gl->words, gl->tops + gl->tops_first, gl->top_word + gl->tops_first, count);
    gl->bytes_uploaded += (uint64_t)count * sizeof *gl->tops;
    gl->tops_first = gl->tops_end = 0;
}

void vxs_gl_stream_tables_begin(vxs_gl *gl, uint32_t number)
{
    gl_page *page  = &gl->pages[number];
    uint32_t first = gl->room_first, room, behind = largest_gap(gl, &first, &room);
    memmove(gl->placed + behind + 1, gl->placed + behind, (gl->placed_count++ - behind) * sizeof *gl->placed);
    gl->placed[behind] = number;
    page->first_word   = first;
    page->word_count   = room;
    gl->coming_squares = 0;
    vxs_gl_tables_begin(&gl->tables, first, room);
}

gl_progress vxs_gl_stream_tables_make(vxs_gl *gl, uint32_t number)
{
    gl_page               *page  = &gl->pages[number];
    const vxs_baked_light *baked = vxs_stream_light(gl->stream, page->light);
    if (gl->coming_squares == page->square_count) {
        page->word_count = gl->tables.count;
        return GL_READY;
    }
    vxs_result r = vxs_gl_tables_add_square(&gl->tables, baked, &gl->squares[page->first_square + gl->coming_squares]);
    if (r == VXS_OK) {
        gl->coming_squares++;
        return GL_MORE;
    }
    page->word_count++; /* the gap must be larger next time */
    leave_room(gl, number);
    if (r == VXS_E_MEMORY) return GL_NO_MEMORY;
    if (gl->log && !gl->said_no_room)
        gl->log(VXS_SEVERITY_WARNING, "no room for the tables of a page: its shadows stay coarse; increase most_table_bytes",
                gl->user);
    gl->said_no_room = 1;
    return GL_NO_ROOM;
}

void vxs_gl_stream_tables_show(vxs_gl *gl, uint32_t number, int is_shown)
{
    const gl_page         *page  = &gl->pages[number];
    const vxs_baked_light *baked = vxs_stream_light(gl->stream, page->light);
    uint32_t               ignored, first_top = gl->lights[page->light].first_word - gl->top_word;
    if (!page->first_word) return;
    for (uint32_t n = page->first_square; n < page->first_square + page->square_count; n++) {
        const gl_square *s = &gl->squares[n];
        set_top(gl, first_top + s->number, is_shown ? s->word : vxs_gl_tables_missing(baked, s->number, &ignored));
    }
    if (!is_shown) leave_room(gl, number);
}

void vxs_gl_stream_tables_hidden(vxs_gl *gl)
{
    uint32_t first, room;
    vxs_gl_stream_tables_write(gl);
    largest_gap(gl, &first, &room);
    for (uint32_t n = 0; n < gl->page_count; n++)
        if (gl->names[n] && !gl->pages[n].first_word && gl->pages[n].word_count <= room) gl->names[n] = 0;
}

void vxs_gl_stream_tables_free(vxs_gl *gl)
{
    vxs_gl_free(gl, gl->tops, gl->top_count, sizeof *gl->tops);
    vxs_gl_free(gl, gl->squares, gl->square_count, sizeof *gl->squares);
    vxs_gl_free(gl, gl->placed, gl->page_count, sizeof *gl->placed);
}
