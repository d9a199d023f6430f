/* Visibility masks with reuse depths; see masks.h.
 *
 * Both rules walk a tile from its xmin, the first depth that must not be all lit, to its emax, the first that may be all shadow.
 * At depth k0 every texel that may be shadowed is, that is e <= k0:
 *
 *        k ->      xmin                           emax
 *     texel a  ......e~~~~x############################      . lit   ~ free   # shadow
 *     texel b  .........e~~~~~~~~~~x###################
 *     texel c  .............................e~~~~~~~~~~
 *     greedy         [   a     ][  a b       ][ all            the mask changes where a lit texel has to go dark (x)
 *     shadow   ......[ab][ a b              ][ all             the mask changes where a lit texel may go dark (e)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/dag/masks.h"

#include <stdlib.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* A tile's columns relative to its xmin, in 16 bits: depths before xmin become 0 and depths beyond emax `FAR`. That changes no mask,
 * since only depths of [xmin, emax) are asked about. */
enum { FAR = 32767 };

typedef struct near_columns {
    _Alignas(16) int16_t e[64];    /* a texel may be dark from here on */
    _Alignas(16) int16_t next[64]; /* a texel that was left lit ends the run here: x, or e under the older rule */
} near_columns;

static void columns_relative(near_columns *out, const column_tile *columns, uint32_t base, mask_rule rule)
{
    const uint32_t *next = rule == MASK_RULE_GREEDY ? columns->x : columns->e;
    for (int n = 0; n < 64; n++) {
        uint32_t e   = columns->e[n] > base ? columns->e[n] - base : 0;
        uint32_t x   = next[n] > base ? next[n] - base : 0;
        out->e[n]    = (int16_t)(e < FAR ? e : FAR);
        out->next[n] = (int16_t)(x < FAR ? x : FAR);
    }
}

/* The mask at depth k0 and, in *next, the least `next` of the texels that it leaves lit; FAR when there is none. */
static uint64_t mask_at(const near_columns *c, int16_t k0, int16_t *next)
{
#ifdef __SSE2__
    __m128i  k     = _mm_set1_epi16(k0);
    __m128i  far   = _mm_set1_epi16(FAR);
    __m128i  least = far;
    uint64_t lit   = 0;
    for (int row = 0; row < 8; row += 2) {
        __m128i a = _mm_cmpgt_epi16(_mm_load_si128((const __m128i *)&c->e[row * 8]), k);
        __m128i b = _mm_cmpgt_epi16(_mm_load_si128((const __m128i *)&c->e[row * 8 + 8]), k);
        __m128i p = _mm_load_si128((const __m128i *)&c->next[row * 8]);
        __m128i q = _mm_load_si128((const __m128i *)&c->next[row * 8 + 8]);
        least     = _mm_min_epi16(least, _mm_or_si128(_mm_and_si128(a, p), _mm_andnot_si128(a, far)));
        least     = _mm_min_epi16(least, _mm_or_si128(_mm_and_si128(b, q), _mm_andnot_si128(b, far)));
        lit |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_packs_epi16(a, b)) << (row * 8);
    }
    least = _mm_min_epi16(least, _mm_srli_si128(least, 8));
    least = _mm_min_epi16(least, _mm_srli_si128(least, 4));
    least = _mm_min_epi16(least, _mm_srli_si128(least, 2));
    *next = (int16_t)_mm_extract_epi16(least, 0);
    return ~lit;
#else
    uint64_t shadow = 0;
    int16_t  least  = FAR;
    for (int n = 0; n < 64; n++) {
        if (c->e[n] <= k0)
            shadow |= (uint64_t)1 << n;
        else if (c->next[n] < least)
            least = c->next[n];
    }
    *next = least;
    return shadow;
#endif
}

/* The same for any depths: tiles that hold a cliff of more than FAR voxels. */
static uint64_t mask_at_far(const column_tile *c, uint32_t k0, mask_rule rule, uint32_t *next)
{
    const uint32_t *ends   = rule == MASK_RULE_GREEDY ? c->x : c->e;
    uint64_t        shadow = 0;
    *next                  = UINT32_MAX;
    for (int n = 0; n < 64; n++) {
        if (c->e[n] <= k0)
            shadow |= (uint64_t)1 << n;
        else if (ends[n] < *next)
            *next = ends[n];
    }
    return shadow;
}

