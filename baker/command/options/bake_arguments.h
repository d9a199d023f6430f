/* The command line of bake and plan: one table of options, and the checks of their combinations.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_ARGUMENTS_H
#define BAKE_ARGUMENTS_H

#include "baker/bake/bake.h"
#include "baker/command/options/options.h"

typedef struct bake_arguments {
    bake_options o;
    const char  *json_path; /* NULL: none */
    const char  *part;      /* "I/N"; NULL: all */

    int watch; /* 1: --watch */

    int pack_given;
    int smoke_given;    /* 1: an option of smoke was given, except --smoke */
    int dag_step_given; /* 1: --rule, --reuse, --compress or --stop was given */

    option       options[OPTIONS_MAX]; /* the table; its targets are in this struct, so the struct must not be copied */
    command_line line;
} bake_arguments;

/* Set defaults, and make the table. name: "bake" or "plan"; output_needed: -o must be given. */
void bake_arguments_init(bake_arguments *a, const char *name, const char *synopsis, const char *summary, int output_needed);

/* Checks that the table cannot express; call after parsing. Returns VXS_OK, VXS_E_ARGUMENT, or what bake_check_outputs returns. */
vxs_result bake_arguments_check(bake_arguments *a, run_context *m);

#endif
