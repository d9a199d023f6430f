/* What rivals take and how often they are wrong; see rival.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_MEASURE_H
#define RIVAL_MEASURE_H

#include "baker/base/spread.h"
#include "baker/lab/command/camera_choice.h"
#include "tests/bench/rival.h"

/* Where lookups are requested: anywhere in the map's volume, where most walks end early; within a voxel of where vxs turns from
 * lit to shadowed, where its walks are as long as they get; and where a picture's pixels see surfaces, next to one another. */
typedef enum point_set { POINTS_VOLUME, POINTS_EDGE, POINTS_SCREEN, POINT_SETS } point_set;

typedef struct measure_options {
    uint32_t      runs;
    uint32_t      points;              /* anywhere, and at edges; the same for all rivals, as all points are */
    uint32_t      width_px, height_px; /* of the picture */
    camera_choice camera;              /* placed */
    uint64_t      voxels;              /* to compare with the contract; 0: every voxel of the map */
    uint32_t      seed;
    int           filter_aside; /* a planted fault: filters are queried a texel beside those that they are checked with */
} measure_options;

typedef struct rival_result {
    const rival *rival;
    uint64_t     memory_bytes, file_bytes; /* 0: not known; no file */
    spread       build_s, open_s;
    size_t       points[LOOKUP_KINDS][POINT_SETS]; /* queried in one run; 0 for rivals without such a filter */
    spread       lookup_ns[LOOKUP_KINDS][POINT_SETS];

    uint64_t voxels, wrong_lit, wrong_dark; /* single taps, against the contract; free voxels count as queried */
    uint64_t filters[LOOKUP_KINDS], wrong_filters[LOOKUP_KINDS]; /* filtered lookups, against the rival's own single taps */
} rival_result;

/* Build, open, query, check: all of them, in turns.
 * results  [count] [out] each with its rival on entry, and all else zero; the first one says where edges are
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_ARGUMENT (the picture sees nothing), or what a rival's open said. */
vxs_result rivals_measure(rival_result *results, size_t count, rival_maps *maps, const measure_options *o, run_context *m);

#endif