static int reserve_runs(tile_masks *t, uint32_t more)
{
    if (t->run_capacity - t->run_count >= more) return 1;
    if (t->run_capacity > UINT32_MAX / 2) return 0;
    uint32_t  capacity = t->run_capacity ? t->run_capacity * 2 : 4096;
    uint64_t *mask     = realloc(t->mask, capacity * sizeof *mask);
    if (mask) t->mask = mask;
    uint32_t *until = realloc(t->until, capacity * sizeof *until);
    if (until) t->until = until;
    if (!mask || !until) return 0;
    t->run_capacity = capacity;
    return 1;
}

static void add_run(tile_masks *t, uint64_t mask, uint32_t until)
{
    t->mask[t->run_count]    = mask;
    t->until[t->run_count++] = until;
}

/* At most 64 runs a tile: each one but the last ends where a texel goes dark. */
static void tile_runs(tile_masks *t, const column_tile *columns, column_bounds b, mask_rule rule)
{
    if (b.emax - b.xmin >= FAR) {
        for (uint32_t k0 = b.xmin, next; k0 < b.emax; k0 = next) {
            uint64_t mask = mask_at_far(columns, k0, rule, &next);
            if (next > b.emax) next = b.emax;
            add_run(t, mask, next);
        }
        return;
    }
    near_columns near;
    columns_relative(&near, columns, b.xmin, rule);
    int16_t end = (int16_t)(b.emax - b.xmin);
    for (int16_t k0 = 0, next; k0 < end; k0 = next) {
        uint64_t mask = mask_at(&near, k0, &next);
        if (next > end) next = end;
        add_run(t, mask, b.xmin + (uint32_t)next);
    }
}

/* Bounds may be loose; runs must not depend on how loose, so the tile's own columns decide. */
static column_bounds tile_bounds(const column_tile *columns)
{
    column_bounds b = {columns->e[0], columns->e[0], columns->x[0], columns->x[0]};
    for (int n = 1; n < 64; n++) {
        b.emin = columns->e[n] < b.emin ? columns->e[n] : b.emin;
        b.emax = columns->e[n] > b.emax ? columns->e[n] : b.emax;
        b.xmin = columns->x[n] < b.xmin ? columns->x[n] : b.xmin;
        b.xmax = columns->x[n] > b.xmax ? columns->x[n] : b.xmax;
    }
    return b;
}

vxs_result tile_masks_build(tile_masks *out, const column_source *source, uint32_t i, uint32_t j, uint32_t side_tiles,
                            mask_rule rule)
{
    memset(out, 0, sizeof *out);
    out->side_tiles = side_tiles;
    size_t tiles    = (size_t)side_tiles * side_tiles;
    out->first      = malloc((tiles + 1) * sizeof *out->first);
    out->xmin       = malloc(tiles * sizeof *out->xmin);
    out->emax       = malloc(tiles * sizeof *out->emax);
    int failed      = !out->first || !out->xmin || !out->emax;

    for (size_t t = 0; t < tiles && !failed; t++) {
        uint32_t      x = i + (uint32_t)(t % side_tiles), y = j + (uint32_t)(t / side_tiles);
        column_bounds bounds = source->bounds(source->data, 0, x, y);
        out->first[t]        = out->run_count;
        if (bounds.emax > bounds.xmin) {
            column_tile columns;
            source->tile(source->data, x, y, &columns);
            bounds = tile_bounds(&columns);
            failed = !reserve_runs(out, 64);
            if (!failed) tile_runs(out, &columns, bounds, rule);
        }
        out->xmin[t] = bounds.xmin;
        out->emax[t] = bounds.emax;
    }
    if (failed) {
        tile_masks_free(out);
        return VXS_E_MEMORY;
    }
    out->first[tiles] = out->run_count;
    return VXS_OK;
}

void tile_masks_free(tile_masks *t)
{
    free(t->first);
    free(t->xmin);
    free(t->emax);
    free(t->mask);
    free(t->until);
    memset(t, 0, sizeof *t);
}
