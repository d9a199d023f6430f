/* Cache of tile depths for filters over palette blocks, for lookups near one another. Internal to the runtime; not installed.
 *
 * The cache is a depth map of 128 x 128 texels that repeats over the light's map: tile (x, y) is stored at (x mod 16, y mod 16),
 * and a tag identifies the stored tile. Filters read it like any depth map, eight texels at once. When tiles are not reused often
 * enough, lookups walk the blocks instead.
 *
 *     tag        16 x 16     number of the stored tile; 0: none
 *     least      16 x 16     depths of its texels: all texels are lit before the least,
 *     greatest   16 x 16     and in shadow from the greatest on
 *     depth     128 x 152    rows: depth - 1, so that each fits i16; columns 0 to 23 are repeated behind the last, so that a row
 *               can be read across the seam
 *
 * SPDX-License-Identifier: MIT */
#ifndef VXS_TAP_CACHE_H
#define VXS_TAP_CACHE_H

#include "block_depths.h"
#include "vxs_space.h"

enum { VXS_CACHE_TILES = 16, VXS_CACHE_PX = 8 * VXS_CACHE_TILES, VXS_CACHE_PITCH = VXS_CACHE_PX + 24, VXS_CACHE_LEVELS_MAX = 15 };

typedef struct vxs_tap_cache {
    const vxs_baked_light *baked;
    uint32_t               cursor_map;
    vxs_block_cursor       cursor;
    int32_t                credit;          /* time that lookups saved, less the time for decoding tiles */
    int32_t                rest, next_rest; /* rest: lookups before tiles are tried again; next_rest: its next length */
    uint32_t               tag[VXS_CACHE_TILES * VXS_CACHE_TILES];
    int16_t                least[VXS_CACHE_TILES * VXS_CACHE_TILES], greatest[VXS_CACHE_TILES * VXS_CACHE_TILES];
    int16_t                depth[VXS_CACHE_PX * VXS_CACHE_PITCH];
} vxs_tap_cache;

/* Whether the cache supports a light: palette blocks, with depths that fit i16. */
int vxs_tap_cache_serves(const vxs_baked_light *baked);

/* Initialize an empty cache for a supported light. */
void vxs_tap_cache_init(vxs_tap_cache *cache, const vxs_baked_light *baked);

/* Same result as vxs_shadow_taps. i, j  any; k  [0, 2^levels) */
uint32_t vxs_cached_taps(vxs_tap_cache *cache, uint32_t map, int32_t i, int32_t j, int32_t k, int32_t filter_px);

/* Same result as vxs_shadow_part. k  [0, 2^levels) */
uint32_t vxs_cached_part(vxs_tap_cache *cache, vxs_place place, int32_t k, int32_t width_px);

#endif
