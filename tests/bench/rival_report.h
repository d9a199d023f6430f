/* What was measured, for people and as JSON (docs/rivals.schema.json); see rivals.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_REPORT_H
#define RIVAL_REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "tests/bench/rival_measure.h"

typedef struct rival_report {
    const char            *scene_path;
    const rival_maps      *maps;
    const measure_options *options;
    const rival_result    *results; /* [count] vxs first */
    size_t                 count;
} rival_report;

/* Tables in Markdown, with units, and where vxs is beaten. Returns 0 without memory. */
int rival_report_print(FILE *to, const rival_report *report);

/* NULL without memory. */
json_t *rival_report_json(const rival_report *report);

#endif
