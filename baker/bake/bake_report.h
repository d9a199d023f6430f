/* What a bake reports: its plan, and what came of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_REPORT_H
#define BAKE_REPORT_H

#include "baker/bake/light_picture.h"
#include "baker/bake/plan.h"
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
    casters         casters;                              /* counts only: no arrays */
    double          casters_min_ws[3], casters_max_ws[3]; /* metres */
    light_report   *lights;
    uint32_t        light_count;
    light_left_out *left_out;
    size_t          left_out_count;

    bake_plan *plan; /* owned */

    light_picture pictures[PICTURES_MAX]; /* of the largest lights, when asked for: owned */
    uint32_t      picture_count;
} bake_report;

/* What is known before the work: counts of casters, and which lights of the scene are left out. Lights that reach nothing are a warning.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bake_report_begin(bake_report *report, const scene *s, const casters *c, message *m);

/* Accepts a zeroed object. */
void bake_report_free(bake_report *r);

#endif
