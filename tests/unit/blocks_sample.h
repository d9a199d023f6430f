/* Palette blocks written by the book, for tests of lookups: random depths of maps, and words that agree. Nothing is made small;
 * instead every variant of the layout (formats/vxs_lookup_blocks.h) is chosen at random where the depths allow it. Patterns lie in
 * front of the block that uses them, blocks in front of their node.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCKS_SAMPLE_H
#define BLOCKS_SAMPLE_H

#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"

enum {
    BLOCKS_SQUARE_PX    = 256,
    BLOCKS_SQUARE_AREA  = BLOCKS_SQUARE_PX * BLOCKS_SQUARE_PX,
    BLOCKS_MAPS_MAX     = 6,
    BLOCKS_NEVER        = INT32_MAX, /* depth of a uniform block that is lit all along */
    BLOCKS_PALETTE_MAX  = 14,
    BLOCKS_SPARE_WORDS  = 4,
    BLOCKS_COMMON_MAX   = 1 << 17,
    BLOCKS_PAGE_FULL_AT = 24000, /* halves; a node has 110000 at most */
    BLOCKS_KINDS        = 11,    /* of private-palette patterns */
};

/* Halves, and words as two of them. */
typedef struct half_list {
    uint16_t *data;
    size_t    count, capacity;
} half_list;

/* The depths of a square of 256 x 256 texels, and what its entry says. */
typedef struct blocks_square {
    int32_t *depth; /* [BLOCKS_SQUARE_AREA], rows */
    uint32_t page, offset, base, min, max;
} blocks_square;

typedef struct blocks_sample {
    uint32_t       levels, map_count, squares_wide;
    int32_t       *map[BLOCKS_MAPS_MAX]; /* [squares_wide][squares_wide] a depth, or ~index of a square */
    blocks_square *squares;
    uint32_t       square_count;
    half_list     *pages, common;
    uint32_t       page_count;
    uint32_t      *words; /* with BLOCKS_SPARE_WORDS zeros behind */
    size_t         word_count;
    uint32_t       kinds[BLOCKS_KINDS], widths[3], states[4], images, planes, far, wide; /* how many of each variant there are */
} blocks_sample;

static inline void *blocks_alloc(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) abort();
    return memory;
}

static inline void put_half(half_list *list, uint32_t half)
{
    if (list->count == list->capacity) {
        list->capacity = 2 * list->capacity + 64;
        list->data     = realloc(list->data, list->capacity * sizeof *list->data);
        if (!list->data) abort();
    }
    list->data[list->count++] = (uint16_t)half;
}

static inline void put_word(half_list *list, uint32_t word)
{
    put_half(list, word);
    put_half(list, word >> 16);
}

/* Bytes, padded to a half. */
static inline void put_bytes(half_list *list, const uint8_t *bytes, uint32_t count)
{
    for (uint32_t n = 0; n < count; n += 2) put_half(list, bytes[n] | (uint32_t)(n + 1 < count ? bytes[n + 1] : 0) << 8);
}

static inline void pad_to_word(half_list *list)
{
    if (list->count & 1) put_half(list, 0);
}

/* sets of depths ------------------------------------------------------------------------------------------------------------------- */

typedef struct depth_set {
    int32_t  depth[65]; /* ascending: of a tile, and a base */
    uint32_t count;
} depth_set;

static inline void depth_set_add(depth_set *set, int32_t depth)
{
    uint32_t at = 0;
    while (at < set->count && set->depth[at] < depth) at++;
    if (at < set->count && set->depth[at] == depth) return;
    memmove(set->depth + at + 1, set->depth + at, (set->count++ - at) * sizeof *set->depth);
    set->depth[at] = depth;
}

static inline uint32_t depth_set_index(const depth_set *set, int32_t depth)
{
    uint32_t at = 0;
    while (set->depth[at] != depth) at++;
    return at;
}

/* 1 when `set` has room for all of a tile's depths, which are added; 0: it stays as it is. */
static inline int depth_set_join(depth_set *set, const int32_t *depths)
{
    depth_set all = *set;
    for (int z = 0; z < 64; z++) {
        depth_set_add(&all, depths[z]);
        if (all.count > BLOCKS_PALETTE_MAX) return 0;
    }
    *set = all;
    return 1;
}

/* A shift that loses nothing of some numbers: any, mostly the greatest. */
static inline uint32_t random_shift(rng *r, const int32_t *numbers, uint32_t count)
{
    uint32_t bits = 1u << 15, shift = 0;
    for (uint32_t n = 0; n < count; n++) bits |= (uint32_t)numbers[n];
    while (!(bits >> shift & 1)) shift++;
    return rng_below(r, 4) ? shift : rng_below(r, shift + 1);
}

/* How deltas are kept: width 0, 1, 2 as in the layout, any that fits. */
static inline uint32_t random_width(rng *r, int32_t greatest, uint32_t *shift)
{
    uint32_t least = greatest >> *shift < 256 ? 0 : greatest >> *shift < 65536 ? 1 : 2;
    uint32_t width = rng_below(r, 4) ? least : least + rng_below(r, 3 - least);
    if (width == 2) *shift = 0;
    return width;
}

