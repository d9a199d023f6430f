/* Parts of plans and of reports: what casts shadows, which lights are left out, what was warned of.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPORT_PARTS_H
#define REPORT_PARTS_H

#include <stdio.h>

#include "baker/bake/bake.h"

void report_print_casters(FILE *to, const bake_report *r);

/* As docs/bake-report.schema.json has them. */
json_t *report_casters_json(const bake_report *r);
json_t *report_left_out_json(const bake_report *r);
json_t *report_warnings_json(const message *m);

#endif
