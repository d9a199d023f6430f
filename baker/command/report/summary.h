/* A bake or its plan in about five lines: scene and lights, the file's size, the time, what is left out.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SUMMARY_H
#define SUMMARY_H

#include <stdio.h>

#include "baker/bake/bake_report.h"

void bake_summary_print(FILE *to, const bake_options *o, const bake_report *r);
void plan_summary_print(FILE *to, const bake_options *o, const bake_report *r);

/* Print, with --resume, how many squares were made and how many were in the cache: a line. */
void squares_print(FILE *to, const bake_options *o, const bake_report *r);

#endif