static inline void put_deltas(half_list *list, const depth_set *set, uint32_t width, uint32_t shift)
{
    uint8_t bytes[64];
    for (uint32_t n = 1; n < set->count; n++) {
        uint32_t delta = (uint32_t)(set->depth[n] - set->depth[0]) >> shift;
        bytes[n - 1]   = (uint8_t)delta;
        if (width == 1) put_half(list, delta);
        if (width == 2) put_word(list, delta);
    }
    if (!width) put_bytes(list, bytes, set->count - 1);
}

/* planes, formats/vxs.md sections 13.2 and 13.3: what they say of depths, at any texel -------------------------------------------------- */

typedef struct plane_slopes {
    int32_t across, down; /* 16 bits each */
} plane_slopes;

/* Of a square of last + 1 texels. */
static inline int64_t slopes_at(plane_slopes s, int32_t last, int32_t x, int32_t y)
{
    return (int64_t)s.across * (s.across < 0 ? x - last : x) + (int64_t)s.down * (s.down < 0 ? y - last : y);
}

/* The plane of a block, of a map's depths. */
typedef struct block_plane {
    plane_slopes slopes;
    uint32_t     shift, tiles; /* a bit for each tile that is on it */
    int64_t      depth;        /* 1/256 voxel */
} block_plane;

static inline int32_t block_plane_at(const block_plane *p, int32_t x, int32_t y)
{
    return (int32_t)((p->depth + slopes_at(p->slopes, 31, x, y) * ((int64_t)1 << p->shift)) >> 8);
}

/* A tile's pattern of one plane or two. */
typedef struct tile_planes {
    uint32_t     kind, shift; /* kind 0: the tile has none */
    plane_slopes slopes[2];
    uint32_t     quarters[2];          /* of a voxel, that each is deeper */
    uint32_t     deeper, deeper_shift; /* the second is, in voxels */
    uint64_t     of_second;
    int32_t      base; /* a depth of the map, without the slope of the node */
} tile_planes;

static inline int32_t tile_planes_at(const tile_planes *p, int32_t x, int32_t y)
{
    int64_t  first  = (64 * p->quarters[0] + (slopes_at(p->slopes[0], 7, x, y) << p->shift)) / 256;
    int64_t  second = (64 * p->quarters[1] + (slopes_at(p->slopes[1], 7, x, y) << p->shift)) / 256;
    uint32_t z      = (uint32_t)(16 * (x / 4 + 2 * (y / 4)) + 4 * (y % 4) + x % 4);
    second += (int64_t)p->deeper << p->deeper_shift;
    switch (p->kind) {
    case 7: return (int32_t)first;
    case 8: return (int32_t)(first < second ? first : second);
    case 9: return (int32_t)(first > second ? first : second);
    default: return (int32_t)(p->of_second >> z & 1 ? second : first);
    }
}

/* Those of a square: of blocks and tiles, rows. */
typedef struct square_planes {
    block_plane block[64];
    tile_planes tile[1024];
} square_planes;

static inline plane_slopes random_slopes(rng *r)
{
    static const int32_t steeps[] = {3, 40, 300, 4000, 32767};
    int32_t              steep    = steeps[rng_below(r, 5)];
    plane_slopes         s        = {rng_between(r, -steep - 1, steep), rng_between(r, -steep - 1, steep)};
    if (!rng_below(r, 6)) *(rng_below(r, 2) ? &s.across : &s.down) = 0;
    return s;
}

/* near  its first depth, or one up to `most` voxels behind it */
static inline block_plane random_block_plane(rng *r, int32_t near, int32_t most)
{
    block_plane p    = {.slopes = random_slopes(r), .shift = rng_below(r, 2) ? rng_below(r, 9) : 0};
    int32_t     last = block_plane_at(&p, p.slopes.across < 0 ? 0 : 31, p.slopes.down < 0 ? 0 : 31);
    p.tiles          = rng_below(r, 2) ? 0xffff : rng_u32(r) & 0xffff;
    p.depth          = 256 * (int64_t)near + rng_between(r, 0, 255);
    if (rng_below(r, 2)) p.depth -= 256 * rng_between(r, 0, last < most ? last : most);
    return p;
}

static inline tile_planes random_tile_planes(rng *r, int32_t base)
{
    static const uint32_t deepers[] = {2, 20, 300, 65535};
    tile_planes           p         = {.kind = 7 + rng_below(r, 4), .base = base};
    p.shift                         = rng_below(r, 2) ? rng_below(r, 9) : 0;
    p.slopes[0]                     = random_slopes(r);
    p.quarters[0]                   = rng_below(r, 4);
    if (p.kind == 7) return p;
    p.quarters[1]  = rng_below(r, 4);
    p.slopes[1]    = random_slopes(r);
    p.deeper       = rng_below(r, deepers[rng_below(r, 4)] + 1);
    p.deeper_shift = rng_below(r, 2) ? rng_below(r, 6) : 0;
    p.of_second    = (uint64_t)rng_u32(r) << 32 | rng_u32(r);
    return p;
}

