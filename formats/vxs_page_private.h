/* Private-palette patterns.
 * Internal to vxs_page_*.c, which define PAGE_ENCODING. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_PRIVATE_H
#define VXS_PAGE_PRIVATE_H

#include "vxs_page_patterns.h"
#include "vxs_page_planes.h"

/* patterns of one plane, or of two planes: the nearer one, the farther one, or selected by a mask ------------------------------- */

enum { QUARTER = 64 /* a quarter voxel, in 1/256 voxel: unit of the least depth of a plane of a pattern */ };

/* Depths are relative to the base of the pattern. */
typedef struct private_planes {
    uint32_t kind;
    sheet    s[2];
    uint64_t mask; /* texels of the second plane, quadrant by quadrant */
} private_planes;

/* Base of a tile with a private-palette pattern. */
typedef struct private_base {
    int32_t  block, value; /* block: of the block, in the node; value: of the tile, relative to that */
    uint32_t far;
} private_base;

/* Index of texel (x, y), quadrant by quadrant. */
PAGE_INLINE uint32_t texel_at(uint32_t x, uint32_t y)
{
    return ((x >> 2) + 2 * (y >> 2)) * 16 + (y & 3) * 4 + (x & 3);
}

static private_planes read_private_planes(const uint32_t *words, uint32_t half)
{
    uint32_t       head = get_half(words, half), shift = head >> 8 & 15;
    private_planes p = {.kind = head >> 12};
    for (uint32_t n = 0; n < (p.kind == PRIVATE_PLANE ? 1u : 2u); n++) {
        plane    one   = {(int16_t)get_half(words, half + 1 + 2 * n), (int16_t)get_half(words, half + 2 + 2 * n), shift};
        uint32_t least = (n ? get_half(words, half + 5) << (head & 7) << 8 : 0) + (head >> (3 + 2 * n) & 3) * QUARTER;
        p.s[n]         = sheet_of(&one, least, TILE_PX, OF_PATTERN);
    }
    for (uint32_t n = 0; n < 4 && p.kind == PRIVATE_MASK; n++) p.mask |= (uint64_t)get_half(words, half + 6 + n) << 16 * n;
    return p;
}

/* Plane of texel (x, y): 0 or 1; with a mask the texel must be in the tile. */
PAGE_INLINE uint32_t which_plane(const private_planes *p, int32_t x, int32_t y)
{
    if (p->kind == PRIVATE_PLANE) return 0;
    if (p->kind == PRIVATE_MASK) return p->mask >> texel_at((uint32_t)x, (uint32_t)y) & 1;
    int32_t first = (int32_t)sheet_from(p->s[0], x, y).at >> 8, second = (int32_t)sheet_from(p->s[1], x, y).at >> 8;
    return p->kind == PRIVATE_NEARER ? second < first : second > first;
}

