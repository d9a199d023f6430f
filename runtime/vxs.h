/* libvxs: lookups in baked shadows. A game needs to include this header only.
 *
 *     vxs_asset *asset;
 *     if (vxs_asset_open_file(&asset, "level.vxs", NULL) != VXS_OK) ...
 *     const vxs_baked_light *sun = vxs_asset_light(asset, 0);
 *     float lit = vxs_lookup(sun, position_ws, normal_ws, vxs_box(9));     // 9 x 9 PCF: 0 dark .. 1 lit, or VXS_OUTSIDE
 *     float lit = vxs_lookup(sun, position_ws, normal_ws, vxs_smooth(9));  // the same without steps of a texel
 *     vxs_asset_close(asset);
 *
 * The library allocates memory in open functions only, never prints, never exits, and has no global state. An open asset is
 * read-only: any number of threads may look it up at once. For levels larger than memory, and where the first lookup must not wait
 * until all pages are decoded, use vxs_stream.h. For lookups on a GPU upload a light's words and its vxs_light_constants_of, and
 * compile the texts of vxs_lookup.h, vxs_lookup_blocks.h and vxs_space.h into the shader (docs/runtime.md).
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_H
#define VXS_H

#include "vxs_file.h"

#ifdef __cplusplus
extern "C" {
#endif

#define VXS_VERSION_MAJOR 0
#define VXS_VERSION_MINOR 2
#define VXS_VERSION_PATCH 0

#define VXS_VERSION_NUMBER (10000 * VXS_VERSION_MAJOR + 100 * VXS_VERSION_MINOR + VXS_VERSION_PATCH)

/* Result of a lookup at a point outside the light's volume. */
#define VXS_OUTSIDE (-1.0f)

typedef struct vxs_asset vxs_asset;

/* Check a whole file in memory and prepare it for lookups.
 * asset  [out] NULL on failure; close it with vxs_asset_close
 * bytes  [size_bytes] a .vxs file; only read; may be freed after the call
 * desc   allocator, memory limit, findings (vxs_file.h); NULL: all defaults
 * Returns VXS_OK; VXS_E_NOT_VXS, VXS_E_VERSION, VXS_E_TRUNCATED, VXS_E_CORRUPT for invalid bytes, which never abort the program;
 * VXS_E_MEMORY; VXS_E_ARGUMENT for a struct_size that no version had. */
vxs_result vxs_asset_open(vxs_asset **asset, const void *bytes, size_t size_bytes, const vxs_read_desc *desc);

/* The same for a file. The bytes of the file count towards the memory limit during the call. The header is checked before memory
 * for the rest is allocated.
 * path  UTF-8
 * Also returns VXS_E_ARGUMENT when path is NULL; VXS_E_NO_FILE; VXS_E_READ: a folder, a pipe, no permission, a read error. */
vxs_result vxs_asset_open_file(vxs_asset **asset, const char *path, const vxs_read_desc *desc);

/* Accepts NULL. */
void vxs_asset_close(vxs_asset *asset);

/* Returns at least 1. */
uint32_t vxs_asset_light_count(const vxs_asset *asset);

/* Returns light `index` with its words, in file order; NULL when index is not below the light count. Valid until
 * vxs_asset_close. */
const vxs_baked_light *vxs_asset_light(const vxs_asset *asset, uint32_t index);

/* Returns the light with this name; NULL when there is none or name is NULL. */
const vxs_baked_light *vxs_asset_find_light(const vxs_asset *asset, const char *name);

/* Returns the baked smoke of light `index`; NULL when it has none. Valid until vxs_asset_close. */
const vxs_baked_smoke *vxs_asset_smoke(const vxs_asset *asset, uint32_t index);

/* Returns points on the surfaces that cast shadow; NULL when the file has none. Valid until vxs_asset_close. */
const vxs_baked_points *vxs_asset_points(const vxs_asset *asset);

/* Convert these points to floats.
 * origin_ws  metres; subtracted from each position. Choose a nearby one, because a float has 24 bits. NULL: (0, 0, 0)
 * out        [4 * points->count] position in metres, then the area in square metres that the point represents: as vxs_area_point */
void vxs_points_unpack(const vxs_baked_points *points, const double origin_ws[3], float *out);

/* Returns all file contents: sections, metadata. Valid until vxs_asset_close. */
const vxs_contents *vxs_asset_contents(const vxs_asset *asset);

/* Find the voxel of a point.
 * point_ws   world space, metres: any numbers. A point with NaN or infinity is outside. So is a point whose squared distance to a
 *            spot or point light overflows (about 1e154 m)
 * normal_ws  NULL, or the normal of the surface at the point, of any length. The voxel is moved off the surface (the bias) so
 *            that the surface does not shade itself, as far as the filter, the texel size and the voxel depth require: at most
 *            1.2 * (width_px + 1) / 2 + 1 texels across the map, and 0.2 * width_px texels and 2 voxels along the light. (0, 0,
 *            0) or a normal with NaN does not move it. The moved voxel may leave the map of a directional light: then it is
 *            outside. In the maps of a spot or point light it is clamped
 * filter     of the lookup, as for vxs_lookup
 * voxel      [out] [0] and [1] texels, [2] depth; may be outside the map. Coordinates are clamped to +-2^30; NaN becomes -2^30
 * Returns the map of the voxel: 0, or 0 to 5 for a light with six maps (VXS_LIGHT_CUBE); -1 when the point is outside the light's
 * volume. The volume of a directional light is the prism over its map: all points in front of the map are lit, and points behind
 * it have the state of the map's last voxel. A bounded light (baked for a region) also ends at its near and far sides. The volume
 * of a spot or point light is its cone and range. */