/* patterns ------------------------------------------------------------------------------------------------------------------------- */

/* A nibble for each texel: z < 32 in the low half of byte z, others in the high half of byte z - 32. */
static inline void put_nibbles(half_list *list, const uint8_t *nibble)
{
    uint8_t bytes[32];
    for (int z = 0; z < 32; z++) bytes[z] = (uint8_t)(nibble[z] | nibble[z + 32] << 4);
    put_bytes(list, bytes, 32);
}

/* index  [64] of each texel's depth, of p */
static inline void put_pattern(blocks_sample *s, rng *r, half_list *list, const uint8_t *index, uint32_t p)
{
    uint8_t   states[16] = {0};
    half_list quadrants  = {0};
    if (!rng_below(r, 3)) {
        s->images++;
        put_half(list, 0xff);
        put_nibbles(list, index);
        return;
    }
    for (uint32_t c = 0; c < 4; c++) {
        int32_t last = -1;
        for (uint32_t n = 0; n + 1 < p; n++) {
            int32_t bits = 0;
            for (uint32_t z = 0; z < 16; z++) bits |= (index[16 * c + z] <= n) << z;
            uint32_t state = bits == 0 ? 0 : bits == 0xffff ? 1 : bits == last && rng_below(r, 8) ? 3 : 2;
            if (state < 2 && !rng_below(r, 8)) state = 2; /* a half that stores it */
            if (state == 2) put_half(&quadrants, (uint32_t)(last = bits));
            states[n] |= (uint8_t)(state << 2 * c);
            s->states[state]++;
        }
    }
    put_bytes(list, states, p - 1);
    for (size_t n = 0; n < quadrants.count; n++) put_half(list, quadrants.data[n]);
    free(quadrants.data);
}

/* Depths of a tile, [64], none of them below `base`, as a pattern with depths of its own. */
static inline void put_private(blocks_sample *s, rng *r, half_list *list, const int32_t *depths, int32_t base)
{
    depth_set set = {{base}, 1};
    int32_t   up[64], greatest = 0;
    uint8_t   index[64], nibble[64], quadrant[4], bytes[3 * 64];
    for (int z = 0; z < 64; z++) {
        depth_set_add(&set, depths[z]);
        up[z]    = depths[z] - base;
        greatest = up[z] > greatest ? up[z] : greatest;
    }
    uint32_t shift = random_shift(r, up, 64), least = greatest >> shift < 256 ? 4 : greatest >> shift < 65536 ? 5 : 6;
    uint32_t kind = rng_below(r, 3) ? least : least + rng_below(r, 7 - least);

    int flat = 1; /* every quadrant within 15 of its least */
    for (uint32_t c = 0; c < 4; c++) {
        int32_t low = INT32_MAX, high = 0;
        for (uint32_t z = 16 * c; z < 16 * c + 16; z++) {
            low  = up[z] >> shift < low ? up[z] >> shift : low;
            high = up[z] >> shift > high ? up[z] >> shift : high;
        }
        flat &= low < 256 && high - low < 16;
        quadrant[c] = (uint8_t)low;
        for (uint32_t z = 16 * c; z < 16 * c + 16; z++) nibble[z] = (uint8_t)((up[z] >> shift) - low);
    }
    if (flat && rng_below(r, 2)) kind = 3;
    if (set.count >= 2 && set.count <= 16 && rng_below(r, 2)) kind = random_width(r, greatest, &shift);

    s->kinds[kind]++;
    put_half(list, kind << 12 | shift << 8 | (kind < 3 ? set.count : 0));
    if (kind < 3) {
        put_deltas(list, &set, kind, shift);
        for (int z = 0; z < 64; z++) index[z] = (uint8_t)depth_set_index(&set, depths[z]);
        put_pattern(s, r, list, index, set.count);
    } else if (kind == 3) {
        put_bytes(list, quadrant, 4);
        put_nibbles(list, nibble);
    } else {
        uint32_t size = kind - 3;
        for (uint32_t z = 0; z < 64; z++)
            for (uint32_t b = 0; b < size; b++) bytes[size * z + b] = (uint8_t)(up[z] >> shift >> 8 * b);
        put_bytes(list, bytes, 64 * size);
    }
}

static inline void put_slopes(half_list *list, plane_slopes s)
{
    put_half(list, (uint32_t)s.across);
    put_half(list, (uint32_t)s.down);
}

static inline void put_planes(blocks_sample *s, half_list *list, const tile_planes *p)
{
    s->kinds[p->kind]++;
    put_half(list, p->kind << 12 | p->shift << 8 | p->quarters[1] << 5 | p->quarters[0] << 3 | p->deeper_shift);
    put_slopes(list, p->slopes[0]);
    if (p->kind == 7) return;
    put_slopes(list, p->slopes[1]);
    put_half(list, p->deeper);
    for (int n = 0; n < 4 && p->kind == 10; n++) put_half(list, (uint32_t)(p->of_second >> 16 * n));
}

/* blocks --------------------------------------------------------------------------------------------------------------------------- */

