/* Filters over palette blocks whose neighbours ask near one another: tiles that were asked lately, kept as depths. Internal to the runtime;
 * not installed.
 *
 * A small depth map of 128 x 128 texels lies over the light's map again and again, like tiles on a floor: tile (x, y) has its place at
 * (x mod 16, y mod 16), with a tag of which tile is there. What a filter needs is read from there as from any depth map, eight texels at
 * once. Where tiles are not asked often enough to be worth it, lookups walk the blocks as they are.
 *
 *     tag        16 x 16     which tile it is; 0: none
 *     least      16 x 16     depths of its texels: all are lit before it,
 *     greatest   16 x 16     and in shadow from this on
 *     depth     128 x 152    rows: depths less one, so that each is an i16; the first columns again behind the last, for rows across the seam
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
    int32_t                credit;          /* what lookups have saved of what tiles took */
    int32_t                rest, next_rest; /* so many lookups walk the blocks before tiles are tried again; and the next time */
    uint32_t               tag[VXS_CACHE_TILES * VXS_CACHE_TILES];
    int16_t                least[VXS_CACHE_TILES * VXS_CACHE_TILES], greatest[VXS_CACHE_TILES * VXS_CACHE_TILES];
    int16_t                depth[VXS_CACHE_PX * VXS_CACHE_PITCH];
} vxs_tap_cache;

/* Whether a light is one for which this is: palette blocks, of which an i16 holds the depths. */
int vxs_tap_cache_serves(const vxs_baked_light *baked);

/* Empty, for a light that it serves. */
void vxs_tap_cache_init(vxs_tap_cache *cache, const vxs_baked_light *baked);

/* vxs_shadow_taps of such a light: the same answer. i, j  any; k  [0, 2^levels) */
uint32_t vxs_cached_taps(vxs_tap_cache *cache, uint32_t map, int32_t i, int32_t j, int32_t k, int32_t filter_px);

/* vxs_shadow_part of such a light: the same answer. k  [0, 2^levels) */
uint32_t vxs_cached_part(vxs_tap_cache *cache, vxs_place place, int32_t k, int32_t width_px);

#endif