/* Predicted base of a tile: its planes meet the texels beside it. */
static int32_t meet_private(const walk *w, const private_planes *p, uint32_t x0, uint32_t y0)
{
    private_planes like = *p;
    int32_t        said[2 * TILE_PX], depth, slope = tile_slope(w, x0 / TILE_PX, y0 / TILE_PX);
    uint32_t       count = 0;
    if (like.kind == PRIVATE_MASK) like.kind = PRIVATE_PLANE; /* the mask has no texels beside the tile */
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
static int code_private_base(walk *w, private_base *o, const private_planes *p, uint32_t x0, uint32_t y0)
{
    int32_t least = least_border_depth(w, x0, y0, TILE_PX);
    int32_t like  = p ? (int16_t)(meet_private(w, p, x0, y0) - o->block) : least == INT16_MAX ? 0 : (int16_t)(least - o->block);
    o->value      = like + code_signed(&w->c, &w->odds->private_base[p ? p->kind == PRIVATE_PLANE ? 1 : 2 : 0], o->value - like);
    return o->far ? o->value > -DEPTH_END && o->value < DEPTH_END : o->value >= -PRIVATE_ZERO && o->value < PRIVATE_ZERO;
}

/* Whether a depth at a texel is nearer to the second plane. */
PAGE_INLINE uint8_t is_second(const private_planes *p, int32_t x, int32_t y, int32_t depth)
{
    int32_t first  = depth - ((int32_t)sheet_from(p->s[0], x, y).at >> 8),
            second = depth - ((int32_t)sheet_from(p->s[1], x, y).at >> 8);
    return (second < 0 ? -second : second) < (first < 0 ? -first : first);
}

/* The mask of texels on the second plane. Texels beside the tile count as on the plane that is nearer to their depth.
 * base  of the tile, in the node */
static int code_private_mask(walk *w, const private_planes *p, uint32_t from, int32_t base, uint32_t x0, uint32_t y0)
{
    around               o       = {0};
    int32_t              without = base - tile_slope(w, x0 / TILE_PX, y0 / TILE_PX), depth;
    _Alignas(16) uint8_t index[64];
    for (int32_t n = 0; n < TILE_PX; n++) {
        depth_above(w, x0 + (uint32_t)n, y0, &depth);
        o.above |= (uint64_t)is_second(p, n, -1, depth - without) << 8 * n;
        depth_left(w, x0, y0 + (uint32_t)n, &depth);
        o.left |= (uint64_t)is_second(p, -1, n, depth - without) << 8 * n;
    }
    o.corner = o.above & 255;
    o.right  = (uint32_t)(o.above >> 56);
    for (uint32_t z = 0; z < 64; z++) index[z] = source_half(w, from + z / 16) >> z % 16 & 1;
    if (!code_indices(w, o, 2, index)) return 0;
    for (uint32_t z = 0; z < 64; z++) put_half(w->words, w->half + 6 + z / 16, (uint32_t)index[z] << z % 16);
    return 1;
}

/* A new pattern.   from  half of the source where it starts;   base  NULL in the common pool, where it counts as 0 */
static int code_private_planes(walk *w, uint32_t kind, uint32_t from, private_base *base, uint32_t x0, uint32_t y0)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   half = w->half, head = source_half(w, from), two = kind != PRIVATE_PLANE;
    uint32_t   shift = code_nibble(c, &odds->private_plane[two].shift, head >> 8 & 15), far_shift = 0;
    uint32_t   quarters = code_nibble(c, &odds->quarters[two], head >> 3 & 15);
    if (!two && quarters > 3) return 0;
    if (shift > PLANE_SHIFT_MAX || private_halves[kind] > 2 * w->word_count - half) return 0;
    for (uint32_t n = 0; n <= two; n++) {
        plane p = {(int16_t)source_half(w, from + 1 + 2 * n), (int16_t)source_half(w, from + 2 + 2 * n), shift};
        if (!code_steps(w, &odds->private_plane[two + n], &p, steps_beside(w, x0, y0, two + n))) return 0;
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
    private_planes p = read_private_planes(w->words, half);
    if (base && !code_private_base(w, base, &p, x0, y0)) return 0;
    if (kind == PRIVATE_MASK && !code_private_mask(w, &p, from + 6, base ? base->block + base->value : 0, x0, y0)) return 0;
    w->half += private_halves[kind];
    return 1;
}

/* all kinds of patterns --------------------------------------------------------------------------------------------------------- */

/* Delta n of a private palette.   head  first half of the pattern;   half  where the deltas start */
static uint32_t private_delta(const uint32_t *words, uint32_t half, uint32_t head, uint32_t n)
{
    uint32_t kind = head >> 12, shift = head >> 8 & 15;
    if (kind == PRIVATE_BYTES) return get_byte(words, 2 * half + n) << shift;
    if (kind == PRIVATE_HALVES) return get_half(words, half + n) << shift;
    return (get_half(words, half + 2 * n) | get_half(words, half + 2 * n + 1) << 16) << shift;
}

/* Set the borders after an own tile.   base  of the tile, in the node */
static void draw_private(walk *w, uint32_t ref, int32_t base, uint32_t x0, uint32_t y0)
{
    const uint32_t *words = pool_of(w, ref);
    uint32_t        half = ref & (REF_COMMON - 1), head = get_half(words, half), kind = head >> 12;
    if (kind <= PRIVATE_WORDS) {
        int16_t  depth[DEPTHS_MAX];
        uint32_t depths = head & 0xff;
        depth[0]        = (int16_t)base;
        for (uint32_t n = 0; n + 1 < depths; n++) depth[n + 1] = (int16_t)(base + (int32_t)private_delta(words, half + 1, head, n));
        draw_pattern(w, border_of_ref(w, ref, half + 1 + private_delta_halves(kind, depths - 1), depths), depth, x0, y0);
        return;
    }
    if (kind >= PRIVATE_PLANE) {
        private_planes planes = read_private_planes(words, half);

        /* base is that of the tile, in the node */
        uint32_t without = (uint32_t)(base - tile_slope(w, x0 / TILE_PX, y0 / TILE_PX)) << 8;
        sheet   *above = &w->sheet_above[x0 / TILE_PX], *left = &w->sheet_left[y0 / TILE_PX];
        for (int32_t n = 0; n < TILE_PX; n++) {
            w->above[8 + x0 + (uint32_t)n] = (int16_t)(base + sheet_depth(planes.s[which_plane(&planes, n, 7)], n, 7));
            w->left[y0 + (uint32_t)n]      = (int16_t)(base + sheet_depth(planes.s[which_plane(&planes, 7, n)], 7, n));
        }
        *above = planes.s[which_plane(&planes, 4, 7)];
        *left  = planes.s[which_plane(&planes, 7, 4)];
        above->at += without;
        left->at += without;
        w->last_private              = *left;
        w->known_above[x0 / TILE_PX] = w->known_left[y0 / TILE_PX] = OF_PATTERN;

        return;
    }
    leave_no_sheet(w, x0, y0, TILE_PX);
    for (uint32_t n = 0; n < TILE_PX; n++) {
        uint32_t shift       = head >> 8 & 15;
        w->above[8 + x0 + n] = (int16_t)(base + (int32_t)(raw_depth(words, half, kind, texel_at(n, 7)) << shift));
        w->left[y0 + n]      = (int16_t)(base + (int32_t)(raw_depth(words, half, kind, texel_at(7, n)) << shift));
    }
}

/* A private palette and its pattern.   from  half of the source where it starts */
static int code_private_palette(walk *w, uint32_t kind, uint32_t from, int32_t base, uint32_t x0, uint32_t y0)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   head = source_half(w, from), shift = code_nibble(c, &odds->private_shift, head >> 8 & 15);
    uint32_t   depths = code_nibble(c, &odds->private_count, (head - 2) & 15) + 2, half = w->half, last = 0;
    uint32_t   halves = private_delta_halves(kind, depths - 1), end = kind == PRIVATE_BYTES    ? 1 << 8
                                                                      : kind == PRIVATE_HALVES ? 1 << 16
                                                                                               : DEPTH_END;
    int16_t    depth[DEPTHS_MAX] = {(int16_t)base};
    if (depths > DEPTHS_MAX || 1 + halves > 2 * w->word_count - half) return 0;
    put_half(w->words, half, head = kind << 12 | shift << 8 | depths);
    for (uint32_t n = 0; n + 1 < depths; n++) {
        uint32_t delta = 0;
        if (PAGE_ENCODING) {
            uint32_t at = from + 1 + (kind == PRIVATE_BYTES ? n / 2 : kind == PRIVATE_HALVES ? n : 2 * n);
            delta       = kind == PRIVATE_BYTES    ? source_half(w, at) >> 8 * (n & 1) & 255
                          : kind == PRIVATE_HALVES ? source_half(w, at)
                                                   : source_half(w, at) | source_half(w, at + 1) << 16;
            if (delta <= last || delta >= end) return 0;
        }
        delta = code_step(c, &odds->private_delta, odds->private_round, last, delta - last - 1);
        if (delta >= end - 1 - last || (uint64_t)(last + delta + 1) << shift >= DEPTH_END) return 0;
        last += delta + 1;
        depth[n + 1] = (int16_t)(base + (int32_t)(last << shift));
        if (kind == PRIVATE_BYTES)
            put_byte(w->words, 2 * half + 2 + n, last);
        else if (kind == PRIVATE_HALVES)
            put_half(w->words, half + 1 + n, last);
        else {
            put_half(w->words, half + 1 + 2 * n, last);
            put_half(w->words, half + 2 + 2 * n, last >> 16);
        }
    }
    w->half += 1 + halves;
    _Alignas(16) uint8_t index[64];
    if (PAGE_ENCODING && !read_source(w, from + 1 + halves, depths, index)) return 0;
    if (!code_image(w, depth, depths, x0, y0, index) || !put_pattern(w, index, depths)) return 0;
    keep_border(w, half, index);
    return 1;
}