typedef struct block_plan {
    int32_t            depths[16][64]; /* of texels, relative to the node, slope added */
    int32_t            least[16];
    depth_set          palette;
    uint32_t           uniform, own; /* a bit for each tile */
    int                far;
    int32_t            private_base[16]; /* relative to the block */
    block_plane        plane;            /* the block has: of depths relative to the node, without its slope */
    const tile_planes *planes[16];       /* NULL, or the tile has those */
    int32_t            base[16];         /* of those, relative to the node, slope added */
} block_plan;

static inline int32_t held_depth(int32_t depth, int32_t last)
{
    return depth < 0 ? 0 : depth < last ? depth : last;
}

static inline void plan_tiles(block_plan *b, rng *r)
{
    uint32_t planes = b->plane.tiles;
    for (int t = 0; t < 16; t++) {
        int32_t low = b->depths[t][0], high = low;
        for (int z = 1; z < 64; z++) {
            low  = b->depths[t][z] < low ? b->depths[t][z] : low;
            high = b->depths[t][z] > high ? b->depths[t][z] : high;
        }
        b->least[t] = low;
        if (b->planes[t])
            b->own |= 1u << t;
        else if (!(planes >> t & 1))
            b->uniform |= (uint32_t)(low == high) << t;
    }
    planes |= b->own;
    for (int t = 0; t < 16; t++)
        if ((b->uniform >> t & 1) && (!rng_below(r, 16) || !depth_set_join(&b->palette, b->depths[t]))) b->own |= 1u << t;
    for (int t = 0; t < 16; t++)
        if (!((b->uniform | planes) >> t & 1) && (!rng_below(r, 5) || !depth_set_join(&b->palette, b->depths[t])))
            b->own |= 1u << t;
    b->uniform &= ~b->own;
    if (!b->palette.count || (b->palette.count < BLOCKS_PALETTE_MAX && !rng_below(r, 8))) /* an unused entry */
        depth_set_add(&b->palette, rng_between(r, 0, held_depth(b->least[rng_below(r, 16)], 1 << 18)));

    b->far = !rng_below(r, 8);
    for (int t = 0; t < 16; t++) {
        int32_t least      = b->planes[t] ? b->base[t] : b->least[t] - (int32_t)(rng_below(r, 4) ? 0 : rng_below(r, 20));
        b->private_base[t] = least - b->palette.depth[0];
        b->far |= (b->own >> t & 1) && (b->private_base[t] < -8192 || b->private_base[t] > 8191);
    }
}

/* Write a tile's pattern, and return the tile's word. */
static inline uint32_t put_tile(blocks_sample *s, rng *r, const block_plan *b, int t, half_list *page)
{
    int        common = !rng_below(r, 4) && s->common.count + 100 < BLOCKS_COMMON_MAX;
    half_list *pool   = common ? &s->common : page;
    uint32_t   at     = (uint32_t)pool->count | (common ? 0x20000u : 0);
    if (b->own >> t & 1) {
        if (b->planes[t])
            put_planes(s, pool, b->planes[t]);
        else
            put_private(s, r, pool, b->depths[t], b->palette.depth[0] + b->private_base[t]);
        return at << 14 | (b->far ? 0 : (uint32_t)(b->private_base[t] + 8192));
    }
    uint32_t used = 0;
    uint8_t  index[64];
    for (int z = 0; z < 64; z++) used |= 1u << depth_set_index(&b->palette, b->depths[t][z]);
    if (!rng_below(r, 8)) used |= rng_u32(r) & ((1u << b->palette.count) - 1);
    for (int z = 0; z < 64; z++) {
        uint32_t before = used & ((1u << depth_set_index(&b->palette, b->depths[t][z])) - 1);
        for (index[z] = 0; before; before &= before - 1) index[z]++;
    }
    uint32_t p = 0;
    for (uint32_t n = 0; n < BLOCKS_PALETTE_MAX; n++) p += used >> n & 1;
    put_pattern(s, r, pool, index, p);
    return at << 14 | used;
}

/* The plane of a block whose base is that. */
static inline void put_plane(blocks_sample *s, half_list *page, const block_plane *p, int32_t base)
{
    int64_t depth = p->depth - 256 * (int64_t)base;
    if (depth < -(1 << 27) || depth >= 1 << 27) abort();
    s->planes++;
    put_slopes(page, p->slopes);
    put_word(page, p->shift | (uint32_t)depth << 4);
}

