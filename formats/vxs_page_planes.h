/* Planes of blocks, and of private-palette patterns. Slopes are predicted from the planes beside it; the depth is predicted
 * so that the plane meets its borders.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_PLANES_H
#define VXS_PAGE_PLANES_H

#include "vxs_page_borders.h"

enum { ZEROS_MAX = 8 /* greatest number of low zero bits that is coded */ };

/* A plane as stored: a and b, slopes across and down, in (1 << shift) / 256 voxel. */
typedef struct plane {
    int32_t  a, b;
    uint32_t shift;
} plane;

/* The plane in a square whose least depth is `least`, in 1/256 voxel.   known  OF_PATTERN or OF_BLOCK */
PAGE_INLINE sheet sheet_of(const plane *p, uint32_t least, int32_t side_px, uint32_t known)
{
    int32_t x = p->a * (1 << p->shift), y = p->b * (1 << p->shift), last = side_px - 1;
    return (sheet){x, y, least - (uint32_t)((x < 0 ? x * last : 0) + (y < 0 ? y * last : 0)), (uint8_t)p->shift, (uint8_t)known};
}

/* The same plane, with (x, y) as its first texel. */
PAGE_INLINE sheet sheet_from(sheet s, int32_t x, int32_t y)
{
    s.at += (uint32_t)(s.x * x + s.y * y);
    return s;
}

PAGE_INLINE int16_t sheet_depth(sheet s, int32_t x, int32_t y)
{
    return (int16_t)(sheet_from(s, x, y).at >> 8);
}

/* Depth that the slope of the node adds to a tile. */
PAGE_INLINE int32_t tile_slope(const walk *w, uint32_t tx, uint32_t ty)
{
    return slope_shift(w->slope_x, w->slope_y, (int32_t)tx, (int32_t)ty);
}

/* The median; 0 if count is 0. Sorts the array. */
static int32_t middle_of(int32_t *said, uint32_t count)
{
    for (uint32_t n = 1; n < count; n++) {
        int32_t  one = said[n];
        uint32_t to  = n;
        for (; to && said[to - 1] > one; to--) said[to] = said[to - 1];
        said[to] = one;
    }
    return count ? said[count / 2] : 0;
}

/* Depth of the texel above a square, or on its left, without the slope of the node; texels beyond the node have the slope of
 * the node's own tiles (open_borders). 0: never in shadow. */
PAGE_INLINE int depth_above(const walk *w, uint32_t x, uint32_t y, int32_t *depth)
{
    *depth = w->above[8 + x] - tile_slope(w, x / TILE_PX, y ? y / TILE_PX - 1 : 0);
    return w->above[8 + x] != (int16_t)NEVER;
}

PAGE_INLINE int depth_left(const walk *w, uint32_t x, uint32_t y, int32_t *depth)
{
    *depth = w->left[y] - tile_slope(w, x ? x / TILE_PX - 1 : 0, y / TILE_PX);
    return w->left[y] != (int16_t)NEVER;
}

/* Whether the depths above a tile, or on its left, are at most one voxel off its plane.   s  from texel (0, 0) of the tile */
static int fits_above(const walk *w, sheet s, uint32_t x0, uint32_t y0)
{
    int32_t depth, off;
    for (int32_t k = 0; k < TILE_PX; k++) {
        if (!depth_above(w, x0 + (uint32_t)k, y0, &depth)) return 0;
        off = (int16_t)(depth - sheet_depth(s, k, -1));
        if (off < -1 || off > 1) return 0;
    }
    return 1;
}

static int fits_left(const walk *w, sheet s, uint32_t x0, uint32_t y0)
{
    int32_t depth, off;
    for (int32_t k = 0; k < TILE_PX; k++) {
        if (!depth_left(w, x0, y0 + (uint32_t)k, &depth)) return 0;
        off = (int16_t)(depth - sheet_depth(s, -1, k));
        if (off < -1 || off > 1) return 0;
    }
    return 1;
}

/* Depth of texel (0, 0) of a block if its plane meets its neighbours.   s  only its slopes are used */
static uint32_t meet_block(const walk *w, const sheet *s, uint32_t x0, uint32_t y0)
{
    int32_t  said[2 * TILE_PX], depth;
    uint32_t count = 0;
    for (int32_t k = 2; k < BLOCK_PX; k += 4) {
        if (depth_above(w, x0 + k, y0, &depth)) said[count++] = depth * 256 + 128 - s->x * k + s->y;
        if (depth_left(w, x0, y0 + k, &depth)) said[count++] = depth * 256 + 128 - s->y * k + s->x;
    }
    return (uint32_t)middle_of(said, count);
}

