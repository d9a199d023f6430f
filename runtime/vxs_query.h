/* libvxs: lookups of many points, and queries of the shadow depth of texels and the lit parts of rays.
 *
 *     vxs_lookup_batch    many points, of any layout, in one light or in several
 *     vxs_first_shadow    depth at which light first ends in a texel
 *     vxs_depth_map       the same for a rectangle of texels, at any resolution
 *     vxs_lit_begin       lit intervals along a ray
 *     vxs_lit_next
 *
 * Where pages are missing, the result is the coarse answer (vxs_lookup_blocks.h), as for lookups, and `coarse` is set. As in
 * vxs.h, nothing is allocated, and any number of threads may call these functions at once.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_QUERY_H
#define VXS_QUERY_H

#include "vxs.h"

#ifdef __cplusplus
extern "C" {
#endif

/* many lookups ---------------------------------------------------------------------------------------------------------------- */

/* Type of a coordinate. */
#define VXS_F64 0u
#define VXS_F32 1u

/* Positions or normals in the caller's layout: x, y, z adjacent, one point every stride_bytes. Any alignment is allowed. */
typedef struct vxs_vectors {
    const void *data;
    size_t      stride_bytes; /* from one point to the next; 0: packed, 24 or 12 */
    uint32_t    type;         /* VXS_F64, VXS_F32 */
} vxs_vectors;

/* Points of one vxs_lookup_batch. It may grow in later versions. */
typedef struct vxs_batch {
    size_t      struct_size; /* the caller's sizeof(vxs_batch); 0: up to and including `light_stride_bytes` */
    vxs_vectors points_ws;   /* [count] as for vxs_lookup */
    vxs_vectors normals_ws;  /* [count]; data NULL: none */
    size_t      count;
    vxs_filter  filter; /* as for vxs_lookup */
    float      *lit; /* [out] any alignment; result of point p and light n at byte p * lit_stride_bytes + n * light_stride_bytes */
    size_t      lit_stride_bytes;   /* 0: sizeof(float) */
    size_t      light_stride_bytes; /* 0: count * lit_stride_bytes: all points of one light, then of the next */
} vxs_batch;

/* Look up points in lights. Each result equals that of vxs_lookup bit for bit; float coordinates are converted to double.
 * lights  [light_count] contiguous baked lights: one light, or all: vxs_asset_light(asset, 0) and vxs_asset_light_count(asset)
 * Returns VXS_OK; VXS_E_ARGUMENT when `lit` or the data of points is NULL, a type is not VXS_F64 or VXS_F32, or struct_size is
 * one that no version had. Then nothing is written.
 * Cost: lowest when consecutive points are near one another, such as pixels of a tile of 8 x 8, because data of one point is
 * reused for the next. Uses 48 KiB of stack. Threads: any. */
vxs_result vxs_lookup_batch(const vxs_baked_light *lights, uint32_t light_count, const vxs_batch *batch);

/* where light ends ------------------------------------------------------------------------------------------------------------ */

/* First voxel of a texel that is in shadow: between the texel's enter and exit depth (formats/vxs.md 2), rounded outward to
 * voxels. In palette blocks all voxels behind it are in shadow too; in a DAG those behind the exit depth are.
 * map     as vxs_voxel returns it
 * i, j    a texel of the map
 * coarse  [out] 1: a page is missing, and this is the coarse answer; else 0. NULL: not wanted
 * Returns [0, 2^levels]; 2^levels: the texel has no shadow; -1: no such map or texel. Threads: any. */
int32_t vxs_first_shadow(const vxs_baked_light *baked, int map, int32_t i, int32_t j, int *coarse);

/* Depth of a depth-map pixel that covers several texels: CENTRE: of the texel at its middle, as a map rendered at that resolution
 * has; LEAST, GREATEST: least or greatest depth of all covered texels, which bound them. */
#define VXS_DEPTH_CENTRE   0u
#define VXS_DEPTH_LEAST    1u
#define VXS_DEPTH_GREATEST 2u

