/* The report of a bake that was up to date: --if-changed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef UNCHANGED_H
#define UNCHANGED_H

#include <stdio.h>

#include "baker/bake/bake.h"

/* One line. */
void unchanged_print(FILE *to, const bake_options *o, const bake_report *r);

/* Replaces the report or the plan; "unchanged" is true in it. */
vxs_result unchanged_write_json(const char *path, const bake_options *o, const bake_report *r, message *m);

#endif
