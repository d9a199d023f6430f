/* Taps of a filter at many voxels of a light that are near one another, for any coding: data of one walk is kept for the next.
 * Palette blocks have a cache of tile depths, a DAG the path of the last walk. Internal to the runtime; not installed.
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
#ifndef VXS_TAPS_MANY_H
#define VXS_TAPS_MANY_H

#include "tile_depths.h"
#include "vxs_file.h"
#include "vxs_lookup.h"
#include "vxs_space.h"

/* cache of tile depths, for filters over palette blocks ------------------------------------------------------------------------- */

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
uint32_t vxs_cached_taps(vxs_tap_cache *cache, uint32_t map, int32_t i, int32_t j, int32_t k, int32_t width_px);

/* Same result as vxs_shadow_part. k  [0, 2^levels) */
uint32_t vxs_cached_part(vxs_tap_cache *cache, vxs_place place, int32_t k, int32_t width_px);

/* path of the last walk through a DAG: two neighbouring slices share their upper nodes ------------------------------------------ */

/* The last walk: node[l] has a side of 8 << l voxels. It ended at level `end`: at a uniform child with state `state`, or at level
 * 0. */
typedef struct vxs_dag_path {
    const uint32_t *words;
    uint32_t        levels, root;
    uint32_t        x, y, z; /* position of the last slice's node of side 8 */
    uint32_t        end, state;
    uint32_t        node[VXS_LEVELS_MAX - 2];
} vxs_dag_path;

/* Start at the root of a map. */
void vxs_dag_path_init(vxs_dag_path *path, const vxs_baked_light *baked, uint32_t map);

/* Same results as vxs_shadow, vxs_shadow_count and vxs_shadow_weight. */
uint32_t vxs_dag_path_shadow(vxs_dag_path *path, uint32_t i, uint32_t j, uint32_t k);
uint32_t vxs_dag_path_count(vxs_dag_path *path, int32_t i, int32_t j, uint32_t k, int32_t width_px);
uint32_t vxs_dag_path_weight(vxs_dag_path *path, vxs_smooth_box box, uint32_t k, int32_t width_px);

/* walks ------------------------------------------------------------------------------------------------------------------------- */

/* vxs_shadow_taps, vxs_shadow_part and vxs_place_from_ws. They are large: with VXS_SMALL all callers share those of lookup.c, which makes
 * a single lookup a tenth to a quarter slower. */
#ifdef VXS_SMALL
#define VXS_TAPS_FN
uint32_t  vxs_walk_taps(const vxs_baked_light *baked, int32_t map, int32_t i, int32_t j, uint32_t k, int32_t width_px);
uint32_t  vxs_walk_part(const vxs_baked_light *baked, vxs_place place, uint32_t k, int32_t width_px);
vxs_place vxs_place_of(const vxs_light *light, const double point_ws[3], const double normal_ws[3], vxs_filter filter);
#else
#define VXS_TAPS_FN static inline
#endif

#if !defined(VXS_SMALL) || defined(VXS_WALKS_HERE)
VXS_TAPS_FN uint32_t vxs_walk_taps(const vxs_baked_light *baked, int32_t map, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    return vxs_shadow_taps(baked->words, &baked->light, map, i, j, k, width_px);
}

VXS_TAPS_FN uint32_t vxs_walk_part(const vxs_baked_light *baked, vxs_place place, uint32_t k, int32_t width_px)
{
    return vxs_shadow_part(baked->words, &baked->light, place, k, width_px);
}

VXS_TAPS_FN vxs_place vxs_place_of(const vxs_light *light, const double point_ws[3], const double normal_ws[3], vxs_filter filter)
{
    return vxs_place_from_ws(light, point_ws, normal_ws, filter);
}
#endif

/* any coding -------------------------------------------------------------------------------------------------------------------- */

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
static inline uint32_t vxs_taps_at(vxs_taps *taps, int32_t map, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    if (taps->cached) return vxs_cached_taps(&taps->kept.cache, (uint32_t)map, i, j, (int32_t)k, width_px);
    if (!taps->paths) return vxs_walk_taps(taps->baked, map, i, j, k, width_px);
    if (width_px == 1) return vxs_dag_path_shadow(&taps->kept.path[map], (uint32_t)i, (uint32_t)j, k);
    return vxs_dag_path_count(&taps->kept.path[map], i, j, k, width_px);
}

/* Same result as vxs_shadow_part. */
static inline uint32_t vxs_taps_part(vxs_taps *taps, vxs_place place, uint32_t k, int32_t width_px)
{
    if (taps->cached) return vxs_cached_part(&taps->kept.cache, place, (int32_t)k, width_px);
    if (!taps->paths) return vxs_walk_part(taps->baked, place, k, width_px);
    vxs_smooth_box box = vxs_smooth_box_at(place.voxel[0], place.voxel[1], place.across, place.down, width_px);
    return vxs_dag_path_weight(&taps->kept.path[place.map], box, k, width_px);
}

#endif