/* Write a block with its patterns. Returns the word of the page where it starts. */
static inline uint32_t put_block(blocks_sample *s, rng *r, block_plan *b, half_list *page)
{
    uint32_t  words[16], planes = b->plane.tiles, mixed = 0xffff & ~(b->uniform | planes), fresh = 0, nibbles = 0;
    uint8_t   bytes[128] = {0};
    depth_set last       = {{-1}, 0};
    for (int t = 0; t < 16; t++)
        if (mixed >> t & 1) words[t] = put_tile(s, r, b, t, page);
    pad_to_word(page);

    uint32_t       at = (uint32_t)page->count / 2, size = 0;
    const int32_t *from = b->palette.depth;
    int32_t        deltas[BLOCKS_PALETTE_MAX];
    for (uint32_t n = 0; n < b->palette.count; n++) deltas[n] = from[n] - from[0];
    uint32_t shift = random_shift(r, deltas, b->palette.count), width = random_width(r, deltas[b->palette.count - 1], &shift);
    s->widths[width]++;
    s->far += (uint32_t)b->far;
    for (uint32_t n = 1; n < b->palette.count; n++)
        for (uint32_t byte = 0; byte < 1u << width; byte++) bytes[size++] = (uint8_t)(deltas[n] >> shift >> 8 * byte);
    for (int t = 0; t < 16; t++) {
        if ((mixed | planes) >> t & 1 || last.depth[0] == b->depths[t][0]) continue;
        last.depth[0] = b->depths[t][0];
        fresh |= 1u << t;
        bytes[size + nibbles / 2] |= (uint8_t)(depth_set_index(&b->palette, last.depth[0]) << 4 * (nibbles & 1));
        nibbles++;
    }
    put_word(page, mixed | fresh << 16);
    put_word(page, b->own | planes | (b->palette.count - 1) << 16 | shift << 20 | width << 24 | (uint32_t)b->far << 26);
    if (planes) put_plane(s, page, &b->plane, from[0]);
    for (int t = 0; t < 16; t++)
        if (mixed >> t & 1) put_word(page, words[t]);
    put_bytes(page, bytes, size + (nibbles + 1) / 2);
    pad_to_word(page);
    for (int t = 0; t < 16; t++)
        if (b->far && (b->own >> t & 1)) put_word(page, (uint32_t)b->private_base[t]);
    return at;
}

/* nodes ---------------------------------------------------------------------------------------------------------------------------- */

typedef struct node_slope {
    int32_t x, y; /* 1/256 voxel a tile */
} node_slope;

static inline int32_t slope_at(node_slope n, int32_t x, int32_t y)
{
    return ((n.x < 0 ? n.x * (x - 31) : n.x * x) + (n.y < 0 ? n.y * (y - 31) : n.y * y)) >> 8;
}

/* Block c of a square as the node sees it. Returns its depth when it has one, BLOCKS_NEVER among them; else -1. */
static inline int32_t plan_block(const blocks_sample *s, block_plan *b, const int32_t *depth, const square_planes *planes, int c,
                                 node_slope n, int32_t base)
{
    int32_t first = -1;
    int     alike = 1, never = 1, plain = 1;
    memset(b, 0, sizeof *b);
    b->plane = planes->block[c];
    b->plane.depth -= 256 * (int64_t)base;
    for (int t = 0; t < 16; t++) {
        int32_t            x = c % 8 * 4 + t % 4, y = c / 8 * 4 + t / 4;
        const tile_planes *own = &planes->tile[32 * y + x];
        if (own->kind) b->planes[t] = own;
        b->base[t] = own->base - base + slope_at(n, x, y);
        plain &= !own->kind && !(b->plane.tiles >> t & 1);
    }
    for (int y = 0; y < 32; y++)
        for (int x = 0; x < 32; x++) {
            int     i = c % 8 * 32 + x, j = c / 8 * 32 + y;
            int32_t d = depth[BLOCKS_SQUARE_PX * j + i], here = d - base + slope_at(n, i / 8, j / 8);
            b->depths[x / 8 + y / 8 * 4][(x / 4 % 2 + y / 4 % 2 * 2) * 16 + y % 4 * 4 + x % 4] = here;
            if (first < 0) first = here;
            alike &= here == first;
            never &= d >= 1 << s->levels;
        }
    return !plain ? -1 : never ? BLOCKS_NEVER : alike ? first : -1;
}

/* Write a square as a node. Returns the word of the page where it starts. */
static inline uint32_t put_node(blocks_sample *s, rng *r, const int32_t *depth, const square_planes *planes, node_slope n,
                                int32_t base, half_list *page)
{
    uint64_t mixed = 0, fresh  = 0;
    uint32_t refs[64], wide    = !rng_below(r, 4);
    int32_t  numbers[64], last = -1;
    for (int c = 0; c < 64; c++) {
        static block_plan b;
        numbers[c] = plan_block(s, &b, depth, planes, c, n, base);
        if (numbers[c] >= 0 && rng_below(r, 16)) {
            if (numbers[c] != last) fresh |= (uint64_t)1 << c;
            last = numbers[c];
            wide |= last >= 0xffff && last != BLOCKS_NEVER;
            continue;
        }
        mixed |= (uint64_t)1 << c;
        plan_tiles(&b, r);
        refs[c]    = put_block(s, r, &b, page);
        numbers[c] = b.palette.depth[0];
        wide |= numbers[c] > 0xffff;
    }
    uint32_t at = (uint32_t)page->count / 2;
    s->wide += wide;
    for (int h = 0; h < 4; h++) put_half(page, (uint32_t)(mixed >> 16 * h));
    for (int h = 0; h < 4; h++) put_half(page, (uint32_t)(fresh >> 16 * h));
    put_half(page, (uint32_t)n.x);
    put_half(page, (uint32_t)n.y);
    put_half(page, wide);
    for (int c = 0; c < 64; c++)
        if (mixed >> c & 1) put_half(page, refs[c]);
    for (int of_fresh = 0; of_fresh < 2; of_fresh++)
        for (int c = 0; c < 64; c++) {
            if (!((of_fresh ? fresh : mixed) >> c & 1)) continue;
            uint32_t number = numbers[c] == BLOCKS_NEVER ? 0xffffffffu : (uint32_t)numbers[c];
            put_half(page, number);
            if (wide) put_half(page, number >> 16);
        }
    pad_to_word(page);
    return at;
}

