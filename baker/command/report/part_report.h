/* The report of a bake of one part: --part.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PART_REPORT_H
#define PART_REPORT_H

#include <stdio.h>

#include "baker/bake/bake.h"

/* A few lines. */
void part_print(FILE *to, const bake_options *o, const bake_report *r);

/* Replaces the report; it contains "part". */
vxs_result part_write_json(const char *path, const bake_options *o, const bake_report *r, message *m);

#endif
