/* Choice of wanted pages: those whose volume is near a focus, the nearest first.
 *
 * A page's volume contains all points that may need it: the map squares that have nodes in it, between the least and greatest
 * depth at which lookups read them, extended by the reach of the widest filter and its bias. It is stored as a box along the axes
 * of light space, in metres: (u, v, depth) for a directional light; coordinates relative to the light for a spot or point light,
 * where the volume of a square is a part of a pyramid and the box encloses it. If the squares of a page are far apart its box is
 * too large, so the page is only loaded earlier.
 * SPDX-License-Identifier: MIT */
#include <float.h>
#include <math.h>
#include <string.h>

#include "stream.h"
#include "vxs_space.h"

/* Texels that a lookup reaches beyond its point: half a filter, and the bias of that filter (vxs_voxel). */
static const double reach_px = VXS_FILTER_MAX / 2 + 1 + 1.2 * (VXS_FILTER_MAX + 1) / 2 + 1;

typedef struct extent {
    double min[3], max[3];
} extent;

/* Clamp to +-FAR_METRES; NaN becomes `otherwise`. Hostile matrices may give any number. */
static float held(double x, double otherwise)
{
    double limit = FAR_METRES;
    return (float)(x != x ? otherwise : x < -limit ? -limit : x > limit ? limit : x);
}

/* Depth range of a square: metres for a directional light, distance along the axis of the map for a spot or point light. Points
 * behind the map use its last voxel, so a range that ends there extends to FAR_METRES, or to the light's range. */
static void depth_range(const vxs_light *light, uint32_t bounds, double *nearest, double *farthest)
{
    uint32_t coarse = light->levels > 8 ? light->levels - 8 : 0, first = (bounds >> 16 & 255) << coarse;
    uint32_t end  = ((bounds >> 24) + 1) << coarse;
    int      last = end >= 1u << light->levels;
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        *nearest  = first * light->voxel_metres - reach_px * light->texel_metres;
        *farthest = last ? FAR_METRES : end * light->voxel_metres + reach_px * light->texel_metres;
        return;
    }
    *nearest  = light->near_metres * exp(first * light->voxel_metres) * (1 - fmin(1, reach_px * light->texel_metres));
    *farthest = last ? FAR_METRES : light->near_metres * exp(end * light->voxel_metres) * (1 + reach_px * light->texel_metres);
    if (light->range_metres > 0) *farthest = fmin(*farthest, light->range_metres);
}

/* Bounding box of a part of a pyramid, from its corners. */
static void punctual_extent(const vxs_light *light, uint32_t map, const double from[2], const double to[2], double nearest,
                            double farthest, extent *e)
{
    double middle = 0.5 * (double)(1u << light->levels);
    for (int k = 0; k < 3; k++) {
        e->min[k] = DBL_MAX;
        e->max[k] = -DBL_MAX;
    }
    for (int corner = 0; corner < 8; corner++) {
        double z = corner & 4 ? farthest : nearest;
        double u = (corner & 1 ? to[0] : from[0]) - middle, v = (corner & 2 ? to[1] : from[1]) - middle;
        double turned[3] = {u * light->texel_metres * z, v * light->texel_metres * z, z}, ls[3];
        vxs_ls_from_face(vxs_face_of_map(light, (int32_t)map), turned, ls);
        for (int k = 0; k < 3; k++) {
            e->min[k] = fmin(e->min[k], ls[k]);
            e->max[k] = fmax(e->max[k], ls[k]);
        }
    }
}

void vxs_stream_page_add_square(stream_page *page, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, uint32_t bounds)
{
    double from[2] = {256.0 * x - reach_px, 256.0 * y - reach_px}, nearest, farthest;
    double to[2]   = {256.0 * x + 256 + reach_px, 256.0 * y + 256 + reach_px};
    extent e;
    depth_range(light, bounds, &nearest, &farthest);
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        for (int k = 0; k < 2; k++) {
            e.min[k] = from[k] * light->texel_metres;
            e.max[k] = to[k] * light->texel_metres;
        }
        e.min[2] = nearest;
        e.max[2] = farthest;
    } else
        punctual_extent(light, map, from, to, nearest, farthest, &e);

    for (int k = 0; k < 3; k++) {
        float low = held(e.min[k], -FAR_METRES), high = held(e.max[k], FAR_METRES);
        if (low < page->min[k]) page->min[k] = low;
        if (high > page->max[k]) page->max[k] = high;
    }
}