int vxs_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], vxs_filter filter, int32_t voxel[3]);

/* Inverse of vxs_voxel: world-space point of light-space coordinates: texels u, v and depth in voxels, all fractional.
 * map  as vxs_voxel returns it; clamped to the maps of the light */
void vxs_point(const vxs_light *light, int map, const double coordinates[3], double point_ws[3]);

/* Lit fraction of a filter in light space around a point.
 * baked      a light with its words, as from vxs_asset_light
 * point_ws   world space, metres; any numbers, as for vxs_voxel
 * normal_ws  NULL, or as for vxs_voxel
 * filter     vxs_box(K) or vxs_smooth(K), K from 1 to VXS_FILTER_MAX texels (vxs_file.h)
 * Returns [0, 1], never NaN, or VXS_OUTSIDE when the point is outside the light's volume (vxs_voxel). Texels outside the map are
 * lit. Maps of spot and point lights have a border, so that no filter leaves a map of 256 texels or more.
 * Cost: one walk of at most `levels` nodes for each tile of 8 x 8 texels that the filter touches. Threads: any. */
float vxs_lookup(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], vxs_filter filter);

/* Returns 1 when the result of vxs_lookup is exact; 0 when a page that it needs is missing (vxs_stream.h), so that all taps are
 * coarse. Always 1 for an asset, which has all pages, and for a point outside the light's volume. Arguments and threads as for
 * vxs_lookup. */
int vxs_lookup_is_full(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], vxs_filter filter);

/* vxs_lookup for many points.
 * points_ws  [3 * count];   normals_ws  [3 * count] or NULL;   lit  [out] [count] */
void vxs_lookup_many(const vxs_baked_light *baked, const double *points_ws, const double *normals_ws, size_t count,
                     vxs_filter filter, float *lit);

/* Transmittance of the baked smoke between the light and a point: 0 to 1, never NaN. Multiply vxs_lookup by it. Smoke is baked
 * only as far as light reaches; behind that depth the value has no meaning. It is interpolated between the four texels around the
 * point.
 * light     from vxs_asset_light or vxs_stream_light
 * smoke     from vxs_asset_smoke or vxs_stream_smoke; NULL: no smoke, returns 1
 * point_ws  any numbers; returns 1 outside the light's volume (vxs_voxel), and beside the map of a directional light
 * Cost: four searches among 16 nodes at most. Threads: any. */
float vxs_smoke_lookup(const vxs_light *light, const vxs_baked_smoke *smoke, const double point_ws[3]);

/* Constants of a light for shaders: the struct of the same name in vxs_space.h. It has the same layout in a std140 uniform block,
 * a std430 buffer, a cbuffer and a StructuredBuffer, and in arrays of it. The fields are those of vxs_light, as float. */
typedef struct vxs_light_constants {
    float    ls_from_ws[12]; /* byte  0: three rows of four; from metres relative to origin_ws */
    float    texel_metres;   /* byte 48 */
    float    voxel_metres;   /* byte 52 */
    float    near_metres;    /* byte 56 */
    float    range_metres;   /* byte 60 */
    float    cos_outer;      /* byte 64 */
    uint32_t kind;           /* byte 68: VXS_LIGHT_KIND_* */
    uint32_t flags;          /* byte 72: VXS_LIGHT_BOUNDED, VXS_LIGHT_CUBE */
    uint32_t levels;         /* byte 76 */
    uint32_t first_word;     /* byte 80: where the light's words start in the array of all words */
    uint32_t coding;         /* byte 84: VXS_CODING_* */
    uint32_t
        origin_fraction_ij; /* byte 88: directional light: rounding error of the last column, 2^-20 texels, signed: u | v << 16 */
    uint32_t origin_fraction_k; /* byte 92: the same for depth; both 0: not known */
} vxs_light_constants;          /* 96 bytes */

/* Constants of a light for positions relative to an origin.
 * origin_ws   metres; NULL: (0, 0, 0). A float has 24 bits: far from the world's origin, only positions relative to a nearby
 *             point, such as the camera, are finer than texels. The matrix is moved in double and then rounded
 * first_word  index of the light's first word in the array of all words */
vxs_light_constants vxs_light_constants_of(const vxs_light *light, const double origin_ws[3], uint32_t first_word);

/* Returns the VXS_VERSION_NUMBER of the library. For a shared library it may differ from that of the headers. A program runs with
 * every library of the same major version that is not older than its headers: structs that callers fill start with struct_size
 * and grow at their end; structs that the library fills, and those of shaders, keep their layout (tests/unit/test_abi.c). */
uint32_t vxs_version(void);

/* Text of a result, such as "out of memory"; never NULL. */
const char *vxs_result_text(vxs_result result);

#ifdef __cplusplus
}
#endif
#endif
