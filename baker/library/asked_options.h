/* What a program asks for, checked, as a bake takes it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASKED_OPTIONS_H
#define ASKED_OPTIONS_H

#include "baker/bake/bake_options.h"
#include "baker/vxs_bake.h"

typedef struct asked_options {
    vxs_bake_options asked; /* as long as this library knows them */
    bake_options     o;     /* borrows from those; lists are owned */
} asked_options;

/* Check options, those of lights and output only where lights are asked for.
 * a  [out] released with asked_options_free, whatever is returned
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_MEMORY. */
vxs_result asked_options_init(asked_options *a, const vxs_bake_options *options, int lights, message *m);

void asked_options_free(asked_options *a);

#endif
