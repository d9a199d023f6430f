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
    PLANE_LEAST = -(1 << 25), /* limit for which a plane's least depth can be stored relative to any block's base */
    PLANE_MOST  = (1 << 26) + (1 << 22)
};

/* tiles ----------------------------------------------------------------------------------------------------------------------- */

/* Set the ranges of a tile with the slope added.   last  greatest exit depth in the map */
static void take_columns(tile_in *t, const column_tile *columns, int32_t shift, int32_t last_vx)
{
    const i32x4 up = i32x4_all(shift), last = i32x4_all(last_vx), far = i32x4_all(FAR_DEPTH);
    i32x4       emax = i32x4_all(INT32_MIN), xmin = i32x4_all(INT32_MAX);
    for (int quad = 0; quad < 4; quad++)
        for (int row = 0; row < 4; row++) {
            int   from = 8 * (4 * (quad >> 1) + row) + 4 * (quad & 1), to = 16 * quad + 4 * row;
            i32x4 e = i32x4_load(columns->e + from) + up, x = i32x4_load(columns->x + from);
            x    = i32x4_select((i32x4)(x > last), far, x) + up; /* as in exit_depth */
            emax = i32x4_max(emax, e);
            xmin = i32x4_min(xmin, x);
            memcpy(t->ranges.low + to, &e, sizeof e);
            memcpy(t->ranges.high + to, &x, sizeof x);
        }
    t->emax = i32x4_greatest(emax);
    t->xmin = i32x4_least(xmin);
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE void put_row(int32_t *to, __m256i row)
{
    __m128i left = _mm256_castsi256_si128(row), right = _mm256_extracti128_si256(row, 1);
    memcpy(to, &left, sizeof left);
    memcpy(to + 16, &right, sizeof right);
}

/* The same with 8 lanes. */
CPU_TARGET_AVX2 static void take_columns_avx2(tile_in *t, const column_tile *columns, int32_t shift, int32_t last_vx)
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
    t->emax = i32x4_greatest((i32x4)_mm_max_epi32(_mm256_castsi256_si128(emax), _mm256_extracti128_si256(emax, 1)));
    t->xmin = i32x4_least((i32x4)_mm_min_epi32(_mm256_castsi256_si128(xmin), _mm256_extracti128_si256(xmin, 1)));
}

#endif

/* Fetch the columns of a tile, and add the slope. */
static vxs_result fetch_tile(node_builder *b, tile_in *t, uint32_t tile_x, uint32_t tile_y, int32_t shift)
{
    column_tile columns;
    int32_t     last_vx = (int32_t)b->columns->depth_vx - 1;
    vxs_result  r       = b->columns->tile(b->columns->data, b->tile_x + tile_x, b->tile_y + tile_y, &columns);
    if (r != VXS_OK) return r;
#ifdef __x86_64__
    if (b->set->patterns.cpu >= CPU_AVX2) {
        take_columns_avx2(t, &columns, shift, last_vx);
        return VXS_OK;
    }
#endif
    take_columns(t, &columns, shift, last_vx);
    return VXS_OK;
}

static vxs_result fetch_block(node_builder *b, uint32_t block_x, uint32_t block_y)
{
    for (uint32_t n = 0; n < BLOCK_TILES; n++) {
        tile_in *t = &b->tile[n];
        uint32_t x = 4 * block_x + n % 4, y = 4 * block_y + n / 4, at = NODE_TILES * y + x;
        t->emax   = b->emax[at];
        t->xmin   = b->xmin[at];
        t->shift  = slope_shift(b->node.slope, (int32_t)x, (int32_t)y);
        t->depths = 0;
        if (t->emax > t->xmin) {
            vxs_result r = fetch_tile(b, t, x, y, t->shift);
            if (r != VXS_OK) return r;
        }
        t->kind = t->emax > t->xmin ? TILE_PATTERN : TILE_UNIFORM;
    }
    return VXS_OK;
}

