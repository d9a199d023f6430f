/* Merges the parts of a bake into an asset: vxs merge. A part is a column source whose squares are all known; they are added in the
 * same way as in a bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MERGE_PARTS_H
#define MERGE_PARTS_H

#include "baker/bake/bake_report.h"

typedef struct merge_options {
    text_list        paths; /* of the parts, in any order */
    const char      *output_path;
    uint32_t         threads;
    const run_watch *watch; /* gets the progress; NULL: not wanted */
} merge_options;

typedef struct merge_report {
    bake_report lights; /* contents of the file, its size, and the time of the merge; other fields are not known */
    uint32_t    parts;
    uint64_t    squares;
} merge_report;

/* Merge all parts of a bake.
 * report  [out] zero it first; released with merge_report_free, whatever is returned
 * Returns VXS_OK; VXS_E_ARGUMENT: a part is missing, or given twice; what part_open returns; VXS_E_CORRUPT also for parts of
 * different bakes; VXS_E_WRITE, VXS_E_MEMORY, VXS_E_REFERENCES. */
vxs_result merge_parts(const merge_options *o, merge_report *report, run_context *m);

void merge_report_free(merge_report *r);

#endif