/* random depths -------------------------------------------------------------------------------------------------------------------- */

static inline node_slope random_slope(rng *r)
{
    int32_t    steep = rng_below(r, 6) ? 40 : rng_below(r, 2) ? 2000 : 32767;
    node_slope n     = {rng_between(r, -steep, steep), rng_between(r, -steep, steep)};
    return rng_below(r, 3) ? n : (node_slope){0, 0};
}

/* Depths of a tile: one, two sides of a line, a few, or as many as there are texels. `level` is where its block is. */
static inline void random_tile(rng *r, int32_t *depth, const int32_t *levels, uint32_t level_count, int32_t side)
{
    static const int32_t ranges[] = {3, 15, 100, 255, 4000, 70000, 1 << 18};
    uint32_t             kind = rng_below(r, 8), few = 2 + rng_below(r, 5);
    int32_t  x = rng_between(r, -8, 8), y = rng_between(r, -8, 8), at = rng_between(r, -30, 90), range = ranges[rng_below(r, 7)];
    int32_t  noise_shift = (int32_t)rng_below(r, 5), from = levels[rng_below(r, level_count)];
    uint32_t picked = rng_below(r, level_count);
    for (int z = 0; z < 64; z++) {
        int32_t *d = depth + BLOCKS_SQUARE_PX * (z / 8) + z % 8;
        if (kind < 3)
            *d = levels[picked];
        else if (kind < 5)
            *d = levels[(picked + (z % 8 * x + z / 8 * y < at)) % level_count];
        else if (kind < 7)
            *d = levels[(picked + rng_below(r, few)) % level_count];
        else
            *d = from + (rng_between(r, 0, range < side ? range : side) >> noise_shift << noise_shift);
    }
}

/* Depths of a square in [0, side]: blocks of a few levels, slanted by -n. Those on planes may be anything.
 * planes  [out] zeroed */
static inline void random_square(rng *r, int32_t *depth, square_planes *planes, node_slope n, int32_t side)
{
    int32_t ground = (int32_t)rng_below(r, (uint32_t)side + 1), step = 1 << rng_below(r, 10);
    for (int c = 0; c < 64; c++) {
        int32_t  levels[20];
        uint32_t kind = rng_below(r, 10), count = kind < 4 ? 1 : 1 + rng_below(r, rng_below(r, 2) ? 4 : 20);
        for (uint32_t l = 0; l < count; l++) levels[l] = count == 1 ? ground : ground + step * rng_between(r, -12, 12);
        if (kind == 9) levels[0] = 2 * side + 4096;
        block_plane *plane = &planes->block[c];
        if (!rng_below(r, 4)) *plane = random_block_plane(r, levels[0], side / 2);
        for (int t = 0; t < 16; t++) {
            int32_t      x = c % 8 * 4 + t % 4, y = c / 8 * 4 + t / 4, *at = depth + 8 * BLOCKS_SQUARE_PX * y + 8 * x;
            tile_planes *own = &planes->tile[32 * y + x];
            random_tile(r, at, levels, count, kind < 4 || kind == 9 ? 0 : side);
            if (!(plane->tiles >> t & 1) && !rng_below(r, 8)) *own = random_tile_planes(r, *at - slope_at(n, x, y));
            for (int z = 0; z < 64; z++) {
                int32_t *d = at + BLOCKS_SQUARE_PX * (z / 8) + z % 8;
                if (plane->tiles >> t & 1)
                    *d = block_plane_at(plane, t % 4 * 8 + z % 8, t / 4 * 8 + z / 8);
                else if (own->kind)
                    *d = own->base + tile_planes_at(own, z % 8, z / 8);
                else
                    *d = held_depth(*d - slope_at(n, x, y), side);
            }
        }
    }
}

static inline void square_bounds(const int32_t *depth, int32_t *low, int32_t *high)
{
    *low = *high = depth[0];
    for (int n = 1; n < BLOCKS_SQUARE_AREA; n++) {
        *low  = depth[n] < *low ? depth[n] : *low;
        *high = depth[n] > *high ? depth[n] : *high;
    }
}

static inline uint32_t coarse_depth(const blocks_sample *s, int32_t depth)
{
    uint32_t coarse = (uint32_t)held_depth(depth, 1 << s->levels) >> (s->levels > 8 ? s->levels - 8 : 0);
    return coarse < 255 ? coarse : 255;
}

