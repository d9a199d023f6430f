/* Patterns of one plane, or of two planes: the nearer one, the farther one, or selected by a mask.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_OWN_PLANES_H
#define VXS_PAGE_OWN_PLANES_H

#include "vxs_page_patterns.h"
#include "vxs_page_planes.h"

enum { QUARTER = 64 /* a quarter voxel, in 1/256 voxel: unit of the least depth of a plane of a pattern */ };

/* Depths are relative to the base of the pattern. */
typedef struct own_planes {
    uint32_t kind;
    sheet    s[2];
    uint64_t mask; /* texels of the second plane, quadrant by quadrant */
} own_planes;

/* Base of a tile with a private-palette pattern. */
typedef struct own_base {
    int32_t  block, value; /* block: of the block, in the node; value: of the tile, relative to that */
    uint32_t far;
} own_base;

/* Index of texel (x, y), quadrant by quadrant. */
PAGE_INLINE uint32_t texel_at(uint32_t x, uint32_t y)
{
    return ((x >> 2) + 2 * (y >> 2)) * 16 + (y & 3) * 4 + (x & 3);
}

static own_planes read_own_planes(const uint32_t *words, uint32_t half)
{
    uint32_t   head = get_half(words, half), shift = head >> 8 & 15;
    own_planes p = {.kind = head >> 12};
    for (uint32_t n = 0; n < (p.kind == OWN_PLANE ? 1u : 2u); n++) {
        plane    one   = {(int16_t)get_half(words, half + 1 + 2 * n), (int16_t)get_half(words, half + 2 + 2 * n), shift};
        uint32_t least = (n ? get_half(words, half + 5) << (head & 7) << 8 : 0) + (head >> (3 + 2 * n) & 3) * QUARTER;
        p.s[n]         = sheet_of(&one, least, TILE_PX, OF_PATTERN);
    }
    for (uint32_t n = 0; n < 4 && p.kind == OWN_MASK; n++) p.mask |= (uint64_t)get_half(words, half + 6 + n) << 16 * n;
    return p;
}

/* Plane of texel (x, y): 0 or 1; with a mask the texel must be in the tile. */
PAGE_INLINE uint32_t which_plane(const own_planes *p, int32_t x, int32_t y)
{
    if (p->kind == OWN_PLANE) return 0;
    if (p->kind == OWN_MASK) return p->mask >> texel_at((uint32_t)x, (uint32_t)y) & 1;
    int32_t first = (int32_t)sheet_from(p->s[0], x, y).at >> 8, second = (int32_t)sheet_from(p->s[1], x, y).at >> 8;
    return p->kind == OWN_NEARER ? second < first : second > first;
}

/* Set the borders after a tile.   base  of the tile, in the node */
static void draw_own_planes(walk *w, const own_planes *p, int32_t base, uint32_t x0, uint32_t y0)
{
    uint32_t without = (uint32_t)(base - tile_slope(w, x0 / TILE_PX, y0 / TILE_PX)) << 8;
    sheet   *above = &w->sheet_above[x0 / TILE_PX], *left = &w->sheet_left[y0 / TILE_PX];
    for (int32_t n = 0; n < TILE_PX; n++) {
        w->above[8 + x0 + (uint32_t)n] = (int16_t)(base + sheet_depth(p->s[which_plane(p, n, 7)], n, 7));
        w->left[y0 + (uint32_t)n]      = (int16_t)(base + sheet_depth(p->s[which_plane(p, 7, n)], 7, n));
    }
    *above = p->s[which_plane(p, 4, 7)];
    *left  = p->s[which_plane(p, 7, 4)];
    above->at += without;
    left->at += without;
    w->last_own = *left;
}

/* Predicted base of a tile: its planes meet the texels beside it. */
static int32_t meet_own(const walk *w, const own_planes *p, uint32_t x0, uint32_t y0)
{
    own_planes like = *p;
    int32_t    said[2 * TILE_PX], depth, slope = tile_slope(w, x0 / TILE_PX, y0 / TILE_PX);
    uint32_t   count = 0;
    if (like.kind == OWN_MASK) like.kind = OWN_PLANE; /* the mask has no texels beside the tile */
    for (uint32_t n = 1; n < TILE_PX; n += 2) {
        int32_t k = (int32_t)n;
        if (depth_above(w, x0 + n, y0, &depth))
            said[count++] = depth - ((int32_t)sheet_from(like.s[which_plane(&like, k, -1)], k, -1).at >> 8);
        if (depth_left(w, x0, y0 + n, &depth))
            said[count++] = depth - ((int32_t)sheet_from(like.s[which_plane(&like, -1, k)], -1, k).at >> 8);
    }
    return middle_of(said, count) + slope;
}