/* Predicted depth of a texel of a raw pattern: from the texels on its left and above; at the border, from the texels beside
 * the tile.
 * d  element of [8][8] */
PAGE_INLINE int32_t raw_like(const walk *w, const uint32_t *d, uint32_t x, uint32_t y, int32_t base, uint32_t shift, uint32_t x0,
                             uint32_t y0)
{
    const int16_t *above = w->above + 8 + x0 + x, *left = w->left + y0 + y;
    if (x && y) return (int32_t)(d[-1] + d[-8] - d[-9]);
    if (x) return (int32_t)d[-1] + ((int16_t)(above[0] - above[-1]) >> shift);
    if (y) return (int32_t)d[-8] + ((int16_t)(left[0] - left[-1]) >> shift);
    return (int16_t)((left[0] < above[0] ? left[0] : above[0]) - base) >> shift;
}

/* 64 depths without a palette.   explicit_bases  1: the four bases of PRIVATE_NIBBLES are not the least depths of their
 * quadrants */
static int code_private_raw(walk *w, uint32_t kind, int explicit_bases, uint32_t from, int32_t base_depth, uint32_t x0, uint32_t y0)
{
    coder     *c    = &w->c;
    page_odds *odds = w->odds;
    uint32_t   half = w->half, shift = code_nibble(c, &odds->private_shift, source_half(w, from) >> 8 & 15);
    uint32_t   depth[8][8], base[4] = {~0u, ~0u, ~0u, ~0u}, last = 0;
    uint32_t   end = kind == PRIVATE_NIBBLES ? 255 + 16 : kind == PRIVATE_RAW1 ? 1 << 8 : kind == PRIVATE_RAW2 ? 1 << 16 : 1 << 24;
    if (private_halves[kind] > 2 * w->word_count - half) return 0;
    for (uint32_t y = 0; y < 8; y++)
        for (uint32_t x = 0; x < 8; x++) {
            uint32_t z = texel_at(x, y), *d = &depth[y][x];
            int32_t  like = raw_like(w, d, x, y, base_depth, shift, x0, y0);
            like          = like < 0 ? 0 : like >= (int32_t)end ? (int32_t)end - 1 : like;

            int32_t  off    = PAGE_ENCODING ? (int32_t)raw_depth(w->source, from, kind, z) - like : 0;
            uint32_t zigzag = off < 0 ? 2 * (uint32_t)-off - 1 : 2 * (uint32_t)off;
            uint32_t symbol = code_nibble(c, &odds->residual[x || y ? x && y : 2][last], zigzag < 15 ? zigzag : 15);
            zigzag          = symbol < 15 ? symbol : 15 + code_number(c, &odds->raw_far, zigzag - 15);
            if (zigzag >= 2u * DEPTH_END) return 0;
            last = (2 * last + zigzag + 1) / 4;
            last = last > 5 ? 5 : last;

            int32_t here = zigzag & 1 ? like - (int32_t)((zigzag + 1) / 2) : like + (int32_t)(zigzag / 2);
            if (here < 0 || here >= (int32_t)end || (uint64_t)here << shift >= DEPTH_END) return 0;
            *d = (uint32_t)here;
            if (base[z / 16] > *d) base[z / 16] = *d;
        }
    put_half(w->words, half, kind << 12 | shift << 8);
    for (uint32_t n = 0; n < 4 && kind == PRIVATE_NIBBLES; n++) {
        if (explicit_bases) base[n] = code_number(c, &odds->raw_base, source_half(w, from + 1 + n / 2) >> 8 * (n & 1) & 255);
        if (base[n] > 255) return 0;
        put_byte(w->words, 2 * half + 2 + n, base[n]);
    }
    for (uint32_t z = 0; z < 64; z++) {
        uint32_t d = depth[(z >> 5) * 4 + (z >> 2 & 3)][(z >> 4 & 1) * 4 + (z & 3)], byte = 2 * half + 2;
        if (kind == PRIVATE_NIBBLES) {
            d -= base[z / 16];
            if (d > 15) return 0;
            put_byte(w->words, byte + 4 + (z & 31), d << (z >> 5) * 4);
        } else if (kind == PRIVATE_RAW1)
            put_byte(w->words, byte + z, d);
        else if (kind == PRIVATE_RAW2)
            put_half(w->words, half + 1 + z, d);
        else
            for (uint32_t n = 0; n < 3; n++) put_byte(w->words, byte + 3 * z + n, d >> 8 * n);
    }
    w->half += private_halves[kind];
    return 1;
}

