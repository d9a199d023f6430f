/* Taps of a filter at many voxels of a light, for any coding: data of one walk is kept for the next. Internal to the runtime; not
 * installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_TAPS_MANY_H
#define VXS_TAPS_MANY_H

#include "dag_path.h"
#include "tap_cache.h"
#include "vxs_space.h"

typedef struct vxs_taps {
    const vxs_baked_light *baked;
    uint32_t               cached, paths;
    union {
        vxs_tap_cache cache;
        vxs_dag_path  path[VXS_CUBE_FACES];
    } kept;
} vxs_taps;

static inline void vxs_taps_init(vxs_taps *taps, const vxs_baked_light *baked)
{
    taps->baked  = baked;
    taps->cached = (uint32_t)vxs_tap_cache_serves(baked);
    taps->paths  = baked->light.coding == VXS_CODING_DAG ? vxs_map_count(&baked->light) : 0;
    if (taps->cached) vxs_tap_cache_init(&taps->kept.cache, baked);
    for (uint32_t map = 0; map < taps->paths; map++) vxs_dag_path_init(&taps->kept.path[map], baked, map);
}

/* Same result as vxs_shadow_taps. */
static inline uint32_t vxs_taps_at(vxs_taps *taps, int32_t map, int32_t i, int32_t j, uint32_t k, int32_t filter_px)
{
    if (taps->cached) return vxs_cached_taps(&taps->kept.cache, (uint32_t)map, i, j, (int32_t)k, filter_px);
    if (!taps->paths) return vxs_shadow_taps(taps->baked->words, &taps->baked->light, map, i, j, k, filter_px);
    if (filter_px == 1) return vxs_dag_path_shadow(&taps->kept.path[map], (uint32_t)i, (uint32_t)j, k);
    return vxs_dag_path_count(&taps->kept.path[map], i, j, k, filter_px);
}

/* Same result as vxs_shadow_part. */
static inline uint32_t vxs_taps_part(vxs_taps *taps, vxs_place place, uint32_t k, int32_t width_px)
{
    if (taps->cached) return vxs_cached_part(&taps->kept.cache, place, (int32_t)k, width_px);
    if (!taps->paths) return vxs_shadow_part(taps->baked->words, &taps->baked->light, place, k, width_px);
    vxs_smooth_box box = vxs_smooth_box_at(place.voxel[0], place.voxel[1], place.across, place.down, width_px);
    return vxs_dag_path_weight(&taps->kept.path[place.map], box, k, width_px);
}

#endif
