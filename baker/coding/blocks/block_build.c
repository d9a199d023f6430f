/* One palette block of 32 x 32 texels; see block_build.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_build.h"

#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/simd.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

enum {
    ALL_TILES     = (1 << BLOCK_TILES) - 1,
    MASK_FROM     = 4, /* a tile that needs fewer depths gets no two planes with a mask */
    SLANTED_TILES = 4, /* tiles on planes in a slanted block */
    NO_ENTRY      = 0xff,
    PALETTE_LANES = 16,         /* room for a palette in whole vectors */
    PLANE_LEAST   = -(1 << 25), /* limit for which a plane's least depth can be stored relative to any block's base */
    PLANE_MOST    = (1 << 26) + (1 << 22)
};

/* A tile that needs this many depths gets two planes, if it is on two: [fine pages][slanted block]. Fine pages repeat patterns for
 * little: there, planes of few depths cost time and save no bytes. */
static const uint8_t pair_from_of[2][2] = {{6, 3}, {PRIVATE_FROM, 6}};

/* tiles ----------------------------------------------------------------------------------------------------------------------- */

/* Bounds of the columns of a tile. */
typedef struct tile_ends {
    int32_t emax, xmin;
} tile_ends;

/* Set the ranges of a tile with the slope added.   last_vx  greatest exit depth in the map */
static tile_ends take_columns(tile_in *t, const column_tile *columns, int32_t shift, int32_t last_vx)
{
    const i32x4 up = i32x4_all(shift), last = i32x4_all(last_vx), far = i32x4_all(FAR_DEPTH);
    i32x4       emax = i32x4_all(INT32_MIN), xmin = i32x4_all(INT32_MAX);
    for (int quad = 0; quad < 4; quad++)
        for (int row = 0; row < 4; row++) {
            int   from = 8 * (4 * (quad >> 1) + row) + 4 * (quad & 1), to = 16 * quad + 4 * row;
            i32x4 e = i32x4_load(columns->e + from) + up, x = i32x4_load(columns->x + from);
            x    = i32x4_select((i32x4)(x > last), far, x) + up; /* as exit_least of block_node.c */
            emax = i32x4_max(emax, e);
            xmin = i32x4_min(xmin, x);
            memcpy(t->ranges.low + to, &e, sizeof e);
            memcpy(t->ranges.high + to, &x, sizeof x);
        }
    return (tile_ends){i32x4_greatest(emax), i32x4_least(xmin)};
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE void put_row(int32_t *to, __m256i row)
{
    __m128i left = _mm256_castsi256_si128(row), right = _mm256_extracti128_si256(row, 1);
    memcpy(to, &left, sizeof left);
    memcpy(to + 16, &right, sizeof right);
}

/* The same with 8 lanes. */
CPU_TARGET_AVX2 static tile_ends take_columns_avx2(tile_in *t, const column_tile *columns, int32_t shift, int32_t last_vx)
{
    const __m256i up = _mm256_set1_epi32(shift), last = _mm256_set1_epi32(last_vx), far = _mm256_set1_epi32(FAR_DEPTH);
    __m256i       emax = _mm256_set1_epi32(INT32_MIN), xmin = _mm256_set1_epi32(INT32_MAX);
    for (int y = 0; y < 8; y++) {
        __m256i e = _mm256_loadu_si256((const __m256i *)(const void *)(columns->e + 8 * y));
        __m256i x = _mm256_loadu_si256((const __m256i *)(const void *)(columns->x + 8 * y));
        e         = _mm256_add_epi32(e, up);
        x         = _mm256_add_epi32(_mm256_blendv_epi8(x, far, _mm256_cmpgt_epi32(x, last)), up);
        emax      = _mm256_max_epi32(emax, e);
        xmin      = _mm256_min_epi32(xmin, x);
        put_row(t->ranges.low + pattern_texel(0, y), e);
        put_row(t->ranges.high + pattern_texel(0, y), x);
    }
    __m128i most  = _mm_max_epi32(_mm256_castsi256_si128(emax), _mm256_extracti128_si256(emax, 1));
    __m128i least = _mm_min_epi32(_mm256_castsi256_si128(xmin), _mm256_extracti128_si256(xmin, 1));
    return (tile_ends){i32x4_greatest((i32x4)most), i32x4_least((i32x4)least)};
}

#endif

vxs_result block_fetch_tile(node_builder *b, uint32_t n, uint32_t tile_x, uint32_t tile_y)
{
    column_tile columns;
    tile_in    *t       = &b->tile[n];
    int32_t     last_vx = (int32_t)b->columns->depth_vx - 1;
    vxs_result  r       = b->columns->tile(b->columns->data, b->tile_x + tile_x, b->tile_y + tile_y, &columns);
    if (r != VXS_OK) return r;
    t->shift  = slope_shift(b->node.slope, (int32_t)tile_x, (int32_t)tile_y);
    t->depths = 0;
#ifdef __x86_64__
    tile_ends ends = b->set->patterns.cpu >= CPU_AVX2 ? take_columns_avx2(t, &columns, t->shift, last_vx)
                                                      : take_columns(t, &columns, t->shift, last_vx);
#else
    tile_ends ends = take_columns(t, &columns, t->shift, last_vx);
#endif
    b->tile_emax[n] = ends.emax;
    b->tile_xmin[n] = ends.xmin;
    return VXS_OK;
}

static void set_kind(node_builder *b, uint32_t tiles, tile_kind kind)
{
    for (int k = 0; k < TILE_KINDS; k++) b->of_kind[k] &= ~tiles;
    b->of_kind[kind] |= tiles;
}

static vxs_result fetch_block(node_builder *b, uint32_t block_x, uint32_t block_y)
{
    uint32_t mixed = 0, uniform = 0;
    for (uint32_t row = 0; row < 4; row++) {
        uint32_t at = NODE_TILES * (4 * block_y + row) + 4 * block_x;
        i32x4    e = i32x4_load(b->emax + at), x = i32x4_load(b->xmin + at);
        memcpy(b->tile_emax + 4 * row, &e, sizeof e);
        memcpy(b->tile_xmin + 4 * row, &x, sizeof x);
        mixed |= (uint32_t)i32x4_bits((i32x4)(e > x)) << 4 * row;
    }
    for (uint32_t rest = mixed; rest; rest &= rest - 1) {
        uint32_t   n = (uint32_t)__builtin_ctz(rest);
        vxs_result r = block_fetch_tile(b, n, 4 * block_x + n % 4, 4 * block_y + n / 4);
        if (r != VXS_OK) return r;
        uniform |= (uint32_t)(b->tile_emax[n] <= b->tile_xmin[n]) << n; /* its bounds were loose */
    }
    memset(b->of_kind, 0, sizeof b->of_kind);
    b->of_kind[TILE_PATTERN] = mixed & ~uniform;
    b->of_kind[TILE_UNIFORM] = ALL_TILES & ~b->of_kind[TILE_PATTERN];
    return VXS_OK;
}

/* Make a depth axis of the depths that occur in these tiles, and set their codes. */
static void scale_by_depths(node_builder *b, uint32_t ranged)
{
    int32_t  depths[AXIS_DEPTHS_MAX];
    int16_t  codes[AXIS_DEPTHS_MAX];
    int      count = 0, next = 0;
    uint32_t uniform = b->of_kind[TILE_UNIFORM];
    for (uint32_t rest = uniform; rest; rest &= rest - 1) {
        depths[count++] = b->tile_emax[__builtin_ctz(rest)];
        depths[count++] = b->tile_xmin[__builtin_ctz(rest)];
    }
    for (uint32_t rest = ranged; rest; rest &= rest - 1, count += 128)
        memcpy(depths + count, &b->tile[__builtin_ctz(rest)].ranges, sizeof b->tile->ranges);
    axis_init_by_depths(&b->axis, depths, codes, count);
    memset(b->tile_high, 0, sizeof b->tile_high); /* of tiles that are not uniform: before all entries */
    for (uint32_t rest = uniform; rest; rest &= rest - 1) {
        b->tile_low[__builtin_ctz(rest)]  = codes[next++];
        b->tile_high[__builtin_ctz(rest)] = codes[next++];
    }
    for (uint32_t rest = ranged; rest; rest &= rest - 1, next += 128) {
        tile_in *t = &b->tile[__builtin_ctz(rest)];
        memcpy(t->low, codes + next, sizeof t->low);
        memcpy(t->high, codes + next + 64, sizeof t->high);
    }
}

/* Make the depth axis for the block's tiles, and set their codes. */
static void scale_block(node_builder *b)
{
    const uint32_t ranged     = b->of_kind[TILE_PATTERN] | b->of_kind[TILE_PRIVATE];
    int32_t        least_high = INT32_MAX, greatest_low = INT32_MIN;
    for (uint32_t rest = ranged | b->of_kind[TILE_UNIFORM]; rest; rest &= rest - 1) {
        least_high   = min_i32(least_high, b->tile_xmin[__builtin_ctz(rest)]);
        greatest_low = max_i32(greatest_low, b->tile_emax[__builtin_ctz(rest)]);
    }
    /* the first is greater if all tiles that are not on a plane are uniform, and have a common depth */
    if (!axis_init(&b->axis, min_i32(least_high, greatest_low), max_i32(least_high, greatest_low))) {
        scale_by_depths(b, ranged);
        return;
    }
    axis_codes(&b->axis, b->tile_emax, b->tile_low, BLOCK_TILES);
    axis_codes(&b->axis, b->tile_xmin, b->tile_high, BLOCK_TILES);
    for (uint32_t rest = ranged; rest; rest &= rest - 1) {
        tile_in *t = &b->tile[__builtin_ctz(rest)];
        axis_codes(&b->axis, t->ranges.low, t->low, 64);
        axis_codes(&b->axis, t->ranges.high, t->high, 64);
    }
}

static void add_tile(intervals *s, const tile_in *t)
{
    memcpy(s->low + s->count, t->low, sizeof t->low);
    memcpy(s->high + s->count, t->high, sizeof t->high);
    s->count += 64;
}

/* palettes -------------------------------------------------------------------------------------------------------------------- */

/* Whether the points of the block prove that a tile needs fewer depths than `enough`. */
static int needs_few(const node_builder *b, uint32_t tile, const stab_group *groups, int count, int enough)
{
    int16_t first = axis_code(&b->axis, b->tile_xmin[tile]), last = axis_code(&b->axis, b->tile_emax[tile]);
    int     from = 0, to = 0;
    while (from + 1 < count && groups[from + 1].high <= first) from++;
    while (to + 1 < count && groups[to].high < last) to++;
    return to - from + 1 < enough;
}

/* Fit two planes to a tile, if these are likely to take less than its pattern and its part of the palette. Returns 0 if not. */
static int fit_pair(tile_in *t, int thorough)
{
    private_plane_pair(&t->plane, &t->ranges, thorough);
    if (t->plane.count > PRIVATE_PAIR_HALVES && t->depths < MASK_FROM) t->plane.count = 0;
    return t->plane.count != 0;
}

/* Count the depths that tiles need, and give private palettes to those that need many. Returns whether there are any.
 * groups     [count] points of the block; if they fit into its palette, tiles that need few are not counted
 * pair_from  depths that a tile needs to get two planes instead */
static int give_private_depths(node_builder *b, const stab_group *groups, int count, int pair_from)
{
    uint32_t many = 0;
    for (uint32_t rest = b->of_kind[TILE_PATTERN]; rest; rest &= rest - 1) {
        uint32_t   n = (uint32_t)__builtin_ctz(rest);
        intervals  s;
        stab_group of_tile[PRIVATE_FROM];
        if (count <= PALETTE_MAX && needs_few(b, n, groups, count, pair_from)) continue;
        s.count = 0;
        add_tile(&s, &b->tile[n]);
        b->tile[n].depths = minimum_stabbing_set(&s, of_tile, PRIVATE_FROM, b->set->patterns.cpu);
        int depths        = b->tile[n].depths;
        many |= (uint32_t)(depths >= PRIVATE_FROM || (depths >= pair_from && fit_pair(&b->tile[n], b->set->privates.thorough)))
                << n;
    }
    set_kind(b, many, TILE_PRIVATE);
    return many != 0;
}

/* Give a private palette to the tile that needs most depths. Uniform tiles alone may need too many. */
static void give_most_private(node_builder *b)
{
    uint32_t most = 0, uniform = b->of_kind[TILE_UNIFORM];
    int      depths = -1;
    for (uint32_t rest = uniform | b->of_kind[TILE_PATTERN]; rest; rest &= rest - 1) {
        uint32_t n     = (uint32_t)__builtin_ctz(rest);
        int      needs = uniform >> n & 1 ? 0 : b->tile[n].depths;
        if (needs <= depths) continue;
        most   = n;
        depths = needs;
    }
    if (uniform >> most & 1) {
        tile_in *t = &b->tile[most];
        for (int n = 0; n < 64; n++) {
            t->ranges.low[n]  = b->tile_emax[most];
            t->ranges.high[n] = b->tile_xmin[most];
        }
        private_plane(&t->plane, &t->ranges);
        t->low[0]  = b->tile_low[most]; /* block_groups may use it */
        t->high[0] = b->tile_high[most];
    }
    set_kind(b, 1u << most, TILE_PRIVATE);
}

/* The fewest depths for all tiles without a private palette. Gives tiles private palettes until the palette is large enough. */
static int block_groups(node_builder *b, stab_group groups[PALETTE_MAX + 1])
{
    int slanted   = __builtin_popcount(b->of_kind[TILE_PLANE] | b->of_kind[TILE_PRIVATE]) >= SLANTED_TILES;
    int pair_from = pair_from_of[b->fine][slanted];

    b->set->privates.thorough = slanted;
    for (int counted = 0;;) {
        intervals s; /* 4 KiB; only the count needs to be initialized */
        s.count = 0;
        for (uint32_t rest = b->of_kind[TILE_PATTERN]; rest; rest &= rest - 1) add_tile(&s, &b->tile[__builtin_ctz(rest)]);
        for (uint32_t rest = b->of_kind[TILE_UNIFORM]; rest; rest &= rest - 1) {
            s.low[s.count]    = b->tile_low[__builtin_ctz(rest)];
            s.high[s.count++] = b->tile_high[__builtin_ctz(rest)];
        }
        if (!s.count) { /* all tiles have private palettes: the palette's depth is only their base */
            const tile_in *first = &b->tile[__builtin_ctz(b->of_kind[TILE_PRIVATE])];
            s.low[0]             = first->low[0];
            s.high[0]            = first->high[0];
            s.count              = 1;
        }
        int count = minimum_stabbing_set(&s, groups, PALETTE_MAX + 1, b->set->patterns.cpu);
        if (count >= pair_from && !counted) {
            counted = 1;
            if (give_private_depths(b, groups, count, pair_from)) continue;
        }
        if (count <= PALETTE_MAX) return count;
        give_most_private(b);
    }
}

/* Number in [low, high] divisible by the largest power of two; low >= 1. */
static int32_t roundest(int32_t low, int32_t high)
{
    int bit = 31 - __builtin_clz((uint32_t)((low - 1) ^ high));
    return high >> bit << bit;
}

/* The palette of a block. */
typedef struct palette_in {
    int16_t code[PALETTE_LANES];
    uint8_t first[BLOCK_TILES]; /* of each tile: the first entry at or behind its last enter depth */
    uint8_t last[BLOCK_TILES];  /* the last entry at or before its first exit depth; NO_ENTRY: there is none */
} palette_in;

/* Choose entries of uniform tiles: the same as the tiles before, where possible. */
static void place_uniform(const node_builder *b, block *out, const palette_in *p)
{
    const uint8_t *low = p->first, *high = p->last;
    run_range      run  = {0, PALETTE_MAX};
    uint32_t       rest = b->of_kind[TILE_UNIFORM], placed = rest;
    for (;; rest &= rest - 1) {
        int n = rest ? __builtin_ctz(rest) : BLOCK_TILES;
        if (rest && run_takes(&run, low[n], high[n])) continue;
        for (; placed & ((1u << n) - 1); placed &= placed - 1) out->tile[__builtin_ctz(placed)].palette = (uint16_t)run.low;
        if (!rest) return;
        run = (run_range){low[n], high[n]};
    }
}

int tile_ranges_from(plane_ranges *to, const node_builder *b, uint32_t n, int32_t from)
{
    const tile_in *t = &b->tile[n];
    if (b->tile_emax[n] - t->shift - from >= PLANE_FREE / PLANE_ONE) return 0;
    plane_ranges_of(to, &t->ranges, from + t->shift);
    return 1;
}

/* The same for planes through the block. */
static int tile_on_block(plane_ranges *to, const node_builder *b, uint32_t n, int32_t from)
{
    if (!tile_ranges_from(to, b, n, from)) return 0;
    to->x = 8 * (int32_t)(n % 4);
    to->y = 8 * (int32_t)(n / 4);
    return 1;
}

/* Add uniform tiles to those on the plane. Tiles of a slanted sheet are uniform here and there; if all tiles are on the plane, the
 * block is like its neighbours.   on  [in, out] */
static vxs_result add_uniform(node_builder *b, plane *p, plane_ranges ranges[BLOCK_TILES], int32_t from, uint32_t *on)
{
    uint32_t near = 0;
    if (!*on || b->columns->side_px < NODE_PX) return VXS_OK; /* some tiles are outside */
    for (uint32_t rest = b->of_kind[TILE_UNIFORM]; rest; rest &= rest - 1) {
        uint32_t   n = (uint32_t)__builtin_ctz(rest);
        vxs_result r = block_fetch_tile(b, n, 4 * (b->number % 8) + n % 4, 4 * (b->number / 8) + n / 4);
        if (r != VXS_OK) return r;
        near |= (uint32_t)tile_on_block(&ranges[n], b, n, from) << n;
    }
    if ((*on | near) == ALL_TILES && plane_of_all(p, ranges))
        *on = ALL_TILES;
    else
        *on |= plane_passes(p, ranges, near);
    return VXS_OK;
}

/* Find the tiles on a common plane; the following steps skip them.
 * p     [out] the plane, in voxels of the map
 * flat  [out] bits of tiles that may lie on a plane */
static vxs_result find_plane(node_builder *b, plane *p, uint32_t *flat)
{
    plane_ranges   ranges[BLOCK_TILES];
    const uint32_t patterned = b->of_kind[TILE_PATTERN];
    uint32_t       mixed = 0, even = 0;
    int32_t        from = INT32_MAX;
    *p                  = (plane){0, 0, 0};
    for (uint32_t rest = patterned; rest; rest &= rest - 1) {
        uint32_t n = (uint32_t)__builtin_ctz(rest);
        from       = min_i32(from, b->tile_xmin[n] - b->tile[n].shift);
        even |= (uint32_t)tile_may_be_plane(&b->tile[n].ranges) << n;
    }
    *flat = even;
    if (__builtin_popcount(even) < PLANE_TILES_MIN) return VXS_OK;
    for (uint32_t rest = patterned; rest; rest &= rest - 1) {
        uint32_t n = (uint32_t)__builtin_ctz(rest);
        mixed |= (uint32_t)tile_on_block(&ranges[n], b, n, from) << n;
    }
    if (__builtin_popcount(even & mixed) < PLANE_TILES_MIN) return VXS_OK;
    uint32_t   on = plane_of_block(p, ranges, mixed, even & mixed, b->set->recent);
    vxs_result r  = add_uniform(b, p, ranges, from, &on);
    if (r != VXS_OK) return r;
    if (on) p->least += from * PLANE_ONE;
    if (p->least < PLANE_LEAST || p->least > PLANE_MOST) on = 0;
    if (!on) *p = (plane){0, 0, 0};
    set_kind(b, on, TILE_PLANE);
    b->set->tile_count += (uint32_t)__builtin_popcount(on);
    return VXS_OK;
}

/* A depth of a block beside the current one that is in this range; -1: none. */
static int32_t depth_beside(const node_builder *b, int32_t low, int32_t high)
{
    const uint32_t n = b->number, x = n % 8, beside[] = {x ? n - 1 : n, n > 7 ? n - 8 : n, x < 7 ? n + 1 : n, n < 56 ? n + 8 : n};
    for (int k = 0; k < 4; k++) {
        const block_depths *other = &b->chosen[beside[k]];
        for (uint32_t m = 0; m < other->count; m++)
            if (low <= other->depth[m] && other->depth[m] <= high) return other->depth[m];
    }
    return -1;
}

/* The least depth along the upper and the left side of a block without uniform tiles. */
static int32_t least_beside(const node_builder *b)
{
    int32_t least = INT32_MAX;
    for (int n = 0; n < 4; n++)
        for (int k = 0; k < 8; k++) {
            least = min_i32(least, b->tile[n].ranges.low[pattern_texel(k, 0)]);
            least = min_i32(least, b->tile[4 * n].ranges.low[pattern_texel(0, k)]);
        }
    return max_i32(least, 0);
}

/* Build the palette for the tiles that are not on the plane.
 * p  [out]
 * Returns the first depth. */
static int32_t build_palette(node_builder *b, block *out, palette_in *p)
{
    stab_group groups[PALETTE_MAX + 1];
    scale_block(b);
    int count = block_groups(b, groups);
    if (!(b->of_kind[TILE_UNIFORM] |
          b->of_kind[TILE_PATTERN])) { /* the only entry is but the base of tiles, which pages predict so */
        out->depths = 1;
        return least_beside(b);
    }

    /* Choose depths within their groups, with round differences to the first. The last depth is often that of the ground. If a
     * block beside this one has a depth in its group, take that: pages of VXS_PACKING_FINE then need not code it. */
    int32_t           base = axis_depth(&b->axis, groups[0].low), high = axis_depth(&b->axis, groups[0].high);
    const stab_group *end = &groups[count - 1];
    int32_t met = count > 1 && b->fine ? depth_beside(b, axis_depth(&b->axis, end->low), axis_depth(&b->axis, end->high)) : -1;
    out->depths = (uint32_t)count;
    for (int n = 1; n < count - (met >= 0); n++) {
        int32_t from = axis_depth(&b->axis, groups[n].low), to = axis_depth(&b->axis, groups[n].high);
        out->depth[n] = roundest(from - high, to - base);
        base          = max_i32(base, from - out->depth[n]);
        high          = min_i32(high, to - out->depth[n]);
    }

    if (met >= 0) out->depth[count - 1] = met - base;
    int32_t depths[PALETTE_LANES] = {0};
    for (int n = 0; n < count; n++) depths[n] = base + out->depth[n];
    axis_codes(&b->axis, depths, p->code, PALETTE_LANES);
    points_of_ranges(b->tile_low, b->tile_high, BLOCK_TILES, p->code, count, p->first, p->last);
    place_uniform(b, out, p);
    return base;
}

/* Find or add the pattern of each tile. */
static vxs_result find_patterns(node_builder *b, block *out, int32_t base, const palette_in *p)
{
    for (uint32_t rest = b->of_kind[TILE_PATTERN] | b->of_kind[TILE_PRIVATE]; rest; rest &= rest - 1) {
        const int      n  = __builtin_ctz(rest);
        const tile_in *t  = &b->tile[n];
        block_tile    *to = &out->tile[n];
        vxs_result     r;
        if (b->of_kind[TILE_PRIVATE] & rest & -rest) {
            to->kind = TILE_PRIVATE;
            r        = private_find(&b->set->privates, &t->ranges, &t->plane, &to->pattern, &to->base);
            to->base -= base;
        } else {
            mask_need needs[PALETTE_MAX - 1];
            to->kind       = TILE_PATTERN;
            const int from = p->last[n] == NO_ENTRY ? 0 : p->last[n];
            to->palette    = (uint16_t)tile_needs(t->low, t->high, p->code, (int)out->depths, from, needs, b->set->patterns.cpu);
            r              = pattern_find(&b->set->patterns, __builtin_popcount(to->palette), needs, &to->pattern);
        }
        if (r != VXS_OK) return r;
        b->set->tile_count++;
    }
    return VXS_OK;
}

vxs_result block_build(node_builder *b, uint32_t *id, int32_t *base)
{
    palette_in palette;
    uint32_t   flat;
    block      out;
    vxs_result r = fetch_block(b, b->number % 8, b->number / 8);
    if (r != VXS_OK) return r;
    memset(&out, 0, sizeof out);
    if ((r = find_plane(b, &out.plane, &flat)) != VXS_OK) return r;

    /* Give tiles that lie on planes of their own these planes: three halves each, at any depth. */
    const uint32_t on = b->of_kind[TILE_PLANE];
    for (uint32_t rest = b->of_kind[TILE_PATTERN]; rest; rest &= rest - 1) {
        tile_in *t     = &b->tile[__builtin_ctz(rest)];
        t->plane.count = 0;
        if (!(flat & rest & -rest)) continue;
        private_plane(&t->plane, &t->ranges);
        if (t->plane.count) set_kind(b, rest & -rest, TILE_PRIVATE);
    }

    if (on == ALL_TILES) {
        out.depths = 1;
        *base      = max_i32(out.plane.least >> 8, 0);
    } else
        *base = build_palette(b, &out, &palette);
    for (uint32_t rest = on; rest; rest &= rest - 1) out.tile[__builtin_ctz(rest)].kind = TILE_PLANE;
    if (on) out.plane.least -= *base * PLANE_ONE;
    block_depths *chosen = &b->chosen[b->number];
    chosen->count        = out.depths;
    for (uint32_t n = 0; n < out.depths; n++) chosen->depth[n] = *base + out.depth[n];
    r = find_patterns(b, &out, *base, &palette);
    return r == VXS_OK ? block_set_find(b->set, &out, id) : r;
}
