/* Rivals: ways to keep the shadow of a light for lookups, all made from the same depth maps and all queried the same.
 *
 * A rival turns maps into the bytes of a file, the file into what lookups read, and answers for voxels: the contract of an asset
 * (docs/overview.md) names the fault, so that one check serves all of them. What one takes on disk is the size of a file that
 * was read back. Everything runs on one thread, and times are processor time, so that they can be compared; or DAGs and palette
 * blocks are made and opened on several, and those times are the clock's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_H
#define RIVAL_H

#include "baker/bake/bake.h"
#include "baker/bake/plan.h"
#include "baker/lab/opengl/depth_maps.h"
#include "baker/lab/truth/truth.h"
#include "formats/vxs_format.h"
#include "formats/vxs_write_file.h"

enum { RIVAL_ZSTD_LEVEL = 12 }; /* of DAGs in files: what vxs bake does by default */

/* What sets some rivals apart. */
enum {
    RIVAL_RAYS   = 1, /* traces rays, and is queried fewer points; may differ from the maps where a ray grazes a triangle */
    RIVAL_SMOOTH = 2, /* has smooth filters */
};

/* The maps of one directional light, and what they were made from. */
typedef struct rival_maps {
    depth_maps maps;    /* enter and exit; the pyramid belongs to the rivals that need it, and is theirs to fill */
    float     *checked; /* the enter and exit depths that answers are checked with: those of maps, unless a fault was planted */
    float     *checked_exit;
    vxs_light  light;   /* as fitted */
    uint32_t   threads; /* for those that can use them */
    uint32_t   levels;  /* the map has 1 << levels texels a side, and as many voxels in depth */
    scene      scene;
    casters    casters;
    bake_plan  plan;
    char       renderer[128]; /* what OpenGL calls itself */
    double     seconds;       /* to render them, on all threads */
} rival_maps;

/* Make the maps of the first directional light that `o` asks for, as a bake does.
 * out  [out] released with rival_maps_free, whatever is returned */
vxs_result rival_maps_render(rival_maps *out, const bake_options *o, run_context *m);

/* A texel of the maps that rivals see loses its caster; what answers are checked with keeps it. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result rival_maps_spoil(rival_maps *maps, run_context *m);

/* Accepts a zeroed object. */
void rival_maps_free(rival_maps *maps);

/* Whether voxel k of texel (i, j) must be lit, or must be in shadow; both 0: it is free. By the depths as they were sampled: no
 * rounding, pyramid, mask or node takes part. */
void rival_maps_contract(const rival_maps *maps, uint32_t i, uint32_t j, uint32_t k, int *must_be_lit, int *must_be_dark);

enum { FILTER_PX = 9 };

/* What rivals are queried: single taps, boxes, smooth boxes. */
typedef enum lookup_kind { LOOKUP_TAP, LOOKUP_BOX, LOOKUP_SMOOTH, LOOKUP_KINDS } lookup_kind;

static const vxs_filter lookup_filters[LOOKUP_KINDS] = {{1, 0}, {FILTER_PX, 0}, {FILTER_PX, 1}};

/* A voxel: each of i, j, k in [0, 1 << levels). */
typedef struct voxel_at {
    int32_t  i, j, k;
    uint32_t within; /* where in its texel a smooth filter is: across | down << 8, each as vxs_place has it */
} voxel_at;

/* Ready for lookups. */
typedef struct rival_asset {
    void    *state;
    uint64_t memory_bytes; /* that lookups may read; 0: not known */
} rival_asset;

typedef struct rival {
    const char *name; /* unique; NULL ends an array of rivals */
    const char *what; /* one line for people */
    const void *options;
    uint32_t    traits; /* RIVAL_ */

    /* Encode the maps as a file. NULL: there is none.
     * file  [out] zero it first; released with free(file->data).   Returns VXS_OK or VXS_E_MEMORY. */
    vxs_result (*build)(rival_maps *maps, const void *options, vxs_bytes *file);

    /* Make a file (or the maps, when there is none) ready for lookups; both are borrowed until close.
     * asset  [out] ends with close.   Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
    vxs_result (*open)(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset);

    /* How many of the K x K taps of vxs_box(K), K odd, about each of `count` voxels are in shadow; of rivals with smooth filters
     * also vxs_smooth(K): how much of a smooth box, of 65536 K K. Taps outside the map are lit. */
    void (*count_dark)(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark);

    void (*close)(void *state);
} rival;

/* rival.count_dark of an open vxs_asset, as vxs_lookup_batch queries it: what one lookup needed is kept for the next. */
void asset_count_dark_batch(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark);

/* All of them. block_rivals[0] is vxs as it is, which the others are held against; dag_rivals[0] is vxs bake --coding dag. */
extern const rival dag_rivals[], block_rivals[], interval_rivals[], depth_rivals[], shader_rivals[], ray_rivals[];

/* The box of a filter's taps, cut to the map: [x0, x1) x [y0, y1). */
typedef struct tap_box {
    int32_t x0, x1, y0, y1;
} tap_box;

static inline tap_box tap_box_at(voxel_at at, int32_t width_px, int32_t side)
{
    int32_t half = width_px / 2;
    return (tap_box){at.i < half ? 0 : at.i - half, at.i + half >= side ? side : at.i + half + 1, at.j < half ? 0 : at.j - half,
                     at.j + half >= side ? side : at.j + half + 1};
}

#endif
