/* libvxs: more than one lookup at a time, and questions about the volume of a light: where its light ends, along its rays and along any.
 *
 *     vxs_lookup_batch    many points, of any layout, in one light or in several
 *     vxs_first_shadow    of a texel, the depth at which light first ends
 *     vxs_depth_map       the same of a rectangle of texels, at any resolution
 *     vxs_lit_begin       along a ray, where it is lit
 *     vxs_lit_next
 *
 * Where pages are missing, what is said is the coarse answer (vxs_lookup_blocks.h), as lookups give it, and `coarse` is set.
 * As in vxs.h, nothing is allocated, and any number of threads may ask at once.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_QUERY_H
#define VXS_QUERY_H

#include "vxs.h"

#ifdef __cplusplus
extern "C" {
#endif

/* many lookups ------------------------------------------------------------------------------------------------------------------ */

/* What a coordinate is. */
#define VXS_F64 0u
#define VXS_F32 1u

/* Positions or normals as the caller has them: x, y, z side by side, one point every so many bytes. No alignment is asked for. */
typedef struct vxs_vectors {
    const void *data;
    size_t      stride_bytes; /* from one to the next; 0: they are packed, 24 or 12 */
    uint32_t    type;         /* VXS_F64, VXS_F32 */
} vxs_vectors;

/* Points that are looked up at once. It may grow in later versions. */
typedef struct vxs_batch {
    size_t      struct_size; /* sizeof(vxs_batch), as the caller knows it; 0: up to and with `light_stride_bytes` */
    vxs_vectors points_ws;   /* [count] as for vxs_lookup */
    vxs_vectors normals_ws;  /* [count]; data NULL: none */
    size_t      count;
    int         filter_px; /* as for vxs_lookup */
    float *lit; /* [out] of any alignment; of point p and light n: p * lit_stride_bytes + n * light_stride_bytes from here on */
    size_t lit_stride_bytes;   /* 0: sizeof(float) */
    size_t light_stride_bytes; /* 0: count * lit_stride_bytes, all points of the first light, then of the next */
} vxs_batch;

/* Look points up in lights. Each answer is that of vxs_lookup, bit for bit; a float is taken for the double that it is.
 * lights  [light_count] baked lights side by side: one of them; or vxs_asset_light(asset, 0) and vxs_asset_light_count(asset), all
 * Returns VXS_OK; VXS_E_ARGUMENT when `lit` or the data of points is NULL, a type is none of the above, or struct_size is none that a
 * version had, and nothing is written.
 * Cost: points that follow one another are best near one another, as the pixels of a tile of 8 x 8 are: what one needed is kept for the
 * next. Takes 48 KiB of stack. Threads: any. */
vxs_result vxs_lookup_batch(const vxs_baked_light *lights, uint32_t light_count, const vxs_batch *batch);

/* where light ends -------------------------------------------------------------------------------------------------------------- */

/* The first voxel of a texel that is in shadow: light ends between the texel's enter and exit depth (formats/vxs.md 2), rounded outward to
 * voxels. Of palette blocks all voxels behind it are in shadow, too; of a DAG those behind the exit depth.
 * map     as vxs_voxel returns it;   i, j  a texel of the map
 * coarse  [out] 1: a page is missing, and this is the coarse answer; else 0. NULL: nobody asks
 * Returns [0, 2^levels]; 2^levels: light does not end; -1 when there is no such map or texel. Threads: any. */
int32_t vxs_first_shadow(const vxs_baked_light *baked, int map, int32_t i, int32_t j, int *coarse);

/* Which depth a pixel of a depth map has that covers several texels: of the texel at its middle, which is what a map of that resolution is
 * rendered with; or the least or the greatest of all, which bound what lies in it. */
#define VXS_DEPTH_CENTRE   0u
#define VXS_DEPTH_LEAST    1u
#define VXS_DEPTH_GREATEST 2u

/* A rectangle of a map as a depth map. It may grow in later versions. */
typedef struct vxs_depth_map_desc {
    size_t    struct_size; /* sizeof(vxs_depth_map_desc), as the caller knows it; 0: up to and with `row_stride_bytes` */
    int32_t   map;         /* as vxs_voxel returns it */
    int32_t   i, j;        /* the first texel */
    uint32_t  wide_px, high_px;
    uint32_t  shift;            /* a pixel covers 2^shift x 2^shift texels; 0 to levels. The map at 2^r texels a side: levels - r */
    uint32_t  which;            /* VXS_DEPTH_* */
    uint32_t *voxels;           /* [out] [high_px] rows of vxs_first_shadow; NULL: none */
    float    *depths;           /* [out] [high_px] rows of the same over 2^levels, 0 near to 1 far; NULL: none */
    size_t    row_stride_bytes; /* of each of them; 0: rows are packed */
} vxs_depth_map_desc;

/* Texels that the map does not have are lit all along. Squares of one depth are filled at once.
 * coarse  [out] 1: pages are missing, and some depths are coarse answers; else 0. NULL: nobody asks
 * Returns VXS_OK; VXS_E_ARGUMENT when there is no such map, a number is out of range, the rectangle ends beyond 2^30 texels or
 * covers more along a side, or struct_size is none that a version had. Threads: any. */
vxs_result vxs_depth_map(const vxs_baked_light *baked, const vxs_depth_map_desc *desc, int *coarse);

/* lit intervals ------------------------------------------------------------------------------------------------------------------ */

#define VXS_INTERVAL_SHADOW  0
#define VXS_INTERVAL_LIT     1
#define VXS_INTERVAL_OUTSIDE 2 /* of the light's volume (vxs_voxel) */

/* Points origin + t * direction, t in [t_begin, t_end). */
typedef struct vxs_ray {
    double origin_ws[3],
        direction_ws[3];   /* metres; the direction of any length: t = 1 is a metre when that is 1. 0: all is at the origin */
    double t_begin, t_end; /* t_end may be INFINITY */
} vxs_ray;

/* A part of a ray, [t_begin, t_end), that is all lit, in shadow, or outside. */
typedef struct vxs_interval {
    double  t_begin, t_end;
    int32_t state;  /* VXS_INTERVAL_* */
    int32_t coarse; /* 1: a page is missing, and this is the coarse answer; else 0 */
} vxs_interval;

/* A walk along a ray, in the caller's memory; its fields are the library's. */
typedef struct vxs_lit_walk {
    const vxs_baked_light *baked;
    uint64_t               room[127]; /* for what is known of the ray, and more in later versions */
} vxs_lit_walk;

/* Begin at t_begin. The light is borrowed while the walk lasts, and its words must not change.
 * Returns VXS_OK; VXS_E_ARGUMENT when a number is NaN or, t_end apart, infinite; the origin or the direction lies beyond 1e50 metres; or
 * t_end is less than t_begin. Then there is nothing to walk. */
vxs_result vxs_lit_begin(vxs_lit_walk *walk, const vxs_baked_light *baked, const vxs_ray *ray);

/* The next intervals of a ray, exact to the voxel, one behind the other without gaps, each unlike the one before it: from t_begin of the
 * first to t_end of the last. A point between has that state as a single tap at it without a normal, but for rounding within its ends. A
 * segment without length has none.
 * intervals  [out] [capacity]
 * Returns how many were written. As many as there was room for: call again, there may be more; fewer: that was the end.
 * Cost: a step for each block, tile or texel that the ray cannot pass with more, whatever its length. Threads: a walk is one thread's; any
 * number of walks at once. */
size_t vxs_lit_next(vxs_lit_walk *walk, vxs_interval *intervals, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
