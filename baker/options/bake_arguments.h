/* The command line of bake and plan: one table of options, and what they must not be together.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_ARGUMENTS_H
#define BAKE_ARGUMENTS_H

#include "baker/bake/bake.h"
#include "baker/options/options.h"

typedef struct bake_arguments {
    bake_options o;
    const char  *json_path; /* NULL: none */
    const char  *page_path; /* --report; NULL: none */
    int          help_shown;

    int resolution_given, texel_given;
    int maps; /* the choice of --maps, both of which are gl so far */
} bake_arguments;

/* Parse and check. name: "bake" or "plan"; output_needed: -o must be given.
 * a  [out] released with bake_arguments_free, whatever is returned. */
vxs_result bake_arguments_parse(bake_arguments *a, const char *name, const char *synopsis, const char *summary, int output_needed,
                                int argc, char **argv, message *m);

void bake_arguments_free(bake_arguments *a);

#endif
