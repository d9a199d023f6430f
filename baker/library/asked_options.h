/* Converts the public options, after checks, into the options of a bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASKED_OPTIONS_H
#define ASKED_OPTIONS_H

#include "baker/bake/bake_options.h"
#include "baker/vxs_bake.h"

typedef struct asked_options {
    vxs_bake_options asked; /* copy, up to the size that this library knows */
    bake_options     o;     /* borrows from `asked`; lists are owned */
} asked_options;

/* Check options. Options of lights and output are checked only if lights is 1.
 * a  [out] released with asked_options_free, whatever is returned
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_MEMORY. */
vxs_result asked_options_init(asked_options *a, const vxs_bake_options *options, int lights, run_context *m);

void asked_options_free(asked_options *a);

#endif
