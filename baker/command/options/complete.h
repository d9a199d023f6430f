/* Completion of command lines by shells.
 *
 * A script is a head, a part for each command, and a tail: the functions that read the parts, from the files completion.*.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPLETE_H
#define COMPLETE_H

#include "baker/command/options/option_table.h"

typedef enum shell { SHELL_BASH, SHELL_ZSH, SHELL_FISH } shell;

/* All print to standard output. */
void complete_head(shell s);
void complete_part(shell s, const command_line *c);
void complete_tail(shell s);

#endif
