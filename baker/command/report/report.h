/* The report of a bake: a table for people, and the same as JSON (docs/bake-report.schema.json).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPORT_H
#define REPORT_H

#include <stdio.h>

#include "baker/bake/bake.h"
#include "baker/bake/bake_report.h"

void report_print(FILE *to, const bake_options *o, const bake_report *r);

/* The report as JSON; m holds the warnings. Incomplete or NULL when out of memory: json_print and json_write detect it. */
json_t *report_json(const bake_options *o, const bake_report *r, const run_context *m);

/* path "-" is standard output. Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result report_write_json(const char *path, const bake_options *o, const bake_report *r, run_context *m);

/* The name of a part: "64^3", the size, for nodes; else its kind. Into text. Returns text. */
const char *part_name(char text[32], const vxs_part *part);

/* The report of a bake of one part: --part. */

/* A few lines. */
void part_print(FILE *to, const bake_options *o, const bake_report *r);

/* Replaces the report; it contains "part". */
vxs_result part_write_json(const char *path, const bake_options *o, const bake_report *r, run_context *m);

/* The report of a bake that was up to date: --if-changed. */

/* One line. */
void unchanged_print(FILE *to, const bake_options *o, const bake_report *r);

/* Replaces the report or the plan; "unchanged" is true in it. */
vxs_result unchanged_write_json(const char *path, const bake_options *o, const bake_report *r, run_context *m);

/* A bake or its plan in about five lines: scene and lights, the file's size, the time, and lights that are left out. The output
 * path may be NULL. */

void bake_summary_print(FILE *to, const bake_options *o, const bake_report *r);
void plan_summary_print(FILE *to, const bake_options *o, const bake_report *r);

/* Print, with --resume, how many squares were made and how many were in the cache: a line. */
void squares_print(FILE *to, const bake_options *o, const bake_report *r);

#endif
