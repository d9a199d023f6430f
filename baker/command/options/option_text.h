/* Texts that help, manual pages and completion have in common.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPTION_TEXT_H
#define OPTION_TEXT_H

#include "baker/command/options/option_table.h"

/* The value that follows an option's name in help: "N", "auto|on|off"; NULL for switches and operands. */
const char *option_value(const option *o);

/* "--resolution N", "--camera", "SCENE" into text. Returns text. */
const char *option_usage(char text[96], const option *o);

/* "bake the shadows of a scene": the first sentence of a summary without its period, in lower case, into text. Returns text. */
const char *summary_phrase(char text[128], const char *summary);

#endif
