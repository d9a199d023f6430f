/* The plane of a block: whether it continues a neighbour's plane, its slopes, and its depth.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_BLOCK_PLANES_H
#define VXS_PAGE_BLOCK_PLANES_H

#include "vxs_page_planes.h"

/* Number of tiles of a block on its plane. ON_ALL also means that the palette has one entry. */
enum { ON_NONE, ON_SOME, ON_ALL };

enum { LIKE_LEFT, LIKE_ABOVE, LIKE_LAST, LIKE_NONE };

enum { JUST_AS = 15 }; /* code in place of a number of zeros: the depth is exactly the predicted one */

typedef struct block_plane {
    uint32_t tiles; /* ON_* */
    plane    plane;
    uint32_t least; /* least depth in the node, in 1/256 voxel, modulo 2^28 */
    int32_t  c;     /* least minus the base of the block */
} block_plane;

PAGE_INLINE int32_t signed_28(uint32_t x)
{
    return (int32_t)(x << 4) >> 4;
}

/* The planes on the left of a block and above it, from texel (0, 0) of the block. Planes of blocks are preferred to planes
 * of patterns. */
typedef struct sheets_beside {
    sheet left, above;
} sheets_beside;

static sheets_beside sheets_of_block(const walk *w, uint32_t x0, uint32_t y0)
{
    sheets_beside found = {0};
    for (int32_t k = 3; k >= 0; k--) {
        const sheet *left = &w->sheet_left[y0 / TILE_PX + (uint32_t)k], *above = &w->sheet_above[x0 / TILE_PX + (uint32_t)k];
        if (left->known && left->known >= found.left.known) found.left = sheet_from(*left, TILE_PX, -TILE_PX * k);
        if (above->known && above->known >= found.above.known) found.above = sheet_from(*above, -TILE_PX * k, TILE_PX);
    }
    return found;
}

/* Whether a is known and has the slopes of b. */
PAGE_INLINE int same_steps(const sheet *a, const sheet *b)
{
    return a->known && a->x == b->x && a->y == b->y && a->shift == b->shift;
}

/* Predicted least depth of a plane: it continues the plane beside the block, or else meets the depths there. Returns whether
 * it continues one. */
static int meet_plane(const walk *w, const plane *p, const sheets_beside *beside, uint32_t x0, uint32_t y0, uint32_t *least)
{
    sheet        s       = sheet_of(p, 0, BLOCK_PX, OF_BLOCK);
    const sheet *goes_on = same_steps(&beside->left, &s) ? &beside->left : same_steps(&beside->above, &s) ? &beside->above : NULL;
    *least               = (goes_on ? goes_on->at : meet_block(w, &s, x0, y0)) - s.at;
    return goes_on != NULL;
}

/* Slopes of a plane. */
static int code_plane(walk *w, plane *p, const sheets_beside *beside)
{
    page_odds   *odds    = w->odds;
    const sheet *left    = beside->left.known ? &beside->left : &w->last_plane,
                *above   = beside->above.known ? &beside->above : &w->last_plane;
    const sheet *known[] = {left, above, &w->last_plane};
    sheet        s       = sheet_of(p, 0, BLOCK_PX, OF_BLOCK);
    uint32_t     like    = 0;
    while (PAGE_ENCODING && like < LIKE_NONE && !same_steps(known[like], &s)) like++;
    like = code_nibble(&w->c, &odds->plane_like[beside->left.known + 3 * beside->above.known], like);
    if (like < LIKE_NONE) {
        const sheet *k = known[like];
        *p             = (plane){k->x >> k->shift, k->y >> k->shift, k->shift};
        return 1;
    }
    s        = (sheet){.x = (left->x + above->x) >> 1, .y = (left->y + above->y) >> 1};
    p->shift = code_nibble(&w->c, &odds->block_plane.shift, p->shift);
    return like == LIKE_NONE && p->shift <= PLANE_SHIFT_MAX && code_steps(w, &odds->block_plane, p, s);
}

/* The plane of a record, without its least depth.
 * record  [4], or [2] without a plane */
static void read_block_plane(block_plane *p, const uint32_t *record)
{
    uint32_t shape = record[0], head = record[1];
    if (!(head & ~shape & 0xffff)) return;
    p->tiles = shape || head != 0xffff ? ON_SOME : ON_ALL;
    p->plane = (plane){(int16_t)record[2], (int16_t)(record[2] >> 16), record[3] & 15};
    p->c     = (int32_t)record[3] >> 4;
}

/* Least depth of a plane: exactly the predicted one (JUST_AS), or the number of its low zero bits, and the other bits
 * relative to the prediction. */
static int code_least(walk *w, block_plane *p, const sheets_beside *beside, uint32_t x0, uint32_t y0)
{
    uint32_t like, zeros = 0;
    int      goes_on = meet_plane(w, &p->plane, beside, x0, y0, &like);
    while (PAGE_ENCODING && zeros < ZEROS_MAX && !(p->least >> zeros & 1)) zeros++;
    if (PAGE_ENCODING && goes_on && !signed_28(p->least - like)) zeros = JUST_AS;
    zeros = code_nibble(&w->c, &w->odds->least_zeros[goes_on], zeros);
    if (zeros > ZEROS_MAX) {
        p->least = like;
        return zeros == JUST_AS;
    }
    /* its low bits */
    uint32_t shift = zeros < ZEROS_MAX ? zeros + 1 : ZEROS_MAX, low = zeros < ZEROS_MAX ? 1u << zeros : 0;
    like          = ((like - low + (1u << shift) / 2) >> shift << shift) + low;
    int32_t steps = signed_28(p->least - like) >> shift;
    p->least      = like + ((uint32_t)code_signed(&w->c, &w->odds->plane_least[goes_on][zeros / 4], steps) << shift);
    return 1;
}

/* The plane of a new block.   from  word of the source;   base  of the block, used only by the encoder */
static int code_block_plane(walk *w, block_plane *p, uint32_t from, uint32_t base, uint32_t x0, uint32_t y0)
{
    sheets_beside beside = sheets_of_block(w, x0, y0);
    if (PAGE_ENCODING) {
        read_block_plane(
            p, (uint32_t[]){source_word(w, from), source_word(w, from + 1), source_word(w, from + 2), source_word(w, from + 3)});
        p->least = (base << 8) + (uint32_t)p->c;
        if (p->plane.shift > PLANE_SHIFT_MAX) return 0;
    }
    p->tiles = code_nibble(&w->c, &w->odds->on_plane[beside.left.known + 3 * beside.above.known], p->tiles);
    if (p->tiles == ON_NONE) return 1;
    if (p->tiles > ON_ALL || !code_plane(w, &p->plane, &beside)) return 0;
    return code_least(w, p, &beside, x0, y0);
}

/* Predicted base of a known block, from its plane. */
static int32_t base_by_plane(const walk *w, const block_plane *p, uint32_t x0, uint32_t y0)
{
    sheets_beside beside = sheets_of_block(w, x0, y0);
    uint32_t      least;
    meet_plane(w, &p->plane, &beside, x0, y0, &least);
    return (int32_t)(least - (uint32_t)p->c + 128) >> 8;
}

#endif
