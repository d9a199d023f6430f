/* A program without the laboratory; see laboratory.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/laboratory.h"

static const command_entry none[] = {{NULL, NULL}};

const laboratory linked_laboratory = {.commands = none};
