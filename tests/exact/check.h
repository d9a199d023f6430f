/* A map of a light in several files against depths that are found anew: rendered, or by brute force where files come straight from
 * triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXACT_CHECK_H
#define EXACT_CHECK_H

#include <stdint.h>

#include "baker/lab/opengl/depth_gl.h"

typedef struct tally {
    uint64_t columns, voxels, wrong_lit, wrong_shadow;
    uint64_t lookups; /* through the runtime; the other voxels are reported by what a file says of whole tiles (coded_runs.h) */
    uint64_t misread; /* runs of voxels that a lookup does not find as they are stored */
    uint64_t insane;  /* texels whose depths cannot be */
    uint64_t maps;
} tally;

/* The light in one file, and what was found of it. */
typedef struct checked_file {
    const uint32_t  *words;
    const vxs_light *light; /* as in the others, but for its coding */
    tally            sum;   /* added to */
} checked_file;

typedef struct check_desc {
    gl_context      *gl;
    const casters   *casters;
    const vxs_light *light; /* as all files have it, but for the words */
    exit_mode        exit;
    int              behind;    /* 1: free behind the last surface: brute alone, as the next */
    double           thickness; /* of sheets that face the light, metres */
    int              brute;     /* 1: by brute force (tests/columns/brute.h), else rendered */
    uint32_t         threads;
    uint64_t         columns;     /* random ones of each map; 0: all voxels */
    uint32_t         silhouettes; /* with columns and brute force: all tiles around so many random ones, too */
    uint64_t         seed;        /* of the columns */
    checked_file    *files;
    uint32_t         file_count;
} check_desc;

/* Compare map `map` of all the files. Returns VXS_OK whatever is wrong, VXS_E_GL, VXS_E_MEMORY. */
vxs_result check_map(const check_desc *d, int map, run_context *m);

#endif