/* A focus in the coordinates of page volumes. 0: the focus is invalid and requests nothing. */
static int focus_extent(const vxs_stream_focus *focus, const vxs_light *light, extent *e)
{
    for (int k = 0; k < 3; k++)
        if (!(isfinite(focus->min_ws[k]) && isfinite(focus->max_ws[k]) && focus->min_ws[k] <= focus->max_ws[k])) return 0;
    if (!(focus->radius_metres >= 0 && focus->weight >= 0) || !isfinite(focus->weight)) return 0;
    for (int k = 0; k < 3; k++) {
        const double *row   = light->ls_from_ws + 4 * k;
        double        scale = light->kind != VXS_LIGHT_KIND_DIRECTIONAL ? 1 : k < 2 ? light->texel_metres : light->voxel_metres;
        double        at = row[3], low = at, high = at;
        for (int axis = 0; axis < 3; axis++) {
            double a = row[axis] * focus->min_ws[axis], b = row[axis] * focus->max_ws[axis];
            low += fmin(a, b);
            high += fmax(a, b);
        }
        e->min[k] = low * scale;
        e->max[k] = high * scale;
    }
    return 1;
}

/* the nearest first: a binary heap of pages, by rank, then by number ----------------------------------------------------------- */

static int is_nearer(const vxs_stream *s, uint32_t a, uint32_t b)
{
    return s->pages[a].rank != s->pages[b].rank ? s->pages[a].rank < s->pages[b].rank : a < b;
}

static void sift_down(vxs_stream *s, uint32_t at, uint32_t count)
{
    uint32_t page = s->heap[at];
    for (uint32_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && is_nearer(s, s->heap[child + 1], s->heap[child])) child++;
        if (!is_nearer(s, s->heap[child], page)) break;
        s->heap[at] = s->heap[child];
    }
    s->heap[at] = page;
}

void vxs_stream_rank_pages(vxs_stream *s, const vxs_stream_focus *foci, uint32_t count)
{
    for (uint32_t n = 0; n < s->page_count; n++) s->pages[n].rank = FLT_MAX;
    for (uint32_t light = 0; light < s->light_count; light++)
        for (uint32_t n = 0; n < count; n++) {
            const stream_light *l = &s->lights[light];
            extent              e;
            if (!focus_extent(&foci[n], &s->baked[light].light, &e)) continue;
            double radius = foci[n].radius_metres > 0 ? foci[n].radius_metres : DBL_MAX,
                   weight = foci[n].weight > 0 ? foci[n].weight : 1;
            for (uint32_t i = l->first_page; i < l->first_page + l->page_count; i++) {
                /* distance in metres from the focus to the page; 0 when they overlap */
                double sum = 0;
                for (int k = 0; k < 3; k++) {
                    double gap = fmax(0, fmax(s->pages[i].min[k] - e.max[k], e.min[k] - s->pages[i].max[k]));
                    sum += gap * gap;
                }
                double distance = sqrt(sum);

                if (!(distance <= radius)) continue;
                float rank = held(distance / weight, FAR_METRES);
                if (rank < s->pages[i].rank) s->pages[i].rank = rank;
            }
        }
    s->wanted = s->heap_count = 0;
    for (uint32_t n = 0; n < s->page_count; n++) {
        stream_page *page = &s->pages[n];
        if (page->rank == FLT_MAX) continue;
        if (page->state == PAGE_HERE || page->state == PAGE_COMING) {
            /* Reduced, so that a page at equal distance, or a little nearer when the camera moves to and fro, does
             * not replace it. */
            float nearer = 0.75f * page->rank - 1;
            page->rank   = nearer > 0 ? nearer : 0;
        }
        s->heap[s->heap_count++] = n;
    }
    s->wanted = s->heap_count;
    for (uint32_t n = s->heap_count / 2; n-- > 0;) sift_down(s, n, s->heap_count);
}

int vxs_stream_next_nearest(vxs_stream *s, uint32_t *page)
{
    if (!s->heap_count) return 0;
    *page      = s->heap[0];
    s->heap[0] = s->heap[--s->heap_count];
    if (s->heap_count) sift_down(s, 0, s->heap_count);
    return 1;
}

/* places ----------------------------------------------------------------------------------------------------------------------- */

/* Choice of a page's place in the array of words: a gap in the room for pages, or the place of pages that are evicted.
 *
 *     room  | page 7 |    gap    | page 2 | page 11 |  gap  |         in_room: 7, 2, 11
 *
 * Pages differ in size and do not move. A place is a run of gaps and of pages that may be evicted: pages that are no longer
 * wanted, the least recently wanted first; and only where no such run is wide enough, pages that are farther than the new page. A
 * page that is being read or decoded is not evicted. */

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
    uint32_t            entry     = light->first_word + VXS_BLOCKS_FIRST_PAGE + (number - light->first_page);
    s->words[entry]               = there ? page->place - light->first_word : 0;
    s->changes[s->change_count++] = (vxs_stream_range){entry, 1};
    if (there) s->changes[s->change_count++] = (vxs_stream_range){page->place, page->word_count};
}

static void remove_from_room(vxs_stream *s, uint32_t at)
{
    memmove(s->in_room + at, s->in_room + at + 1, (--s->in_room_count - at) * sizeof *s->in_room);
}

int vxs_stream_room_alloc(vxs_stream *s, uint32_t number)
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

void vxs_stream_room_free(vxs_stream *s, uint32_t number)
{
    uint32_t at = 0;
    while (s->in_room[at] != number) at++;
    remove_from_room(s, at);
}
