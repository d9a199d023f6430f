/* The report of a bake: a table for people, and the same as JSON (docs/bake-report.schema.json).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPORT_H
#define REPORT_H

#include <jansson.h>
#include <stdio.h>

#include "baker/bake.h"

void report_print(FILE *to, const bake_options *o, const bake_report *r);

/* path "-" is standard output. Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result report_write_json(const char *path, const bake_options *o, const bake_report *r, message *m);

/* Write any JSON value as an output file, indented, with a newline at its end; the value is released. NULL is VXS_E_MEMORY. */
vxs_result json_write(const char *path, json_t *value, message *m);

/* A text as JSON; what is not UTF-8, as a file's name may be, gets '?' for each byte beyond ASCII. NULL without memory. */
json_t *json_text(const char *text);

/* "12.3 MiB" into text. Returns text. */
const char *size_text(char text[32], uint64_t bytes);

#endif