/* Rectangle of a map to write as a depth map. It may grow in later versions. */
typedef struct vxs_depth_map_desc {
    size_t    struct_size; /* the caller's sizeof(vxs_depth_map_desc); 0: up to and including `row_stride_bytes` */
    int32_t   map;         /* as vxs_voxel returns it */
    int32_t   i, j;        /* first texel of the rectangle */
    uint32_t  wide_px, high_px;
    uint32_t  shift;  /* a pixel covers 2^shift x 2^shift texels; 0 to levels. For a map of 2^r pixels a side: levels - r */
    uint32_t  which;  /* VXS_DEPTH_* */
    uint32_t *voxels; /* [out] [high_px] rows of voxel depths, as vxs_first_shadow; NULL: not wanted */
    float    *depths; /* [out] [high_px] rows of the same divided by 2^levels, 0 near to 1 far; NULL: not wanted */
    size_t    row_stride_bytes; /* of each output; 0: rows are packed */
} vxs_depth_map_desc;

/* Write a depth map. Texels outside the map are lit at all depths. Squares of uniform depth are filled at once.
 * coarse  [out] 1: pages are missing, and some depths are coarse answers; else 0. NULL: not wanted
 * Returns VXS_OK; VXS_E_ARGUMENT when there is no such map, a number is out of range, the rectangle reaches beyond +-2^30 texels
 * or is larger than 2^30 texels along a side, or struct_size is one that no version had. Threads: any. */
vxs_result vxs_depth_map(const vxs_baked_light *baked, const vxs_depth_map_desc *desc, int *coarse);

/* lit intervals --------------------------------------------------------------------------------------------------------------- */

#define VXS_INTERVAL_LIT     0
#define VXS_INTERVAL_SHADOW  1
#define VXS_INTERVAL_OUTSIDE 2 /* outside the light's volume (vxs_voxel) */

/* Points origin + t * direction, t in [t_begin, t_end). */
typedef struct vxs_ray {
    double origin_ws[3],
        direction_ws[3];   /* metres; the direction has any length: with length 1, t is in metres. 0: all points are the origin */
    double t_begin, t_end; /* t_end may be INFINITY */
} vxs_ray;

/* Part of a ray, [t_begin, t_end), that is all lit, all in shadow, or all outside. */
typedef struct vxs_interval {
    double  t_begin, t_end;
    int32_t state;  /* VXS_INTERVAL_* */
    int32_t coarse; /* 1: a page is missing, and this is the coarse answer; else 0 */
} vxs_interval;

/* State of a walk along a ray, in the caller's memory. Callers do not use its fields. */
typedef struct vxs_lit_walk {
    const vxs_baked_light *baked;
    uint64_t               room[127]; /* internal state, with spare space for later versions */
} vxs_lit_walk;

/* Start a walk at t_begin. The light is borrowed during the walk, and its words must not change.
 * Returns VXS_OK; VXS_E_ARGUMENT when a number is NaN; when one other than t_end is infinite; when the origin or direction has a
 * coordinate beyond +-1e50; or when t_end is less than t_begin. Then the walk has no intervals. */
vxs_result vxs_lit_begin(vxs_lit_walk *walk, const vxs_baked_light *baked, const vxs_ray *ray);

/* Get the next intervals of a ray, exact to the voxel. They follow one another without gaps from the ray's t_begin to its t_end,
 * and adjacent intervals differ. Each point in an interval has the state of a single tap there without a normal, except for
 * rounding at the ends. A segment of length 0 has no intervals.
 * intervals  [out] [capacity]
 * Returns how many were written. If it equals capacity, call again: there may be more. If it is less, the ray has ended.
 * Cost: one step for each block, tile or texel that cannot be passed in a larger step, whatever the length of the ray. Threads:
 * one at a time for each walk; any number of walks at once. */
size_t vxs_lit_next(vxs_lit_walk *walk, vxs_interval *intervals, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
