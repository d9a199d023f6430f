/* Choice of a page's place in the array of words: a gap in the room for pages, or the place of pages that are evicted.
 *
 *     room  | page 7 |    gap    | page 2 | page 11 |  gap  |         in_room: 7, 2, 11
 *
 * Pages differ in size and do not move. A place is a run of gaps and of pages that may be evicted: pages that are no longer
 * wanted, the least recently wanted first; and only where no such run is wide enough, pages that are farther than the new page. A
 * page that is being read or decoded is not evicted.
 * SPDX-License-Identifier: MIT */
#include <float.h>
#include <string.h>

#include "stream.h"

/* Words that a page takes, including those behind it that a lookup may fetch. */
uint32_t vxs_stream_room_words(const stream_page *page)
{
    return (page->word_count + VXS_BLOCKS_SPARE_WORDS + ROOM_ALIGN - 1) / ROOM_ALIGN * ROOM_ALIGN;
}

/* Cost of evicting a page for one of rank `rank`. Negative when it is not among the nearest, lower the longer ago it was; 0 to 1
 * when it is, lower the farther it is; 2: it must not be evicted. */
static double cost_of(const vxs_stream *s, const stream_page *page, float rank)
{
    if (page->state != PAGE_HERE) return 2;
    if (page->kept != s->frame) return -(double)(s->frame - page->kept);
    return page->rank > rank ? 1 / (1 + (double)page->rank) : 2;
}

typedef struct place {
    uint32_t first_word, at, leaving; /* pages in_room[at] to [at + leaving - 1] are evicted */
    double   cost;
} place;

/* The place that starts at the end of in_room[at - 1], with as many evicted pages as needed. Its cost is the greatest cost of
 * these; 2: no place. */
static place place_at(const vxs_stream *s, uint32_t at, uint32_t words, float rank)
{
    place p = {s->room_first, at, 0, -DBL_MAX};
    if (at) p.first_word = s->pages[s->in_room[at - 1]].place + vxs_stream_room_words(&s->pages[s->in_room[at - 1]]);
    for (;; p.leaving++) {
        uint32_t next = at + p.leaving;
        uint32_t end  = next < s->in_room_count ? s->pages[s->in_room[next]].place : s->room_end;
        if (end - p.first_word >= words) return p;
        double cost = next < s->in_room_count ? cost_of(s, &s->pages[s->in_room[next]], rank) : 2;
        if (cost > p.cost) p.cost = cost;
        if (cost > 1) return p;
    }
}

void vxs_stream_show(vxs_stream *s, uint32_t number, int there)
{
    stream_page        *page      = &s->pages[number];
    const stream_light *light     = &s->lights[page->light];
    uint32_t            entry     = light->first_word + FIRST_PAGE_WORD + (number - light->first_page);
    s->words[entry]               = there ? page->place - light->first_word : 0;
    s->changes[s->change_count++] = (vxs_stream_range){entry, 1};
    if (there) s->changes[s->change_count++] = (vxs_stream_range){page->place, page->word_count};
}

static void remove_from_room(vxs_stream *s, uint32_t at)
{
    memmove(s->in_room + at, s->in_room + at + 1, (--s->in_room_count - at) * sizeof *s->in_room);
}

int vxs_stream_room_take(vxs_stream *s, uint32_t number)
{
    stream_page *page  = &s->pages[number];
    uint32_t     words = vxs_stream_room_words(page);
    place        best  = {.cost = 2};
    for (uint32_t at = 0; at <= s->in_room_count; at++) {
        place p = place_at(s, at, words, page->rank);
        if (p.cost < best.cost) best = p;
    }
    if (best.cost > 1) return 0;
    for (; best.leaving; best.leaving--) {
        uint32_t leaving = s->in_room[best.at];
        vxs_stream_show(s, leaving, 0);
        s->pages[leaving].state = PAGE_AWAY;
        remove_from_room(s, best.at);
        s->status.left++;
    }
    memmove(s->in_room + best.at + 1, s->in_room + best.at, (s->in_room_count++ - best.at) * sizeof *s->in_room);
    s->in_room[best.at] = number;
    page->place         = best.first_word;
    return 1;
}

void vxs_stream_room_give_back(vxs_stream *s, uint32_t number)
{
    uint32_t at = 0;
    while (s->in_room[at] != number) at++;
    remove_from_room(s, at);
}
