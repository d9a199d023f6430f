/* libvxs: lookups in baked shadows. The one header that a game includes.
 *
 *     vxs_asset *asset;
 *     if (vxs_asset_open_file(&asset, "level.vxs", NULL) != VXS_OK) ...
 *     const vxs_baked_light *sun = vxs_asset_light(asset, 0);
 *     float lit = vxs_lookup(sun, position_ws, normal_ws, 9);      // 9 x 9 PCF: 0 dark .. 1 lit, VXS_OUTSIDE
 *     float lit = vxs_lookup(sun, position_ws, normal_ws, VXS_SMOOTH + 9);         // the same without steps of a texel
 *     vxs_asset_close(asset);
 *
 * The library allocates in open only, never prints, never exits, and keeps no global state. An open asset is read-only: any
 * number of threads may look it up at once. Levels that are larger than their memory are opened by vxs_stream.h. For lookups on a GPU
 * upload a light's words and vxs_light_constants_of, and hand the shader the texts of vxs_lookup.h, vxs_lookup_blocks.h and vxs_space.h (docs/runtime.md).
 * SPDX-License-Identifier: MIT */
#ifndef VXS_H
#define VXS_H

#include "vxs_file.h"

#ifdef __cplusplus
extern "C" {
#endif

#define VXS_VERSION_MAJOR 0
#define VXS_VERSION_MINOR 1
#define VXS_VERSION_PATCH 0

#define VXS_VERSION_NUMBER (10000 * VXS_VERSION_MAJOR + 100 * VXS_VERSION_MINOR + VXS_VERSION_PATCH)

/* What a lookup returns for a point outside the light's volume. */
#define VXS_OUTSIDE (-1.0f)

typedef struct vxs_asset vxs_asset;

/* Check a whole file in memory and make it ready for lookups.
 * asset  [out] NULL on failure; closed with vxs_asset_close
 * bytes  [size_bytes] a .vxs file; only read, may be freed after the call
 * desc   allocator, memory limit, findings (vxs_file.h); NULL: all defaults
 * Returns VXS_OK; VXS_E_NOT_VXS, VXS_E_VERSION, VXS_E_TRUNCATED, VXS_E_CORRUPT for bad bytes, which never abort; VXS_E_MEMORY;
 * VXS_E_ARGUMENT for a struct_size that no version had, or no path. */
vxs_result vxs_asset_open(vxs_asset **asset, const void *bytes, size_t size_bytes, const vxs_read_desc *desc);

/* The same for a file, whose bytes count towards the memory limit while it is read; its header is looked at before anything is taken for the
 * rest. Also returns VXS_E_READ (no such file, a folder, a
 * pipe, an error while reading): errno says why. path is UTF-8. */
vxs_result vxs_asset_open_file(vxs_asset **asset, const char *path, const vxs_read_desc *desc);

/* Accepts NULL. */
void vxs_asset_close(vxs_asset *asset);

/* At least 1. */
uint32_t vxs_asset_light_count(const vxs_asset *asset);

/* Light `index` and its words, in file order; NULL when there are fewer. Valid until vxs_asset_close. */
const vxs_baked_light *vxs_asset_light(const vxs_asset *asset, uint32_t index);

/* The light of a name, or NULL; of no name, NULL. */
const vxs_baked_light *vxs_asset_find_light(const vxs_asset *asset, const char *name);

/* What baked smoke leaves of light `index`; NULL where it has none. Valid until vxs_asset_close. */
const vxs_baked_smoke *vxs_asset_smoke(const vxs_asset *asset, uint32_t index);

/* Points of the surfaces that cast shadow, for techniques that draw them; NULL where the file has none. Valid until vxs_asset_close. */
const vxs_baked_points *vxs_asset_points(const vxs_asset *asset);

/* The same as floats.
 * origin_ws  metres that they count from: something near, for a float has 24 bits; NULL: (0, 0, 0)
 * out        [4 * points->count] a place, and the square metres that it stands for: as vxs_area_point has them */
void vxs_points_unpack(const vxs_baked_points *points, const double origin_ws[3], float *out);

/* Everything that was read: sections, metadata. Valid until vxs_asset_close. */
const vxs_contents *vxs_asset_contents(const vxs_asset *asset);

/* The voxel of a point, [0] and [1] texels, [2] depth; may lie outside the map. Coordinates beyond +-2^30 are clamped to it, and NaN is
 * -2^30.
 * point_ws   world space, metres: any numbers. A point with NaN or infinity is outside; so is one from which the square of the distance to
 *            a spot or point light is no number, some 1e154 m
 * normal_ws  NULL, or the normal of the surface that the point lies on, of any length: the voxel is moved off the surface (the bias), as
 *            far as the filter, the size of a texel and the depth of a voxel need it, so that the surface does not shade itself: up to
 *            1.2 * (filter_px + 1) / 2 + 1 texels across the map, and 0.2 * filter_px texels and 2 voxels along the light. (0, 0, 0)
 *            and a normal with NaN do not move it. It may leave the map of a directional light, which is outside; in the maps of a spot
 *            or point light it is held
 * filter_px  the filter that the voxel is for, as for vxs_lookup
 * Returns the map that the voxel is in: 0, or 0 to 5 of a light with six maps (VXS_LIGHT_CUBE); -1 when the point is outside the
 * light's volume. The volume of a directional light is the prism over its map: in front of the map all is lit, and what is behind it is
 * in the shadow of the map's last voxel. A bounded one (baked for a region) ends at its near and far sides too. The volume of a spot
 * or point light is its cone and range. */
int vxs_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px, int32_t voxel[3]);

