/* Depth maps under zstd; see baseline.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/baseline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "baker/base/array.h"
#include "baker/base/z_order.h"

enum { BAND_ROWS = 16 }; /* a sample is bands of rows, so that most rows keep the one above them */

void baseline_init(baseline *b, uint32_t map_px, uint32_t tile_px, size_t texels_a_map)
{
    uint32_t across = map_px / tile_px;
    *b = (baseline){.tile_px = tile_px, .tiles_a_map = across * across, .texels_a_tile = texels_a_map / (across * across)};
}

static uint16_t depth_of(const depth_maps *tile, size_t texel)
{
    double share = tile ? depth_maps_voxels(tile, tile->enter[texel]) / tile->depth_vx : 1;
    return (uint16_t)fmin(share * 65536, 65535);
}

/* Keep bands of the next tile; NULL: an empty one. */
static vxs_result add_tile(baseline *b, const depth_maps *tile)
{
    size_t   all   = (size_t)b->tile_px * b->tile_px;
    size_t   band  = (size_t)BAND_ROWS * b->tile_px;
    uint32_t bands = (b->tile_px + BAND_ROWS - 1) / BAND_ROWS;
    uint32_t keep  = b->texels_a_tile && b->texels_a_tile < all ? (uint32_t)(b->texels_a_tile / band) : bands;
    if (!keep) keep = 1;
    if (!array_reserve(&b->texels, &b->capacity, b->count + keep * band, sizeof *b->texels)) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < keep; n++) {
        size_t from = (size_t)((uint64_t)n * bands / keep) * band;
        size_t size = all - from < band ? all - from : band;
        for (size_t k = 0; k < size; k++) b->texels[b->count++] = depth_of(tile, from + k);
    }
    b->tiles_seen++;
    return VXS_OK;
}

static vxs_result add_empty(baseline *b, uint64_t until)
{
    vxs_result r = VXS_OK;
    while (b->tiles_seen < until && r == VXS_OK) r = add_tile(b, NULL);
    return r;
}

vxs_result baseline_add(baseline *b, const depth_maps *tile, uint32_t map, uint32_t i, uint32_t j)
{
    vxs_result r = add_empty(b, (uint64_t)map * b->tiles_a_map + z_number((z_place){i, j}));
    return r == VXS_OK ? add_tile(b, tile) : r;
}

vxs_result baseline_end(baseline *b, uint32_t map_count)
{
    return add_empty(b, (uint64_t)map_count * b->tiles_a_map);
}

double baseline_ratio(const baseline *b, double *share)
{
    double seen = (double)b->tiles_seen * b->tile_px * b->tile_px;
    *share      = seen > 0 ? (double)b->count / seen : 0;
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