/* p  planes of the tile; NULL: none */
static int code_own_base(walk *w, own_base *o, const own_planes *p, uint32_t x0, uint32_t y0)
{
    int32_t least = least_border_depth(w, x0, y0, TILE_PX);
    int32_t like  = p ? (int16_t)(meet_own(w, p, x0, y0) - o->block) : least == INT16_MAX ? 0 : (int16_t)(least - o->block);
    o->value      = like + code_signed(&w->c, &w->odds->own_base[p ? p->kind == OWN_PLANE ? 1 : 2 : 0], o->value - like);
    return o->far ? o->value > -DEPTH_END && o->value < DEPTH_END : o->value >= -OWN_ZERO && o->value < OWN_ZERO;
}

/* Whether a depth at a texel is nearer to the second plane. */
PAGE_INLINE uint8_t is_second(const own_planes *p, int32_t x, int32_t y, int32_t depth)
{
    int32_t first  = depth - ((int32_t)sheet_from(p->s[0], x, y).at >> 8),
            second = depth - ((int32_t)sheet_from(p->s[1], x, y).at >> 8);
    return (second < 0 ? -second : second) < (first < 0 ? -first : first);
}

/* The mask of texels on the second plane. Texels beside the tile count as on the plane that is nearer to their depth.
 * base  of the tile, in the node */
static int code_own_mask(walk *w, const own_planes *p, uint32_t from, int32_t base, uint32_t x0, uint32_t y0)
{
    uint8_t              border[16] = {0}, left[8] = {0};
    int32_t              without = base - tile_slope(w, x0 / TILE_PX, y0 / TILE_PX), depth;
    _Alignas(16) uint8_t index[64];
    for (int32_t n = 0; n < TILE_PX; n++) {
        depth_above(w, x0 + (uint32_t)n, y0, &depth);
        border[2 + n] = is_second(p, n, -1, depth - without);
        depth_left(w, x0, y0 + (uint32_t)n, &depth);
        left[n] = is_second(p, -1, n, depth - without);
    }
    border[1]  = border[2];
    border[10] = border[9];
    for (uint32_t z = 0; z < 64; z++) index[z] = source_half(w, from + z / 16) >> z % 16 & 1;
    if (!code_indices(w, border, left, 2, index)) return 0;
    for (uint32_t z = 0; z < 64; z++) put_half(w->words, w->half + 6 + z / 16, (uint32_t)index[z] << z % 16);
    return 1;
}

/* A new pattern.   from  half of the source where it starts;   base  NULL in the common pool, where it counts as 0 */
static int code_own_planes(walk *w, uint32_t kind, uint32_t from, own_base *base, uint32_t x0, uint32_t y0)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   half = w->half, head = source_half(w, from), two = kind != OWN_PLANE;
    uint32_t   shift = code_nibble(c, &odds->own_plane[two].shift, head >> 8 & 15), far_shift = 0;
    uint32_t   quarters = code_nibble(c, &odds->quarters[two], head >> 3 & 15);
    if (!two && quarters > 3) return 0;
    if (shift > PLANE_SHIFT_MAX || own_halves[kind] > 2 * w->word_count - half) return 0;
    for (uint32_t n = 0; n <= two; n++) {
        plane p = {(int16_t)source_half(w, from + 1 + 2 * n), (int16_t)source_half(w, from + 2 + 2 * n), shift};
        if (!code_steps(w, &odds->own_plane[two + n], &p, steps_beside(w, x0, y0, two + n))) return 0;
        put_half(w->words, half + 1 + 2 * n, (uint32_t)p.a);
        put_half(w->words, half + 2 + 2 * n, (uint32_t)p.b);
    }
    if (two) {
        uint32_t far;
        far_shift = code_nibble(c, &odds->far_shift, head & 7);
        far       = code_number(c, &odds->far_plane, source_half(w, from + 5));
        if (far_shift > FAR_SHIFT_MAX || far > 0xffff) return 0;
        put_half(w->words, half + 5, far);
    }
    put_half(w->words, half, kind << 12 | shift << 8 | quarters << 3 | far_shift);
    own_planes p = read_own_planes(w->words, half);
    if (base && !code_own_base(w, base, &p, x0, y0)) return 0;
    if (kind == OWN_MASK && !code_own_mask(w, &p, from + 6, base ? base->block + base->value : 0, x0, y0)) return 0;
    w->half += own_halves[kind];
    return 1;
}

#endif
