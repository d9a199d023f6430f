/* The report of vxs compare, as text and as JSON (docs/compare.schema.json).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_REPORT_H
#define COMPARE_REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "baker/casters/casters.h"
#include "baker/lab/compare/compare.h"
#include "runtime/vxs.h"

typedef struct compared_asset {
    const char *path;
    vxs_asset  *asset;
    json_t     *made;                                 /* its metadata; owned; NULL: not written by vxs */
    closed_mode closed;                               /* which components are solids: as in the bake, or as the command line sets
                                                         it */
    size_t      triangle_count, solid_triangle_count; /* of the scene, so made */
    uint64_t    file_bytes, memory_bytes;             /* size of the file; size of the words of all lights in memory */

    int      bake_given; /* 1: the next two come from the report of its bake */
    double   bake_seconds;
    uint64_t bake_peak_bytes;

    json_t *scene_differences;      /* differences from the scene that it was baked from: an array of words, owned; NULL: not yet
                                       known */
    const vxs_baked_light **lights; /* [light_count] to compare; the array is owned, the lights belong to the asset */
    uint32_t                light_count;
    compare_result         *results; /* [light_count] owned; NULL: not yet compared */
} compared_asset;

typedef struct compare_report {
    const char     *scene_path;
    compare_options options;
    double          max_error; /* accepted share of wrong points */
    int             max_error_given;
    compared_asset *assets; /* [asset_count] */
    size_t          asset_count;
} compare_report;

/* 1 when the asset passes: no answer is unexplained, the bias has no fault, and not more points are wrong than accepted.
 * compare_passes: all assets pass. */
int compare_passes(const compare_report *r);

/* Print a line or a few for each asset; everything if m is verbose. */
void compare_print(FILE *to, const compare_report *r, const run_context *m);

/* NULL or incomplete when out of memory; json_write reports it. */
json_t *compare_json(const compare_report *r);

#endif