/* The other way: the point in world space of light-space coordinates: texels u, v and depth in voxels, none of them whole.
 * map  as vxs_voxel returns it; one that the light does not have stands for the nearest that it has */
void vxs_point(const vxs_light *light, int map, const double coordinates[3], double point_ws[3]);

/* The lit fraction of a filter in light space around a point.
 * baked      a light with its words, as vxs_asset_light gives it
 * point_ws   world space, metres; any numbers, as for vxs_voxel
 * normal_ws  NULL, or as for vxs_voxel
 * filter_px  K, odd, 1 (a single tap) to VXS_FILTER_MAX: the K x K texels about that of the point, a box PCF ([CPVS16] 5). The box goes
 *            by whole texels, and so do edges of shadows.
 *            VXS_SMOOTH + K, K even or odd, 1 to VXS_FILTER_MAX: a box of that width about the point itself, of whose border texels the part
 *            that it covers counts, in 1/256 along each axis. At most 1/(256 K) of its light comes or goes by a step.
 *            Any other number stands for one of these: less than 1 for 1, more than VXS_FILTER_MAX (of K with VXS_SMOOTH too) for that, and
 *            an even K without VXS_SMOOTH, whose box has no middle texel, for K + 1
 * Returns [0, 1], never NaN, or VXS_OUTSIDE when the point is outside the light's volume (vxs_voxel). Texels outside the map are lit: maps of
 * spot and point lights have a border, so that no filter leaves them where they are 256 texels or wider.
 * Cost: one walk of at most `levels` nodes for each tile of 8 x 8 texels that the filter touches. Threads: any. */
float vxs_lookup(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], int filter_px);

/* Whether that answer is exact: 1; 0 when pages that it needs are missing (vxs_stream.h), so that all of its taps are coarse. An asset
 * that was opened whole has all of them. Arguments and threads as above; outside the light's volume it is 1. */
int vxs_lookup_is_full(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], int filter_px);

/* vxs_lookup for many points.
 * points_ws  [3 * count];   normals_ws  [3 * count] or NULL;   lit  [out] [count] */
void vxs_lookup_many(const vxs_baked_light *baked, const double *points_ws, const double *normals_ws, size_t count, int filter_px,
                     float *lit);

/* How much light baked smoke leaves on its way to a point: 0 to 1, never NaN. What reaches a point is vxs_lookup times this: smoke is baked as far as light
 * comes, and behind that this means nothing. Four curves are asked, and what they say is weighed by where the point lies between texels.
 * light     that of vxs_asset_light or vxs_stream_light
 * smoke     that of vxs_asset_smoke or vxs_stream_smoke; NULL: none, and all light is left
 * point_ws  any numbers; all light is left outside the light's volume (vxs_voxel), and beside the maps of suns
 * Cost: four searches among 16 nodes at most. Threads: any. */
float vxs_smoke_lookup(const vxs_light *light, const vxs_baked_smoke *smoke, const double point_ws[3]);

/* What a shader has to know of a light: the struct of this name in vxs_space.h, laid out the same in a std140 uniform block, a std430
 * buffer, a cbuffer and a StructuredBuffer, and in arrays of it. The fields are those of vxs_light, in float. */
typedef struct vxs_light_constants {
    float    ls_from_ws[12]; /* byte  0: three rows of four; from metres about an origin */
    float    texel_metres;   /* byte 48 */
    float    voxel_metres;   /* byte 52 */
    float    near_metres;    /* byte 56 */
    float    range_metres;   /* byte 60 */
    float    cos_outer;      /* byte 64 */
    uint32_t kind;           /* byte 68: VXS_LIGHT_KIND_* */
    uint32_t flags;          /* byte 72: VXS_LIGHT_BOUNDED, VXS_LIGHT_CUBE */
    uint32_t levels;         /* byte 76 */
    uint32_t first_word;     /* byte 80: where the light's words start among those of all lights */
    uint32_t coding;         /* byte 84: VXS_CODING_* */
    uint32_t
        origin_fraction_ij; /* byte 88: of a sun, what rounding took from the last column, in 2^-20 texels, signed: across | down << 16 */
    uint32_t origin_fraction_k; /* byte 92: and along the light; both 0: it is not known */
} vxs_light_constants;          /* 96 bytes */

/* The constants of a light, for positions that count from an origin.
 * origin_ws   metres; NULL: (0, 0, 0). A float has 24 bits, so that far from the world's origin only positions relative to something near,
 *             the camera say, are finer than texels. The matrix is moved there in double, and then rounded
 * first_word  where the light's words were put */
vxs_light_constants vxs_light_constants_of(const vxs_light *light, const double origin_ws[3], uint32_t first_word);

/* The VXS_VERSION_NUMBER that the library was built as, which a shared one's headers need not have. Programs keep running with every library of their
 * headers' major version that is not older: structs that callers fill grow at their end, and begin with struct_size; those that the library fills,
 * and those of shaders, keep their layout (tests/unit/test_abi.c). */
uint32_t vxs_version(void);

/* "out of memory" and the like; never NULL. */
const char *vxs_result_text(vxs_result result);

#ifdef __cplusplus
}
#endif
#endif
