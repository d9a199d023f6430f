/* From a scene to a .vxs file: the list of stages, and what they report.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_H
#define BAKE_H

#include "baker/bake/light_picture.h"
#include "baker/bake/plan.h"
#include "baker/dag/build.h"
#include "baker/measure/context.h"

/* A section of a light in the file: a level, or its masks. */
typedef struct level_report {
    uint32_t side_voxels; /* 16.. octree nodes, 8 slice nodes, 0 masks */
    uint32_t count;
    uint64_t memory_bytes, stored_bytes;
} level_report;

typedef struct light_report {
    vxs_light    light;
    depth_stats  depth;
    uint64_t     tiles, tiles_skipped;           /* map tiles of TILE_MAX_PX at most; without casters */
    uint64_t     mask_tiles, mask_runs;          /* 8 x 8 tiles that need masks; masks before merging */
    uint64_t     inserted_nodes, inserted_masks; /* before compression */
    uint64_t     memory_bytes, stored_bytes;
    level_report level[VXS_LEVELS_MAX]; /* the root first, masks last */
    uint32_t     level_count;
    double       depth_zstd19_ratio; /* zstd -19 over raw, of the 16-bit depth map; 0: not measured */
    double       depth_sample_share; /* of its texels that this was measured on */
} light_report;

/* A light of the scene that was not baked. */
typedef struct light_left_out {
    char        name[VXS_LIGHT_NAME_BYTES];
    const char *why;
} light_left_out;

typedef struct bake_report {
    stage_report    stage[STAGE_COUNT];
    double          total_seconds;                     /* from start to the file under its name */
    double          baseline_seconds, picture_seconds; /* no part of the total */
    uint64_t        peak_bytes;
    char            renderer[128];
    uint64_t        file_bytes;
    casters         casters; /* counts only: no arrays */
    double          casters_min_ws[3], casters_max_ws[3];
    light_report   *lights;
    uint32_t        light_count;
    light_left_out *left_out;
    size_t          left_out_count;

    bake_plan *plan; /* owned */

    light_picture pictures[PICTURES_MAX]; /* of the largest lights, when asked for: owned */
    uint32_t      picture_count;
} bake_report;

/* Bake a scene. The output is complete under its name, or untouched.
 * report  [out] zero it first; released with bake_report_free, whatever is returned.
 * Same scene and options, same bytes, at any thread count. */
vxs_result bake(const bake_options *o, bake_report *report, message *m);

/* Only what would be done: fills what is known before the work, the plan above all. */
vxs_result bake_plan_only(const bake_options *o, bake_report *report, message *m);

void bake_report_free(bake_report *r);

#endif