/* Set the borders after a tile on the plane of a block.   s  from texel (0, 0) of the tile */
static void draw_sheet(walk *w, sheet s, uint32_t x0, uint32_t y0)
{
    int16_t *above = w->above + 8 + x0, *left = w->left + y0;
    int32_t  slope = tile_slope(w, x0 / TILE_PX, y0 / TILE_PX);
    for (int32_t n = 0; n < TILE_PX; n++) {
        above[n] = (int16_t)(sheet_depth(s, n, TILE_PX - 1) + slope);
        left[n]  = (int16_t)(sheet_depth(s, TILE_PX - 1, n) + slope);
    }
    w->sheet_above[x0 / TILE_PX] = w->sheet_left[y0 / TILE_PX] = s;
    w->known_above[x0 / TILE_PX] = w->known_left[y0 / TILE_PX] = s.known;
}

/* Slopes a and b, predicted by a plane with similar slopes; often they have zeros as low bits. */
static int code_steps(walk *w, plane_odds *odds, plane *p, sheet like)
{
    uint32_t zeros = 0;
    while (PAGE_ENCODING && zeros < ZEROS_MAX && !((p->a | p->b) >> zeros & 1)) zeros++;
    zeros = code_nibble(&w->c, &odds->zeros, zeros);
    if (zeros > ZEROS_MAX) return 0;
    uint32_t shift = p->shift + zeros, k = zeros / 4;
    int32_t  half = (1 << shift) / 2, a = (like.x + half) >> shift, b = (like.y + half) >> shift;
    a += code_signed(&w->c, &odds->a[k], (p->a >> zeros) - a);
    b += code_signed(&w->c, &odds->b[k], (p->b >> zeros) - b);
    if (a != (int16_t)a || b != (int16_t)b) return 0;
    p->a = a * (1 << zeros);
    p->b = b * (1 << zeros);
    return p->a == (int16_t)p->a && p->b == (int16_t)p->b;
}

/* Predicted slopes for a plane of a tile: from the planes on its left and above it, or the last one.
 * which  0: of a single plane; 1, 2: of the first or second of two planes */
static sheet steps_beside(const walk *w, uint32_t x0, uint32_t y0, uint32_t which)
{
    const sheet  *left = &w->sheet_left[y0 / TILE_PX], *above = &w->sheet_above[x0 / TILE_PX];
    const uint8_t known_above = w->known_above[x0 / TILE_PX];
    if (!w->known_left[y0 / TILE_PX]) return known_above ? *above : w->last_private;
    if (!known_above || which == 1) return *left;
    if (which == 2) return *above;
    return (sheet){.x = (left->x + above->x) >> 1, .y = (left->y + above->y) >> 1};
}

/* planes of blocks: whether one continues a neighbour's plane, its slopes, and its depth ---------------------------------------- */

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
        const uint32_t row = y0 / TILE_PX + (uint32_t)k, column = x0 / TILE_PX + (uint32_t)k;
        const uint8_t  left = w->known_left[row], above = w->known_above[column];
        if (left && left >= found.left.known) found.left = sheet_from(w->sheet_left[row], TILE_PX, -TILE_PX * k);
        if (above && above >= found.above.known) found.above = sheet_from(w->sheet_above[column], -TILE_PX * k, TILE_PX);
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

    /* Least depth of a plane: exactly the predicted one (JUST_AS), or the number of its low zero bits, and the other bits
     * relative to the prediction. */
    uint32_t like, zeros = 0;
    int      goes_on = meet_plane(w, &p->plane, &beside, x0, y0, &like);
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

/* Predicted base of a known block, from its plane. */
static int32_t base_by_plane(const walk *w, const block_plane *p, uint32_t x0, uint32_t y0)
{
    sheets_beside beside = sheets_of_block(w, x0, y0);
    uint32_t      least;
    meet_plane(w, &p->plane, &beside, x0, y0, &least);
    return (int32_t)(least - (uint32_t)p->c + 128) >> 8;
}

#endif