/* The base of a tile with a known pattern. */
static int code_base_of(walk *w, private_base *base, uint32_t ref, uint32_t x0, uint32_t y0)
{
    const uint32_t *words = pool_of(w, ref);
    uint32_t        half  = ref & (REF_COMMON - 1);
    if (get_half(words, half) >> 12 < PRIVATE_PLANE) return code_private_base(w, base, NULL, x0, y0);
    private_planes p = read_private_planes(words, half);
    return code_private_base(w, base, &p, x0, y0);
}

/* A new private-palette pattern.   base  of the tile; NULL in the common pool, where it counts as 0 */
static int code_private(walk *w, uint32_t from, private_base *base, uint32_t x0, uint32_t y0)
{
    uint32_t kind = source_half(w, from) >> 12;
    if (PAGE_ENCODING) {
        if (kind >= PRIVATE_KINDS) return 0;
        if (kind >= PRIVATE_NIBBLES && kind < PRIVATE_PLANE && from + private_halves[kind] > 2 * w->word_count) return 0;
        for (uint32_t c = 0, bases = kind == PRIVATE_NIBBLES; c < 4 && bases; c++) {
            uint32_t least = 0, first = get_byte(w->source, 2 * from + 2 + c);
            for (uint32_t z = 16 * c; z < 16 * c + 16; z++) least |= raw_depth(w->source, from, PRIVATE_NIBBLES, z) == first;
            if (!least) kind = PRIVATE_KINDS;
        }
    }
    uint32_t beside = (w->known_left[y0 / TILE_PX] != 0) + (w->known_above[x0 / TILE_PX] != 0);
    kind            = code_nibble(&w->c, &w->odds->private_kind[beside], kind);
    if (kind > PRIVATE_KINDS) return 0;
    if (kind >= PRIVATE_PLANE && kind < PRIVATE_KINDS) return code_private_planes(w, kind, from, base, x0, y0);
    if (base && !code_private_base(w, base, NULL, x0, y0)) return 0;
    int32_t depth = base ? base->block + base->value : 0;
    if (kind <= PRIVATE_WORDS) return code_private_palette(w, kind, from, depth, x0, y0);
    return kind == PRIVATE_KINDS ? code_private_raw(w, PRIVATE_NIBBLES, 1, from, depth, x0, y0)
                                 : code_private_raw(w, kind, 0, from, depth, x0, y0);
}

#endif