/* A square of its own, or one like another but for its depth. Returns its index. */
static inline uint32_t blocks_sample_square(blocks_sample *s, rng *r)
{
    int32_t        side = 1 << s->levels, low, high;
    uint32_t       up   = s->levels > 16 ? s->levels - 16 : 0;
    blocks_square *q    = s->squares + s->square_count;
    q->depth            = blocks_alloc(BLOCKS_SQUARE_AREA, sizeof *q->depth);
    if (s->square_count && !rng_below(r, 4)) {
        const blocks_square *like   = s->squares + rng_below(r, s->square_count);
        uint32_t             deeper = rng_below(r, ((uint32_t)side >> up) / 2);
        if (deeper + like->base > 0xffff) deeper = 0xffff - like->base;
        q->page   = like->page;
        q->offset = like->offset;
        q->base   = like->base + deeper;
        for (int n = 0; n < BLOCKS_SQUARE_AREA; n++) {
            int32_t d   = like->depth[n] + (int32_t)(deeper << up);
            q->depth[n] = d < side ? d : side;
        }
        square_bounds(q->depth, &low, &high);
    } else {
        if (s->pages[s->page_count - 1].count > rng_below(r, BLOCKS_PAGE_FULL_AT)) s->page_count++;
        square_planes *planes = blocks_alloc(1, sizeof *planes);
        node_slope     n      = random_slope(r);
        random_square(r, q->depth, planes, n, side);
        if (!rng_below(r, 5)) n = rng_below(r, 2) ? random_slope(r) : (node_slope){0, 0}; /* one that does not fit */
        square_bounds(q->depth, &low, &high);
        q->base = (uint32_t)held_depth(low, side) >> up;
        if (rng_below(r, 2)) q->base = rng_below(r, q->base + 1);
        if (q->base > 0xffff) q->base = 0xffff;
        q->page   = s->page_count - 1;
        q->offset = put_node(s, r, q->depth, planes, n, (int32_t)(q->base << up), s->pages + q->page);
        free(planes);
    }
    q->min = coarse_depth(s, low);
    q->max = coarse_depth(s, high);
    return s->square_count++;
}

/* words ---------------------------------------------------------------------------------------------------------------------------- */

static inline void put_entry(const blocks_sample *s, half_list *list, int32_t square)
{
    if (square >= 0) {
        put_word(list, 0x80000000u | (uint32_t)square);
        put_word(list, 0);
        return;
    }
    const blocks_square *q = s->squares + ~square;
    put_word(list, q->page << 16 | q->offset);
    put_word(list, q->base | q->min << 16 | q->max << 24);
}

/* A cell of 8 x 8 squares that have one depth. */
static inline int cell_is_uniform(const blocks_sample *s, const int32_t *cell)
{
    for (uint32_t n = 0; n < 64; n++)
        if (cell[0] < 0 || cell[n % 8 + n / 8 * (size_t)s->squares_wide] != cell[0]) return 0;
    return 1;
}

static inline void put_top(const blocks_sample *s, rng *r, half_list *list, const int32_t *map)
{
    uint32_t wide = s->squares_wide, cells = wide / 8;
    if (s->levels < 15) {
        for (uint32_t n = 0; n < wide * wide; n++) put_entry(s, list, map[n]);
        return;
    }
    uint32_t next  = (uint32_t)list->count / 2 + cells * cells;
    uint8_t *plain = blocks_alloc((size_t)cells * cells, 1); /* cells without entries */
    for (uint32_t n = 0; n < cells * cells; n++) {
        const int32_t *cell = map + n % cells * 8 + n / cells * 8 * (size_t)wide;
        plain[n]            = cell_is_uniform(s, cell) && rng_below(r, 64);
        put_word(list, plain[n] ? 0x80000000u | (uint32_t)*cell : next);
        next += plain[n] ? 0 : 128;
    }
    for (uint32_t n = 0; n < cells * cells; n++)
        for (uint32_t e = 0; e < 64 && !plain[n]; e++)
            put_entry(s, list, map[n % cells * 8 + e % 8 + (n / cells * 8 + e / 8) * (size_t)wide]);
    free(plain);
}

static inline void put_list(half_list *list, const half_list *more)
{
    for (size_t n = 0; n < more->count; n++) put_half(list, more->data[n]);
    pad_to_word(list);
}

static inline void blocks_sample_words(blocks_sample *s, rng *r)
{
    half_list list = {0};
    uint32_t  head = 8 + s->page_count, turn = rng_below(r, s->page_count);
    for (uint32_t n = 0; n < head; n++) put_word(&list, 0);
    uint32_t *start = blocks_alloc(head, sizeof *start);
    start[0]        = s->page_count;
    for (uint32_t map = 0; map < s->map_count; map++) {
        start[2 + map] = (uint32_t)list.count / 2;
        put_top(s, r, &list, s->map[map]);
    }
    start[1] = (uint32_t)list.count / 2;
    put_list(&list, &s->common);
    for (uint32_t n = 0; n < s->page_count; n++) { /* pages come in any order */
        uint32_t page   = (n + turn) % s->page_count;
        start[8 + page] = (uint32_t)list.count / 2;
        put_list(&list, &s->pages[page]);
    }
    s->word_count = list.count / 2;
    s->words      = blocks_alloc(s->word_count + BLOCKS_SPARE_WORDS, sizeof *s->words);
    for (size_t n = 0; n < s->word_count; n++) s->words[n] = list.data[2 * n] | (uint32_t)list.data[2 * n + 1] << 16;
    memcpy(s->words, start, head * sizeof *start);
    free(start);
    free(list.data);
}

