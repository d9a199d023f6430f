/* A plan as text and as JSON (docs/plan.schema.json). The report of a bake repeats the plan, with the results.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PLAN_TEXT_H
#define PLAN_TEXT_H

#include <jansson.h>
#include <stdio.h>

#include "baker/bake/bake_report.h"

void plan_print_decisions(FILE *to, const bake_plan *plan, const bake_options *o, const bake_report *report);

/* Print a line: expected time, memory and size. */
void plan_print_estimate(FILE *to, const bake_plan *plan);

/* Print a line for each option that was not given and would save something.   file_bytes  size without it: planned or baked */
void plan_print_savings(FILE *to, const bake_plan *plan, uint64_t file_bytes);

/* The whole of vxs plan. */
void plan_print(FILE *to, const bake_options *o, const bake_report *report);

/* path "-" is standard output. Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result plan_write_json(const char *path, const bake_options *o, const bake_report *report, run_context *m);

/* "0.206 m", for a punctual light "0.002 to 0.03 m at casters, median 0.01 m", into text. Returns text. */
enum { TEXELS_BYTES = 96 };
const char *texels_text(char text[TEXELS_BYTES], const texel_range *t, int digits);
json_t     *texels_json(const texel_range *t);

/* Parts of the plan for the report of the bake: casters, warnings, decisions. */
void    report_print_casters(FILE *to, const bake_report *r);
void    report_print_excluded(FILE *to, const bake_report *r, const char *head); /* a line a rule, head first */
json_t *report_casters_json(const bake_report *r);
json_t *report_warnings_json(const run_context *m);
json_t *plan_decisions_json(const bake_plan *plan, const bake_options *o, const bake_report *report);
json_t *plan_estimate_json(const bake_plan *plan);
json_t *plan_lights_json(const bake_plan *plan);
json_t *plan_savings_json(const bake_plan *plan);

#endif
