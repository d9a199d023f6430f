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
    const sheet *left = &w->sheet_left[y0 / TILE_PX], *above = &w->sheet_above[x0 / TILE_PX];
    if (!left->known) return above->known ? *above : w->last_own;
    if (!above->known || which == 1) return *left;
    if (which == 2) return *above;
    return (sheet){.x = (left->x + above->x) >> 1, .y = (left->y + above->y) >> 1};
}

#endif