/* Random maps.
 * levels     3 to 18;   square_max  squares with more than one depth, at most */
static inline void blocks_sample_init(blocks_sample *s, rng *r, uint32_t levels, uint32_t map_count, uint32_t square_max)
{
    uint32_t wide = levels > 8 ? 1u << (levels - 8) : 1;
    size_t   area = (size_t)wide * wide;
    int32_t  side = 1 << levels;
    *s            = (blocks_sample){.levels = levels, .map_count = map_count, .squares_wide = wide};
    s->squares    = blocks_alloc(square_max, sizeof *s->squares);
    s->pages      = blocks_alloc(square_max + 1, sizeof *s->pages);
    s->page_count = 1;
    for (uint32_t map = 0; map < map_count; map++) {
        s->map[map]   = blocks_alloc(area, sizeof **s->map);
        int32_t depth = side;
        for (size_t n = 0; n < area; n++) {
            if (!rng_below(r, levels < 15 ? 4 : 3000)) depth = rng_below(r, 2) ? side : (int32_t)rng_below(r, (uint32_t)side + 1);
            s->map[map][n] = depth;
        }
    }
    for (uint32_t n = 0; n < square_max; n++) { /* around the middle, in two corners, anywhere */
        uint32_t x = n < 4 ? (wide - (n & 1)) / 2 : n < 6 ? (n & 1) * (wide - 1) : rng_below(r, wide);
        uint32_t y = n < 4 ? (wide - (n >> 1)) / 2 : n < 6 ? (n & 1) * (wide - 1) : rng_below(r, wide);
        s->map[n % map_count][x + (size_t)wide * y] = ~(int32_t)blocks_sample_square(s, r);
    }
    blocks_sample_words(s, r);
}

static inline void blocks_sample_free(blocks_sample *s)
{
    for (uint32_t n = 0; n < s->square_count; n++) free(s->squares[n].depth);
    for (uint32_t n = 0; n < s->page_count; n++) free(s->pages[n].data);
    for (uint32_t map = 0; map < s->map_count; map++) free(s->map[map]);
    free(s->squares);
    free(s->pages);
    free(s->common.data);
    free(s->words);
}

/* what they mean ------------------------------------------------------------------------------------------------------------------- */

static inline int32_t blocks_sample_depth(const blocks_sample *s, uint32_t map, uint32_t i, uint32_t j)
{
    int32_t square = s->map[map][(i >> 8) + (size_t)s->squares_wide * (j >> 8)];
    return square >= 0 ? square : held_depth(s->squares[~square].depth[(i & 255) + BLOCKS_SQUARE_PX * (j & 255)], 1 << s->levels);
}

/* The square of a texel, of more than one depth, or NULL. */
static inline const blocks_square *blocks_sample_square_at(const blocks_sample *s, uint32_t map, uint32_t i, uint32_t j)
{
    int32_t square = s->map[map][(i >> 8) + (size_t)s->squares_wide * (j >> 8)];
    return square < 0 ? s->squares + ~square : NULL;
}

/* 1 for shadow, by the bounds of its square, or by its one depth. */
static inline uint32_t blocks_sample_coarse(const blocks_sample *s, uint32_t map, uint32_t i, uint32_t j, uint32_t k)
{
    const blocks_square *q      = blocks_sample_square_at(s, map, i, j);
    uint32_t             coarse = s->levels > 8 ? k >> (s->levels - 8) : k;
    if (!q) return (int32_t)k >= blocks_sample_depth(s, map, i, j);
    return coarse < q->min ? 0 : coarse > q->max ? 1 : coarse * 2 >= q->min + q->max + 1;
}

/* Whether that is all there is to say, or the page is there. */
static inline int blocks_sample_is_full(const blocks_sample *s, uint32_t map, uint32_t i, uint32_t j, uint32_t k)
{
    const blocks_square *q      = blocks_sample_square_at(s, map, i, j);
    uint32_t             coarse = s->levels > 8 ? k >> (s->levels - 8) : k;
    return !q || coarse < q->min || coarse > q->max || s->words[8 + q->page];
}

/* 1 for shadow; by the bounds of the square where its page is not there. */
static inline uint32_t blocks_sample_shadow(const blocks_sample *s, uint32_t map, uint32_t i, uint32_t j, uint32_t k)
{
    if (!blocks_sample_is_full(s, map, i, j, k)) return blocks_sample_coarse(s, map, i, j, k);
    return (int32_t)k >= blocks_sample_depth(s, map, i, j);
}

#endif