/* Make the depth axis for the block's tiles. */
static void scale_block(node_builder *b)
{
    int32_t least_high = INT32_MAX, greatest_low = INT32_MIN;
    for (const tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
        if (t->kind == TILE_PLANE) continue;
        least_high   = min_i32(least_high, t->xmin);
        greatest_low = max_i32(greatest_low, t->emax);
    }
    /* the first is greater if all tiles that are not on a plane are uniform, and have a common depth */
    if (!axis_init(&b->axis, min_i32(least_high, greatest_low), max_i32(least_high, greatest_low))) {
        /* Make a depth axis of the depths that occur in the block's tiles, and set their codes. */
        int32_t depths[AXIS_DEPTHS_MAX];
        int16_t codes[AXIS_DEPTHS_MAX];
        int     count = 0, next = 0;
        depths[0] = 0; /* there is always one; avoids a compiler warning */
        for (const tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
            if (t->kind == TILE_PLANE) continue;
            int of_tile = t->kind == TILE_UNIFORM ? 1 : 64;
            memcpy(depths + count, t->kind == TILE_UNIFORM ? &t->emax : t->ranges.low, (size_t)of_tile * sizeof *depths);
            count += of_tile;
            memcpy(depths + count, t->kind == TILE_UNIFORM ? &t->xmin : t->ranges.high, (size_t)of_tile * sizeof *depths);
            count += of_tile;
        }
        axis_init_by_depths(&b->axis, depths, codes, count);
        for (tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
            if (t->kind == TILE_PLANE) continue;
            if (t->kind == TILE_UNIFORM) {
                next += 2;
                continue;
            }
            memcpy(t->low, codes + next, sizeof t->low);
            memcpy(t->high, codes + next + 64, sizeof t->high);
            next += 128;
        }

        return;
    }
    for (tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
        if (t->kind == TILE_UNIFORM || t->kind == TILE_PLANE) continue;
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

/* Count the depths that each tile needs, and give private palettes to tiles that need many. Returns the number of these. */
static int give_private_depths(node_builder *b)
{
    int count = 0;
    for (tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
        intervals  s;
        stab_group groups[PRIVATE_FROM];
        if (t->kind != TILE_PATTERN) continue;
        s.count = 0;
        add_tile(&s, t);
        t->depths = minimum_stabbing_set(&s, groups, PRIVATE_FROM, b->set->patterns.cpu);
        if (t->depths < PRIVATE_FROM) continue;
        t->kind = TILE_PRIVATE;
        count++;
    }
    return count;
}

/* The fewest depths for all tiles without a private palette. Gives tiles private palettes until the palette is large enough. */
static int block_groups(node_builder *b, stab_group groups[PALETTE_MAX + 1])
{
    for (int counted = 0;;) {
        intervals s; /* 4 KiB; only the count needs to be initialized */
        s.count = 0;
        for (const tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
            if (t->kind == TILE_PATTERN) add_tile(&s, t);
            if (t->kind != TILE_UNIFORM) continue;
            s.low[s.count]    = axis_code(&b->axis, t->emax);
            s.high[s.count++] = axis_code(&b->axis, t->xmin);
        }
        if (!s.count) { /* all tiles have private palettes: the palette's depth is only their base */
            const tile_in *first = b->tile;
            while (first->kind == TILE_PLANE) first++;
            s.low[0]  = first->low[0];
            s.high[0] = first->high[0];
            s.count   = 1;
        }
        int count = minimum_stabbing_set(&s, groups, PALETTE_MAX + 1, b->set->patterns.cpu);
        if (count >= PRIVATE_FROM && !counted) {
            counted = 1;
            if (give_private_depths(b)) continue;
        }
        if (count <= PALETTE_MAX) return count;

        /* The palette is full: give a private palette to the tile that needs most depths. Uniform tiles alone may need too
         * many. */
        tile_in *most = NULL;
        for (tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++)
            if ((t->kind == TILE_UNIFORM || t->kind == TILE_PATTERN) && (!most || t->depths > most->depths)) most = t;
        for (int n = 0; n < 64 && most->kind == TILE_UNIFORM; n++) {
            most->ranges.low[n]  = most->emax;
            most->ranges.high[n] = most->xmin;
        }
        if (most->kind == TILE_UNIFORM) {
            private_plane(&most->plane, &most->ranges);
            most->low[0]  = axis_code(&b->axis, most->emax); /* block_groups may use it */
            most->high[0] = axis_code(&b->axis, most->xmin);
        }
        most->kind = TILE_PRIVATE;
    }
}

/* Number in [low, high] divisible by the largest power of two; low >= 1. */
static int32_t roundest(int32_t low, int32_t high)
{
    int bit = 31 - __builtin_clz((uint32_t)((low - 1) ^ high));
    return high >> bit << bit;
}

enum { PALETTE_LANES = 16 };

/* Number of ascending depths below this one. */
static int count_below(const int32_t depths[PALETTE_LANES], int32_t depth)
{
    u32x4 below[4];
    for (int n = 0; n < 4; n++) below[n] = (u32x4)(i32x4_load(depths + 4 * n) < i32x4_all(depth));
    return __builtin_ctz(u32x4_zeros(below) | 1u << PALETTE_LANES);
}

/* Give this entry to the uniform tiles [first, end). */
static void place_run(const node_builder *b, block *out, int first, int end, int32_t entry)
{
    for (int n = first; n < end; n++)
        if (b->tile[n].kind == TILE_UNIFORM) out->tile[n].palette = (uint16_t)entry;
}

/* Find the tiles on a common plane; the following steps skip them.
 * p  [out] the plane, in voxels of the map
 * Returns the bits of those tiles. */
static uint32_t find_plane(node_builder *b, plane *p)
{
    plane_ranges ranges[BLOCK_TILES];
    uint32_t     mixed = 0, flat = 0;
    int32_t      from = INT32_MAX;
    *p                = (plane){0, 0, 0};
    for (uint32_t n = 0; n < BLOCK_TILES; n++)
        if (b->tile[n].kind == TILE_PATTERN) from = min_i32(from, b->tile[n].xmin - b->tile[n].shift);
    for (uint32_t n = 0; n < BLOCK_TILES; n++) {
        tile_in *t = &b->tile[n];
        if (t->kind != TILE_PATTERN) continue;
        t->flat = tile_may_be_plane(&t->ranges);
        if (t->emax - t->shift - from >= PLANE_FREE / PLANE_ONE) continue;
        mixed |= 1u << n;
        flat |= (uint32_t)t->flat << n;
    }
    if (__builtin_popcount(flat) < PLANE_TILES_MIN) return 0;
    for (uint32_t rest = mixed; rest; rest &= rest - 1) {
        int n = __builtin_ctz(rest);
        plane_ranges_of(&ranges[n], &b->tile[n].ranges, from + b->tile[n].shift);
        ranges[n].x = 8 * (n % 4);
        ranges[n].y = 8 * (n / 4);
    }
    uint32_t on = plane_of_block(p, ranges, mixed, flat, b->set->recent);
    if (on) p->least += from * PLANE_ONE;
    if (p->least < PLANE_LEAST || p->least > PLANE_MOST) on = 0;
    if (!on) *p = (plane){0, 0, 0};
    for (uint32_t n = 0; n < BLOCK_TILES; n++)
        if (on >> n & 1) b->tile[n].kind = TILE_PLANE;
    b->set->tile_count += (uint32_t)__builtin_popcount(on);
    return on;
}

/* A depth in this range that a block has which is beside the current one; -1: none. */
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

/* Build the palette for the tiles that are not on the plane.
 * codes  [out] codes of its depths;   Returns the first depth. */
static int32_t build_palette(node_builder *b, block *out, int16_t codes[PALETTE_MAX])
{
    stab_group groups[PALETTE_MAX + 1];
    scale_block(b);
    int count = block_groups(b, groups);

    /* Choose depths within their groups, with round differences to the first. The last one is often of what lies behind all edges: it
     * is that of a block beside, if possible, so that pages of VXS_PACKING_FINE need not code it. */
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
    for (int n = 0; n < count; n++) codes[n] = axis_code(&b->axis, base + out->depth[n]);

    /* Choose entries of uniform tiles: the same as the tiles before, where possible. */
    int32_t   depths[PALETTE_LANES];
    run_range run   = {0, PALETTE_MAX};
    int       first = 0;
    for (uint32_t n = 0; n < PALETTE_LANES; n++) depths[n] = n < out->depths ? base + out->depth[n] : INT32_MAX;
    for (int n = 0; n < BLOCK_TILES; n++) {
        const tile_in *t = &b->tile[n];
        if (t->kind != TILE_UNIFORM) continue;
        run_range may = {count_below(depths, t->emax), count_below(depths, t->xmin + 1) - 1};
        if (run_takes(&run, may.low, may.high)) continue;
        place_run(b, out, first, n, run.low);
        run   = may;
        first = n;
    }
    place_run(b, out, first, BLOCK_TILES, run.low);

    return base;
}

vxs_result block_build(node_builder *b, uint32_t *id, int32_t *base)
{
    int16_t    codes[PALETTE_MAX];
    block      out;
    vxs_result r = fetch_block(b, b->number % 8, b->number / 8);
    if (r != VXS_OK) return r;
    memset(&out, 0, sizeof out);
    uint32_t on = find_plane(b, &out.plane);

    /* Give tiles that lie on planes of their own these planes: three halves each, at any depth. */
    for (tile_in *t = b->tile; t < b->tile + BLOCK_TILES; t++) {
        t->plane.count = 0;
        if (t->kind != TILE_PATTERN || !t->flat) continue;
        private_plane(&t->plane, &t->ranges);
        if (t->plane.count) t->kind = TILE_PRIVATE;
    }

    if (on == 0xffff) {
        out.depths = 1;
        *base      = max_i32(out.plane.least >> 8, 0);
    } else
        *base = build_palette(b, &out, codes);
    if (on) out.plane.least -= *base * PLANE_ONE;
    block_depths *chosen = &b->chosen[b->number];
    chosen->count        = out.depths;
    for (uint32_t n = 0; n < out.depths; n++) chosen->depth[n] = *base + out.depth[n];
    int count = (int)out.depths;
    for (int n = 0; n < BLOCK_TILES && r == VXS_OK; n++) {
        const tile_in *t  = &b->tile[n];
        block_tile    *to = &out.tile[n];
        to->kind          = (uint16_t)t->kind;
        if (t->kind == TILE_UNIFORM || t->kind == TILE_PLANE) continue;
        b->set->tile_count++;
        if (t->kind == TILE_PRIVATE) {
            r = private_find(&b->set->privates, &t->ranges, &t->plane, &to->pattern, &to->base);
            to->base -= *base;
            continue;
        }
        mask_need needs[PALETTE_MAX - 1];
        to->palette = (uint16_t)tile_needs(t->low, t->high, codes, count, needs, b->set->patterns.cpu);
        r           = pattern_find(&b->set->patterns, __builtin_popcount(to->palette), needs, &to->pattern);
    }
    return r == VXS_OK ? block_set_find(b->set, &out, id) : r;
}
