/* The 16-bit depth map under zstd -19; see baseline.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/baseline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

enum { BAND_ROWS = 16 }; /* a sample is bands of rows, so that most rows keep the one above them */

static int reserve(baseline *b, size_t more)
{
    if (b->capacity - b->count >= more) return 1;
    uint16_t *grown = realloc(b->texels, (b->count + more) * sizeof *grown);
    if (!grown) return 0;
    b->texels   = grown;
    b->capacity = b->count + more;
    return 1;
}

int baseline_add(baseline *b, const depth_maps *maps, int empty)
{
    uint32_t side_px = maps->side_px;
    size_t   all     = (size_t)side_px * side_px;
    size_t   band    = (size_t)BAND_ROWS * side_px;
    uint32_t bands   = (side_px + BAND_ROWS - 1) / BAND_ROWS;
    uint32_t keep    = b->limit_per_map && b->limit_per_map < all ? (uint32_t)(b->limit_per_map / band) : bands;
    if (!keep) keep = 1;
    if (!reserve(b, keep * band)) return 0;
    for (uint32_t n = 0; n < keep; n++) {
        size_t from = (size_t)((uint64_t)n * bands / keep) * band;
        size_t size = all - from < band ? all - from : band;
        for (size_t k = 0; k < size; k++) {
            double d              = empty ? 1 : depth_maps_voxels(maps, maps->enter[from + k]) / maps->depth_vx;
            b->texels[b->count++] = (uint16_t)fmin(d * 65536, 65535);
        }
    }
    b->seen += all;
    return 1;
}

double baseline_ratio(const baseline *b, double *share)
{
    *share = b->seen ? (double)b->count / (double)b->seen : 0;
    if (!b->count) return 0;
    size_t raw   = b->count * sizeof *b->texels;
    size_t bound = ZSTD_compressBound(raw);
    void  *to    = malloc(bound);
    size_t size  = to ? ZSTD_compress(to, bound, b->texels, raw, 19) : 0;
    free(to);
    return to && !ZSTD_isError(size) ? (double)size / (double)raw : 0;
}

void baseline_free(baseline *b)
{
    free(b->texels);
    memset(b, 0, sizeof *b);
}
