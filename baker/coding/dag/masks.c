/* Visibility masks with reuse depths; see column_tree.h.
 *
 * Both rules walk a tile from its xmin, the first depth where a texel must be shadowed, to its emax, the first where all texels may
 * be. At depth k0 every texel is shadowed that may be, that is e <= k0:
 *
 *        k ->      xmin                           emax
 *     texel a  ......e~~~~x############################      . lit   ~ don't care   # shadow
 *     texel b  .........e~~~~~~~~~~x###################
 *     texel c  .............................e~~~~~~~~~~
 *     greedy         [   a     ][  a b       ][ all            the mask changes where a lit texel must become shadowed (x)
 *     shadow   ......[ab][ a b              ][ all             the mask changes where a lit texel may become shadowed (e)
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/column_tree.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* A tile's columns relative to its xmin, in 16 bits. Depths before xmin become 0, and depths beyond emax `FAR`. This changes no
 * mask, because only depths in [xmin, emax) matter. */
enum { FAR = 32767 };

typedef struct near_columns {
    _Alignas(16) int16_t e[64];    /* the texel may be shadowed from here on */
    _Alignas(16) int16_t next[64]; /* a texel left lit ends the run here: x, or e with MASK_RULE_SHADOW */
} near_columns;

/* The mask at depth k0; *next becomes the least `next` of its lit texels, FAR if there is none. */
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

uint32_t tile_runs(const column_tile *columns, mask_rule rule, mask_run runs[TILE_RUNS_MAX], column_bounds *bounds)
{
    column_bounds   b     = tile_bounds(columns); /* bounds from a source may be loose; the runs must not depend on that */
    const uint32_t *ends  = rule == MASK_RULE_GREEDY ? columns->x : columns->e;
    uint32_t        count = 0;
    *bounds               = b;
    if (b.emax <= b.xmin) return 0;
    if (b.emax - b.xmin >= FAR) {
        /* as below, without a limit on depths, for tiles with a cliff of more than FAR voxels */
        for (uint32_t k0 = b.xmin, next; k0 < b.emax; k0 = next) {
            uint64_t mask = 0;
            next          = UINT32_MAX;
            for (int n = 0; n < 64; n++) {
                if (columns->e[n] <= k0)
                    mask |= (uint64_t)1 << n;
                else if (ends[n] < next)
                    next = ends[n];
            }
            next          = min_u32(next, b.emax);
            runs[count++] = (mask_run){mask, next};
        }
        return count;
    }
    near_columns near;
    for (int n = 0; n < 64; n++) {
        uint32_t e   = columns->e[n] > b.xmin ? columns->e[n] - b.xmin : 0;
        uint32_t x   = ends[n] > b.xmin ? ends[n] - b.xmin : 0;
        near.e[n]    = (int16_t)(e < FAR ? e : FAR);
        near.next[n] = (int16_t)(x < FAR ? x : FAR);
    }
    int16_t end = (int16_t)(b.emax - b.xmin);
    for (int16_t k0 = 0, next; k0 < end; k0 = next) {
        uint64_t mask = mask_at(&near, k0, &next);
        next          = next < end ? next : end;
        runs[count++] = (mask_run){mask, b.xmin + (uint32_t)next};
    }
    return count;
}
